#!/usr/bin/env python3
"""Table 3 of Brandt et al. 2019 on scene `paper`: views 1 to 5 without LOD and with ours, at three sizes and in stereo, beside the paper's.

usage: bench/table3.py SCENE [--splat-size PX | --budget-ms MS] [--columns 1k,2.5k,4k,HMD] [--views 1,2] [--no-reference]

Prints Markdown: ours, and in brackets the paper's (a GTX 1060; frame time is 1000 / FPS). Pictures without LOD are
drawn once for each size, which takes their seconds; --no-reference leaves them out, and SSIM with them.
"""
import pathlib
import tempfile

import kit

SIZES = {"1k": "1920x1080", "2.5k": "2560x1440", "4k": "3840x2160", "HMD": "2688x1600"}
NAMES = {"1": "Overview", "2": "Pompeii", "3": "Car factory", "4": "Bakery", "5": "Power plants"}
# draw calls, triangles, surfels, FPS, quality
PAPER = {
    "1": {"no LOD": (73518, 2.12e9, 0, 1.04, 1.0), "1k": (364, 92.22e3, 4.32e6, 271.95, 0.68),
          "2.5k": (825, 1.59e6, 7.60e6, 145.93, 0.69), "4k": (5513, 1.86e6, 15.86e6, 99.51, 0.70),
          "HMD": (682, 179.45e3, 4.97e6, 171.69, None)},
    "2": {"no LOD": (56467, 1.73e9, 0, 1.31, 1.0), "1k": (9770, 11.61e6, 12.00e6, 81.02, 0.92),
          "2.5k": (12974, 15.36e6, 17.10e6, 54.49, 0.93), "4k": (19943, 25.53e6, 27.58e6, 43.57, 0.94),
          "HMD": (17359, 20.25e6, 15.55e6, 43.71, None)},
    "3": {"no LOD": (12950, 656.20e6, 0, 3.52, 1.0), "1k": (3641, 4.67e6, 6.67e6, 152.90, 0.99),
          "2.5k": (4811, 5.63e6, 11.85e6, 101.91, 0.99), "4k": (5748, 10.02e6, 21.07e6, 84.92, 0.99),
          "HMD": (6419, 7.96e6, 7.60e6, 87.92, None)},
    "4": {"no LOD": (51594, 949.09e6, 0, 2.39, 1.0), "1k": (5693, 11.18e6, 11.31e6, 70.13, 0.89),
          "2.5k": (8757, 18.17e6, 18.08e6, 44.23, 0.91), "4k": (12781, 31.21e6, 32.55e6, 32.03, 0.95),
          "HMD": (10578, 21.31e6, 15.70e6, 37.78, None)},
    "5": {"no LOD": (8610, 419.44e6, 0, 5.70, 1.0), "1k": (2360, 7.41e6, 6.49e6, 150.24, 0.99),
          "2.5k": (4195, 10.31e6, 8.64e6, 111.22, 0.99), "4k": (6477, 18.87e6, 13.00e6, 76.97, 0.99),
          "HMD": (3233, 13.40e6, 10.11e6, 83.84, None)},
}
KEPT = ("splat_size", "frame_ms", "select_ms", "draw_ms", "shade_ms", "draw_calls", "triangles", "splats", "fragments", "nodes",
        "covered_pixels")


def draw(given, view, size, png, *more):
    figures = kit.stipple("render", given.scene, "--view", view, "--size", size, "-o", png, *more, threads=given.threads)
    return {name: figures[name] for name in KEPT}


def quality_options(given):
    return ["--budget-ms", given.budget_ms] if given.budget_ms else ["--splat-size", given.splat_size]


def measure_column(given, view, column, folder):
    """Ours and, where there is time for it, no LOD at one size."""
    size, found = SIZES[column], []
    ours, truth = folder / "ours.png", folder / "truth.png"
    stereo = ["--stereo"] if column == "HMD" else []
    kit.say(f"view {view}, {column}")
    params = {"scene": given.scene, "view": view, "size": size}
    figures = draw(given, view, size, ours, *quality_options(given), *stereo)
    if not given.no_reference and not stereo:
        reference = draw(given, view, size, truth, "--reference", "--once")
        figures.update(kit.compare(ours, truth))
        found.append(kit.result("table3", {**params, "column": f"no LOD {column}"}, reference))
    found.append(kit.result("table3", {**params, "column": column, "options": " ".join(map(str, quality_options(given)))}, figures))
    return found


def cell(ours, paper):
    return ours if paper is None else f"{ours} ({paper})"


def rows_of(view, columns, by_column):
    """The five rows of a view."""
    rows = {"draw items": [], "triangles": [], "splats": [], "frame, ms": [], "SSIM": [], "SSIM, covered": []}
    for column in columns:
        ours, paper = by_column.get(column), PAPER[view][column]
        if ours is None:
            for name in rows:
                rows[name].append("")
            continue
        for name, key, i in (("draw items", "draw_calls", 0), ("triangles", "triangles", 1), ("splats", "splats", 2)):
            rows[name].append(cell(kit.short(ours[key]), kit.short(paper[i])))
        rows["frame, ms"].append(cell(f"{ours['frame_ms']:,.0f}", f"{1000 / paper[3]:.1f}"))
        whole = ours.get("ssim", 1.0 if column == "no LOD" else None)
        rows["SSIM"].append("" if whole is None else cell(f"{whole:.3f}", paper[4]))
        covered = ours.get("ssim_covered")
        rows["SSIM, covered"].append("" if covered is None else f"{covered:.3f}")
    return [[f"{view} {NAMES[view]}" if i == 0 else "", name, *cells] for i, (name, cells) in enumerate(rows.items())]


def main():
    parser = kit.options(__doc__)
    parser.add_argument("scene")
    parser.add_argument("--splat-size", default="1")
    parser.add_argument("--budget-ms", default=None)
    parser.add_argument("--columns", default="1k,2.5k,4k,HMD")
    parser.add_argument("--views", default="1,2,3,4,5")
    parser.add_argument("--no-reference", action="store_true")
    given = parser.parse_args()
    columns = [c for c in given.columns.split(",") if c != "HMD" or kit.knows("render", "stereo")]
    results, rows = [], []
    with tempfile.TemporaryDirectory() as folder:
        for view in given.views.split(","):
            for column in columns:
                results += measure_column(given, view, column, pathlib.Path(folder))
            by_column = {r["params"]["column"]: r["figures"] for r in results if r["params"]["view"] == view}
            by_column["no LOD"] = by_column.get(f"no LOD {columns[0]}")
            rows += rows_of(view, ["no LOD", *columns], by_column)
    kit.table(["view", "", "no LOD", *columns], rows)
    kit.keep("table3" if not given.budget_ms else "table3-budget", results, given.out)


main()
