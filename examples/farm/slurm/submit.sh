#!/usr/bin/env bash
# Submits a sequence to Slurm: one job chooses the look, an array of tasks then makes the frames in chunks.
set -euo pipefail

usage() {
  cat <<'USAGE'
usage: submit.sh [options] INPUT FRAMES OUTPUT [-- LOOK...]

  INPUT, OUTPUT  names of files with #### for the number, on a disk that all nodes see
  FRAMES         as in 1001-1240, 1-100x2 or 1,5,9
  LOOK           options of `relievo enhance`, or of the recipe's command

  -c N           frames in one task (10)
  -t N           threads of one task (4)
  -m error|skip  what a frame that is not there is (error)
  -r RECIPE      a recipe to start from; what it leaves open is chosen

The program is `relievo`, or $RELIEVO. Account, partition, memory and time limit are Slurm's own: SBATCH_ACCOUNT,
SBATCH_PARTITION, SBATCH_MEM_PER_CPU and SBATCH_TIMELIMIT. Prints the number of the array.
USAGE
}

misused() {
  echo "error: $1; see submit.sh -h" >&2
  exit 2
}

chunk=10 threads=4 missing=error recipe=
while getopts :c:t:m:r:h option; do
  case $option in
    c) chunk=$OPTARG ;;
    t) threads=$OPTARG ;;
    m) missing=$OPTARG ;;
    r) recipe=$OPTARG ;;
    h) usage && exit 0 ;;
    *) misused "-$OPTARG is no option or lacks its value" ;;
  esac
done
shift $((OPTIND - 1))
(($# >= 3)) || misused "INPUT, FRAMES and OUTPUT are needed"
input=$1 frames=$2 output=$3
shift 3
[[ ${1-} != -- ]] || shift
[[ $chunk =~ ^[1-9][0-9]*$ ]] || misused "-c takes a number of frames from 1, not '$chunk'"
[[ $threads =~ ^[1-9][0-9]*$ ]] || misused "-t takes a number of threads from 1, not '$threads'"
[[ $missing == error || $missing == skip ]] || misused "-m takes error or skip, not '$missing'"
[[ -z $recipe || -r $recipe ]] || misused "-r $recipe cannot be read"

# The frames one by one.
numbers=()
IFS=, read -ra parts <<<"$frames"
for part in "${parts[@]}"; do
  [[ $part =~ ^(-?[0-9]+)(-(-?[0-9]+)([x:]([1-9][0-9]*))?)?$ ]] || misused "FRAMES has '$part', which is no range"
  # 10#: a leading zero does not make a number octal.
  first=${BASH_REMATCH[1]} last=${BASH_REMATCH[3]:-${BASH_REMATCH[1]}} step=${BASH_REMATCH[5]:-1}
  first=$((${first%%[0-9]*}10#${first#-})) last=$((${last%%[0-9]*}10#${last#-}))
  ((first <= last)) || misused "FRAMES has '$part', which runs backwards"
  for ((n = first; n <= last; n += step)); do numbers+=("$n"); done
done

# What belongs to this submission: one line of frames for each task, the recipe, the logs.
folder=$(dirname -- "$output")
mkdir -p -- "$folder"
job=$(mktemp -d -- "$(realpath -- "$folder")/farm.XXXXXX")
# Tasks may run as this user on nodes where a group reads along.
chmod 755 "$job"
tasks=0
for ((i = 0; i < ${#numbers[@]}; i += chunk)); do
  list=("${numbers[@]:i:chunk}")
  # A run of consecutive frames is short to read in a log: 1001-1010.
  if ((list[-1] - list[0] == ${#list[@]} - 1)); then
    ((${#list[@]} == 1)) && echo "${list[0]}" || echo "${list[0]}-${list[-1]}"
  else
    (IFS=, && echo "${list[*]}")
  fi
  tasks=$((tasks + 1))
done >"$job/chunks"
input=$(realpath -s -- "$input")
output=$(realpath -s -- "$output")
program=${RELIEVO:-relievo}

here=$(dirname -- "$(realpath -- "${BASH_SOURCE[0]}")")
what=(enhance)
if [[ -n $recipe ]]; then
  cp -- "$recipe" "$job/start.toml"
  what=(run "$job/start.toml")
fi
choose=$(sbatch --parsable --cpus-per-task="$threads" --output="$job/choose.log" "$here/choose.sbatch" \
  "$program" "${what[@]}" "$input" --frames "$frames" --threads "$threads" --save-recipe "$job/look.toml" "$@")
# With several clusters the answer is NUMBER;CLUSTER.
sbatch --parsable --dependency="afterok:${choose%%;*}" --kill-on-invalid-dep=yes --array="1-$tasks" \
  --cpus-per-task="$threads" --output="$job/%a.log" \
  "$here/render.sbatch" "$program" "$input" "$output" "$missing" "$threads" "$job"
echo "logs, chunks and recipe: $job" >&2
