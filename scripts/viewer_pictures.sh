#!/usr/bin/env bash
# Redraws docs/images/viewer*.png except viewer-grows.png, for the viewer's page. Drives real
# windows under Xvfb.
# Arguments: executable, scratch folder (default: those of the release build). Needs Xvfb and
# xdotool, like the tests.
set -u
root=$(cd "$(dirname "$0")/.." && pwd)
set -- "${1:-$root/build/release/lab/stipple-lab}" "${2:-/tmp/stipple-viewer-pictures}"
export VIEW_SIZE=1280x720
. "$root/tests/cli/view_window.sh"
images=$root/docs/images
scene=scene:power-plant,scale=0.1
printf '{"samples": 3}' > config/stipple/viewer.json

# picture NAME: takes a screenshot once the viewer is idle
picture()
{
    sleep 1 # hovering ends and messages appear
    wait_until 'r["rests"]'
    shot "$1.png"
    cp "$1.png" "$images/$1.png"
}

# the start page, with recent files
for name in bridge hall gearbox; do
    printf 'v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n' > $name.obj
    open_viewer $name.obj --backend cpu
    wait_until 'r["loading"] == "done" and r["rests"]'
    close_viewer
done
open_viewer
wait_until 'r["start"]["shown"] and r["rests"]'
xdotool mousemove 1200 690
picture viewer-start
close_viewer

# parts, a selected part, display
open_viewer $scene --backend cpu
wait_until 'r["loading"] == "done" and r["rests"] and picture["complete"]'
search_for "bunker 4"
xdotool key Return
wait_until 'tools["chosen"].endswith("bunker 4") and r["rests"]'
wait_until 'not tools["types"]'
xdotool key F2
wait_until 'r["page"] == "quality" and r["rests"]'
xdotool mousemove 620 400 click 5 click 5 click 5 click 5
picture viewer

# a section plane with its handle
xdotool key Escape Home F3
wait_until 'r["page"] == "section" and tools["chosen"] == "" and r["rests"]'
xdotool mousemove 1035 153 click 1 # the plane across X
xdotool mousemove 1200 690
wait_until 'tools["section_planes"] == 1 and r["rests"]'
picture viewer-section

# the search, and measuring in feet
xdotool mousemove 1040 207 click 1 # turns the plane off
wait_until 'tools["section_planes"] == 0 and r["rests"]'
xdotool key Home 9 F4 m
wait_until 'tools["measures"] and r["page"] == "measure" and r["rests"]'
for place in "515 225" "600 540" "762 490"; do
    # shellcheck disable=SC2086
    xdotool mousemove $place click 1
    sleep 0.5
done
search_for "coal mill"
xdotool mousemove 1200 690
picture viewer-measure
close_viewer

# a number of splats
open_viewer $scene --backend cpu --method psp --splats 2000
wait_until 'r["loading"] == "done" and r["rests"] and picture["complete"]'
xdotool key F2
wait_until 'r["page"] == "quality" and "slider" in r["splats"]["places"]'
xdotool mousemove 620 400 click 4 click 4
wait_until 'r["rests"] and picture["complete"]'
xdotool mousemove 1200 690
picture viewer-splats
close_viewer
