#!/usr/bin/env bash
# stipple render: pictures, figures and refusals. Arguments: executable, scratch folder.
# needs: stipple-lab
set -u
stipple=$1
scratch=$2
. "$(dirname "$0")/shared.sh"
mkdir -p "$scratch" && cd "$scratch" || exit 1

"$stipple" build scene:boxes -o boxes.stip --fresh 2> err > /dev/null || fail "boxes: $(cat err)"
file=boxes.stip
rm -f a.png
"$stipple" render "$file" -o a.png --size 80x60 --json > a.json 2> err || fail "render: $(cat err)"
[ ! -s err ] || fail "messages: $(cat err)"
python3 - << 'END' || fail "figures or picture"
import json, struct
figures = json.load(open("a.json"))
expected = """backend device width height splat_size resolution frame_ms select_ms draw_ms shade_ms splats fragments clusters
listed_splats listed_triangles truncated file_bytes whole_bytes drawn triangles nodes draw_calls resident_bytes covered_pixels layers gl samples
accumulated_frames picture_ms method coarse_method color range camera""".split()
assert sorted(figures) == sorted(expected), figures
assert (figures["backend"], figures["width"], figures["height"]) == ("cpu", 80, 60)
assert (figures["samples"], figures["accumulated_frames"]) == (16, 16), figures
data = open("a.png", "rb").read()
assert data[:8] == b"\x89PNG\r\n\x1a\n" and struct.unpack(">II", data[16:24]) == (80, 60)
END
for view in front back left right top bottom iso d0 d25; do
    "$stipple" render "$file" -o "$view.png" --view "$view" --size 32x32 || fail "view $view"
done
"$stipple" render "$file" -o - --size 32x32 > stdout.png || fail "to standard output"
cmp -s stdout.png iso.png || fail "standard output gets a different picture"
"$stipple" render "$file" -o threads.png --size 32x32 --threads 1 || fail "--threads"
cmp -s threads.png iso.png || fail "threads change the picture"
# useless threads get no picture of their own: 1024 of these would take 8 GB
"$stipple" render "$file" -o large.png --size 1024x1024 --once || fail "large"
"$stipple" render "$file" -o threads.png --size 1024x1024 --once --threads 1024 --memory 1536M || fail "1024 threads"
cmp -s threads.png large.png || fail "1024 threads change the picture"
"$stipple" render "$file" -o effects.png --size 48x48 --eye-dome --ambient-occlusion=6 --accumulate 4 || fail "effects"
cmp -s effects.png iso.png && fail "effects change nothing"
"$stipple" render "$file" -o effects2.png --size 48x48 --eye-dome 1 --ambient-occlusion 6 --supersample 2 --threads 1 || fail "effects, again"
cmp -s effects.png effects2.png || fail "four accumulated frames are not --supersample 2"
"$stipple" render "$file" -o one.png --size 32x32 --accumulate 1 || fail "one frame"
"$stipple" render "$file" -o size1.png --size 32x32 --splat-size 1 --json > size1.json || fail "size 1"
cmp -s one.png size1.png || fail "one accumulated frame is not the picture"
grep -q '"samples": 1,' size1.json || fail "--splat-size has more than a sample a pixel: $(cat size1.json)"
# without a quality option, a picture is antialiased
"$stipple" render "$file" -o sixteen.png --size 32x32 --splat-size 1 --accumulate 16 --json > sixteen.json || fail "16 samples"
cmp -s sixteen.png iso.png || fail "a still is not the mean of 16 samples"
grep -q '"samples": 16,' sixteen.json || fail "--accumulate 16 is not 16 samples: $(cat sixteen.json)"
for processor in baseline avx2; do
    STP_PROCESSOR=$processor "$stipple" render "$file" -o p.png --size 48x48 --eye-dome --ambient-occlusion=6 --supersample 2 || fail "effects, $processor"
    cmp -s p.png effects.png || fail "$processor changes effects"
    STP_PROCESSOR=$processor "$stipple" render "$file" -o p.png --size 32x32 || fail "$processor"
    cmp -s p.png iso.png || fail "$processor changes the picture"
done
"$stipple" render "$file" -o e.png --eye 9,9,9 --target 0,0,0 --up 0,0,1 --fov 40 --size 32x32 --supersample 2 \
    --light head --background 336699 --splat-size 2 --policy paper || fail "options"

# a model is built into the cache once
python3 - << 'END' || exit 1
import struct
with open("ball.obj", "w") as out:
    from math import sin, cos, pi
    n = 24
    for i in range(n + 1):
        for k in range(2 * n):
            a, b = pi * i / n, pi * k / n
            out.write(f"v {sin(a) * cos(b):.6f} {cos(a):.6f} {sin(a) * sin(b):.6f}\n")
    for i in range(n):
        for k in range(2 * n):
            p = [i * 2 * n + k, i * 2 * n + (k + 1) % (2 * n), (i + 1) * 2 * n + (k + 1) % (2 * n), (i + 1) * 2 * n + k]
            out.write("f " + " ".join(str(x + 1) for x in p) + "\n")
