#!/usr/bin/env bash
# stipple build and stipple info: files, JSON, exit codes. Arguments: executable, scratch folder.
set -u
stipple=$1
scratch=$2
. "$(dirname "$0")/shared.sh"
mkdir -p "$scratch" && cd "$scratch" || exit 1
rm -rf ./*
# run CODE COMMAND ARGUMENTS...: stdout to out, stderr to err
run()
{
    local wanted=$1
    shift
    "$stipple" "$@" > out 2> err
    local code=$?
    [ "$code" = "$wanted" ] || fail "$*: exit $code, not $wanted: $(cat err)"
}

figure()
{
    python3 -c 'import json, sys; d = json.load(open("out")); print(eval(sys.argv[1], {"d": d}))' "$1"
}

# a ball of 48 x 48 squares, with the poles; 4,512 triangles
python3 - << 'END'
import math
n = 48
with open("ball.obj", "w") as f:
    for i in range(n + 1):
        for k in range(n):
            a, b = math.pi * i / n, 2 * math.pi * k / n
            f.write(f"v {math.sin(a) * math.cos(b):.6f} {math.cos(a):.6f} {math.sin(a) * math.sin(b):.6f}\n")
    for i in range(n):
        for k in range(n):
            a, b = i * n + k + 1, i * n + (k + 1) % n + 1
            if i > 0:
                f.write(f"f {a} {b} {a + n}\n")
            if i < n - 1:
                f.write(f"f {b} {b + n} {a + n}\n")
END

run 0 build ball.obj -o one.stip --threads 1 --json
[ ! -s err ] || fail "messages: $(cat err)"
wanted="bounds candidates file_bytes format_version instances methods nodes objects parts peak_bytes points seconds"
wanted="$wanted sources splat_bytes surfels texture_bytes threads triangle_bytes triangles unique_nodes"
wanted="$wanted unique_surfels unique_triangles unit up views"
for key in $wanted; do
    [ "$(figure "'$key' in d")" = True ] || fail "build --json lacks $key"
done
for key in import partition capture order finish write total; do
    [ "$(figure "d['seconds']['$key'] >= 0")" = True ] || fail "seconds lacks $key"
done
[ "$(figure "d['triangles'], d['surfels'], d['methods'], d['threads']")" = "(4512, 564, ['blue'], 1)" ] \
    || fail "figures: $(cat out)"
[ "$(figure "d['input_bytes'], d['triangles_alone_would_do']")" = "($(stat -c %s ball.obj), True)" ] || fail "input: $(cat out)"
[ "$(figure "d['file_bytes']")" = "$(stat -c %s one.stip)" ] || fail "file_bytes: $(cat out)"
[ "$(figure "d['splat_bytes'] / d['unique_surfels'] < 15.5")" = True ] || fail "surfels are too large: $(cat out)"

run 0 build ball.obj -o three.stip --threads 3 --memory 2G --progress none
cmp -s one.stip three.stip || fail "the file depends on threads or memory"
grep -q '^  total .* 4,512 .* 564 ' out || fail "no figures: $(cat out)"
tail -n 1 out | grep -Eq '^  bytes +[0-9.]+ KB in, [0-9.]+ KB out: [0-9.]+ KB splats, [0-9.]+ KB triangles, 0 B textures$' \
    || fail "the last line does not list the sizes: $(cat out)"
grep -q 'its 4,512 triangles suffice: --threshold 4512 leaves' out || fail "a small model: $(cat out)"
grep -q 'times the input' out && fail "too large: $(cat out)"
STP_PROCESSOR=baseline "$stipple" build ball.obj -o base.stip --quiet > out 2> err || fail "baseline: $(cat err)"
cmp -s one.stip base.stip || fail "the file depends on the processor"
[ ! -s out ] || fail "--quiet prints: $(cat out)"
run 0 build ball.obj -o random.stip --order random --seed 5 --metric euclidean --surfels 300 --surfel-ratio 0.001 --json
[ "$(figure "d['surfels']")" = 300 ] || fail "--surfels: $(cat out)"
run 0 build ball.obj -o none.stip --threshold 5000 --json
[ "$(figure "d['surfels'], d['methods']")" = "(0, [])" ] || fail "--threshold: $(cat out)"
run 0 check one.stip

run 0 info one.stip --json
[ "$(figure "d['triangles'], d['surfels'], d['format_version'], d['parts'][0]['triangles']")" = \
    "(4512, 564, 1, 4512)" ] || fail "info: $(cat out)"
[ "$(figure "'seconds' in d")" = False ] || fail "info has seconds"
run 0 info ball.obj --json
[ "$(figure "d['triangles'], d['surfels'], d['format_version'], d['sources'][0]['format']")" = \
    "(4512, 0, None, 'obj')" ] || fail "info of a model: $(cat out)"
run 0 info one.stip
grep -q '^  total .* 4,512 .* 564 ' out || fail "info: $(cat out)"

# failures: one sentence, no files left behind, existing files unchanged
cp one.stip kept.stip
printf 'glTF\002\000\000\000' > broken.glb
run 1 build broken.glb -o kept.stip
[ "$(wc -l < err)" = 1 ] || fail "not exactly one sentence: $(cat err)"
cmp -s one.stip kept.stip || fail "a failed build changed its output"
run 1 build missing.obj -o kept.stip
run 1 build ball.obj -o no/such/folder.stip
run 1 build ball.obj -o /dev/null
[ -c /dev/null ] || fail "/dev/null was replaced"
run 1 build ball.obj -o kept.stip --memory 100K
cmp -s one.stip kept.stip || fail "a build without memory changed its output"
[ -z "$(find . -name '*.tmp-*')" ] || fail "left behind: $(find . -name '*.tmp-*')"
run 1 info broken.glb
run 1 info missing.stip
run 2 build ball.obj
run 2 build -o x.stip
run 2 build ball.obj -o ball.obj
run 2 build ball.obj -o x.stip --order best
run 2 build ball.obj -o -
[ ! -e ./- ] || fail "a file named -"
run 2 build ball.obj -o x.stip --progress much
run 1 build ball.obj -o ''
run 2 info
# progress ends at 100 %
printf 'v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n' > end.obj
"$stipple" build end.obj -o end.stip --progress json > out 2> err || fail "no build with progress"
tail -n 1 err | grep -q '"overall":1.0' || fail "the last progress is $(tail -n 1 err)"

exit $((failures > 0))
