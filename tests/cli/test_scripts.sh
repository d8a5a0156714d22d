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
CTEST=$(command -v ctest) || exit 77
export CTEST
cp "$source/scripts/test" scripts/test
printf '#!/bin/sh\nexit 0\n' | tee scripts/setup > bin/cmake
printf '#!/bin/sh\ncd "$2" || exit 1\nshift 2\n[ ! -e dies ] || kill -KILL $$\nexec "$CTEST" "$@"\n' > bin/ctest
chmod +x scripts/setup bin/cmake bin/ctest

# counts LINE CODE: scripts/test ends this way, with a test that passes in each build, one that only
# the other build runs, and the changes made by `change`
counts()
{
    local line=$1 code=$2 got
    rm -rf release asan
    mkdir release asan
    printf 'add_test(cli.fine "/bin/true")\nadd_test(unit.elsewhere "/bin/false")\n' > release/CTestTestfile.cmake
    printf 'add_test(unit.fine "/bin/true")\nadd_test(cli.elsewhere "/bin/false")\n' > asan/CTestTestfile.cmake
    change
    PATH=$PWD/bin:$PATH scripts/test > out 2> err
    got=$?
    [ "$(tail -n 1 out)" = "$line" ] && [ $got -eq "$code" ] || fail "not \"$line\" and $code, but $got: $(tail -n 3 out)"
}

change() { :; }
counts "2 passed, 0 failed" 0
change() { printf 'add_test(cli.skips "/bin/sh" "-c" "exit 77")\nset_tests_properties(cli.skips PROPERTIES SKIP_RETURN_CODE 77)\n' >> release/CTestTestfile.cmake; }
counts "2 passed, 0 failed, 1 skipped" 0
change() { echo 'add_test(unit.crashes "/bin/sh" "-c" "kill -SEGV $$")' >> asan/CTestTestfile.cmake; }
counts "2 passed, 1 failed" 1
change() { echo 'add_test(cli.lost "/nowhere/tests")' >> release/CTestTestfile.cmake; }
counts "2 passed, 1 failed, 1 skipped" 1
change() { : > asan/CTestTestfile.cmake; }
counts "1 passed, 1 failed" 1
change() { touch release/dies; }
counts "1 passed, 1 failed" 1
exit $((failures > 0))
