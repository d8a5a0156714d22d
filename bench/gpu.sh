#!/usr/bin/env bash
# Measures what OpenGL draws on this machine's GPU, in one command and without a network: builds
# stipple, makes the benchmark scene, draws its views at 1080p, 1440p, 4K and in stereo with points,
# compute shaders and full geometry, and writes bench/results/DEVICE/gpu.json and gpu.md.
#
#   bench/gpu.sh [--scale F] [--scene NAME] [--jobs N] [--splat-size PX] [--build FOLDER]
#                [--stipple PROGRAM] [--output FOLDER]
#
# --scale F       fraction of the benchmark scene (1: 2.35 billion triangles); default: with a GPU,
#                 1 if there are eight CPUs and 24 GB of memory, else 0.1; without a GPU 0.002
# --scene NAME    another scene of `stipple-lab scene --list`; default paper
# --stipple       use this program instead of building one
# --output        output folder instead of bench/results
#
# Needs the compilers and libraries of packages.txt, and a driver with EGL (no display). Reports
# missing parts by name.
set -u
here=$(cd "$(dirname "$0")/.." && pwd) || exit 1
scene=paper scale= jobs=$(nproc) size=1 build=$here/build/gpu stipple= output=$here/bench/results
fail()
{
    echo "gpu.sh: $*" >&2
    exit 1
}
while [ $# -gt 0 ]; do
    [ $# -ge 2 ] || fail "$1 needs a value, or is not an option (see the head of this script)"
    case $1 in
    --scale) scale=$2 ;;
    --scene) scene=$2 ;;
    --jobs) jobs=$2 ;;
    --splat-size) size=$2 ;;
    --build) build=$2 ;;
    --stipple) stipple=$2 ;;
    --output) output=$2 ;;
    *) fail "$1 is not an option (see the head of this script)" ;;
    esac
    shift 2
done

# Names every package of packages.txt that the build needs and that is missing.
look_for_packages()
{
    command -v dpkg-query > /dev/null || return 0
    local missing=() name
    while read -r name; do
        case $name in
        build-essential | cmake | pkg-config | lib*-dev)
            dpkg-query -W -f '${Status}' "$name" 2> /dev/null | grep -q 'ok installed' || missing+=("$name")
            ;;
        esac
    done < <(grep -v '^#' "$here/packages.txt")
    [ ${#missing[@]} -eq 0 ] || echo "gpu.sh: not installed: ${missing[*]}" >&2
}

if [ -z "$stipple" ]; then
    look_for_packages
    command -v cmake > /dev/null || fail "cmake is needed to build (apt-get install cmake)"
    generator=()
    command -v ninja > /dev/null && generator=(-G Ninja)
    echo "gpu.sh: building in $build" >&2
    cmake -S "$here" -B "$build" "${generator[@]}" -DCMAKE_BUILD_TYPE=RelWithDebInfo \
        -DCMAKE_C_FLAGS_RELWITHDEBINFO='-O3 -g' > "$build.log" 2>&1 ||
        { mkdir -p "$build"; tail -20 "$build.log" >&2; fail "cmake failed ($build.log): a package of packages.txt is missing"; }
    cmake --build "$build" -j "$jobs" --target stipple_lab_tool >> "$build.log" 2>&1 ||
        { tail -30 "$build.log" >&2; fail "the build failed ($build.log)"; }
    stipple=$build/lab/stipple-lab
fi
[ -x "$stipple" ] || fail "$stipple is not executable"

scratch=$(mktemp -d) || exit 1
trap 'rm -rf "$scratch"' EXIT
export XDG_CACHE_HOME=$scratch
"$stipple" bench gl --quick --model scene:boxes --json > "$scratch/quick.json" 2> "$scratch/quick.err" ||
    { cat "$scratch/quick.err" >&2; fail "OpenGL 4.5 through EGL does not work"; }
device=$(grep -m 1 -o '"device": *"[^"]*"' "$scratch/quick.json" | sed 's/.*: *"//; s/"$//')
[ -n "$device" ] || { cat "$scratch/quick.err" >&2; fail "OpenGL 4.5 through EGL is not available (driver, libegl1)"; }
software=
case $device in *llvmpipe* | *softpipe* | *swrast*) software=1 ;; esac
[ -z "$software" ] || echo "gpu.sh: only $device is available: draws small pictures of a small scene, which do not represent a GPU" >&2

memory=$(awk '/MemTotal/ { print int($2 / 1048576) }' /proc/meminfo)
if [ -z "$scale" ]; then
    scale=0.1
    [ "$(nproc)" -ge 8 ] && [ "$memory" -ge 24 ] && scale=1
    [ -z "$software" ] || scale=0.002
fi
echo "gpu.sh: $device, scene:$scene,scale=$scale" >&2
begin=$(date +%s)
"$stipple" build "scene:$scene,scale=$scale" -o "$scratch/scene.stip" --quiet > /dev/null || fail "cannot make the scene"
made=$(($(date +%s) - begin))
folder=$output/$(echo "$device" | tr -cs 'A-Za-z0-9.\n' '-' | sed 's/-*$//')
mkdir -p "$folder" || exit 1
"$stipple" bench gl --model "$scratch/scene.stip" --splat-size "$size" --json --markdown "$scratch/gpu.md" > "$scratch/gpu.json" ||
    fail "the benchmark failed"
sed "s|$scratch/scene.stip|scene:$scene,scale=$scale|" "$scratch/gpu.json" > "$folder/gpu.json"
{
    echo "# OpenGL on $device"
    echo
    echo "Made by \`bench/gpu.sh --scene $scene --scale $scale --splat-size $size\`; the scene took $made s to build, everything else $(($(date +%s) - begin - made)) s."
    [ -z "$software" ] || echo "Rendered on the CPU: this shows only that the script works."
    echo
    sed "s|$scratch/scene.stip|scene:$scene,scale=$scale|" "$scratch/gpu.md"
} > "$folder/gpu.md"
echo "$folder/gpu.json"
echo "$folder/gpu.md"
