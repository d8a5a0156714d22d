#!/usr/bin/env bash
# stipple view, as hands use it: windows under Xvfb, keys and mouse by xdotool, pictures compared.
# Arguments: executable, scratch folder. VIEW_BACKEND=gl: OpenGL draws, and only what a hand does in one window is tried. Waits for what --report says; nothing depends on how long anything takes.
set -u
drawn_by=${VIEW_BACKEND:-cpu}
other_way=$([ "$drawn_by" = cpu ] && echo gl || echo cpu)
stipple=$1
scratch=$2
rm -rf "$scratch"
. "$(dirname "$0")/shared.sh"
here=$(cd "$(dirname "$0")" && pwd)
mkdir -p "$scratch" && cd "$scratch" || exit 1
export XDG_CACHE_HOME=$PWD/cache XDG_CONFIG_HOME=$PWD/config LIBGL_ALWAYS_SOFTWARE=1
export XDG_PICTURES_DIR=$PWD/pictures SDL_VIDEODRIVER=x11 SDL_AUDIODRIVER=dummy
mkdir -p config/stipple pictures
printf '{"shot_width": 320, "shot_height": 200, "samples": 2}' > config/stipple/viewer.json
# drivers of others keep what they have until the process ends
printf 'leak:libGL\nleak:libX\nleak:_dri.so\nleak:libSDL\nleak:libLLVM\nleak:libdbus\nleak:swrast\n' > leaks
export LSAN_OPTIONS=suppressions=$PWD/leaks:print_suppressions=0
viewer=0
xvfb=0

# without a display
env -u DISPLAY -u WAYLAND_DISPLAY -u SDL_VIDEODRIVER "$stipple" view > out 2> err
[ $? -eq 1 ] || fail "no display: another exit code than 1"
grep -q '^stipple: there is no display' err || fail "no display: $(cat err)"
[ "$(wc -l < err)" -eq 1 ] && [ ! -s out ] || fail "no display: not one sentence"
env -u WAYLAND_DISPLAY DISPLAY=:4242 "$stipple" view > out 2> err
[ $? -eq 1 ] && grep -q '^stipple: there is no display' err || fail "a display that is none: $(cat err)"
"$stipple" view a b > out 2> err
[ $? -eq 2 ] || fail "two files are shown"

for program in Xvfb xdotool python3; do
    command -v $program > /dev/null || exit 77
done

clean_up()
{
    [ "$viewer" -ne 0 ] && kill "$viewer" 2> /dev/null
    [ "$xvfb" -ne 0 ] && kill "$xvfb" 2> /dev/null
    wait 2> /dev/null
}
trap clean_up EXIT

# any display number that is free; the server's memory is the screen
mkdir screen
exec 3> display
Xvfb -displayfd 3 -screen 0 640x400x24 -fbdir screen -nolisten tcp > xvfb.log 2>&1 &
xvfb=$!
exec 3>&-
while [ ! -s display ]; do
    kill -0 $xvfb 2> /dev/null || { cat xvfb.log; exit 77; }
    sleep 0.1
done
export DISPLAY=:$(cat display)

# wait_until CONDITION: a Python expression over what the report says (r, camera, picture) and over what `keep` kept (k).
# There is no limit to how long anything takes; but where the viewer rests for so many looks, nothing comes any more.
wait_until()
{
    local rested=0
    while ! python3 "$here/view_report.py" report.json "$1"; do
        if ! kill -0 $viewer 2> /dev/null; then
            fail "the viewer ended before: $1: $(cat viewer.err)"
            exit 1
        fi
        rested=$((rested + 1))
        python3 "$here/view_report.py" report.json 'r["rests"]' || rested=0
        if [ $rested -ge 600 ]; then
            fail "the viewer rests, and this does not come: $1: $(cat report.json)"
            exit 1
        fi
        sleep 0.1
    done
}

check()
{
    python3 "$here/view_report.py" report.json "$2" || fail "$1: $(cat report.json)"
}

keep()
{
    cp report.json kept.json
}

# open_viewer ARGUMENTS...: until its window has the keys
open_viewer()
{
    rm -f report.json
    "$stipple" view "$@" --size 640x400 --report report.json > viewer.out 2> viewer.err &
    viewer=$!
    wait_until 'r["shows"] > 0'
    until window=$(xdotool search --onlyvisible --pid $viewer 2> /dev/null | tail -1) && [ -n "$window" ]; do
        kill -0 $viewer 2> /dev/null || exit 1
        sleep 0.1
    done
    xdotool windowmove "$window" 0 0 windowfocus "$window"
}

