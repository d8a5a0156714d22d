#!/usr/bin/env bash
# Exit codes, and the use of stdout and stderr. Arguments: executable, scratch folder.
set -u
stipple=$1
scratch=$2
. "$(dirname "$0")/shared.sh"
mkdir -p "$scratch" && cd "$scratch" || exit 1
# expect CODE OUT ERR ARGUMENT...: OUT and ERR are patterns of the streams' first lines; empty: nothing printed
expect()
{
    local code=$1 out=$2 err=$3
    shift 3
    "$stipple" "$@" > out 2> err
    local got=$?
    [ $got -eq "$code" ] || fail "stipple $*: exit $got, not $code"
    check_stream out "$out" "stipple $*"
    check_stream err "$err" "stipple $*"
}

check_stream()
{
    if [ -z "$2" ]; then
        [ ! -s "$1" ] || fail "$3: $1 should be empty: $(head -1 "$1")"
    else
        head -1 "$1" | grep -Eq -- "$2" || fail "$3: $1 should begin with $2: $(head -1 "$1")"
    fi
}

expect 2 '' '^Usage: stipple COMMAND'
expect 0 '^Usage: stipple COMMAND' '' --help
expect 0 '^stipple [0-9]+\.[0-9]+\.[0-9]+$' '' --version
expect 0 '^stipple [0-9]+\.[0-9]+\.[0-9]+$' '' compare --version
expect 0 '^Usage: stipple compare' '' compare -h
expect 0 '^Usage: stipple compare' '' compare --json --help
expect 0 '^Usage: stipple compare' '' --help compare
expect 0 '^Usage: stipple compare' '' --help-all compare
# what one table of one paper needs
for option in leaf-points leaf-neighbors samples interval color-threshold; do
    expect 2 '' "^stipple: --$option is an option of stipple-lab$" build a.obj -o a.stip --$option 20
done
expect 2 '' '^stipple: --drop is an option of stipple-lab$' order a.ply -o b.ply --drop=0.5
expect 2 '' '^stipple: unknown option --intervl$' order a.ply -o b.ply --intervl 3
expect 2 '' "^stipple: unknown command 'compar'; did you mean 'compare'\?$" compar
expect 2 '' "^stipple: unknown command 'zzzzzz'$" zzzzzz
expect 2 '' '^stipple: unknown option --nonsense$' --nonsense
expect 2 '' '^stipple: unknown option --jsno; did you mean --json\?$' compare --jsno
expect 2 '' '^stipple: unknown option -z$' compare -z
expect 2 '' '^stipple: --mask needs a value: M.png$' compare --mask
expect 2 '' '^stipple: --json takes no value$' compare --json=yes
expect 2 '' "^stipple: --threads: 'two' is not a whole number$" compare --threads two
expect 2 '' "^stipple: --threads: '-1' is not a whole number$" compare --threads=-1
expect 2 '' "^stipple: --threads: '9999999' is not within 0 and 1024$" compare --threads=9999999
expect 2 '' "^stipple: --threads: '99999999999999999999999' is not a whole number$" \
    compare --threads=99999999999999999999999
expect 2 '' "^stipple: --completion: 'tcsh' is not one of bash\|zsh\|fish$" help --completion tcsh
expect 2 '' '^stipple: compare needs two pictures' compare
expect 2 '' '^stipple: compare needs two pictures, but got 3' compare a.png b.png c.png
# after -- an option is an argument, and so is a single dash
expect 2 '' '^stipple: compare needs two pictures, but got 1' compare -- --json
expect 2 '' '^stipple: compare needs two pictures, but got 1' compare -
expect 2 '' '^stipple: only one picture can come from standard input' compare - -
# failures exit with 1 and one sentence
expect 1 '' '^stipple: missing.png: No such file or directory$' compare missing.png missing.png
[ "$(wc -l < err)" -eq 1 ] || fail "one sentence expected: $(cat err)"
# options may follow arguments, and flags may be joined
expect 1 '' '^stipple: missing.png: ' compare missing.png -qv missing.png --json
# the option after an unknown command is ignored
expect 2 '' "^stipple: unknown command 'nope'" nope --json

# a full disk and a closed pipe are failures
if [ -w /dev/full ]; then
    "$stipple" help > /dev/full 2> err
    [ $? -eq 1 ] || fail "a full disk should give exit 1"
    grep -q '^stipple: standard output: cannot be written: No space' err || fail "full disk: $(cat err)"
fi
{ "$stipple" help --completion bash 2> err; echo $? > code; } | true
case $(cat code) in
0 | 1) ;; # 0: all was written before the reader left
*) fail "a closed pipe should give exit 1, not $(cat code)" ;;
esac

# without a terminal there are no escape sequences
"$stipple" help > out 2> err
"$stipple" nope >> out 2>> err
if grep -q "$(printf '\033')" out err; then
    fail "escape sequences in a file"
fi
exit $((failures > 0))
