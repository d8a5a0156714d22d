#!/usr/bin/env python3
"""Compares methods: quality and time of pictures, by splat size, on the views of several scenes.

usage: bench/methods.py [--methods blue,spt] [--sizes 1,2,4,8,16 | --counts N,N...] [--repeats N]
                        [--warm] SCENE...

SCENE is a .stip with both methods, or a model or named scene, which is built with both. Each view
of a scene (iso if it has none) is drawn at each size by each method and compared with its
reference. Times are minima over the repeats. Prints a table at sizes 2 and 8; writes methods.svg,
quality over time.

With --counts, each view is drawn with that many splats instead (`render --splats N`; an upper limit
for spt), and without triangles. The method auto is the default without --method: blue, and psp
where few splats suffice. With --warm, times are medians of repeated frames, as in a flight.
"""
import pathlib
import subprocess
import tempfile

import kit

PANEL_WIDTH, PANEL_HEIGHT, GAP, TOP = 250, 150, 46, 66


def build(given, scene, folder):
    if str(scene).endswith(".stip"):
        return pathlib.Path(scene)
    out = folder / (pathlib.Path(str(scene).replace(":", "-").replace(",", "-").replace("/", "-")).stem + ".stip")
    kit.say(f"{scene} ...")
    built = given.methods.replace("auto", "psp")
    subprocess.run([kit.STIPPLE, "build", scene, "-o", out, "--method", built, "--progress", "none"], check=True,
                   stdout=subprocess.DEVNULL)
    return out


def measure(given, stored, view, quality, method, truth, picture):
    """SSIM and figures of one picture. `quality`: an option and its value."""
    asked = () if method == "auto" else ("--method", method)
    call = ("render", stored, "-o", picture, "--view", view, "--size", given.size, *quality, *asked, *(() if given.warm else ("--once",)))
    frames = [kit.stipple(*call, threads=given.threads) for _ in range(given.repeats)]
    best = min(frames, key=lambda frame: frame["frame_ms"])
    likeness = kit.compare(picture, truth)
    return {"ssim": likeness["ssim"], "ssim_covered": likeness["ssim_covered"], "frame_ms": best["frame_ms"], "splats": best["splats"],
            "triangles": best["triangles"]}


def compare_counts(given, told, stored, view, folder):
    """Both methods at equal numbers of splats; the picture goes to `folder`."""
    results = []
    for count in map(int, given.counts.split(",")):
        pair = [measure(given, stored, view, ("--splats", count), method, folder / "truth.png", folder / "ours.png") for method in given.methods.split(",")]
        results.append(kit.result("methods-counts", {"scene": told, "view": view, "size": given.size, "splats": count},
                                  {key: [figures[key] for figures in pair] for key in pair[0]}))
    return results