END
export XDG_CACHE_HOME=$PWD/cache
rm -rf cache
"$stipple" render ball.obj -o ball.png --size 64x64 -q || fail "a model"
[ "$(ls cache/stipple | wc -l)" -eq 1 ] || fail "the cache holds $(ls cache/stipple)"
"$stipple" build ball.obj -o fine.stip --surfels 1000 --surfel-ratio 0.001 -q || fail "many surfels" # enough to overlap in a pixel
"$stipple" render fine.stip -o plain.png --size 48x48 --splats 500 -q || fail "no filter"
"$stipple" render fine.stip -o blended.png --size 48x48 --splats 500 --filter ewa -q || fail "filter"
"$stipple" render fine.stip -o p.png --size 48x48 --splats 500 --filter ewa --threads 1 -q || fail "filter, one thread"
cmp -s p.png blended.png || fail "threads change the filter"
cmp -s plain.png blended.png && fail "the filter changes nothing"
for processor in baseline avx2; do
    STP_PROCESSOR=$processor "$stipple" render fine.stip -o p.png --size 48x48 --splats 500 --filter ewa -q || fail "filter, $processor"
    cmp -s p.png blended.png || fail "$processor changes the filter"
done
"$stipple" render ball.obj -o again.png --size 64x64 -v 2> err || fail "a model again"
grep -q "from the cache" err || fail "built twice: $(cat err)"
cmp -s ball.png again.png || fail "the cache changes the picture"
"$stipple" render ball.obj -o small.png --size 64x64 --splats 200 --json > small.json || fail "splats of a model"
grep -q '"splats": 200' small.json || fail "exactly 200 splats: $(cat small.json)"
grep -q '"drawn": "splats"' small.json || fail "drawn content: $(cat small.json)"
echo "v 9 9 9" >> ball.obj
"$stipple" render ball.obj -o third.png --size 64x64 -q || fail "a changed model"
[ "$(ls cache/stipple | wc -l)" -eq 2 ] || fail "a changed model was not built"
head -c 100 "$file" > "cache/stipple/$(ls cache/stipple | head -n 1)"
head -c 100 "$file" > "cache/stipple/$(ls cache/stipple | tail -n 1)"
"$stipple" render ball.obj -o fourth.png --size 64x64 -q 2> err || fail "a damaged cache: $(cat err)"
cmp -s third.png fourth.png || fail "a damaged cache changes the picture"
for cached in cache/stipple/*; do # the same with a header that is whole
    size=$(stat -c %s "$cached")
    printf '\377\377\377\377' | dd of="$cached" bs=1 seek=$((size - 2000)) conv=notrunc 2> /dev/null
done
"$stipple" render ball.obj -o fifth.png --size 64x64 -q 2> err || fail "a damaged block: $(cat err)"
cmp -s third.png fifth.png || fail "a damaged block changes the picture"
# without need for splats, the build omits them, in a separate file, until they are needed
rm -rf cache
sheet=scene:one-mesh,scale=0.15
"$stipple" render ball.obj -o original.png --size 64x64 --reference --json > original.json || fail "--reference of a model"
grep -q '"splats": 0' original.json || fail "--reference draws splats: $(cat original.json)"
grep -q '"drawn": "triangles"' original.json || fail "drawn content: $(cat original.json)"
ls cache/stipple/*-originals.stip > /dev/null || fail "--reference made $(ls cache/stipple)"
"$stipple" render ball.obj -o splats.png --size 64x64 --splats 200 --json > small.json || fail "splats after --reference"
grep -q '"splats": 200' small.json || fail "no splats after --reference: $(cat small.json)"
"$stipple" render "$sheet" -o quick.png --size 16x16 --json > quick.json || fail "a large model"
grep -q '"splats": 0' quick.json || fail "a large model got splats first: $(cat quick.json)"
"$stipple" render "$sheet" -o quick.png --size 16x16 --json -v > quick.json 2> err || fail "a large model again"
grep -q "from the cache.*-picture.stip" err || fail "a picture is built twice: $(cat err)"
"$stipple" render "$sheet" -o quick.png --size 16x16 --splats 100 --json > quick.json || fail "splats of a large model"
grep -q '"splats": 100' quick.json || fail "no splats of a large model: $(cat quick.json)"
"$stipple" render "$sheet" -o quick.png --size 16x16 -v --json > quick.json 2> err || fail "a large model, third"
grep -q "picture.stip" err && fail "the build without splats was preferred: $(cat err)"
grep -q "from the cache" err || fail "the build with splats is not used: $(cat err)"

echo "not a model" > text.xyzzy
# Content at an extreme distance is skipped, and the rest is drawn; an empty picture is explained.
cat > far.obj << 'END'
o near
v 0 0 0
v 1 0 0
v 0 1 0
f 1 2 3
o away
v 1e30 0 0
v 1e30 1 0
v 1e30 0 1
f 4 5 6
o spiked
v 3 0 0
v 4 0 0
v 3 1 0
v 3 -1e38 0
f 7 8 9
f 8 7 10
END
"$stipple" build far.obj -o far.stip --fresh --threshold 1 2> err || fail "far.obj: $(cat err)"
grep -q "object [0-9]* (away)" err || fail "the omitted object is not named: $(cat err)"
for how in "" --reference; do
    "$stipple" render far.stip -o far.png --size 40x30 --view front $how --json > far.json 2> err
    [ ! -s err ] || fail "far.stip: $(cat err)"
    python3 -c "import json; n = json.load(open('far.json'))['covered_pixels']; assert n > 50, n" ||
        fail "a far object makes the picture blank $how"
done
"$stipple" render far.stip -o far.png --size 40x30 --eye 0,0,9 --target 0,0,99 2> err || fail "$(cat err)"
grep -q "far.stip: the picture is empty: no part of the scene is in view" err ||
    fail "an empty picture is not explained: $(cat err)"

refused 1 "text.xyzzy" render text.xyzzy -o a.png

refused 2 "needs one file" render -o a.png
refused 2 "needs -o" render "$file"
refused 2 "there are front, back, left, right, top, bottom, iso, d0 to d25" render "$file" -o a.png --view nowhere
refused 2 "exclude" render "$file" -o a.png --splats 4 --splat-size 2
refused 2 "exclude" render "$file" -o a.png --accumulate 4 --supersample 2
refused 2 "--eye-dome" render "$file" -o a.png --eye-dome=bright
refused 2 "--filter" render "$file" -o a.png --filter box
refused 2 "--ambient-occlusion" render "$file" -o a.png --ambient-occlusion 99
"$stipple" render -o eye.png --size 48x48 --eye-dome "$file" || fail "an option without its value before the file"
refused 2 "--backend" render "$file" -o a.png --backend vulkan
refused 2 "not a colour" render "$file" -o a.png --background greenish
refused 2 "file name" render "$file" -o - --json
refused 1 "nothing.stip" render nothing.stip -o a.png
cp "$file" same.stip
ln -s same.stip link.stip
refused 2 "would be overwritten" render same.stip -o link.stip
cmp -s "$file" same.stip || fail "render wrote over its scene"
refused 2 "ortho" render "$file" -o a.png --ortho -5
refused 2 "ortho" render "$file" -o a.png --ortho 0
# an explicit up equals the default: fitting a standard view does not change it
"$stipple" render "$file" -o default_up.png --eye 3,2,5 --target 0,0,0 --size 32x24 -q || fail "no picture from an eye"
"$stipple" render "$file" -o given_up.png --eye 3,2,5 --target 0,0,0 --up 0,1,0 --size 32x24 -q || fail "no picture with an up"
cmp -s default_up.png given_up.png || fail "--up 0,1,0 turns the picture"
# a budget leaves ambient occlusion out while it looks for the size of splats, not in the picture
for occlusion in "" "--ambient-occlusion 5"; do
    # shellcheck disable=SC2086
    "$stipple" render "$file" -o "budget${occlusion:+_dark}.png" --size 320x240 --budget-ms 0.1 $occlusion -q ||
        fail "no picture within a budget"
done
cmp -s budget.png budget_dark.png && fail "render leaves ambient occlusion out of its picture"
# other formats of pictures get advice; models do not come from standard input
refused 2 "ImageMagick" render "$file" -o a.tiff
refused 2 "standard input" render - -o a.png
refused 2 "standard input" render /dev/stdin -o a.png
# compare and sheet read what render writes
for suffix in png jpg webp; do
    "$stipple" render "$file" -o "kind.$suffix" --size 64x48 --background white -q || fail "$suffix"
    "$stipple" compare "kind.$suffix" kind.png --json > compare.json || fail "compare reads no $suffix"
    holds "$(value compare.json ssim) > 0.9" || fail "$suffix: $(cat compare.json)"
done
"$stipple" sheet kind.jpg kind.webp -o kinds.png || fail "sheet reads no JPEG and WebP"
# normals of models that have none
"$stipple" render ball.obj -o ball.png --size 64x64 -q || fail "a model once more"
"$stipple" render ball.obj -o smooth.png --size 64x64 --smooth 60 -q || fail "--smooth"
cmp -s ball.png smooth.png && fail "--smooth draws what the cache holds without it"
"$stipple" -q build ball.obj -o smooth.stip --smooth 60 || fail "build --smooth"
"$stipple" -q render smooth.stip -o smooth2.png --size 64x64 && cmp -s smooth.png smooth2.png || fail "build --smooth differs"
"$stipple" render smooth.stip -o x.png --smooth 60 2> err && fail "--smooth of a built file"
grep -q "smooth.stip is built; --smooth is an option of build" err || fail "a built file: $(cat err)"
head -c 100 "$file" > short.stip
refused 1 "short.stip" render short.stip -o a.png
refused 1 "no/folder" render "$file" -o no/folder/a.png --size 8x8
exit $((failures > 0))
