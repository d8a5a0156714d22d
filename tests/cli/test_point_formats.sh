#!/usr/bin/env bash
# Point clouds and height tiles on the command line: info for each format, named columns, axes, and
# errors. Arguments: executable, scratch folder.
set -u
stipple=$1
# shellcheck source=/dev/null
. "$(dirname "$0")/shared.sh"
rm -rf "$2"
mkdir -p "$2" && cd "$2" || exit 1
export XDG_CACHE_HOME=$PWD/cache

python3 - << 'EOF' || exit 1
import math, struct
ball = [(math.cos(i) * math.sin(i * 0.01), math.sin(i) * math.sin(i * 0.01), 5 + math.cos(i * 0.01)) for i in range(314)]
with open("ball.xyz", "w") as f:
    f.writelines("%.5f %.5f %.5f %d 0 128\n" % (*p, i % 256) for i, p in enumerate(ball))
with open("ball.csv", "w") as f:
    f.write("q;intensity;z;y;x\n")
    f.writelines("a;%d;%.5f;%.5f;%.5f\n" % (i, p[2], p[1], p[0]) for i, p in enumerate(ball))
with open("ball.pts", "w") as f:
    f.write("314\n")
    f.writelines("%.5f %.5f %.5f %d 9 9 9\n" % (*p, -i) for i, p in enumerate(ball))
with open("ball.pcd", "wb") as f:
    f.write(b"VERSION 0.7\nFIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nCOUNT 1 1 1\nWIDTH 314\nHEIGHT 1\nPOINTS 314\nDATA binary\n")
    f.write(b"".join(struct.pack("<3f", *p) for p in ball))
with open("ball.ptx", "w") as f:
    f.write("2\n157\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n1 0 0 0\n0 1 0 0\n0 0 1 0\n0 0 0 1\n")
    f.writelines("%.5f %.5f %.5f 0.5\n" % p for p in ball)
with open("N10E020.hgt", "wb") as f:
    f.write(b"".join(struct.pack(">h", (x * y) % 97) for y in range(1201) for x in range(1201)))
open("bad.xyz", "w").write("1 2 3\n4 5\n6 7 8\n")
open("bad.e57", "w").write("ASTM-E57" + "x" * 100)
EOF

# value FILE PYTHON: evaluates an expression about the JSON d of `info --json FILE`
value()
{
    "$stipple" info "$1" --json "${@:3}" 2> err | python3 -c "import json, sys; d = json.load(sys.stdin); print($2)"
}
is() # WANTED GOT WHAT
{
    [ "$1" = "$2" ] || fail "$3: $2, not $1"
}
for ending in xyz csv pts pcd ptx; do
    is "314 z $ending" "$(value ball.$ending '"%d %s %s" % (d["points"], d["up"], d["sources"][0]["format"])' |
        sed 's/csv/xyz/;s/ xyz$/ '$ending'/')" "ball.$ending"
    # the ball is above the ground: y is up in a scene
    is "True" "$(value ball.$ending 'd["bounds"]["min"][1] > 3.9 and d["bounds"]["max"][1] < 6.1')" "up of ball.$ending"
done
is "2880000 m" "$(value N10E020.hgt '"%d %s" % (d["triangles"], d["unit"])')" "heights"
is "True" "$(value ball.xyz 'd["bounds"]["min"][0] > 3.9' --columns z,y,x,r,g,b)" "named columns"

for axis in y -y z -z x -x; do
    "$stipple" -q build ball.xyz -o up.stip --up $axis 2> err || fail "--up $axis: $(cat err)"
    # the middle of the ball is at (0, 0, 5)
    middle=$("$stipple" info up.stip --json | python3 -c 'import json, sys
b = json.load(sys.stdin)["bounds"]
print(*(round((p + q) / 2) + 0 for p, q in zip(b["min"], b["max"])))')
    case $axis in
    y) is "0 0 5" "$middle" "--up y" ;;
    -y) is "0 0 -5" "$middle" "--up -y" ;;
    z) is "0 5 0" "$middle" "--up z" ;;
    -z) is "0 -5 0" "$middle" "--up -z" ;;
    *) is "0 0 5" "$middle" "--up $axis" ;;
    esac
done

"$stipple" -q render ball.xyz --size 64x64 -o a.png 2> err || fail "render: $(cat err)"
"$stipple" -q render ball.xyz --size 64x64 -o b.png --columns z,y,x,-,-,- 2> err || fail "render --columns: $(cat err)"
cmp -s a.png b.png && fail "--columns draws what the cache holds without it"
"$stipple" -q build ball.xyz -o one.stip --threads 1 && "$stipple" -q build ball.xyz -o two.stip --threads 2 &&
    cmp one.stip two.stip || fail "the number of threads changes the result"

refused 2 "x, y and z must be among" info ball.xyz --columns x,y
refused 2 "columns are x, y" build ball.xyz -o out.stip --columns x,y,z,w
refused 2 "named twice" render ball.xyz -o out.png --columns x,y,z,x
refused 2 "columns applies to text point clouds; ball.ptx is not one" info ball.ptx --columns x,y,z
refused 2 "ball.pcd is not one" build ball.pcd N10E020.hgt -o out.stip --columns x,y,z
refused 2 "one.stip is not one" render one.stip -o out.png --columns x,y,z
refused 1 "line 2" build bad.xyz -o out.stip
refused 1 "bad.e57: has version" build bad.e57 -o out.stip
refused 1 "has 6 columns, not 7" info ball.xyz --columns x,y,z,r,g,b,class
[ -e out.stip ] && fail "a refused input leaves a file"
exit $((failures > 0))
