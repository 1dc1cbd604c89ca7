#!/usr/bin/env bash
# Starts a Slurm cluster of one node in a folder, runs a build in it as a job array and a job that merges, and stops it.
# Usage: slurm.sh FOLDER BRDFC SCENE SHARDS, as root; all but BRDFC relative to the folder. The packs go to FOLDER/packs.
# Exit code 77: there is no Slurm here, or it cannot be started.
set -uo pipefail
folder=$1 brdfc=$2 scene=$3 shards=$4
cd "$folder" || exit 1
PATH=$PATH:/usr/sbin:/sbin
skip() { echo "skipped: $*"; exit 77; }
for tool in munged slurmctld slurmd sbatch; do
    command -v "$tool" >/dev/null || skip "no $tool (Debian: slurm-wlm munge)"
done
[ "$(id -u)" -eq 0 ] || skip "Slurm is started by root alone"

slurm=$PWD/slurm host=$(hostname -s)
mkdir -p "$slurm/state" "$slurm/spool"
export SLURM_CONF=$slurm/slurm.conf
# Free ports, so that a running cluster does not conflict.
ports=$(python3 -c 'import socket
s = [socket.socket() for _ in range(2)]
[x.bind(("127.0.0.1", 0)) for x in s]
print(*(x.getsockname()[1] for x in s))') || skip "no python3 to find free ports"
read -r control node <<<"$ports"
cores=$(nproc)
cat >"$SLURM_CONF" <<END
ClusterName=test
SlurmctldHost=$host(127.0.0.1)
SlurmctldPort=$control
SlurmdPort=$node
AuthType=auth/munge
AuthInfo=socket=$slurm/munge.socket
CredType=cred/munge
SlurmUser=root
StateSaveLocation=$slurm/state
SlurmdSpoolDir=$slurm/spool
SlurmctldPidFile=$slurm/slurmctld.pid
SlurmdPidFile=$slurm/slurmd.pid
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
SelectType=select/cons_tres
SelectTypeParameters=CR_Core
MpiDefault=none
ReturnToService=2
NodeName=$host NodeAddr=127.0.0.1 CPUs=$cores State=UNKNOWN
PartitionName=all Nodes=$host Default=YES MaxTime=10 State=UP
END

processes=()
stop() {
    for process in "${processes[@]}"; do kill "$process" 2>/dev/null; done
    wait 2>/dev/null
}
trap stop EXIT
head -c 1024 /dev/urandom >"$slurm/munge.key"
chmod 400 "$slurm/munge.key"
chmod 755 "$slurm"
munged --foreground --force --socket "$slurm/munge.socket" --key-file "$slurm/munge.key" --pid-file "$slurm/munged.pid" \
    --log-file "$slurm/munged.log" --seed-file "$slurm/munged.seed" >"$slurm/munged.out" 2>&1 &
processes+=($!)
for _ in $(seq 50); do [ -S "$slurm/munge.socket" ] && break; sleep 0.1; done
[ -S "$slurm/munge.socket" ] || skip "munged does not start: $(tail -n 1 "$slurm/munged.out" "$slurm/munged.log" 2>/dev/null)"
slurmctld -D -f "$SLURM_CONF" >"$slurm/slurmctld.out" 2>&1 &
processes+=($!)
slurmd -D -f "$SLURM_CONF" -N "$host" >"$slurm/slurmd.out" 2>&1 &
processes+=($!)
for _ in $(seq 100); do sinfo -h -o %T 2>/dev/null | grep -q idle && break; sleep 0.1; done
sinfo -h -o %T 2>/dev/null | grep -q idle ||
    skip "no node comes up: $(tail -n 1 "$slurm/slurmctld.out") $(tail -n 1 "$slurm/slurmd.out")"

# The commands of docs/many-machines.md.
cat >array.sh <<END
#!/bin/sh
exec "$brdfc" build "$scene" --out packs --quiet --jobs 1 --shard "\$SLURM_ARRAY_TASK_ID/$shards"
END
cat >merge.sh <<END
#!/bin/sh
exec "$brdfc" build "$scene" --out packs --quiet
END
array=$(sbatch --parsable --array="1-$shards" --output=array-%a.out array.sh) || exit 1
sbatch --wait --dependency="afterok:$array" --kill-on-invalid-dep=yes --output=merge.out merge.sh
code=$?
[ "$code" -eq 0 ] || tail -n 5 array-*.out merge.out
exit "$code"
