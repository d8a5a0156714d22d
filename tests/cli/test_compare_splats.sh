#!/usr/bin/env bash
# stipple-lab compare-splats: known distances, agreement with gtscompare (Debian: libgts-bin), all kinds
# of files, and error messages. Arguments: executable, scratch folder.
# needs: stipple-lab
set -u
stipple=$1
# shellcheck source=/dev/null
. "$(dirname "$0")/shared.sh"
mkdir -p "$2" && cd "$2" || exit 1
rm -rf ./*
export XDG_CACHE_HOME=$PWD/cache

cat > files.py << 'END'
"""Makes models and splats, and turns splats into meshes for gtscompare."""
import math, struct, sys

def mesh(path, points, faces):
    with open(path, "w") as file:
        file.write(f"ply\nformat ascii 1.0\nelement vertex {len(points)}\nproperty float x\nproperty float y\nproperty float z\n")
        file.write(f"element face {len(faces)}\nproperty list uchar int vertex_indices\nend_header\n")
        file.write("".join("%.9g %.9g %.9g\n" % p for p in points) + "".join("3 %d %d %d\n" % f for f in faces))

def cloud(path, points):
    with open(path, "w") as file:
        file.write(f"ply\nformat ascii 1.0\nelement vertex {len(points)}\nproperty float x\nproperty float y\nproperty float z\n")
        file.write("end_header\n" + "".join("%.9g %.9g %.9g\n" % p for p in points))

def splats(path, rows, names="x y z nx ny nz axis_x axis_y axis_z minor"):
    with open(path, "wb") as file:
        file.write(b"ply\nformat binary_little_endian 1.0\nelement vertex %d\n" % len(rows))
        file.write("".join(f"property float {name}\n" for name in names.split()).encode() + b"end_header\n")
        file.write(b"".join(struct.pack("<10f", *row) for row in rows))

def stone(rings, around):
    """A ball with bumps."""
    points, faces = [], []
    for i in range(rings + 1):
        for k in range(around):
            a, b = math.pi * i / rings, 2 * math.pi * k / around
            r = 1 + 0.15 * math.sin(5 * a) * math.cos(3 * b)
            points.append((r * math.sin(a) * math.cos(b), r * math.cos(a), r * math.sin(a) * math.sin(b)))
    for i in range(rings):
        for k in range(around):
            a, b, c, d = i * around + k, i * around + (k + 1) % around, (i + 1) * around + k, (i + 1) * around + (k + 1) % around
            faces += ([(a, b, d)] if i > 0 else []) + ([(a, d, c)] if i + 1 < rings else [])
    return points, faces

def read_splats(path):
    data = open(path, "rb").read()
    head, body = data.split(b"end_header\n", 1)
    size = 43 if b"red" in head else 40
    return [struct.unpack_from("<10f", body, i) for i in range(0, len(body), size)]

def gts(path, points, faces):
    edges = {}
    for f in faces:
        for a, b in ((f[0], f[1]), (f[1], f[2]), (f[2], f[0])):
            edges.setdefault((min(a, b), max(a, b)), len(edges) + 1)
    with open(path, "w") as file:
        file.write(f"{len(points)} {len(edges)} {len(faces)}\n" + "".join("%.9g %.9g %.9g\n" % tuple(p) for p in points))
        file.write("".join("%d %d\n" % (a + 1, b + 1) for a, b in edges))
        for f in faces:
            file.write(" ".join(str(edges[min(a, b), max(a, b)]) for a, b in ((f[0], f[1]), (f[1], f[2]), (f[2], f[0]))) + "\n")

def fans(rows, sides=40):
    """Polygons whose sides are as far outside the ellipse in their corners as inside it in their middles."""
    points, faces, larger = [], [], 2 / (1 + math.cos(math.pi / sides))
    for row in rows:
        c, n, u = row[0:3], row[3:6], row[6:9]
        v = (n[1] * u[2] - n[2] * u[1], n[2] * u[0] - n[0] * u[2], n[0] * u[1] - n[1] * u[0])
        length = math.sqrt(sum(x * x for x in v))
        v = [x * row[9] / length for x in v]
        first = len(points)
        points.append(c)
        for k in range(sides):
            s, t = larger * math.cos(2 * math.pi * k / sides), larger * math.sin(2 * math.pi * k / sides)
            points.append([c[i] + s * u[i] + t * v[i] for i in range(3)])
        faces += [(first, first + 1 + k, first + 1 + (k + 1) % sides) for k in range(sides)]
    return points, faces

if __name__ == "__main__":
    # a square with one disk above it that is larger, and one that is smaller than the square
    mesh("square.ply", [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0)], [(0, 1, 2), (0, 2, 3)])
    splats("above.ply", [(0.5, 0.5, 0.1, 0, 0, 1, 2, 0, 0, 1)])
    splats("middle.ply", [(0.5, 0.5, 0, 0, 0, 1, 0, 0.25, 0, 0.25)])
    splats("bad.ply", [(0.5, math.nan, 0, 0, 0, 1, 0, 0.25, 0, 0.25)])
    splats("short.ply", [(0.5, 0, 0, 0, 0, 1, 0, 0.25, 0, 0.25)], "x y z nx ny nz axis_x axis_y axis_z other")
    open("cut.ply", "wb").write(open("above.ply", "rb").read()[:-1])
    cloud("cloud.ply", [(0, 0, 0), (1, 0, 0.2), (1, 1, 0.4)])
    cloud("one.ply", [(1, 2, 3)])
    tilted = (3, 2, 1, 0.6, 0, 0.8, 0.8 * 0.8, 0.6, -0.6 * 0.8, 0.3)
    splats("tilted.ply", [tilted])
    mesh("fan.ply", *(lambda p, f: ([tuple(q) for q in p], f))(*fans([tilted])))
    points, faces = stone(30, 50)
    mesh("stone.ply", points, faces)
    gts("stone.gts", points, faces)
    points, faces = stone(6, 9)
    mesh("coarse.ply", points, faces)
    gts("coarse.gts", points, faces)
END
python3 files.py || exit 1

# figures FILE EXPRESSION: evaluates a Python expression about the figures d
figures()
{
    python3 -c "import json, math, sys
d = json.load(open(sys.argv[1]))
near = lambda a, b, part=1e-6: abs(a - b) <= part * max(abs(b), 1e-9)
sys.exit(not ($2))" "$1" || fail "$1: not $2: $(cat "$1")"
}

refused 2 'needs splats and a model' compare-splats above.ply
refused 2 'needs splats and a model' compare-splats above.ply square.ply square.ply
refused 2 'banana' compare-splats above.ply square.ply --method banana
refused 1 'missing.ply' compare-splats missing.ply square.ply
refused 1 'missing.ply' compare-splats above.ply missing.ply
refused 1 'single point' compare-splats above.ply one.ply
refused 1 'not finite' compare-splats bad.ply square.ply
refused 1 'a property is missing' compare-splats short.ply square.ply
refused 1 'does not match its header' compare-splats cut.ply square.ply
refused 1 'only to a .stip' compare-splats above.ply square.ply --splats 1

# known distances
"$stipple" compare-splats above.ply square.ply --size 99x99 --json > above.json 2> err || fail "above: $(cat err)"
[ ! -s err ] || fail "messages: $(cat err)"
keys=$(python3 -c 'import json; print(*sorted(json.load(open("above.json"))))')
[ "$keys" = "area area_ratio area_ratio_missing diagonal farthest hausdorff_bound_percent hausdorff_max_percent hausdorff_mean_percent samples splat_area splats ssim ssim_covered triangles views" ] ||
    fail "keys: $keys"
figures above.json 'd["splats"] == 1 and d["triangles"] == 0 and near(d["area"], 1) and near(d["diagonal"], math.sqrt(2))'
figures above.json 'near(d["hausdorff_max_percent"], 10 / math.sqrt(2)) and near(d["hausdorff_mean_percent"], 10 / math.sqrt(2))'
figures above.json 'near(d["area_ratio"], 2 * math.pi) and d["area_ratio_missing"] is None'
figures above.json 'len(d["views"]) == 7 and all(0 < v["ssim"] <= 1 for v in d["views"])'
"$stipple" compare-splats middle.ply square.ply --no-pictures --json > middle.json || fail "middle"
figures middle.json 'd["ssim"] is None and d["ssim_covered"] is None and d["views"] is None'
figures middle.json 'near(d["hausdorff_max_percent"], 100 * (math.sqrt(0.5) - 0.25) / math.sqrt(2)) and near(d["area_ratio"], math.pi / 16)'
# from the middle of a square, the mean distance is 0.382598; within the disk it is 0
figures middle.json 'near(d["hausdorff_mean_percent"], 100 * (0.3825978 - 0.25 + math.pi * 0.25 ** 3 / 3) / math.sqrt(2), 2e-3)'
"$stipple" compare-splats above.ply square.ply --no-pictures > text || fail "text"
grep -q '^area .*6.283 times' text || fail "text: $(cat text)"

# a drawn ellipse covers the same pixels as its triangles, in each view
"$stipple" compare-splats tilted.ply fan.ply --size 160x160 --json > tilted.json || fail "tilted"
figures tilted.json 'd["hausdorff_max_percent"] < 0.2 and d["hausdorff_bound_percent"] < 0.21 and near(d["area_ratio"], 1, 2e-3)'
figures tilted.json 'all(v["ssim"] > 0.9 and v["ssim_covered"] > 0.9 for v in d["views"])'

# a cloud: each of its points counts, and there is no area
"$stipple" compare-splats above.ply cloud.ply --no-pictures --json > cloud.json || fail "cloud"
figures cloud.json 'd["area_ratio"] is None and "no triangles" in d["area_ratio_missing"] and d["samples"] == 3'
figures cloud.json 'near(d["hausdorff_max_percent"] * d["diagonal"], 30, 1e-5) and near(d["hausdorff_mean_percent"] * d["diagonal"], 50 / 3, 1e-5)'
figures cloud.json 'near(d["farthest"][2], 0.4, 1e-6)'

# a model itself; the same bytes for any number of threads
"$stipple" compare-splats square.ply square.ply --size 160x120 --json > same.json || fail "a mesh"
figures same.json 'd["splats"] == 0 and d["triangles"] == 2 and d["hausdorff_max_percent"] == 0 and d["area_ratio"] == 1 and d["ssim"] == 1'
"$stipple" -q decimate stone.ply -o stone-psp.ply --splats 90 > out || fail "decimate"
"$stipple" compare-splats stone-psp.ply stone.ply --size 160x160 --json > stone-psp.json || fail "decimated splats"
for threads in 1 2 3; do
    "$stipple" compare-splats stone-psp.ply stone.ply --samples 50000 --no-pictures --threads $threads --json > threads$threads.json || fail "--threads $threads"
    cmp -s threads1.json threads$threads.json || fail "$threads threads give different figures"
done
figures stone-psp.json 'd["splats"] == 90 and 0.1 < d["hausdorff_max_percent"] < 20 and 0.001 < d["hausdorff_mean_percent"] < 1 and 1 < d["area_ratio"] < 9'
figures stone-psp.json '0.5 < d["ssim"] < 1 and d["samples"] == 200000 and d["hausdorff_max_percent"] <= d["hausdorff_bound_percent"] < 1.0011 * d["hausdorff_max_percent"]'
"$stipple" -q decimate stone.ply -o more.ply --splats 700 > out || fail "decimate"
"$stipple" compare-splats more.ply stone.ply --samples 20000 --size 160x160 --json > more.json || fail "more splats"
python3 -c 'import json; a, b = (json.load(open(f)) for f in ("stone-psp.json", "more.json")); assert b["ssim"] > a["ssim"] + 0.05 and b["ssim_covered"] > a["ssim_covered"] + 0.1 and 3 * b["hausdorff_mean_percent"] < a["hausdorff_mean_percent"], (a, b)' ||
    fail "more splats are no better: $(cat more.json)"
"$stipple" compare-splats stone-psp.ply stone.ply --no-pictures --samples 400000 --json > dense.json || fail "--samples"
figures dense.json 'd["samples"] == 400000'
python3 -c 'import json; a, b = (json.load(open(f)) for f in ("stone-psp.json", "dense.json")); assert abs(a["hausdorff_max_percent"] / b["hausdorff_max_percent"] - 1) < 0.0011 and abs(a["hausdorff_mean_percent"] / b["hausdorff_mean_percent"] - 1) < 0.002, (a, b)' ||
    fail "figures depend on the number of samples"
# truncated files
python3 -c '
data = open("above.ply", "rb").read()
for size in range(4, len(data), 37): open(f"cut{size}.ply", "wb").write(data[:size])'
for cut in cut[0-9]*.ply; do
    "$stipple" compare-splats "$cut" square.ply > out 2> err
    [ $? -eq 1 ] && [ ! -s out ] && grep -q "^stipple-lab: " err || fail "$cut: $(cat err)"
done

# the same splats as a .stip, with rounding; whole and in part
"$stipple" -q decimate stone.ply -o stone-psp.stip --splats 90 > out || fail "decimate to a .stip"
"$stipple" check stone-psp.stip > out || fail "the .stip of splats is invalid"
"$stipple" compare-splats stone-psp.stip stone.ply --size 160x160 --json > stip.json || fail "a .stip of splats"
python3 - << 'END' || fail "a .stip gives different figures from the PLY: $(cat stip.json)"
import json
a, b = json.load(open("stone-psp.json")), json.load(open("stip.json"))
for key, part in (("hausdorff_max_percent", 0.03), ("hausdorff_mean_percent", 0.03), ("area_ratio", 0.02), ("ssim", 0.001)):
    assert abs(a[key] - b[key]) <= part * a[key], (key, a[key], b[key])
assert b["splats"] == 90
END
"$stipple" compare-splats stone-psp.stip stone.ply --splats 40 --no-pictures --json > part.json || fail "--splats"
figures part.json 'd["splats"] == 40'
"$stipple" render stone-psp.stip -o whole.png --size 200x200 --json > whole.json || fail "render a .stip of splats"
"$stipple" render stone-psp.stip -o shrunk.png --size 200x200 --splat-scale 0.3 --json > shrunk.json || fail "--splat-scale"
python3 -c 'import json; w, s = (json.load(open(f)) for f in ("whole.json", "shrunk.json")); assert w["listed_splats"] == 90 and w["method"] == "psp" and 0 < s["covered_pixels"] < 0.8 * w["covered_pixels"], (w, s)' ||
    fail "pictures of splats"

# sets from build, of either method: more splats are closer
"$stipple" -q build stone.ply -o stone.stip --method blue,spt --threshold 100 > out || fail "build"
for method in blue spt; do
    for count in 100 1000; do
        "$stipple" compare-splats stone.stip stone.ply --method $method --splats $count --samples 20000 --no-pictures --json > $method$count.json ||
            fail "$method $count"
    done
    python3 - $method << 'END' || fail "$method: $(cat $method*.json)"
import json, sys
few, many = (json.load(open(f"{sys.argv[1]}{n}.json")) for n in (100, 1000))
assert 0 < few["splats"] <= 100 < many["splats"] <= 1000 and few["triangles"] == 0
assert 2 * many["hausdorff_mean_percent"] < few["hausdorff_mean_percent"] < 2 and many["area_ratio"] > 1
END
done
figures blue100.json 'd["splats"] == 100'

# comparison uses the files' axes, not those of scenes: a z-up model is the same model
"$stipple" -q build stone.ply -o turned.stip --up z > out || fail "--up z"
"$stipple" compare-splats stone-psp.ply turned.stip --size 160x160 --json > turned.json || fail "another up axis"
figures turned.json 'd["splats"] == 90'
python3 -c 'import json; a, b = (json.load(open(f)) for f in ("stone-psp.json", "turned.json")); assert all(abs(a[k] - b[k]) < 0.02 * a[k] for k in ("hausdorff_max_percent", "hausdorff_mean_percent", "area_ratio", "ssim")), (a, b)' ||
    fail "another up axis gives different figures: $(cat turned.json)"

# an independent program (GNU Triangulated Surface Library): for ellipses as fans of triangles, and
# for a mesh
if installed gtscompare "agreement with it (Debian: libgts-bin)"; then
    python3 -c 'from files import *; gts("fans.gts", *fans(read_splats("stone-psp.ply")))' || fail "fans"
    "$stipple" compare-splats coarse.ply stone.ply --no-pictures --json > coarse.json || fail "a coarse mesh"
    for pair in "fans dense" "coarse coarse"; do
        set -- $pair
        gtscompare stone.gts "$1.gts" 0.005 > gts.txt 2>&1 < /dev/null || fail "gtscompare"
        python3 - "$2.json" << 'END' || fail "$1: gtscompare finds other distances"
import json, re, sys
d = json.load(open(sys.argv[1]))
text = open("gts.txt").read().split("Distance between faces")[1].split("boundaries")[0]
mean, most = (float(re.search(name + r":\s*(\S+)", text)[1]) * 100 / d["diagonal"] for name in (r"Average", "Maximum"))
# it samples every 0.5 % of the diagonal, so it may miss the maximum by up to the sample spacing
assert -0.02 * most < d["hausdorff_max_percent"] - most < 0.02 * most + 0.5 * 0.71, (most, d)
assert abs(mean - d["hausdorff_mean_percent"]) < 0.02 * mean, (mean, d)
END
    done
fi
exit $((failures > 0))