close_viewer()
{
    xdotool key ctrl+q
    wait $viewer || fail "the viewer's exit code is $?: $(cat viewer.err)"
    viewer=0
    [ ! -s viewer.out ] || fail "the viewer writes on stdout"
}

# search_for TEXT: as quick hands, and as on a busy machine: all keys come before the viewer looks at the first
search_for()
{
    xdotool key ctrl+f
    wait_until 'tools["types"]'
    kill -STOP $viewer
    xdotool key ctrl+a
    xdotool type "$1"
    kill -CONT $viewer
    wait_until "tools['search'] == '$1'"
}

# shot NAME: what is on the screen
shot()
{
    python3 "$here/view_screen.py" screen/Xvfb_screen0 "$1"
}

# same A B SSIM: at least that alike
same()
{
    "$stipple" compare "$1" "$2" --json > compared.json || fail "$1 and $2 cannot be compared"
    python3 -c 'import json, sys; sys.exit(json.load(open("compared.json"))["ssim"] < float(sys.argv[1]))' "$3" ||
        fail "$1 and $2 are not alike: $(cat compared.json)"
}

# as_seen NAME SCENE: what stipple render makes of the camera of the report
as_seen()
{
    # shellcheck disable=SC2046
    "$stipple" render "$2" --backend cpu -o "$1" $(python3 "$here/view_report.py" report.json) --supersample 2 --splat-size 1 \
        --background dbe0e6 -q || fail "$2 cannot be rendered"
}

other() # A B SSIM: less alike
{
    "$stipple" compare "$1" "$2" --json > compared.json || fail "$1 and $2 cannot be compared"
    python3 -c 'import json, sys; sys.exit(json.load(open("compared.json"))["ssim"] >= float(sys.argv[1]))' "$3" ||
        fail "$1 and $2 are alike: $(cat compared.json)"
}

drag() # BUTTON X0 Y0 X1 Y1
{
    xdotool mousemove "$2" "$3" mousedown "$1" mousemove $((($2 + $4) / 2)) $((($3 + $5) / 2)) mousemove "$4" "$5"
    xdotool mouseup "$1"
}

# the picture in the window is that of stipple render
open_viewer scene:boxes --backend "$drawn_by"
wait_until 'r["rests"] and picture["complete"]'
if ! python3 "$here/view_report.py" report.json "r['backend'] == '$drawn_by'" && [ "$drawn_by" = gl ]; then
    exit 77 # there is no OpenGL
fi
check "the picture is accumulated" 'picture["samples"] == 4'
xdotool key Tab
wait_until 'r["rests"] and not r["panels"] and picture["width"] == 640 and picture["height"] == 400'
xdotool key f # frames what there is, from where it is seen from
wait_until 'r["rests"] and picture["complete"]'
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
wait_until 'r["rests"] and near(camera["eye"][0] / camera["eye"][1], 1.25)'

# orbit: the distance to the pivot stays; the picture is another
keep
drag 1 320 200 400 220
wait_until 'r["rests"] and distance(camera["eye"], k["camera"]["eye"]) > 0.1'
check "orbit" 'near(distance(camera["eye"], camera["pivot"]), distance(k["camera"]["eye"], k["camera"]["pivot"]))'
shot orbit.png
# the wheel comes nearer, and what is under the cursor stays: the middle of the picture shows the middle of a box
keep
xdotool mousemove 320 200 click 4
wait_until 'r["rests"] and camera["reach"] < k["camera"]["reach"]'
xdotool click 5
wait_until 'r["rests"] and near(camera["reach"], k["camera"]["reach"])'
check "wheel back and forth" 'distance(camera["eye"], k["camera"]["eye"]) < 0.05'
# sideways: the gaze stays
keep
drag 2 320 200 350 170
wait_until 'r["rests"] and distance(camera["eye"], k["camera"]["eye"]) > 0.01'
check "pan" 'distance(camera["up"], k["camera"]["up"]) < 1e-9'
# the head turns: the eye stays
keep
drag 3 320 200 250 200
wait_until 'r["rests"] and distance(camera["target"], k["camera"]["target"]) > 0.1'
check "look" 'distance(camera["eye"], k["camera"]["eye"]) < 1e-9'
# flight: as long as the key is held
for key in w s a d q e; do
    keep
    xdotool keydown $key
    wait_until 'distance(camera["eye"], k["camera"]["eye"]) > 0.02'
    xdotool keyup $key
    wait_until 'r["rests"]'
