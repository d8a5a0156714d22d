#!/usr/bin/env python3
"""Each view within a time budget: ours, and the paper's policy and orders with the same time. Prints
frame times, and SSIM against the original triangles.

usage: bench/budget_views.py SCENE PAPER_SCENE [TEXT_SCENE] [--budget-ms MS] [--views 1,2]

SCENE is built as usual, PAPER_SCENE from the same input with --order paper-fast, TEXT_SCENE with
--order paper-text. Ours gets the budget; if it takes longer with splats of 8 pixels, the paper's get
that longer time. A scene that is - is not measured.
"""
import pathlib
import tempfile

import kit


def draw(given, file, view, png, budget, *more):
    figures = kit.stipple("render", file, "--view", view, "--size", given.size, "-o", png, "--budget-ms", f"{budget:.2f}", *more,
                          threads=given.threads)
    return {name: figures[name] for name in ("frame_ms", "select_ms", "draw_ms", "shade_ms", "splat_size", "splats", "triangles", "draw_calls")}


def measure(given, view, folder):
    truth = folder / "truth.png"
    kit.stipple("render", given.scene, "--view", view, "--size", given.size, "-o", truth, "--reference", "--once", threads=given.threads)
    found = []
    budget = given.budget_ms
    for name, file, more in (("ours", given.scene, ()), ("paper-fast", given.paper_scene, ("--policy", "paper")),
                             ("paper-text", given.text_scene, ("--policy", "paper"))):
        if file == "-":
            continue
        kit.say(f"view {view}, {name}, {budget:.1f} ms")
        png = folder / f"{name}.png"
        figures = draw(given, file, view, png, budget, *more)
        figures.update(kit.compare(png, truth))
        params = {"scene": file, "view": view, "size": given.size, "policy": name, "budget_ms": budget}
        found.append(kit.result("budget_views", params, figures))
        if name == "ours":
            budget = max(budget, figures["frame_ms"])
    return found


def main():
    parser = kit.options(__doc__)
    parser.add_argument("scene")
    parser.add_argument("paper_scene")
    parser.add_argument("text_scene", nargs="?", default="-")
    parser.add_argument("--budget-ms", type=float, default=33.0)
    parser.add_argument("--views", default="1,2,3,4,5")
    given = parser.parse_args()
    results = []
    with tempfile.TemporaryDirectory() as folder:
        for view in given.views.split(","):
            results += measure(given, view, pathlib.Path(folder))
    rows = []
    for r in results:
        p, f = r["params"], r["figures"]
        rows.append([p["view"], p["policy"], f"{p['budget_ms']:.0f}", *(f"{f[n]:.1f}" for n in ("frame_ms", "select_ms", "draw_ms", "shade_ms")),
                     f"{f['splat_size']:.2f}", kit.short(f["splats"]), kit.short(f["triangles"]), f"{f['ssim']:.4f}", f"{f['ssim_covered']:.4f}"])
    kit.table(["view", "policy", "budget, ms", "frame", "select", "draw", "shade", "size", "splats", "triangles", "SSIM", "covered"], rows)
    kit.keep("budget-views", results, given.out)


main()
