#!/usr/bin/env python3
"""Figure 7 of Brandt et al. 2019: ours, without LOD, and the SSIM of each pixel (black where they
differ), one row per view.

usage: lab/papers/figure7.py SCENE [--views NAME,NAME] [--splat-size PX] [--size WxH]

Writes figure7.png, with pictures at half size.
"""
import pathlib
import subprocess
import tempfile

import kit

BACKGROUND = ("--background", "b9d0e6")


def measure(given, view, folder):
    """The three pictures of a view, and its figures."""
    kit.say(f"view {view}")
    ours, alike = folder / f"ours-{view}.png", folder / f"alike-{view}.png"
    drawn = kit.stipple("render", given.scene, "--view", view, "--size", given.size, *BACKGROUND, "--splat-size", given.splat_size, "-o", ours,
                        "--once", threads=given.threads)
    truth, whole = kit.reference(given, view, given.size, *BACKGROUND)
    figures = kit.stipple("compare", ours, truth, "--map", alike)
    params = {"scene": given.scene, "view": view, "size": given.size, "splat_size": given.splat_size}
    return [ours, truth, alike], kit.result("figure7", params, {"ssim": figures["ssim"], "splats": drawn["splats"], "triangles": drawn["triangles"],
                                                                "triangles_without_lod": whole["triangles"]})


def main():
    parser = kit.options(__doc__, size="640x360")
    parser.add_argument("scene")
    parser.add_argument("--views", default="1,2,3,4,5")
    parser.add_argument("--splat-size", default="1")
    given = parser.parse_args()
    results, pictures = [], []
    given.images.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory() as folder:
        for view in given.views.split(","):
            shown, found = measure(given, view, pathlib.Path(folder))
            pictures += shown
            results.append(found)
        sheet = given.images / "figure7.png"
        subprocess.run([kit.ROOT / "scripts/contact_sheet.py", sheet, "3/2", *pictures], check=True)
    kit.say(sheet)
    kit.table(["view", "splats", "triangles", "triangles without LOD", "SSIM"],
              [[r["params"]["view"], *(kit.short(r["figures"][k]) for k in ("splats", "triangles", "triangles_without_lod")), f"{r['figures']['ssim']:.3f}"]
               for r in results])
    kit.keep("figure7", results, given.out)


if __name__ == "__main__":
    main()
