#!/usr/bin/env bash
# stipple check: verdicts, JSON and exit codes. Arguments: executable, scratch folder, source folder.
set -u
stipple=$1
scratch=$2
golden=$3/tests/golden/store/v1/sample.stip
mkdir -p "$scratch" && cd "$scratch" || exit 1
command -v python3 > /dev/null || exit 77
failures=0

fail()
{
    echo "FAIL: $*" >&2
    failures=$((failures + 1))
}

# run CODE ARGUMENTS...: stdout to out, stderr to err
run()
{
    local wanted=$1
    shift
    "$stipple" check "$@" > out 2> err
    local code=$?
    [ "$code" = "$wanted" ] || fail "check $*: exit $code, not $wanted: $(cat err)"
}

figure()
{
    python3 -c 'import json, sys; print(json.load(open("out"))[sys.argv[1]])' "$1"
}

run 0 "$golden"
grep -q '^ok: ' out || fail "no ok: $(cat out)"
[ ! -s err ] || fail "messages: $(cat err)"
run 0 "$golden" --json
size=$(stat -c %s "$golden")
keys=$(python3 -c 'import json; print(*sorted(json.load(open("out"))))')
[ "$keys" = "blocks bytes_checked fault file_bytes ok" ] || fail "keys: $keys"
[ "$(figure ok) $(figure fault)" = "True None" ] || fail "verdict: $(cat out)"
[ "$(figure file_bytes) $(figure bytes_checked)" = "$size $size" ] || fail "bytes: $(cat out)"

# a byte of the last block: the quick check does not look there
python3 - "$golden" << 'END'
import sys
data = bytearray(open(sys.argv[1], "rb").read())
data[-1] ^= 1
open("bulk.stip", "wb").write(data)
data[-1] ^= 1
data[300] ^= 1
open("directory.stip", "wb").write(data)
data[300] ^= 1
open("short.stip", "wb").write(data[:-1])
END
run 1 bulk.stip
[ ! -s out ] || fail "output: $(cat out)"
[ "$(wc -l < err)" = 1 ] || fail "not one sentence: $(cat err)"
grep -q 'bulk.stip: the checksum of the block' err || fail "fault: $(cat err)"
run 1 bulk.stip --json
[ "$(figure ok)" = False ] || fail "verdict: $(cat out)"
figure fault | grep -q 'the checksum of the block' || fail "fault: $(cat out)"
run 0 bulk.stip --quick
run 1 directory.stip --quick
run 1 short.stip --quick
grep -q 'ends after' err || fail "fault: $(cat err)"
run 1 missing.stip --json
[ "$(figure file_bytes) $(figure ok)" = "0 False" ] || fail "missing: $(cat out)"
run 2
run 2 a.stip b.stip
exit $((failures != 0))
