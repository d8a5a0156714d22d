#!/usr/bin/env bash
# stipple compare: figures, files and JSON. Arguments: executable, scratch folder.
set -u
stipple=$1
scratch=$2
. "$(dirname "$0")/shared.sh"
mkdir -p "$scratch" && cd "$scratch" || exit 1
python3 - << 'END' || exit 1
import struct, zlib

def chunk(kind, data):
    return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))

def write(path, width, height, color):
    rows = b"".join(b"\0" + b"".join(bytes(color(x, y)) for x in range(width)) for y in range(height))
    with open(path, "wb") as file:
        file.write(b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", struct.pack(">IIBBBBB", width, height, 8, 6, 0, 0, 0))
                   + chunk(b"IDAT", zlib.compress(rows)) + chunk(b"IEND", b""))

write("a.png", 200, 180, lambda x, y: (100, 100, 100, 255))
write("b.png", 200, 180, lambda x, y: (110, 110, 110, 255))
write("half.png", 200, 180, lambda x, y: (100, 100, 100, 255) if x < 100 else (0, 0, 0, 0))
write("mask.png", 200, 180, lambda x, y: (255, 255, 255, 255) if x < 80 else (0, 0, 0, 255))
write("small.png", 20, 18, lambda x, y: (100, 100, 100, 255))
END

# figure KEY FILE: the value of a key of a JSON file
figure()
{
    python3 -c 'import json, sys; print(json.load(open(sys.argv[2]))[sys.argv[1]])' "$1" "$2"
}

# near EXPECTED ACTUAL
near()
{
    python3 -c 'import sys; sys.exit(abs(float(sys.argv[1]) - float(sys.argv[2])) > 1e-9)' "$1" "$2"
}

"$stipple" compare a.png b.png --json > ab.json 2> err || fail "compare: $(cat err)"
[ ! -s err ] || fail "messages: $(cat err)"
keys=$(python3 -c 'import json; print(*sorted(json.load(open("ab.json"))))')
[ "$keys" = "height ms_ssim psnr ssim ssim_covered width" ] || fail "keys: $keys"
[ "$(figure width ab.json) $(figure height ab.json)" = "200 180" ] || fail "size"
# of constants: (2 a b + c1) / (a^2 + b^2 + c1), and 20 log10(255 / 10)
near 0.9954764440966563 "$(figure ssim ab.json)" || fail "ssim $(figure ssim ab.json)"
near 28.130803608679102 "$(figure psnr ab.json)" || fail "psnr $(figure psnr ab.json)"

"$stipple" compare a.png a.png --json > aa.json || fail "compare with itself"
[ "$(figure ssim aa.json) $(figure ms_ssim aa.json) $(figure psnr aa.json)" = "1.0 1.0 200.0" ] ||
    fail "a picture differs from itself: $(cat aa.json)"
"$stipple" compare a.png a.png | grep -q '^psnr .*infinite' || fail "text of equal pictures"
"$stipple" compare a.png b.png | grep -q '^psnr  *28.131 dB$' || fail "text of psnr"

# the mask excludes the half that differs
"$stipple" compare a.png half.png --mask mask.png --json > masked.json || fail "--mask"
near 1 "$(figure ssim_covered masked.json)" || fail "--mask: $(figure ssim_covered masked.json)"
"$stipple" compare a.png half.png --json > unmasked.json || fail "compare"
near 1 "$(figure ssim_covered unmasked.json)" && fail "without --mask all counts"

# truth: A and the picture with one sample, both compared with B
"$stipple" compare half.png b.png --exact a.png --json > exact.json || fail "--exact"
"$stipple" compare half.png b.png --json > half.json || fail "compare"
python3 - << 'END' || fail "--exact: $(cat exact.json)"
import json
exact, half, ab = (json.load(open(name + ".json")) for name in ("exact", "half", "ab"))
assert exact["truth"] == exact["ssim_covered"] == half["ssim_covered"] and exact["exact"] == ab["ssim_covered"]
assert abs(exact["ratio"] - exact["truth"] / exact["exact"]) < 1e-12
END
"$stipple" compare half.png b.png --exact a.png | grep -q '^ratio  *[0-9.]*$' || fail "text of --exact"
"$stipple" compare a.png b.png --exact a.png --mask mask.png > out 2> err
[ $? -eq 2 ] && grep -q 'exclude each other' err || fail "--exact with --mask: $(cat err)"
"$stipple" compare a.png b.png --exact small.png > out 2> err
[ $? -eq 1 ] && [ "$(wc -l < err)" = 1 ] || fail "--exact of another size: $(cat err)"

# pictures as output, and as input from a pipe
"$stipple" compare --map map.png --difference difference.png a.png half.png > text || fail "--map"
"$stipple" compare map.png difference.png > text || fail "the map and the difference differ in size"
"$stipple" compare - a.png --json < a.png > piped.json || fail "standard input"
cmp -s aa.json piped.json || fail "a pipe gives different figures"
"$stipple" compare difference.png difference.png --map map2.png > text || fail "difference.png"
"$stipple" compare --map=map3.png -- a.png half.png > text || fail "--map=FILE"
cmp -s map.png map3.png || fail "two maps differ"
for threads in 1 2 3; do
    "$stipple" compare a.png half.png --threads $threads --json | cmp -s - unmasked.json ||
        fail "$threads threads give different figures"
done

# inputs that cannot be compared
"$stipple" compare a.png small.png > out 2> err
[ $? -eq 1 ] && [ ! -s out ] || fail "different sizes should fail, without output on stdout"
grep -qx 'stipple: pictures of 200 x 180 and 20 x 18 cannot be compared' err || fail "sizes: $(cat err)"
head -c 60 a.png > cut.png
"$stipple" compare a.png cut.png > out 2> err
[ $? -eq 1 ] || fail "a cut file should fail"
grep -q '^stipple: cut.png: PNG: ' err || fail "cut: $(cat err)"
"$stipple" compare a.png b.png --map no/such/folder/map.png > out 2> err
[ $? -eq 1 ] && [ ! -s out ] || fail "a map that cannot be written should fail"
exit $((failures > 0))
