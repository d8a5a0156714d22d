#!/usr/bin/env bash
# Method stochastic: builds, pictures on both backends, cues, counts, prefixes, and errors.
# needs: stipple-lab
# Arguments: executable, scratch folder, source folder.
set -u
stipple=$1
# shellcheck source=/dev/null
. "$(dirname "$0")/shared.sh"
mkdir -p "$2" && cd "$2" || exit 1
rm -rf ./*

alike() # A.png B.png LEAST: by SSIM
{
    "$stipple" compare "$1" "$2" --json > compare.json
    holds "$(value compare.json ssim) >= $3" || fail "$1 and $2 differ: $(cat compare.json)"
}

# write_ply(NAME, COLUMNS, LAYOUT, POINTS): columns as "TYPE NAME" each, the layout of a point for struct
cat > ply_file.py << 'END'
import struct
COLORS = ["uchar red", "uchar green", "uchar blue"]
def write_ply(name, columns, layout, points):
    with open(name, "wb") as file:
        file.write(b"ply\nformat binary_little_endian 1.0\nelement vertex %d\n" % len(points))
        file.write("".join(f"property {column}\n" for column in ["float x", "float y", "float z", *columns]).encode())
        file.write(b"end_header\n" + b"".join(struct.pack(layout, *point) for point in points))
END
# a ball above a floor, without normals
python3 - << 'END'
import math
import random
from ply_file import COLORS, write_ply
some = random.Random(5)
points = [(some.uniform(-4, 4), 0.0, some.uniform(-4, 4), 90, 140, 70) for _ in range(5000)]
for _ in range(5000):
    v = [some.gauss(0, 1) for _ in range(3)]
    length = math.sqrt(sum(x * x for x in v))
    points.append((v[0] / length, 1.5 + v[1] / length, v[2] / length, 200, 60, 50))
write_ply("cloud.ply", COLORS, "<3f3B", points)
END
refused 2 'leaf-points requires --method stochastic' build cloud.ply -o a.stip --leaf-points 100
refused 2 'leaf-flatness requires --method stochastic' build cloud.ply -o a.stip --leaf-flatness 0.001
for option in "leaf-sample 100" "leaf-scales 3" "leaf-neighbors 6" "normal-neighbors 30"; do
    # shellcheck disable=SC2086
    refused 2 "${option% *} requires --method stochastic" build cloud.ply -o a.stip --$option
done
"$stipple" -q build cloud.ply -o cloud.stip --method stochastic || fail "no build"
"$stipple" -q build cloud.ply -o other.stip --method stochastic --threads 1 --fresh || fail "no build by one thread"
cmp -s cloud.stip other.stip || fail "the file depends on the number of threads"
"$stipple" -q build cloud.ply -o finer.stip --method stochastic --leaf-points 100 --leaf-flatness 0.001 --leaf-sample 64 --leaf-scales 1 --leaf-neighbors 8 --normal-neighbors 12 || fail "no finer build"
[ "$(wc -c < finer.stip)" -gt "$(wc -c < cloud.stip)" ] || fail "finer leaves take no more bytes"
for file in cloud finer; do
    "$stipple" -q check $file.stip || fail "$file.stip is wrong"
    python3 "$3/scripts/read_store.py" $file.stip > /dev/null || fail "the independent reader refuses $file.stip"
done
# rebuilt from existing results
"$stipple" -q build cloud.ply -o cloud.stip --method stochastic || fail "no second build"
cmp -s cloud.stip other.stip || fail "a build that reuses an output differs"

draw() # NAME OPTIONS...
{
    local name=$1
    shift
    "$stipple" render cloud.stip -o "$name.png" --size 200x150 --eye 3,4,8 --target 0,1,0 --once --accumulate 1 --json "$@" > "$name.json" \
        2> err || fail "render $*: $(cat err)"
}
draw all --splat-size 3
[ "$(value all.json method)" = stochastic ] || fail "drawn by $(value all.json method)"
draw again --splat-size 3
cmp -s all.png again.png || fail "two frames of one view differ"
draw resident --splat-size 3 --memory 64M
cmp -s all.png resident.png || fail "resident leaves give another picture"
if draw gl --splat-size 3 --backend gl && [ -e gl.png ]; then
    alike all.png gl.png 0.98
fi
# exactly the requested number
for count in 1 77 3000 10000; do
    draw count --splats $count
    [ "$(value count.json splats)" = $count ] || fail "--splats $count draws $(value count.json splats)"
done
# fewer splats than leaves leave no holes
"$stipple" render finer.stip -o few.png --size 200x150 --eye 3,4,8 --target 0,1,0 --once --splats 20 --json > few.json || fail "few"
holds "$(value few.json covered_pixels) >= 0.95 * $(value count.json covered_pixels)" || fail "holes: $(cat few.json)"
# each cue changes the number
draw all --splat-size 3 --cues paper
draw flat --splat-size 3 --cues edge,coverage,silhouette,occlusion
draw inside --splat-size 3 --cues flatness,edge,coverage,occlusion
draw open --splat-size 3 --cues flatness,edge,coverage,silhouette
draw coverage --splat-size 3 --cues coverage
draw none --splat-size 3 --cues none
[ "$(value flat.json splats)" -lt "$(value all.json splats)" ] || fail "flatness adds no splats"
[ "$(value inside.json splats)" -lt "$(value all.json splats)" ] || fail "silhouettes add no splats"
[ "$(value open.json splats)" -gt "$(value all.json splats)" ] || fail "occlusion takes no splats away"
[ "$(value coverage.json splats)" -lt "$(value none.json splats)" ] || fail "coverage takes no splats away"
refused 2 'list of flatness, edge' render cloud.stip -o a.png --cues zebra
refused 2 'list of flatness, edge' render cloud.stip -o a.png --cues edge,edge
refused 2 'list of flatness, edge' render cloud.stip -o a.png --cues ''
# a truncated file shows the whole scene
draw whole --splat-size 6
for part in 20% 60%; do
    draw part --splat-size 6 --prefix $part
    alike part.png whole.png 0.5
done
# splats reach into the picture from leaves that lie outside of it: a wall on the faces of cubes, four pixels beyond
python3 - << 'END'
import random
from ply_file import write_ply
some = random.Random(3)
points = [(some.random(), some.random(), 0, 0, 0, 1) for _ in range(20000)]
points += [(-0.5 + 0.01 * some.random(), 0.5 + 0.01 * some.random(), 0, 0, 0, 1) for _ in range(200)]
write_ply("wall.ply", ["float nx", "float ny", "float nz"], "<6f", points)
END
"$stipple" -q build wall.ply -o wall.stip --method stochastic || fail "no build of a wall"
"$stipple" render wall.stip -o wall.png --eye -0.52,0.5,5 --target -0.52,0.5,0 --ortho 1 --size 200x200 --splat-size 16 --once --accumulate 1 \
    --json > wall.json || fail "no picture of a wall"
[ "$(value wall.json covered_pixels)" -gt 150 ] || fail "splats of leaves beside the picture are missing: $(cat wall.json)"
# attributes of points: a strip of class 6 in ground
python3 - << 'END'
import math
import random
from ply_file import write_ply
some = random.Random(7)
places = [(some.uniform(-4, 4), some.uniform(-4, 4)) for _ in range(6000)]
write_ply("scan.ply", ["ushort intensity", "uchar classification"], "<3fHB",
          [(x, math.sin(x), z, int(30000 + 7000 * x), 6 if abs(z) < 0.5 else 2) for x, z in places])
END
"$stipple" -q build scan.ply -o scan.stip --method stochastic || fail "no build of a scan"
cp scan.stip first.stip
rm -rf scan.stip.work
"$stipple" -q build scan.ply -o scan.stip --method stochastic || fail "no second build of a scan"
cmp -s scan.stip first.stip || fail "a reused set has other attributes"
"$stipple" -q check scan.stip || fail "scan.stip is wrong"
python3 "$3/scripts/read_store.py" scan.stip > /dev/null || fail "the independent reader refuses scan.stip"
paint() # NAME OPTIONS...
{
    local name=$1
    shift
    "$stipple" render scan.stip -o "$name.png" --size 200x150 --view top --splat-size 3 --once --accumulate 1 --json "$@" > "$name.json" \
        2> err || fail "render scan.stip $*: $(cat err)"
}
paint plain
for color in intensity class; do
    paint $color --color $color
    ! cmp -s $color.png plain.png || fail "--color $color colours nothing"
done
paint resident --color intensity --memory 64M
cmp -s intensity.png resident.png || fail "--color intensity within a limit gives another picture"
if paint gl --color class --backend gl && [ -e gl.png ]; then
    alike class.png gl.png 0.98
fi
paint strip --classes 6
some=$(value strip.json covered_pixels) every=$(value plain.json covered_pixels)
holds "0.1 * $every < $some && $some < 0.2 * $every" || fail "classes are not hidden: $some, $every"
paint strip_gl --classes 6 --backend gl && alike strip.png strip_gl.png 0.98
# beside another method, and from triangles
"$stipple" -q build scan.ply -o scan.stip --method blue,stochastic || fail "no build of a scan by two methods"
"$stipple" -q check scan.stip || fail "scan.stip of two methods is wrong"
paint beside --color intensity --method stochastic
alike beside.png intensity.png 0.9
"$stipple" -q build cloud.ply -o both.stip --method blue,stochastic || fail "no build of two methods"
"$stipple" -q check both.stip || fail "both.stip is wrong"
python3 - << 'END'
import math
with open("hills.obj", "w") as file: # a sheet of 40 x 40
    for i in range(1600):
        x, z = 0.1 * (i % 40), 0.1 * (i // 40)
        file.write(f"v {x} {0.5 * math.sin(2 * x) * math.cos(2 * z)} {z}\n")
    for i in range(1, 1560):
        if i % 40 != 0:
            file.write(f"f {i} {i + 40} {i + 41}\nf {i} {i + 41} {i + 1}\n")
END
"$stipple" -q build hills.obj -o hills.stip --method stochastic || fail "no build of a mesh"
"$stipple" -q check hills.stip || fail "hills.stip is wrong"
"$stipple" -q render hills.stip -o hills.png --size 200x150 --splat-size 2 --once --accumulate 1 || fail "no picture of a mesh"
"$stipple" -q render hills.stip -o truth.png --size 200x150 --reference --once --accumulate 1 || fail "no reference of a mesh"
alike hills.png truth.png 0.7
# a closed surface of more points than other methods keep together faces outwards: a bumpy ring
python3 - << 'END'
import math
import random
from ply_file import COLORS, write_ply
some, points = random.Random(11), []
for i in range(410000):
    u, v = some.uniform(0, 2 * math.pi), some.uniform(0, 2 * math.pi)
    r = 1 + 0.1 * math.sin(9 * u) * math.cos(3 * v)
    p = ((3 + r * math.cos(v)) * math.cos(u), (3 + r * math.cos(v)) * math.sin(u), r * math.sin(v))
    points.append((*p, i & 255, i >> 8 & 255, i >> 16))
write_ply("ring.ply", COLORS, "<3f3B", points)
END
"$stipple" -q build ring.ply -o ring.stip --method stochastic || fail "no build of a ring"
python3 - "$3" << 'END' || fail "a ring faces inwards"
import math
import pathlib
import struct
import sys
sys.path[:0] = [sys.argv[1] + "/lab/papers", sys.argv[1] + "/scripts"]
import stochastic_normals
points = list(struct.iter_unpack("<3f3B", open("ring.ply", "rb").read().split(b"end_header\n", 1)[1]))
count = inwards = 0
for number, normal in stochastic_normals.read_normals(pathlib.Path("ring.stip")):
    x, y, z = points[number][:3]
    across = math.hypot(x, y)
    middle = (3 * x / across, 3 * y / across, 0) # of the tube
    count += 1
    inwards += sum(n * (p - m) for n, p, m in zip(normal, (x, y, z), middle)) < 0
assert count >= 410000 and inwards < 0.005 * count, (count, inwards)
END
