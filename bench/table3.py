#!/usr/bin/env python3
"""Table 3 of Brandt et al. 2019 on scene `paper`: views 1 to 5 without LOD and with ours, at three
sizes and in stereo, beside the paper's.

usage: bench/table3.py SCENE [--splat-size PX | --budget-ms MS] [--counts-only | --times-only]
                       [--merge FILE.json...] [--columns 1k,2.5k,4k,HMD] [--views 1,2]
                       [--references FOLDER] [--no-reference]

Prints Markdown: ours, and the paper's in brackets (a GTX 1060; frame time is 1000 / FPS).
--counts-only needs no idle machine: counts, and SSIM against pictures without LOD, which are drawn
once and cached in --references. --times-only measures the rest and adds it to the files of --merge.
Without either, both are measured. With --merge and --views none, it only prints.
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
COUNTS = ("splat_size", "draw_calls", "triangles", "splats", "fragments", "nodes", "covered_pixels")
TIMES = ("frame_ms", "select_ms", "draw_ms", "shade_ms")
WHOLE = "no LOD"


def quality_options(given):
    return ["--budget-ms", given.budget_ms] if given.budget_ms else ["--splat-size", given.splat_size]


def draw(given, view, column, png, *more):
    """A picture and its requested figures: times are medians of several frames."""
    stereo = ["--stereo"] if column == "HMD" else []
    figures = kit.stipple("render", given.scene, "--view", view, "--size", SIZES[column], "-o", png, *more, *stereo,
                          *(["--once"] if given.counts_only else []), threads=given.threads)
    return {name: figures[name] for name in (*COUNTS, *(() if given.counts_only else TIMES))}


def measure_ours(given, view, column, folder):
    kit.say(f"view {view}, {column}")
    ours = folder / "ours.png"
    figures = draw(given, view, column, ours, *quality_options(given))
    if not given.times_only and not given.no_reference:
        truth, _ = kit.reference(given, view, SIZES[column], stereo=column == "HMD")
        figures.update(kit.compare(ours, truth))
    return figures


def measure_whole(given, view, column, folder):
    """Without LOD. Its counts are known if its picture is cached."""
    kit.say(f"view {view}, no LOD")
    if given.counts_only:
        _, figures = kit.reference(given, view, SIZES[column])
        return {name: figures[name] for name in COUNTS}
    return draw(given, view, column, folder / "whole.png", "--reference")


def measure(given, columns):
    found = []
    with tempfile.TemporaryDirectory() as folder:
        for view in [] if given.views == "none" else given.views.split(","):
            params = {"scene": given.scene, "view": view}
            if not given.no_reference:
                found.append(kit.result("table3", {**params, "column": WHOLE, "size": SIZES[columns[0]]},
                                        measure_whole(given, view, columns[0], pathlib.Path(folder))))
            for column in columns:
                params.update({"column": column, "size": SIZES[column], "options": " ".join(map(str, quality_options(given)))})
                found.append(kit.result("table3", dict(params), measure_ours(given, view, column, pathlib.Path(folder))))
    return found


def merge(lists):
    """One result per view and column; the last one wins if several have the same figure."""
    by_place = {}
    for r in (r for results in lists for r in results):
        place = (r["params"]["view"], r["params"]["column"])
        if place in by_place:
            old = by_place[place]
            if old["params"].get("options") != r["params"].get("options"):
                raise SystemExit(f"view {place[0]}, {place[1]}: {old['params'].get('options')} and {r['params'].get('options')} cannot be merged")
            old["figures"].update(r["figures"])
        else:
            by_place[place] = r
    return [by_place[place] for place in sorted(by_place, key=lambda p: (p[0], [WHOLE, *SIZES].index(p[1])))]


def cell(ours, paper):
    return ours if paper is None else f"{ours} ({paper})"


def rows_of(view, columns, by_column):
    """The rows of a view."""
    rows = {"draw items": [], "triangles": [], "splats": [], "frame, ms": [], "SSIM": [], "SSIM, covered": []}
    for column in columns:
        ours, paper = by_column.get(column), PAPER[view][column]
        if ours is None:
            for cells in rows.values():
                cells.append("")
            continue
        for name, key, i in (("draw items", "draw_calls", 0), ("triangles", "triangles", 1), ("splats", "splats", 2)):
            rows[name].append(cell(kit.short(ours[key]), kit.short(paper[i])))
        rows["frame, ms"].append(cell(f"{ours['frame_ms']:,.0f}", f"{1000 / paper[3]:,.1f}") if "frame_ms" in ours else "")
        whole = ours.get("ssim", 1.0 if column == WHOLE else None)
        rows["SSIM"].append("" if whole is None else cell(f"{whole:.3f}", paper[4]))
        covered = ours.get("ssim_covered")
        rows["SSIM, covered"].append("" if covered is None else f"{covered:.3f}")
    return [[f"{view} {NAMES[view]}" if i == 0 else "", name, *cells] for i, (name, cells) in enumerate(rows.items())]


def main():
    parser = kit.options(__doc__)
    parser.add_argument("scene")
    parser.add_argument("--splat-size", default="2", help="default 2: about as many splats as the paper's")
    parser.add_argument("--budget-ms", default=None)
    parser.add_argument("--columns", default=",".join(SIZES))
    parser.add_argument("--views", default="1,2,3,4,5")
    parser.add_argument("--counts-only", action="store_true")
    parser.add_argument("--times-only", action="store_true")
    parser.add_argument("--merge", nargs="+", default=[], metavar="FILE.json", help="earlier results")
    parser.add_argument("--no-reference", action="store_true", help="no column without LOD, and no SSIM")
    given = parser.parse_args()
    columns = given.columns.split(",")
    results = merge([*map(kit.read_results, given.merge), measure(given, columns)])
    rows = []
    for view in sorted({r["params"]["view"] for r in results}):
        rows += rows_of(view, [WHOLE, *columns], {r["params"]["column"]: r["figures"] for r in results if r["params"]["view"] == view})
    kit.table(["view", "", WHOLE, *columns], rows)
    kit.keep(f"table3-budget-{given.budget_ms}" if given.budget_ms else f"table3-size-{given.splat_size}", results, given.out)


if __name__ == "__main__":
    main()
