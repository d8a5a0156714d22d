#!/usr/bin/env bash
# Coordinates under the cursor in the viewer: east, north and height of a survey, and how they are
# copied. Arguments: executable, scratch folder.
set -u
. "$(dirname "$0")/view_window.sh"
"$python" -S -E - << 'END'
import struct
# a level field of points: LAS 1.4 with a coordinate system, scale 1 mm
wkt = b'PROJCS["Test field",GEOGCS["G",DATUM["D",SPHEROID["S",6378137,298.25]],PRIMEM["P",0],UNIT["degree",0.0174532925199433]],PROJECTION["Transverse_Mercator"],UNIT["metre",1]]\0'
side, east, north, height = 200, 691000, 5334000, 512.25
points = [(250 * i, 250 * k, 0) for i in range(side) for k in range(side)]
start = 375 + 54 + len(wkt)
head = bytearray(375)
head[0:4], head[24:26] = b"LASF", b"\1\4"
struct.pack_into("<H", head, 6, 16)
struct.pack_into("<HII", head, 94, 375, start, 1)
struct.pack_into("<BH", head, 104, 6, 30)
struct.pack_into("<6d", head, 131, 0.001, 0.001, 0.001, east, north, height)
struct.pack_into("<6d", head, 179, east + 0.25 * (side - 1), east, north + 0.25 * (side - 1), north, height, height)
struct.pack_into("<QQ", head, 247, len(points), len(points))
vlr = struct.pack("<H16sHH32s", 0, b"LASF_Projection", 2112, len(wkt), b"")
body = b"".join(struct.pack("<3iHBBBBhHd", *p, 0, 0x11, 0, 2, 0, 0, 0, 0.0) for p in points)
open("field.las", "wb").write(bytes(head) + vlr + wkt + body)
END
printf 'v 0 0 0\nv 8 0 0\nv 0 8 0\nv 8 8 0\nf 1 2 3\nf 2 4 3\n' > mesh.obj

# pastes what was copied: into the search field
paste_is()
{
    xdotool key ctrl+f
    wait_until 'tools["types"]'
    xdotool key ctrl+a ctrl+v
    wait_until "$1"
    xdotool key ctrl+a BackSpace Escape
}

open_viewer field.las --backend "$drawn_by"
wait_until 'r["loading"] == "done" and r["rests"] and picture["complete"]'
xdotool key Tab 7
wait_until 'r["rests"] and not r["panels"] and near(camera["eye"][0], camera["target"][0])'
xdotool mousemove 320 200
wait_until 'tools["place"].startswith("E 6910") and ", N 53340" in tools["place"]'
check "a height and the unit of the system" 'abs(float(tools["place"].split("H ")[1].split()[0]) - 512.25) < 0.5 and tools["place"].endswith(" m")'
xdotool key ctrl+c
wait_until 'r["message"].startswith("Copied 6910")'
paste_is 'len(tools["search"].split(", ")) == 3 and float(tools["search"].split(", ")[0]) % 0.25 == 0 and float(tools["search"].split(", ")[2]) == 512.25'
close_viewer

open_viewer mesh.obj --backend "$drawn_by"
wait_until 'r["loading"] == "done" and r["rests"] and picture["complete"]'
xdotool key Tab 1
wait_until 'r["rests"] and not r["panels"] and near(camera["eye"][0], camera["target"][0])'
xdotool mousemove 320 200
wait_until 'tools["place"] and "E " not in tools["place"]'
xdotool key ctrl+c
wait_until 'r["message"].startswith("Copied 4.") or r["message"].startswith("Copied 3.9")'
xdotool mousemove 5 200
wait_until 'tools["place"] == ""'
xdotool key ctrl+c
wait_until 'r["message"].startswith("Nothing to copy")'
close_viewer
[ $failures -eq 0 ]
