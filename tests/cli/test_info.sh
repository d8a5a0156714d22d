#!/usr/bin/env bash
# stipple info: the table of parts, JSON, and files of any size. Arguments: executable, scratch
# folder, source folder.
set -u
stipple=$1
scratch=$2
golden=$3/tests/golden/store/v1
. "$(dirname "$0")/shared.sh"
mkdir -p "$scratch" && cd "$scratch" || exit 1
rm -rf ./*
# run CODE COMMAND ARGUMENTS...: stdout to out, stderr to err
run()
{
    local wanted=$1
    shift
    "$stipple" "$@" > out 2> err
    local code=$?
    [ "$code" = "$wanted" ] || fail "$*: exit $code, not $wanted: $(cat err)"
}

figure()
{
    python3 -c 'import json, sys; d = json.load(open("out")); print(eval(sys.argv[1], {"d": d}))' "$1"
}

# a plant: a hall with 40 uses of one motor (a mesh of two materials), and a wall; below one site
python3 - << 'END'
import base64
import json
import struct
positions, indices = [], []
for y in range(31):
    for x in range(31):
        positions += [x / 30, (x * 7 + y * 3) % 5 / 20, y / 30]
for y in range(30):
    for x in range(30):
        a = y * 31 + x
        indices += [a, a + 31, a + 1, a + 1, a + 31, a + 32]
data = struct.pack(f"<{len(positions)}f", *positions) + struct.pack(f"<{len(indices)}I", *indices)
size = len(positions) * 4
motors = [{"name": f"motor {i}", "mesh": 0, "translation": [2 * i, 0, 0]} for i in range(40)]
json.dump({
    "asset": {"version": "2.0"},
    "scene": 0,
    "scenes": [{"nodes": [0]}],
    "nodes": [{"name": "site", "children": [1, 2]},
              {"name": "hall", "children": list(range(3, 43))},
              {"name": "wall\u00e9", "mesh": 1, "translation": [0, 5, 0]}] + motors,
    "materials": [{"name": "steel"}, {"name": "paint", "pbrMetallicRoughness": {"roughnessFactor": 0.5}}],
    "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1, "material": 0},
                               {"attributes": {"POSITION": 0}, "indices": 2, "material": 1}]},
               {"primitives": [{"attributes": {"POSITION": 0}, "indices": 2, "material": 0}]}],
    "accessors": [{"bufferView": 0, "componentType": 5126, "count": 961, "type": "VEC3",
                   "min": [0, 0, 0], "max": [1, 0.2, 1]},
                  {"bufferView": 1, "componentType": 5125, "count": 4800, "type": "SCALAR"},
                  {"bufferView": 1, "byteOffset": 19200, "componentType": 5125, "count": 600, "type": "SCALAR"}],
    "bufferViews": [{"buffer": 0, "byteLength": size}, {"buffer": 0, "byteOffset": size, "byteLength": 21600}],
    "buffers": [{"byteLength": len(data),
                 "uri": "data:application/octet-stream;base64," + base64.b64encode(data).decode()}],
}, open("plant.gltf", "w"))
END

parts="[(p['name'], p['objects'], p['unique_objects'], p['triangles'], p['unique_triangles'], p['instances']) for p in d['parts']]"
wanted="[('hall', 40, 1, 72000, 1800, 80), ('wallé', 1, 1, 200, 200, 1)]"
run 0 info plant.gltf --json
[ "$(figure "$parts")" = "$wanted" ] || fail "parts of a model: $(figure "$parts")"
[ "$(figure "d['objects'], d['unique_objects'], d['triangles'], d['format_version']")" = "(41, 2, 72200, None)" ] \
    || fail "figures of a model: $(cat out)"
run 0 build plant.gltf -o plant.stip --surfels 500 --surfel-ratio 0.001 --resolution 64 --quiet
run 0 info plant.stip --json
[ "$(figure "$parts")" = "$wanted" ] || fail "parts: $(figure "$parts")"
[ "$(figure "d['objects'], d['unique_objects'], d['triangles'], d['format_version']")" = "(41, 2, 72200, 1)" ] \
    || fail "figures: $(cat out)"
[ "$(figure "d['splat_bytes'] > 0 and d['lods'] > 0 and d['unique_lods'] > 0 and d['surfels'] > 0")" = True ] \
    || fail "surfels: $(cat out)"
keys="objects unique_objects lods unique_lods triangles unique_triangles points surfels unique_surfels
      triangle_bytes splat_bytes texture_bytes"
for key in $keys; do
    [ "$(figure "all('$key' in p for p in d['parts'])")" = True ] || fail "parts lack $key"
done

# the table: aligned, each part and the total
run 0 info plant.stip
for line in '^  hall +40 +\(1\) .* 72,000 +\(1,800\) ' '^  wallé +1 +\(1\) .* 200 +\(200\) ' \
    '^  total +41 +\(2\) .* 72,200 +\(' '^  sources +plant.gltf \(gltf, ' '^plant.stip: .*, .stip version 1\.'; do
    grep -Eq "$line" out || fail "no line $line: $(cat out)"
done
python3 - << 'END' || fail "columns are not aligned: $(cat out)"
lines = open("out", encoding="utf-8").read().split("\n\n")[1].splitlines()
assert len(lines) == 4, lines
assert len({len(line) for line in lines}) == 1, lines
END

# levels of triangles: a wavy sheet has some, the plant has none
grep -q '^  levels ' out && fail "levels that are not there: $(cat out)"
python3 - << 'END'
import math
with open("sheet.obj", "w") as f:
    for y in range(61):
        for x in range(61):
            f.write(f"v {x / 60} {0.02 * math.sin(x / 9) * math.cos(y / 7):.6f} {y / 60}\n")
    for y in range(60):
        for x in range(60):
            a = y * 61 + x + 1
            f.write(f"f {a} {a + 61} {a + 1}\nf {a + 1} {a + 61} {a + 62}\n")
END
run 0 build sheet.obj -o sheet.stip --quiet
run 0 info sheet.stip --json
[ "$(figure "d['levels'] > 0, 0 < d['level_triangles'] < 7200, 0 < d['level_bytes'] < d['file_bytes']")" \
    = "(True, True, True)" ] || fail "levels: $(cat out)"
run 0 info sheet.stip
grep -Eq '^  levels +[0-9.]+ KB  \([0-9]+ levels of [0-9,]+ triangles\)$' out || fail "no levels: $(cat out)"
run 0 build sheet.obj -o bare.stip --levels off --quiet
run 0 info bare.stip --json
[ "$(figure "d['levels'], d['level_triangles'], d['level_bytes']")" = "(0, 0, 0)" ] || fail "no levels: $(cat out)"

# a file of version 1.0 has no summary: the figures come from its tables
run 0 info "$golden/sample.stip" --json
[ "$(figure "d['format_version'], d['format_minor']")" = "(1, 0)" ] || fail "version 1.0: $(cat out)"
run 0 info "$golden/sample-1.1.stip" --json
[ "$(figure "d['format_minor'], len(d['parts']) > 0, len(d['views']) > 0")" = "(1, True, True)" ] \
    || fail "version 1.1: $(cat out)"
run 0 info "$golden/sample.stip"

# names cannot control terminals; long ones are shortened between characters
python3 - << 'END'
import json
scene = json.load(open("plant.gltf"))
scene["nodes"][1]["name"] = "\u001b[31m" + 40 * "\u00e9"
json.dump(scene, open("odd.gltf", "w"))
END
run 0 info odd.gltf
grep -q "$(printf '\033')" out && fail "an escape sequence from the file"
python3 -c 'open("out", encoding="utf-8").read()' || fail "a name was cut within a character"

# damage in the data it reads is detected and reported in one sentence
python3 - "$golden/sample-1.1.stip" << 'END'
import struct
import sys
data = bytearray(open(sys.argv[1], "rb").read())
for i in range(struct.unpack_from("<I", data, 32)[0]):
    kind, _, offset, _ = struct.unpack_from("<IIQQ", data, 128 + 40 * i)
    if kind == 19:
        data[offset + 8] ^= 1
open("damaged.stip", "wb").write(data)
END
run 1 info damaged.stip
[ ! -s out ] || fail "output: $(cat out)"
[ "$(wc -l < err)" = 1 ] || fail "not exactly one sentence: $(cat err)"
grep -q 'checksum of the section of type 19' err || fail "fault: $(cat err)"
run 1 check damaged.stip --quick

# formats, and corrections of what a model says about itself
run 0 info --formats
grep -q '^LAS, LAZ, COPC *las laz$' out || fail "formats: $(cat out)"
grep -qw 'wrl' out && fail "a format that cannot be read is listed"
run 0 info --formats --json
python3 -c 'import json
assert {"format": "gltf", "title": "glTF 2.0", "suffixes": "gltf glb"} in json.load(open("out"))["formats"]' || fail "$(cat out)"
printf 'v 0 0 0\nv 1 0 0\nv 0 2 0\nf 1 2 3\n' > flat.obj
run 0 info flat.obj --up z --unit mm --json
python3 -c 'import json
f = json.load(open("out"))
assert (f["up"], f["unit"], f["bounds"]["max"]) == ("z", "mm", [1, 0, 0]), f' || fail "$(cat out)"
for up in "" "--model-up z"; do
    # shellcheck disable=SC2086
    "$stipple" -q render flat.obj -o flat.png --size 8x8 --ortho 4 --view front --once $up --json > flat.json || fail "render $up"
    # shellcheck disable=SC2086
    "$stipple" -q thumbnail flat.obj -o "small${up:+_z}.png" --size 16x16 --view top $up || fail "thumbnail $up"
    [ "$(value flat.json covered_pixels)" -gt 0 ] || [ -n "$up" ] || fail "nothing is seen from the front"
done
cmp -s small.png small_z.png && fail "--model-up does not turn a model"

# single-sided surfaces of glTF: a sheet, and a closed body whose fronts face inwards
python3 << 'END'
import base64, json, struct
corners = struct.pack("<12f", 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1)
sheet, body = struct.pack("<6H", 0, 1, 2, 0, 1, 2), struct.pack("<12H", 0, 1, 2, 0, 3, 1, 0, 2, 3, 1, 3, 2)
data = corners + sheet + body
views = [(0, 48), (48, 6), (60, 24)]
json.dump({
    "asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0, 1]}],
    "nodes": [{"mesh": 0}, {"mesh": 1, "translation": [5, 0, 0]}],
    "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "indices": i, "material": 0}]} for i in (1, 2)],
    "materials": [{"name": "paint"}],
    "accessors": [{"bufferView": 0, "componentType": 5126, "count": 4, "type": "VEC3", "min": [0, 0, 0],
                   "max": [1, 1, 1]}] +
                 [{"bufferView": i, "componentType": 5123, "count": n, "type": "SCALAR"} for i, n in ((1, 3), (2, 12))],
    "bufferViews": [{"buffer": 0, "byteOffset": at, "byteLength": size} for at, size in views],
    "buffers": [{"byteLength": len(data), "uri": "data:;base64," + base64.b64encode(data).decode()}],
}, open("sides.gltf", "w"))
END
"$stipple" build sides.gltf -o sides.stip > /dev/null 2> err || fail "sides.gltf"
grep -q 'face inwards, and only their inside is drawn: 1' err || fail "inverted: $(cat err)"
for file in sides.gltf sides.stip; do
    run 0 info $file
    grep -q 'one side  *5  triangles of 1 single-sided materials' out || fail "sides of $file: $(cat out)"
    grep -q 'inverted  *1  closed meshes face inwards: --back-faces on shows' out || fail "inverted in $file: $(cat out)"
    run 0 info $file --json
    [ "$(value out single_sided_triangles) $(value out inverted_meshes)" = "5 1" ] || fail "sides of $file: $(cat out)"
done
sheet=(-q render sides.stip -o sheet.png --size 16x16 --ortho 1 --once --json)
"$stipple" "${sheet[@]}" --eye 0.2,0.2,5 --target 0.2,0.2,0 > sheet.json || fail "front"
[ "$(value sheet.json covered_pixels)" -gt 50 ] || fail "the front of a sheet is not drawn"
"$stipple" "${sheet[@]}" --eye 0.2,0.2,-5 --target 0.2,0.2,0 > sheet.json 2> /dev/null || fail "back"
[ "$(value sheet.json covered_pixels)" = 0 ] || fail "the back of a single-sided sheet is drawn"
"$stipple" "${sheet[@]}" --eye 0.2,0.2,-5 --target 0.2,0.2,0 --back-faces on > sheet.json || fail "--back-faces"
[ "$(value sheet.json covered_pixels)" -gt 50 ] || fail "--back-faces on draws no backs"
exit $((failures != 0))
