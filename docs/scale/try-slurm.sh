#!/usr/bin/env bash
# Runs docs/scale/slurm.sh on a cluster of two nodes, both of them this machine, and looks at what came out.
#
#     docs/scale/try-slurm.sh path/to/plenoscope
#
# Needs root and Debian's slurm-wlm and munge; `cargo xtask test --all` installs them. Everything lies in a folder that
# goes away, and every daemon that it starts it stops.
set -eu
program=$(realpath "$1")
here=$(cd "$(dirname "$0")" && pwd)
dir=$(mktemp -d /tmp/plenoscope-slurm.XXXXXX)
daemons=()
stop() {
    status=$?
    # Only our own, by their numbers; the last that was started first.
    for ((n = ${#daemons[@]} - 1; n >= 0; n--)); do kill "${daemons[n]}" 2>/dev/null || true; done
    wait 2>/dev/null || true
    if [ "$status" != 0 ]; then tail -n 20 "$dir"/*.log "$dir"/slurm-*.out 2>/dev/null || true; fi
    rm -rf "$dir"
    exit "$status"
}
trap stop EXIT
chmod 755 "$dir"
mkdir "$dir/state" "$dir/spool" "$dir/photos"

# Keys and daemons of our own, away from a cluster that this machine may belong to.
dd if=/dev/urandom of="$dir/munge.key" bs=1024 count=1 status=none
chmod 400 "$dir/munge.key"
munged --foreground --force --key-file "$dir/munge.key" --socket "$dir/munge.socket" --pid-file "$dir/munge.pid" \
    --seed-file "$dir/munge.seed" --log-file "$dir/munge.log" 2>>"$dir/munged.log" &
daemons+=($!)
host=$(hostname -s)
cores=$(nproc)
cat >"$dir/slurm.conf" <<CONF
ClusterName=plenoscope
SlurmctldHost=$host(127.0.0.1)
SlurmctldPort=26817
SlurmUser=root
SlurmdUser=root
AuthType=auth/munge
AuthInfo=socket=$dir/munge.socket
CredType=cred/munge
StateSaveLocation=$dir/state
SlurmdSpoolDir=$dir/spool/%n
SlurmctldPidFile=$dir/slurmctld.pid
SlurmdPidFile=$dir/slurmd-%n.pid
SlurmctldLogFile=$dir/slurmctld.log
SlurmdLogFile=$dir/slurmd-%n.log
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
SwitchType=switch/none
MpiDefault=none
SelectType=select/cons_tres
SelectTypeParameters=CR_Core
ReturnToService=2
SchedulerParameters=batch_sched_delay=0,sched_interval=1
NodeName=one NodeHostname=$host NodeAddr=127.0.0.1 Port=26818 CPUs=$cores
NodeName=two NodeHostname=$host NodeAddr=127.0.0.1 Port=26819 CPUs=$cores
PartitionName=all Nodes=one,two Default=YES MaxTime=INFINITE State=UP
CONF
export SLURM_CONF=$dir/slurm.conf PLENOSCOPE=$program
for _ in $(seq 50); do [ -S "$dir/munge.socket" ] && break; sleep 0.1; done
slurmctld -D -i 2>>"$dir/slurmctld.log" &
daemons+=($!)
for node in one two; do
    slurmd -D -N "$node" 2>>"$dir/slurmd-$node.log" &
    daemons+=($!)
done
for _ in $(seq 100); do
    [ "$(sinfo -h -N -o %T 2>/dev/null | sort -u)" = idle ] && break
    sleep 0.2
done
sinfo -N

"$program" sample -o "$dir" >/dev/null
photos=${PHOTOS:-12}
for n in $(seq "$photos"); do ln "$dir/sample.png" "$dir/photos/scan-$n.png"; done
ls -d "$dir"/photos/* >"$dir/list.txt"
echo '{"version": 2, "lens": {"f_number": 2.0}}' >"$dir/edit.json"
cd "$dir"
started=$(date +%s.%N)
job=$(sbatch --parsable --array=1-4 --mem=0 --chdir="$dir" "$here/slurm.sh" "$dir/list.txt" "$dir/edit.json" "$dir/out")

# One task is thrown back into the queue in the middle, as a node that is needed for something else does it.
for _ in $(seq 600); do ls "$dir"/out/*.jpg >/dev/null 2>&1 && break; sleep 0.1; done
task=$(squeue -h -r -j "$job" -t RUNNING -o %i | head -n 1)
if [ -n "$task" ]; then
    scontrol requeue "$task" && echo "put back into the queue: task $task"
fi
for _ in $(seq 3000); do
    waiting=$(squeue -h -r -j "$job" -o "%i %r")
    [ -n "$waiting" ] || break
    # Slurm would wait two minutes before it begins such a task again.
    [[ $waiting != *BeginTime* ]] || scontrol update JobId="$task" StartTime=now
    sleep 0.2
done
ended=$(date +%s.%N)
[ -z "$(squeue -h -j "$job")" ] || { echo "the array does not end" >&2; squeue; exit 1; }

# Every photo there once, none torn, nothing left behind; and each part said so.
for photo in $(cat "$dir/list.txt"); do
    name=$(basename "$photo" .png)
    "$program" info "$dir/out/$name-f2.jpg" >/dev/null
    cmp "$dir/out/$name-f2.jpg" "$dir/out/scan-1-f2.jpg"
    [ "$(cat "$dir"/out-reports/*.jsonl | grep -c "\"path\":\"$photo\".*\"error\":null")" -ge 1 ]
done
[ "$(find "$dir/out" -maxdepth 1 -type f | wc -l)" = "$photos" ]
grep -L '"state":"made"' "$dir"/out-reports/*.jsonl | grep . && { echo "a part did nothing" >&2; exit 1; }
scontrol -o show job "$job" | grep -o 'ArrayTaskId=[0-9]*\|JobState=[A-Z]*\| NodeList=[a-z][a-z]*\|Restarts=[0-9]*' | paste -sd' ' | sed 's, ArrayTaskId,\nArrayTaskId,g'
[ "$(scontrol -o show job "$job" | grep -o 'NodeList=[a-z]*' | sort -u | grep -c 'one\|two')" = 2 ]
echo "ok: $photos photos on two nodes in $(awk "BEGIN { printf \"%.1f\", $ended - $started }") s"
