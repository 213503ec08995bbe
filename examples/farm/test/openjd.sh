#!/usr/bin/env bash
# The Open Job Description template, run by openjd-cli. Called by test.sh with WORK, RELIEVO and FRAMES.
set -euo pipefail
here=$(dirname -- "$(realpath -- "${BASH_SOURCE[0]}")")
# shellcheck source=examples/farm/test/expect.sh
source "$here/expect.sh"
template=$here/../openjd/template.yaml
progress=$here/../openjd/progress.py
out=$WORK/openjd
log=$WORK/openjd.log
mkdir "$out"

# job OUTPUT [PARAMETER...]: runs both steps.
job() {
  local folder=$1 also=()
  shift
  for parameter in "$@"; do also+=(-p "$parameter"); done
  openjd run "$template" --step Render --run-dependencies -p "InputDir=$WORK/in" -p "OutputDir=$folder" \
    -p "Frames=$FRAMES" -p ChunkSize=7 -p Threads=1 -p "Relievo=$RELIEVO" ${also[@]+"${also[@]}"} >"$log" 2>&1
}

# told TEXT: the last session printed it, times and all left out.
told() {
  grep -qE "^[0-9:.]+[[:space:]]+$1" "$log" || {
    cat "$log" >&2
    failed "the session did not print '$1'"
  }
}

openjd check "$template" >/dev/null
passed "openjd check"

job "$out" || { cat "$log" >&2 && failed "openjd run"; }
told 'openjd_progress: 100'
told 'openjd_status: 7 done, 0 skipped, 0 missing, 0 failed'
cmp "$WORK/reference/look.toml" "$out/look.toml"
same "$out"
passed "openjd run: chosen once, made in chunks, equal to one machine bit for bit"

# Two frames lost: again, and only these are made.
touch "$WORK/before"
rm "$out/shot.1003.exr" "$out/shot.1010.exr"
sleep 0.1
job "$out"
[[ $(find "$out" -name 'shot.*.exr' -newer "$WORK/before" | wc -l) == 2 ]] || failed "frames made twice"
told 'openjd_status: 1 done, 6 skipped'
same "$out"
passed "run again: only the frames that are not there are made"

# A recipe to start from: one that leaves nothing open stays as it is.
mkdir "$WORK/again"
job "$WORK/again" "Recipe=$WORK/reference/look.toml"
cmp "$WORK/reference/look.toml" "$WORK/again/look.toml"
same "$WORK/again"
job "$WORK/again" "Recipe=$WORK/reference/look.toml" 'Look=--iterations 20' RecipeName=other.toml
grep -qx 'iterations = 20' "$WORK/again/other.toml" || failed "the look was not laid over the recipe"
passed "a recipe is taken, a look laid over it"

# A frame cut short and one that is not there: the others of their chunks are made, and the session is told why.
mkdir "$WORK/broken.out"
broken=("InputDir=$WORK/broken" "Recipe=$WORK/reference/look.toml" "Frames=1001-1005")
! job "$WORK/broken.out" "${broken[@]}" || failed "a broken frame was taken for made"
told 'openjd_fail: 2 failed: 1002: .*; 1004: '
[[ $(find "$WORK/broken.out" -name 'shot.*.exr' | wc -l) == 3 ]] || failed "frames beside a broken one were not made"
! job "$WORK/broken.out" "${broken[@]}" MissingFrame=skip || failed "a broken frame was taken for made"
told 'openjd_fail: 1 failed: 1002: '
passed "frames that fail are named, the others of the chunk made"

# A farm that cancels: the frame in hand is finished.
mkdir "$WORK/cancelled"
"$progress" "$RELIEVO" run "$WORK/reference/look.toml" "$WORK/in/shot.####.exr" --frames "$FRAMES" --threads 1 \
  -o "$WORK/cancelled/shot.####.exr" --progress json >"$log" 2>&1 &
task=$!
within 60 "first frame" test -e "$WORK/cancelled/shot.1001.exr"
kill -TERM "$task"
status=0
wait "$task" || status=$?
((status == 143)) || failed "cancelled with status $status, not 143"
! grep -q openjd_fail "$log" || failed "a cancelled task says that it failed"
for frame in "$WORK"/cancelled/*; do cmp "$frame" "$WORK/reference/$(basename "$frame")"; done
passed "cancelled: whole frames and nothing else, status 143"
