#!/usr/bin/env bash
# Pictures of stipple view: standard views, hidden parts, sections, window sizes; compared with
# stipple render and with the other backend. Arguments: executable, scratch folder. VIEW_BACKEND=gl:
# OpenGL draws. The test waits for the state in --report; it does not depend on timing.
# needs: stipple-lab
set -u
# each pixel takes long without a graphics card
width=400 height=250 other_size="360 230"
VIEW_SIZE=${width}x$height
middle="$((width / 2)) $((height / 2))"
. "$(dirname "$0")/view_window.sh"

# the picture in the window equals that of stipple render
open_viewer scene:boxes --backend "$drawn_by"
wait_until 'r["rests"] and picture["complete"]'
if ! "$python" -S -E "$here/view_report.py" report.json "r['backend'] == '$drawn_by'" && [ "$drawn_by" = gl ]; then
    echo "skipped: there is no OpenGL"
    exit 77
fi
check "the picture is accumulated" 'picture["samples"] == 4'
xdotool key Tab
wait_until 'r["rests"] and not r["panels"] and '"picture['width'] == $width and picture['height'] == $height"
keep
xdotool key f # frames what there is, from where it is seen from
wait_until 'r["rests"] and picture["complete"]'
check "the first view fits the picture when panels close" 'distance(camera["eye"], k["camera"]["eye"]) < 1e-6'
shot first.png
as_seen rendered.png scene:boxes
same first.png rendered.png 0.98

# standard views
xdotool key 1
wait_until 'r["rests"] and abs(camera["up"][1] - 1) < 1e-9 and near(camera["eye"][0], 0)'
shot front.png
as_seen front_rendered.png scene:boxes
same front.png front_rendered.png 0.98
keep
xdotool key 5
wait_until 'r["rests"] and camera["ortho_height"] > 0'
shot parallel.png
as_seen parallel_rendered.png scene:boxes
same parallel.png parallel_rendered.png 0.98
xdotool key 5
wait_until 'r["rests"] and camera["ortho_height"] == 0 and near(distance(camera["eye"], k["camera"]["eye"]), 0)'
xdotool key 7
wait_until 'r["rests"] and near(camera["up"][2], -1)'
xdotool key 3
wait_until 'r["rests"] and near(camera["eye"][2], 0) and camera["eye"][0] > 1'
xdotool key 9
wait_until 'r["rests"] and near((camera["eye"][0] - camera["target"][0]) / (camera["eye"][1] - camera["target"][1]), 1)'

