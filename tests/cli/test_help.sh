#!/usr/bin/env bash
# Help, man pages and completions of every command. Arguments: executable, scratch folder.
set -u
stipple=$1
scratch=$2
. "$(dirname "$0")/shared.sh"
mkdir -p "$scratch" && cd "$scratch" || exit 1
# a page without warnings, with the available formatter
check_page()
{
    if installed mandoc "man pages"; then
        # long lines do not matter in generated pages; other messages are advice for base systems
        mandoc -T lint "$1" 2>&1 | grep -v -e 'STYLE: input text line longer than 80 bytes' \
            -e 'STYLE: operating system explicitly' -e 'STYLE: referenced manual not found' > lint
        [ ! -s lint ] || fail "mandoc: $1: $(head -3 lint)"
    fi
    if installed groff "man pages"; then
        groff -mandoc -ww -Tutf8 "$1" 2> lint > rendered || fail "groff: $1"
        [ ! -s lint ] || fail "groff: $1: $(head -3 lint)"
        [ -s rendered ] || fail "groff: $1: nothing was rendered"
    fi
}

# required sections of man pages: none is empty, each example is a separate command
check_sections()
{
    awk -v page="$1" '
        /^\.Sh / { section = substr($0, 5); next }
        { filled[section] = 1 }
        END {
            count = split("SYNOPSIS,DESCRIPTION,OPTIONS,FILES,EXIT STATUS,EXAMPLES", wanted, ",")
            for (i = 1; i <= count; ++i) {
                if (!(wanted[i] in filled)) { print page ": no " wanted[i]; bad = 1 }
            }
            exit bad
        }' "$1" > section || fail "$(cat section)"
    sed -n '/^\.Sh EXAMPLES$/,/^\.Sh /p' "$1" | grep -q '^\.Dl \$ .*stipple' || fail "$1: no example"
    for code in 0 1 2 130; do
        grep -q "^\.It $code\$" "$1" || fail "$1: no exit status $code"
    done
}

names=$("$stipple" help | sed -n '/^Commands:/,/^$/s/^  \([a-z-]*\) .*/\1/p')
for name in compare help; do
    echo "$names" | grep -qx -- "$name" || fail "help does not list $name"
done
"$stipple" help --man > stipple.1 || fail "help --man"
check_page stipple.1
check_sections stipple.1
# options FILE: those that a text of help lists
options()
{
    sed -n 's/^  \(-., \|    \)--\([a-z0-9-]*\).*/--\2/p' "$1"
}
for name in $names; do
    "$stipple" help "$name" > usual || fail "help $name"
    "$stipple" "$name" --help > text || fail "$name --help"
    cmp -s text usual || fail "help $name and $name --help differ"
    "$stipple" help "$name" --all > text || fail "help $name --all"
    "$stipple" "$name" --help-all > text2 || fail "$name --help-all"
    cmp -s text text2 || fail "help $name --all and $name --help-all differ"
    # the usual options are some of all, and the last line has the number of the others
    options usual > few
    options text > all
    sort all > named
    sort few | comm -23 - named > missing
    [ ! -s missing ] || fail "help-all of $name: $(cat missing)"
    [ "$(tail -1 usual)" = "'stipple $name --help-all' lists $(($(wc -l < all) - $(wc -l < few))) more options." ] ||
        fail "help $name: $(tail -1 usual)"
    [ "$(wc -l < few)" -le 16 ] || fail "help $name lists $(wc -l < few) options"
    [ "$(sort all | uniq -d)" = "" ] || fail "help-all $name repeats an option"
    ! grep -q -e '--leaf-\|--interval\|--color-threshold' text || fail "help-all $name: an option of stipple-lab"
    grep -q "^Usage: stipple $name" text || fail "help $name: no usage"
    awk 'length > 110 { exit 1 }' text || fail "help $name: lines are too long"
    "$stipple" help --man "$name" > "stipple-$name.1" || fail "help --man $name"
    check_page "stipple-$name.1"
    check_sections "stipple-$name.1"
    grep -q "^Examples:" text && grep -q "^Files:" text || fail "help $name: no examples or files"
    grep -q "Xr stipple.-$(echo "$name" | sed 's/-/.-/g') 1" stipple.1 || fail "stipple.1 does not name $name"
    # each option in the man page is in help
    grep -oE -- '--[a-z0-9-]+' text | sort -u > named
    sed -n 's/^\.It.* Fl \\-\([a-z\\-]*\).*/--\1/p' "stipple-$name.1" | tr -d '\\' | sort -u | comm -23 - named > missing
    [ ! -s missing ] || fail "help of $name: $(cat missing)"
    # each option in help is in the man page
    grep -oE 'Fl \\-[a-z0-9\\-]+' "stipple-$name.1" | sed 's/^Fl \\-/--/' | tr -d '\\' | sort -u > named
    sort -u all | comm -23 - named > missing
    [ ! -s missing ] || fail "man page of $name: $(cat missing)"
done
"$stipple" render --help > text
for heading in Output Camera Picture Quality Points Objects; do
    grep -qx "$heading:" text || fail "render --help has no group $heading"
done
"$stipple" render --help-all > text
for heading in 'Method blue' 'Method spt' 'Method stochastic' Effects 'Options of every command'; do
    grep -qx "$heading:" text || fail "render --help-all has no group $heading"
    grep -qx "\.Ss $heading" stipple-render.1 || fail "the man page of render has no group $heading"
done

for shell in bash zsh fish; do
    "$stipple" help --completion $shell > "completion.$shell" || fail "help --completion $shell"
    grep -q 'compare' "completion.$shell" || fail "completion of $shell: no compare"
    grep -q 'difference' "completion.$shell" || fail "completion of $shell: no --difference"
    if installed $shell "completions"; then
        $shell -n "completion.$shell" || fail "completion of $shell: syntax"
    fi
done

grep -q '^    render) .* --normal-clusters.* --cues' completion.bash || fail "completions lack rare options"

# the completions for typed words
complete_bash()
{
    COMP_WORDS=("$@")
    COMP_CWORD=$((${#COMP_WORDS[@]} - 1))
    _stipple
    echo "${COMPREPLY[*]}"
}
# shellcheck disable=SC1091
. ./completion.bash
[ "$(complete_bash stipple comp | tr ' ' '\n' | head -1)" = compare ] || fail "bash: a command"
[ "$(complete_bash stipple compare a.png --dif)" = --difference ] || fail "bash: an option"
[ "$(complete_bash stipple help --completion z)" = zsh ] || fail "bash: a choice"
[ "$(complete_bash stipple help --completion = z)" = zsh ] || fail "bash: a choice after ="
[ "$(complete_bash stipple help comp | tr ' ' '\n' | head -1)" = compare ] || fail "bash: help of a command"
touch picture.png
[ "$(complete_bash stipple compare pict)" = picture.png ] || fail "bash: a file"
exit $((failures > 0))
