#!/usr/bin/env bash
# stipple view with all kinds of files: broken, growing, dropped, truncated, with unusual names,
# with a memory limit. Arguments: executable, scratch folder.
set -u
. "$(dirname "$0")/view_window.sh"

# the window reports files that cannot be shown
printf 'not a model' > broken.glb
for file in missing.stip broken.glb; do
    open_viewer $file --backend cpu
    wait_until 'r["loading"] == "failed" and r["rests"]'
    check "$file is said not to be shown" "'$file' in r['message']"
    close_viewer
done

# a model is built in the background
python3 - << 'END' || exit 1
with open("ball.obj", "w") as out:
    from math import sin, cos, pi
    n = 60
    for i in range(n + 1):
        for j in range(2 * n):
            a, b = pi * i / n, pi * j / n
            out.write(f"v {sin(a) * cos(b):.6f} {cos(a):.6f} {sin(a) * sin(b):.6f}\n")
    for i in range(n):
        for j in range(2 * n):
            p = [i * 2 * n + j, i * 2 * n + (j + 1) % (2 * n), (i + 1) * 2 * n + (j + 1) % (2 * n), (i + 1) * 2 * n + j]
            out.write("f " + " ".join(str(x + 1) for x in p) + "\n")
END
open_viewer ball.obj --backend cpu
wait_until 'r["loading"] == "done" and r["rests"] and picture["complete"]'
# viewpoints are stored beside the model
xdotool key 1
wait_until 'r["rests"] and near(camera["eye"][0], 0)'
xdotool key v
wait_until 'tools["views"] == 1'
[ -s ball.views.json ] || fail "there is no ball.views.json"
close_viewer
open_viewer ball.obj --backend cpu
wait_until 'r["loading"] == "done" and r["rests"] and tools["views"] == 1'
close_viewer
"$stipple" render ball.obj --view "View 1" --backend cpu -o view.png --size 64x64 -q || fail "the viewpoint cannot be rendered"
# files are dropped onto an empty window and onto one with a scene
cp ball.obj "a ball%20.obj"
open_viewer --backend cpu
for file in "a ball%20.obj" ball.obj; do
    if python3 "$here/view_drop.py" "$window" "$file"; then
        wait_until "r['file'].endswith('/$file') and r['loading'] == 'done' and r['rests'] and picture['complete']"
    else
        [ $? -eq 77 ] && echo "skipped: dropped files: libX11 is not installed" || fail "$file cannot be dropped"
    fi
done
# several files, or a folder of them, are one scene
if python3 "$here/view_drop.py" "$window" ball.obj "a ball%20.obj"; then
    wait_until "r['file'].endswith('/ball.obj') and r['inputs'] == 2 and r['loading'] == 'done' and r['rests'] and picture['complete']"
fi
close_viewer
mkdir -p tiles
for x in 0 2; do
    printf 'v %d 0 0\nv %d 0 0\nv %d 1 0\nf 1 2 3\n' $x $((x + 1)) $x > tiles/tile_$x.obj
done
echo notes > tiles/notes.txt
open_viewer tiles --backend cpu
wait_until 'r["inputs"] == 2 and r["loading"] == "done" and r["rests"]'
check "the folder is recent" 'r["start"]["recent"][0].endswith("/tiles")'
keep
# up axis and unit can be corrected, also in the panel
close_viewer
open_viewer tiles/tile_0.obj tiles/tile_2.obj --backend cpu --up z --unit mm
wait_until 'r["inputs"] == 2 and r["loading"] == "done" and r["rests"]'
check "up and unit" 'r["axes"] == {"up": "z", "unit_metres": 0.001} and k["axes"] == {"up": "y", "unit_metres": 0.0}'
close_viewer
# a viewpoint restores its box as a box, further planes, and hidden parts; names may be anything
python3 - << 'END'
import json
views = json.load(open("ball.views.json"))
view = views["views"][0]
view["name"] = "\"a\" ##b %s " + 100 * "long "
view["note"] = 40 * "what is to be seen "
view["sections"] = [[1, 0, 0, 0.9], [-1, 0, 0, 0.9], [0, 1, 0, 0.9], [0, -1, 0, 0.9], [0, 0, 1, 0.9], [0, 0, -1, 0.9],
                    [1, 1, 0, 0.5]]
