#!/usr/bin/env bash
# stipple decimate: splats in a PLY, figures, and sentences where something is wrong. Arguments: executable, scratch folder.
set -u
stipple=$1
# shellcheck source=/dev/null
. "$(dirname "$0")/shared.sh"
mkdir -p "$2" && cd "$2" || exit 1
rm -rf ./*
command -v python3 > /dev/null || exit 77

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
    cmp -s threads.ply normals-lazy.ply || fail "$threads threads give other splats"
done
# as many as there are, and no fewer than can be
"$stipple" -q decimate ball.ply -o all.ply --splats 5000 > out || fail "more splats than points"
check all.ply 3000
# pieces, on any number of threads, give as many
for threads in 1 3; do
    "$stipple" -q decimate ball.ply -o pieces-$threads.ply --splats 200 --piece-size 128 --threads $threads --json > pieces.json || fail "--piece-size"
done
check pieces-1.ply 200
cmp -s pieces-1.ply pieces-3.ply || fail "3 threads give other pieces"
cmp -s pieces-1.ply normals-lazy.ply && fail "--piece-size changes nothing"
python3 -c 'import json; d = json.load(open("pieces.json")); assert d["points_per_second"] > 0 and d["peak_bytes"] > 36000, d' || fail "figures: $(cat pieces.json)"
# two balls far apart: two splats are left, or one where that is asked for
python3 - << 'END'
lines = open("ball.ply").read().replace("vertex 3000", "vertex 6000").splitlines()
body = lines[lines.index("end_header") + 1:]
far = [" ".join([str(float(line.split()[0]) + 1000)] + line.split()[1:]) for line in body]
open("balls.ply", "w").write("\n".join(lines + far) + "\n")
END
count() # FILE
{
    python3 -c 'import sys; print(open(sys.argv[1], "rb").read().split(b"element vertex ")[1].split()[0].decode())' "$1"
}
"$stipple" -q decimate balls.ply -o two.ply --splats 1 --merge-angle 180 > out || fail "two balls"
[ "$(count two.ply)" = 2 ] || fail "expected two splats, got $(count two.ply)"
"$stipple" -q decimate balls.ply -o one.ply --splats 1 --connect > out || fail "--connect"
[ "$(count one.ply)" = 1 ] || fail "expected one splat, got $(count one.ply)"
# too little memory is said, and leaves no file
refused 1 'memory' decimate balls.ply -o little.ply --memory 600K
[ ! -e little.ply ] || fail "a call without memory left a file"
exit $((failures > 0))
