#!/usr/bin/env bash
# Shapes of splats: squares and opacity textures, with both methods, both backends and any number of
# threads. Arguments: executable, scratch folder.
# needs: stipple-lab
set -u
stipple=$1
# shellcheck source=/dev/null
. "$(dirname "$0")/shared.sh"
mkdir -p "$2" && cd "$2" || exit 1
rm -rf ./*

"$stipple" -q build scene:spheres,scale=0.02 --surfels 8000 --surfel-ratio 0.001 -o both.stip --method blue,spt || fail "no build of two methods"

draw() # NAME OPTIONS...
{
    local name=$1
    shift
    "$stipple" render both.stip -o "$name.png" --size 160x120 --splat-size 6 --hybrid off --once -q "$@" 2> err ||
        fail "render $*: $(cat err)"
}
alike() # A B LEAST
{
    "$stipple" compare "$1.png" "$2.png" --json > compare.json
    holds "$(value compare.json ssim) > $3" || fail "$1 and $2 differ: $(cat compare.json)"
}
# a PNG of one colour, 2 x 2 pixels of RGBA
paint() # FILE RED GREEN BLUE ALPHA
{
    python3 - "$@" << 'END'
import struct, sys, zlib
def chunk(name, data):
    return struct.pack(">I", len(data)) + name + data + struct.pack(">I", zlib.crc32(name + data))
rows = (b"\0" + bytes(map(int, sys.argv[2:6])) * 2) * 2
with open(sys.argv[1], "wb") as file:
    file.write(b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", struct.pack(">IIBBBBB", 2, 2, 8, 6, 0, 0, 0)) +
               chunk(b"IDAT", zlib.compress(rows)) + chunk(b"IEND", b""))
END
}
paint white.png 255 255 255 255
paint faint.png 255 255 255 4
paint black.png 0 0 0 255

for method in blue spt; do
    for shape in "--splat-shape square" "--filter textured" "--filter textured --splat-texture white.png"; do
        # shellcheck disable=SC2086
        draw one --method $method $shape --threads 1
        # shellcheck disable=SC2086
        draw three --method $method $shape --threads 3
        cmp -s one.png three.png || fail "$method $shape: threads change the picture"
        # shellcheck disable=SC2086
        STP_PROCESSOR=baseline draw baseline --method $method $shape
        cmp -s one.png baseline.png || fail "$method $shape: the processor changes the picture"
    done
    draw disks --method $method
    draw named --method $method --splat-shape disk
    draw squares --method $method --splat-shape square
    cmp -s disks.png named.png || fail "disks are not the default"
    cmp -s disks.png squares.png && fail "$method: squares are disks"
done

# opacities are normalised by their sum: with a single texel, all weights are equal
draw gauss --filter textured
draw white --filter textured --splat-texture white.png
draw black --filter textured --splat-texture black.png
draw faint --filter textured --splat-texture faint.png
alike white black 0.9999
alike white faint 0.9999
cmp -s gauss.png white.png && fail "the texture changes nothing"

if "$stipple" render both.stip -o gl.png --size 32x32 --backend gl -q 2> /dev/null; then
    draw gl_squares --splat-shape square --backend gl
    draw gl_white --filter textured --splat-texture white.png --backend gl
    draw cpu_squares --splat-shape square --backend cpu
    draw cpu_white --filter textured --splat-texture white.png --backend cpu
    alike gl_squares cpu_squares 0.98
    alike gl_white cpu_white 0.975 # the picture is full of borders of splats
fi

cat > path.json << 'END'
{"fov": 60, "fps": 10, "keys": [{"t": 0, "eye": [0, 2, 6], "target": [0, 0, 0]}, {"t": 1, "eye": [2, 2, 6], "target": [0, 0, 0]}]}
END
"$stipple" fly both.stip --path path.json --frames 2 --size 64x48 --splat-shape square -q > out || fail "fly with squares"
refused 2 "splat-shape" render both.stip -o a.png --splat-shape cube
refused 2 "exclude" render both.stip -o a.png --splat-shape square --filter ewa
refused 2 "exclude" fly both.stip --path path.json --splat-shape square --filter textured
refused 2 "requires --filter textured" render both.stip -o a.png --splat-texture white.png
refused 1 "nothing.png" render both.stip -o a.png --filter textured --splat-texture nothing.png
refused 1 "path.json" render both.stip -o a.png --filter textured --splat-texture path.json
[ ! -e a.png ] || fail "a refused picture was written"
exit $((failures > 0))
