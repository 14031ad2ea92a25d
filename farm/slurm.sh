#!/bin/sh
#SBATCH --job-name=celfx
#SBATCH --output=celfx-%A_%a.log
#SBATCH --requeue
# One GPU a task, where there are some; celfx takes the first that it sees:
##SBATCH --gres=gpu:1
#
# A task of the array runs one line of a list of commands, which celfx prints:
#
#   celfx frames my.toml --chunk 10 --cache cache > jobs.txt
#   sbatch --array=1-$(wc -l < jobs.txt) farm/slurm.sh jobs.txt
#
# Tasks may be ended, requeued and run twice: celfx claims frames and keeps those that are finished. The task ends as celfx does
# (celfx --help lists its exit codes), in the folder from which it was submitted.
set -eu

list=${1:?"expected the list of commands: sbatch --array=1-N farm/slurm.sh jobs.txt"}
line=${SLURM_ARRAY_TASK_ID:?"not in an array: sbatch --array=1-N farm/slurm.sh jobs.txt"}
command=$(sed -n "${line}p" "$list")
if [ -z "$command" ]; then
    echo "$list has no line $line" >&2
    exit 2
fi
printf '%s\n' "$command"
# celfx has quoted its words for a shell, and gets the signals that end the task.
eval "exec $command"