done
xdotool key 9
wait_until 'r["rests"] and near(camera["eye"][0] / camera["eye"][1], 1.25)'
# a click on a surface chooses the part and the pivot; Escape chooses nothing
xdotool mousemove 320 200 click 1
wait_until 'r["rests"] and camera["pivot_chosen"] and tools["chosen"] != ""'
keep
shot chosen.png
# F frames the part, Home everything
xdotool key f
wait_until 'r["rests"] and camera["reach"] < 0.6 * k["camera"]["reach"]'
xdotool key Home
wait_until 'r["rests"] and near(camera["reach"], k["camera"]["reach"]) and tools["chosen"] == ""'
# what is hidden is not in the picture, nor in the way of the next click
shot all_parts.png
xdotool mousemove 320 200 click 1
wait_until 'r["rests"] and tools["chosen"] == k["tools"]["chosen"]'
xdotool key x Escape
wait_until 'r["rests"] and tools["marks"] == 1 and tools["chosen"] == ""'
shot hidden.png
other all_parts.png hidden.png 0.995
xdotool mousemove 320 200 click 1
wait_until 'r["rests"] and tools["chosen"] not in ("", k["tools"]["chosen"])'
xdotool key i
wait_until 'r["rests"] and tools["marks"] == 2'
shot isolated.png
other isolated.png all_parts.png 0.9
xdotool key g # of what was isolated
wait_until 'r["rests"] and tools["marks"] == 2'
xdotool key u Escape
wait_until 'r["rests"] and tools["marks"] == 0 and tools["chosen"] == ""'
shot shown.png
same shown.png all_parts.png 0.999
# a part is found by its name
search_for "BOX 1"
search_for "BOX 15"
wait_until 'tools["found"] == 1'
xdotool key Return
wait_until 'tools["chosen"].endswith("box 15") and r["rests"]'
xdotool key Escape # out of the field
wait_until 'not tools["types"]'
xdotool key Tab
wait_until 'r["rests"] and not r["panels"] and picture["width"] == 640'
xdotool key Home
wait_until 'r["rests"] and near(camera["reach"], k["camera"]["reach"]) and tools["chosen"] == ""'
# a section through the middle
xdotool key k
wait_until 'r["rests"] and tools["section_planes"] == 6'
xdotool key k
wait_until 'r["rests"] and tools["section_planes"] == 0'
# measuring: two clicks are two points, one of which goes again
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
# a saved picture is that of stipple render
xdotool key F12
wait_until 'r["rests"] and tools["shot"] != ""'
mv pictures/Stipple/boxes-001.png shot.png || fail "no saved picture"
"$stipple" compare shot.png shot.png > out || fail "the saved picture is no PNG"
# a flight is recorded, and stipple fly can fly it
xdotool key r
wait_until 'tools["records"]'
keep
xdotool keydown d
wait_until 'distance(camera["eye"], k["camera"]["eye"]) > 0.05'
xdotool keyup d key r
wait_until 'not tools["records"] and r["rests"]'
"$stipple" fly scene:boxes --path pictures/Stipple/boxes-001.flight.json --backend cpu --size 64x48 --frames 3 --json -q > fly.json ||
    fail "the recorded flight cannot be flown"
# the other way gives the same, where OpenGL is to be had
shot before.png
xdotool key b
wait_until "r['rests'] and (r['backend'] == '$other_way' or 'not to be had' in r['message'])"
shot after.png
same before.png after.png 0.97
# where nothing is to be seen, the picture says why, whoever draws
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
# what is said comes before what was said, and hides nothing
xdotool key v
wait_until '"last until" in r["message"]'
# a window of another size
xdotool windowsize "$window" 520 360
wait_until 'r["rests"] and picture["width"] == 520 and picture["height"] == 360'
# a very small one has panels too
xdotool windowsize "$window" 300 200
wait_until 'r["rests"] and picture["width"] == 300 and picture["height"] == 200'
xdotool key Tab F3
wait_until 'r["rests"] and r["page"] == "quality" and 100 <= picture["width"] < 200 and picture["height"] > 100'
xdotool key p
wait_until 'r["rests"] and r["page"] == "none" and r["parts"] and 100 <= picture["width"] < 200'
xdotool key h
wait_until 'r["rests"] and r["help"]'
shot small.png
xdotool key Escape F2 Tab
wait_until 'r["rests"] and not r["help"] and not r["panels"]'
xdotool windowsize "$window" 640 400
wait_until 'r["rests"] and picture["width"] == 640 and picture["height"] == 400'
# panels and help
xdotool key Tab
wait_until 'r["rests"] and r["panels"]'
xdotool key F3
wait_until 'r["page"] == "quality"'
xdotool key h
wait_until 'r["help"]'
xdotool key Escape
wait_until 'not r["help"]'
close_viewer
grep -q '"page": 2' config/stipple/viewer.json || fail "settings are not kept: $(cat config/stipple/viewer.json)"
[ "$drawn_by" = cpu ] || exit 0

