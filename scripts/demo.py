#!/usr/bin/env python3
"""The main part of scripts/demo, run once stipple is built.

usage: demo.py STIPPLE FOLDER MODEL [--alone]

Builds MODEL and, without --alone (MODEL is then a GLB), a plant of 1,200 copies. Flies through it,
prints figures within the budget and of all triangles side by side, and writes FOLDER/sheet.png, with
the exact triangles that the budget allows beside them.
"""
import json
import math
import os
import shutil
import subprocess
import sys
from pathlib import Path

BUDGET_MS = 33
SIZE = "1280x720"
DISTANCE_STEPS = 7 # to within 7 % of the distance
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
    filtered = sorted(q["truth"] / q["exact_filtered"] for q in splats["quality"])
    rows = (
        ("", f"{BUDGET_MS} ms budget", "all triangles"),
        ("frame time, median", f"{splats['frame_ms']['p50']:.1f} ms", f"{triangles['frame_ms']['p50']:,.1f} ms"),
        ("frame time, longest", f"{splats['frame_ms']['max']:.1f} ms", f"{triangles['frame_ms']['max']:,.1f} ms"),
        ("splats per frame", number(splats["splats"]["p50"]), "0"),
        ("triangles per frame", number(splats["triangles"]["p50"]), number(triangles["triangles"]["p50"])),
        ("truth", f"{ratios[len(ratios) // 2]:.3f}", "1"),
        ("truth, both filtered", f"{filtered[len(filtered) // 2]:.3f}", "1"),
        ("memory, peak", f"{splat_bytes / 1e6:,.0f} MB", f"{triangle_bytes / 1e6:,.0f} MB"),
    )
    for row in rows:
        print("{:<22} {:>20} {:>16}".format(*row))
    print(f"\n{SIZE} on {splats['backend']} ({splats['device']}, {splats['threads']} threads); medians over the flight; "
          f"truth: SSIM to 16 samples a pixel, as a share of what all triangles reach with one, over {len(ratios)} frames;\n"
          "both filtered: as a share of what all triangles reach after the filter that the budget's frames pass\n")


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


def draw_nearest(draw, picture, eye, reach, limit_ms):
    """Draws exact triangles up to the distance from the eye at which a frame takes limit_ms: what a viewer shows that
    holds its frame rate by a draw distance. Returns the figures of the picture."""
    trial = picture.with_suffix(".trial.png")

    def draw_within(distance):
        box = ",".join(f"{x + side * distance:.9g}" for side in (-1, 1) for x in eye)
        return draw(trial, "--reference", "--caps", "off", f"--section-box={box}")

    low, high = reach / 2048, 4 * reach
    best = draw_within(low)
    trial.replace(picture)
    for _ in range(DISTANCE_STEPS):
        middle = math.sqrt(low * high)
        figures = draw_within(middle)
        if limit_ms < figures["frame_ms"] < 2 * limit_ms:
            figures = draw_within(middle) # once more: the machine may have been busy
        if figures["frame_ms"] <= limit_ms:
            low, best = middle, figures
            trial.replace(picture)
        else:
            high = middle
    trial.unlink(missing_ok=True)
    return best


def draw_view(stipple, scene, key, reach, name, folder):
    """A view within the budget, its nearest triangles in the same time, and all of them. Returns the cells of the sheet
    and a row of figures."""
    ours, near, truth = (folder / f"{name}-{what}.png" for what in ("splats", "nearest", "triangles"))

    def draw(picture, *options):
        return run([stipple, "render", scene, "--size", SIZE, "--json", "-q", *key, "-o", picture, *options])[0]

    splats = draw(ours, "--budget-ms", str(BUDGET_MS))
    triangles = draw(truth, "--reference")
    limit_ms = max(splats["frame_ms"], BUDGET_MS)
    if triangles["frame_ms"] <= limit_ms:
        nearest = triangles
        shutil.copy(truth, near)
    else:
        eye = [float(x) for x in key[key.index("--eye") + 1].split(",")]
        nearest = draw_nearest(draw, near, eye, reach, limit_ms)
    alike = [run([stipple, "compare", picture, truth, "--json"])[0]["ssim_covered"] for picture in (ours, near)]
    cells = [f"{ours}=within {BUDGET_MS} ms: {splats['frame_ms']:.0f} ms, SSIM {alike[0]:.2f}",
             f"{near}=nearest {number(nearest['triangles'])} triangles: {nearest['frame_ms']:.0f} ms, SSIM {alike[1]:.2f}",
             f"{truth}=all {number(triangles['triangles'])} triangles: {triangles['frame_ms']:,.0f} ms"]
    figures = [f"{of['frame_ms']:,.0f} ms, SSIM {ssim:.2f}" for of, ssim in zip((splats, nearest), alike)]
    return cells, (name, *figures, f"{triangles['frame_ms']:,.0f} ms")


def draw_views(stipple, scene, flight, bounds, folder):
    reach = math.dist(bounds["min"], bounds["max"])
    cells, rows = [], [("view", f"{BUDGET_MS} ms budget", "nearest triangles", "all triangles")]
    for name, part in (("far", 0.25), ("near", 0.75), ("beside", 1)):
        drawn, row = draw_view(stipple, scene, key_of(flight, part), reach, name, folder)
        cells += ["/", *drawn]
        rows.append(row)
    for row in rows:
        print("{:<12} {:>20} {:>20} {:>16}".format(*row))
    print("\nnearest triangles: exact ones, up to the distance that the time of the budget's frame allows\n")
    return cells


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
    cells += draw_views(stipple, scene, flight, figures["bounds"], folder)
    cells += [f"{folder}/fly-splats.json=within {BUDGET_MS} ms", f"{folder}/fly-triangles.json=all triangles"]
    run([stipple, "sheet", *cells, "-o", folder / "sheet.png", "--title", title, "--columns", "3", "--width", "520"])
    print(f"contact sheet          {folder}/sheet.png\nlook around            {stipple} view {scene}")


if __name__ == "__main__":
    main()
