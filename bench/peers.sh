#!/usr/bin/env bash
# Compares stipple with programs that do part of the same, on 20 M unique triangles (`stipple-lab scene
# twenty-million`): gltfpack, which simplifies, against `stipple build`; F3D, from model to picture,
# against `stipple render`. Programs take turns, REPEATS times (default 3); prints medians. Takes
# minutes; run it on an idle machine.
#
# usage: bench/peers.sh [MODEL.glb]
#
# The peers are not dependencies of the project. On Debian: apt-get install gltfpack f3d xvfb xauth
# time
set -euo pipefail
cd "$(dirname "$0")/.."
stipple=$PWD/build/release/lab/stipple-lab
repeats=${REPEATS:-3}
folder=$(mktemp -d "${TMPDIR:-/tmp}/stipple-peers-XXXXXX")
trap 'rm -rf "$folder"' EXIT

have() { command -v "$1" > /dev/null; }
timer=$(type -P time) || { echo "peers.sh: GNU time is missing (apt-get install time)" >&2; exit 1; }
[ -x "$stipple" ] || { echo "peers.sh: $stipple is missing (run make)" >&2; exit 1; }

model=${1:-}
if [ -z "$model" ]; then
    model=$folder/twenty-million.glb
    "$stipple" scene twenty-million -o "$model" --progress none
fi

# measure NAME COMMAND...: appends a line "wall user system kilobytes" to NAME.times
measure() {
    local name=$1
    shift
    if "$timer" -v -o "$folder/report" "$@" > "$folder/log" 2>&1; then
        awk -F': ' '/Elapsed/ { n = split($NF, t, ":"); wall = 0; for (i = 1; i <= n; ++i) wall = 60 * wall + t[i] }
            /User time/ { user = $NF } /System time/ { kernel = $NF } /Maximum resident/ { memory = $NF }
            END { print wall, user, kernel, memory }' "$folder/report" >> "$folder/$name.times"
    else
        echo "peers.sh: $name failed: $(tail -n 1 "$folder/log")" >&2
    fi
}

clear_builds() { rm -rf "$folder/cache" "$folder/built.stip" "$folder/built.stip.work"; }

run_build() { clear_builds; measure "stipple-build" "$stipple" build "$model" -o "$folder/built.stip" --fresh -q; }
run_render() { # NAME OPTION...
    local name=$1
    shift
    clear_builds
    measure "$name" env XDG_CACHE_HOME="$folder/cache" "$stipple" render "$model" -o "$folder/stipple.png" \
        --view front --size 1920x1080 -q "$@"
}
run_gltfpack() { measure "gltfpack" gltfpack -i "$model" -o "$folder/simple.glb" -si 0.01; }
run_f3d() { measure "f3d" "${screen[@]}" f3d "$model" --output "$folder/f3d.png" --resolution 1920,1080; }

screen=()
if [ -z "${DISPLAY:-}" ]; then
    screen=(xvfb-run -a)
fi
with_gltfpack=true with_f3d=true
have gltfpack || { with_gltfpack=false; echo "peers.sh: gltfpack is missing; skipped" >&2; }
have f3d || { with_f3d=false; echo "peers.sh: f3d is missing; skipped" >&2; }
if $with_f3d && [ ${#screen[@]} -gt 0 ] && ! have xvfb-run; then
    with_f3d=false
    echo "peers.sh: f3d needs a display or xvfb-run; skipped" >&2
fi

cat "$model" > /dev/null # load the model into the page cache for all
for _ in $(seq "$repeats"); do
    ! $with_gltfpack || run_gltfpack
    run_build
    ! $with_f3d || run_f3d
    run_render stipple-render --once --supersample 1
    run_render stipple-render-full
done

median() { sort -n | awk '{ v[NR] = $1 } END { print v[int((NR + 1) / 2)] }'; }
row() {
    local label=$1 times=$folder/$2.times
    [ -s "$times" ] || { printf '| %s | - | - | - |\n' "$label"; return; }
    printf '| %s | %.1f | %.1f | %.2f |\n' "$label" "$(cut -d' ' -f1 "$times" | median)" \
        "$(awk '{ print $2 + $3 }' "$times" | median)" \
        "$(cut -d' ' -f4 "$times" | median | awk '{ print $1 * 1024 / 1e9 }')"
}
echo "$(basename "$model"), $(stat -c %s "$model") bytes; $(nproc) CPUs; medians of $repeats"
echo
echo "| | seconds | CPU seconds | GB at most |"
echo "|---|---|---|---|"
row "gltfpack -si 0.01" gltfpack
row "stipple build" stipple-build
row "f3d, model to picture" f3d
row "stipple render, model to picture, one sample" stipple-render
row "stipple render, model to picture" stipple-render-full
echo
echo "Memory is peak resident memory, including mapped files."
