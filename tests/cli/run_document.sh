#!/usr/bin/env bash
# Sourced by the tests of README.md and docs/hello.md: run_document runs every command of the sh
# blocks of a document as printed, in order, in a scratch folder, with the programs that it prints;
# different options give different pictures. Arguments: executable, scratch folder, source folder.
# shellcheck disable=SC2034 # for those who source it
set -u
stipple=$1
scratch=$2
source=$3
rm -rf "$scratch"
. "$(dirname "$0")/shared.sh"
model=/usr/share/assimp/models/glTF2/2CylinderEngine-glTF-Binary/2CylinderEngine.glb
if [ ! -e $model ]; then
    echo "skipped: the package assimp-testmodels is not installed"
    exit 77
fi
skip_sanitizers
mkdir -p "$scratch"
export XDG_CACHE_HOME=$scratch/cache XDG_CONFIG_HOME=$scratch/config LIBGL_ALWAYS_SOFTWARE=1

# Runs the blocks of a document: each command separately, in the shell of the previous ones. Skips
# commands that build and test this program (they have tests of their own, and must exist), and
# commands that need a missing display.
cat > "$scratch/run.py" << 'END'
import re, shlex, subprocess, sys
document, out = sys.argv[1:]
blocks = re.findall(r"^```sh\n(.*?)^```", open(document).read(), re.M | re.S)
commands = [line for block in blocks for line in block.splitlines() if line.strip() and not line.startswith("#")]
assert len(commands) >= 5, f"{document} has {len(commands)} commands"
assert all(not c.endswith("\\") for c in commands), "commands stand on one line, to be copied"
for text in re.findall(r"^```(?:c|python)\n(.*?)^```", open(document).read(), re.M | re.S):
    name = re.match(r"(?://|#) (\w+\.\w+)$", text, re.M)[1] # a program; its first line names it
    open(f"{out.rsplit('/', 1)[0]}/{name}", "w").write(text)
with open(out, "w") as script:
    script.write("set -u\n")
    for command in commands:
        words = shlex.split(command, comments=True)
        if words[0] in ("make", "scripts/setup", "scripts/demo", "scripts/test"):
            script.write(f"test -e {'Makefile' if words[0] == 'make' else words[0]}")
        elif words[0].endswith("stipple") and words[1] == "view":
            script.write(f"look {' '.join(shlex.quote(w) for w in words[2:])}")
        else:
            script.write(command)
        script.write(f"\ncode=$?; [ $code -eq 0 ] || {{ echo {shlex.quote(command)}: exit $code >&2; exit 1; }}\n")
END
look() # a window opens, shows all, and stays open until it is closed
{
    installed xvfb-run "windows" || { test -e "$1"; return; }
    # shellcheck disable=SC2016
    SDL_AUDIODRIVER=dummy xvfb-run -a bash -c '
        rm -f look.json
        stipple view "$@" --report look.json & viewer=$!
        until grep -q "\"complete\": true" look.json 2> /dev/null; do
            kill -0 $viewer 2> /dev/null || exit 1
            sleep 0.1
        done
        kill $viewer && wait $viewer
        [ $? -eq 0 ] || [ $? -eq 143 ]' look "$@"
}
export -f look

run_document() # DOCUMENT
{
    local document=$1 folder pictures twins
    folder=$scratch/$(basename "$document" .md)
    mkdir -p "$folder/bin" "$folder/build"
    ln -s "$(dirname "$(dirname "$stipple")")" "$folder/build/release"
    ln -s "$stipple" "$folder/bin/stipple"
    ln -s "${stipple%/*/*}/lab/stipple-lab" "$folder/bin/stipple-lab"
    ln -s "$source/scripts" "$folder/scripts"
    cp "$source/Makefile" "$folder"
    cp "$model" "$folder/plant.glb" # a reader's own model
    cp "$source/lab/scenes/flights/one-mesh.json" "$folder/flight.json"
    python3 "$scratch/run.py" "$source/$document" "$folder/run.sh" || { fail "$document has no commands"; return; }
    (cd "$folder" && PATH=$folder/bin:$PATH bash run.sh > out 2> err) || fail "$document: $(tail -n 3 "$folder/err")"
    pictures=$(find "$folder" -maxdepth 1 -name '*.png' -o -maxdepth 1 -name '*.jpg' | sort)
    [ "$(echo "$pictures" | wc -l)" -ge 2 ] || fail "$document draws no pictures"
    # shellcheck disable=SC2086
    twins=$(sha256sum $pictures | sort | awk '$1 == last { print before, $2 } { last = $1; before = $2 }')
    [ -z "$twins" ] || fail "$document: these pictures are equal: $twins"
}
