#!/usr/bin/env bash
# --backend: OpenGL and the CPU draw the same pictures. Arguments: executable, scratch folder.
# needs: stipple-lab
set -u
stipple=$1
scratch=$2
rm -rf "$scratch"
. "$(dirname "$0")/shared.sh"
mkdir -p "$scratch" && cd "$scratch" || exit 1

for scene in boxes city-small; do
    "$stipple" scene $scene -o $scene.gltf --scale 0.01 > /dev/null 2> err || fail "$scene: $(cat err)"
    "$stipple" build $scene.gltf -o $scene.stip --fresh > /dev/null 2> err || fail "$scene: $(cat err)"
done
if ! "$stipple" render boxes.stip -o a.png --size 8x8 --backend gl 2> err; then
    grep -q "^stipple-lab: backend gl: .*; use --backend cpu$" err || fail "OpenGL is missing, and nothing says so: $(cat err)"
    echo "skipped: $(cat err)"
    exit 77
fi

# both FILE ARGUMENTS...: the same picture from both backends
both()
{
    local backend
    for backend in cpu gl; do
        "$stipple" render "$@" --size 120x80 --backend $backend -o $backend.png --json > $backend.json 2> err ||
            fail "$* $backend: $(cat err)"
    done
    "$stipple" compare cpu.png gl.png --json > compare.json || fail "compare"
    python3 - "$*" << 'END' || fail "$*"
import json, sys
cpu, gl, compare = (json.load(open(name + ".json")) for name in ("cpu", "gl", "compare"))
assert (cpu["backend"], gl["backend"]) == ("cpu", "gl"), gl
assert len(gl["device"]) > 3 and gl["device"] != cpu["device"], gl
assert 1 <= gl["draw_calls"] <= 8, gl
assert sorted(cpu) == sorted(gl), set(cpu) ^ set(gl)
for key in ("width", "height", "splat_size"):
    assert cpu[key] == gl[key], key
assert compare["ssim"] >= 0.98, compare
assert gl["draw_ms"] > 0 and gl["shade_ms"] > 0 and gl["frame_ms"] > 0, gl
END
}
both boxes.stip
both boxes.stip --supersample 2 --background 204060
both city-small.stip --view top --splat-size 2 --eye-dome 1 --light head
both city-small.stip --view iso --splat-size 2 --stereo

cat > flight.json << 'END'
{"fps": 10, "keys": [{"t": 0, "eye": [0, 1, 9], "target": [0, 0, 0]}, {"t": 1, "eye": [3, 1, 8], "target": [0, 0, 0]}]}
END
"$stipple" fly boxes.stip --path flight.json --size 64x48 --frames 3 --backend gl --json -q > fly.json 2> err ||
    fail "fly: $(cat err)"
python3 -c "
import json
f = json.load(open('fly.json'))
assert f['backend'] == 'gl' and f['frames'] == 3 and f['draw_calls']['max'] <= 8, f
assert all(p['gl']['issue_ms'] > 0 and p['gl']['missing'] == 0 and p['covered_pixels'] > 0 for p in f['per_frame']), f
assert f['first_frame']['gl']['uploaded_bytes'] > 0 and f['per_frame'][-1]['gl']['resident_bytes'] > 0, f" || fail "fly's figures"

# every option that changes pictures, with point splats and with compute shaders
"$stipple" bench backends --quick --model city-small.stip --json > backends.json 2> err || fail "bench backends: $(cat err)"
python3 - << 'END' || fail "bench backends' figures"
import json
results = json.load(open("backends.json"))["results"]
pictures = [r for r in results if r["name"] == "backends"]
assert {r["params"]["way"] for r in pictures} == {"points", "compute"}, pictures
assert {1, 2, 4} <= {r["params"]["splat_size"] for r in pictures if r["params"]["case"].startswith("size")}
for r in pictures:
    f = r["figures"]
    assert f["ssim"] >= 0.98 and 1 <= f["draw_calls"] <= 8, r
    assert f.get("ssim_reference_gl", 1) >= f.get("ssim_reference_cpu", 1) - 0.001, r
assert results[-1]["figures"]["ssim"] == min(r["figures"]["ssim"] for r in pictures)
END

# point trees: traversal and sequence cover the same pixels, and are the same on both backends
for backend in cpu gl; do
    "$stipple" bench spt --quick --backend $backend --json > spt-$backend.json 2> err || fail "bench spt: $(cat err)"
done
python3 - << 'END' || fail "bench spt's figures"
import json
cpu, gl = ([r["figures"] for r in json.load(open(f"spt-{backend}.json"))["results"] if r["name"] == "spt distance"]
           for backend in ("cpu", "gl"))
assert len(cpu) == len(gl) == 7
for c, g in zip(cpu, gl):
    assert all(c[key] == g[key] for key in g if key.startswith("drawn_by")), (c, g)
    assert {"drawn_by_traversal", "drawn_by_sequence", "drawn_by_groups"} <= set(g), g
    for key in ("traversal_pixels", "sequence_pixels", "groups_pixels"):
        assert abs(g[key] / c[key] - 1) < 0.01 and abs(g[key] / g["traversal_pixels"] - 1) < 0.01, (key, c, g)
    assert g["drawn_by_groups"] <= g["submitted_by_groups"] <= g["submitted_by_sequence"], g
    for way, spent in ("traversal", "gather"), ("sequence", "test"), ("groups", "test"):
        assert 0 <= g[f"{way}_{spent}_ms"] < g[f"{way}_draw_ms"], g
END

# automatic: a software renderer does not count as a GPU
"$stipple" render boxes.stip -o a.png --size 8x8 --json > auto.json 2> err || fail "auto: $(cat err)"
python3 -c "
import json
auto, gl = json.load(open('auto.json')), json.load(open('gl.json'))
software = any(name in gl['device'] for name in ('llvmpipe', 'softpipe', 'swrast'))
assert auto['backend'] == ('cpu' if software else 'gl'), auto" || fail "automatic choice"

# shaders in a folder override those in the library
mkdir -p shaders
echo "void main() { this is no shader" > shaders/splat.frag.glsl
if STP_SHADER_DIR=$PWD/shaders "$stipple" render city-small.stip --view top -o b.png --size 8x8 --backend gl 2> err; then
    fail "a broken shader of STP_SHADER_DIR draws"
fi
grep -q "splat.frag.glsl" err || fail "a broken shader is not named: $(cat err)"
exit $((failures > 0))
