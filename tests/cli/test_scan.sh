#!/usr/bin/env bash
# stipple-lab scan: the same points in each format, with any number of threads, from scenes, models and
# .stip files; errors. Arguments: executable, scratch folder, source folder.
# needs: stipple-lab
set -u
stipple=$1
# shellcheck source=/dev/null
. "$(dirname "$0")/shared.sh"
readers=$(cd "$(dirname "$0")" && pwd)/scan_files.py
mkdir -p "$2" && cd "$2" || exit 1
rm -rf ./*
export XDG_CACHE_HOME=$PWD/cache

refused 2 'needs one scene' scan -o a.las
refused 2 'needs -o' scan scene:boxes
refused 2 'a.xyz' scan scene:boxes -o a.xyz
refused 2 'needs a .ply' scan scene:boxes -o a.las --truth
refused 2 'exclude each other' scan scene:boxes -o a.las --stations 2 --station 0,0,1
refused 2 'X,Y,Z' scan scene:boxes -o a.las --station 1,2
refused 2 'stations' scan scene:boxes -o a.las --stations 0
refused 2 'stations' scan scene:boxes -o a.las --stations 257
refused 2 'resolution' scan scene:boxes -o a.las --resolution 0
refused 2 'noise' scan scene:boxes -o a.las --noise -1
refused 1 'missing.obj' scan missing.obj -o a.las
refused 1 'no scene' scan scene:nothing -o a.las
refused 1 'nowhere' scan scene:boxes -o nowhere/a.las --resolution 10
printf 'ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nproperty float y\nproperty float z\nend_header\n1 2 3\n' > one.ply
refused 1 'needs triangles' scan one.ply -o a.las
cp one.ply before.ply
refused 2 'one.ply' scan one.ply -o one.ply
cmp -s one.ply before.ply || fail "the model was written over"
refused 1 'memory' scan scene:boxes -o a.las --memory 1M
[ ! -e a.las ] || fail "a refused call left a file"

# each format holds the same points, read according to its specification only
for ending in las ptx ply e57; do
    "$stipple" -q scan scene:boxes --stations 3 --resolution 2 --seed 4 -o boxes.$ending --json > boxes.json ||
        fail "$ending"
done
python3 "$readers" boxes boxes.json || fail "formats"
"$stipple" -q scan scene:boxes --stations 2 --resolution 3 --shift 389000.5,5820000,34 -o far.las --json > far.json || fail "--shift"
for ending in ptx ply e57; do
    "$stipple" -q scan scene:boxes --stations 2 --resolution 3 --shift 389000.5,5820000,34 -o far.$ending || fail "--shift $ending"
done
python3 "$readers" far far.json || fail "formats with --shift"

for ending in las ptx ply e57; do
    "$stipple" -q scan scene:boxes --airborne --stations 2 --resolution 1 -o air.$ending --json > air.json || fail "--airborne $ending"
done
python3 "$readers" air air.json air || fail "formats from the air"
refused 2 'excludes --station' scan scene:boxes -o a.las --airborne --station 0,0,9
refused 1 'resolution' scan scene:boxes -o a.las --airborne --resolution 0.01 --height 0.001

# the same bytes with any number of threads; different ones with another seed
for threads in 1 3; do
    for ending in las e57; do
        "$stipple" -q scan scene:boxes --stations 3 --resolution 2 --seed 4 -o again.$ending --threads $threads || fail "--threads"
        cmp -s again.$ending boxes.$ending || fail "$threads threads give another .$ending"
    done
done
"$stipple" -q scan scene:boxes --stations 3 --resolution 2 --seed 5 -o again.las || fail "--seed"
! cmp -s again.las boxes.las || fail "--seed changes nothing"

# a cube's faces from within, with the truth; from a z-up scene in millimetres
python3 - << 'END'
corners = [(x, y, z) for x in (-2000, 2000) for y in (-3000, 3000) for z in (0, 4000)]
faces = [(0, 1, 3, 2), (4, 5, 7, 6), (0, 1, 5, 4), (2, 3, 7, 6), (0, 2, 6, 4), (1, 3, 7, 5)]
with open("room.obj", "w") as file:
    for c in corners:
        file.write("v %d %d %d\n" % c)
    for f in faces:
        file.write("f %d %d %d %d\n" % tuple(i + 1 for i in f))
corners = [(x, y, z) for x in (-2000, 2000) for y in (-3000, 3000) for z in (0, 4000)]
faces = [(0, 1, 3, 2), (4, 5, 7, 6), (0, 1, 5, 4), (2, 3, 7, 6), (0, 2, 6, 4), (1, 3, 7, 5)]
with open("room.obj", "w") as file:
    for c in corners:
        file.write("v %d %d %d\n" % c)
    for f in faces:
        file.write("f %d %d %d %d\n" % tuple(i + 1 for i in f))
END
"$stipple" -q build room.obj -o room.stip --up z --unit mm || fail "build"
"$stipple" -q scan room.stip --station 0.5,-1,1.5 --noise 0.01 --resolution 120 --truth -o room.ply --json > room.json || fail "room"
python3 - "$readers" << 'END' || fail "the room"
import json, math, os, sys
sys.path.insert(0, os.path.dirname(sys.argv[1]))
sys.dont_write_bytecode = True
from scan_files import read_ply
d, points = json.load(open("room.json")), read_ply("room.ply")
assert d["misses"] == 0 and d["points"] == len(points) == 120 * 50 and d["station_positions"] == [[0.5, -1, 1.5]], d
inside = ((-2, 2), (-3, 3), (0, 4))
for p in points:
    place, eye = [p[k] for k in "xyz"], (0.5, -1, 1.5)
    far = math.dist(place, eye)
    true = [e + (a - e) * (far - p["range_error"]) / far for a, e in zip(place, eye)]
    normal = (p["nx"], p["ny"], p["nz"])
    k = max(range(3), key=lambda i: abs(normal[i]))
    assert abs(abs(normal[k]) - 1) < 1e-6 and abs(p["range_error"]) <= 0.06
    side = inside[k][0] if normal[k] > 0 else inside[k][1]
    assert abs(true[k] - side) < 1e-4 and all(lo - 1e-3 <= v <= hi + 1e-3 for v, (lo, hi) in zip(true, inside)), (true, normal)
mean = sum(p["range_error"] for p in points) / len(points)
deviation = math.sqrt(sum(p["range_error"] ** 2 for p in points) / len(points))
assert abs(mean) < 0.0006 and 0.0095 < deviation < 0.0105, (mean, deviation)
END
"$stipple" scan room.stip --station 0.5,-1,1.5 --range 0.5 -o none.las --json > none.json 2> none.err || fail "nothing near"
grep -q 'no ray hit' none.err || fail "an empty scan is not named: $(cat none.err)"
python3 -c 'import json; d = json.load(open("none.json")); assert d["points"] == 0 and d["bounds"] is None, d' || fail "$(cat none.json)"

# numbers of any length are written in full
"$stipple" -q scan room.stip --resolution 20 --shift 1e300,-1e300,1e300 -o far.ptx || fail "a far scan"
python3 - << 'END' || fail "the far scan"
lines = open("far.ptx").read().split("\n")
assert [float(v) for v in lines[2].split()] == [1e300, -1e300, 1e300] and lines[5] == "0 0 1", lines[:10]
assert [float(v) for v in lines[9].split()] == [1e300, -1e300, 1e300, 1] and lines[10].count(" ") == 6, lines[9:11]
END

# a build of a scan shows the scene
"$stipple" -q build boxes.ply -o boxes.stip --up z || fail "build of a scan"
"$stipple" info boxes.stip --json > info.json || fail "info"
python3 -c 'import json; assert json.load(open("info.json"))["points"] == json.load(open("boxes.json"))["points"]' || fail "points"
exit $((failures > 0))