# a click on a surface selects the part and sets the pivot; Escape clears the selection
xdotool mousemove $middle click 1
wait_until 'r["rests"] and camera["pivot_chosen"] and tools["chosen"] != ""'
keep
shot chosen.png
xdotool key Escape Home 9
wait_until 'r["rests"] and near((camera["eye"][0] - camera["target"][0]) / (camera["eye"][1] - camera["target"][1]), 1)'
xdotool mousemove $middle click 1
wait_until 'r["rests"] and camera["pivot_chosen"] and tools["chosen"] != ""'
keep
check "the selection is tinted" 'tools["tinted"][0] > 20'
# F fits the part, Home everything
xdotool key f
wait_until 'r["rests"] and camera["reach"] < 0.6 * k["camera"]["reach"]'
xdotool key Home
wait_until 'r["rests"] and near(camera["reach"], k["camera"]["reach"]) and tools["chosen"] == ""'
# hidden parts are not in the picture and do not block clicks
shot all_parts.png
xdotool mousemove $middle click 1
wait_until 'r["rests"] and tools["chosen"] == k["tools"]["chosen"]'
xdotool key x Escape
wait_until 'r["rests"] and tools["marks"] == 1 and tools["chosen"] == ""'
shot hidden.png
other all_parts.png hidden.png 0.995
xdotool mousemove $middle click 1
wait_until 'r["rests"] and tools["chosen"] not in ("", k["tools"]["chosen"])'
xdotool key i
wait_until 'r["rests"] and tools["marks"] == 2'
shot isolated.png
other isolated.png all_parts.png 0.9
xdotool key g # of what was isolated
wait_until 'r["rests"] and tools["marks"] == 2'
xdotool key o # all others are ghosts, instead of hidden
wait_until 'r["rests"] and tools["marks"] == 2'
shot focused.png
other focused.png isolated.png 0.98
xdotool key u Escape
wait_until 'r["rests"] and tools["marks"] == 0 and tools["chosen"] == "" and tools["tinted"] == [0, 0]'
shot shown.png
same shown.png all_parts.png 0.999
xdotool key x # of no part
wait_until '"No part is selected" in r["message"] and tools["marks"] == 0'
# a section through the middle
xdotool key k
wait_until 'r["rests"] and tools["section_planes"] == 6 and "Section box on" in r["message"]'
xdotool key k
wait_until 'r["rests"] and tools["section_planes"] == 0'
# a saved picture equals that of stipple render
xdotool key F12
wait_until 'r["rests"] and tools["shot"] != ""'
mv pictures/Stipple/boxes-001.png shot.png || fail "no saved picture"
"$stipple" compare shot.png shot.png > out || fail "the saved picture is no PNG"
# the other backend gives the same, if OpenGL is available
shot before.png
xdotool key b
wait_until "r['rests'] and (r['backend'] == '$other_way' or 'not available' in r['message'])"
shot after.png
same before.png after.png 0.97
# an empty picture is explained, with either backend
for way in other first; do
    search_for boxes
    wait_until 'tools["found"] == 1'
    xdotool key Return
    wait_until 'tools["chosen"] == "boxes" and not tools["types"] and r["rests"]'
    xdotool key Tab x
    wait_until 'r["rests"] and "all parts in view are hidden" in r["hint"]'
    shot nothing.png
    other nothing.png before.png 0.9
    xdotool key u
    wait_until 'r["rests"] and r["hint"] == ""'
    [ $way = first ] || xdotool key b
    [ $way = first ] || wait_until "r['rests'] and r['backend'] == '$drawn_by'"
done
xdotool key Home 1
wait_until 'r["rests"] and near(camera["eye"][0], 0) and tools["chosen"] == ""'
# a new message comes before older ones, and hides none
xdotool key v
wait_until '"kept until" in r["message"]'
# a window of another size
xdotool windowsize "$window" $other_size
wait_until "r['rests'] and f\"{picture['width']} {picture['height']}\" == '$other_size'"
# a very small one has panels too
xdotool windowsize "$window" 300 200
wait_until 'r["rests"] and picture["width"] == 300 and picture["height"] == 200'
xdotool key Tab F2
wait_until 'r["rests"] and r["page"] == "quality" and 100 <= picture["width"] < 200 and picture["height"] > 100'
xdotool key p
wait_until 'r["rests"] and r["page"] == "none" and r["parts"] and 100 <= picture["width"] < 200'
xdotool key h
wait_until 'r["rests"] and r["help"]'
shot small.png
xdotool key Escape
wait_until 'r["rests"] and not r["help"] and r["parts"]'
keep
drag 1 "$("$python" -S -E -c 'import json
print(round(json.load(open("report.json"))["picture"]["area"][0]) + 2)')" 100 150 100 # the edge of the parts
wait_until 'r["rests"] and abs(picture["area"][0] - 150) < 2 and picture["area"][0] != k["picture"]["area"][0]'
check "the camera is not turned" 'camera["up"] == k["camera"]["up"]'
xdotool key F6 Tab
wait_until 'r["rests"] and not r["panels"]'
xdotool windowsize "$window" "$width" "$height"
wait_until 'r["rests"] and '"picture['width'] == $width and picture['height'] == $height"
# a camera that was moved stays when the picture gets another shape
drag 1 $middle $((width / 2 + 30)) $((height / 2))
wait_until 'r["rests"] and abs(camera["eye"][0]) > 0.1'
keep
xdotool windowsize "$window" $other_size
wait_until "r['rests'] and f\"{picture['width']} {picture['height']}\" == '$other_size'"
check "a moved camera stays" 'distance(camera["eye"], k["camera"]["eye"]) < 1e-9'
close_viewer
[ $failures -eq 0 ]
