# shellcheck shell=bash
# Sourced by tests of the viewer: a window under Xvfb, keys and mouse by xdotool, the state in
# --report, picture comparison. Arguments of the test: executable, scratch folder. VIEW_BACKEND=gl:
# OpenGL draws. VIEW_SIZE: size of the window.
drawn_by=${VIEW_BACKEND:-cpu}
other_way=$([ "$drawn_by" = cpu ] && echo gl || echo cpu)
stipple=$1
scratch=$2
rm -rf "$scratch"
. "$(dirname "${BASH_SOURCE[0]}")/shared.sh"
here=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
mkdir -p "$scratch" && cd "$scratch" || exit 1
export XDG_CACHE_HOME=$PWD/cache XDG_CONFIG_HOME=$PWD/config XDG_STATE_HOME=$PWD/state LIBGL_ALWAYS_SOFTWARE=1
export XDG_PICTURES_DIR=$PWD/pictures SDL_VIDEODRIVER=x11 SDL_AUDIODRIVER=dummy
# under sanitizers: the search for leaks may crash while threads of the driver end
[ "$drawn_by" = cpu ] || export ASAN_OPTIONS=${ASAN_OPTIONS:+$ASAN_OPTIONS:}detect_leaks=0
mkdir -p config/stipple pictures
# ambient occlusion would take most of the time; with it: test_view_splats.sh
printf '{"shot_width": 320, "shot_height": 200, "samples": 2, "ambient_occlusion": 0}' > config/stipple/viewer.json
viewer=0
xvfb=0

for program in Xvfb xdotool python3; do
    installed $program "the viewer" || exit 77
done

# the interpreter itself: a wrapper may take longer than the scripts here
python=$(python3 -c 'import sys; print(sys.executable)')

clean_up()
{
    [ "$viewer" -ne 0 ] && kill "$viewer" 2> /dev/null
    [ "$xvfb" -ne 0 ] && kill "$xvfb" 2> /dev/null
    wait 2> /dev/null
}
trap 'code=$?; clean_up; (exit $code); end_test' EXIT

# any free display number; the server's memory is the screen
mkdir screen
exec 3> display
Xvfb -displayfd 3 -screen 0 "${VIEW_SIZE:-640x400}x24" -fbdir screen -nolisten tcp > xvfb.log 2>&1 &
xvfb=$!
exec 3>&-
while [ ! -s display ]; do
    kill -0 $xvfb 2> /dev/null || { echo "skipped: Xvfb ends: $(cat xvfb.log)"; exit 77; }
    sleep 0.1
done
export DISPLAY=:$(cat display)

# wait_until CONDITION: a Python expression of the report (r, camera, picture) and of values stored
# by `keep` (k). There is no time limit; but if the viewer is at rest for a minute, nothing more will
# change.
wait_until()
{
    "$python" -S -E "$here/view_report.py" report.json "$1" "$viewer"
    case $? in
    0) return ;;
    2) fail "the viewer is at rest, but this did not happen: $1: $(cat report.json)" ;;
    3) fail "the viewer ended before: $1: $(cat viewer.err)" ;;
    *) fail "no condition: $1" ;;
    esac
    exit 1
}

check()
{
    "$python" -S -E "$here/view_report.py" report.json "$2" || fail "$1: $(cat report.json)"
}

keep()
{
    cp report.json kept.json
}

# open_viewer ARGUMENTS...: waits until the window has the keyboard focus
open_viewer()
{
    rm -f report.json
    "$stipple" view "$@" --size "${VIEW_SIZE:-640x400}" --report report.json > viewer.out 2> viewer.err &
    viewer=$!
    wait_until 'r["shows"] > 0'
    until window=$(xdotool search --onlyvisible --pid $viewer 2> /dev/null | tail -1) && [ -n "$window" ]; do
        kill -0 $viewer 2> /dev/null || {
            wait $viewer
            fail "the viewer ended before it had a window, with code $?: $(cat viewer.err)"
            exit 1
        }
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

# search_for TEXT: like a fast typist or a busy machine: all keys arrive before the viewer handles
# the first
search_for()
{
    xdotool key ctrl+f
    wait_until 'tools["types"]'
    type_all "$1" 'tools["search"]'
}

# type_all TEXT FIELD: replaces the content of the field, an expression of the report; all keys at
# once
type_all()
{
    kill -STOP $viewer
    xdotool key ctrl+a
    xdotool type "$1"
    kill -CONT $viewer
    wait_until "$2 == '$1'"
}

# shot FILE: the content of the screen, read from the server's memory. The server must have handled
# what the viewer sent before: each of these requests waits for its turn. The last frame may still be
# on its way: waits until the screen stays the same.
shot()
{
    local tries
    xdotool getmouselocation getmouselocation > /dev/null
    cp screen/Xvfb_screen0 shot.xwd
    for tries in 1 2 3 4 5 6 7 8 9 10; do
        sleep 0.1
        xdotool getmouselocation getmouselocation > /dev/null
        cmp -s screen/Xvfb_screen0 shot.xwd && break
        cp screen/Xvfb_screen0 shot.xwd
    done
    "$python" -S -E "$here/view_screen.py" shot.xwd "$1"
}

# same A B SSIM: at least this similarity
same()
{
    "$stipple" compare "$1" "$2" --json > compared.json || fail "$1 and $2 cannot be compared"
    holds "$(value compared.json ssim) >= $3" || fail "$1 and $2 are not alike: $(cat compared.json)"
}

# as_seen NAME SCENE: the picture of stipple render from the report's camera
as_seen()
{
    # shellcheck disable=SC2046
    "$stipple" render "$2" --backend cpu -o "$1" $("$python" -S -E "$here/view_report.py" report.json) --supersample 2 --splat-size 1 \
        --background dbe0e6 -q || fail "$2 cannot be rendered"
}

other() # A B SSIM: less alike
{
    "$stipple" compare "$1" "$2" --json > compared.json || fail "$1 and $2 cannot be compared"
    holds "$(value compared.json ssim) < $3" || fail "$1 and $2 are alike: $(cat compared.json)"
}

drag() # BUTTON X0 Y0 X1 Y1
{
    xdotool mousemove "$2" "$3" mousedown "$1" mousemove $((($2 + $4) / 2)) $((($3 + $5) / 2)) mousemove "$4" "$5"
    xdotool mouseup "$1"
}
