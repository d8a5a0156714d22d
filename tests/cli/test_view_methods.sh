#!/usr/bin/env bash
# A file with several methods in the viewer: the requested one is drawn, a key switches to the next,
# and the choice is kept. Arguments: executable, scratch folder.
# needs: stipple-lab
set -u
VIEW_SIZE=400x250
. "$(dirname "$0")/view_window.sh"
"$stipple" -q build scene:spheres,scale=0.02 --surfels 3000 --surfel-ratio 0.001 -o both.stip --method blue,spt || exit 1
open_viewer both.stip --method spt --backend cpu
wait_until 'r["rests"] and r["method"] == "spt"'
xdotool key n
wait_until 'r["rests"] and r["method"] == "blue" and "blue" in r["message"]'
# while the camera moves
xdotool keydown w
xdotool key n
wait_until 'r["method"] == "spt"'
xdotool keyup w
wait_until 'r["rests"] and r["method"] == "spt"'
close_viewer
open_viewer both.stip --backend cpu
wait_until 'r["rests"] and r["method"] == "spt"'
close_viewer
# a file without the method gives a message
"$stipple" -q build scene:spheres,scale=0.02 --surfels 3000 --surfel-ratio 0.001 -o blue.stip || exit 1
open_viewer blue.stip --method spt --backend cpu
wait_until 'r["rests"] and r["method"] == "blue" and "not by spt" in r["message"]'
close_viewer
[ $failures -eq 0 ]
