#!/usr/bin/env python3
"""The main part of scripts/demo, run once stipple is built.

usage: demo.py STIPPLE FOLDER MODEL [--alone]

Builds MODEL and, without --alone (MODEL is then a GLB), a plant of 1,200 copies. Flies through it,
prints figures within the budget and of all triangles side by side, and writes FOLDER/sheet.png.
"""
import json
import math
import os
import subprocess
import sys
from pathlib import Path

BUDGET_MS = 33
SIZE = "1280x720"
FRAMES, COMPARED_EVERY, TRIANGLE_FRAMES = 121, 60, 3 # the flight's three compared frames are those of all triangles


def note(text):
    print(f"demo: {text}", file=sys.stderr, flush=True)


def run(arguments):
    """Runs stipple. Returns its JSON output and its peak memory."""
    child = subprocess.Popen(arguments, stdout=subprocess.PIPE)
    text = child.stdout.read()
    _, status, usage = os.wait4(child.pid, 0)
    if status != 0:
        sys.exit(f"demo: failed: {' '.join(map(str, arguments))}")
    return json.loads(text) if text.strip() else {}, usage.ru_maxrss * 1024


def number(value):
    for unit, name in ((1e9, " G"), (1e6, " M"), (1e4, " k")):
        if value >= unit:
            return f"{value / (1e3 if name == ' k' else unit):.3g}{name}"
    return f"{value:,.0f}"


def size_of(path):
    return f"{os.path.getsize(path) / 1e6:.1f} MB"


def build(stipple, model, out):
    figures, _ = run([stipple, "build", model, "-o", out, "--json"])
    print(f"{Path(model).name:<22} {size_of(model):>9}, {number(figures['triangles'])} triangles")
    print(f"{out.name:<22} {size_of(out):>9}, built in {figures['seconds']['total']:.1f} s: "
          f"{number(figures['unique_surfels'])} surfels, and all triangles\n", flush=True)
    return figures


def orbit(bounds):
    """A flight around a model, from far to near."""
    low, high = bounds["min"], bounds["max"]
    middle = [(a + b) / 2 for a, b in zip(low, high)]
    reach = max(math.dist(low, high) / 2, 1e-9)
    keys = []
    for step in range(9):
        angle, far = step * math.pi / 4, reach * (1.5 + 8 * (1 - step / 8) ** 2)
        eye = [middle[0] + far * math.cos(angle), middle[1] + 0.4 * far, middle[2] + far * math.sin(angle)]
        keys.append({"t": step * 1.5, "eye": eye, "target": middle, "up": [0, 1, 0]})
    return {"fov": 60, "fps": 30, "keys": keys}


def fly(stipple, scene, flight):
    shared = [stipple, "fly", scene, "--path", flight, "--size", SIZE, "--json"]
    splats, splat_bytes = run([*shared, "--frames", str(FRAMES), "--budget-ms", str(BUDGET_MS)])
    quality, _ = run([*shared, "--frames", str(FRAMES), "--budget-ms", str(BUDGET_MS), "--reference-every",
                      str(COMPARED_EVERY)])
    triangles, triangle_bytes = run([*shared, "--frames", str(TRIANGLE_FRAMES), "--reference"])
    splats["quality"] = quality["quality"]
    return {"splats": (splats, splat_bytes), "triangles": (triangles, triangle_bytes)}


def print_table(flown):
    (splats, splat_bytes), (triangles, triangle_bytes) = flown["splats"], flown["triangles"]
    ratios = sorted(q["ratio"] for q in splats["quality"])
    rows = (
        ("", f"{BUDGET_MS} ms budget", "all triangles"),
        ("frame time, median", f"{splats['frame_ms']['p50']:.1f} ms", f"{triangles['frame_ms']['p50']:,.1f} ms"),
        ("frame time, longest", f"{splats['frame_ms']['max']:.1f} ms", f"{triangles['frame_ms']['max']:,.1f} ms"),
        ("splats per frame", number(splats["splats"]["p50"]), "0"),
        ("triangles per frame", number(splats["triangles"]["p50"]), number(triangles["triangles"]["p50"])),
        ("truth", f"{ratios[len(ratios) // 2]:.3f}", "1"),
        ("memory, peak", f"{splat_bytes / 1e6:,.0f} MB", f"{triangle_bytes / 1e6:,.0f} MB"),
    )
    for row in rows:
        print("{:<22} {:>20} {:>16}".format(*row))
    print(f"\n{SIZE} on {splats['backend']} ({splats['device']}, {splats['threads']} threads); medians over the flight; "
          f"truth: SSIM to 16 samples a pixel, as a share of what all triangles reach with one, over {len(ratios)} frames\n")


