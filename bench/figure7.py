#!/usr/bin/env python3
"""Figure 7 of Brandt et al. 2019: ours, without LOD, and the SSIM of each pixel, one below the other, as docs/images/figure7.png.

usage: bench/figure7.py SCENE [--view NAME] [--splat-size PX]
"""
import pathlib
import subprocess
import tempfile

import kit


def main():
    parser = kit.options(__doc__, size="960x540")
    parser.add_argument("scene")
    parser.add_argument("--view", default="5")
    parser.add_argument("--splat-size", default="1")
    given = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        ours, truth, alike = (pathlib.Path(folder) / f"{name}.png" for name in ("ours", "truth", "alike"))
        common = ["render", given.scene, "--view", given.view, "--size", given.size, "--background", "b9d0e6"]
        drawn = kit.stipple(*common, "--splat-size", given.splat_size, "-o", ours, "--once", threads=given.threads)
        whole = kit.stipple(*common, "--reference", "-o", truth, "--once", threads=given.threads)
        figures = kit.stipple("compare", ours, truth, "--map", alike)
        sheet = given.images / "figure7.png"
        subprocess.run([kit.ROOT / "scripts/contact_sheet.py", sheet, "1", ours, truth, alike], check=True)
    kit.say(sheet)
    kit.table(["view", "splats", "triangles", "triangles without LOD", "SSIM"],
              [[given.view, kit.short(drawn["splats"]), kit.short(drawn["triangles"]), kit.short(whole["triangles"]), f"{figures['ssim']:.3f}"]])
    params = {"scene": given.scene, "view": given.view, "size": given.size, "splat_size": given.splat_size}
    kit.keep("figure7", [kit.result("figure7", params, {"ssim": figures["ssim"], "splats": drawn["splats"], "triangles": drawn["triangles"],
                                                        "triangles_without_lod": whole["triangles"]})], given.out)


main()
