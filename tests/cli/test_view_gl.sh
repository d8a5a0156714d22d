#!/usr/bin/env bash
# Tests interaction in the viewer's window with OpenGL drawing: see test_view.sh.
# Arguments: executable, scratch folder.
# needs: stipple-lab
VIEW_BACKEND=gl exec bash "$(dirname "$0")/test_view.sh" "$@"
