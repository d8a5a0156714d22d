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
vectors = printed["machine"]["vectors"]
suffixes = {"avx2": ("vector", "avx2"), "neon": ("vector", "neon"), "avx512": ("wide", "avx512")}
here = ["baseline"] + (["avx2", "avx512"] if vectors == "avx512" else [vectors] if vectors != "baseline" else [])
for p, variants in rows:
    kernel = p["source"]
    written = [v for v in here if v == "baseline" or any((source / f"{kernel}_{s}.c").exists() for s in suffixes[v])]
    assert list(variants) == written, (p, list(variants))
    for f in variants.values():
        assert f["same_bits"] and 0 < f["ns_min"] <= f["ns"] <= f["ns_max"], (p, f)
assert len({p["kernel"] for p, _ in rows}) == len(rows)
known = {p["source"] for p, _ in rows}
for path in (source / "src").rglob("*.c"):
    name, _, suffix = str(path.relative_to(source).with_suffix("")).rpartition("_")
    assert name in known or suffix not in ("vector", "wide", "avx2", "avx512", "neon"), f"{path}: no row in lab/kernels/kernels.c"
END_PYTHON

"$stipple" kernels crc32c curve-cells --quick > out || fail "two kernels"
[ "$(grep -c -e '^crc32c ' -e '^curve-cells ' out)" = 2 ] && [ "$(wc -l < out)" = 4 ] || fail "two kernels: $(cat out)"
STP_PROCESSOR=baseline "$stipple" kernels crc32c --quick --json > out || fail "portable only"
grep -qE 'avx2|neon' out && fail "STP_PROCESSOR is ignored: $(cat out)"
"$stipple" kernels --list | grep -q "^splats-blend *src/raster/splats_blend$" || fail "list"
refused 2 "there is no kernel nothing" kernels nothing
exit $((failures > 0))
