#!/usr/bin/env bash
# Fails if a C file differs from clang-format's output. Skipped unless it is version 14 (Debian 12):
# others format differently.
cd "$(dirname "$0")/.." || exit 1
formatter=clang-format
command -v clang-format-14 > /dev/null && formatter=clang-format-14
if ! $formatter --version 2> /dev/null | grep -q 'version 14\.'; then
    echo "clang-format 14 is not installed"
    exit 77
fi
folders=()
for folder in include src program lab examples tests fuzz; do
    [ -d $folder ] && folders+=("$folder")
done
find "${folders[@]}" -name '*.[ch]' -o -name '*.cpp' | sort | xargs $formatter --dry-run -Werror
