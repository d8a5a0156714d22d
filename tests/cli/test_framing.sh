#!/usr/bin/env bash
# Pictures without a chosen camera show what there is in their middle, whatever its bounds. Arguments:
# executable, scratch folder.
set -u
stipple=$1
scratch=$2
. "$(dirname "$0")/shared.sh"
PYTHONPATH=$(cd "$(dirname "$0")" && pwd)
export PYTHONPATH PYTHONDONTWRITEBYTECODE=1
mkdir -p "$scratch" && cd "$scratch" || exit 1
rm -f ./*.png

# a mast on a plate: seven of the eight corners of its bounds are empty
cat > mast.obj << 'END'
v 0 0 0
v 4 0 0
v 0 0 4
v 0.1 3 0
f 1 2 3
f 1 4 2
f 1 3 4
f 2 4 3
END
for view in iso front right d3; do
    "$stipple" -q render mast.obj -o "$view.png" --view $view --size 96x72 || fail "view $view"
    "$stipple" -q thumbnail mast.obj -o "small_$view.png" --view $view --size 80x80 || fail "thumbnail of $view"
done
"$stipple" -q build mast.obj -o mast.stip || fail "no build"
"$stipple" -q thumbnail mast.stip -o small_stored.png --size 80x80 || fail "thumbnail of a .stip"
"$stipple" -q render mast.obj -o parallel.png --ortho 1 --size 60x96 || fail "parallel"
"$stipple" -q render mast.obj -o default.png --size 96x72 --json > default.json || fail "default"
cmp -s default.png iso.png || fail "the default view is not iso"
python3 - << 'END' || fail "framing"
import glob, json, math
from read_png import covered
for path in sorted(glob.glob("*.png")):
    left, right, top, bottom = covered(path)
    assert abs(left - right) < 0.035 and abs(top - bottom) < 0.035, (path, left, right, top, bottom)
    assert 0.02 < min(left, top) < 0.06, (path, left, right, top, bottom)
camera = json.load(open("default.json"))["camera"]
toward = [e - t for e, t in zip(camera["eye"], camera["target"])]
assert abs(math.degrees(math.asin(toward[1] / math.dist(toward, [0, 0, 0]))) - 35.2644) < 1e-3, camera
assert camera["fov"] == 40, camera
END
# a camera given by --eye has the field of view it always had
"$stipple" -q render mast.obj -o placed.png --eye 5,5,5 --size 32x32 --json > placed.json || fail "placed"
[ "$(value placed.json fov)" = 60.0 ] || fail "--eye: fov $(value placed.json fov)"
[ $failures -eq 0 ]
