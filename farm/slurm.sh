#!/bin/sh
# A task of a Slurm array: one line of a list of commands, which celfx prints. The same script serves every shot:
#
#   celfx frames my.toml --chunk 10 --cache cache > jobs.txt
#   sbatch --array=1-$(wc -l < jobs.txt) farm/slurm.sh jobs.txt
#
# Tasks run in the folder of submission, which all nodes must see, and end with celfx's exit code (celfx --help lists them).
# They may be cancelled, requeued and run twice: celfx keeps finished frames and claims those that it renders. So what failed
# is run again by submitting the same list again. Arrays have at most 1000 tasks unless the cluster says otherwise
# (MaxArraySize): make the chunks larger, not the list.
#
#SBATCH --job-name=celfx
# JOB_TASK.log; a task that is requeued goes on in the same file.
#SBATCH --output=celfx-%A_%a.log
#SBATCH --open-mode=append
# After the loss of a node, or when another job takes its place, a task is queued again.
#SBATCH --requeue
# Cores of a task: for lavapipe, and for writing pictures.
##SBATCH --cpus-per-task=4
# One GPU a task. Slurm must hide the others (ConstrainDevices), for celfx takes the first that it sees.
##SBATCH --gres=gpu:1
set -eu

# shellcheck disable=SC2016
usage='sbatch --array=1-$(wc -l < jobs.txt) farm/slurm.sh jobs.txt'
fail() { echo "slurm.sh: $1" >&2; exit 2; }

list=${1-}
line=${SLURM_ARRAY_TASK_ID-}
[ -n "$list" ] || fail "no list of commands; expected: $usage"
[ -n "$line" ] || fail "not a task of an array; expected: $usage"
[ -r "$list" ] || fail "$list cannot be read in $PWD"
command=$(sed -n "${line}p" "$list")
[ -n "$command" ] || fail "$list has no line $line; expected: $usage"
printf '%s\n' "$command"
# The words of a line are quoted for a shell. In its place celfx gets the signals that end the task.
exec sh -c "$command"
