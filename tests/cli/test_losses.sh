#!/usr/bin/env bash
# One warning reports skipped content of an input; unreadable files are named. Arguments:
# executable, scratch folder.
set -u
stipple=$1
scratch=$2
rm -rf "$scratch"
. "$(dirname "$0")/shared.sh"
mkdir -p "$scratch" && cd "$scratch" || exit 1

python3 - << 'END' || exit 1
import base64, json, struct
data = struct.pack("<9f", 0, 0, 0, 1, 0, 0, 0, 1, 0)
buffer = {"byteLength": len(data), "uri": "data:application/octet-stream;base64," + base64.b64encode(data).decode()}
accessor = {"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3", "min": [0, 0, 0], "max": [1, 1, 0]}
plain = {"asset": {"version": "2.0"}, "scenes": [{"nodes": [0]}], "nodes": [{"mesh": 0}],
         "meshes": [{"primitives": [{"attributes": {"POSITION": 0}}]}], "accessors": [accessor],
         "bufferViews": [{"buffer": 0, "byteLength": 36}], "buffers": [buffer]}
def write(name, **changes):
    json.dump({**plain, **changes}, open(name, "w"))
write("plain.gltf")
write("rich.gltf", extensionsUsed=["KHR_lights_punctual", "KHR_texture_transform", "EXT_x"],
      scenes=[{"nodes": [0, 1]}, {"nodes": [1]}], cameras=[{"type": "orthographic"}],
      nodes=[{"mesh": 0}, {"camera": 0}],
      animations=[{"channels": [{"sampler": 0, "target": {"node": 0, "path": "translation"}}],
                   "samplers": [{"input": 0, "output": 0}]}],
      meshes=[{"primitives": [{"attributes": {"POSITION": 0}, "targets": [{"POSITION": 0}]},
                              {"attributes": {"POSITION": 0}, "targets": [{"POSITION": 0}], "mode": 1}]}])
write("many.gltf", extensionsUsed=[f"EXT_{'long' * 20}_{i}" for i in range(40)])
json.dump({"asset": {"version": "1.0"}, "meshes": {"a": {}}}, open("old.gltf", "w"))
open("old.glb", "wb").write(b"glTF" + struct.pack("<II", 1, 20) + b"\0" * 8)
open("lines.obj", "w").write("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\nl 1 2\nl 2 3\n")
open("part.stp", "w").write("ISO-10303-21;\nHEADER;\nFILE_SCHEMA(('AUTOMOTIVE_DESIGN'));\nENDSEC;\n")
open("part", "w").write("ISO-10303-21;\nHEADER;\nFILE_SCHEMA(('CONFIG_CONTROL_DESIGN'));\nENDSEC;\n")
open("house.ifc", "w").write("ISO-10303-21;\nHEADER;\nFILE_SCHEMA(('IFC2X3'));\nENDSEC;\n")
open("part.igs", "w").write(" " * 72 + "S      1\n" + " " * 72 + "G      1\n")
END

# said FILE TEXT: its build succeeds with one warning, TEXT
said()
{
    "$stipple" build "$1" -o out.stip > out 2> err || fail "$1: $(cat err)"
    [ "$(grep -c warning err)" -eq 1 ] || fail "$1 does not print exactly one warning: $(cat err)"
    grep -qxF "stipple: warning: $1: not kept: $2" err || fail "$1 does not say what is lost: $(cat err)"
}
said rich.gltf "1 animation (drawn in the stored pose); 1 morph target (drawn at the stored weights); 1 line element; \
1 camera without perspective; 1 additional scene; extensions KHR_lights_punctual, EXT_x"
said lines.obj "2 line elements"
"$stipple" build plain.gltf -o out.stip > out 2> err || fail "plain: $(cat err)"
[ ! -s err ] || fail "a completely imported model warns: $(cat err)"
"$stipple" build rich.gltf -o out.stip -q > out 2> err || fail "quiet: $(cat err)"
[ ! -s err ] || fail "-q warns: $(cat err)"
"$stipple" build many.gltf -o out.stip > out 2> err || fail "many: $(cat err)"
grep -q "and [0-9]* more$" err || fail "many extensions are not counted: $(cat err)"

skinned=/usr/share/assimp/models/FBX/animation_with_skeleton.fbx
if [ -e $skinned ]; then
    "$stipple" build $skinned -o out.stip > out 2> err || fail "skinned: $(cat err)"
    grep -q "not kept: 1 animation (drawn in the stored pose); 1 skin (drawn in the stored pose); 1 light$" err ||
        fail "a skinned FBX does not list its losses: $(cat err)"
fi

for old in old.gltf old.glb; do
    refused 1 "it is glTF 1.0, which is not supported: convert it to glTF 2.0" build $old -o out.stip
done
refused 1 "is STEP, which contains exact surfaces instead of triangles.*export glTF" build part.stp -o out.stip
refused 1 "is STEP" build part -o out.stip
refused 1 "is IGES" build part.igs -o out.stip
"$stipple" build house.ifc -o out.stip > out 2> err
! grep -q STEP err || fail "IFC is taken for STEP: $(cat err)"
exit $((failures > 0))