# files that cannot be shown are said to be so in the window
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
# viewpoints lie beside the model
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
# files fall onto a window: one that shows nothing yet, and one that shows another
cp ball.obj "a ball%20.obj"
open_viewer --backend cpu
for file in "a ball%20.obj" ball.obj; do
    if python3 "$here/view_drop.py" "$window" "$file"; then
        wait_until "r['file'].endswith('/$file') and r['loading'] == 'done' and r['rests'] and picture['complete']"
    else
        [ $? -eq 77 ] || fail "$file cannot be dropped"
    fi
done
close_viewer
# a viewpoint brings its box back as a box, further planes, and what is hidden; names may be anything
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
xdotool key F6
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
ls cache/stipple/*-draft* > out 2> /dev/null && fail "a draft is kept that nobody needs any more: $(cat out)"
close_viewer
# in two windows at once: the second waits for what the first builds, and leaves it its drafts
sed 's/^v 0 .*/v 0 1 0/' large.obj > shared.obj
open_viewer shared.obj --backend cpu
wait_until 'r["stores"] > 0'
kill -STOP $viewer # wherever it is by now
"$stipple" view shared.obj --backend cpu --size 320x200 --report second.json > second.out 2> second.err &
second=$!
sleep 2
kill -CONT $viewer
until python3 "$here/view_report.py" second.json 'r["loading"] in ("done", "failed")'; do
    kill -0 $second 2> /dev/null || { fail "the second window ended: $(cat second.err)"; break; }
    sleep 0.1
done
python3 "$here/view_report.py" second.json 'r["loading"] == "done" and r["complete"]' || fail "the second: $(cat second.json)"
kill $second
wait $second
wait_until 'r["loading"] == "done" and r["rests"] and picture["complete"]'
check "nothing was missing" 'r["message"] == ""'
xdotool windowfocus "$window"
close_viewer
# what a killed window left goes
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
# names of any bytes: they are reported, and viewpoints are kept without the parts that no file of texts can name
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
    wait_until 'r["rests"] and tools["marks"] == 1 and tools["views"] == 1 and "too long or not UTF-8: 1 parts" in r["message"]'
    close_viewer
    grep -q '"View 1"' $file.views.json || fail "the viewpoint of $file.obj is not kept"
done
# nothing to draw
printf 'solid none\nendsolid none\n' > none.stl
open_viewer none.stl --backend cpu
wait_until 'r["loading"] == "done" and r["rests"]'
check "nothing is said to be in it" '"nothing" in r["message"]'
xdotool key f x k v m F12 1 5
wait_until 'r["rests"]'
close_viewer
# a file that another program cuts short while it is shown: one sentence, whenever it is needed again
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
    [ $code -eq 1 ] && grep -q '^stipple: a file in use was made shorter' viewer.err || fail "cut short: $code: $(cat viewer.err)"
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
# under a limit of memory
open_viewer ball.obj --backend cpu --memory 64M
wait_until 'r["loading"] == "done" and r["rests"] and picture["complete"]'
xdotool key F12
wait_until 'tools["shot"].endswith(".png") and r["rests"]'
close_viewer
# which holds for saved pictures, too
sed -i 's/"shot_width": [0-9]*/"shot_width": 8192/; s/"shot_height": [0-9]*/"shot_height": 8192/' config/stipple/viewer.json
open_viewer ball.obj --backend cpu --memory 64M
wait_until 'r["loading"] == "done" and r["rests"] and picture["complete"]'
xdotool key F12
wait_until '"memory" in r["message"] and r["rests"]'
check "there is no picture" 'tools["shot"] == ""'
close_viewer
[ $failures -eq 0 ]
