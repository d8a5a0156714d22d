# SPDX-License-Identifier: MIT
# Shared by the tests of the command line; sourced before they change to their folder.
# shellcheck shell=bash
failures=0

# a failed check fails the test, however it ends
end_test()
{
    local code=$?
    [ $code -ne 0 ] || [ "$failures" -eq 0 ] || code=1
    exit $code
}
trap end_test EXIT

fail()
{
    echo "FAIL: $*" >&2
    failures=$((failures + 1))
}

# refused CODE WORD ARGUMENTS...: the executable exits with CODE and prints one sentence that
# contains WORD, and nothing on stdout; `programs` overrides its PATH
refused()
{
    local wanted=$1 word=$2 got
    shift 2
    PATH=${programs:-$PATH} "$stipple" "$@" > out 2> err
    got=$?
    [ $got -eq "$wanted" ] || fail "$* exits with $got, not $wanted"
    grep -q -- "$word" err || fail "$* does not print $word: $(cat err)"
    [ "$(grep -c "^${stipple##*/}: " err)" -eq 1 ] || fail "$* does not print exactly one sentence: $(cat err)"
    [ ! -s out ] || fail "$* writes on stdout"
}

# installed PROGRAM TESTED: whether a program is installed; if not, prints what is not tested. This
# line is what scripts/skipped_tests.py looks for.
installed()
{
    command -v "$1" > /dev/null && return
    echo "skipped: $2: $1 is not installed"
    return 1
}

# skip_sanitizers: skips a test that links programs with the library, if this needs sanitizers
skip_sanitizers()
{
    if grep -qE '^STP_SANITIZE:[A-Z]+=.+' "$(dirname "$(dirname "$stipple")")/CMakeCache.txt"; then
        echo "skipped: a library with sanitizers cannot be linked here"
        exit 77
    fi
}

# value FILE KEY: the first value with this name in a JSON file of the executable: a number, a text
# without its quotes, or a word (null). Without a start of an interpreter for each.
value()
{
    local text
    text=$(< "$1")
    [[ $text =~ \"$2\":\ ([^,$'\n'}]*) ]] || echo "no $2 in $1" >&2
    text=${BASH_REMATCH[1]#\"}
    echo "${text%\"}"
}

# holds COMPARISON: of numbers, joined by &&; a word such as null is none
holds()
{
    if [[ $1 =~ [a-df-zA-Z] ]]; then
        echo "not only numbers: $1" >&2
        return 1
    fi
    awk "BEGIN { exit !($1) }"
}
