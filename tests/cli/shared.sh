# SPDX-License-Identifier: MIT
# What tests of the command line share; sourced before they change to their folder.
# shellcheck shell=bash
failures=0

fail()
{
    echo "FAIL: $*" >&2
    failures=$((failures + 1))
}
