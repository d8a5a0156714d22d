#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# LAS and LAZ on the command line: info and build agree on both, and truncated files are rejected.
# needs: stipple-lab
set -u
stipple=$1
scratch=$2
rm -rf "$scratch"
. "$(dirname "$0")/shared.sh"
mkdir -p "$scratch" && cd "$scratch" || exit 1

# The record of format 2: x, y, z, intensity, returns, class, angle, user, source, red, green, blue.
python3 - <<'PY' || exit 1
import struct
def las(format, record, count, points):
    size = len(points) // count
    head = b"LASF" + bytes(20) + bytes([1, 2]) + bytes(68) + struct.pack("<HII", 227, 227, 0)
    head += struct.pack("<BHI", format, size, count) + bytes(20)
    head += struct.pack("<6d", .01, .01, .01, 600000, 5000000, 0)
    head += struct.pack("<6d", 600010, 600000, 5000010, 5000000, 3, 0)
    return head + points
points = b"".join(
    struct.pack("<iiiHBBbBHHHH", 10 * x, 10 * y, (x + y) % 300, 100 + x, 9, 2, -5, 0, 7, 200, x, y)
    for x in range(100) for y in range(100))
open("a.las", "wb").write(las(2, 26, 10000, points))
open("cut.las", "wb").write(las(2, 26, 10000, points)[:-1])
PY

"$stipple" info a.las --json > info.json 2> info.err || fail "info of a LAS file"
grep -q '"points": 10000' info.json || fail "info does not count the points"
grep -q '"up": "z"' info.json || fail "info does not say that z is up"
python3 - <<'PY' || fail "info of the points: $(cat info.json)"
import json
scan = json.load(open("info.json"))["scan"]
assert scan["points"] == 10000 and scan["point_format"] == 2 and scan["version"] == "1.2", scan
assert scan["compressor"] is None and scan["copc"] is None and scan["coordinate_system"] is None
assert scan["bounds"] == {"min": [600000, 5000000, 0], "max": [600010, 5000010, 3]}, scan["bounds"]
types = {a["name"]: (a["type"], a["kept"]) for a in scan["attributes"]}
assert types["intensity"] == ("u16", True) and types["user data"] == ("u8", False), types
assert "red" in types and "time" not in types
PY
"$stipple" info a.las 2> /dev/null | grep -q 'intensity: u16' || fail "info does not list attributes"
"$stipple" bench import --model a.las --quick --json > bench.json 2> bench.err || fail "bench import: $(cat bench.err)"
grep -q '"points": 10000' bench.json && grep -q '"format": "las"' bench.json || fail "bench import: $(cat bench.json)"
grep -q 'its unit of length is unknown (set it with --unit)' info.err || fail "there is no warning about the unit"
"$stipple" build a.las -o a.stip --unit ft --progress none > build.out 2> build.err || fail "build of a LAS file"
"$stipple" check a.stip > check.out || fail "check of the built file"
"$stipple" info a.stip --json | grep -q '"unit": "ft"' || fail "the requested unit"
refused 1 "cut.las: ends after 9999 of the 10000 points in its header" \
    build cut.las -o cut.stip --progress none
[ ! -e cut.stip ] || fail "a failed build leaves a file"
exit $((failures > 0))
