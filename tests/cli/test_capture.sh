#!/usr/bin/env bash
# stipple-lab capture: candidates as points, and the captured pictures.
# needs: stipple-lab
set -eu
stipple=$1 scratch=$2
rm -rf "$scratch"
mkdir -p "$scratch"
cd "$scratch"
cat > cube.obj <<'END'
v -1 -1 -1
v 1 -1 -1
v 1 1 -1
v -1 1 -1
v -1 -1 1
v 1 -1 1
v 1 1 1
v -1 1 1
f 4 3 2 1
f 5 6 7 8
f 1 2 6 5
f 3 4 8 7
f 2 3 7 6
f 4 1 5 8
END
"$stipple" capture cube.obj -o points.ply --pictures pictures --resolution 32 > report.txt
grep -Eq '^[0-9]+ candidates, [0-9]+ of them filled in; 8 directions, 32 pixels' report.txt
for kind in position normal color; do
    for view in 0 7; do
        test -s "pictures/$kind$view.png"
    done
done
test ! -e pictures/color8.png
# `stipple order` accepts the candidates
"$stipple" order points.ply -o ordered.ply --count 50 --json | grep -q '"count": 50'
# usage
code=0
"$stipple" capture cube.obj 2> error.txt || code=$?
[ $code -eq 2 ] && grep -q 'expected one model' error.txt
code=0
"$stipple" capture missing.obj -o x.ply 2> error.txt || code=$?
[ $code -eq 1 ] && [ "$(wc -l < error.txt)" -eq 1 ] && [ ! -e x.ply ]
