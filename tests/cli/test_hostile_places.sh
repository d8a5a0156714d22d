#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# Pipes and folders where files are expected, limits of file sizes, and folders that others made: one sentence, and no
# waiting. Arguments: executable, scratch folder.
set -u
stipple=$1
scratch=$2
rm -rf "$scratch"
. "$(dirname "$0")/shared.sh"
mkdir -p "$scratch" && cd "$scratch" || exit 1
export XDG_CACHE_HOME=$PWD/cache

printf 'v 0 0 0\nv 1 0 0\nv 1 2 0\nv 0 2 0\nf 1 2 3 4\n' > box.obj
"$stipple" build box.obj -o box.stip -q || fail "build"
"$stipple" render box.stip --size 32x32 -o box.png -q || fail "render"

# a pipe that nobody writes into is not waited for; the descriptor keeps a failure from hanging the test
mkfifo pipe pipe.stip pipe.obj pipe.png
exec 8<> pipe 9<> pipe.stip 10<> pipe.obj 11<> pipe.png
for name in pipe pipe.stip pipe.obj; do
    for command in info check build render; do
        case $command in
            build) more=(-o out.stip) ;;
            render) more=(-o out.png) ;;
            *) more=() ;;
        esac
        [ $command = check ] && [ $name != pipe.stip ] && continue
        refused 1 "is not a regular file" $command $name "${more[@]}"
    done
done
refused 1 "is not a regular file" compare box.png pipe.png
refused 1 "is not a regular file" fly box.stip --path pipe --frames 2
exec 8>&- 9>&- 10>&- 11>&-

# a file that may not grow: a sentence instead of a signal, and no output
"$stipple" scene city-small --scale 0.05 -o scene.glb -q || fail "scene"
(
    ulimit -f 16
    refused 1 "File too large" build scene.glb -o large.stip
    [ $failures -eq 0 ]
) || fail "a limit of file sizes"
[ ! -e large.stip ] || fail "an output that was cut off is kept"

# without a home, built models go to a folder that only its owner can write
folder=/tmp/stipple-$(id -u)
if [ ! -e "$folder" ]; then
    mkdir -m 777 "$folder"
    chmod 777 "$folder"
    (
        unset XDG_CACHE_HOME HOME
        refused 1 "others may write there" render box.obj --size 32x32 -o box.png
        [ $failures -eq 0 ]
    ) || fail "a folder that others may write"
    rmdir "$folder"
fi

[ $failures -eq 0 ] && echo "ok"
exit $((failures != 0))
