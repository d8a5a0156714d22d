#!/usr/bin/env bash
# stipple view, as hands use it: windows under Xvfb, keys and mouse by xdotool, pictures compared.
# Arguments: executable, scratch folder. Waits for what --report says; nothing depends on how long anything takes.
set -u
stipple=$1
scratch=$2
rm -rf "$scratch"
. "$(dirname "$0")/shared.sh"
here=$(cd "$(dirname "$0")" && pwd)
mkdir -p "$scratch" && cd "$scratch" || exit 1
export XDG_CACHE_HOME=$PWD/cache XDG_CONFIG_HOME=$PWD/config LIBGL_ALWAYS_SOFTWARE=1
export SDL_VIDEODRIVER=x11 SDL_AUDIODRIVER=dummy
mkdir -p config
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
Xvfb -displayfd 3 -screen 0 1280x720x24 -fbdir screen -nolisten tcp > xvfb.log 2>&1 &
xvfb=$!
exec 3>&-
while [ ! -s display ]; do
    kill -0 $xvfb 2> /dev/null || { cat xvfb.log; exit 77; }
    sleep 0.1
done
export DISPLAY=:$(cat display)

# wait_until CONDITION: a Python expression over what the report says (r, camera, picture) and over what `keep` kept (k)
wait_until()
{
    while ! python3 "$here/view_report.py" report.json "$1"; do
        if ! kill -0 $viewer 2> /dev/null; then
            fail "the viewer ended before: $1: $(cat viewer.err)"
            return 1
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
    "$stipple" view "$@" --report report.json > viewer.out 2> viewer.err &
    viewer=$!
    wait_until 'r["shows"] > 0' || return 1
    until window=$(xdotool search --onlyvisible --pid $viewer 2> /dev/null | tail -1) && [ -n "$window" ]; do
        kill -0 $viewer 2> /dev/null || return 1
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
    "$stipple" render "$2" -o "$1" $(python3 "$here/view_report.py" report.json) --supersample 4 --splat-size 1 \
        --background dbe0e6 -q || fail "$2 cannot be rendered"
}

drag() # BUTTON X0 Y0 X1 Y1
{
    xdotool mousemove "$2" "$3" mousedown "$1" mousemove $((($2 + $4) / 2)) $((($3 + $5) / 2)) mousemove "$4" "$5"
    xdotool mouseup "$1"
}

# the picture in the window is that of stipple render
open_viewer scene:boxes --backend cpu --size 1280x720
wait_until 'r["rests"] and picture["complete"]'
check "the picture is accumulated" 'picture["samples"] == 16'
xdotool key Tab
wait_until 'r["rests"] and not r["panels"] and picture["width"] == 1280 and picture["height"] == 720'
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
drag 1 640 360 800 400
wait_until 'r["rests"] and distance(camera["eye"], k["camera"]["eye"]) > 0.1'
check "orbit" 'near(distance(camera["eye"], camera["pivot"]), distance(k["camera"]["eye"], k["camera"]["pivot"]))'
shot orbit.png
# the wheel comes nearer, and what is under the cursor stays: the middle of the picture shows the middle of a box
keep
xdotool mousemove 640 360 click 4
wait_until 'r["rests"] and camera["reach"] < k["camera"]["reach"]'
xdotool click 5
wait_until 'r["rests"] and near(camera["reach"], k["camera"]["reach"])'
check "wheel back and forth" 'distance(camera["eye"], k["camera"]["eye"]) < 0.05'
# sideways: the gaze stays
keep
drag 2 640 360 700 300
wait_until 'r["rests"] and distance(camera["eye"], k["camera"]["eye"]) > 0.01'
check "pan" 'distance(camera["up"], k["camera"]["up"]) < 1e-9'
# the head turns: the eye stays
keep
drag 3 640 360 500 360
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
# a click on a surface chooses the pivot
xdotool mousemove 640 360 click 1
wait_until 'r["rests"] and camera["pivot_chosen"]'
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
close_viewer
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
close_viewer
[ $failures -eq 0 ]
