#!/usr/bin/env bash
# Two eyes and zones of larger splats, in render and fly. Arguments: executable, scratch folder,
# source folder.
set -u
stipple=$1
scratch=$2
rm -rf "$scratch"
. "$(dirname "$0")/shared.sh"
mkdir -p "$scratch" && cd "$scratch" || exit 1

# draw NAME ARGUMENTS...: writes NAME.png and NAME.json
draw()
{
    local name=$1
    shift
    "$stipple" render "$@" -o "$name.png" --json > "$name.json" 2> err || fail "$name: $(cat err)"
}

python3 - << 'END' || exit 1
with open("ball.obj", "w") as out:
    from math import sin, cos, pi
    n = 60
    for i in range(n + 1):
        for k in range(2 * n):
            a, b = pi * i / n, pi * k / n
            out.write(f"v {sin(a) * cos(b):.6f} {cos(a):.6f} {sin(a) * sin(b):.6f}\n")
    for i in range(n):
        for k in range(2 * n):
            p = [i * 2 * n + k, i * 2 * n + (k + 1) % (2 * n), (i + 1) * 2 * n + (k + 1) % (2 * n), (i + 1) * 2 * n + k]
            out.write("f " + " ".join(str(x + 1) for x in p) + "\n")
END
"$stipple" build ball.obj -o ball.stip --levels off -q || exit 1

# each half is the view of an eye beside the centre
near=(--target 0,0,0 --fov 40)
draw both ball.stip --eye 0,0,5 "${near[@]}" --size 128x48 --stereo --ipd 0.5 --reference
draw left ball.stip --eye -0.25,0,5 --target -0.25,0,0 --fov 40 --size 64x48 --reference
draw right ball.stip --eye 0.25,0,5 --target 0.25,0,0 --fov 40 --size 64x48 --reference
# the same for averaged frames
for eye in both left right; do
    case $eye in both) place=(--eye 0,0,5 --target 0,0,0 --size 128x48 --stereo --ipd 0.5) ;;
        left) place=(--eye -0.25,0,5 --target -0.25,0,0 --size 64x48) ;;
        right) place=(--eye 0.25,0,5 --target 0.25,0,0 --size 64x48) ;;
    esac
    draw resting_$eye ball.stip "${place[@]}" --fov 40 --reference --accumulate 4
done
# the ball is left of the centre: the fovea of a flat picture, of both eyes, and with a gaze towards
# the ball
far=(--eye 4,0,9 --target 4,0,0 --fov 60 --size 128x96 --splat-size 1.5)
draw plain ball.stip "${far[@]}"
draw one ball.stip "${far[@]}" --fovea 0.25:1,1:1
draw fovea ball.stip "${far[@]}" --fovea 0.1:2,1:6
draw there ball.stip "${far[@]}" --fovea 0.1:2,1:6 --fovea-center -0.463,0
draw paper ball.stip "${far[@]}" --fovea 0.1:2,1:6 --policy paper
draw threads ball.stip "${far[@]}" --fovea 0.1:2,1:6 --threads 1
draw stereo ball.stip "${far[@]}" --fovea 0.1:2,1:6 --stereo
draw stereo_threads ball.stip "${far[@]}" --fovea 0.1:2,1:6 --stereo --threads 1
draw budget ball.stip --eye 4,0,9 --target 4,0,0 --size 128x96 --fovea 0.25:2,1:4 --stereo --budget-ms 1e5
cmp -s one.png plain.png || fail "a factor of 1 changes the picture"
cmp -s fovea.png threads.png || fail "threads change the picture with a fovea"
cmp -s stereo.png stereo_threads.png || fail "threads change the picture of two eyes"
python3 - << 'END' || fail "pictures or figures"
import json, struct, zlib
def figures(name):
    return json.load(open(name + ".json"))
