#!/usr/bin/env bash
# stipple-lab bench frame and positions on a small model: reports, measuring in pieces, a memory limit,
# and errors. Arguments: executable, scratch folder.
# needs: stipple-lab
set -u
stipple=$1
scratch=$2
rm -rf "$scratch"
. "$(dirname "$0")/shared.sh"
mkdir -p "$scratch" && cd "$scratch" || exit 1
export XDG_CACHE_HOME=$PWD/cache

# bench NAME ARGUMENTS...: writes NAME.json
bench()
{
    local name=$1
    shift
    "$stipple" bench "$@" --json > "$name.json" 2> err || fail "$name: $(cat err)"
}

# hills over the area of the benchmark scene, in nine parts, so that positions see different content
python3 - << 'END' || exit 1
from math import sin
with open("hills.obj", "w") as out:
    n = 60
    for i in range(n + 1):
        for k in range(n + 1):
            out.write(f"v {100 * k - 3000} {60 * sin(i / 3) * sin(k / 4) - 80:.3f} {70 * i - 2100}\n")
    for part in range(9):
        out.write(f"o part{part}\n")
        for i in range(part // 3 * 20, part // 3 * 20 + 20):
            for k in range(part % 3 * 20, part % 3 * 20 + 20):
                a = i * (n + 1) + k + 1
                out.write(f"f {a} {a + n + 1} {a + 1}\nf {a + 1} {a + n + 1} {a + n + 2}\n")
END
"$stipple" build hills.obj -o hills.stip --levels off -q || exit 1
small=(--model hills.stip --size 64x48)
bench whole positions "${small[@]}" --count 6 --threads 1
bench begin positions "${small[@]}" --count 5
bench end positions "${small[@]}" --first 5 --count 1 --memory 64M --splat-size 3
bench frame frame "${small[@]}" --quick --splat-size 2
bench streamed frame "${small[@]}" --quick --memory 64M --threads 1
"$stipple" render hills.stip -o a.png --size 64x48 --json > render.json || fail "render"
echo '{"keys": [{"t": 0, "eye": [0, 900, 2000], "target": [0, 0, 0]}]}' > look.json
"$stipple" fly hills.stip --path look.json --size 64x48 --json > fly.json || fail "fly"
python3 - << 'END' || fail "figures"
import json
def load(name):
    return json.load(open(name + ".json"))["results"]
LISTS = "frame_ms", "jump_ms", "splats", "triangles"
def positions(name):
    results = load(name)
    for r in results:
        p, f = r["params"], r["figures"]
        assert (p["width"], p["height"]) == (64, 48) and p["pictures"] == 4 * p["positions"], p
        assert all(len(f[key]) == p["pictures"] for key in LISTS), f
        ordered = sorted(f["frame_ms"])
        assert (f["min"], f["max"]) == (ordered[0], ordered[-1]) and f["p50"] == ordered[(len(ordered) - 1) // 2]
        assert f["min"] <= f["p25"] <= f["p50"] <= f["p75"] <= f["p95"] <= f["p99"] <= f["max"]
    return {r["params"]["place"]: r for r in results}
whole, begin, end = positions("whole"), positions("begin"), positions("end")
assert [r["params"]["positions"] for r in whole.values()] == [6, 2, 2, 2, 2]
assert [r["params"]["positions"] for r in begin.values()] == [5, 2, 2, 2, 2]
assert list(end) == ["Overview"] and end["Overview"]["params"]["first"] == 5 # a quarter of six begins two, as of five
assert end["Overview"]["params"]["splat_size"] == 3 and whole["Overview"]["params"]["threads"] == 1
assert len(set(whole["Overview"]["figures"]["triangles"])) > 4
for key in "splats", "triangles": # the pieces are the whole
    parts = begin["Overview"]["figures"][key] + end["Overview"]["figures"][key]
    assert parts == whole["Overview"]["figures"][key], (key, parts)
for name, memory in ("frame", None), ("streamed", 64 << 20):
    results = load(name)
    flights = [r for r in results if "flight" in r["params"]]
    assert [r["params"].get("controller") for r in flights] == [None, "predict", "paper"]
    assert len(results) > len(flights) and all("view" in r["params"] for r in results if r not in flights)
    for r in results: # what the commands say of a picture and of a flight
        flies = r in flights
        keys = set(json.load(open("fly.json" if flies else "render.json"))) | ({"residency"} if flies and memory else set())
        keys -= {"samples", "accumulated_frames", "picture_ms", "drawn", "method", "coarse_method", "color", "range", "camera"} # of a picture that is written
        keys -= {"truncated", "file_bytes", "whole_bytes"} # of the file that is drawn
        assert set(r["figures"]) == keys, set(r["figures"]) ^ keys
        assert (r["figures"]["backend"], r["figures"]["width"]) == ("cpu", 64), r["figures"]
        assert (r["params"]["width"], r["params"].get("memory_bytes")) == (64, memory), r["params"]
        assert ("residency" in r["figures"]) == (memory is not None and r in flights)
    if memory:
        for r in flights:
            assert r["figures"]["residency"]["read_bytes"] > 0 and r["params"]["threads"] == 1
            assert 0 <= r["figures"]["residency"]["frames_lacking"] <= r["figures"]["frames"]
    else:
        assert flights[0]["figures"]["splat_size"]["max"] == 2
END

refused 2 "there is no benchmark nothing" bench nothing
refused 2 "--size" bench positions --size 0x48
refused 2 "--count" bench positions --count 0
refused 2 "--first" bench positions --first -1
refused 2 "--memory" bench frame --memory much
"$stipple" bench frame --model nothing.stip --quick > out 2> err
[ $? -eq 1 ] || fail "a missing model is not refused"
grep -q "nothing.stip" err || fail "a missing model is not named: $(cat err)"
bench psp psp --quick --threads 2
python3 - << 'END' || fail "figures of psp"
import json
results = json.load(open("psp.json"))["results"]
assert [(r["name"], r["params"]) for r in results] == [
    ("psp", {"points": 100000, "metric": metric, "threads": 2}) for metric in ("normals", "regions")], results
for f in (r["figures"] for r in results):
    assert set(f) == {"input_points", "splats", "seconds", "points_per_second", "bytes_per_operator"}, f
    assert f["input_points"] == 100000 and f["splats"] == 1000 and f["seconds"] > 0, f
    assert abs(f["points_per_second"] * f["seconds"] / 100000 - 1) < 1e-6 and 3 < f["bytes_per_operator"] < 40, f
END
bench levels levels --model hills.obj --threads 2
python3 - << 'END' || fail "figures of levels"
import json
(result,) = json.load(open("levels.json"))["results"]
f = result["figures"]
assert result["name"] == "levels" and result["params"] == {"model": "hills.obj", "triangles": 7200}, result
drawn = [f[f"triangles_at_diagonal_by_{share}"] for share in (3200, 1600, 800, 400, 200, 100, 50)]
assert drawn == sorted(drawn, reverse=True) and 0 < drawn[-1] < 1000 and drawn[0] <= 7200, drawn
assert 7200 < f["stored_triangles"] < 4 * 7200 and f["clusters"] >= f["stored_triangles"] / 128, f
assert 5 < f["levels"] < 64 and f["seconds"] > 0, f
END
exit $((failures > 0))
