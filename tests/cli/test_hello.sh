#!/usr/bin/env bash
# Runs every command of docs/hello.md as printed. Arguments: executable, scratch folder, source
# folder.
set -u
# shellcheck source=/dev/null
. "$(dirname "$0")/run_document.sh"
run_document docs/hello.md

# few, many and dots draw only splats, and differ from the triangles by the expected amounts
cd "$scratch/hello" || exit 1
python3 -c 'data = open("engine.ppm", "rb").read(); assert data.startswith(b"P6 640 480 255\n") and len(set(data[15:])) > 50' ||
    fail "picture.c draws nothing"
for options in "--splats 1000" "--splats 20000" "--splats 2000 --splat-scale 0.3"; do
    # shellcheck disable=SC2086
    "$stipple" render engine.stip -o figures.png --size 640x480 --once --json $options > figures.json
    [ "$(value figures.json splats)" -gt 0 ] && [ "$(value figures.json triangles)" = 0 ] || fail "$options draws triangles"
done
ssim() # PICTURE
{
    "$stipple" compare "$1" truth.png --json > ssim.json
    value ssim.json ssim
}
few=$(ssim few.png) many=$(ssim many.png) dots=$(ssim dots.png)
holds "$dots < $many && $few < $many" || fail "more splats are not more similar: $few, $many, $dots"
exit $((failures > 0))
