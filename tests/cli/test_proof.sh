#!/usr/bin/env bash
# The scripts of bench/: they resume measurements, report failures, merge parts of a table, and
# update tables in documents. A script stands in for stipple. Arguments: executable, scratch folder,
# source folder.
set -u
scratch=$2
source=$3
rm -rf "$scratch"
. "$(dirname "$0")/shared.sh"
mkdir -p "$scratch" && cd "$scratch" || exit 1

cat > stipple << 'END'
#!/usr/bin/env python3
import json, os, sys
words = sys.argv[1:]
def value(name):
    return words[words.index(name) + 1]
with open(os.environ["CALLS"], "a") as calls:
    print(*words, file=calls)
if words == ["--version"]:
    print("stipple 0")
elif words[:2] == ["bench", "splats"]:
    print(json.dumps({"results": [{"name": "splats", "params": {"size_px": 1.0, "threads": t},
        "figures": {"cpu_per_second": 30e6, "gl_per_second": 1e6, "ratio": 30.0, "part_of_copy": 0.2, "part_of_random_pixels": 0.5}} for t in (1, 2)]}))
elif words[:2] == ["bench", "positions"]:
    first, count = int(value("--first")), int(value("--count"))
    if os.path.exists("stop") and first > 0:
        sys.exit("stopped")
    params = {"model": value("--model"), "place": "Overview", "metres_above_ground": 200.0, "first": first, "positions": count,
              "pictures": 4 * count, "width": 64, "height": 48, "threads": 1, "splat_size": 4.0}
    values = [float(4 * first + i) for i in range(4 * count)]
    print(json.dumps({"results": [{"name": "positions", "params": params,
        "figures": {"frame_ms": [v + 1 for v in values], "jump_ms": values, "splats": values, "triangles": values}}]}))
else:
    sys.exit("this cannot be drawn")
END
chmod +x stipple
export STIPPLE=$PWD/stipple CALLS=$PWD/calls
touch scene.stip

# proof CODE ARGUMENTS...
proof()
{
    local code=$1
    shift
    : > calls
    "$source/bench/proof" scene.stip --size 64x48 --positions 50 --work work --keep kept --references references "$@" > out 2> err
    [ $? -eq "$code" ] || fail "proof $* exits with another code than $code: $(cat err)"
}

proof 1 --list --only nothing
proof 0 --list
grep -q "| positions | " out || fail "--list lists $(cat out)"
[ ! -e work ] || fail "--list leaves something"
touch stop
proof 1 --only splats,figure7,positions
grep -q "splats .* measured" err || fail "splats: $(cat err)"
grep -q "figure7 .* FAILED: .*this cannot be drawn" err || fail "figure7: $(cat err)"
grep -q "positions .* FAILED: .*stopped" err || fail "positions: $(cat err)"
grep -q "ratio | 30 x" out || fail "the table is $(cat out)"
[ ! -e work/scratch ] || fail "leaves files"
rm stop
proof 0 --only splats,positions
grep -q "splats .* measured before" err || fail "splats are measured again: $(cat err)"
grep -q -- "--first 0" calls && fail "finished positions are repeated: $(cat calls)"
grep -q -- "--first 20" calls || fail "positions do not continue: $(cat calls)"
grep -q "| Overview | 50 | 200 | 50.0 | 100.0 |" out || fail "the pieces do not add up: $(cat out)"
touch stipple # another program
proof 0 --only positions
grep -q -- "--first 0" calls || fail "another program's positions go on: $(cat calls)"
grep -q "30 x" work/proof.md || fail "proof.md: $(cat work/proof.md)"

# one table combines the counts of one run and the times of another
python3 - << 'END' || fail "files to merge"
import json
def entry(**figures):
    return {"results": [{"name": "table3", "params": {"view": "2", "column": "1k", "options": "--splat-size 2"}, "figures": figures}]}
json.dump(entry(draw_calls=629, triangles=1460000, splats=1740000, ssim=0.987, ssim_covered=0.5), open("counts.json", "w"))
json.dump(entry(draw_calls=629, triangles=1460000, splats=1740000, frame_ms=41.0), open("times.json", "w"))
other = entry(frame_ms=1.0)
other["results"][0]["params"]["options"] = "--splat-size 1"
json.dump(other, open("other.json", "w"))
END
"$source/bench/table3.py" scene.stip --views none --merge counts.json times.json --out merged.json > out 2> err || fail "merge: $(cat err)"
grep -q "frame, ms |  | 41 (12.3)" out || fail "no times in $(cat out)"
grep -q "SSIM |  | 0.987 (0.92)" out || fail "no likeness in $(cat out)"
"$source/bench/table3.py" scene.stip --views none --merge counts.json other.json --out merged.json > out 2> err && fail "merges other sizes"

# goals, and tables into a document
printf 'before\n<!-- measured: splats -->\nold\n<!-- end -->\n<!-- measured: growth -->\nkept\n<!-- end -->\n<!-- measured: goals -->\n<!-- end -->\nafter\n' > page.md
"$source/bench/goals.py" --results kept/results --document page.md --tables work > out 2> err || fail "goals: $(cat err)"
grep -q "30.0 and 30.0 times with 1 and 2 threads | yes" out || fail "goals are $(cat out)"
grep -q "not measured" out || fail "all is measured: $(cat out)"
for word in before after kept "ratio | 30 x" "15 times"; do
    grep -q "$word" page.md || fail "the page lacks $word: $(cat page.md)"
done
grep -q "^old" page.md && fail "the page keeps its old table"
exit $((failures > 0))
