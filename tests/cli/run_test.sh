#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# Runs a test of the command line with its own, initially empty cache: tests that run at the
# same time must not build the same file, and none may find files of an earlier run.
# Arguments: script, executable, scratch folder, source folder.
if [ $# -ne 4 ]; then
    echo "usage: run_test.sh SCRIPT EXECUTABLE SCRATCH SOURCE" >&2
    exit 2
fi
if ! command -v python3 > /dev/null; then # which nearly all tests use
    echo "skipped: python3 is not installed"
    exit 77
fi
export XDG_CACHE_HOME=$3-cache
rm -rf "$XDG_CACHE_HOME"
# shaders that Mesa compiled are shared: compiling them takes as long as many tests
export MESA_SHADER_CACHE_DIR=${MESA_SHADER_CACHE_DIR:-$(dirname "$3")/mesa}
# under sanitizers: third-party drivers do not free their memory until the process ends
printf 'leak:%s\n' libGL libX _dri.so libSDL libLLVM libdbus swrast > "$3-leaks"
export LSAN_OPTIONS=suppressions=$3-leaks:print_suppressions=0
bash "$@"
code=$?
rm -rf "$XDG_CACHE_HOME" "$3-leaks"
exit $code
