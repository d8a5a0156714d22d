#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# Runs a test of the command line with a cache of its own, empty at the start: tests that run at the
# same time must not build the same file, and none may find what an earlier run left.
# Arguments: script, executable, scratch folder, source folder.
export XDG_CACHE_HOME=$3-cache
rm -rf "$XDG_CACHE_HOME"
bash "$@"
code=$?
rm -rf "$XDG_CACHE_HOME"
exit $code
