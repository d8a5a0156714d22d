#!/usr/bin/env bash
# bench/gpu.sh and stipple-lab bench gl on a small scene: output and errors. Arguments: executable,
# scratch folder, source folder.
# needs: stipple-lab
set -u
stipple=$1
scratch=$2
source=$3
rm -rf "$scratch"
. "$(dirname "$0")/shared.sh"
mkdir -p "$scratch" && cd "$scratch" || exit 1
export XDG_CACHE_HOME=$PWD/cache LIBGL_ALWAYS_SOFTWARE=1
"$stipple" bench gl --quick --model scene:boxes --json > quick.json 2> err || fail "bench gl: $(cat err)"
if grep -q "nothing is measured" err; then
    echo "skipped: there is no OpenGL"
    exit 77
fi

bash "$source/bench/gpu.sh" --scene boxes --scale 1 --stipple "$stipple" --output out > said 2> err || fail "gpu.sh: $(cat err)"
grep -q "do not represent a GPU" err || fail "gpu.sh does not warn that this is not a GPU"
json=$(grep 'gpu.json$' said) markdown=$(grep 'gpu.md$' said)
[ -s "$json" ] && [ -s "$markdown" ] || fail "gpu.sh does not print its output files: $(cat said)"
python3 - "$json" << 'END' || fail "$json is not what is expected"
import json, sys
results = json.load(open(sys.argv[1]))["results"]
rows = [r for r in results if r["name"] == "gl"]
for way in ("points", "compute", "auto", "full geometry"):
    of = [r for r in rows if r["params"]["way"] == way]
    assert len({r["params"]["picture"] for r in of}) == 2, way
    for r in of:
        assert r["params"]["model"] == "scene:boxes,scale=1", r
        assert r["figures"]["frame_ms"] >= 0 and 0 < r["figures"]["draw_calls"] <= 8, r
        assert (r["figures"]["triangles"] > 0) or way != "full geometry", r
assert any(r["name"] == "gl ways" and r["figures"]["copied_bytes_per_second"] > 0 for r in results)
END
[ "$(grep -c '^| .* | points |' "$markdown")" -ge 2 ] || fail "$markdown has no rows of points"
bash "$source/bench/gpu.sh" --colour red > out.txt 2> err && fail "an unknown option is accepted"
grep -q "is not an option" err || fail "gpu.sh does not name the unknown option"
