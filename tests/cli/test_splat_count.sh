#!/usr/bin/env bash
# --splats N draws exactly N splats of a psp set, or all if there are fewer, even if several nodes
# share them; on both backends, with any number of threads, for truncated files, in flights, and
# with hidden parts. Arguments: executable, scratch folder.
# needs: stipple-lab
set -u
stipple=$1
# shellcheck source=/dev/null
. "$(dirname "$0")/shared.sh"
mkdir -p "$2" && cd "$2" || exit 1
rm -rf ./*

# a static ball and a moving one: the picture has a set of each
python3 - << 'END'
import base64, json, math, struct

SIDE = 40
points = [(math.cos(2 * math.pi * i / SIDE) * math.sin(math.pi * k / SIDE), math.cos(math.pi * k / SIDE),
           math.sin(2 * math.pi * i / SIDE) * math.sin(math.pi * k / SIDE))
          for k in range(SIDE + 1) for i in range(SIDE + 1)]
corners = []
for k in range(SIDE):
    for i in range(SIDE):
        a = k * (SIDE + 1) + i
        corners += [a, a + 1, a + SIDE + 1, a + 1, a + SIDE + 2, a + SIDE + 1]
columns = [b"".join(struct.pack("<3f", *p) for p in points), struct.pack(f"<{len(corners)}H", *corners),
           struct.pack("<2f", 0, 1), struct.pack("<6f", 3, 0, 0, 4, 0, 0)]
data, views = b"", []
for column in columns:
    views.append({"buffer": 0, "byteOffset": len(data), "byteLength": len(column)})
    data += column
json.dump({
    "asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0, 1]}],
    "nodes": [{"mesh": 0, "name": "rests"}, {"mesh": 0, "name": "moves", "translation": [3, 0, 0]}],
    "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1}]}],
    "animations": [{"channels": [{"sampler": 0, "target": {"node": 1, "path": "translation"}}],
                    "samplers": [{"input": 2, "output": 3}]}],
    "accessors": [
        {"bufferView": 0, "componentType": 5126, "count": len(points), "type": "VEC3", "min": [-1, -1, -1], "max": [1, 1, 1]},
        {"bufferView": 1, "componentType": 5123, "count": len(corners), "type": "SCALAR"},
        {"bufferView": 2, "componentType": 5126, "count": 2, "type": "SCALAR", "min": [0], "max": [1]},
        {"bufferView": 3, "componentType": 5126, "count": 2, "type": "VEC3"}],
    "bufferViews": views,
    "buffers": [{"byteLength": len(data), "uri": "data:application/octet-stream;base64," + base64.b64encode(data).decode()}],
}, open("balls.gltf", "w"))
END
"$stipple" -q build balls.gltf -o balls.stip --method psp --surfels 2000 --surfel-ratio 0.001 || fail "no build of balls"
"$stipple" -q build scene:spheres,scale=0.1 -o spheres.stip --method psp --surfels 8000 --surfel-ratio 0.001 || fail "no build of spheres"

camera="--eye 10,8,12" # a standard view of a truncated file may lie beside that of the whole file
draw() # FILE NAME COUNT OPTIONS...: a picture of so many splats
{
    "$stipple" render "$1" -o "$2.png" $camera --size 240x160 --splats "$3" --once --json "${@:4}" > "$2.json" 2> err ||
        fail "render $*: $(cat err)"
}

counts() # FILE BACKEND ALL COUNTS...
{
    local n
    for n in "${@:4}"; do
        draw "$1" "$2-$n" "$n" --backend "$2"
        [ "$(value "$2-$n.json" listed_splats)" = $((n < $3 ? n : $3)) ] ||
            fail "$1 by $2: $(value "$2-$n.json" listed_splats) splats are not $n"
    done
}

likeness() # PICTURE: to the original triangles
{
    "$stipple" compare "$1" whole.png --json > compare.json || fail "compare $1"
    value compare.json ssim_covered
}

backends=cpu
if "$stipple" render spheres.stip -o gl.png --size 8x8 --once --backend gl 2> /dev/null; then
    backends="cpu gl"
fi
for file in balls spheres; do
    all=$([ $file = balls ] && echo 4000 || echo 8000)
    "$stipple" -q render $file.stip -o whole.png $camera --size 240x160 --once --reference || fail "no original of $file"
    counts $file.stip cpu "$all" 1 2 7 64 333 1001 1999 2500 1000000
    [ "$backends" = cpu ] || counts $file.stip gl "$all" 1 64 1001 2500 1000000
    a=$(likeness cpu-7.png) b=$(likeness cpu-64.png) c=$(likeness cpu-333.png) d=$(likeness cpu-1999.png)
    holds "$a <= $b && $b <= $c && $c <= $d && $a < $d" ||
        fail "$file: more splats are no nearer to the original: $a $b $c $d"
    for n in 64 1001; do
        for threads in 1 3; do
            draw $file.stip threads $n --threads $threads
            cmp -s threads.png cpu-$n.png || fail "$file: $n splats differ with $threads threads"
        done
        draw $file.stip limited $n --memory 64M
        cmp -s limited.png cpu-$n.png || fail "$file: $n splats differ under a limit of memory"
        [ "$(value limited.json listed_splats)" = $n ] || fail "$file under a limit: $(value limited.json listed_splats) splats"
        if [ "$backends" != cpu ]; then
            "$stipple" compare cpu-$n.png gl-$n.png --json > compare.json || fail "compare"
            holds "$(value compare.json ssim) > 0.98" || fail "$file: backends differ at $n splats"
        fi
    done
done

# only splats, even for moving parts
for n in 1 7 1001; do
    [ "$(value cpu-$n.json triangles)" = 0 ] || fail "triangles beside $n splats"
done

# with a hidden part, the other sets share the count; parts without a set are drawn by their
# triangles, independent of the number of splats
camera=""
"$stipple" -q build scene:power-plant,scale=0.02 --threshold 500 -o plant.stip --method blue,psp || fail "no build of the plant"
for method in blue psp; do
    draw plant.stip none-hidden 300 --method $method
    [ "$(value none-hidden.json triangles)" = 0 ] || fail "$method: triangles where nothing is hidden"
    "$stipple" -q render plant.stip -o whole.png $camera --size 240x160 --once --reference --hide "#88" --json > whole.json ||
        fail "no original of the plant"
    beside=""
    for n in 1 40 300 3000; do
        draw plant.stip $method-hidden-$n $n --method $method --hide "#88"
        [ "$(value $method-hidden-$n.json listed_splats)" = $n ] ||
            fail "$method: $(value $method-hidden-$n.json listed_splats) splats are not $n where a part is hidden"
        triangles=$(value $method-hidden-$n.json listed_triangles)
        [ "${beside:=$triangles}" = "$triangles" ] || fail "$method: $triangles triangles beside $n splats are not $beside"
    done
    [ "$beside" -lt $(($(value whole.json listed_triangles) / 4)) ] || fail "$method: $beside triangles beside splats"
    few=$(likeness $method-hidden-300.png) many=$(likeness $method-hidden-3000.png)
    holds "$few < $many && $many > 0.7" || fail "$method: splats are badly shared where a part is hidden: $few $many"
    draw plant.stip threads 300 --method $method --hide "#88" --threads 1
    cmp -s threads.png $method-hidden-300.png || fail "$method: one thread gives different shares"
    draw plant.stip limited 300 --method $method --hide "#88" --memory 64M
    [ "$(value limited.json listed_splats)" = 300 ] || fail "$method: $(value limited.json listed_splats) splats under a limit of memory"
done

# for a truncated file, as many as its prefix has
draw spheres.stip part 6000 --prefix 10%
drawn=$(value part.json listed_splats)
if [ "$drawn" -lt 100 ] || [ "$drawn" -ge 6000 ]; then
    fail "$drawn splats of a tenth of a file"
fi
camera="--eye 10,8,12"
draw spheres.stip part 50 --prefix 10%
draw spheres.stip whole 50
cmp -s part.png whole.png || fail "50 splats of a tenth of a file differ"

# compare-splats and fly
"$stipple" compare-splats balls.stip balls.gltf --splats 1234 --json > compare.json || fail "compare-splats"
[ "$(value compare.json splats)" = 1234 ] || fail "compare-splats takes $(value compare.json splats) splats"
cat > path.json << 'END'
{"fov": 60, "fps": 10, "keys": [{"t": 0, "eye": [0, 1, 9], "target": [2, 0, 0]}, {"t": 1, "eye": [4, 2, 9], "target": [2, 0, 0]}]}
END
for backend in $backends; do
    "$stipple" -q fly balls.stip --path path.json --splats 2345 --frames 3 --size 64x48 --backend "$backend" --json > fly.json ||
        fail "fly by $backend"
    python3 -c 'import json; assert [f["listed_splats"] for f in json.load(open("fly.json"))["per_frame"]] == [2345] * 3' ||
        fail "fly by $backend draws other numbers of splats"
done
[ $failures -eq 0 ]
