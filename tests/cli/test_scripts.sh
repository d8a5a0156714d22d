#!/usr/bin/env bash
# scripts/test counts crashed tests, tests that cannot be started, and missing ones as failed.
# Folders of tests, run by the real ctest, stand in for builds. Arguments: executable, scratch
# folder, source folder.
set -u
scratch=$2
source=$3
rm -rf "$scratch"
. "$(dirname "$0")/shared.sh"
mkdir -p "$scratch/scripts" "$scratch/bin" && cd "$scratch" || exit 1
installed ctest "scripts/test" || exit 77
CTEST=$(command -v ctest)
export CTEST
cp "$source/scripts/test" scripts/test
printf '#!/bin/sh\nexit 0\n' | tee scripts/setup > bin/cmake
printf '#!/bin/sh\ncd "$2" || exit 1\nshift 2\n[ ! -e dies ] || kill -KILL $$\nexec "$CTEST" "$@"\n' > bin/ctest
chmod +x scripts/setup bin/cmake bin/ctest

mkdir -p build/asan/tests

# unit_tests COMMANDS: what stands in for the program of the unit tests
unit_tests()
{
    printf '#!/bin/sh\n[ "$1" = --jobs ] || exit 9\n%s\n' "$1" > build/asan/tests/stp_tests
    chmod +x build/asan/tests/stp_tests
}

# counts LINE CODE: scripts/test ends this way, with a test of each kind that passes, one that only
# the other build runs, and the changes made by `change`
counts()
{
    local line=$1 code=$2 got
    rm -rf release asan
    mkdir release asan
    printf 'add_test(cli.fine "/bin/true")\nadd_test(format.elsewhere "/bin/false")\n' > release/CTestTestfile.cmake
    printf 'add_test(format.fine "/bin/true")\nadd_test(cli.elsewhere "/bin/false")\n' > asan/CTestTestfile.cmake
    unit_tests 'echo "ok   fine, 0.10 s"; echo "1 passed, 0 failed, 0 skipped"'
    change
    PATH=$PWD/bin:$PATH scripts/test > out 2> err
    got=$?
    [ "$(tail -n 1 out)" = "$line" ] && [ $got -eq "$code" ] || fail "not \"$line\" and $code, but $got: $(tail -n 3 out)"
}

change() { :; }
counts "3 passed, 0 failed" 0
change() { printf 'add_test(cli.skips "/bin/sh" "-c" "exit 77")\nset_tests_properties(cli.skips PROPERTIES SKIP_RETURN_CODE 77)\n' >> release/CTestTestfile.cmake; }
counts "3 passed, 0 failed, 1 skipped" 0
change() { echo 'add_test(cli.crashes "/bin/sh" "-c" "kill -SEGV $$")' >> release/CTestTestfile.cmake; }
counts "3 passed, 1 failed" 1
change() { echo 'add_test(cli.lost "/nowhere/tests")' >> release/CTestTestfile.cmake; }
counts "3 passed, 1 failed, 1 skipped" 1
change() { : > asan/CTestTestfile.cmake; }
counts "2 passed, 1 failed" 1
change() { touch release/dies; }
counts "2 passed, 1 failed" 1
# unit tests: one that fails beside one that is skipped, and a program that ends early or is missing
change() { unit_tests 'echo "ok   fine, 0.10 s"; echo "skip odd: no reason"; echo "a.c:3: failed: 1 == 2"; echo "FAIL bad, 0.10 s"; echo "1 passed, 1 failed, 1 skipped"; exit 1'; }
counts "3 passed, 1 failed, 1 skipped" 1
grep -q '^a.c:3: failed: 1 == 2$' out && grep -q '^FAIL bad' out || fail "the message of a failed unit test is not printed: $(cat out)"
grep -qE '^(ok|skip) ' out && fail "unit tests that did not fail are printed: $(cat out)"
change() { unit_tests 'echo "ok   fine, 0.10 s"; kill -KILL $$'; }
counts "2 passed, 1 failed" 1
change() { unit_tests 'echo "ok   fine, 0.10 s"'; }
counts "2 passed, 1 failed" 1
change() { rm build/asan/tests/stp_tests; }
counts "2 passed, 1 failed" 1

# skipped CODE LINES COMMAND: scripts/skipped_tests.py prints these lines for a test that runs COMMAND
skipped()
{
    local code=$1 lines=$2 got
    rm -rf skips
    mkdir skips
    {
        echo 'add_test(fine "/bin/true")'
        echo "add_test(odd \"/bin/sh\" \"-c\" \"$3\")"
        echo 'set_tests_properties(odd PROPERTIES SKIP_RETURN_CODE 77)'
    } > skips/CTestTestfile.cmake
    "$CTEST" --test-dir skips --output-junit "$PWD/skips/dev.xml" > ctest.log 2>&1 || fail "ctest: $(cat ctest.log)"
    "$source/scripts/skipped_tests.py" skips/dev.xml > out 2> err
    got=$?
    [ $got -eq "$code" ] && [ "$(cat out)" = "$lines" ] || fail "not $code and \"$lines\", but $got: $(cat out err)"
}

skipped 0 "" "echo all of it"
skipped 0 "skipped: there is no GPU: odd (dev)" "echo skip name: there is no GPU; exit 77"
skipped 1 "skipped: what is not installed: odd (dev)" "echo skipped: what is not installed; exit 77"
skipped 1 "skipped: a part: x is not installed: odd (dev)" "echo skipped: a part: x is not installed"
skipped 1 "skipped: no reason is given: odd (dev)" "exit 77"

# scripts/setup takes the headings of packages.txt as ends; a dpkg-query without packages lists what it asks for
cp "$source/scripts/setup" scripts/setup
printf '# Building:\na\n# Testing:\nb\n# Long checks:\nc\n' > packages.txt
printf '#!/bin/sh\nfor last; do :; done\necho "$last" >> asked\necho installed\n' > bin/dpkg-query
printf '#!/bin/sh\nexit 1\n' > bin/apt-get
chmod +x bin/dpkg-query bin/apt-get
for wanted in "--programs:a" ":a b" "--all:a b c"; do
    rm -f asked
    option=${wanted%%:*}
    PATH=$PWD/bin:$PATH scripts/setup ${option:+"$option"} || fail "scripts/setup $option fails"
    [ "$(tr '\n' ' ' < asked)" = "${wanted#*:} " ] || fail "scripts/setup $option asks for $(cat asked)"
done
PATH=$PWD/bin:$PATH scripts/setup --some 2> err
[ $? -eq 2 ] || fail "scripts/setup takes any option"
exit $((failures > 0))
