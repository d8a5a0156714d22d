#!/usr/bin/env bash
# A SpaceMouse in stipple view: it moves the model or the camera, the wheel zooms while it holds the
# model, its buttons frame and switch, and the viewer goes on when its daemon ends. Arguments: executable, scratch folder. The test waits for
# the state in --report; it does not depend on timing.
# needs: stipple-lab
set -u
. "$(dirname "$0")/view_window.sh"

mkfifo events || exit 1
exec 7<> events # opens at once
export SPNAV_SOCKET=$PWD/spnav.sock
"$python" -S -E "$here/view_space_mouse.py" "$SPNAV_SOCKET" events &
daemon=$!
trap 'code=$?; kill "$daemon" 2> /dev/null; clean_up; (exit $code); end_test' EXIT
until [ -S "$SPNAV_SOCKET" ]; do
    kill -0 "$daemon" 2> /dev/null || { fail "no daemon"; exit 1; }
    sleep 0.02
done
if ! ldd "$(command -v "$stipple")-view" | grep -q libspnav; then
    echo "skipped: built without libspnav"
    exit 77
fi
open_viewer scene:boxes --backend cpu
wait_until 'r["rests"] and picture["complete"] and tools["space_mouse"]'
# twisting the cap turns the model about the pivot; at rest the viewer rests
keep
echo "0 0 0 0 0 150 0" >&7
wait_until 'distance(camera["eye"], k["camera"]["eye"]) > 0.1'
echo "0" >&7
wait_until 'r["rests"]'
check "turn" 'near(distance(camera["eye"], camera["pivot"]), distance(k["camera"]["eye"], k["camera"]["pivot"])) and camera["up"][1] > 0.5'
check "the distance of the content changes no reach" 'near(camera["reach"], k["camera"]["reach"])'
# meanwhile the wheel zooms, as with the mouse alone: only a flight has a speed
keep
xdotool mousemove 320 200
echo "0 0 0 0 0 50 0" >&7
wait_until 'not r["rests"] and distance(camera["eye"], k["camera"]["eye"]) > 0.01'
xdotool click 4
wait_until 'camera["reach"] < 0.999 * k["camera"]["reach"] or camera["speed"] != k["camera"]["speed"]'
echo "0" >&7
wait_until 'r["rests"]'
check "the wheel zooms" 'camera["reach"] < 0.999 * k["camera"]["reach"] and camera["speed"] == k["camera"]["speed"]'
# the first button fits again, the second switches to flight
echo "1 0" >&7
wait_until 'r["rests"] and picture["complete"]'
echo "1 1" >&7
wait_until 'r["message"] == "The SpaceMouse moves the camera"'
keep
echo "0 0 0 200" >&7
wait_until 'distance(camera["eye"], k["camera"]["eye"]) > 0.1'
check "forward" 'distance(camera["up"], k["camera"]["up"]) < 1e-9'
# the daemon ends while the cap is pushed
echo end >&7
wait "$daemon"
wait_until 'r["rests"] and not tools["space_mouse"]'
close_viewer
[ $failures -eq 0 ]
