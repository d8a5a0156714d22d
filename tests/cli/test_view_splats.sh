#!/usr/bin/env bash
# A fixed number of splats in the viewer: by an option, with the slider, typed, and by keys. The
# chosen number is drawn with either backend, and while the camera moves. Arguments: executable,
# scratch folder.
# needs: stipple-lab
set -u
VIEW_SIZE=700x520
. "$(dirname "$0")/view_window.sh"

# place NAME X Y: a point of a widget, as fractions of its box
place()
{
    "$python" -S -E -c 'import json, sys
x0, y0, x1, y1 = json.load(open("report.json"))["splats"]["places"][sys.argv[1]]
print(round(x0 + (x1 - x0) * float(sys.argv[2])), round(y0 + (y1 - y0) * float(sys.argv[3])))' "$@"
}

# drawn COUNT: an expression; COUNT splats are drawn, and the picture reaches full quality
drawn()
{
    wait_until "r['splats']['count'] == $1 and r['rests'] and picture['complete'] and picture['samples'] == 4"
    check "$1 splats are drawn" "picture['splats'] == $1 and picture['triangles'] == 0"
}

"$stipple" -q build scene:spheres,scale=0.2 --surfels 12000 --surfel-ratio 0.001 -o all.stip --method blue,spt,psp || exit 1
printf '{"samples": 2, "budget_ms": 4}' > config/stipple/viewer.json
open_viewer all.stip --backend cpu --splats 500
wait_until 'r["rests"] and picture["complete"]'
check "there are more" 'r["splats"]["all"] > 10000'
drawn 500
# the slider: two at its left end, all at the right one, their geometric mean in the middle
xdotool key F2
wait_until 'r["page"] == "quality" and "slider" in r["splats"]["places"]'
set -- $(place slider 0.01 0.5)
xdotool mousemove "$1" "$2" click 1
drawn 2
check "two splats show something" 'r["hint"] == ""'
shot two.png
set -- $(place slider 0.99 0.5)
xdotool mousemove "$1" "$2" click 1
drawn 'r["splats"]["all"]'
shot all.png
other two.png all.png 0.95
# while the slider is dragged
xdotool mousedown 1
for part in 0.2 0.7 0.5; do
    keep
    # shellcheck disable=SC2046
    xdotool mousemove $(place slider $part 0.5)
    wait_until 'r["splats"]["count"] != k["splats"]["count"] and picture["listed_splats"] == r["splats"]["count"]'
done
xdotool mouseup 1
drawn 'r["splats"]["count"]'
check "steps are factors" '0.5 < r["splats"]["count"] / (2 * r["splats"]["all"]) ** 0.5 < 2'
# a typed number, including numbers out of range
set -- $(place field 0.1 0.5)
xdotool mousemove "$1" "$2" click 1
wait_until 'tools["types"]'
xdotool key ctrl+a
xdotool type 1234
xdotool key Return
wait_until 'not tools["types"]'
drawn 1234
xdotool mousemove 400 300
# keys: twice, half, and steps of a twentieth
xdotool key Prior
drawn 2468
xdotool key Next
drawn 1234
xdotool key shift+Prior
drawn 1295
xdotool key shift+Next
drawn 1231
# no budget changes the number while the camera moves
keep
xdotool keydown s # away: all stays in the picture, however long that is
for more in 2 5 9; do
    wait_until "picture['frames'] >= k['picture']['frames'] + $more"
    check "a camera that moves" 'picture["listed_splats"] == 1231 and r["splats"]["count"] == 1231'
done
xdotool keyup s
drawn 1231
# by size, and back to the number that this gave, but at most all
xdotool key Home
wait_until 'r["rests"] and picture["complete"]'
keep
xdotool mousemove 200 300 click --repeat 5 5 # away, where splats suffice
wait_until 'r["rests"] and picture["complete"] and camera["reach"] > 1.8 * k["camera"]["reach"]'
xdotool mousemove 400 300
keep
xdotool key c
wait_until 'r["splats"]["count"] == 0 and r["rests"] and picture["complete"] and picture["listed_splats"] > 1231'
xdotool key c
drawn 'min(r["splats"]["all"], k["splats"]["all"])'
# other methods: at most the number for spt, exactly the number for psp
xdotool key Next Next Next
drawn 'r["splats"]["all"] // 8'
xdotool key n
wait_until 'r["method"] == "spt" and r["rests"] and picture["complete"] and r["splats"]["count"] > 1000'
check "splats of spt" '0 < picture["listed_splats"] <= r["splats"]["count"] and picture["triangles"] == 0'
xdotool key n
wait_until 'r["method"] == "psp" and r["rests"] and picture["complete"] and r["splats"]["count"] > 1000'
check "splats of psp" 'picture["listed_splats"] == r["splats"]["count"] and picture["triangles"] == 0'
xdotool key n
wait_until 'r["method"] == "blue" and r["rests"] and picture["complete"]'
shot by_cpu.png
xdotool key b
wait_until '(r["backend"] == "gl" or "not available" in r["message"]) and r["rests"] and picture["complete"]'
shot by_gl.png
same by_cpu.png by_gl.png 0.97
check "so many by OpenGL, too" 'picture["listed_splats"] == r["splats"]["count"] == r["splats"]["all"] // 8'
keep
close_viewer
# the number is kept; an explicit budget applies
open_viewer all.stip --backend cpu
wait_until 'r["rests"] and picture["complete"] and r["splats"]["count"] == k["splats"]["count"]'
close_viewer
open_viewer all.stip --backend cpu --budget-ms 100
wait_until 'r["rests"] and picture["complete"] and r["splats"]["count"] == 0'
close_viewer
# original triangles have no splats to count, unless a number is requested
printf '{"samples": 2, "method": 3, "splat_count": 700}' > config/stipple/viewer.json
"$stipple" -q build scene:boxes -o few.stip || exit 1
open_viewer few.stip --backend cpu
wait_until 'r["rests"] and picture["complete"] and r["splats"]["count"] == 0 and r["splats"]["all"] == 0'
xdotool key Prior
wait_until '"no splats" in r["message"]'
check "nothing is counted" 'r["splats"]["count"] == 0'
close_viewer
open_viewer all.stip --backend cpu --splats 800
drawn 800
close_viewer
[ $failures -eq 0 ]
