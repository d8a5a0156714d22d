#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# scripts/attack finds nothing in one file of each kind, and detects a faulty program. Arguments:
# executable, scratch folder, source folder.
# needs: stipple-lab
set -u
stipple=$1
scratch=$2
source=$3
rm -rf "$scratch"
. "$(dirname "$0")/shared.sh"
mkdir -p "$scratch" && cd "$scratch" || exit 1

"$source/scripts/attack" --rounds 1 --stipple "$stipple" --keep "$PWD/kept" > table 2> err || fail "attack: $(cat table err)"
grep -q '^| stip | ' table && grep -q '^| race: ' table && grep -q ', 0 found$' table || fail "no table: $(cat table)"
[ ! -e kept ] || fail "files are kept without a finding"

"$source/scripts/attack" --rounds 1 --only nothing --stipple "$stipple" --keep "$PWD/kept" > table 2> err &&
    fail "a campaign without files succeeds"

# a program whose first calls of "info" crash, say nothing, print terminal escapes, and leave files
# behind: each fault is found and kept. mkdir counts, as two threads call.
cat > program << END
#!/bin/bash
[ "\$1" = info ] || exec "$stipple" "\$@"
mkdir "$PWD/crash" 2> /dev/null && kill -SEGV \$\$
mkdir "$PWD/silent" 2> /dev/null && exit 1
mkdir "$PWD/escapes" 2> /dev/null && { printf "stipple-lab: \033[2J\n" >&2; exit 1; }
mkdir "$PWD/leaves" 2> /dev/null && { touch left-behind; echo "stipple-lab: no" >&2; exit 1; }
exec "$stipple" "\$@"
END
chmod +x program
"$source/scripts/attack" --rounds 1 --only stip --stipple "$PWD/program" --keep "$PWD/kept" > table 2> err &&
    fail "a faulty program passes"
for fault in 'ends with -11' 'ends with 1 without a message' 'control characters' "leaves \['left-behind'\]"; do
    grep -q "^found: stip: $fault" table || fail "not found: $fault: $(cat table err)"
    grep -q "$fault" kept/*.txt || fail "not kept: $fault"
done
grep -q '^| stip | 4 |' table || fail "not all files were tried: $(cat table)"

[ $failures -eq 0 ] || exit 1
echo "all well"