def key_of(flight, part):
    """The view at a fraction (0 to 1) of the flight's keys, as options of render."""
    keys = flight["keys"]
    key = keys[round(part * (len(keys) - 1))]
    return ["--fov", str(flight["fov"]), "--eye", ",".join(map(str, key["eye"])),
            "--target", ",".join(map(str, key["target"]))]


def draw_prefixes(stipple, scene, surfels, folder):
    cells = []
    counts = sorted({min(n, surfels) for n in (1000, 10000, 100000)} - {0})
    for count in counts:
        picture = folder / f"prefix-{count}.png"
        run([stipple, "render", scene, "-o", picture, "--size", "780x520", "--background", "white", "--splats", str(count), "-q"])
        cells.append(f"{picture}=the first {count:,} splats")
    return cells


def draw_view(stipple, scene, options, name, folder):
    ours, truth, difference = (folder / f"{name}-{what}.png" for what in ("splats", "triangles", "difference"))
    shared = [stipple, "render", scene, "--size", SIZE, "--background", "white", "--json", *options]
    splats, _ = run([*shared, "-o", ours, "--budget-ms", str(BUDGET_MS)])
    triangles, _ = run([*shared, "-o", truth, "--reference"])
    alike, _ = run([stipple, "compare", ours, truth, "--difference", difference, "--json"])
    return [f"{ours}=within {BUDGET_MS} ms: {splats['frame_ms']:.0f} ms",
            f"{truth}={number(triangles['triangles'])} triangles: {triangles['frame_ms']:,.0f} ms",
            f"{difference}=difference: SSIM {alike['ssim']:.3f}"]


def main():
    if len(sys.argv) not in (4, 5) or sys.argv[4:] not in ([], ["--alone"]):
        sys.exit(__doc__)
    stipple, folder, model = Path(sys.argv[1]).resolve(), Path(sys.argv[2]).resolve(), Path(sys.argv[3])
    alone = len(sys.argv) == 5
    if not model.exists():
        sys.exit(f"demo: {model}: no such file")
    folder.mkdir(parents=True, exist_ok=True)
    note(f"converting {model.name}")
    print(flush=True)
    scene, path = folder / f"{model.stem}.stip", folder / "flight.json"
    figures = build(stipple, model, scene)
    cells = draw_prefixes(stipple, scene, figures["unique_surfels"], folder)
    title = f"{model.name}: {number(figures['triangles'])} triangles"
    if alone:
        path.write_text(json.dumps(orbit(figures["bounds"])))
    else:
        plant = folder / "plant.glb"
        subprocess.run([sys.executable, Path(__file__).parent / "make_plant.py", model, plant, path], check=True,
                       stdout=subprocess.DEVNULL)
        scene = folder / "plant.stip"
        figures = build(stipple, plant, scene)
        title += f"; a plant of 1,200 copies: {number(figures['triangles'])} triangles"
    flight = json.loads(path.read_text())
    note("flying: splats, comparisons, all triangles (the slowest part)")
    flown = fly(stipple, scene, path)
    print_table(flown)
    for what, (figures_of, _) in flown.items():
        (folder / f"fly-{what}.json").write_text(json.dumps(figures_of))
    note("drawing the contact sheet")
    cells += ["/", *draw_view(stipple, scene, key_of(flight, 0.25), "far", folder)]
    cells += ["/", *draw_view(stipple, scene, key_of(flight, 0.75), "near", folder)]
    cells += [f"{folder}/fly-splats.json=within {BUDGET_MS} ms", f"{folder}/fly-triangles.json=all triangles"]
    run([stipple, "sheet", *cells, "-o", folder / "sheet.png", "--title", title, "--columns", "3", "--width", "520"])
    print(f"contact sheet          {folder}/sheet.png\nlook around            {stipple} view {scene}")


main()
