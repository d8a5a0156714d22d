#!/usr/bin/env bash
# Few splats are ellipses, unless a method is requested: in files of blue and psp for all nodes that
# need few, in files of blue for uppermost nodes. Arguments: executable, scratch folder, source folder.
# needs: stipple-lab
set -u
stipple=$1
# shellcheck source=/dev/null
. "$(dirname "$0")/shared.sh"
mkdir -p "$2" && cd "$2" || exit 1
rm -rf ./*

draw() # NAME FILE OPTIONS...
{
    local name=$1 file=$2
    shift 2
    "$stipple" render "$file" -o "$name.png" --size 320x240 --view overview --once --json "$@" > "$name.json" 2> err ||
        fail "render $file $*: $(cat err)"
}
likeness() # A B: SSIM of covered pixels
{
    "$stipple" compare "$1.png" "$2.png" --json > compare.json || fail "compare $1 $2"
    value compare.json ssim_covered
}

scene=scene:power-plant,scale=0.02
"$stipple" -q build $scene -o both.stip --method blue,psp --levels off || fail "no build of blue and psp"
"$stipple" -q build $scene -o turned.stip --method psp,blue --levels off || fail "no build of psp and blue"
draw truth both.stip --reference

for size in 8; do
    draw mixed both.stip --splat-size $size --backend cpu
    draw blue both.stip --splat-size $size --backend cpu --method blue
    draw psp both.stip --splat-size $size --backend cpu --method psp
    [ "$(value mixed.json method) $(value mixed.json coarse_method)" = "blue psp" ] ||
        fail "drawn by $(value mixed.json method) and $(value mixed.json coarse_method)"
    for one in blue psp; do
        [ "$(value $one.json coarse_method)" = null ] || fail "$one is drawn with another method"
        cmp -s mixed.png $one.png && fail "the default draws the same as $one"
    done
    a=$(likeness mixed truth) b=$(likeness blue truth)
    holds "$a >= $b" || fail "ellipses make the picture less alike: $a, $b"
    draw threads both.stip --splat-size $size --backend cpu --threads 3
    cmp -s mixed.png threads.png || fail "three threads draw a different picture"
    draw streamed both.stip --splat-size $size --backend cpu --memory 64M
    cmp -s mixed.png streamed.png || fail "with a memory limit the picture differs"
    draw gl both.stip --splat-size $size --backend gl
    a=$(likeness mixed gl)
    holds "$a >= 0.99" || fail "OpenGL draws another picture: $a"
done

# with other options, the first method draws alone
draw by_policy both.stip --splat-size 6 --policy paper
draw first both.stip --splat-size 6 --prefix 40%
draw turned turned.stip --splat-size 6
for one in by_policy turned truth; do
    [ "$(value $one.json coarse_method)" = null ] || fail "$one is drawn with another method"
done
[ "$(value turned.json method)" = psp ] || fail "the first method is $(value turned.json method)"

# a count of splats takes ellipses of both kinds of files; a file of blue alone has some of its
# uppermost sets, and does not list them
"$stipple" -q build $scene -o blue.stip --levels off || fail "no build of blue"
"$stipple" info blue.stip --json > info.json || fail "no information on blue.stip"
python3 -c 'import json, sys; sys.exit(json.load(open("info.json"))["methods"] != ["blue"])' ||
    fail "a file of blue lists other methods"
"$stipple" check blue.stip > checked 2>&1 || fail "a file with coarse ellipses: $(cat checked)"
for file in both blue; do
    draw counted $file.stip --splats 60 --backend cpu
    draw counted_blue $file.stip --splats 60 --backend cpu --method blue
    a=$(likeness counted truth) b=$(likeness counted_blue truth)
    holds "$a > $b + 0.02" || fail "$file: 60 ellipses are not more alike than 60 disks: $a, $b"
    draw streamed $file.stip --splats 60 --backend cpu --memory 64M
    cmp -s counted.png streamed.png || fail "$file: with a memory limit, 60 splats differ"
    draw gl $file.stip --splats 60 --backend gl
    a=$(likeness counted gl)
    holds "$a >= 0.98" || fail "$file: OpenGL draws 60 splats otherwise: $a"
done
draw many blue.stip --splats 20000 --backend cpu
draw many_blue blue.stip --splats 20000 --backend cpu --method blue
cmp -s many.png many_blue.png || fail "many splats are not drawn as disks"
[ "$(value many.json coarse_method)" = null ] || fail "a method that nobody can choose is reported"
[ $failures -eq 0 ]
