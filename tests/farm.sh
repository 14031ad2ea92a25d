#!/bin/sh
# tests/farm.sh CELFX: the files in farm/ run for real, on this machine: a Slurm controller and node in a folder of their own, and
# the Open Job Description CLI. Frames of many tasks must be those of one run, bit for bit. What cannot be installed is skipped with
# a line.
set -eu

celfx=$(realpath "$1")
cd "$(dirname "$0")/.."
farm=$PWD/farm
folder=$(mktemp -d)
# Programs are found as users find them.
mkdir "$folder/bin"
ln -s "$celfx" "$folder/bin/celfx"
PATH=$folder/bin:$PATH
export PATH

stop() {
    for name in slurmd slurmctld munged; do
        [ ! -s "$folder/$name.pid" ] || kill "$(cat "$folder/$name.pid")" 2>/dev/null || true
    done
    sleep 1
    rm -rf "$folder"
}
trap stop EXIT
trap 'exit 130' INT TERM
cd "$folder"

fail() {
    echo "farm: $1" >&2
    [ $# -lt 2 ] || tail -n 20 "$2" >&2 || true
    exit 1
}

cat >shot.toml <<'SHOT'
size = [48, 48]
frames = [1, 12]
[smoke]
particles = 100
[flame]
SHOT
celfx render shot.toml -q -o 'one/####.png'

# same FOLDER: whether its frames are those of one run.
same() {
    for frame in one/*.png; do
        cmp "$frame" "$1/$(basename "$frame")" || fail "$1: frame $(basename "$frame") is not that of one run"
    done
    [ "$(ls -A "$1" | wc -l)" = "$(ls one | wc -l)" ] || fail "$1: $(ls -A "$1" | tr '\n' ' ')"
}

# ---- Slurm
root=
[ "$(id -u)" = 0 ] || root="sudo -n"
slurm() {
    if ! command -v slurmctld >/dev/null || ! command -v munged >/dev/null; then
        $root env DEBIAN_FRONTEND=noninteractive apt-get install -y -q --no-install-recommends slurm-wlm munge \
            >apt.log 2>&1 || { echo "SKIPPED: farm: Slurm: cannot be installed: $(tail -n 1 apt.log)"; return 1; }
    fi
    [ "$(id -u)" = 0 ] || { echo "SKIPPED: farm: Slurm: its node is run as root"; return 1; }
}
# free PORT: the next port on which nobody listens.
free() {
    port=$1
    while python3 -c "import socket; socket.create_connection(('127.0.0.1', $port), 1)" 2>/dev/null; do port=$((port + 1)); done
    echo "$port"
}

if slurm; then
    host=$(hostname -s)
    mkdir munge state spool
    chown munge:munge munge
    chmod 755 "$folder"
    # The key is this test's own, and so is the socket.
    head -c 1024 /dev/urandom >munge/key
    chown munge:munge munge/key
    chmod 400 munge/key
    runuser -u munge -- munged --force --key-file "$folder/munge/key" --socket "$folder/munge/socket" \
        --pid-file "$folder/munge/pid" --log-file "$folder/munge/log" --seed-file "$folder/munge/seed" ||
        fail "munged does not start" munge/log
    ln -s munge/pid munged.pid
    controller=$(free 16817)
    node=$(free 16918)
    cat >slurm.conf <<CONF
ClusterName=celfx
SlurmctldHost=$host(127.0.0.1)
SlurmctldPort=$controller
SlurmdPort=$node
AuthType=auth/munge
AuthInfo=socket=$folder/munge/socket
CryptoType=crypto/munge
SlurmUser=root
StateSaveLocation=$folder/state
SlurmdSpoolDir=$folder/spool
SlurmctldPidFile=$folder/slurmctld.pid
SlurmdPidFile=$folder/slurmd.pid
SlurmctldLogFile=$folder/slurmctld.log
SlurmdLogFile=$folder/slurmd.log
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
SelectType=select/cons_tres
SelectTypeParameters=CR_Core
ReturnToService=2
MpiDefault=none
NodeName=$host NodeAddr=127.0.0.1 CPUs=2 RealMemory=500 State=UNKNOWN
PartitionName=all Nodes=$host Default=YES State=UP
CONF
    SLURM_CONF=$folder/slurm.conf
    export SLURM_CONF
    slurmctld || fail "slurmctld does not start" slurmctld.log
    slurmd || fail "slurmd does not start" slurmd.log
    for _ in $(seq 60); do
        ! sinfo -h -o %t 2>/dev/null | grep -q '^idle$' || break
        sleep 1
    done
    sinfo -h -o %t | grep -q '^idle$' || fail "the node does not come up: $(sinfo)" slurmctld.log

    # run LIST: an array of a task a line; waits for all of it.
    run() {
        job=$(sbatch --parsable --array="1-$(wc -l <"$1")" "$farm/slurm.sh" "$1")
        for _ in $(seq 300); do
            [ -n "$(squeue -h -j "$job" -o %i 2>/dev/null)" ] || return 0
            sleep 1
        done
        fail "the array of $1 has not ended in 300 s: $(squeue)" slurmd.log
    }
    celfx frames shot.toml --chunk 3 -o 'slurm/####.png' --cache cache >jobs.txt
    run jobs.txt
    same slurm
    ls cache/*.past >/dev/null || fail "nothing is kept in the cache"
    # A task ends as celfx does: 2 for a shot that is wrong.
    echo "celfx render shot.toml --set smoke.sigam=3" >wrong.txt
    run wrong.txt
    scontrol show job "$job" | grep -q 'ExitCode=2:0' || fail "a wrong shot is not seen: $(scontrol show job "$job")"
    echo "farm: Slurm: $(wc -l <jobs.txt) tasks made the frames of one run"
fi

# ---- Open Job Description
if python3 -m venv python >pip.log 2>&1 && python/bin/pip install -q openjd-cli >>pip.log 2>&1; then
    python/bin/openjd check "$farm/openjd.yaml" >openjd.log 2>&1 || fail "the description is refused" openjd.log
    python/bin/openjd run "$farm/openjd.yaml" -p Shot=shot.toml -p Frames=1-12 -p Out='openjd/####.png' -p Cache=cache2 \
        >openjd.log 2>&1 || fail "a task has failed" openjd.log
    same openjd
    ! python/bin/openjd run "$farm/openjd.yaml" -p Shot=shot.toml -p Frames=12-13 -p Out='beyond/####.png' -p Cache=cache2 \
        >openjd.log 2>&1 || fail "a frame beyond the shot is not seen" openjd.log
    echo "farm: Open Job Description: 12 tasks made the frames of one run"
else
    echo "SKIPPED: farm: Open Job Description: openjd-cli cannot be installed: $(tail -n 1 pip.log)"
fi