def plot(results, methods, path):
    panels = sorted({(r["params"]["scene"], r["params"]["view"]) for r in results})
    columns = 3
    rows = -(-len(panels) // columns)
    drawing = kit.Drawing(columns * (PANEL_WIDTH + GAP) + 30, TOP + rows * (PANEL_HEIGHT + 70))
    drawing.text(40, 22, "likeness (SSIM of covered pixels) over the time of a frame, by splat size", more='font-weight="bold"')
    for i, method in enumerate(methods):
        drawing.line([(40 + 90 * i, 40), (60 + 90 * i, 40)], kit.COLORS[i], 2)
        drawing.text(66 + 90 * i, 44, method)
    for k, panel in enumerate(panels):
        mine = [r for r in results if (r["params"]["scene"], r["params"]["view"]) == panel]
        most = max(r["figures"]["frame_ms"] for r in mine)
        left, top = 40 + k % columns * (PANEL_WIDTH + GAP), TOP + k // columns * (PANEL_HEIGHT + 70) + 20
        drawing.text(left, top - 8, f"{panel[0]}, {panel[1]}")
        for i in range(3):
            y = top + PANEL_HEIGHT * i / 2
            drawing.line([(left, y), (left + PANEL_WIDTH, y)], "#ddd")
            drawing.text(left - 6, y + 4, f"{1 - i / 2:.1f}", "end")
        drawing.text(left, top + PANEL_HEIGHT + 16, "0")
        drawing.text(left + PANEL_WIDTH, top + PANEL_HEIGHT + 16, f"{most:.0f} ms", "end")
        for i, method in enumerate(methods):
            points = [(left + PANEL_WIDTH * r["figures"]["frame_ms"] / most,
                       top + PANEL_HEIGHT * (1 - max(0.0, r["figures"]["ssim_covered"]))) for r in mine if r["params"]["method"] == method]
            drawing.line(points, kit.COLORS[i], 2)
            for x, y in points:
                drawing.put(f'<circle cx="{x:.1f}" cy="{y:.1f}" r="2.5" fill="{kit.COLORS[i]}"/>')
    drawing.write(path)


def main():
    parser = kit.options(__doc__, size="1280x720")
    parser.add_argument("scenes", nargs="+", metavar="SCENE")
    parser.add_argument("--methods", default="blue,spt", help="two of them")
    parser.add_argument("--sizes", default="1,2,4,8,16")
    parser.add_argument("--counts", help="compare at equal numbers of splats instead, as 10000,100000")
    parser.add_argument("--repeats", type=int, default=5)
    parser.add_argument("--warm", action="store_true", help="medians of repeated frames")
    given = parser.parse_args()
    methods = given.methods.split(",")
    first, second = methods
    results, rows, counted = [], [], []
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        for scene in given.scenes:
            stored = build(given, scene, folder)
            told = kit.name_of(scene).removesuffix(".stip")
            for view in kit.stipple("info", stored)["views"] or ["iso"]:
                truth = folder / "truth.png"
                kit.stipple("render", stored, "-o", truth, "--view", view, "--size", given.size, "--reference", "--once",
                            threads=given.threads)
                if given.counts:
                    counted += compare_counts(given, told, stored, view, folder)
                    continue
                for size in given.sizes.split(","):
                    pair = [measure(given, stored, view, ("--splat-size", size), method, truth, folder / "ours.png") for method in methods]
                    for method, figures in zip(methods, pair):
                        results.append(kit.result("methods", {"scene": told, "view": view, "size": given.size, "splat_size": float(size),
                                                              "method": method}, figures))
                    if float(size) in (2, 8) or given.warm:
                        rows.append([told, view, size, *(f"{f['ssim_covered']:.3f}" for f in pair), *(f"{f['frame_ms']:.0f}" for f in pair),
                                     *(f"{f['splats']:,}" for f in pair), *(f"{f['triangles']:,}" for f in pair)])
                kit.say(f"{told} {view}")
    if given.counts:
        kit.table(["scene", "view", "splats", f"SSIM {first}", f"SSIM {second}", f"ms {first}", f"ms {second}", f"splats of {second}"],
                  [[r["params"]["scene"], r["params"]["view"], f"{r['params']['splats']:,}", *(f"{x:.3f}" for x in r["figures"]["ssim_covered"]),
                    *(f"{x:.1f}" for x in r["figures"]["frame_ms"]), f"{r['figures']['splats'][1]:,}"] for r in counted])
        kit.keep("methods-counts" if methods == ["blue", "spt"] else f"methods-counts-{second}", counted, given.out)
        return
    kit.table(["scene", "view", "px", *(f"{what} {method}" for what in ("SSIM", "ms", "splats", "triangles") for method in methods)], rows)
    kit.keep("methods" if methods == ["blue", "spt"] else f"methods-{second}", results, given.out)
    plot(results, methods, given.images / ("methods.svg" if methods == ["blue", "spt"] else f"methods-{second}.svg"))


if __name__ == "__main__":
    main()
