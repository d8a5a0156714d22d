#!/usr/bin/env bash
# Sets of several methods: build, info, render, fly and bench name them, and report missing ones.
# Arguments: executable, scratch folder, source folder.
# needs: stipple-lab
set -u
stipple=$1
# shellcheck source=/dev/null
. "$(dirname "$0")/shared.sh"
mkdir -p "$2" && cd "$2" || exit 1
rm -rf ./*

# invalid methods
refused 2 'list of blue, spt, psp and stochastic' build scene:spheres -o a.stip --method zebra
refused 2 'list of blue, spt, psp and stochastic' build scene:spheres -o a.stip --method blue,blue
refused 2 'list of blue, spt, psp and stochastic' build scene:spheres -o a.stip --method ''
refused 2 'method' render a.stip -o a.png --method zebra
[ ! -e a.stip ] || fail "a refused build left a file"

small="scene:spheres,scale=0.02 --surfels 3000 --surfel-ratio 0.001"
# shellcheck disable=SC2086
"$stipple" -q build $small -o both.stip --method blue,spt --levels off || fail "no build of two methods"
# shellcheck disable=SC2086
"$stipple" -q build $small -o blue.stip --levels off || fail "no build"
# shellcheck disable=SC2086
"$stipple" -q build $small -o spt.stip --method spt --error qsplat --color-threshold 0 ||
    fail "no build of spt"
# shellcheck disable=SC2086
"$stipple" -q build $small -o split.stip --method spt --error split --color-threshold 0 ||
    fail "no build with split errors"
[ "$(stat -c %s split.stip)" -gt "$(stat -c %s spt.stip)" ] || fail "split errors take no space"
for file in both blue spt split; do
    "$stipple" -q check $file.stip || fail "$file.stip is wrong"
done
methods() # of info.json
{
    tr -d ' \n' < info.json | grep -oE '"methods":\[[^]]*\]' | head -n 1
}
"$stipple" info both.stip --json > info.json
[ "$(methods)" = '"methods":["blue","spt"]' ] || fail "info names $(methods)"
"$stipple" info spt.stip --json > info.json
[ "$(methods)" = '"methods":["spt"]' ] || fail "info names $(methods)"

# the default is the first; each works on either backend, and differs from the other
draw() # FILE NAME OPTIONS...
{
    local file=$1 name=$2
    shift 2
    "$stipple" render "$file" -o "$name.png" --size 200x150 --splat-size 3 --once --json "$@" > "$name.json" 2> err ||
        fail "render $file $*: $(cat err)"
}
draw both.stip first
draw both.stip first_blue --method blue
draw both.stip first_spt --method spt
draw spt.stip only
draw blue.stip alone
[ "$(value first.json method)" = blue ] || fail "the first method is $(value first.json method)"
[ "$(value first_spt.json method)" = spt ] || fail "spt is $(value first_spt.json method)"
[ "$(value only.json method)" = spt ] || fail "of a file of spt: $(value only.json method)"
cmp -s first.png first_blue.png || fail "the default is not the first method"
cmp -s first.png alone.png || fail "blue beside spt is not blue alone"
cmp -s first.png first_spt.png && fail "spt draws the same as blue"
refused 1 'has splats by blue, not by spt' render blue.stip -o a.png --method spt --once
cat > path.json << 'PATH_END'
{"fov": 60, "fps": 10, "keys": [{"t": 0, "eye": [0, 2, 6], "target": [0, 0, 0]}, {"t": 1, "eye": [2, 2, 6], "target": [0, 0, 0]}]}
PATH_END
refused 1 "has splats by blue, not by spt" bench frame --model blue.stip --method spt --quick
refused 1 'has splats by blue, not by spt' fly blue.stip --path path.json --method spt --frames 2 --size 64x48
if draw both.stip gl --method spt --backend gl && [ -e gl.png ]; then
    "$stipple" compare first_spt.png gl.png --json > compare.json
    holds "$(value compare.json ssim) > 0.98" || fail "backends differ: $(cat compare.json)"
fi
# split errors: alike on both backends
draw split.stip split
if draw split.stip gl_split --backend gl && [ -e gl_split.png ]; then
    "$stipple" compare split.png gl_split.png --json > compare.json
    holds "$(value compare.json ssim) > 0.98" || fail "backends differ with split errors: $(cat compare.json)"
fi
# the same with a memory limit
draw both.stip limited --method spt --memory 64M
"$stipple" compare first_spt.png limited.png --json > compare.json
holds "$(value compare.json ssim) > 0.99" || fail "resident sets differ: $(cat compare.json)"
# only splats; including those facing away, behind which nothing else is visible
draw both.stip alone_spt --method spt --hybrid off --eye 0,0.5,2 --target 0,0,0
[ "$(value alone_spt.json triangles)" = 0 ] || fail "--hybrid off draws triangles"
refused 2 'hybrid' render both.stip -o a.png --method spt --hybrid maybe
refused 2 'only spt has --backend' bench frame --quick --backend gl
draw both.stip all_sides --method spt --normal-clusters off
"$stipple" compare first_spt.png all_sides.png --json > compare.json
holds "$(value compare.json ssim) > 0.97" || fail "sides that face away are seen: $(cat compare.json)"
"$stipple" render both.stip -o epsilon.png --size 200x150 --epsilon 3 --once --method spt || fail "--epsilon"
cmp -s epsilon.png first_spt.png || fail "--epsilon is not --splat-size"
# a floor whose triangles are not drawn: its splats cover it without holes, at any size
python3 - << 'END'
with open("floor.obj", "w") as file:
    for z in range(81):
        for x in range(81):
            file.write(f"v {x / 8} 0 {z / 8}\n")
    for z in range(80):
        for x in range(80):
            a = z * 81 + x + 1
            file.write(f"f {a} {a + 81} {a + 1}\nf {a + 1} {a + 81} {a + 82}\n")
END
"$stipple" -q build floor.obj -o floor.stip --method spt --surfels 20000 --surfel-ratio 0.001 || fail "floor"
# a model that is not built yet is built with the requested method
"$stipple" -q render floor.obj --method spt -o model.png --size 64x48 --once --json > model.json ||
    fail "no picture of a model by spt"
[ "$(value model.json method)" = spt ] || fail "the model is drawn by $(value model.json method)"
floor() # NAME OPTIONS...
{
    "$stipple" -q render floor.stip -o "$1.png" --eye 5,1,-2 --target 5,0,5 --size 200x120 --once --background ff00ff "${@:2}" ||
        fail "floor $*"
}
floor whole --reference
for size in 2 16 30; do
    for prefix in 60% 95%; do
        floor part --splat-size $size --prefix $prefix
        python3 - << 'END' || fail "the floor has holes at $size pixels, $prefix"
import struct, zlib

def read(name):
    """Rows of an RGB or RGBA PNG."""
    data, at, packed = open(name, "rb").read(), 8, b""
    while at < len(data):
        size, kind = struct.unpack_from(">I4s", data, at)
        if kind == b"IHDR":
            width, height, _, color = struct.unpack_from(">IIBB", data, at + 8)
        packed += data[at + 8:at + 8 + size] if kind == b"IDAT" else b""
        at += 12 + size
    each = 4 if color == 6 else 3
    stride, plain, rows, above = each * width, zlib.decompress(packed), [], bytes(each * width)
    for y in range(height):
        kind, row = plain[y * (stride + 1)], bytearray(plain[y * (stride + 1) + 1:(y + 1) * (stride + 1)])
        for i in range(stride):
            a, b = row[i - each] if i >= each else 0, above[i]
            c = above[i - each] if i >= each else 0
            p = a + b - c
            paeth = a if abs(p - a) <= abs(p - b) and abs(p - a) <= abs(p - c) else b if abs(p - b) <= abs(p - c) else c
            row[i] = (row[i] + (0, a, b, (a + b) // 2, paeth)[kind]) & 255
        rows.append([bytes(row[each * x:each * x + 3]) for x in range(width)])
        above = row
    return rows

empty, truth, part = bytes((255, 0, 255)), read("whole.png"), read("part.png")
inside = [(x, y) for y in range(2, 118) for x in range(2, 198)
          if all(truth[y + i][x + k] != empty for i in (-2, 0, 2) for k in (-2, 0, 2))]
holes = [at for at in inside if part[at[1]][at[0]] == empty]
assert len(inside) > 1000 and not holes, (len(inside), holes[:9])
END
    done
done
# options of point trees only
refused 2 'method spt' build floor.obj -o other.stip --error qsplat
refused 2 'method spt' build floor.obj -o other.stip --color-threshold 3
# merges by the metrics of the paper: other valid files, which draw; the default is `regions`
psp() # NAME OPTIONS...
{
    # shellcheck disable=SC2086
    "$stipple" -q build $small -o "$1.stip" --method psp --levels off "${@:2}" || fail "no build of psp: $*"
}
psp merged
draw merged.stip original --reference
draw merged.stip regions
for metric in normals distances; do
    psp $metric --psp-metric $metric
    "$stipple" -q check $metric.stip || fail "$metric.stip is wrong"
    cmp -s $metric.stip merged.stip && fail "--psp-metric $metric is the default"
    grep -aq "\"psp_metric\":\"$metric\"" $metric.stip || fail "the file does not say $metric"
    draw $metric.stip $metric
    cmp -s $metric.png regions.png && fail "$metric draws the default's splats"
    "$stipple" compare $metric.png original.png --json > compare.json
    holds "$(value compare.json ssim) > 0.6" || fail "$metric draws something else: $(cat compare.json)"
    # a build over a file of another metric reuses none of its sets
    cp merged.stip over.stip
    psp over --psp-metric $metric
    cmp -s over.stip $metric.stip || fail "sets of another metric were reused"
done
cmp -s normals.stip distances.stip && fail "both metrics make the same file"
grep -aq psp_metric merged.stip && fail "a default is recorded"
psp over
cmp -s over.stip merged.stip || fail "the default after another metric differs"
refused 2 'psp-metric requires --method psp' build floor.obj -o other.stip --psp-metric normals
refused 2 'psp-metric' build floor.obj -o other.stip --method psp --psp-metric zebra
# options that only stipple-lab has
"$stipple" build --help-all > help
for option in samples interval color-threshold leaf-points leaf-neighbors normal-neighbors; do
    grep -q "^      --$option N" help || fail "build --help-all does not list --$option"
done
"$stipple" -q build floor.obj -o paper.stip --order paper-text --samples 20 --interval 9 || fail "--samples and --interval"
# a fixed number of splats
draw both.stip few --method spt
"$stipple" render both.stip -o few.png --size 200x150 --splats 500 --method spt --once --json > few.json || fail "no 500 splats"
[ "$(value few.json splats)" -le 500 ] || fail "$(value few.json splats) splats are not 500"
"$stipple" -q fly both.stip --path path.json --method spt --frames 3 --size 64x48 --budget-ms 50 --json > fly.json || fail "fly"
[ "$(value fly.json method)" = spt ] || fail "fly draws $(value fly.json method)"
for file in both split; do
    python3 "$3/scripts/read_store.py" $file.stip > read.json || fail "the independent reader refuses $file.stip"
done
[ $failures -eq 0 ]
