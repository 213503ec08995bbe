#!/usr/bin/env bash
# The Slurm scripts, on a cluster of two nodes on this machine that loses tasks and a node. Called by test.sh with WORK,
# RELIEVO and FRAMES.
set -euo pipefail
here=$(dirname -- "$(realpath -- "${BASH_SOURCE[0]}")")
# shellcheck source=examples/farm/test/expect.sh
source "$here/expect.sh"
submit=$here/../slurm/submit.sh
cluster=$WORK/cluster
mkdir -p "$cluster"/{state,munge}
chmod 700 "$cluster/munge"
export SLURM_CONF=$cluster/slurm.conf

# gone PROCESS: ended, whether or not its parent has asked how.
gone() {
  ! readlink "/proc/$1/exe" >/dev/null
}

# Ends programs, frozen ones too, then the daemons, each by its own number.
cleanup() {
  local pid name
  scancel --user "$(id -un)" 2>/dev/null || true
  for pid in $(pgrep -f "run $WORK/.*/look.toml"); do kill -KILL "$pid" 2>/dev/null || true; done
  for _ in {1..150}; do
    [[ -n $(squeue --noheader 2>/dev/null) ]] || break
    sleep 0.1
  done
  for name in slurmd.a slurmd.b slurmctld munged; do
    pid=$(cat "$cluster/$name.pid" 2>/dev/null) || continue
    kill "$pid" 2>/dev/null || continue
    for _ in {1..50}; do
      gone "$pid" && continue 2
      sleep 0.1
    done
    kill -KILL "$pid" 2>/dev/null || true
  done
}
trap cleanup EXIT