view["annotations"] = [{"text": view["note"], "at": [0, 0, 1]}]
views["views"] = [view, dict(view, name="short")]
json.dump(views, open("ball.views.json", "w"))
END
open_viewer ball.obj --backend cpu --view short
wait_until 'r["loading"] == "done" and r["rests"]'
check "two views" 'tools["views"] == 2'
check "the view is taken with all its planes" 'near(camera["eye"][0], 0) and tools["section_planes"] == 7 and r["message"] == ""'
shot cut.png
xdotool key k
wait_until 'r["rests"] and tools["section_planes"] == 1'
xdotool key F5
wait_until 'r["rests"] and r["page"] == "views"'
shot names.png
xdotool key h # no higher than the window
wait_until 'r["rests"] and r["help"]'
shot help.png
close_viewer
# a large one grows: points, triangles, splats
python3 - << 'END' || exit 1
with open("large.obj", "w") as out:
    n = 260
    for i in range(n + 1):
        out.write("".join(f"v {i} {i * j * 7 % 5} {j}\n" for j in range(n + 1)))
    for i in range(n):
        for j in range(n):
            a = i * (n + 1) + j + 1
            out.write(f"f {a} {a + 1} {a + n + 1}\nf {a + 1} {a + n + 2} {a + n + 1}\n")
END
open_viewer large.obj --backend cpu
wait_until 'r["stores"] > 0 and camera["reach"] > 0'
keep
wait_until 'r["loading"] == "done" and r["rests"] and picture["complete"]'
check "it was seen before it was finished" 'r["stores"] >= 3 and k["stores"] < r["stores"] or k["loading"] == "done"'
check "the camera stays where it was" 'distance(camera["eye"], k["camera"]["eye"]) < 1e-9 or k["scene"] == 0'
check "the whole is there" 'r["stores"] >= 3 and r["complete"]'
ls cache/stipple/*-draft* > out 2> /dev/null && fail "a draft is kept that is no longer needed: $(cat out)"
close_viewer
# two windows at once: the second waits for the first one's build and does not remove its drafts
sed 's/^v 0 .*/v 0 1 0/' large.obj > shared.obj
open_viewer shared.obj --backend cpu
wait_until 'r["stores"] > 0'
kill -STOP $viewer # wherever it is by now
"$stipple" view shared.obj --backend cpu --size 320x200 --report second.json > second.out 2> second.err &
second=$!
# it waits for the first, or finds what the first has just built
"$python" -S -E "$here/view_report.py" second.json 'r["shows"] > 0 and r["loading"] in ("working", "done")' $second ||
    fail "the second window ended: $(cat second.err)"
kill -CONT $viewer
"$python" -S -E "$here/view_report.py" second.json 'r["loading"] in ("done", "failed")' $second ||
    fail "the second window ended: $(cat second.err)"
