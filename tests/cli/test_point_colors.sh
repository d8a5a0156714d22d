#!/usr/bin/env bash
# Attributes of points from files to pictures: both backends, memory limits, hidden classes, info
# and picks, and errors. Arguments: executable, scratch folder, source folder. STP_WRITE_GOLDEN=1
# rewrites the golden pictures.
set -u
stipple=$1 source=$3
# shellcheck source=/dev/null
. "$(dirname "$0")/shared.sh"
mkdir -p "$2" && cd "$2" || exit 1
rm -rf ./*
export XDG_CACHE_HOME=$PWD/cache

# a hill with houses and trees: intensity, class, return number, time; and the same without attributes
python3 - << 'END'
import math, struct
state = 1
def roll():
    global state
    state = (state * 6364136223846793005 + 1442695040888963407) % 2**64
    return (state >> 33) / 2**31
rows, plain = [], []
for i in range(20000):
    x, z, kind = 40 * roll(), 40 * roll(), 2
    y = 4 * math.sin(x / 8) * math.cos(z / 9)
    if i % 10 == 0:
        x, z, y, kind = 10 + 6 * roll(), 20 + 6 * roll(), 6.0, 6
    elif i % 10 < 3:
        x, z, y, kind = 25 + 8 * roll(), 10 + 20 * roll(), 3 + 4 * roll(), 5
    light = {2: 20000, 6: 50000, 5: 9000}[kind] + int(8000 * math.sin(x))
    rows.append(struct.pack("<3fHBBd", x, y, z, light, kind, 1 + i % 2, 1000 + x))
    plain.append(struct.pack("<3f", x, y, z))
def write(name, properties, rows):
    head = f"ply\nformat binary_little_endian 1.0\nelement vertex {len(rows)}\n{properties}end_header\n"
    open(name, "wb").write(head.encode() + b"".join(rows))
place = "property float x\nproperty float y\nproperty float z\n"
write("hill.ply", place + "property ushort intensity\nproperty uchar classification\n"
      "property uchar return_number\nproperty double gps_time\n", rows)
write("plain.ply", place, plain)
END

build() # MODEL FILE ARGUMENTS...
{
    local model=$1 file=$2
    shift 2
    "$stipple" build "$model" -o "$file" --progress none "$@" > log 2>&1 || fail "build $model: $(cat log)"
}
build hill.ply hill.stip --threads 1
build hill.ply again.stip --threads 4
cmp -s hill.stip again.stip || fail "threads change bytes"
rm -rf again.stip.work
build hill.ply again.stip # reuses the sets of the previous output
cmp -s hill.stip again.stip || fail "a rebuild changes bytes"
build plain.ply plain.stip
build hill.ply merged.stip --method psp
"$stipple" check hill.stip > log 2>&1 || fail "check: $(cat log)"

"$stipple" info hill.stip --json > info.json || fail "info fails"
python3 - << 'END' || fail "info does not list attributes"
import json
found = json.load(open("info.json"))
named = {a["name"]: a for a in found["attributes"]}
assert list(named) == ["intensity", "class", "return", "time"], named
assert named["return"]["min"] == 1 and named["return"]["max"] == 2
assert named["intensity"]["min"] < named["intensity"]["p2"] < named["intensity"]["p98"] < named["intensity"]["max"]
classes = {c["value"]: (c["name"], c["count"]) for c in named["class"]["classes"]}
assert classes == {2: ("ground", 14000), 5: ("high vegetation", 4000), 6: ("building", 2000)}, classes
assert found["sources"][0]["coordinate_system"] is None
END

draw() # OUT ARGUMENTS...
{
    local out=$1
    shift
    "$stipple" render hill.stip -o "$out" --size 200x140 --accumulate 1 "$@" > draw.json 2> err || fail "render $*: $(cat err)"
}
alike() # A B LEAST
{
    "$stipple" compare "$1" "$2" --json > compare.json || fail "$1 and $2 cannot be compared"
    python3 -c '
import json, sys
psnr = json.load(open("compare.json"))["psnr"]
sys.exit(psnr is not None and psnr < float(sys.argv[1]))' "$3" || fail "$1 is not like $2: $(cat compare.json)"
}
for mode in intensity elevation normal class; do
    draw $mode.png --backend cpu --color $mode
    draw limited.png --backend cpu --color $mode --memory 64M
    alike limited.png $mode.png 99
    if draw gl.png --backend gl --color $mode 2> /dev/null; then
        alike gl.png $mode.png 40
    fi
done
for mode in intensity elevation; do
    golden=$source/tests/golden/draw/points_$mode.png
    [ "${STP_WRITE_GOLDEN:-0}" = 1 ] && cp $mode.png "$golden"
    alike $mode.png "$golden" 40
done

# a range at one end gives a single colour; hidden classes leave no trace
draw houses.png --backend cpu --color class --classes 6 --json
python3 - << 'END' || fail "hidden classes are drawn"
import json
found = json.load(open("draw.json"))
assert found["color"] == "class" and found["range"] is None
assert 0 < found["covered_pixels"] < 3000, found["covered_pixels"]
END
draw houses_gl.png --backend gl --color class --classes 6 && alike houses_gl.png houses.png 40
draw houses_all.png --backend cpu --color class --classes 6 --reference --json
python3 -c 'import json; assert 0 < json.load(open("draw.json"))["covered_pixels"] < 3000' || fail "hidden points are drawn"
draw none.png --backend cpu --classes 9 --json
python3 -c 'import json; assert json.load(open("draw.json"))["covered_pixels"] == 0' || fail "a class that no point has is drawn"
draw low.png --backend cpu --color time --range 1000,1040 --json
python3 -c 'import json; assert json.load(open("draw.json"))["range"] == [1000.0, 1040.0]' || fail "--range is not reported"

# a picked point has its attributes
"$stipple" render hill.stip --pick 100,70 --size 200x140 --view top > pick.json || fail "no pick"
python3 - << 'END' || fail "a pick lists no attributes: $(cat pick.json)"
import json
pick = json.load(open("pick.json"))
assert pick["hit"] and set(pick["attributes"]) == {"intensity", "class", "class name", "return", "time"}, pick
assert abs(pick["attributes"]["time"] - 1000 - pick["position"][0]) < 1e-3
END

# elevation of a mesh: the lower end of a slope is violet, its upper end yellow
printf 'v 0 0 0\nv 10 0 0\nv 10 10 -5\nv 0 10 -5\nf 1 2 3 4\n' > slope.obj
"$stipple" render slope.obj -o slope.png --color elevation --size 64x64 --view front --backend cpu --light head > log 2>&1 ||
    fail "elevation of a mesh: $(cat log)"
"$stipple" render slope.obj -o high.png --color elevation --range -100,-50 --size 64x64 --view front --backend cpu --light head ||
    fail "elevation of a mesh, all high"
cmp -s slope.png high.png && fail "--range changes no elevation"

# points without colours are drawn by elevation, if nothing else is asked for; what is stored stays
python3 - << 'END'
import struct
rows = [struct.pack("<3f3B", i % 60, 0.2 * (i % 7), i // 60, i % 250, 90, 200 - i % 190) for i in range(3600)]
place = "property float x\nproperty float y\nproperty float z\nproperty uchar red\nproperty uchar green\nproperty uchar blue\n"
head = f"ply\nformat binary_little_endian 1.0\nelement vertex {len(rows)}\n{place}end_header\n"
open("bright.ply", "wb").write(head.encode() + b"".join(rows))
END
build bright.ply bright.stip
color_of() # FILE ARGUMENTS...: the colour that a picture has
{
    "$stipple" render "$@" -o auto.png --size 64x64 --json 2> err | python3 -c 'import json, sys; print(json.load(sys.stdin)["color"])'
}
[ "$(color_of plain.stip)" = elevation ] || fail "points without colours are not drawn by elevation"
[ "$(color_of plain.stip --color rgb)" = rgb ] || fail "--color rgb is ignored"
[ "$(color_of plain.stip --filter ewa)" = rgb ] || fail "elevations exclude a filter that was asked for"
[ "$(color_of bright.stip)" = rgb ] || fail "points with colours are drawn by elevation"
[ "$(color_of slope.obj)" = rgb ] || fail "a mesh is drawn by elevation"
for file in plain bright; do
    "$stipple" info $file.stip --json | python3 -c 'import json, sys; print(json.load(sys.stdin)["default_color"])' > $file.color
done
[ "$(cat plain.color bright.color)" = "elevation
rgb" ] || fail "info does not tell the default colour: $(cat plain.color bright.color)"
"$stipple" info plain.stip | grep -q "drawn by elevation" || fail "info says nothing about colours"

refused 1 "no intensity" render plain.stip -o out.png --color intensity
refused 1 "no class" render plain.stip -o out.png --classes 2
refused 1 "no source (they have intensity, class, return, time)" render hill.stip -o out.png --color source
refused 1 "by psp have no intensity" render merged.stip -o out.png --color intensity --method psp
refused 2 "--range must be LO,HI" render hill.stip -o out.png --color intensity --range 5
refused 2 "--range must be LO,HI" render hill.stip -o out.png --color intensity --range 5,1
refused 2 "--range requires" render hill.stip -o out.png --color class --range 1,5
refused 2 "--classes must be N,N" render hill.stip -o out.png --classes 2,256
refused 2 "--classes must be N,N" render hill.stip -o out.png --classes ground
refused 2 "exclude each other" render hill.stip -o out.png --color elevation --filter ewa
refused 2 "color" render hill.stip -o out.png --color reflectance
[ $failures -eq 0 ]
