#!/usr/bin/env bash
# stipple sheet: the layout of pictures, plots of flights, errors. Arguments: executable, scratch
# folder.
set -u
stipple=$1
scratch=$2
rm -rf "$scratch"
. "$(dirname "$0")/shared.sh"
mkdir -p "$scratch" && cd "$scratch" || exit 1
# writes PNG files of one colour, and reads pixels of the sheet
cat > png.py << 'END'
import struct, sys, zlib
def write(path, width, height, rgba):
    def chunk(kind, body):
        return struct.pack(">I", len(body)) + kind + body + struct.pack(">I", zlib.crc32(kind + body))
    open(path, "wb").write(b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", struct.pack(">IIBBBBB", width, height, 8, 6, 0, 0, 0))
        + chunk(b"IDAT", zlib.compress((b"\0" + bytes(rgba) * width) * height)) + chunk(b"IEND", b""))
def size(path):
    return struct.unpack(">II", open(path, "rb").read()[16:24])
END
python3 -c "
import json, png
png.write('red.png', 200, 100, (255, 0, 0, 255))
png.write('green.png', 40, 20, (0, 255, 0, 255))
png.write('clear.png', 200, 100, (0, 0, 0, 0))
for name, base in (('slow', 300.0), ('fast', 30.0)):
    json.dump({'budget': {'ms': 33.0} if name == 'fast' else None,
               'per_frame': [{'t': i / 10, 'frame_ms': base + i} for i in range(20)]}, open(name + '.json', 'w'))"

# two pictures of 100 pixels with a gap of 10 around each; the second is enlarged twice
"$stipple" sheet red.png green.png -o sheet.png --width 100 || fail "sheet"
[ "$(python3 -c "import png; print(*png.size('sheet.png'))")" = "230 80" ] || fail "the sheet is of another size"
"$stipple" sheet red.png green.png -o again.png --width 100 && cmp -s sheet.png again.png || fail "the same input gives a different sheet"
"$stipple" sheet red.png / green.png -o rows.png --width 100 || fail "rows"
[ "$(python3 -c "import png; print(*png.size('rows.png'))")" = "120 140" ] || fail "the rows are not one below the other"
"$stipple" sheet red.png=caption -o caption.png --width 100 || fail "caption"
[ "$(python3 -c "import png; print(*png.size('caption.png'))")" = "120 104" ] || fail "a caption has no room"
# transparent areas are white: the same as a sheet of white
python3 -c "import png; png.write('white.png', 200, 100, (255, 255, 255, 255))"
"$stipple" sheet clear.png -o a.png && "$stipple" sheet white.png -o b.png && cmp -s a.png b.png || fail "transparency is not white"
! "$stipple" compare a.png caption.png > out 2>&1 || fail "sheets of other sizes are compared"
"$stipple" sheet fast.json=splats slow.json=triangles -o plot.png --width 600 || fail "plot"
"$stipple" sheet fast.json=splats -o one.png --width 600 || fail "plot of one"
"$stipple" compare plot.png one.png --json | python3 -c "import json, sys; assert json.load(sys.stdin)['ssim'] < 0.99" ||
    fail "the second flight is not plotted"

refused 2 "needs 1 to" sheet -o x.png
refused 2 "needs -o" sheet red.png
refused 2 "would be overwritten" sheet red.png -o red.png
refused 2 "must end in .png" sheet red.png -o x.gif
refused 1 "missing.png" sheet missing.png -o x.png
echo '{}' > empty.json
refused 1 "expected the output of stipple fly --json" sheet empty.json -o x.png
refused 1 "has no pictures" sheet / -o x.png
for frame in '"t": 1e20, "frame_ms": 5' '"t": 1, "frame_ms": 1e308' '"t": -1e300, "frame_ms": 1'; do
    echo '{"per_frame": [{"t": 0, "frame_ms": 1}, {'"$frame"'}]}' > far.json
    refused 1 "far.json: frame 2: expected t and frame_ms up to 1e+09" sheet far.json -o x.png
done
echo '{"budget": {"ms": 1e308}, "per_frame": [{"t": 0, "frame_ms": 1}]}' > far.json
refused 1 "far.json: budget: expected ms up to 1e+09" sheet far.json -o x.png
echo '{"per_frame": [{"t": 1e9, "frame_ms": 1e9}, {"t": -1e9, "frame_ms": 0}]}' > wide.json
"$stipple" sheet wide.json -o wide.png || fail "the widest axes"
echo '{"per_frame": [{"t": 1e9, "frame_ms": 1}]}' > late.json
"$stipple" sheet late.json -o late.png || fail "one late frame"
[ ! -e x.png ] || fail "a refused sheet was written"
exit $((failures > 0))
