#!/usr/bin/env bash
# Drawing of clouds: default eye-dome lighting, point sizes, clouds beside meshes, methods with
# attributes, signs of normals, and precision of positions. Arguments: executable, scratch folder,
# source folder.
# needs: stipple-lab
set -u
stipple=$1 source=$3
# shellcheck source=/dev/null
. "$(dirname "$0")/shared.sh"
mkdir -p "$2" && cd "$2" || exit 1
rm -rf ./*
export XDG_CACHE_HOME=$PWD/cache

# a ball of points, with intensity and class, with and without normals; and a box beside it
python3 - << 'END'
import math, struct
rows, lit = [], []
for i in range(4000):
    y = 1 - 2 * (i + 0.5) / 4000
    turn, r = i * 2.399963229728653, math.sqrt(1 - y * y)
    n = (r * math.cos(turn), y, r * math.sin(turn))
    tail = struct.pack("<HB", 1000 + int(30000 * (1 + y)), 6 if y > 0 else 2)
    rows.append(struct.pack("<3f", *n) + tail)
    lit.append(struct.pack("<6f", *n, *n) + tail)
def write(name, rows, normals):
    place = "".join(f"property float {c}\n" for c in ["x", "y", "z"] + (["nx", "ny", "nz"] if normals else []))
    head = (f"ply\nformat binary_little_endian 1.0\nelement vertex {len(rows)}\n{place}"
            "property ushort intensity\nproperty uchar classification\nend_header\n")
    open(name, "wb").write(head.encode() + b"".join(rows))
write("ball.ply", rows, False)
write("lit.ply", lit, True)
corners = [(x, y, z) for x in (1.5, 2.5) for y in (-1, 0) for z in (-0.5, 0.5)]
faces = ["1 2 4 3", "5 7 8 6", "1 5 6 2", "3 4 8 7", "1 3 7 5", "2 6 8 4"]
open("box.obj", "w").write("".join("v %g %g %g\n" % c for c in corners) + "".join(f"f {f}\n" for f in faces))
END
build() # FILE ARGUMENTS...
{
    local file=$1
    shift
    "$stipple" build -o "$file" --unit m --progress none "$@" > log 2>&1 || fail "build $*: $(cat log)"
}
build ball.stip ball.ply
build lit.stip lit.ply
build both.stip box.obj ball.ply
build methods.stip ball.ply --method psp,stochastic
build merged.stip ball.ply --method psp

draw() # FILE OUT ARGUMENTS...
{
    local file=$1 out=$2
    shift 2
    "$stipple" render "$file" -o "$out" --size 120x90 --accumulate 1 "$@" > draw.json 2> err || fail "render $file $*: $(cat err)"
}
alike() # A B LEAST
{
    "$stipple" compare "$1" "$2" --json > compare.json || fail "$1 and $2 cannot be compared"
    python3 -c '
import json, sys
psnr = json.load(open("compare.json"))["psnr"]
sys.exit(psnr is not None and psnr < float(sys.argv[1]))' "$3" || fail "$1 differs from $2: $(cat compare.json)"
}
both() # FILE OUT ARGUMENTS...: by the processor, and the same by OpenGL where there is one
{
    local file=$1 out=$2
    shift 2
    draw "$file" "$out" --backend cpu "$@"
    if "$stipple" render "$file" -o gl.png --size 120x90 --accumulate 1 --backend gl "$@" > /dev/null 2>&1; then
        alike gl.png "$out" 35
    fi
}

# eye-dome lighting: on for a cloud, off if requested, off beside a mesh
both ball.stip usual.png
draw ball.stip one.png --backend cpu --eye-dome 1
draw ball.stip off.png --backend cpu --eye-dome off
cmp -s usual.png one.png || fail "a cloud is not drawn with eye-dome lighting"
cmp -s usual.png off.png && fail "--eye-dome off changes nothing"
draw both.stip beside.png --backend cpu
draw both.stip beside_off.png --backend cpu --eye-dome=0
cmp -s beside.png beside_off.png || fail "eye-dome lighting beside a mesh"

# sizes: more pixels for larger points; in metres fewer from farther away; adaptive is the default
covered() # FILE ARGUMENTS...
{
    local file=$1
    shift
    draw "$file" size.png --backend cpu --once --json --eye 0,0,8 --target 0,0,0 "$@"
    python3 -c 'import json; print(json.load(open("draw.json"))["covered_pixels"])'
}
small=$(covered ball.stip --point-size 1)
large=$(covered ball.stip --point-size 9px)
metres=$(covered ball.stip --point-size 0.2m)
[ "$small" -lt "$large" ] || fail "9 pixels cover $large, 1 pixel $small"
[ "$small" -lt "$metres" ] || fail "0.2 m cover $metres, 1 pixel $small"
both ball.stip sized.png --point-size 5
draw ball.stip adaptive.png --backend cpu --point-size adaptive
cmp -s adaptive.png usual.png || fail "adaptive is not the default"
for size in 0 65px 3cm -1m big; do
    refused 2 "--point-size must be" render ball.stip -o a.png "--point-size=$size"
done

# points and triangles in one scene: attributes and sizes apply only to points
golden=$source/tests/golden/draw/points_both.png
both both.stip colored.png --color class --point-size 0.1m
[ "${STP_WRITE_GOLDEN:-0}" = 1 ] && cp colored.png "$golden"
alike colored.png "$golden" 35
draw both.stip far.png --backend cpu --color intensity --splat-size 8
draw both.stip limited.png --backend cpu --color intensity --splat-size 8 --memory 64M
alike limited.png far.png 99
draw both.stip shown.png --backend cpu --classes 9 --once --json
python3 -c 'import json; f = json.load(open("draw.json")); assert f["splats"] >= 0 and f["triangles"] == 12, f' || fail "hidden classes hide triangles"

# choice of a method with the attribute
draw methods.stip methods.png --backend cpu --color intensity --once --json
grep -q "drawn by stochastic: splats by psp have no intensity" err || fail "no message about the other method: $(cat err)"
python3 -c 'import json; assert json.load(open("draw.json"))["method"] == "stochastic"' || fail "stochastic is not named"
draw merged.stip merged.png --backend cpu --classes 6
grep -q "original points are drawn: splats have no class" err || fail "no message about original points: $(cat err)"
refused 1 "by psp have no intensity" render methods.stip -o a.png --color intensity --method psp

# signs and positions
python3 "$source/scripts/read_store.py" ball.stip > ball.json || fail "ball.stip by the other reader"
python3 "$source/scripts/read_store.py" lit.stip > lit.json || fail "lit.stip by the other reader"
"$stipple" info ball.stip --json > info.json || fail "info"
"$stipple" info both.stip | grep -q "positions *exact to .* [mun]*m$" || fail "info does not print the accuracy of positions"
python3 - << 'END' || fail "certainty"
import json
ball, lit, info = (json.load(open(f"{n}.json")) for n in ("ball", "lit", "info"))
# a set, and its coarse ellipses
assert [c["flags"] for c in ball["certainty"]] == [1, 1], ball["certainty"]
assert [c["flags"] for c in lit["certainty"]] == [0, 0], lit["certainty"]
step = ball["surfels"][0]["step"]
assert ball["certainty"][0]["position_error"] == info["position_error"] == step / 2, (info["position_error"], step)
END
[ $failures -eq 0 ]
