#!/usr/bin/env bash
# stipple fly: figures, pictures, films, plots and errors. Arguments: executable, scratch folder,
# source folder.
# needs: stipple-lab
set -u
stipple=$1
scratch=$2
source=$3
rm -rf "$scratch"
. "$(dirname "$0")/shared.sh"
mkdir -p "$scratch" && cd "$scratch" || exit 1
export XDG_CACHE_HOME=$PWD/cache

# fly NAME ARGUMENTS...: writes NAME.json
fly()
{
    local name=$1
    shift
    "$stipple" fly "$@" --json -q > "$name.json" 2> err || fail "$name: $(cat err)"
}

# a ball, drawn as splats from a distance
python3 - << 'END' || exit 1
with open("ball.obj", "w") as out:
    from math import sin, cos, pi
    n = 40
    for i in range(n + 1):
        for k in range(2 * n):
            a, b = pi * i / n, pi * k / n
            out.write(f"v {sin(a) * cos(b):.6f} {cos(a):.6f} {sin(a) * sin(b):.6f}\n")
    for i in range(n):
        for k in range(2 * n):
            p = [i * 2 * n + k, i * 2 * n + (k + 1) % (2 * n), (i + 1) * 2 * n + (k + 1) % (2 * n), (i + 1) * 2 * n + k]
            out.write("f " + " ".join(str(x + 1) for x in p) + "\n")
END
"$stipple" build ball.obj -o ball.stip --levels off -q || exit 1
cat > flight.json << 'END'
{"fov": 40, "fps": 4, "keys": [{"t": 1, "eye": [0, 1, 40], "target": [0, 0, 0]},
 {"t": 2, "eye": [9, 1, 8], "target": [0, 0, 0]}, {"t": 3.5, "eye": [4, -1, 0], "target": [0, 0, 0], "up": [0, 1, 0.2]}]}
END

