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
# points far from the rest of a cloud are named, and do not shrink it
python3 - << 'END'
places = [(500000 + i % 40 / 4, 4500000 + i // 40 / 4, 100) for i in range(1600)]
for name, strays in ("clean", []), ("stray", [(0, 0, 0)]), ("strays", [(0, 0, 0), (1e6, 2e6, 0), (7e5, 5e6, 10)]):
    with open(f"{name}.xyz", "w") as file:
        file.writelines("%.2f %.2f %.2f\n" % place for place in strays + places)
END
for name in clean stray strays; do
    "$stipple" build $name.xyz -o $name.stip --unit m 2> $name.log || fail "no build of $name"
    "$stipple" -q render $name.stip -o $name.png --size 96x72 --json > $name.json || fail "render $name"
    [ "$(value $name.json covered_pixels)" = "$(value clean.json covered_pixels)" ] || fail "$name shrinks the cloud"
done
"$stipple" -q thumbnail strays.xyz -o far.png --size 80x80 || fail "thumbnail of a cloud with strays"
python3 -c 'from read_png import covered
margins = covered("far.png")
assert max(margins[:2]) < 0.1, margins' || fail "strays shrink a thumbnail"
grep -q "1 point lies up to 4528 km from the rest" stray.log || fail "the stray is not named: $(cat stray.log)"
grep -q "3 points lie up to .* km from the rest" strays.log || fail "the strays are not named: $(cat strays.log)"
! grep -q "from the rest" clean.log || fail "strays of a clean cloud"
# a camera given by --eye has the field of view it always had
"$stipple" -q render mast.obj -o placed.png --eye 5,5,5 --size 32x32 --json > placed.json || fail "placed"
[ "$(value placed.json fov)" = 60.0 ] || fail "--eye: fov $(value placed.json fov)"
[ $failures -eq 0 ]
