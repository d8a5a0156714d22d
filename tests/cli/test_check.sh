#!/usr/bin/env bash
# stipple check: results, JSON and exit codes. Arguments: executable, scratch folder, source folder.
set -u
stipple=$1
scratch=$2
golden=$3/tests/golden/store/v1/sample.stip
. "$(dirname "$0")/shared.sh"
mkdir -p "$scratch" && cd "$scratch" || exit 1
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

# a byte of the last block: the quick check does not read it
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
[ "$(wc -l < err)" = 1 ] || fail "not exactly one sentence: $(cat err)"
grep -q 'bulk.stip: the checksum of the block' err || fail "fault: $(cat err)"
run 1 bulk.stip --json
[ "$(figure ok)" = False ] || fail "verdict: $(cat out)"
figure fault | grep -q 'the checksum of the block' || fail "fault: $(cat out)"
run 0 bulk.stip --quick
run 1 directory.stip --quick
run 1 short.stip --quick
grep -q 'ends after' err || fail "fault: $(cat err)"

# a directory too large to be read whole: the quick check covers the first page of each section and
# the general information; the full check covers the rest
python3 - << 'END'
import random
random.seed(1)
names = [f"part {i} {random.random()}" for i in range(7000)]
with open("many.obj", "w") as f:
    f.write("v 0 0 0\nv 1 0 0\nv 0 1 0\n")
    for i, name in enumerate(names):
        f.write(f"o {name}\nv {i} 0 1\nf 1 2 {4 + i}\n")
END
"$stipple" build many.obj -o many.stip --threshold 100000 --quiet > out 2> err || fail "build: $(cat err)"
run 0 many.stip --quick --json
[ "$(python3 -c 'import json; d = json.load(open("out")); print(d["bytes_checked"] < 600000 < d["file_bytes"])')" = \
    True ] || fail "bytes of a quick check: $(cat out)"
python3 - << 'END'
import struct
data = bytearray(open("many.stip", "rb").read())
sections = [struct.unpack_from("<IIQQ", data, 128 + 40 * i) for i in range(struct.unpack_from("<I", data, 32)[0])]
def damage(name, at):
    data[at] ^= 1
    open(name, "wb").write(data)
    data[at] ^= 1
damage("header.stip", 50)
damage("table.stip", 140)
for kind, _, offset, size in sections:
    if kind in (13, 16, 19, 20, 21):
        damage(f"section-{kind}.stip", offset + size - 1)
    if kind == 17:
        damage("objects-first.stip", offset)
        damage("objects-last.stip", offset + size - 1)
END
for file in header.stip table.stip section-*.stip objects-first.stip; do
    run 1 "$file" --quick
    [ "$(wc -l < err)" = 1 ] || fail "$file: not exactly one sentence: $(cat err)"
done
[ "$(ls section-*.stip | wc -l)" = 5 ] || fail "sections: $(ls section-*.stip)"
run 0 objects-last.stip --quick
run 1 objects-last.stip

run 1 missing.stip --json
[ "$(figure file_bytes) $(figure ok)" = "0 False" ] || fail "missing: $(cat out)"
run 2
run 2 a.stip b.stip
exit $((failures != 0))
