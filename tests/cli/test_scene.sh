#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# stipple-lab scene: lists and writes scenes that the other commands understand.
# needs: stipple-lab
set -eu
stipple=$1 scratch=$2
rm -rf "$scratch"
mkdir -p "$scratch"
cd "$scratch"
export XDG_CACHE_HOME=$scratch/cache

fail() {
    echo "FAILED: $*" >&2
    exit 1
}
expect() { # exit code, command...
    local wanted=$1 got=0
    shift
    "$@" >out 2>err || got=$?
    [ "$got" = "$wanted" ] || fail "$* exits $got, not $wanted: $(cat err)"
}

expect 0 "$stipple" scene --list
grep -q '^  boxes ' out || fail "the list has no boxes"
expect 0 "$stipple" scene --list --json
python3 -c 'import json; assert any(s["name"] == "boxes" for s in json.load(open("out"))["scenes"])'

# the documentation has a row for each scene, with its views
python3 - "$stipple" "$3/docs/scenes.md" << 'PY'
import json, subprocess, sys
stipple, page = sys.argv[1], open(sys.argv[2]).read()
for scene in json.load(open("out"))["scenes"]:
    rows = [line for line in page.splitlines() if line.startswith(f"| `{scene['name']}` |")]
    assert len(rows) == 1, scene["name"]
    info = subprocess.run([stipple, "info", f"scene:{scene['name']},scale=0.0001", "--json"], capture_output=True, check=True)
    for view in json.loads(info.stdout)["views"]:
        assert f"`{view}`" in rows[0], (scene["name"], view)
PY

expect 0 "$stipple" scene boxes -o boxes.glb --json
python3 -c 'import json; s = json.load(open("out")); assert s["unique_triangles"] == 324, s'
expect 0 "$stipple" scene boxes -o boxes.gltf
[ -s boxes.bin ] || fail "no binary file beside the .gltf"
python3 - <<'PY'
import json
g = json.load(open("boxes.gltf"))
assert g["asset"]["version"] == "2.0" and len(g["meshes"]) == 27 and len(g["cameras"]) == 2
assert g["buffers"][0]["uri"] == "boxes.bin"
PY
for input in boxes.glb boxes.gltf scene:boxes; do
    expect 0 "$stipple" info "$input" --json
    python3 -c 'import json; i = json.load(open("out")); assert (i["triangles"], i["instances"]) == (324, 27), i'
done
expect 0 "$stipple" info scene:boxes,scale=8 --json
python3 -c 'import json; assert json.load(open("out"))["instances"] == 216'

expect 0 "$stipple" build scene:boxes -o a.stip --threshold 0 -q
expect 0 "$stipple" check a.stip
expect 0 "$stipple" render scene:boxes --view corner --size 64x64 -o a.png
expect 0 "$stipple" render scene:boxes,seed=2 --view corner --size 64x64 -o b.png
cmp -s a.png b.png && fail "two seeds give the same picture"

expect 2 "$stipple" scene
expect 2 "$stipple" scene nothing -o x.glb
expect 2 "$stipple" scene boxes
expect 2 "$stipple" scene boxes -o x.obj
expect 2 "$stipple" scene boxes -o x.glb --scale 0
expect 1 "$stipple" info scene:nothing
expect 1 "$stipple" info scene:boxes,scale=-1
expect 1 "$stipple" scene boxes -o no/such/folder/x.glb
[ "$(wc -l <err)" = 1 ] || fail "not exactly one sentence: $(cat err)"

# stipple names the program that has a command, for each command that only stipple-lab has
product=${stipple%/*/*}/program/stipple
commands() { "$1" help | sed -n '/^Commands:/,/^$/s/^  \([a-z-]*\) .*/\1/p' | sort; }
commands "$stipple" > lab-commands
commands "$product" > commands
comm -23 lab-commands commands > moved
[ "$(wc -l < moved)" -ge 8 ] && [ -z "$(comm -13 lab-commands commands)" ] || fail "stipple-lab lacks commands of stipple"
while read -r name; do
    expect 2 "$product" "$name"
    grep -q "^stipple: stipple-lab has the command '$name'" err || fail "stipple $name: $(cat err)"
done < moved
