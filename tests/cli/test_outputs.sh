#!/usr/bin/env bash
# Valid and invalid outputs; none replaces an input; colours and axes. Arguments: executable,
# scratch folder.
# needs: stipple-lab
set -u
stipple=$1
scratch=$2
rm -rf "$scratch"
. "$(dirname "$0")/shared.sh"
mkdir -p "$scratch" && cd "$scratch" || exit 1
export XDG_CACHE_HOME=$PWD/cache

printf 'v 0 0 0\nv 1 0 0\nv 1 2 0\nv 0 2 0\nv 0 0 3\nf 1 2 3 4\nf 1 2 5\n' > box.obj
"$stipple" build box.obj -o box.stip -q || fail "build"
draw()
{
    "$stipple" render box.stip --size 64x48 --backend cpu -q "$@" || fail "render $*"
}

# the name determines the picture format
draw -o a.png
draw -o a.PNG
draw -o a.jpg
draw -o b.jpeg
draw -o a.webp
draw -o a
python3 - << 'END' || fail "a picture does not have the format of its name"
for name, start, at in (("a.png", b"\x89PNG", 0), ("a.PNG", b"\x89PNG", 0), ("a.jpg", b"\xff\xd8\xff", 0),
                        ("b.jpeg", b"\xff\xd8\xff", 0), ("a.webp", b"WEBPVP8L", 8), ("a", b"\x89PNG", 0)):
    data = open(name, "rb").read()
    assert data[at:at + len(start)] == start, (name, data[:16])
END
cmp -s a.jpg b.jpeg || fail "the same picture gives different JPEG bytes"
for name in a.bmp a.tiff a.exr a.stip a.glb; do
    refused 2 "must end in .png, .jpg, .jpeg or .webp" render box.stip -o $name
    [ ! -e $name ] || fail "$name was written"
done
refused 2 "must end in .png" compare a.png a.PNG --map map.gif

# build writes .stip
for name in x.glb x.GLTF x.obj x.png x.jpg x.step; do
    refused 2 "build writes .stip files only" build box.obj -o $name
    [ ! -e $name ] || fail "$name was written"
done
"$stipple" build box.obj -o other.name -q || fail "a user's own suffix"

# no input is overwritten
mkdir -p model && cp a.png model/skin.png
printf 'newmtl m\nmap_Kd skin.png\n' > model/box.mtl
{ printf 'mtllib box.mtl\n'; cat box.obj; } > model/box.obj
printf '{"asset": {"version": "2.0"}, "images": [{"uri": "skin.png"}]}' > model/empty.gltf
refused 2 "is a part of model/box.obj and would be overwritten" render model/box.obj -o model/skin.png
refused 2 "is a part of model/empty.gltf" render model/empty.gltf -o ./model/../model/skin.png
cmp -s a.png model/skin.png || fail "a texture was written over"
"$stipple" render model/box.obj -o model/other.png --size 32x24 -q || fail "a picture beside the model"
refused 2 "would be overwritten" compare a.png a.PNG --map a.png
refused 2 "would be overwritten" compare a.png a.PNG --difference a.PNG
refused 2 "would be overwritten" capture box.obj -o box.obj
refused 2 "would be overwritten" build box.obj -o ./box.obj

# colours
for color in '#4682b4' 4682b4 steelblue SteelBlue; do
    draw -o color.png --background "$color"
    [ ! -e first.png ] && cp color.png first.png
    cmp -s color.png first.png || fail "$color gives a different colour"
done
draw -o white.png --background '#fff'
draw -o named.png --background white
cmp -s white.png named.png || fail "#fff is not white"
! cmp -s white.png first.png || fail "two colours are equal"
refused 2 "is not a colour" render box.stip -o x.png --background '#12345'
refused 2 "is not a colour" render box.stip -o x.png --background steel

# --up of build turns the bounds, that of render the picture
bounds()
{
    "$stipple" build box.obj -o up.stip -q --fresh --up "$1" || fail "--up $1"
    "$stipple" info up.stip --json | python3 -c "
import json, sys
b = json.load(sys.stdin)['bounds']
print(*(round(v) for v in b['min'] + b['max']))"
}
[ "$(bounds y)" = "0 0 0 1 2 3" ] || fail "--up y: $(bounds y)"
[ "$(bounds -y)" = "0 -2 -3 1 0 0" ] || fail "--up -y: $(bounds -y)"
[ "$(bounds z)" = "0 0 -2 1 3 0" ] || fail "--up z: $(bounds z)"
[ "$(bounds -z)" = "0 -3 0 1 0 2" ] || fail "--up -z: $(bounds -z)"
[ "$(bounds x)" = "-2 0 0 0 1 3" ] || fail "--up x: $(bounds x)"
[ "$(bounds -x)" = "0 -1 0 2 0 3" ] || fail "--up -x: $(bounds -x)"
for pair in "z 0,0,1" "-x -1,0,0"; do
    # shellcheck disable=SC2086
    set -- $pair
    draw -o axis.png --eye 3,4,5 --up "$1"
    draw -o vector.png --eye 3,4,5 --up "$2"
    cmp -s axis.png vector.png || fail "--up $1 is not $2"
done
refused 2 "neither an axis" render box.stip -o x.png --up up
refused 2 "'0,0,0' has no length" render box.stip -o x.png --up 0,0,0
refused 2 "not one of x|-x|y|-y|z|-z" build box.obj -o x.stip --up w
exit $((failures > 0))
