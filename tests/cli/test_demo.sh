#!/usr/bin/env bash
# scripts/demo: a single model, and the plant made from it; without the build before it. Arguments:
# executable, scratch folder, source folder.
# needs: stipple-lab
set -u
stipple=$1
scratch=$2
source=$3
rm -rf "$scratch"
. "$(dirname "$0")/shared.sh"
mkdir -p "$scratch/scripts" "$scratch/bin" "$scratch/build/release/program" && cd "$scratch" || exit 1
cp "$source"/scripts/demo "$source"/scripts/demo.py "$source"/scripts/make_plant.py scripts
printf '#!/bin/sh\nexit 0\n' | tee scripts/setup > bin/cmake
chmod +x scripts/setup bin/cmake
ln -s "$stipple" build/release/program/stipple
export XDG_CACHE_HOME=$PWD/cache

"$stipple" scene boxes -o boxes.glb -q > /dev/null || fail "boxes"
PATH=$PWD/bin:$PATH scripts/demo boxes.glb > out 2> err || fail "demo of a model: $(cat err)"
for row in "^boxes.glb .* triangles" "^frame time, median .* ms .* ms" "^truth .*[01]\.[0-9]* .*1$" \
    "^truth, both filtered .*[01]\.[0-9]* .*1$" \
    "^memory, peak .* MB .* MB" "^far .* ms, SSIM .* ms, SSIM [01]\.[0-9]* .* ms$" "^near .* SSIM " \
    "^beside .* SSIM " "^contact sheet .*build/demo/sheet.png"; do
    grep -q -- "$row" out || fail "the demo does not print $row: $(cat out)"
done
"$stipple" compare build/demo/sheet.png build/demo/sheet.png > sheet || fail "the sheet is no picture"
for view in far near beside; do
    for picture in splats nearest triangles; do
        [ -s "build/demo/$view-$picture.png" ] || fail "the picture $view-$picture is missing"
    done
done
PATH=$PWD/bin:$PATH scripts/demo missing.glb > out 2> err && fail "a demo without a model succeeds"
grep -q "missing.glb: no such file" err || fail "a missing model is not named: $(cat err)"

# the plant: 200 machines of 27 boxes a hall, on shelves and a floor
scripts/make_plant.py boxes.glb plant.glb flight.json 300 > out || fail "plant"
grep -qx "400 machines in 2 halls" out || fail "machines are not rounded up to halls: $(cat out)"
"$stipple" info plant.glb --json > plant.json || fail "the plant cannot be read"
"$stipple" info boxes.glb --json > boxes.json
python3 - << 'END' || fail "the plant does not hold its machines"
import json
plant, boxes = json.load(open("plant.json")), json.load(open("boxes.json"))
slabs = 2 * 5 * 3 + 1
assert plant["triangles"] == 400 * boxes["triangles"] + 12 * slabs, (plant["triangles"], boxes["triangles"])
low, high = plant["bounds"]["min"], plant["bounds"]["max"]
for key in json.load(open("flight.json"))["keys"]:
    assert all(abs(value) < 10 * (h - l) + 1e6 for value, l, h in zip(key["eye"], low, high))
END

# the nearest triangles: of a file that is too slow as a whole, a part within the budget
"$stipple" build plant.glb -o plant.stip -q || fail "the plant cannot be built"
python3 - "$stipple" << 'END' || fail "the nearest triangles"
import json, math, pathlib, subprocess, sys
sys.path.insert(0, "scripts")
sys.dont_write_bytecode = True
import demo
key = json.load(open("flight.json"))["keys"][3]
view = ["--eye", ",".join(map(str, key["eye"])), "--target", ",".join(map(str, key["target"]))]

def draw(picture, *options):
    """A frame takes as many milliseconds as it has thousands of triangles."""
    figures, _ = demo.run([sys.argv[1], "render", "plant.stip", "--size", "64x36", "--json", "-q", "--once", *view,
                          "-o", picture, *options])
    return {**figures, "frame_ms": figures["triangles"] / 1000}

whole = draw(pathlib.Path("whole.png"), "--reference")
bounds = json.loads(subprocess.run([sys.argv[1], "info", "plant.stip", "--json"], stdout=subprocess.PIPE).stdout)["bounds"]
reach = math.dist(bounds["min"], bounds["max"])
limit = whole["frame_ms"] / 4
some = demo.draw_nearest(draw, pathlib.Path("nearest.png"), key["eye"], reach, limit)
assert 0.3 * limit < some["frame_ms"] <= limit, (some["frame_ms"], limit)
assert pathlib.Path("nearest.png").exists() and not list(pathlib.Path(".").glob("*.trial.png"))
nothing = demo.draw_nearest(draw, pathlib.Path("nearest.png"), key["eye"], reach, 0)
assert nothing["triangles"] == 0, nothing
END
exit $((failures > 0))
