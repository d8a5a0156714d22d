#!/usr/bin/env bash
# stipple order and distribution: files, figures and JSON. Arguments: executable, scratch folder.
# needs: stipple-lab
set -u
stipple=$1
scratch=$2
. "$(dirname "$0")/shared.sh"
mkdir -p "$scratch" && cd "$scratch" || exit 1
# run CODE ARGUMENTS...: stdout to out, stderr to err
run()
{
    local wanted=$1
    shift
    "$stipple" "$@" > out 2> err
    local code=$?
    [ "$code" = "$wanted" ] || fail "$*: exit $code, not $wanted: $(cat err)"
}

# a ball's 4000 points with normals and colours; colours identify the points
python3 - << 'END'
import math, struct
count = 4000
with open("ball.ply", "wb") as f:
    f.write(b"ply\nformat binary_little_endian 1.0\nelement vertex %d\n" % count)
    for name in "x y z nx ny nz".split():
        f.write(b"property float %s\n" % name.encode())
    for name in "red green blue".split():
        f.write(b"property uchar %s\n" % name.encode())
    f.write(b"end_header\n")
    for i in range(count):
        z = 1 - (2 * i + 1) / count
        r, a = math.sqrt(1 - z * z), i * 2.399963
        n = (r * math.cos(a), r * math.sin(a), z)
        f.write(struct.pack("<6f3B", *[2 * v for v in n], *n, i & 255, i >> 8, 7))
END
cat > read.py << 'END'
import struct, sys
data = open(sys.argv[1], "rb").read()
head, body = data.split(b"end_header\n", 1)
names = [line.split()[2].decode() for line in head.splitlines() if line.startswith(b"property")]
assert names == "x y z nx ny nz red green blue alpha".split(), names
points = [struct.unpack_from("<6f4B", body, 28 * i) for i in range(len(body) // 28)]
assert len(points) == int(sys.argv[2]), len(points)
ids = set(p[6] | p[7] << 8 for p in points)
assert len(ids) == len(points), "points repeat"
for p in points:
    assert all(abs(p[k] - 2 * p[3 + k]) < 1e-5 for k in range(3)), "normals do not belong"
END

for order in exact paper-fast paper-text random best-of-k; do
    run 0 order ball.ply -o "$order.ply" --order "$order" --count 1000 --json
    keys=$(python3 -c 'import json; print(*sorted(json.load(open("out"))))')
    [ "$keys" = "candidates count index_ms metric order order_ms threads" ] || fail "keys: $keys"
    [ "$(python3 -c 'import json; d = json.load(open("out")); print(d["order"], d["count"])')" = "$order 1000" ] ||
        fail "figures: $(cat out)"
    python3 read.py "$order.ply" 1000 || fail "$order.ply"
done
run 0 order ball.ply -o all.ply --metric euclidean --threads 1
python3 read.py all.ply 4000 || fail all.ply
run 0 order ball.ply -o again.ply --metric euclidean --threads 2
cmp all.ply again.ply || fail "threads change the order"
grep -q '4000 of 4000 points, exact, euclidean' out || fail "report: $(cat out)"

run 0 distribution random.ply exact.ply --of ball.ply --prefix 100,1000 --plot plot.svg --json
python3 - << 'END' || fail "distribution: $(cat out)"
import json, xml.dom.minidom
d = json.load(open("out"))
keys = ["count", "coverage_max", "coverage_p50", "coverage_p99", "relative_spacing_min", "spacing_median",
        "spacing_min", "uncovered_fraction"]
assert [sorted(p) for p in d["prefixes"]] == [keys, keys]
assert [p["count"] for p in d["prefixes"]] == [100, 1000]
random, exact = [f["prefixes"] for f in d["files"]]
for r, e in zip(random, exact):
    assert e["coverage_max"] < r["coverage_max"] and e["spacing_min"] > r["spacing_min"]
    assert 0.5 < e["relative_spacing_min"] < 1.1 and e["uncovered_fraction"] < 0.01
assert xml.dom.minidom.parse("plot.svg").documentElement.tagName == "svg"
END
run 0 distribution exact.ply
grep -q 'cover max' out || fail "table: $(cat out)"

run 2 order ball.ply
run 2 order -o x.ply
run 2 order ball.ply -o -
run 2 order ball.ply -o ./ball.ply
run 2 distribution
run 2 distribution exact.ply --prefix 10,x
run 1 order missing.ply -o x.ply
[ "$(wc -l < err)" = 1 ] || fail "not exactly one sentence: $(cat err)"
run 1 order ball.ply -o missing/x.ply
run 0 bench order --list
grep -q '^order' out || fail "benchmarks: $(cat out)"
exit $((failures != 0))
