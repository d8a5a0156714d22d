#!/usr/bin/env bash
# Mouse and keys in stipple view: orbit, wheel, pan, look, flight, the view cube, search, measuring,
# recorded flights, panels. All of it is independent of the backend. Arguments: executable, scratch
# folder. The test waits for the state in --report; it does not depend on timing.
# needs: stipple-lab
set -u
. "$(dirname "$0")/view_window.sh"

open_viewer scene:boxes --backend cpu
wait_until 'r["rests"] and picture["complete"]'
xdotool key Tab
wait_until 'r["rests"] and not r["panels"] and picture["width"] == 640 and picture["height"] == 400'
xdotool key f
wait_until 'r["rests"] and picture["complete"]'
xdotool key 9
wait_until 'r["rests"] and near((camera["eye"][0] - camera["target"][0]) / (camera["eye"][1] - camera["target"][1]), 1)'
# orbit: the distance to the pivot stays; the picture changes
keep
drag 1 320 200 400 220
wait_until 'r["rests"] and distance(camera["eye"], k["camera"]["eye"]) > 0.1'
check "orbit" 'near(distance(camera["eye"], camera["pivot"]), distance(k["camera"]["eye"], k["camera"]["pivot"]))'
shot orbit.png
# the wheel zooms in, and the point under the cursor stays: the centre of the picture shows the
# centre of a box
keep
xdotool mousemove 320 200 click 4
wait_until 'r["rests"] and camera["reach"] < k["camera"]["reach"]'
xdotool click 5
wait_until 'r["rests"] and near(camera["reach"], k["camera"]["reach"])'
check "wheel back and forth" 'distance(camera["eye"], k["camera"]["eye"]) < 0.05'
# panning: the direction stays
keep
drag 2 320 200 350 170
wait_until 'r["rests"] and distance(camera["eye"], k["camera"]["eye"]) > 0.01'
check "pan" 'distance(camera["up"], k["camera"]["up"]) < 1e-9'
# looking around: the eye stays
keep
drag 3 320 200 250 200
wait_until 'r["rests"] and distance(camera["target"], k["camera"]["target"]) > 0.1'
check "look" 'distance(camera["eye"], k["camera"]["eye"]) < 1e-9'
# flight: while the key is held
for key in w s a d q e; do
    keep
    xdotool keydown $key
    wait_until 'distance(camera["eye"], k["camera"]["eye"]) > 0.02'
    xdotool keyup $key
    wait_until 'r["rests"]'
done
xdotool key 9
wait_until 'r["rests"] and near((camera["eye"][0] - camera["target"][0]) / (camera["eye"][1] - camera["target"][1]), 1)'
# a click on a surface selects the part and sets the pivot; Escape clears the selection
xdotool mousemove 320 200 click 1
wait_until 'r["rests"] and camera["pivot_chosen"] and tools["chosen"] != ""'
keep
# clicks on the view cube turn the camera, and the scale bar fits into the picture
xdotool key Escape Tab
wait_until 'r["rests"] and r["panels"] and r["guides"] and "front" in r["guides"]["cube"]'
check "a scale bar" '0 < r["guides"]["scale_bar"]["pixels"] <= 160 and r["guides"]["scale_bar"]["length"] > 0'
check "all six sides" 'len(r["guides"]["cube"]) == 6'
shot guides.png
for side in front left top back bottom right; do
    # shellcheck disable=SC2046
    set -- $("$python" -S -E -c 'import json, sys
x, y = json.load(open("report.json"))["guides"]["cube"][sys.argv[1]]
print(round(x), round(y))' $side)
    keep
    xdotool mousemove "$1" "$2" click 1
    wait_until 'r["rests"] and distance(camera["eye"], k["camera"]["eye"]) > 0.1'
    case $side in
    front) check "$side" 'near(camera["eye"][0], camera["target"][0]) and camera["eye"][2] > camera["target"][2] + 1' ;;
    left) check "$side" 'near(camera["eye"][2], camera["target"][2]) and camera["eye"][0] < camera["target"][0] - 1' ;;
    top) check "$side" 'near(camera["eye"][0], camera["target"][0]) and camera["eye"][1] > camera["target"][1] + 1' ;;
    back) check "$side" 'near(camera["eye"][0], camera["target"][0]) and camera["eye"][2] < camera["target"][2] - 1' ;;
    bottom) check "$side" 'near(camera["eye"][0], camera["target"][0]) and camera["eye"][1] < camera["target"][1] - 1' ;;
    right) check "$side" 'near(camera["eye"][2], camera["target"][2]) and camera["eye"][0] > camera["target"][0] + 1' ;;
    esac
done
check "a click on the cube chooses nothing" 'tools["chosen"] == ""'
xdotool key Tab Home 9
wait_until 'r["rests"] and not r["panels"] and near((camera["eye"][0] - camera["target"][0]) / (camera["eye"][1] - camera["target"][1]), 1)'
xdotool mousemove 320 200 click 1
wait_until 'r["rests"] and camera["pivot_chosen"] and tools["chosen"] != ""'
keep
# search finds a part by its name
search_for "BOX 1"
search_for "BOX 15"
wait_until 'tools["found"] == 1'
xdotool key Return
wait_until 'tools["chosen"].endswith("box 15") and r["rests"]'
check "the name comes first, what it belongs to beside it" \
    'r["match"]["label"] == "box 15" and r["match"]["detail"] + "/box 15" == tools["chosen"]'
xdotool key Escape # out of the field
wait_until 'not tools["types"]'
xdotool key Tab
wait_until 'r["rests"] and not r["panels"] and picture["width"] == 640'
xdotool key Home
wait_until 'r["rests"] and near(camera["reach"], k["camera"]["reach"]) and tools["chosen"] == ""'
# measuring: two clicks add two points, one of which is removed again
xdotool key m
wait_until 'tools["measures"]'
xdotool mousemove 320 200 click 1
wait_until 'len(tools["points"]) == 1'
xdotool mousemove 280 220 click 1
wait_until 'len(tools["points"]) == 2'
check "points are on the boxes" 'all(abs(c) <= 2.5 for p in tools["points"] for c in p) and distance(*tools["points"]) > 0.01'
xdotool key BackSpace
wait_until 'len(tools["points"]) == 1'
xdotool key BackSpace Escape
wait_until 'not tools["measures"] and r["rests"]'
# a recorded flight can be flown by stipple fly
xdotool key r
wait_until 'tools["records"]'
keep
xdotool keydown d
wait_until 'distance(camera["eye"], k["camera"]["eye"]) > 0.05'
xdotool keyup d key r
wait_until 'not tools["records"] and r["rests"]'
"$stipple" fly scene:boxes --path pictures/Stipple/boxes-001.flight.json --backend cpu --size 64x48 --frames 3 --json -q > fly.json ||
    fail "the recorded flight cannot be flown"
# panels and help
xdotool key Tab
wait_until 'r["rests"] and r["panels"]'
xdotool key F2
wait_until 'r["page"] == "quality"'
xdotool key h
wait_until 'r["help"]'
xdotool key Escape
wait_until 'not r["help"]'
close_viewer
grep -q '"page": 2' config/stipple/viewer.json || fail "settings are not kept: $(cat config/stipple/viewer.json)"
[ $failures -eq 0 ]
