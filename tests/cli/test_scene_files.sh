#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# stipple-lab scene -o FILE.glb|FILE.gltf: reading the file gives the same scene as generating it
# directly. Arguments: executable, scratch folder, source folder.
# needs: stipple-lab
set -eu
stipple=$1 scratch=$2 source=$3
. "$(dirname "$0")/shared.sh"
rm -rf "$scratch"
mkdir -p "$scratch"
cd "$scratch"

fail() {
    echo "FAILED: $*" >&2
    exit 1
}

# What both stores have in common, and the names of two views. Blocks of splats and triangles are
# not decoded: the reader has a test of its own (tests/store/independent_reader.sh).
cat > compare.py << 'END'
import json, math, sys
sys.path.insert(0, sys.argv[1] + "/scripts")
import read_store
direct, file = json.load(open("direct.json")), json.load(open("file.json"))
for key in ("objects unique_objects instances nodes unique_nodes triangles unique_triangles points views unit up "
            "lods unique_lods triangle_bytes").split():
    assert direct[key] == file[key], (key, direct[key], file[key])
size = max(direct["bounds"]["max"][k] - direct["bounds"]["min"][k] for k in range(3))
for end in "min", "max":  # instances are floats in a file
    for a, b in zip(direct["bounds"][end], file["bounds"][end]):
        assert abs(a - b) <= 1e-6 * size, (end, a, b)
def read(name):
    data = open(name, "rb").read()
    return read_store.read_tables(read_store.read_sections(data, read_store.read_header(data)))
direct, file = read("direct.stip"), read("file.stip")
# a file says double-sided of all that is drawn from both sides; the flag changes no picture
used = lambda store: {tuple(sorted((k, str(v & ~2 if k == "flags" else v)) for k, v in store["materials"][i].items()))
                      for i in {mesh["material"] for mesh in store["meshes"]}}
assert used(direct) and used(direct) == used(file), "materials"
# shared groups are written out under the names of their users, and cameras are separate nodes
shown = lambda store: {o["name"] for o in store["objects"]} - {"production line", "plant, common part"}
assert shown(direct) <= shown(file), shown(direct) - shown(file)
for a, b in zip(direct["views"], file["views"]):
    assert a["name"] == b["name"] and abs(a["fov_degrees"] - b["fov_degrees"]) < 1e-9, (a, b)
    assert math.dist(a["eye"], b["eye"]) < 1e-6, (a, b)
print(*[view["name"] for view in direct["views"] if " " not in view["name"]][:2])
END

# same NAME SCALE OPTIONS...: builds NAME directly, from a .glb and from a .gltf, and compares the
# content
same() {
    local name=$1 scale=$2 view file
    shift 2
    "$stipple" build "scene:$name,scale=$scale" -o direct.stip --json "$@" > direct.json || fail "$name"
    for form in $forms; do
        "$stipple" scene "$name" --scale "$scale" -o "file.$form" -q || fail "$name as .$form"
        "$stipple" build "file.$form" -o file.stip --json --fresh "$@" > file.json || fail "$name from .$form"
        python3 compare.py "$source" > views || fail "$name as .$form differs"
        for view in $(< views); do
            for file in direct file; do
                "$stipple" render "$file.stip" --view "$view" --size 160x90 --reference -o "$file.png" || fail "$name $view"
            done
            "$stipple" compare direct.png file.png --json > compare.json
            holds "$(value compare.json ssim) >= 0.999" || fail "$name as .$form, view $view: $(cat compare.json)"
        done
        rm -f file.*
    done
}

forms="glb gltf"
same boxes 1
same city-small 0.005 --threshold 1000000000000
same terrain 0.0002 --threshold 1000000000000
forms=glb
same car-factory 0.0001 --threshold 1000000000000
same paper 0.0001 --threshold 1000000000000

# a scene with excessively shared nodes cannot be written
"$stipple" scene paper-huge --scale 0.001 -o huge.gltf 2> err && fail "paper-huge fits a file"
[ "$(wc -l < err)" = 1 ] || fail "not exactly one sentence: $(cat err)"
[ ! -e huge.gltf ] || fail "a file is left"
