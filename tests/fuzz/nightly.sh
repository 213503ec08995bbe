#!/usr/bin/env bash
# nightly.sh [MINUTES [TARGET...]]: fuzzes every target in turn, 20 minutes each where not given, then attacks the built
# program; or the targets that are named, and no more. What is found lies, minimised, in tests/fuzz/artifacts; exit code 1 if there is any. Needs nightly Rust; installs cargo-fuzz.
set -uo pipefail
minutes=${1:-20}
targets=("${@:2}")
here=$(cd "$(dirname "$0")" && pwd)
cd "$here/../.." || exit 2

command -v cargo-fuzz >/dev/null || cargo install --locked cargo-fuzz || exit 2
fuzz=(cargo +nightly fuzz)
how=(--fuzz-dir "$here" --dev --sanitizer none)

# Files of the runs come and go by the thousand: in memory, where there is room for that.
place=$(mktemp -d -p "$([ -w /dev/shm ] && echo /dev/shm || echo "${TMPDIR:-/tmp}")" relievo-nightly.XXXXXX)
trap 'rm -rf "$place"' EXIT
export TMPDIR=$place

"${fuzz[@]}" build "${how[@]}" && cargo build --release || exit 2
python3 tests/fuzz/attack.py --lay "$place/seeds" || exit 2
status=0
[ ${#targets[@]} -gt 0 ] || read -ra targets -d '' < <("${fuzz[@]}" list --fuzz-dir "$here")
for target in "${targets[@]}"; do
    work=$here/corpus/$target
    kept=$here/found/$target
    artifacts=$here/artifacts/$target
    mkdir -p "$work" "$kept" "$artifacts"
    case $target in
        exr_to_frame) cp "$place"/seeds/*.exr "$work" ;;
        pictures | photo_and_recipe) cp "$place"/seeds/*.{png,jpg,tif,hdr} "$work" ;;
    esac
    before=$(ls "$artifacts")
    echo "== $target, $minutes minutes"
    end=$((SECONDS + 60 * minutes))
    # A finding ends a run: another takes the rest of the time, but not for ever the same finding.
    for _ in 1 2 3 4 5; do
        [ $SECONDS -lt $end ] || break
        "${fuzz[@]}" run "${how[@]}" "$target" "$work" "$kept" -- -max_total_time=$((end - SECONDS)) -timeout=10 \
            -rss_limit_mb=4096 -max_len=65536 -close_fd_mask=1 -print_final_stats=1 >"$place/$target.log" 2>&1 && break
        status=1
        grep -a -m 1 -A 1 'panicked at' "$place/$target.log" || tail -n 20 "$place/$target.log"
    done
    grep -a '^stat::number_of_executed_units\|^stat::peak_rss_mb' "$place/$target.log"
    for file in $(comm -13 <(sort <<<"$before") <(ls "$artifacts" | sort)); do
        status=1
        keep=$artifacts/$file
        # A time-out is not made smaller: every try would take as long.
        if [[ $file == crash-* ]]; then
            "${fuzz[@]}" tmin "${how[@]}" "$target" "$artifacts/$file" -- -max_total_time=120 -rss_limit_mb=4096 -close_fd_mask=1 \
                >"$place/tmin.log" 2>&1
            smaller=$(find "$artifacts" -name 'minimized-from-*' -newer "$artifacts/$file" -printf '%T@ %p\n' | sort -n | tail -n 1 | cut -d' ' -f2)
            keep=${smaller:-$keep}
        fi
        echo "FOUND by $target: $artifacts/$file"
        echo "  see it again:  cargo +nightly fuzz run ${how[*]} $target $keep"
        echo "  keep it, once mended:  mv $keep $kept/WHAT_IT_SHOWED, and a line in tests/fuzz/found/README.md"
    done
done

[ $# -gt 1 ] || python3 tests/fuzz/attack.py --runs $((300 * minutes)) || status=1
exit $status