boxes=(scene:boxes --path "$source/lab/scenes/flights/boxes.json")
fly plain "${boxes[@]}" --size 64x48 --frames 5
fly same "${boxes[@]}" --size 64x48 --frames 6 --reference --reference-every 1 --popping
fly same_ball ball.stip --path flight.json --size 64x48 --reference --reference-every 1 --popping
fly same_filtered ball.stip --path flight.json --size 64x48 --reference --reference-every 1 --popping --pixel-filter on
fly every ball.stip --path flight.json --size 64x48 --reference-every 4 --splat-size 3 --popping
fly budget ball.stip --path flight.json --size 64x48 --budget-ms 0.1 --threads 1
fly paper ball.stip --path flight.json --size 64x48 --budget-ms 1e5 --controller paper
fly policy ball.stip --path flight.json --size 64x48 --splat-size 6 --policy switch --splat-scale 0.5 --supersample 2
fly one ball.stip --path flight.json --size 64x48 --frames 1
python3 - << 'END' || fail "figures"
import json
def load(name):
    f = json.load(open(name + ".json"))
    expected = """truncated file_bytes whole_bytes backend device width height threads frames frame_ms splats triangles splat_size draw_calls extra_splats
    budget popping quality first_frame per_frame method coarse_method""".split()
    assert sorted(f) == sorted(expected), (name, sorted(f))
    assert sorted(f["frame_ms"]) == ["max", "p50", "p95", "p99"], f["frame_ms"]
    for key in "splats", "triangles", "splat_size", "draw_calls", "extra_splats":
        assert sorted(f[key]) == ["max", "p50"], f[key]
    assert len(f["per_frame"]) == f["frames"]
    for frame in f["per_frame"]:
        assert ("popping" in frame) == (f["popping"] is not None) and frame.pop("popping", 0) >= 0
        assert ("left_out" in frame) == (f["budget"] is not None) and not frame.pop("left_out", []), frame
        assert sorted(frame) == sorted("""t frame_ms select_ms draw_ms shade_ms splat_size resolution splats extra_splats fragments
            clusters triangles listed_splats listed_triangles nodes draw_calls covered_pixels layers gl""".split()), frame
        assert frame["splats"] <= frame["listed_splats"] and frame["triangles"] <= frame["listed_triangles"], frame
        assert frame["gl"] is None and sorted(f["first_frame"]) == sorted(set(frame) - {"t", "extra_splats"}), frame
        assert 0 < frame["select_ms"] + frame["draw_ms"] + frame["shade_ms"] <= frame["frame_ms"] + 1e-6, frame
    for key in "frame_ms", "splats", "triangles", "splat_size":
        values = sorted(frame[key] for frame in f["per_frame"])
        assert f[key]["max"] == values[-1] and f[key]["p50"] == values[(len(values) - 1) // 2], (name, key, values, f[key])
    assert f["frame_ms"]["p50"] <= f["frame_ms"]["p95"] <= f["frame_ms"]["p99"] <= f["frame_ms"]["max"]
    for q in f["quality"]:
        assert sorted(q) == ["exact", "exact_filtered", "frame", "ms_ssim", "psnr", "ratio", "ssim", "ssim_covered", "truth"], q
        assert abs(q["ratio"] * q["exact"] - q["truth"]) < 1e-12 and 0 < q["exact"] <= 1, q
        assert 0 < q["exact_filtered"] <= 1 and q["exact_filtered"] != q["exact"], q
    return f
f = load("plain")
assert (f["backend"], f["width"], f["height"], f["frames"]) == ("cpu", 64, 48, 5)
assert f["popping"] is None and f["quality"] == [] and f["budget"] is None
assert [frame["t"] for frame in f["per_frame"]] == [0, 1, 2, 3, 4]
assert f["triangles"]["p50"] > 0
for name in "same", "same_ball":
    f = load(name)
    assert [q["frame"] for q in f["quality"]] == list(range(f["frames"]))
    assert all(q["ssim"] == q["ssim_covered"] == q["ms_ssim"] == q["ratio"] == 1 for q in f["quality"]), f["quality"]
    assert any(q["truth"] < 1 for q in f["quality"]), f["quality"] # one sample is not the truth
    assert f["popping"] == {"p50": 0, "p999": 0, "max": 0}, f["popping"]
# of 6,400 triangles some are hidden
assert {frame["listed_triangles"] for frame in f["per_frame"]} == {6400} and min(frame["triangles"] for frame in f["per_frame"]) < 6400
f = load("same_filtered") # the originals are drawn like the frame
assert all(q["ssim"] == 1 and q["truth"] == q["exact_filtered"] for q in f["quality"]), f["quality"]
assert f["popping"] == {"p50": 0, "p999": 0, "max": 0}, f["popping"]
f = load("every") # 2.5 s at 4 frames a second
assert f["frames"] == 11 and f["per_frame"][-1]["t"] == 3.5 and f["per_frame"][1]["t"] == 1.25
assert [q["frame"] for q in f["quality"]] == [0, 4, 8]
assert any(q["ssim"] < 1 for q in f["quality"]) and all(q["ssim"] > 0.3 for q in f["quality"]), f["quality"]
assert f["popping"]["p50"] <= f["popping"]["p999"] <= f["popping"]["max"] and f["popping"]["max"] > 0
assert f["splats"]["max"] > 0 and f["splat_size"]["max"] == 3
f = load("budget")
assert f["threads"] == 1 and all(1 <= frame["splat_size"] <= 24 for frame in f["per_frame"])
assert all(0.5 <= frame["resolution"] <= 1 for frame in f["per_frame"])
assert sorted(f["budget"]) == ["ms", "within_1_0", "within_1_1", "within_1_5"] and f["budget"]["ms"] == 0.1, f["budget"]
for key, factor in ("within_1_0", 1.0), ("within_1_1", 1.1), ("within_1_5", 1.5):
    within = [frame["frame_ms"] <= factor * 0.1 for frame in f["per_frame"]]
    assert abs(f["budget"][key] - sum(within) / len(within)) < 1e-9, (key, f["budget"])
f = load("paper") # all the time of the world: as fine as can be
assert all(frame["splat_size"] == 1 for frame in f["per_frame"]), f["per_frame"]
assert f["budget"]["within_1_0"] == 1, f["budget"]
assert load("policy")["splat_size"]["p50"] == 6 and load("policy")["extra_splats"]["max"] == 0
assert load("one")["frames"] == 1
END

# pictures equal those of render, with all measurements
"$stipple" fly ball.stip --path flight.json --size 64x48 --splat-size 3 -o pictures/ --reference-every 5 --popping > text ||
    fail "pictures"
[ "$(ls pictures)" = "$(seq -f 'frame-%06.0f.png' 0 10)" ] || fail "pictures are $(ls pictures)"
# the truth of a frame is what `compare` finds in pictures of `render`
"$stipple" fly ball.stip --path flight.json --size 64x48 --splat-size 3 --reference-every 5 --supersample 2 --json > truth.json ||
    fail "truth"
python3 - "$stipple" << 'END' || fail "truth of fly and of compare differ"
import json, subprocess, sys
def run(*options):
    return json.loads(subprocess.run([sys.argv[1], *options, "--json"], check=True, capture_output=True).stdout)
view = ["--size", "64x48", "--fov", "40", "--eye", "0,1,40", "--target", "0,0,0"]
run("render", "ball.stip", "-o", "ours.png", "--splat-size", "3", "--supersample", "2", *view)
run("render", "ball.stip", "-o", "truth.png", "--reference", "--supersample", "4", *view)
run("render", "ball.stip", "-o", "exact.png", "--reference", "--supersample", "1", *view)
run("render", "ball.stip", "-o", "filtered.png", "--reference", "--pixel-filter", "on", *view)
found, flown = run("compare", "ours.png", "truth.png", "--exact", "exact.png"), json.load(open("truth.json"))["quality"][0]
for key in "truth", "exact", "ratio":
    assert abs(found[key] - flown[key]) < 1e-9, (key, found, flown)
found = run("compare", "ours.png", "truth.png", "--exact", "filtered.png")
assert abs(found["exact"] - flown["exact_filtered"]) < 1e-9, (found, flown)
END
# --pixel-filter: auto filters frames of flights and of budgets, not other pictures and no originals
one=(ball.stip --size 64x48 --splat-size 3 --eye 0,1,40 --target 0,0,0 --fov 40)
for name in auto on off; do
    "$stipple" render "${one[@]}" -o "render-$name.png" --pixel-filter $name > /dev/null || fail "render --pixel-filter $name"
    "$stipple" fly ball.stip --path flight.json --size 64x48 --splat-size 3 --frames 1 -o "fly-$name/" --pixel-filter $name \
        > /dev/null || fail "fly --pixel-filter $name"
    "$stipple" fly ball.stip --path flight.json --size 64x48 --reference --frames 1 -o "reference-$name/" \
        --pixel-filter $name > /dev/null || fail "fly --reference --pixel-filter $name"
done
"$stipple" render "${one[@]}" -o render.png > /dev/null || fail "render"
for pair in "render.png render-off.png" "render-auto.png render-off.png" "fly-auto/frame-000000.png fly-on/frame-000000.png" \
    "fly-off/frame-000000.png render-off.png" "fly-on/frame-000000.png render-on.png" "reference-auto/frame-000000.png reference-off/frame-000000.png"; do
    cmp -s ${pair% *} ${pair#* } || fail "pictures differ: $pair"
done
for pair in "render-on.png render-off.png" "reference-on/frame-000000.png reference-off/frame-000000.png"; do
    cmp -s ${pair% *} ${pair#* } && fail "pictures are equal: $pair"
done
for word in "frame ms" popping SSIM ratio; do
    grep -q "$word" text || fail "the table lacks $word: $(cat text)"
done
"$stipple" render ball.stip -o one.png --size 64x48 --pixel-filter on --splat-size 3 --eye 9,1,8 --target 0,0,0 --fov 40 || fail "render"
cmp -s one.png pictures/frame-000004.png || fail "a frame differs from render's picture"
mkdir -p again
"$stipple" fly ball.stip --path flight.json --size 64x48 --splat-size 3 -o again --frames 11 -q > text || fail "again"
cmp -s pictures/frame-000007.png again/frame-000007.png || fail "the same flight has other pictures"

# ffmpeg makes a film from raw frames: this one only counts them
mkdir -p bin
cat > bin/ffmpeg << 'END'
#!/usr/bin/env bash
echo "$@" > arguments
for last; do :; done
echo "it prints"
wc -c > "${last#file:}"
exit "$(cat code)"
END
chmod +x bin/ffmpeg
echo 0 > code
PATH=$PWD/bin:$PATH "$stipple" fly ball.stip --path flight.json --size 64x48 -o film.mp4 --json > film.json 2> err || fail "film: $(cat err)"
python3 -c 'import json; json.load(open("film.json"))' || fail "figures beside a film"
[ "$(cat film.mp4)" -eq $((11 * 64 * 48 * 3)) ] || fail "the film has $(cat film.mp4) bytes"
grep -q -- "-video_size 64x48 -framerate 4.0" arguments || fail "ffmpeg gets $(cat arguments)"
echo old > film.mp4
echo 3 > code
programs=$PWD/bin:$PATH refused 1 "ffmpeg could not write it (its exit code is 3)" fly ball.stip --path flight.json --size 64x48 -o film.mp4
[ "$(cat film.mp4)" = old ] || fail "a film that failed replaces the old one"
ls film.mp4.* 2> /dev/null && fail "leaves $(ls film.mp4.*)"
printf '#!/bin/sh\nexit 1\n' > bin/ffmpeg
programs=$PWD/bin:$PATH refused 1 "ffmpeg" fly ball.stip --path flight.json --size 640x480 -o film.mp4
echo 'touch started' >> bin/ffmpeg
mkfifo pipe.mp4
programs=$PWD/bin:$PATH refused 1 "pipe.mp4: is not a regular file" fly ball.stip --path flight.json --size 64x48 -o pipe.mp4
programs=$PWD/bin:$PATH refused 1 "no/film.mp4: cannot be written" fly ball.stip --path flight.json --size 64x48 -o no/film.mp4
[ ! -e started ] || fail "a film that cannot be written is begun"
rm bin/ffmpeg
programs=$PWD/bin refused 1 "ffmpeg, which writes films, cannot be started" fly ball.stip --path flight.json --size 64x48 -o film.mp4

"$stipple" fly ball.stip --path flight.json --size 64x48 --budget-ms 5 --plot plot.svg > /dev/null || fail "plot"
python3 - << 'END' || fail "the plot"
import xml.etree.ElementTree as tree
root = tree.parse("plot.svg").getroot()
text = " ".join(t for t in root.itertext())
for word in "frame time, ms", "size of splats", "splats", "triangles":
    assert word in text, text
assert "popping" not in text and "SSIM" not in text, text
END
"$stipple" fly ball.stip --path flight.json --size 64x48 --popping --reference-every 4 --plot plot.svg > /dev/null || fail "a plot of all"
python3 - << 'END' || fail "the plot of all"
import xml.etree.ElementTree as tree
root = tree.parse("plot.svg").getroot()
text = " ".join(t for t in root.itertext())
assert "popping" in text and "SSIM" in text, text
dots = [e for e in root.iter() if e.tag.endswith("circle")]
assert len(dots) == 6, len(dots) # two for each of three frames, of eleven
height = float(root.get("height"))
assert all(0 < float(d.get("cy")) < height for d in dots)
END

# the next run removes what a killed run left of its film
sleep 0 &
gone=$!
wait $gone
touch film.mp4.tmp-$gone-0
printf '#!/usr/bin/env bash\nfor last; do :; done\ncat > "${last#file:}"\n' > bin/ffmpeg
chmod +x bin/ffmpeg
PATH=$PWD/bin:$PATH "$stipple" fly ball.stip --path flight.json --size 64x48 --frames 2 -o film.mp4 -q > text || fail "film again"
ls film.mp4.* 2> /dev/null && fail "leaves $(ls film.mp4.*)"
[ "$(stat -c %s film.mp4)" -eq $((2 * 64 * 48 * 3)) ] || fail "the film has $(stat -c %s film.mp4) bytes"
rm bin/ffmpeg

refused 2 "needs one file" fly --path flight.json
refused 2 "needs --path" fly ball.stip
refused 2 "film OUT.mp4 or a folder" fly ball.stip --path flight.json -o film.avi
refused 2 "would be overwritten" fly ball.stip --path flight.json --plot flight.json
refused 2 "would be overwritten" fly ball.stip --path flight.json --plot ball.stip
refused 2 "exclude" fly ball.stip --path flight.json --budget-ms 5 --splat-size 2
refused 2 "exclude" fly ball.stip --path flight.json --budget-ms 5 --reference
refused 2 "frames" fly ball.stip --path flight.json --frames 0
refused 2 "no object named attic" fly ball.stip --path flight.json --size 8x8 --hide attic
refused 1 "nothing.json" fly ball.stip --path nothing.json
refused 1 "nothing.stip" fly nothing.stip --path flight.json
echo '{"fps": 1000, "keys": [{"t": 0, "eye": [0, 0, 9], "target": [0, 0, 0]}, {"t": 9000, "eye": [0, 0, 8], "target": [0, 0, 0]}]}' > long.json
refused 1 "long.json: has 9000001 frames" fly ball.stip --path long.json
echo '{"keys": [{"t": 0}]}' > bad.json
refused 1 'bad.json: key 0: "eye"' fly ball.stip --path bad.json
refused 1 "no/plot.svg" fly ball.stip --path flight.json --size 8x8 --frames 1 --plot no/plot.svg
refused 1 "no/plot.svg" fly ball.stip --path flight.json --size 8x8 --plot no/plot.svg -o never/
[ ! -e never ] || fail "a flight that cannot be plotted is flown"
refused 2 "standard output" fly ball.stip --path flight.json --plot -
for plot in both.mp4 plot.png plot; do # a plot in place of the film that was just written would be a loss
    refused 2 "--plot needs a name OUT.svg, not $plot" fly ball.stip --path flight.json --size 8x8 -o both.mp4 --plot "$plot"
done
touch file
refused 1 "file/pictures/" fly ball.stip --path flight.json --size 8x8 --frames 1 -o file/pictures/
exit $((failures > 0))
