#!/bin/sh
# tests/farm.sh CELFX: the files in farm/ run for real on this machine, by a Slurm controller with one node and by the Open Job
# Description CLI. Frames that many tasks have rendered must be those of one run, bit for bit. What is not installed is
# installed, or skipped with a line where that may not be done. All else is in a folder that is removed at the end.
set -eu

celfx=$(realpath "$1")
farm=$(cd "$(dirname "$0")/../farm" && pwd)
folder=$(mktemp -d)
policy=
if [ "$(id -u)" = 0 ]; then root=; else root='sudo -n'; fi

# The processes that run in the folder: the daemons, and tasks that are left when these have ended.
ours() {
    for process in /proc/[0-9]*; do
        case $(readlink "$process/cwd" 2>/dev/null) in
            "$folder" | "$folder"/*) echo "${process#/proc/}" ;;
        esac
    done
}

# end SIGNAL: waits for at most 10 s until our processes have ended.
end() {
    for _ in $(seq 50); do
        left=$(ours)
        [ -n "$left" ] || return 0
        # Unquoted: a list of numbers.
        # shellcheck disable=SC2086
        kill -s "$1" $left 2>/dev/null
        sleep 0.2
    done
}

stop() {
    status=$?
    set +e
    trap '' EXIT INT TERM HUP
    cd /
    [ -z "$policy" ] || $root rm -f "$policy"
    [ ! -e "$folder/slurm.conf" ] || timeout 10 scancel --user="$(id -un)" >/dev/null 2>&1
    end TERM
    end KILL
    rm -rf "$folder"
    exit "$status"
}
trap stop EXIT
trap 'exit 130' INT
trap 'exit 143' TERM HUP

fail() {
    echo "farm: FAILED: $1" >&2
    shift
    for log; do
        echo "---- the end of $log" >&2
        tail -n 20 "$log" >&2 || true
    done
    exit 1
}

have() { command -v "$1" >/dev/null 2>&1; }

# Programs are found as users find them, daemons also where users do not look for them. Caches and temporary files go into
# the folder, and a Slurm job around this test must not be seen by the one in it.
cd "$folder"
mkdir bin tmp
ln -s "$celfx" bin/celfx
export PATH="$folder/bin:$PATH:/usr/sbin:/sbin" TMPDIR="$folder/tmp" XDG_CACHE_HOME="$folder/tmp"
for name in $(env | sed -En 's/^(S(LURM|BATCH|QUEUE|INFO|CANCEL|CONTROL)_[A-Z0-9_]*)=.*/\1/p'); do
    unset "$name"
done

celfx shot builtin:campfire | sed 's/^size = \[.*/size = [48, 48]/; s/^frames = .*/frames = [1, 8]/' >shot.toml
celfx render shot.toml -q -o 'one/####.png' || fail "celfx does not render"
[ "$(ls one)" = "$(printf '%04d.png\n' 1 2 3 4 5 6 7 8)" ] || fail "one run rendered $(echo one/*)"

# same FOLDER LOG...: whether its frames are those of one run, and nothing else is in it.
same() {
    frames=$1
    shift
    for frame in one/*; do
        cmp "$frame" "$frames/${frame#one/}" || fail "$frames: frame ${frame#one/} is not that of one run" "$@"
    done
    [ "$(ls -A "$frames")" = "$(ls -A one)" ] || fail "$frames: more than frames: $(find "$frames")" "$@"
}

# ---- Slurm
# Installs Slurm and munge; where that may not be done, `why` says so.
install_slurm() {
    why="it is not installed, and there is no apt-get"
    have apt-get || return 1
    why="it is not installed, and only root may install it"
    [ -z "$root" ] || { have sudo && sudo -n true 2>/dev/null; } || return 1
    # Debian starts the services of packages that it installs, and at every boot. Nobody has asked for these here.
    if [ ! -e /usr/sbin/policy-rc.d ]; then
        policy=/usr/sbin/policy-rc.d
        printf '#!/bin/sh\nexit 101\n' | $root tee "$policy" >/dev/null
        $root chmod 755 "$policy"
    fi
    services=
    for service in munge slurmctld slurmd; do
        [ -e "/lib/systemd/system/$service.service" ] || services="$services $service"
    done
    apt="$root env DEBIAN_FRONTEND=noninteractive apt-get -q -o DPkg::Lock::Timeout=120"
    packages="install -y --no-install-recommends slurm-wlm munge"
    # Unquoted: lists of words.
    # shellcheck disable=SC2086
    { $apt $packages || { $apt update && $apt $packages; }; } >apt.log 2>&1 </dev/null ||
        { why="apt-get cannot install it: $(tail -n 1 apt.log)" && return 1; }
    for service in $services; do
        $root systemctl disable "$service" >>apt.log 2>&1 || $root update-rc.d "$service" disable >>apt.log 2>&1 || true
    done
}

# port FIRST: the next port on which nobody listens.
port() {
    port=$1
    while cat /proc/net/tcp /proc/net/tcp6 2>/dev/null | grep -qi "^ *[0-9]*: [0-9A-F]*:$(printf %04X "$port") "; do
        port=$((port + 1))
    done
    echo "$port"
}

# ended JOB: waits until no task of it waits or runs.
ended() {
    for _ in $(seq 240); do
        if left=$(squeue --noheader --jobs="$1" 2>squeue.log) && [ -z "$left" ]; then return; fi
        sleep 1
    done
    fail "job $1 has not ended: $left" squeue.log slurmctld.log slurmd.log
}

# expect JOB TASK HOW: whether the task has ended so.
expect() {
    how=$(scontrol --oneliner show job "$1_$2" | tr ' ' '\n' | grep -E '^(JobState|Restarts|ExitCode)=' | paste -s -d ' ' -)
    [ "$how" = "$3" ] || fail "task $2 of job $1 has ended with $how, and not with $3" "celfx-$1_$2.log" slurmctld.log slurmd.log
}

run_slurm() {
    mkdir state spool
    (umask 077 && head -c 1024 /dev/urandom >munge.key)
    host=$(uname -n)
    host=${host%%.*}
    controller=$(port $((20000 + $$ % 10000)))
    cat >slurm.conf <<CONF
ClusterName=celfx
SlurmctldHost=$host(127.0.0.1)
SlurmctldPort=$controller
SlurmdPort=$(port $((controller + 1)))
CommunicationParameters=NoInAddrAny,NoCtldInAddrAny
# After that many seconds a task that is requeued may begin again.
AuthInfo=socket=$folder/munge.socket,cred_expire=10
SlurmUser=$(id -un)
SlurmdUser=$(id -un)
StateSaveLocation=$folder/state
SlurmdSpoolDir=$folder/spool
SlurmctldPidFile=$folder/slurmctld.pid
SlurmdPidFile=$folder/slurmd.pid
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
SelectType=select/cons_tres
SelectTypeParameters=CR_Core
SlurmdParameters=config_overrides
MpiDefault=none
NodeName=$host NodeAddr=127.0.0.1 CPUs=2 State=UNKNOWN
PartitionName=all Nodes=$host Default=YES State=UP
CONF
    export SLURM_CONF="$folder/slurm.conf"
    # --force: only the user of this test sees the folder, and so the socket.
    munged --foreground --force --key-file="$folder/munge.key" --socket="$folder/munge.socket" \
        --pid-file="$folder/munged.pid" --log-file="$folder/munged-file.log" --seed-file="$folder/munge.seed" >munged.log 2>&1 &
    slurmctld -D >slurmctld.log 2>&1 &
    slurmd -D >slurmd.log 2>&1 &
    for _ in $(seq 60); do
        state=$(sinfo --noheader --format=%t 2>&1) || true
        [ "$state" != idle ] || break
        sleep 1
    done
    [ "$state" = idle ] || fail "Slurm's node does not come up: $state" munged.log slurmctld.log slurmd.log

    # As farm/slurm.sh says. The first task is requeued as soon as it has rendered a frame, which is kept.
    celfx frames shot.toml --chunk 2 --cache cache -o 'of slurm/####.png' >jobs.txt
    [ "$(wc -l <jobs.txt)" = 4 ] || fail "not 4 commands of 2 frames" jobs.txt
    job=$(sbatch --parsable "--array=1-$(wc -l <jobs.txt)" "$farm/slurm.sh" jobs.txt) || fail "sbatch" slurmctld.log
    for _ in $(seq 600); do
        [ ! -e 'of slurm/0001.png' ] || break
        sleep 0.1
    done
    [ -e 'of slurm/0001.png' ] || fail "no frame in 60 s" "celfx-${job}_1.log" slurmd.log
    first=$(stat -c %i 'of slurm/0001.png')
    scontrol requeue "${job}_1" || fail "the first task is not requeued" slurmctld.log
    ended "$job"
    expect "$job" 1 "JobState=COMPLETED Restarts=1 ExitCode=0:0"
    for task in 2 3 4; do expect "$job" "$task" "JobState=COMPLETED Restarts=0 ExitCode=0:0"; done
    same 'of slurm' "celfx-${job}"_*.log
    [ "$(stat -c %i 'of slurm/0001.png')" = "$first" ] || fail "a frame that was finished was rendered again" "celfx-${job}_1.log"
    [ -n "$(ls cache)" ] || fail "nothing in the cache"

    # Not celfx's mistakes: a key that does not exist, and a task for which there is no line. Finished frames are no mistake.
    { head -n 1 jobs.txt; echo "celfx render shot.toml --set smoke.no_such_key=1"; } >wrong.txt
    job=$(sbatch --parsable --array=1-3 "$farm/slurm.sh" wrong.txt) || fail "sbatch" slurmctld.log
    ended "$job"
    expect "$job" 1 "JobState=COMPLETED Restarts=0 ExitCode=0:0"
    for task in 2 3; do expect "$job" "$task" "JobState=FAILED Restarts=0 ExitCode=2:0"; done
    grep -q 'no_such_key: unknown key' "celfx-${job}_2.log" || fail "celfx does not say what is wrong" "celfx-${job}_2.log"
    grep -q 'wrong.txt has no line 3' "celfx-${job}_3.log" || fail "slurm.sh does not say what is wrong" "celfx-${job}_3.log"
    same 'of slurm' "celfx-${job}"_*.log
    echo "farm: $(slurmctld -V): 4 tasks, one of them requeued, rendered the frames of one run; wrong ones failed"
}

if { have munged && have slurmctld && have slurmd && have sbatch; } || install_slurm; then
    run_slurm
else
    echo "SKIPPED: farm: Slurm: $why"
fi

# ---- Open Job Description
# openjd FOLDER FRAMES: as farm/openjd.yaml says.
openjd() {
    python/bin/openjd run "$farm/openjd.yaml" -p Shot=shot.toml -p "Frames=$2" -p Chunk=3 -p "Out=$1/####.png" -p Cache=cache2 \
        >openjd.log 2>&1
}

if { python3 -m venv python && python/bin/pip install -q --disable-pip-version-check 'openjd-cli>=0.8'; } >pip.log 2>&1; then
    python/bin/openjd check "$farm/openjd.yaml" >openjd.log 2>&1 || fail "openjd.yaml is not accepted" openjd.log
    openjd 'of openjd' 1-8 || fail "a task of openjd.yaml has failed" openjd.log
    same 'of openjd' openjd.log
    [ "$(grep -c 'Running Task' openjd.log)" = 3 ] || fail "not 3 tasks of at most 3 frames" openjd.log
    ! openjd beyond 8-9 || fail "a frame beyond the shot is not a failure" openjd.log
    grep -q 'exited with code: 2' openjd.log || fail "a frame beyond the shot does not end with 2" openjd.log
    echo "farm: $(python/bin/openjd --version): 3 tasks rendered the frames of one run; a wrong one failed"
else
    echo "SKIPPED: farm: Open Job Description: no Python with openjd-cli: $(tail -n 1 pip.log)"
fi
