#!/usr/bin/env bash
# stipple-lab kernels: every SIMD kernel gives the bits of its portable variant, and every source
# file with one has a row. Arguments: executable, scratch folder, source folder.
# needs: stipple-lab
set -u
stipple=$1
scratch=$2
source=$3
rm -rf "$scratch"
. "$(dirname "$0")/shared.sh"
mkdir -p "$scratch" && cd "$scratch" || exit 1
command -v python3 > /dev/null || exit 77

"$stipple" kernels --quick --json > kernels.json 2> err || fail "kernels: $(cat err)"
python3 - "$source" << 'END_PYTHON' || fail "figures"
import json, pathlib, sys
source = pathlib.Path(sys.argv[1])
printed = json.load(open("kernels.json"))
rows = [(r["params"], r["figures"]) for r in printed["results"]]
names = ["baseline", "avx2", "avx512"]
here = names[:names.index(printed["machine"]["vectors"]) + 1]
for p, variants in rows:
    kernel = p["source"]
    written = ["baseline"] + [v for v in names[1:] if (source / f"{kernel}_{v}.c").exists()]
    assert list(variants) == [v for v in written if v in here], (p, list(variants))
    for f in variants.values():
        assert f["same_bits"] and 0 < f["ns_min"] <= f["ns"] <= f["ns_max"], (p, f)
assert len({p["kernel"] for p, _ in rows}) == len(rows)
known = {p["source"] for p, _ in rows}
for path in (source / "src").rglob("*_avx*.c"):
    name = str(path.relative_to(source)).rpartition("_avx")[0]
    assert name in known, f"{path}: no row in lab/kernels/kernels.c"
END_PYTHON

"$stipple" kernels crc32c curve-cells --quick > out || fail "two kernels"
[ "$(grep -c -e '^crc32c ' -e '^curve-cells ' out)" = 2 ] && [ "$(wc -l < out)" = 4 ] || fail "two kernels: $(cat out)"
STP_PROCESSOR=baseline "$stipple" kernels crc32c --quick --json > out || fail "portable only"
grep -q avx2 out && fail "STP_PROCESSOR is ignored: $(cat out)"
"$stipple" kernels --list | grep -q "^splats-blend *src/raster/splats_blend$" || fail "list"
refused 2 "there is no kernel nothing" kernels nothing
exit $((failures > 0))
