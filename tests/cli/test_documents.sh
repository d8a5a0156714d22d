#!/usr/bin/env bash
# The documents agree with the program, the picture of the house with the code, and
# scripts/check_docs.py finds each kind of fault, in documents and in comments.
# Arguments: executable, scratch folder, source folder.
set -u
stipple=$1
scratch=$2
source=$3
rm -rf "$scratch"
. "$(dirname "$0")/shared.sh"
mkdir -p "$scratch/docs/algorithms" "$scratch/tests" "$scratch/src" "$scratch/scripts"

python3 "$source/scripts/check_docs.py" --tool "$stipple" --tool "${stipple%/*/*}/lab/stipple-lab" > "$scratch/found" ||
    fail "documents have faults: $(cat "$scratch/found")"
python3 "$source/scripts/draw_house.py" --check 2> "$scratch/found" || fail "$(cat "$scratch/found")"

cat > "$scratch/src/there.c" << 'END'
// Begins as docs/testing.md, A heading, says; ends like there.c of src/there.c, stp_there.width and stp_there_*.
// stp_gone is not in missing.h, nor is it stp_there.height
// of src/absent/there.c (docs/testing.md, No heading).
const char* text = "// stp_in_a_string of nowhere.c";
int there(void)
END
printf 'typedef struct stp_there {\n    int width;\n} stp_there;\n' > "$scratch/src/there.h"
printf '#!/bin/sh\n# runs lost.sh in docs/nowhere\necho "# gone.sh"\n' > "$scratch/scripts/run"
printf '"""Reads lost.py."""\nname = "gone.py"\n' > "$scratch/scripts/read.py"

# a folder of documents with one fault of each kind
touch "$scratch/CHANGELOG.md" "$scratch/README.md"
echo 'void test_that_exists(test_state* test)' > "$scratch/tests/test_one.c"
{
    printf 'word %.0s' {1..21} && echo
    echo 'See [nothing](missing.md), [no heading](testing.md#absent) and [this one](testing.md#a-heading).'
    echo 'The file `src/missing.c`, the function `stp_missing` and the member `stp_there.depth`.'
    echo 'The function `there` in `src/there.c`, and `elsewhere` in `src/there.c`.'
    printf '\n| idea | `src/there.c` | `there`, `absent` |\n\n'
    echo 'Run `stipple build x.obj --missing` and `stipple missing`, not `stipple build x.obj --fresh`.'
} > "$scratch/docs/faults.md"
printf '## A heading\n' > "$scratch/docs/testing.md"
printf '# Page\n\n## One\n\n**Rule.** One.\n\n**Guarantee.** Much.\n\n## Two\n\n**Test.** `that_exists`, `that_is_missing`.\n' \
    > "$scratch/docs/algorithms/page.md"
printf 'word %.0s\n' {1..3001} > "$scratch/docs/performance.md"
python3 "$source/scripts/check_docs.py" --root "$scratch" --tool "$stipple" > "$scratch/faults" &&
    fail "faults are not found"
cat > "$scratch/expected" << 'END'
docs/algorithms/page.md: no test that_is_missing
docs/algorithms/page.md: section One has a guarantee but no test
docs/algorithms/page.md: the page has no part Code
docs/algorithms/page.md: the page has no part Paper
docs/faults.md: 1: 105 columns, at most 100
docs/faults.md: no code has the name stp_missing
docs/faults.md: no command: stipple missing
docs/faults.md: no file for the link missing.md
docs/faults.md: no file src/missing.c
docs/faults.md: no heading for the link testing.md#absent
docs/faults.md: src/there.c has no elsewhere
docs/faults.md: src/there.c has no function absent
docs/faults.md: stipple build has no option --missing
docs/faults.md: stp_there has no member depth
docs/performance.md: 3001 words, at most 3000
scripts/read.py:1: no file lost.py
scripts/run:2: no file lost.sh
scripts/run:2: nothing is at docs/nowhere
src/there.c:2: no code has the name stp_gone
src/there.c:2: no file missing.h
src/there.c:2: stp_there has no member height
src/there.c:3: docs/testing.md has no section No heading
src/there.c:3: no file src/absent/there.c
END
sort "$scratch/faults" | diff "$scratch/expected" - > "$scratch/difference" || fail "$(cat "$scratch/difference")"

# figures have a command, a date and an age
python3 "$source/scripts/figure_ages.py" --check > "$scratch/found" || fail "figures: $(cat "$scratch/found")"
ages=$scratch/ages
mkdir -p "$ages/docs" "$ages/src/order" "$ages/src/raster"
echo '# Nothing is measured' > "$ages/README.md"
cat > "$ages/docs/performance.md" << 'END'
| what | measured | command | date |
|---|---|---|---|
| order | 3 ms | `stipple-lab bench order` | 2026-01-02 |
| splats | 4 M | `bench/splats.py --quick` | 2026-01-02 |
END
commit() { # file, day
    echo "$2" >> "$ages/$1" && git -C "$ages" add -A &&
        GIT_COMMITTER_DATE="$2T12:00:00" git -C "$ages" -c user.name=a -c user.email=a@b.c commit -q -m "$1" --date "$2T12:00:00"
}
git -C "$ages" init -q && commit src/order/a.c 2026-01-01 && commit src/order/a.c 2026-01-03 &&
    commit src/order/a.c 2026-01-04 && commit src/raster/b.c 2026-01-01 || fail "no history"
python3 "$source/scripts/figure_ages.py" --root "$ages" > "$scratch/found" || fail "ages: $(cat "$scratch/found")"
printf 'docs/performance.md:3: order: 2026-01-02, 2 commits since\ndocs/performance.md:4: splats: 2026-01-02, 0 commits since\n' |
    diff - "$scratch/found" > "$scratch/difference" || fail "$(cat "$scratch/difference")"
cat > "$ages/docs/performance.md" << 'END'
| what | measured | command | date |
|---|---|---|---|
| order | 3 ms | | 2026-01-02 |
| splats | 4 M | `bench/splats.py` | soon |
| frames | 5 ms | `bench/guess.py` | 2026-01-02 |
| tomorrow | 6 ms | `bench/splats.py` | 9999-01-02 |
END
python3 "$source/scripts/figure_ages.py" --root "$ages" --check > "$scratch/found" && fail "faults of figures are not found"
cat > "$scratch/expected" << 'END'
docs/performance.md:3: order: has no command
docs/performance.md:4: splats: has no date
docs/performance.md:5: frames: the rooms of `bench/guess.py` are not known
docs/performance.md:6: tomorrow: its date is in the future
END
diff "$scratch/expected" "$scratch/found" > "$scratch/difference" || fail "$(cat "$scratch/difference")"
exit $((failures > 0))
