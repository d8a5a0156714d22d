#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# Pipes and folders instead of files, file size limits, and folders created by others: one sentence,
# without blocking. Arguments: executable, scratch folder.
# needs: stipple-lab
set -u
stipple=$1
scratch=$2
rm -rf "$scratch"
. "$(dirname "$0")/shared.sh"
mkdir -p "$scratch" && cd "$scratch" || exit 1
export XDG_CACHE_HOME=$PWD/cache

printf 'v 0 0 0\nv 1 0 0\nv 1 2 0\nv 0 2 0\nf 1 2 3 4\n' > box.obj
"$stipple" build box.obj -o box.stip -q || fail "build"
"$stipple" render box.stip --size 32x32 -o box.png -q || fail "render"

# a pipe without a writer does not block; the descriptor keeps a failure from hanging the test
mkfifo pipe pipe.stip pipe.obj pipe.png
exec 8<> pipe 9<> pipe.stip 10<> pipe.obj 11<> pipe.png
for name in pipe pipe.stip pipe.obj; do
    for command in info check build render; do
        case $command in
            build) more=(-o out.stip) ;;
            render) more=(-o out.png) ;;
            *) more=() ;;
        esac
        [ $command = check ] && [ $name != pipe.stip ] && continue
        refused 1 "is not a regular file" $command $name "${more[@]}"
    done
done
refused 1 "is not a regular file" compare box.png pipe.png
refused 1 "is not a regular file" fly box.stip --path pipe --frames 2
exec 8>&- 9>&- 10>&- 11>&-

# a file that must not grow: a sentence instead of a signal, and no output
"$stipple" scene city-small --scale 0.05 -o scene.glb -q || fail "scene"
(
    ulimit -f 16
    refused 1 "File too large" build scene.glb -o large.stip
    [ $failures -eq 0 ]
) || fail "a limit of file sizes"
[ ! -e large.stip ] || fail "an output that was cut off is kept"

# without a home folder, built models go to a folder that only its owner can write to
folder=/tmp/stipple-$(id -u)
if [ ! -e "$folder" ]; then
    mkdir -m 777 "$folder"
    chmod 777 "$folder"
    (
        unset XDG_CACHE_HOME HOME
        refused 1 "writable by others" render box.obj --size 32x32 -o box.png
        [ $failures -eq 0 ]
    ) || fail "a folder that others may write"
    rmdir "$folder"
fi

