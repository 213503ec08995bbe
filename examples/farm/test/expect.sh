#!/usr/bin/env bash
# What both tests say and compare. Sourced; WORK is the folder of the test, FRAMES the frames of its sequence.

passed() {
  echo "passed: $1"
}

failed() {
  echo "FAILED: $1" >&2
  exit 1
}

# same FOLDER: all frames are there, bit for bit those of one machine, and no other file has the name of a frame.
same() {
  local reference name others
  for reference in "$WORK"/reference/shot.*.exr; do
    name=$(basename "$reference")
    cmp -s "$reference" "$1/$name" || failed "$1/$name is not the frame of one machine"
  done
  others=$(find "$1" -maxdepth 1 -type f -name 'shot.*.exr' ! -name 'shot.????.exr')
  [[ -z $others ]] || failed "left over: $others"
}

# within SECONDS WHAT COMMAND...: waits until the command succeeds.
within() {
  local end=$((SECONDS + $1)) what=$2
  shift 2
  until "$@"; do
    ((SECONDS < end)) || failed "$what: waited in vain"
    sleep 0.1
  done
}
