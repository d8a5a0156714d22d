#!/usr/bin/env bash
# Colours of points in the viewer: requested colours are shown at once, a file without the attribute
# gives a message, and the panel is drawn. Arguments: executable, scratch folder.
set -u
. "$(dirname "$0")/view_window.sh"
python3 - << 'END'
import struct
rows = []
for i in range(4000):
    x, z, kind = i % 64, i // 64, 6 if i % 64 < 20 else 2
    rows.append(struct.pack("<3fHB", x, 5.0 if kind == 6 else 0.1 * (z % 7), z, 16 * i, kind))
head = (f"ply\nformat binary_little_endian 1.0\nelement vertex {len(rows)}\nproperty float x\nproperty float y\n"
        "property float z\nproperty ushort intensity\nproperty uchar classification\nend_header\n")
open("scan.ply", "wb").write(head.encode() + b"".join(rows))
END
printf 'v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n' > mesh.obj
"$stipple" -q build scan.ply -o scan.stip || exit 1

for memory in "" "--memory 512M"; do
    # shellcheck disable=SC2086
    open_viewer scan.stip --backend "$drawn_by" $memory
    wait_until 'r["loading"] == "done" and r["rests"] and r["color"] == "elevation" and picture["complete"]'
    shot plain.png
    close_viewer
    # shellcheck disable=SC2086
    open_viewer scan.stip --backend "$drawn_by" --color intensity --range 0,60000 $memory
    wait_until 'r["loading"] == "done" and r["rests"] and r["color"] == "intensity" and picture["complete"]'
    shot "intensity$memory.png"
    cp report.json "first$memory.json"
    cmp -s plain.png "intensity$memory.png" && fail "intensities change nothing"
    close_viewer
done
same intensity.png "intensity--memory 512M.png" 0.99
# however early the scene is ready, the first camera fits beside the panels
"$python" -S -E -c 'import json; one, other = (json.load(open(f"first{m}.json"))["camera"] for m in ("", "--memory 512M"))
assert one == other, (one, other)' || fail "first cameras differ"
open_viewer scan.stip --backend "$drawn_by" --color elevation --classes 6 --point-size 4px
wait_until 'r["loading"] == "done" and r["rests"] and r["color"] == "elevation" and r["hides"] and picture["complete"]'
wait_until 'r["eye_dome"] == 1 and r["point_sizing"] == 1' # of a cloud; as asked
xdotool key F2
wait_until 'r["page"] == "quality" and r["rests"]'
shot panel.png
close_viewer
open_viewer mesh.obj --backend "$drawn_by" --color intensity
wait_until 'r["loading"] == "done" and r["rests"] and r["color"] == "rgb" and "no intensity" in r["message"] and r["eye_dome"] == 0'
close_viewer
[ $failures -eq 0 ]