# pictures that claim more pixels than their bytes justify: by a palette, by many copies, by many
# files
python3 - << 'END'
import base64, json, struct, zlib
def png(side):
    def chunk(kind, data):
        return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))
    rows = zlib.compressobj(9)
    data = b"".join(rows.compress(bytes(1 + side // 8)) for _ in range(side)) + rows.flush()
    return (b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", struct.pack(">2I5B", side, side, 1, 0, 0, 0, 0)) +
            chunk(b"IDAT", data) + chunk(b"IEND", b""))
open("flat.png", "wb").write(png(16384))
small = base64.b64encode(png(8192)).decode()
modes = [{"wrapS": s, "wrapT": t} for s in (10497, 33071) for t in (10497, 33071)]
corners = base64.b64encode(struct.pack("<9f", 0, 0, 0, 1, 0, 0, 0, 1, 0) + bytes(24)).decode()
json.dump({"asset": {"version": "2.0"}, "scenes": [{"nodes": [0]}], "nodes": [{"mesh": 0}],
           "meshes": [{"primitives": [{"attributes": {"POSITION": 0, "TEXCOORD_0": 1}, "material": m} for m in range(4)]}],
           "materials": [{"pbrMetallicRoughness": {"baseColorTexture": {"index": m}}} for m in range(4)],
           "textures": [{"source": 0, "sampler": m} for m in range(4)], "samplers": modes,
           "images": [{"uri": "data:image/png;base64," + small}],
           "accessors": [{"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3", "min": [0, 0, 0], "max": [1, 1, 0]},
                         {"bufferView": 0, "byteOffset": 36, "componentType": 5126, "count": 3, "type": "VEC2"}],
           "bufferViews": [{"buffer": 0, "byteLength": 60}],
           "buffers": [{"byteLength": 60, "uri": "data:application/octet-stream;base64," + corners}]}, open("copies.gltf", "w"))
with open("many.obj", "w") as obj, open("many.mtl", "w") as mtl:
    obj.write("mtllib many.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\n")
    for i in range(8):
        open(f"p{i}.png", "wb").write(png(4096))
        mtl.write(f"newmtl m{i}\nmap_Kd p{i}.png\n")
        obj.write(f"usemtl m{i}\nf 1/1 2/1 3/1\n")
END
refused 1 "pixels" compare flat.png flat.png
refused 1 "the pictures claim" build copies.gltf -o copies.stip
python3 - "$stipple" << 'END' || fail "many.obj is not built, or with more than 3 GB: $(cat many.out)"
import resource, subprocess, sys
with open("many.out", "w") as out:
    subprocess.run([sys.argv[1], "build", "many.obj", "-o", "many.stip"], stdout=out, stderr=out, check=True)
assert resource.getrusage(resource.RUSAGE_CHILDREN).ru_maxrss < 3000000
END
grep -q "p7.png is left out: the pictures of the file claim too many pixels" many.out || fail "all pictures are decoded: $(cat many.out)"
[ "$(grep -c 'is left out' many.out)" -eq 4 ] || fail "not four pictures are left out: $(cat many.out)"

# links beside a model: followed within its folder, even if the folder is reached by a link; not out
# of it
mkdir -p shared/textures
printf 'newmtl a\nKd 1 0 0\n' > secret.mtl
cp secret.mtl shared/textures/inner.mtl
ln -s ../secret.mtl shared/out.mtl
ln -s textures/inner.mtl shared/in.mtl
ln -s shared linked
for name in in out; do
    printf 'mtllib %s.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl a\nf 1 2 3\n' $name > shared/$name.obj
done
for folder in shared linked; do
    "$stipple" build $folder/in.obj -o in.stip > link.out 2>&1 || fail "in.obj is not built"
    ! grep -q "left out" link.out || fail "a link within the folder is refused: $(cat link.out)"
    "$stipple" build $folder/out.obj -o in.stip > link.out 2>&1 || fail "out.obj is not built"
    grep -q 'out.mtl" is left out: it is a link out of the folder' link.out || fail "a link is followed: $(cat link.out)"
done

# models read by assimp follow the same rules for file names: only their own files, and none that
# blocks
mkdir -p assembly/parts outside
printf 'v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n' > assembly/parts/good.obj
cp assembly/parts/good.obj outside/secret.obj
ln -s ../outside/secret.obj assembly/link.obj
mkfifo assembly/pipe.obj
triangles_of() # REFERENCE: how many a LightWave scene that names it has
{
    printf 'LWSC\n3\n\nLoadObjectLayer 1 %s\n' "$1" > assembly/scene.lws
    "$stipple" info assembly/scene.lws --json 2> lws.err |
        python3 -c 'import json, sys; print(json.load(sys.stdin)["triangles"])'
}
[ "$(triangles_of parts/good.obj)" = 1 ] || fail "a file below the model is not read: $(cat lws.err)"
for name in ../outside/secret.obj "$PWD/outside/secret.obj" link.obj pipe.obj; do
    [ "$(triangles_of "$name")" = 0 ] || fail "$name is read, or not left out: $(cat lws.err)"
    [ "$name" = pipe.obj ] || grep -q "is left out: it " lws.err || fail "$name is left out without a warning"
done

# names with terminal control sequences: no control character is printed, and no line is forged
python3 - << 'END'
import base64, json, struct
evil = "\x1b]0;owned\x07\x1b[2J\nstipple: forged\r\u202e\u009b31m"
data = struct.pack("<9f", 0, 0, 0, 1, 0, 0, 0, 1, 0)
json.dump({"asset": {"version": "2.0"}, "scenes": [{"nodes": [0, 1]}], "extensionsUsed": [evil],
           "nodes": [{"mesh": 0, "name": evil}, {"camera": 0, "name": evil}], "meshes": [
               {"name": evil, "primitives": [{"attributes": {"POSITION": 0}, "material": 0}]}],
           "materials": [{"name": evil, "pbrMetallicRoughness": {"baseColorTexture": {"index": 0}}}],
           "textures": [{"source": 0}], "images": [{"uri": evil + ".png"}],
           "cameras": [{"type": "perspective", "name": evil, "perspective": {"yfov": 1, "znear": 1}}],
           "accessors": [{"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3",
                          "min": [0, 0, 0], "max": [1, 1, 0]}],
           "bufferViews": [{"buffer": 0, "byteLength": 36}],
           "buffers": [{"byteLength": 36, "uri": "data:application/octet-stream;base64," + base64.b64encode(data).decode()}]},
          open("evil.gltf", "w"))
END
evil_file=$(printf 'evil\033[31m\nstipple: forged.stip')
"$stipple" build evil.gltf -o "$evil_file" -v > evil.out 2>&1 || fail "evil.gltf is not built: $(cat -v evil.out)"
"$stipple" info "$evil_file" >> evil.out 2>&1 || fail "its file is not described"
"$stipple" info "$evil_file" --json > evil.json || fail "its file is not described as JSON"
"$stipple" info "$evil_file" --json >> evil.out 2>&1 || fail "its file is not described as JSON"
"$stipple" info "$evil_file" --find owned >> evil.out 2>&1 || fail "its names are not found"
"$stipple" render "$evil_file" --view nothing -o box.png >> evil.out 2>&1 && fail "an unknown view is drawn"
"$stipple" check "$evil_file" >> evil.out 2>&1 || fail "its file is not right"
python3 - << 'END' || fail "control characters from a file are printed: $(cat -v evil.out)"
import re
text = open("evil.out", encoding="utf-8").read() # and all of it is UTF-8
assert "x1b" in text
assert not re.search("[\x00-\x08\x0b-\x1f\x7f-\x9f\u202a-\u202e]", text)
assert not re.search("^stipple: forged", text, re.M)
END

[ $failures -eq 0 ] && echo "ok"
exit $((failures != 0))
