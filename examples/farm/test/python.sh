#!/usr/bin/env bash
# The task in Python, run in the place of relievo: by the Open Job Description template and by itself. Called by test.sh
# with WORK, FRAMES and a python3 that has pyrelievo and OpenEXR.
set -euo pipefail
here=$(dirname -- "$(realpath -- "${BASH_SOURCE[0]}")")
# shellcheck source=examples/farm/test/expect.sh
source "$here/expect.sh"
task=$here/../python/task.py
out=$WORK/python
log=$WORK/python.log
mkdir "$out"

# equal FOLDER: all frames are there, with the layers and the picture of one machine's, bit for bit, and nothing else is.
equal() {
  python3 - "$WORK/reference" "$1" <<'PYTHON' || failed "$1 differs from one machine's frames"
import sys
from pathlib import Path

import OpenEXR

def channels(path):
    with OpenEXR.File(str(path), separate_channels=True) as file:
        return {name: channel.pixels.tobytes() for part in file.parts for name, channel in part.channels.items()}

reference, made = (sorted(Path(folder).glob("*")) for folder in sys.argv[1:])
names = [path.name for path in reference]
assert [path.name for path in made] == names, set(names) ^ {path.name for path in made}
for one, other in zip(reference, made):
    if one.suffix == ".exr":
        assert channels(one) == channels(other), one.name
PYTHON
}

openjd run "$here/../openjd/template.yaml" --step Render --run-dependencies -p "InputDir=$WORK/in" -p "OutputDir=$out" \
  -p "Frames=$FRAMES" -p ChunkSize=16 -p Threads=1 -p "Relievo=$task" >"$log" 2>&1 || { cat "$log" >&2 && failed "openjd run"; }
grep -q 'openjd_status: 16 done, 0 skipped, 0 missing, 0 failed' "$log" || failed "the session was not told of the frames"
cmp "$WORK/reference/look.toml" "$out/look.toml"
equal "$out"
passed "openjd run with a task in Python: layers and picture equal to one machine bit for bit"

# run FOLDER OPTION...: a chunk in Python; sets status.
run() {
  local folder=$1
  shift
  status=0
  "$task" run "$out/look.toml" "$WORK/broken/shot.####.exr" -o "$folder/shot.####.exr" --keep-going --skip-existing \
    --sample-frames none --progress json --threads 1 "$@" >"$log" 2>&1 || status=$?
}

mkdir "$WORK/broken.python"
run "$WORK/broken.python" --frames 1001-1005
((status == 3)) || failed "broken frames ended with status $status, not 3"
grep -q '"frame": 1002, "status": "failed", .*"message": ' "$log" || failed "a frame cut short is not named"
[[ $(ls -A "$WORK/broken.python") == $'shot.1001.exr\nshot.1003.exr\nshot.1005.exr' ]] || failed "not the whole frames alone"
run "$WORK/broken.python" --frames 1003-1005 --missing-frame skip
((status == 0)) || failed "whole and missing frames ended with status $status, not 0"
grep -q '"done": 0, "skipped": 2, "missing": 1, "failed": 0' "$log" || failed "frames were made again"
passed "frames that fail are named, the others made, and none made again"

mkdir "$WORK/stopped.python"
"$task" run "$out/look.toml" "$WORK/in/shot.####.exr" --frames "$FRAMES" -o "$WORK/stopped.python/shot.####.exr" --threads 1 &
pid=$!
within 60 "first frame" test -e "$WORK/stopped.python/shot.1001.exr"
kill -TERM "$pid"
status=0
wait "$pid" || status=$?
((status == 143)) || failed "told to stop, it ended with status $status, not 143"
[[ -z $(find "$WORK/stopped.python" -name '.*.part') && ! -e $WORK/stopped.python/shot.1048.exr ]] || failed "not stopped"
passed "told to stop: whole frames and nothing else, status 143"
