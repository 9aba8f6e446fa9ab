#!/usr/bin/env bash
# SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
# SPDX-License-Identifier: BSD-3-Clause
#
# A map that a Slurm cluster of two nodes on this machine colours in parts, one node of which is lost at work: the bytes
# of a single run.
. "$(dirname "$0")/common.bash"
. "$(dirname "$0")/spread.bash"
make_recording
export PATH=$PATH:/usr/sbin  # where Debian has the daemons, and only root looks

port=$((20000 + RANDOM % 10000))
slurm=$tmp/slurm
mkdir -p "$slurm"/{state,n1,n2}
cat >"$slurm/slurm.conf" <<CONF
ClusterName=test
SlurmctldHost=localhost
SlurmctldPort=$port
SlurmUser=$(id -un)
SlurmdUser=$(id -un)
AuthType=auth/munge
AuthInfo=socket=$slurm/munge.socket
CredType=cred/munge
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
SlurmctldPidFile=$slurm/slurmctld.pid
SlurmdPidFile=$slurm/%n.pid
SlurmdSpoolDir=$slurm/%n
StateSaveLocation=$slurm/state
SelectType=select/cons_tres
SelectTypeParameters=CR_Core
SchedulerParameters=sched_interval=1,bf_interval=1,batch_sched_delay=1
SlurmdTimeout=5
KillWait=2
NodeName=n1 NodeHostname=localhost NodeAddr=127.0.0.1 Port=$((port + 1)) CPUs=1
NodeName=n2 NodeHostname=localhost NodeAddr=127.0.0.1 Port=$((port + 2)) CPUs=1
PartitionName=all Nodes=n1,n2 Default=YES State=UP
CONF
export SLURM_CONF=$slurm/slurm.conf
head -c 1024 /dev/urandom >"$slurm/munge.key"
chmod 600 "$slurm/munge.key"
munged --foreground --force --key-file="$slurm/munge.key" --socket="$slurm/munge.socket" --pid-file="$slurm/munge.pid" \
  --log-file="$slurm/munge.log" --seed-file="$slurm/munge.seed" 2>"$slurm/munge.out" &
background+=($!)
slurmctld -D -c >"$slurm/slurmctld.log" 2>&1 &
background+=($!)
for node in n1 n2; do
  slurmd -D -N "$node" >"$slurm/$node.log" 2>&1 &
  node_daemon=$!
  background+=("$node_daemon")
done
for ((tries = 0; tries < 100; ++tries)); do
  [ "$(sinfo -h -t idle -o %D 2>/dev/null)" = 2 ] && break
  sleep 0.2
done
if ((tries == 100)); then
  problem "the cluster does not come up"
  tail -n 5 "$slurm"/*.log "$slurm/munge.out"
  exit 1
fi

# lose_node: n2 with all that runs on it, as when the machine is switched off.
lose_node() {
  local step
  await_victim || return
  kill -KILL "$node_daemon"
  for step in $(pgrep -f '^slurmstepd: '); do
    # The job's program tells its node.
    for child in $(pgrep -P "$step"); do
      tr '\0' '\n' <"/proc/$child/environ" | grep -qx 'SLURMD_NODENAME=n2' || continue
      pkill -KILL -P "$child" || true
      kill -KILL "$child" "$step"
    done
  done
  # Slurm would wait two minutes before it runs the part again.
  local job deadline=$((SECONDS + 120))
  while ((SECONDS < deadline)) && { job=$(squeue -h -t pending -n surfels -o '%A %r' | grep -m 1 BeginTime) ||
    [ -z "$(sinfo -h -n n2 -t down -o %D)" ]; }; do
    [ -z "$job" ] || scontrol update "JobId=${job%% *}" StartTime=now || true
    sleep 0.5
  done
}
lose_node &
expect 0 'job [0-9]+: merge, 1 parts' scripts/spread_slurm "$recording" --output "$tmp/parts.ply" --parts 3 --wait \
  --logs "$tmp/%x.%A_%a.log" --colorize "$tmp/colorize" "${params[@]}"
expect_the_same
grep -q 'surfels' "$tmp/victim" || problem "no node was lost at work"
[ "$(sinfo -h -n n2 -o %T)" = 'down*' ] || problem "the node is not down"
[ "$problems" = 0 ] || { squeue; tail -20 "$slurm/slurmctld.log" "$tmp"/*.log; }

expect 1 'num_threads is what' scripts/spread_slurm "$recording" --output "$tmp/parts.ply" num_threads=2
expect 1 'error: the map is not saved' scripts/spread_slurm "$recording" --output "$tmp/parts.ply" --parts 2 --wait \
  --logs "$tmp/%x.%A_%a.log" --colorize "$tmp/colorize_without_lambda"
