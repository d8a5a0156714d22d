#!/usr/bin/env bash
# A file of blue and psp: nodes that need few splats are drawn by ellipses, unless a method is
# requested. Arguments: executable, scratch folder, source folder.
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
draw counted both.stip --splats 500 --backend cpu
draw counted_blue both.stip --splats 500 --backend cpu --method blue
cmp -s counted.png counted_blue.png || fail "a splat count does not use the first method"
draw first both.stip --splat-size 6 --prefix 40%
draw turned turned.stip --splat-size 6
for one in by_policy counted turned truth; do
    [ "$(value $one.json coarse_method)" = null ] || fail "$one is drawn with another method"
done
[ "$(value turned.json method)" = psp ] || fail "the first method is $(value turned.json method)"
[ $failures -eq 0 ]
