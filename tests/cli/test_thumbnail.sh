#!/usr/bin/env bash
# stipple thumbnail: pictures of meshes, clouds, scenes and .stip files; errors. Arguments:
# executable, scratch folder.
# needs: stipple-lab
set -u
stipple=$1
# shellcheck source=/dev/null
. "$(dirname "$0")/shared.sh"
PYTHONPATH=$(cd "$(dirname "$0")" && pwd)
export PYTHONPATH PYTHONDONTWRITEBYTECODE=1
mkdir -p "$2" && cd "$2" || exit 1
rm -rf ./*
export XDG_CACHE_HOME=$PWD/cache

refused 2 'needs one model' thumbnail -o a.png
refused 2 'needs -o' thumbnail scene:boxes
refused 2 'splats' thumbnail scene:boxes -o a.png --splats 0
refused 2 'size' thumbnail scene:boxes -o a.png --size 5000x1
refused 2 'not above' thumbnail scene:boxes -o a.png --view above
refused 2 'file name' thumbnail scene:boxes -o - --json
refused 2 'a.tga' thumbnail scene:boxes -o a.tga
refused 1 'missing.obj' thumbnail missing.obj -o a.png
refused 1 'nowhere' thumbnail scene:boxes -o nowhere/a.png
printf '# nothing\n' > empty.obj
refused 1 'no positions' thumbnail empty.obj -o a.png
printf 'v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n' > flat.obj
cp flat.obj before.obj
refused 2 'flat.obj' thumbnail flat.obj -o flat.obj
cmp -s flat.obj before.obj || fail "the model was written over"
[ ! -e a.png ] || fail "a refused call left a file"

# the same bytes with any number of threads; nothing is cached
for threads in 1 2 5; do
    "$stipple" -q thumbnail scene:boxes -o boxes-$threads.png --threads $threads --json > $threads.json ||
        fail "--threads $threads"
    cmp -s boxes-1.png boxes-$threads.png || fail "$threads threads give another picture"
done
python3 - 1.json << 'END' || fail "figures: $(cat 1.json)"
import json, sys
d = json.load(open(sys.argv[1]))
assert d["way"] == "captured" and d["method"] == "psp", d
assert (d["width"], d["height"], d["splats"], d["triangles"]) == (256, 256, 2000, 0), d
assert d["candidates"] > 20000 and d["seconds"] > 0 and d["peak_bytes"] > 1000, d
END
[ ! -e cache ] || fail "a thumbnail fills the cache"

# similar to the original, with the same outline
alike() # PICTURE REFERENCE LEAST: ssim_covered
{
    "$stipple" compare "$1" "$2" --json > alike.json || fail "compare $1"
    holds "$(value alike.json ssim_covered) >= $3" || fail "$1 is not like $2: $(cat alike.json)"
}
"$stipple" -q render scene:boxes -o reference.png --reference --ortho 1 --size 256x256 --supersample 4 || fail "reference"
alike boxes-1.png reference.png 0.9
"$stipple" -q thumbnail scene:boxes -o more.png --splats 4000 || fail "--splats 4000"
alike more.png reference.png 0.94
"$stipple" -q render scene:boxes -o top.png --reference --ortho 1 --size 200x100 --supersample 4 --view top || fail "top"
"$stipple" -q thumbnail scene:boxes -o t.png --size 200x100 --view top || fail "--view top"
alike t.png top.png 0.9
"$stipple" -q thumbnail scene:boxes -o t.webp --background white || fail "WebP"
"$stipple" -q thumbnail scene:boxes -o - > piped.png || fail "to standard output"
cmp -s piped.png boxes-1.png || fail "standard output gets a different picture"

# a .stip: splats of psp if it has them, else of the first method
python3 - << 'END'
import math
with open("ball.obj", "w") as file:
    for i in range(61):
        for k in range(60):
            a, b = math.pi * i / 60, math.tau * k / 60
            file.write(f"v {math.sin(a) * math.cos(b):.5f} {math.cos(a):.5f} {math.sin(a) * math.sin(b):.5f}\n")
    for i in range(60):
        for k in range(60):
            a, b = 60 * i + k + 1, 60 * i + (k + 1) % 60 + 1
            file.write(f"f {a} {b} {b + 60} {a + 60}\n")
END
"$stipple" -q build ball.obj -o two.stip --method blue,psp --threads 2 || fail "build"
"$stipple" -q build ball.obj -o one.stip --threads 2 || fail "build"
for file in two:psp one:blue; do
    "$stipple" -q thumbnail ${file%:*}.stip -o s.png --splats 500 --json > s.json || fail "$file"
    python3 - s.json ${file#*:} << 'END' || fail "$file: $(cat s.json)"
import json, sys
d = json.load(open(sys.argv[1]))
assert d["way"] == "stored" and d["method"] == sys.argv[2] and 0 < d["splats"] <= 500, d
END
done

# a cloud has no holes: a grid of points is drawn closed
python3 - << 'END'
with open("grid.ply", "w") as file:
    file.write("ply\nformat ascii 1.0\nelement vertex 1600\nproperty float x\nproperty float y\nproperty float z\n"
               "property uchar red\nproperty uchar green\nproperty uchar blue\nend_header\n")
    for i in range(1600):
        file.write(f"{i % 40} 0 {i // 40} {i % 40 * 6} 90 {i // 40 * 6}\n")
END
"$stipple" -q thumbnail grid.ply -o grid.png --view top --json > grid.json || fail "a cloud"
"$stipple" -q thumbnail grid.ply -o holes.png --view top --background '#010203' || fail "a cloud on a colour"
python3 - << 'END' || fail "the cloud has holes"
from read_png import read_png
rows = read_png("grid.png")
assert all(rows[y][4 * x + 3] == 255 for y in range(30, 226) for x in range(30, 226))
END
exit $((failures > 0))