def rows(name):
    data, at, packed = open(name + ".png", "rb").read(), 8, b""
    while at < len(data):
        length, kind = struct.unpack(">I4s", data[at:at + 8])
        if kind == b"IHDR":
            width, height = struct.unpack(">II", data[at + 8:at + 16])
        packed += data[at + 8:at + 8 + length] if kind == b"IDAT" else b""
        at += 12 + length
    raw, out, before = zlib.decompress(packed), [], bytes(4 * width)
    for y in range(height):
        kind, row = raw[y * (4 * width + 1)], bytearray(raw[y * (4 * width + 1) + 1:(y + 1) * (4 * width + 1)])
        for i in range(4 * width):
            a, b, c = row[i - 4] if i >= 4 else 0, before[i], before[i - 4] if i >= 4 else 0
            nearest = min((abs(b - c), 0, a), (abs(a - c), 1, b), (abs(a + b - 2 * c), 2, c))[2]
            row[i] = (row[i] + [0, a, b, (a + b) // 2, nearest][kind]) % 256
        before = bytes(row)
        out.append(before)
    return out
for kind in "", "resting_":
    both, left, right = rows(kind + "both"), rows(kind + "left"), rows(kind + "right")
    assert both == [l + r for l, r in zip(left, right)], kind + "halves are not what each eye sees"
    assert left != right
assert rows("resting_both") != rows("both")
f = figures("both")
assert (f["width"], f["height"]) == (128, 48), f
for key in "covered_pixels", "triangles":
    assert f[key] == figures("left")[key] + figures("right")[key], key
plain, fovea, there = (figures(n)["splats"] for n in ("plain", "fovea", "there"))
assert 0 < 3 * fovea < plain and fovea < there <= plain, (plain, fovea, there)
assert 0 < 2 * figures("paper")["splats"] < plain
assert figures("fovea")["splat_size"] == 1.5 and 1 <= figures("budget")["splat_size"] < 1.01
END

cat > flight.json << 'END'
{"fov": 60, "fps": 4, "keys": [{"t": 0, "eye": [4, 0, 9], "target": [4, 0, 0]}, {"t": 1, "eye": [0, 0, 5], "target": [0, 0, 0]}]}
END
"$stipple" fly ball.stip --path flight.json --size 128x96 --splat-size 1.5 --fovea 0.1:2,1:6 --stereo -o pictures/ --popping --pixel-filter off \
    --json > fly.json 2> err || fail "fly: $(cat err)"
cmp -s stereo.png pictures/frame-000000.png || fail "a frame of two eyes differs from render's picture"
python3 -c 'import json; f = json.load(open("fly.json")); assert f["popping"]["max"] > 0 and f["width"] == 128' || fail "fly's figures"

for command in render fly; do
    arguments=(ball.stip -o a.png)
    [ $command = fly ] && arguments=(ball.stip --path flight.json)
    for zones in "" 1 1:2, 1:2,1:3 0.5:2,0.2:3 -1:2 1:0 1:99 3:2 0.5:2:3 nan:1 1:nan 0:1,.1:1,.2:1,.3:1,.4:1,.5:1,.6:1,.7:1,.8:1; do
        refused 2 "--fovea must be R:S" $command "${arguments[@]}" --fovea "$zones"
    done
    for center in "" 1 1,2 1,1,1 a,b; do
        refused 2 "--fovea-center must be X,Y" $command "${arguments[@]}" --fovea 1:2 --fovea-center "$center"
    done
    refused 2 "requires --fovea" $command "${arguments[@]}" --fovea-center 0,0
    refused 2 "requires --stereo" $command "${arguments[@]}" --ipd 0.06
    refused 2 "ipd" $command "${arguments[@]}" --stereo --ipd 0
    refused 2 "even width" $command "${arguments[@]}" --stereo --size 127x96
    refused 2 "--fovea and --splats exclude" $command "${arguments[@]}" --fovea 1:2 --splats 9
    refused 2 "--fovea and --reference exclude" $command "${arguments[@]}" --fovea 1:2 --reference
done
refused 2 "--stereo and --ortho exclude" render ball.stip -o a.png --stereo --ortho 3
exit $((failures > 0))
