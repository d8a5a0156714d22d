#!/usr/bin/env bash
# stipple view without a display, and with wrong arguments.
# Arguments: executable, scratch folder.
set -u
stipple=$1
scratch=$2
rm -rf "$scratch"
. "$(dirname "$0")/shared.sh"
mkdir -p "$scratch" && cd "$scratch" || exit 1
export XDG_CACHE_HOME=$PWD/cache XDG_CONFIG_HOME=$PWD/config XDG_STATE_HOME=$PWD/state SDL_VIDEODRIVER=x11

env -u DISPLAY -u WAYLAND_DISPLAY -u SDL_VIDEODRIVER "$stipple" view > out 2> err
[ $? -eq 1 ] || fail "no display: another exit code than 1"
grep -q '^stipple: there is no display' err || fail "no display: $(cat err)"
[ "$(wc -l < err)" -eq 1 ] && [ ! -s out ] || fail "no display: not exactly one sentence"
env -u WAYLAND_DISPLAY DISPLAY=:4242 "$stipple" view > out 2> err
[ $? -eq 1 ] && grep -q '^stipple: there is no display' err || fail "an invalid display: $(cat err)"
printf '\x89STP' > built.stip
"$stipple" view built.stip --up z > out 2> err
[ $? -eq 2 ] && grep -q 'built.stip is built' err || fail "a built file is turned: $(cat err)"
"$stipple" view --splats 1 > out 2> err
[ $? -eq 2 ] && grep -q 'splats' err || fail "one splat: $(cat err)"
"$stipple" view --splats 100 --budget-ms 20 > out 2> err
[ $? -eq 2 ] && grep -q 'exclude each other' err || fail "a number of splats and a budget: $(cat err)"

# the viewer is a program of its own, beside the tool or installed
if ldd "$(readlink -f "$stipple")" | grep -q SDL; then
    fail "every command loads the window system"
fi
mkdir -p alone/bin && cp "$(readlink -f "$stipple")" alone/bin/stipple
alone/bin/stipple view > out 2> err
[ $? -eq 1 ] && grep -q '^stipple: cannot start the viewer .*/alone/.*stipple-view: No such file' err ||
    fail "without its viewer: $(cat err)"
mkdir -p alone/libexec/stipple
ln -s "$(dirname "$(readlink -f "$stipple")")/stipple-view" alone/libexec/stipple/stipple-view
env -u DISPLAY -u WAYLAND_DISPLAY -u SDL_VIDEODRIVER alone/bin/stipple view > out 2> err
[ $? -eq 1 ] && grep -q '^stipple: there is no display' err || fail "with an installed viewer: $(cat err)"
[ $failures -eq 0 ]
