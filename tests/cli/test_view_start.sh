#!/usr/bin/env bash
# stipple view without a file: the start page, its dialog and recent files; and dragging section
# handles. Arguments: executable, scratch folder.
set -u
. "$(dirname "$0")/view_window.sh"

mkdir models
printf 'v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 2 3\nf 1 2 4\nf 1 3 4\nf 2 3 4\n' > models/corner.obj
cp models/corner.obj models/other.obj
touch models/scan.laz models/scan.e57 models/notes.wrl
here_path=$(pwd -P)

open_viewer
wait_until 'r["start"]["shown"] and r["rests"]'
check "nothing is recent yet" 'r["start"]["recent"] == [] and not r["start"]["dialog"]'
shot start.png
xdotool key ctrl+o
wait_until 'r["start"]["dialog"] and tools["types"]'
shot dialog.png
other start.png dialog.png 0.99
# a missing file gives a message, and the dialog stays
xdotool type "missing.obj"
wait_until 'r["start"]["typed"] == "missing.obj"'
xdotool key Return
wait_until 'r["rests"] and r["start"]["dialog"] and r["file"] == ""'
xdotool key Escape
wait_until 'not r["start"]["dialog"] and r["start"]["shown"]'
# a folder, then a file in it
xdotool key ctrl+o
wait_until 'r["start"]["dialog"] and tools["types"]'
type_all "$here_path/models" 'r["start"]["typed"]'
xdotool key Return
wait_until "r['start']['folder'] == '$here_path/models' and r['start']['typed'] == '' and not tools['types']"
xdotool key ctrl+o # the keys go back to the field
wait_until 'r["start"]["dialog"] and tools["types"]'
check "scans are listed" 'r["start"]["listed"] == 4'
xdotool type "corn" # filters the list; Tab completes
wait_until 'r["start"]["typed"] == "corn" and r["start"]["listed"] == 1'
xdotool key Tab
wait_until 'r["start"]["typed"] == "corner.obj"'
xdotool key Return
wait_until "r['file'] == '$here_path/models/corner.obj' and r['loading'] == 'done' and r['rests'] and picture['complete']"
check "the dialog is gone" 'not r["start"]["dialog"] and not r["start"]["shown"]'
check "it is recent" "r['start']['recent'] == ['$here_path/models/corner.obj']"

# a section plane follows the mouse along its normal
xdotool key F3
wait_until 'r["rests"] and r["page"] == "section" and r["handles"] == []'
xdotool key k
wait_until 'r["rests"] and len(r["handles"]) == 6 and tools["section_planes"] == 6'
keep
before=$("$python" -S -E -c 'import json
print(*[round(c) for c in json.load(open("report.json"))["handles"][2]["place"]])')
set -- $before
shot box.png
drag 1 "$1" "$2" "$1" $(($2 + 40))
wait_until 'r["rests"] and r["handles"][2]["place"][1] > k["handles"][2]["place"][1] + 20'
check "the camera stays" 'distance(camera["eye"], k["camera"]["eye"]) < 1e-9'
check "the other side stays" 'abs(r["handles"][3]["place"][1] - k["handles"][3]["place"][1]) < 1'
shot dragged.png
other box.png dragged.png 0.995
close_viewer

# the next window knows the file; a missing file is removed from the list
open_viewer models/other.obj --backend cpu
wait_until 'r["loading"] == "done" and r["rests"]'
check "two are recent" 'len(r["start"]["recent"]) == 2 and r["start"]["recent"][0].endswith("other.obj")'
close_viewer
open_viewer
wait_until 'r["start"]["shown"] and len(r["start"]["recent"]) == 2 and r["rests"]'
shot recent.png
rm models/other.obj
xdotool key ctrl+1
wait_until '"no longer exists" in r["message"] and len(r["start"]["recent"]) == 1'
xdotool key ctrl+1
wait_until 'r["file"].endswith("corner.obj") and r["loading"] == "done" and r["rests"]'
close_viewer
[ $failures -eq 0 ]
