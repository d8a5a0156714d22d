#!/usr/bin/env bash
# stipple-lab decimate: splats in a PLY, figures, and error messages. Arguments: executable, scratch
# folder.
# needs: stipple-lab
set -u
stipple=$1
# shellcheck source=/dev/null
. "$(dirname "$0")/shared.sh"
mkdir -p "$2" && cd "$2" || exit 1
rm -rf ./*

python3 - << 'END'
import math
with open("ball.ply", "w") as file:
    file.write("ply\nformat ascii 1.0\nelement vertex 3000\n")
    file.write("".join(f"property float {c}\n" for c in ("x", "y", "z", "nx", "ny", "nz")))
    file.write("property uchar red\nproperty uchar green\nproperty uchar blue\nend_header\n")
    for i in range(3000):
        y = 1 - 2 * (i + 0.5) / 3000
        r, a = math.sqrt(1 - y * y), 2.399963229728653 * i
        p = f"{r * math.cos(a):.6f} {y:.6f} {r * math.sin(a):.6f}"
        file.write(f"{p} {p} 200 {100 if y > 0 else 10} 30\n")
END
refused 2 'expected one model' decimate -o a.ply
refused 2 'expected -o' decimate ball.ply
refused 2 'standard output' decimate ball.ply -o -
refused 2 'neither .ply nor .stip' decimate ball.ply -o a.obj
refused 2 'neither .ply nor .stip' decimate ball.ply -o a.splats --by blue
refused 2 'neighbours' decimate ball.ply -o a.ply --neighbours 33
refused 2 'merge-angle' decimate ball.ply -o a.ply --merge-angle 200
refused 2 'octopus' decimate ball.ply -o a.ply --by octopus
refused 1 'missing.ply' decimate missing.ply -o a.ply
[ ! -e a.ply ] || fail "a refused call left a file"

check() # FILE COUNT: splats of a ball, that face out
{
    python3 - "$1" "$2" << 'END' || fail "$1 is not a ball of $2 splats"
import struct, sys
data = open(sys.argv[1], "rb").read()
head, body = data.split(b"end_header\n", 1)
count = int(head.split(b"element vertex ")[1].split()[0])
assert count == int(sys.argv[2]), count
size = 10 * 4 + 3
assert len(body) == count * size
for i in range(count):
    *f, red, green, blue = struct.unpack_from("<10f3B", body, i * size)
    c, n, a, minor = f[0:3], f[3:6], f[6:9], f[9]
    away = sum(x * x for x in c) ** 0.5
    major = sum(x * x for x in a) ** 0.5
    assert 0.6 < away < 1.1 and sum(x * y for x, y in zip(c, n)) > 0.5 * away, (away, n)
    assert 0 < minor <= 1.001 * major < 1.5 and abs(sum(x * y for x, y in zip(a, n))) < 1e-3
    assert red == 200 and blue == 30 and 10 <= green <= 100
END
}
for metric in normals distances; do
    for queue in lazy eager; do
        "$stipple" -q decimate ball.ply -o $metric-$queue.ply --splats 200 --metric $metric --queue $queue --json > $metric.json ||
            fail "decimate --metric $metric --queue $queue"
        check $metric-$queue.ply 200
    done
    cmp -s $metric-lazy.ply $metric-eager.ply || fail "the queue changes splats of $metric"
    python3 -c 'import json, sys; d = json.load(open(sys.argv[1])); assert d["points"] == 3000 and d["splats"] == 200 and 8 < d["area"] < 90, d' $metric.json ||
        fail "figures of $metric: $(cat $metric.json)"
done
cmp -s normals-lazy.ply distances-lazy.ply && fail "the metric changes nothing"
for threads in 1 3; do
    "$stipple" -q decimate ball.ply -o threads.ply --splats 200 --threads $threads > out || fail "--threads $threads"
    cmp -s threads.ply normals-lazy.ply || fail "$threads threads give different splats"
done
# the methods for comparison with psp
refused 2 'need --by psp' decimate ball.ply -o a.ply --by octree --metric distances
refused 2 'need --by psp' decimate ball.ply -o a.ply --by blue --neighbours 4
refused 2 'need --by psp' decimate ball.ply -o a.ply --by octree --connect
refused 2 'need --by psp' decimate ball.ply -o a.ply --by quadric --piece-size 100
refused 1 'expected triangles' decimate ball.ply -o a.ply --by mesh
[ ! -e a.ply ] || fail "a refused call left a file"
for by in octree octree-level quadric blue; do
    "$stipple" -q decimate ball.ply -o $by.ply --splats 200 --by $by --json > $by.json || fail "decimate --by $by"
    count=$(python3 -c 'import json, sys; d = json.load(open(sys.argv[1])); print(d["splats"]); assert d["by"] == sys.argv[2] and d["points"] == 3000 and 8 < d["area"] < 130 and "surface" not in d, d' $by.json $by) ||
        fail "figures of $by: $(cat $by.json)"
    case $by in
    octree) [ "$count" -le 200 ] && [ "$count" -ge 194 ] ;;
    octree-level) [ "$count" -gt 50 ] && [ "$count" -lt 400 ] ;;
    *) [ "$count" -eq 200 ] ;;
    esac || fail "$by makes $count splats, not 200"
    check $by.ply "$count"
    "$stipple" -q decimate ball.ply -o threads.ply --splats 200 --by $by --threads 1 > out || fail "$by with one thread"
    grep -q "^$count splats for 3000 points" out || fail "$by prints $(cat out)"
    cmp -s threads.ply $by.ply || fail "one thread gives different splats with $by"
done
"$stipple" order ball.ply -o ordered.ply --count 200 > out || fail "order"
python3 - << 'END' || fail "blue does not take the first points of the order"
import struct
def points(path, size):
    head, body = open(path, "rb").read().split(b"end_header\n", 1)
    count = int(head.split(b"element vertex ")[1].split()[0])
    assert len(body) % count == 0 and (size == 0 or len(body) == count * size)
    return [struct.unpack_from("<3f", body, i * (len(body) // count)) for i in range(count)]
assert points("blue.ply", 43) == points("ordered.ply", 0)
END
python3 - << 'END' # a bent sheet
with open("sheet.obj", "w") as file:
    for i in range(900):
        file.write(f"v {i % 30} {i // 30} {(i % 30) ** 2 / 100}\n")
    for i in range(870):
        if i % 30 < 29:
            file.write(f"f {i + 1} {i + 2} {i + 32}\nf {i + 1} {i + 32} {i + 31}\n")
END
"$stipple" -q decimate sheet.obj -o mesh.ply --splats 100 --by mesh --json > mesh.json || fail "decimate --by mesh"
python3 - << 'END' || fail "the figures of mesh are wrong: $(cat mesh.json)"
import json, struct
figures = json.load(open("mesh.json"))
head, body = open("mesh.ply", "rb").read().split(b"end_header\n", 1)
vertices, faces = (int(head.split(b"element %b " % e)[1].split()[0]) for e in (b"vertex", b"face"))
assert figures["by"] == "mesh" and figures["points"] == 900 and figures["splats"] == 0, figures
assert figures["vertices"] == vertices and abs(vertices - 100) <= 3 and figures["triangles"] == faces, figures
assert abs(figures["area"] / figures["surface"] - 1) < 0.02 and 841 < figures["surface"] < 1100, figures
assert len(body) == vertices * 15 + faces * 13
points = [struct.unpack_from("<3f", body, 15 * i) for i in range(vertices)]
for i in range(faces):
    count, *corners = struct.unpack_from("<B3I", body, 15 * vertices + 13 * i)
    a, b, c = (points[k] for k in corners)  # fails beyond the last vertex
    assert count == 3 and (b[0] - a[0]) * (c[1] - a[1]) > (c[0] - a[0]) * (b[1] - a[1]), (a, b, c)  # faces up
END
"$stipple" info mesh.ply > out || fail "a mesh that was written cannot be read"
# at most the number of points, at least the number of separate pieces
"$stipple" -q decimate ball.ply -o all.ply --splats 5000 > out || fail "more splats than points"
check all.ply 3000
# pieces give the same number, with any number of threads
for threads in 1 3; do
    "$stipple" -q decimate ball.ply -o pieces-$threads.ply --splats 200 --piece-size 128 --threads $threads --json > pieces.json || fail "--piece-size"
done
check pieces-1.ply 200
cmp -s pieces-1.ply pieces-3.ply || fail "3 threads give different pieces"
cmp -s pieces-1.ply normals-lazy.ply && fail "--piece-size changes nothing"
python3 -c 'import json; d = json.load(open("pieces.json")); assert d["points_per_second"] > 0 and d["peak_bytes"] > 36000, d' || fail "figures: $(cat pieces.json)"
# two balls far apart: two splats remain, or one with --connect
python3 - << 'END'
lines = open("ball.ply").read().replace("vertex 3000", "vertex 6000").splitlines()
body = lines[lines.index("end_header") + 1:]
far = [" ".join([str(float(line.split()[0]) + 1000)] + line.split()[1:]) for line in body]
open("balls.ply", "w").write("\n".join(lines + far) + "\n")
END
count() # FILE
{
    grep -a -m 1 -oE 'element vertex [0-9]+' "$1" | tr -dc 0-9
}
"$stipple" -q decimate balls.ply -o two.ply --splats 1 --merge-angle 180 > out || fail "two balls"
[ "$(count two.ply)" = 2 ] || fail "expected two splats, got $(count two.ply)"
"$stipple" -q decimate balls.ply -o one.ply --splats 1 --connect > out || fail "--connect"
[ "$(count one.ply)" = 1 ] || fail "expected one splat, got $(count one.ply)"
# points that exceed the memory limit go to files: the same splats, by any metric, and for any form
# of the folder
python3 - << 'END'
import math, random, struct
chance = random.Random(5)
with open("many.ply", "wb") as file:
    names = "".join(f"property float {c}\n" for c in ("x", "y", "z", "nx", "ny", "nz")) + "".join(f"property uchar {c}\n" for c in ("red", "green", "blue"))
    file.write(f"ply\nformat binary_little_endian 1.0\nelement vertex 90000\n{names}end_header\n".encode())
    for i in range(90000):
        x, y = 100 * chance.random(), 100 * chance.random()
        z = 3 * math.sin(0.2 * x) * math.sin(0.3 * y)
        file.write(struct.pack("<6f3B", x, y, z, 0, 0, 1, int(2 * x), int(2 * y), 9))
END
# without normals the sides of splats are unknown, and prevent no merge
sed '1,/end_header/d' ball.ply | cut -d ' ' -f 1-3 > ball.xyz
for metric in normals distances; do
    area=''
    for file in ball.ply ball.xyz; do
        "$stipple" -q decimate $file -o sides.ply --splats 30 --metric $metric --json > sides.json || fail "decimate $file"
        area="$area $(python3 -c 'import json; print("%.3g" % json.load(open("sides.json"))["area"])')"
    done
    # shellcheck disable=SC2086 # two words
    set -- $area
    [ "$1" = "$2" ] || fail "--metric $metric: area $1 with normals, $2 without"
done
# the record of merges: a base set of 100 splats, and the states of all other counts
refused 2 'record needs a name' decimate ball.ply -o a.ply --record
refused 2 'record.* need --by psp' decimate ball.ply -o a.stip --record --by blue
for metric in normals distances; do
    "$stipple" -q decimate ball.ply -o record.stip --splats 100 --metric $metric --record --json > record.json || fail "--record"
    [ "$(value record.json splats)" = 100 ] || fail "a record of 100 splats: $(cat record.json)"
    "$stipple" -q check record.stip || fail "the record of $metric is wrong"
    "$stipple" -q render record.stip -o base.png --size 160x120 --once --json > base.json || fail "render record.stip"
    [ "$(value base.json listed_splats)" = 100 ] || fail "the base set is drawn as $(value base.json listed_splats) splats"
    for count in 100 101 700; do
        "$stipple" -q decimate ball.ply -o state.stip --splats $count --metric $metric > out || fail "decimate to $count"
        "$stipple" -q render state.stip -o state.png --size 160x120 --once --eye 1,2,3 --target 0,0,0 || fail "render state.stip"
        "$stipple" -q render record.stip -o part.png --size 160x120 --splats $count --once --eye 1,2,3 --target 0,0,0 --json > part.json || fail "--splats $count of a record"
        [ "$(value part.json splats)" = $count ] || fail "$count splats of a record: $(cat part.json)"
        "$stipple" compare part.png state.png --json > compare.json
        holds "$(value compare.json ssim) > 0.995" || fail "$metric, $count splats: $(cat compare.json)"
    done
done
mkdir -p spills
for metric in normals distances; do
    "$stipple" -q decimate many.ply -o whole-$metric.ply --splats 500 --metric $metric > out || fail "many points"
    for threads in 1 2; do
        "$stipple" -q decimate many.ply -o spills/$metric.ply --splats 500 --metric $metric --memory 6M --threads $threads --json > spilled.json ||
            fail "$metric in 6 MB by $threads threads"
        cmp -s whole-$metric.ply spills/$metric.ply || fail "$metric: $threads threads give different splats where memory is small"
        [ "$(value spilled.json peak_bytes)" -le $((6 << 20)) ] || fail "peak: $(cat spilled.json)"
    done
done
[ "$(ls spills)" = "$(printf 'distances.ply\nnormals.ply')" ] || fail "files are left: $(ls spills)"
refused 1 'cannot create a temporary file' decimate many.ply -o missing/a.ply --memory 6M
# a full disk is reported once
(
    ulimit -f 3000
    "$stipple" -q decimate many.ply -o spills/full.ply --splats 500 --memory 6M
) > out 2> full.txt && fail "a full disk is ignored"
[ "$(wc -l < full.txt)" = 1 ] && grep -q 'no room for .* of temporary data' full.txt || fail "a full disk: $(cat full.txt)"
[ "$(ls spills | wc -l)" = 2 ] || fail "a full disk leaves files: $(ls spills)"
# too little memory is reported, and leaves no file
refused 1 'memory' decimate balls.ply -o little.ply --memory 600K
[ ! -e little.ply ] || fail "a call without memory left a file"
exit $((failures > 0))
