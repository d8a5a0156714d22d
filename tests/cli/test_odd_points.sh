#!/usr/bin/env bash
# build, decimate, compare-splats and thumbnail on unusual point sets: each gives a sensible result
# or one clear sentence. Arguments: executable, scratch folder.
# needs: stipple-lab
set -u
stipple=$1
# shellcheck source=/dev/null
. "$(dirname "$0")/shared.sh"
mkdir -p "$2" && cd "$2" || exit 1
rm -rf ./*
export XDG_CACHE_HOME=$PWD/cache

python3 - << 'END'
def cloud(name, points):
    with open(name + ".ply", "w") as file:
        file.write(f"ply\nformat ascii 1.0\nelement vertex {len(points)}\n")
        file.write("property float x\nproperty float y\nproperty float z\nend_header\n")
        file.write("".join(f"{x} {y} {z}\n" for x, y, z in points))
grid = [(i % 20, 0, i // 20) for i in range(400)]
cloud("none", [])
cloud("one", [(1, 2, 3)])
cloud("two", [(1, 2, 3), (2, 2, 3)])
cloud("same", [(1, 2, 3)] * 50)
cloud("pair", [(1, 2, 3)] * 2)
cloud("line", [(0.1 * i, 0.2 * i, 0) for i in range(200)])
cloud("apart", grid + [(1000, 0, 0), (0, 500, 0)])
cloud("nan", grid + [("nan", "nan", "nan"), ("nan", 1, 2)])
cloud("nans", [("nan", "nan", "nan")] * 5)
cloud("endless", grid + [("inf", 0, 0)])
END
: > zero.ply
: > zero.obj

# whether a file has at most COUNT splats, all with finite numbers
splats() # FILE MOST
{
    python3 - "$1" "$2" << 'END' || fail "$1 is not of at most $2 finite splats"
import math, struct, sys
head, body = open(sys.argv[1], "rb").read().split(b"end_header\n", 1)
count = int(head.split(b"element vertex ")[1].split()[0])
wide = b"property double x" in head
size = (24 if wide else 12) + 7 * 4 + 3
assert 0 < count <= int(sys.argv[2]) and len(body) == count * size, (count, len(body))
for i in range(count):
    f = struct.unpack_from("<3d7f" if wide else "<10f", body, i * size)
    assert all(map(math.isfinite, f)) and f[9] > 0, f
END
}

for name in one two same line apart nan endless; do
    "$stipple" -q decimate $name.ply -o $name-splats.ply --splats 30 --connect > /dev/null 2> err ||
        fail "decimate $name: $(cat err)"
    splats $name-splats.ply 30
    "$stipple" -q decimate $name.ply -o $name-splats.stip --splats 30 > /dev/null 2> err ||
        fail "decimate $name to a .stip: $(cat err)"
done

for name in two line apart nan endless; do
    "$stipple" -q compare-splats $name-splats.ply $name.ply --size 32x32 --json > $name.json 2> err ||
        fail "compare-splats $name: $(cat err)"
    python3 -c 'import json, math, sys; d = json.load(open(sys.argv[1])); assert d["splats"] > 0 and all(math.isfinite(d[k]) for k in ("hausdorff_max_percent", "hausdorff_mean_percent", "diagonal", "ssim")), d' $name.json ||
        fail "figures of $name: $(cat $name.json)"
done
for name in one same; do # a point has no diagonal to measure by
    refused 1 'single point' compare-splats $name-splats.ply $name.ply
done

for name in one two same line apart nan endless; do
    "$stipple" -q thumbnail $name.ply -o $name.png --size 64x64 --json > $name.json 2> err ||
        fail "thumbnail $name: $(cat err)"
    python3 -c 'import json, sys; d = json.load(open(sys.argv[1])); assert d["splats"] > 0, d' $name.json ||
        fail "the thumbnail of $name is empty: $(cat $name.json)"
done

# every method keeps all points at one position
for method in blue spt psp stochastic; do
    for name in one pair same; do
        "$stipple" -q build $name.ply --method $method -o $name.stip > /dev/null 2> err || fail "build $name by $method: $(cat err)"
        "$stipple" -q render $name.stip -o $name.png --size 64x64 --json > $name.json 2> err ||
            fail "render $name by $method: $(cat err)"
        python3 -c 'import json, sys; d = json.load(open(sys.argv[1])); assert d["splats"] > 0, d' $name.json ||
            fail "$name by $method is empty: $(cat $name.json)"
    done
done

for name in none.ply nans.ply zero.ply zero.obj; do
    for command in "decimate $name -o a.ply" "compare-splats $name two.ply" "compare-splats line-splats.ply $name" \
        "thumbnail $name -o a.png"; do
        # shellcheck disable=SC2086
        "$stipple" $command > out 2> err && fail "$command succeeds"
        [ "$(grep '^stipple-lab: ' err | grep -v warning | grep -c "$name: ")" -eq 1 ] || fail "$command says: $(cat err)"
        [ "$(grep -c -v 'without a finite position' err)" -eq 1 ] || fail "$command says more: $(cat err)"
        [ ! -s out ] || fail "$command writes on stdout"
    done
done
for name in none.ply nans.ply; do # an empty scene is no error, but never silent
    "$stipple" build one.ply $name -o a.stip > out 2> err || fail "build $name: $(cat err)"
    [ "$(grep -c "^stipple-lab: warning: $name: has neither triangles nor points" err)" -eq 1 ] ||
        fail "build $name says: $(cat err)"
done
[ ! -e a.ply ] && [ ! -e a.png ] || fail "a refused call left a file"
exit $((failures > 0))
