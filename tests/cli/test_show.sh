#!/usr/bin/env bash
# Visibility: sections, hidden objects, ghosts, picking, saved viewpoints. Arguments: executable,
# scratch folder.
set -u
stipple=$1
scratch=$2
. "$(dirname "$0")/shared.sh"
mkdir -p "$scratch" && cd "$scratch" || exit 1
show() # renders on the processor: pixels are counted
{
    "$stipple" render "$@" --backend cpu
}
rm -f ./*.views.json

# Two houses of a shared room with a door each; a wall beside them. All are squares of 2 x 2 at their places, facing z.
python3 - << 'END'
import base64, json, struct
corners = struct.pack("<12f", -1, -1, 0, 1, -1, 0, 1, 1, 0, -1, 1, 0)
data = corners + struct.pack("<6H", 0, 1, 2, 0, 2, 3)
def node(name, x, children=None, mesh=None, z=0):
    n = {"name": name, "translation": [x, 0, z]}
    if children: n["children"] = children
    if mesh is not None: n["mesh"] = mesh
    return n
model = {"asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0, 3, 6]}],
  "nodes": [node("left", -4, [1]), node("room", 0, [2], 0), node("door", 0, mesh=0, z=1),
            node("right", 4, [4]), node("room", 0, [5], 0), node("door", 0, mesh=0, z=1), node("wall", 0, mesh=0)],
  "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1}]}],
  "accessors": [{"bufferView": 0, "componentType": 5126, "count": 4, "type": "VEC3", "min": [-1, -1, 0], "max": [1, 1, 0]},
                {"bufferView": 1, "componentType": 5123, "count": 6, "type": "SCALAR"}],
  "bufferViews": [{"buffer": 0, "byteOffset": 0, "byteLength": 48}, {"buffer": 0, "byteOffset": 48, "byteLength": 12}],
  "buffers": [{"byteLength": 60, "uri": "data:application/octet-stream;base64," + base64.b64encode(data).decode()}]}
json.dump(model, open("street.gltf", "w"))
END
"$stipple" build street.gltf -o street.stip --fresh 2> err > /dev/null || fail "build: $(cat err)"

# covered NAME ARGUMENTS...: the columns of squares that are covered in a view from the front, 10 pixels a unit
covered()
{
    local name=$1
    shift
    show street.stip -o "$name.png" --size 120x40 --ortho 4 --eye 0,0,9 --target 0,0,0 "$@" --json \
        > "$name.json" 2> err || fail "$*: $(cat err)"
    python3 -c 'import json,sys; print(json.load(open(sys.argv[1]))["covered_pixels"])' "$name.json"
}

# expect PIXELS ARGUMENTS...
expect()
{
    local wanted=$1 got
    shift
    got=$(covered picture "$@")
    [ "$got" = "$wanted" ] || fail "$*: $got pixels are covered, not $wanted"
}

# filled WIDTH HEIGHT ARGUMENTS...: extent of the covered pixels, in percent of the picture's width
# and height
filled()
{
    local wanted="$1 $2"
    shift 2
    show street.stip -o fitted.png --splat-size 1 "$@" 2> err || fail "$*: $(cat err)"
    python3 - "$wanted" << 'END' || fail "$*: covers other pixels"
import struct, sys, zlib
data, at, parts = open("fitted.png", "rb").read(), 8, b""
while at < len(data):
    size, kind = struct.unpack(">I4s", data[at:at + 8])
    if kind == b"IHDR":
        width, height = struct.unpack(">II", data[at + 8:at + 16])
    parts += data[at + 8:at + 8 + size] if kind == b"IDAT" else b""
    at += 12 + size
raw, columns, rows, before = zlib.decompress(parts), set(), set(), bytearray(4 * width)
for y in range(height):
    kind, row = raw[(4 * width + 1) * y], bytearray(raw[(4 * width + 1) * y + 1:(4 * width + 1) * (y + 1)])
    for i in range(4 * width):
        left, up, corner = (row[i - 4], before[i], before[i - 4]) if i >= 4 else (0, before[i], 0)
        paeth = min((abs(up - corner), 0, left), (abs(left - corner), 1, up), (abs(left + up - 2 * corner), 2, corner))[2]
        row[i] = (row[i] + (0, left, up, (left + up) // 2, paeth)[kind]) & 255
    columns |= {x for x in range(width) if row[4 * x + 3]}
    rows |= {y} if any(row[3::4]) else set()
    before = row
got = (max(columns) + 1 - min(columns)) * 100 / width, (max(rows) + 1 - min(rows)) * 100 / height
assert all(abs(g - float(w)) <= 1.5 for g, w in zip(got, sys.argv[1].split())), (got, sys.argv[1])
END
}

# standard views fit the visible objects, with margins of 4 %
filled 92 92 --view front --isolate wall --size 100x100
filled 46 92 --view front --isolate wall --size 200x100
filled 46 92 --view front --isolate wall --section x:0 --size 100x100
filled 92 92 --view front --isolate wall --section-box 0,0,-1,1,1,1 --size 100x100 --ortho 1
filled 92 46 --view front --isolate wall --size 100x200 --fov 20

expect 1200                          # three squares of 20 x 20
expect 800 --hide wall
expect 400 --isolate wall
expect 1200 --hide left/room/door    # the room is behind it
expect 800 --hide left
expect 400 --hide room               # both
expect 400 --hide left --hide wall
expect 400 --hide left --hide '#7'
expect 400 --isolate right/room --hide right/room/door
expect 600 --section x:0
expect 600 --section -x:50%
expect 300 --section x:0 --section y:0
expect 200 --section-box -1,-1,-9,1,0,9
expect 600 --section-box 0%,0%,0%,50%,100%,100% --reference
expect 600 --section 1,0,0,0 --splat-size 2
expect 0 --section z:-1
for kind in --reference --splat-size=1; do
    count=$(covered ghost --ghost wall $kind)
    [ "$count" -gt 840 ] && [ "$count" -lt 960 ] || fail "a ghost covers $((count - 800)) of 400 pixels"
done
count=$(covered ghosts --isolate wall --ghost others)
[ "$count" -gt 560 ] && [ "$count" -lt 800 ] || fail "others as ghosts: $count"

# picking: the nearest object, and the one behind it
pick()
{
    show street.stip --size 120x40 --ortho 4 --eye 0,0,9 --target 0,0,0 "$@" > pick.json 2> err ||
        fail "$*: $(cat err)"
}
same()
{
    python3 -c 'import json,sys; p = json.load(open("pick.json")); assert eval(sys.argv[1]), p' "$1" || fail "$1"
}
pick --pick 20,20
same 'p["hit"] and p["object"]["path"].endswith("left/room/door") and abs(p["distance"] - 8) < 1e-6'
same 'abs(p["position"][0] + 4) < 1e-6 and abs(p["position"][2] - 1) < 1e-6 and p["normal"][2] > 0.999'
pick --pick 20,20 --hide door
same 'p["object"]["path"].endswith("left/room") and p["object"]["name"] == "room" and abs(p["distance"] - 9) < 1e-6'
pick --pick 20,20 --section z:0.5
same 'abs(p["distance"] - 9) < 1e-6'
pick --pick 40,20
same 'p["hit"] is False'
pick --pick 51.5,10.5
same 'p["snap"]["kind"] == "vertex" and abs(p["snap"]["position"][0] + 1) < 1e-3'
pick --pick 60,20 -o with.png --json
same 'p["pick"]["object"]["name"] == "wall" and p["covered_pixels"] == 1200'

# viewpoints beside the model
cat > street.views.json << 'END'
{"version": 1, "views": [
 {"name": "cut", "eye": [0, 0, 9], "target": [0, 0, 0], "ortho_height": 4, "sections": [[1, 0, 0, 0]],
  "hidden": [{"path": "PREFIXleft/room", "at": [-4, 0, 0.5]}], "note": "half a wall",
  "annotations": [{"text": "here", "at": [0, 0, 0]}]},
 {"name": "gone", "eye": [0, 0, 9], "target": [0, 0, 0], "ortho_height": 4, "hidden": [{"path": "no such thing"}]}]}
END
prefix=$(show street.stip --pick 60,20 --size 120x40 --ortho 4 --eye 0,0,9 --target 0,0,0 |
    python3 -c 'import json,sys; print(json.load(sys.stdin)["object"]["path"][:-len("wall")])')
sed -i "s|PREFIX|$prefix|" street.views.json
show street.stip -o v.png --size 120x40 --view cut --json > v.json 2> err || fail "viewpoint: $(cat err)"
grep -q '"covered_pixels": 200' v.json || fail "the viewpoint shows a different picture: $(cat v.json)"
show street.stip -o v.png --size 120x40 --view gone 2> err || fail "viewpoint: $(cat err)"
grep -q "no such thing" err || fail "a missing object is not named: $(cat err)"
echo '{' > street.views.json
show street.stip -o v.png --size 120x40 --view cut 2> err
[ $? -eq 1 ] && grep -q "street.views.json: line" err || fail "a broken sidecar: $(cat err)"
show street.stip -o v.png --size 120x40 --view front || fail "a broken sidecar affects other views"

# objects by parts of their names
"$stipple" info street.stip --find DOO > found 2> err || fail "find: $(cat err)"
[ "$(wc -l < found)" -eq 2 ] && grep -q "left/room/door" found && grep -q "right/room/door" found || fail "finds $(cat found)"
"$stipple" info street.stip --find roo --json > pick.json || fail "find as JSON"
same 'len(p["found"]) == 2 and p["found"][0]["name"] == "room" and p["found"][0]["triangles"] == 4 and not p["more"]'
same 'p["found"][1]["children"] == 1 and p["found"][1]["index"] == 5'
"$stipple" info street.stip --find nowhere > found || fail "a search without results should succeed"
[ ! -s found ] || fail "finds a missing object"
# names may hold any bytes: JSON is UTF-8, and nothing controls a terminal
printf 'o caf\351\033[2J\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n' > bytes.obj
"$stipple" build bytes.obj -o bytes.stip --fresh > /dev/null 2> err || fail "bytes: $(cat err)"
"$stipple" info bytes.stip --find caf > found || fail "find of any bytes"
LC_ALL=C grep -q 'bytes.obj/caf' found || fail "finds $(cat -v found)"
LC_ALL=C grep -q $'\033' found && fail "prints terminal escapes: $(cat -v found)"
"$stipple" info bytes.stip --find caf --json > found.json || fail "find of any bytes as JSON"
"$stipple" render bytes.stip --pick 16,20 --size 32x32 --view front > pick.json || fail "pick of any bytes"
python3 - << 'END' || fail "names of any bytes: $(cat found.json pick.json)"
import json
found = json.load(open("found.json"))["found"][-1]
assert found["name"].startswith("caf?") and found["path"].startswith("bytes.obj/caf?"), found
assert json.load(open("pick.json"))["object"]["path"] == found["path"]
END
"$stipple" info street.gltf --find door 2> err
[ $? -eq 2 ] || fail "--find of a model"

# a flight shows the same
echo '{"keys": [{"t": 0, "eye": [0, 0, 9], "target": [0, 0, 0]}, {"t": 0.05, "eye": [0, 0, 8], "target": [0, 0, 0]}]}' > f.json
"$stipple" fly street.stip --backend cpu --path f.json -o frames/ --size 60x40 --frames 2 --pixel-filter off --hide wall --section x:0 -q > /dev/null 2> err ||
    fail "fly: $(cat err)"
show street.stip -o f.png --accumulate 1 --size 60x40 --eye 0,0,9 --target 0,0,0 --hide wall --section x:0 || fail "first frame"
cmp -s f.png "$(find frames -name '*.png' | sort | head -n 1)" || fail "fly and render draw different pictures"

refused 2 "no object named" render street.stip -o r.png --size 32x32 --hide attic
refused 2 "--section must be" render street.stip -o r.png --size 32x32 --section x
refused 2 "--section must be" render street.stip -o r.png --size 32x32 --section 0,0,0,1
refused 2 "--section must be" render street.stip -o r.png --size 32x32 --section x:1 --section x:a
refused 2 "--section-box must be" render street.stip -o r.png --size 32x32 --section-box 1,2,3
refused 2 "--pick needs" render street.stip -o r.png --size 32x32 --pick 7
# a box of the whole scene, and planes at its ends, cut nothing, though stored positions are rounded
python3 - << 'END'
from math import cos, sin
with open("cup.obj", "w") as out:
    n = 24
    for k in range(2):
        out.writelines(f"v {(0.7 + k / 3) * cos(i * 6.2831853 / n):.5f} {k / 3:.5f} {(0.7 + k / 3) * sin(i * 6.2831853 / n):.5f}\n"
                       for i in range(n))
    for i in range(n):
        a, b = i + 1, (i + 1) % n + 1
        out.write(f"f {a} {a + n} {b}\nf {b} {a + n} {b + n}\n")
    out.write("f " + " ".join(str(i + 1) for i in range(n)) + "\n")
END
"$stipple" -q build cup.obj -o cup.stip || fail "no build of a cup"
show cup.stip -o whole_cup.png --size 80x60 -q || fail "no cup"
for cut in "--section-box 0%,0%,0%,100%,100%,100%" "--section x:100% --section -y:0%"; do
    # shellcheck disable=SC2086
    show cup.stip -o cut_cup.png --size 80x60 -q $cut || fail "no cup with $cut"
    cmp -s cut_cup.png whole_cup.png || fail "$cut changes the picture"
done

exit $((failures > 0))