start_cluster() {
  local ports user
  ports=$(python3 -c 'import socket
held = [socket.socket() for _ in range(3)]
for s in held: s.bind(("127.0.0.1", 0))
print(*(s.getsockname()[1] for s in held))')
  read -ra ports <<<"$ports"
  user=$(id -un)
  cat >"$SLURM_CONF" <<CONF
ClusterName=relievo
SlurmctldHost=$(hostname -s)(127.0.0.1)
SlurmctldPort=${ports[0]}
SlurmUser=$user
SlurmdUser=$user
AuthType=auth/munge
AuthInfo=socket=$cluster/munge/socket
CredType=cred/munge
StateSaveLocation=$cluster/state
SlurmdSpoolDir=$cluster/spool.%n
SlurmctldPidFile=$cluster/slurmctld.pid
SlurmdPidFile=$cluster/slurmd.%n.pid
SlurmctldLogFile=$cluster/slurmctld.log
SlurmdLogFile=$cluster/slurmd.%n.log
SlurmdParameters=config_overrides
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
JobAcctGatherType=jobacct_gather/none
MpiDefault=none
SelectType=select/cons_tres
SelectTypeParameters=CR_Core
ReturnToService=2
MinJobAge=3600
KillWait=10
NodeName=a NodeHostname=localhost NodeAddr=127.0.0.1 Port=${ports[1]} CPUs=1
NodeName=b NodeHostname=localhost NodeAddr=127.0.0.1 Port=${ports[2]} CPUs=1
PartitionName=farm Nodes=a,b Default=YES State=UP
CONF
  head -c 1024 /dev/urandom >"$cluster/munge/key"
  chmod 600 "$cluster/munge/key"
  munged --force --key-file="$cluster/munge/key" --socket="$cluster/munge/socket" --pid-file="$cluster/munged.pid" \
    --log-file="$cluster/munged.log" --seed-file="$cluster/munge/seed"
  slurmctld -c
  slurmd -N a
  slurmd -N b
  within 30 "two idle nodes" idle 2
}

idle() {
  [[ $(sinfo --noheader --Node --states=idle | wc -l) == "$1" ]]
}

# field JOB NAME: what Slurm says of a task, as in `field 5_2 JobState`.
field() {
  scontrol --oneliner show job "$1" | tr ' ' '\n' | sed -n "s/^$2=//p"
}

# ended ARRAY: no task waits or runs.
ended() {
  [[ -z $(squeue --noheader --jobs "$1" 2>/dev/null) ]]
}

# array SUBMITTED...: the number of the array and its folder.
array() {
  array=$("$submit" "$@" 2>"$WORK/submit.log") || { cat "$WORK/submit.log" >&2 && failed "submit.sh"; }
  job=$(sed -n 's/^logs, chunks and recipe: //p' "$WORK/submit.log")
}

# Freezes a program on a node amid its chunk: the first frame is made, the last is not. Sets pid, task.
catch() {
  local node=$1 end=$((SECONDS + 60)) environment chunk folder
  folder=$(dirname "$job")
  while ((SECONDS < end)); do
    for pid in $(pgrep -f "run $job/look.toml"); do
      environment=$(tr '\0' '\n' <"/proc/$pid/environ" 2>/dev/null) || continue
      grep -qx "SLURMD_NODENAME=$node" <<<"$environment" || continue
      task=$(sed -n 's/^SLURM_ARRAY_TASK_ID=//p' <<<"$environment")
      chunk=$(sed -n "${task}p" "$job/chunks")
      [[ -e $folder/shot.${chunk%-*}.exr ]] || continue
      kill -STOP "$pid" 2>/dev/null || continue
      [[ -e $folder/shot.${chunk#*-}.exr ]] || return 0
      # Too late for this one.
      kill -CONT "$pid" 2>/dev/null || true
    done
    sleep 0.02
  done
  failed "no task amid its frames on node $node"
}

start_cluster
passed "a cluster of two nodes"

# One array, through it all.
array -c 8 -t 1 "$WORK/in/shot.####.exr" "$FRAMES" "$WORK/slurm/shot.####.exr"

catch a
killed=$task
kill -KILL "$pid"

catch b
lost=$task frozen=$pid
kill -KILL "$(cat "$cluster/slurmd.b.pid")"
scontrol update nodename=b state=down reason=lost

catch a
warned=$task
# A time limit that is near: Slurm gives its signal within half a minute.
scontrol update jobid="$(field "${array}_$warned" JobId)" timelimit=2
within 90 "the signal before the time limit" grep -q 'told to stop' "$job/$warned.log"
kill -CONT "$pid"

within 400 "the array to end" ended "$array"
cmp "$WORK/reference/look.toml" "$job/look.toml"
for task in $(seq "$(wc -l <"$job/chunks")"); do
  state=$(field "${array}_$task" JobState)
  [[ $state == COMPLETED ]] || failed "task $task is $state"
done
for task in "$killed" "$lost" "$warned"; do
  (($(field "${array}_$task" Restarts) >= 1)) || failed "task $task did not go again"
done
same "$WORK/slurm"
grep -q 'ended with status 137' "$job/$killed.log" || failed "task $killed was not seen to be killed"
passed "a killed program: its task went again"
grep -q 'ended with status 143' "$job/$warned.log" || failed "task $warned was not seen to stop"
passed "a task told to stop before its time limit: frame finished, went again"
# The lost node is cut off, not dead: its program wakes and works on.
kill -CONT "$frozen"
within 60 "the program of the lost node to end" gone "$frozen"
same "$WORK/slurm"
passed "a lost node: its task went again, and what woke on it did no harm"
passed "six chunks on two nodes equal one machine bit for bit"

# What somebody cancels stays so.
array -c 8 -t 1 -r "$WORK/reference/look.toml" "$WORK/in/shot.####.exr" "$FRAMES" "$WORK/cancelled.slurm/shot.####.exr"
catch a
scancel "$array"
kill -CONT "$pid"
within 60 "the cancelled array to end" ended "$array"
state=$(field "${array}_$task" JobState)
[[ $state == CANCELLED ]] || failed "a cancelled task is $state"
for frame in "$WORK"/cancelled.slurm/shot.*; do cmp "$frame" "$WORK/reference/$(basename "$frame")"; done
passed "cancelled: whole frames and nothing else, not started again"

# A frame cut short fails its task with status 3, and not again and again.
array -c 8 -t 1 -r "$WORK/reference/look.toml" "$WORK/broken/shot.####.exr" 1001-1003 "$WORK/broken.slurm/shot.####.exr"
within 60 "the broken chunk to end" ended "$array"
[[ $(field "${array}_1" JobState) == FAILED && $(field "${array}_1" ExitCode) == 3:0 ]] ||
  failed "a chunk with a broken frame: $(field "${array}_1" JobState) $(field "${array}_1" ExitCode)"
passed "a frame that fails: the task fails with status 3, the others of the chunk are made"

# No look could be chosen: the array does not wait for ever.
array -t 1 "$WORK/nothing/shot.####.exr" 1-20 "$WORK/nothing.out/shot.####.exr"
within 120 "an array without a recipe to be given up" ended "$array"
passed "no recipe: the array is given up"
