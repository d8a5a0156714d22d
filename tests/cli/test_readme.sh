#!/usr/bin/env bash
# Runs every command of README.md as printed. Arguments: executable, scratch folder, source folder.
set -u
# shellcheck source=/dev/null
. "$(dirname "$0")/run_document.sh"
run_document README.md
exit $((failures > 0))
