#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# scripts/attack finds nothing in one file of each kind, and detects a faulty program. Arguments:
# executable, scratch folder, source folder.
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

# a program that crashes, one without an error message, one that prints terminal escapes, and one
# that leaves files behind
for wrong in 'kill -SEGV $$' 'exit 1' 'printf "stipple: \033[2J\n" >&2; exit 1' 'touch left-behind; echo "stipple: no" >&2; exit 1'; do
    printf '#!/bin/bash\n[ "$1" = info ] || exec "%s" "$@"\n%s\n' "$stipple" "$wrong" > program
    chmod +x program
    "$source/scripts/attack" --rounds 1 --only stip --stipple "$PWD/program" --keep "$PWD/kept" > table 2> err &&
        fail "$wrong is not detected"
    grep -q '^found: ' table || fail "$wrong: no finding is reported: $(cat table err)"
    [ "$(find kept -name '*.txt' | wc -l)" -gt 0 ] || fail "$wrong: no file is kept"
    rm -rf kept
done

[ $failures -eq 0 ] || exit 1
echo "all well"