python3 "$here/view_report.py" second.json 'r["loading"] == "done" and r["complete"]' || fail "the second: $(cat second.json)"
kill $second
wait $second
wait_until 'r["loading"] == "done" and r["rests"] and picture["complete"]'
check "nothing was missing" 'r["message"] == ""'
xdotool windowfocus "$window"
close_viewer
# leftovers of a killed window are removed
draft=$(ls -t cache/stipple/*.stip | head -1)
draft=${draft%.stip}-draft.stip
echo left > "$draft"
open_viewer shared.obj --backend cpu
wait_until 'r["loading"] == "done" and r["rests"]'
close_viewer
[ ! -e "$draft" ] || fail "a draft stays: $draft"
# names in other scripts
sed 's/^o .*//; 1i o \xe6\xb3\xb5\xe7\xab\x99 \xd9\x85\xd8\xb6\xd8\xae\xd8\xa9' ball.obj > names.obj
open_viewer names.obj --backend cpu
wait_until 'r["loading"] == "done" and r["rests"]'
xdotool key p
wait_until 'r["rests"] and r["parts"]'
shot letters.png
close_viewer
# names with any bytes: they are reported, and viewpoints are saved without parts whose names are
# not valid text
python3 - << 'END' || exit 1
ball = [line for line in open("ball.obj", "rb") if not line.startswith(b"o ")]
long = "\u00e9" * 600
with open("bytes.obj", "wb") as out:
    out.write(b"o caf\xe9\n" + b"".join(ball))
with open("long.obj", "wb") as out:
    out.write(b"o x" + long.encode() + b"\n" + b"".join(ball))
END
for file in bytes long; do
    open_viewer $file.obj --backend cpu
    wait_until 'r["loading"] == "done" and r["rests"] and picture["complete"]'
    xdotool key Tab f
    wait_until 'r["rests"] and not r["panels"] and picture["width"] == 640'
    xdotool mousemove 320 200 click 1
    wait_until 'r["rests"] and tools["chosen"] != ""'
    xdotool key x v
    wait_until 'r["rests"] and tools["marks"] == 1 and tools["views"] == 1 and "1 parts saved as visible" in r["message"]'
    close_viewer
    grep -q '"View 1"' $file.views.json || fail "the viewpoint of $file.obj is not kept"
done
# nothing to draw
printf 'solid none\nendsolid none\n' > none.stl
open_viewer none.stl --backend cpu
wait_until 'r["loading"] == "done" and r["rests"]'
check "nothing is said to be in it" '"no visible content" in r["message"]'
xdotool key f x k v m F12 1 5
wait_until 'r["rests"]'
close_viewer
# a file that another program truncates while it is shown: one sentence, whenever it is read again
"$stipple" build ball.obj -o short.stip -q || fail "ball.obj cannot be built"
open_viewer short.stip --backend cpu
wait_until 'r["loading"] == "done" and r["rests"]'
: > short.stip
for _ in 1 2 3 4 5 6 7 8 9 10; do
    kill -0 $viewer 2> /dev/null || break
    xdotool mousemove 320 200 click 1 key i key x key b
    sleep 0.2
done
if kill -0 $viewer 2> /dev/null; then
    close_viewer # all of it was in memory
else
    wait $viewer
    code=$?
    viewer=0
    [ $code -eq 1 ] && grep -q '^stipple: a file in use was truncated' viewer.err || fail "cut short: $code: $(cat viewer.err)"
fi
# without OpenGL
open_viewer ball.obj --backend cpu --software-window
wait_until 'r["loading"] == "done" and r["rests"] and picture["complete"]'
shot software.png
close_viewer
open_viewer ball.obj --backend cpu
wait_until 'r["loading"] == "done" and r["rests"] and picture["complete"]'
shot hardware.png
close_viewer
same software.png hardware.png 0.9
# with a memory limit
open_viewer ball.obj --backend cpu --memory 64M
wait_until 'r["loading"] == "done" and r["rests"] and picture["complete"]'
xdotool key F12
wait_until 'tools["shot"].endswith(".png") and r["rests"]'
close_viewer
# which also applies to saved pictures
sed -i 's/"shot_width": [0-9]*/"shot_width": 8192/; s/"shot_height": [0-9]*/"shot_height": 8192/' config/stipple/viewer.json
open_viewer ball.obj --backend cpu --memory 64M
wait_until 'r["loading"] == "done" and r["rests"] and picture["complete"]'
xdotool key F12
wait_until '"memory" in r["message"] and r["rests"]'
check "there is no picture" 'tools["shot"] == ""'
close_viewer
[ $failures -eq 0 ]
