#!/usr/bin/env bash
# Tests the farm scripts from a clean machine: OpenJD with openjd-cli, Slurm with two nodes on this machine.
#
#   examples/farm/test.sh
#
# Installs what it lacks by apt-get and pip, builds the program where there is none (RELIEVO names another), and leaves
# nothing behind but what was installed.
set -euo pipefail
here=$(dirname -- "$(realpath -- "${BASH_SOURCE[0]}")")
# shellcheck source=examples/farm/test/expect.sh
source "$here/test/expect.sh"
root=$here/../..
# Daemons live there on Debian, for others than root out of the path.
export PATH=$PATH:/usr/sbin:/sbin

WORK=$(mktemp -d)
trap 'rm -rf -- "$WORK"' EXIT
export WORK FRAMES=1001-1048

# install PACKAGE...: by apt-get, where this user may.
install() {
  local as=()
  ((EUID == 0)) || as=(sudo -n)
  echo "installing $*"
  "${as[@]}" apt-get update -qq
  DEBIAN_FRONTEND=noninteractive "${as[@]}" apt-get install -y -qq --no-install-recommends "$@" >"$WORK/apt.log" 2>&1 || {
    cat "$WORK/apt.log" >&2
    failed "could not install $*"
  }
}

lacking=()
for pair in python3:python3 slurmctld:slurmctld slurmd:slurmd sbatch:slurm-client munged:munge pgrep:procps cmp:diffutils; do
  command -v "${pair%%:*}" >/dev/null || lacking+=("${pair#*:}")
done
python3 -c 'import ensurepip' 2>/dev/null || lacking+=(python3-venv)
((${#lacking[@]} == 0)) || install "${lacking[@]}"
if ! command -v openjd >/dev/null; then
  echo "installing openjd-cli"
  python3 -m venv "$WORK/venv"
  "$WORK/venv/bin/pip" install --quiet --disable-pip-version-check 'openjd-cli>=0.8,<0.9'
  export PATH=$WORK/venv/bin:$PATH
fi

if [[ -z ${RELIEVO-} ]]; then
  RELIEVO=$root/target/release/relievo
  [[ -x $RELIEVO ]] || cargo build --release --manifest-path "$root/Cargo.toml"
fi
RELIEVO=$(realpath -- "$RELIEVO")
export RELIEVO

# A sequence that cuts from one picture to another, so that chunks that chose for themselves would differ; and one with a
# frame cut short and one that is not there.
mkdir "$WORK"/{in,broken}
for number in {1001..1030}; do cp "$root/fixtures/bust.exr" "$WORK/in/shot.$number.exr"; done
for number in {1031..1048}; do cp "$root/fixtures/gears.exr" "$WORK/in/shot.$number.exr"; done
cp "$WORK"/in/shot.100{1,3,5}.exr "$WORK/broken"
head -c 999 "$WORK/in/shot.1002.exr" >"$WORK/broken/shot.1002.exr"

# What one machine makes of it.
mkdir "$WORK/reference"
"$RELIEVO" enhance "$WORK/in/shot.####.exr" --frames "$FRAMES" --save-recipe "$WORK/reference/look.toml"
"$RELIEVO" run "$WORK/reference/look.toml" "$WORK/in/shot.####.exr" --frames "$FRAMES" -o "$WORK/reference/shot.####.exr" --quiet
passed "48 frames on one machine"

echo "Open Job Description: openjd-cli"
"$here/test/openjd.sh"
if python3 -c 'import pyrelievo, OpenEXR' 2>/dev/null; then
  echo "Python: pyrelievo"
  "$here/test/python.sh"
else
  echo "skipped: the task in Python, whose python3 lacks pyrelievo or OpenEXR"
fi
echo "Slurm: $(slurmctld -V)"
"$here/test/slurm.sh"
echo "all passed"
