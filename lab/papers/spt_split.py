#!/usr/bin/env python3
"""Point trees with unified and with split errors, in files: splats drawn, instructions of a frame, and likeness to
triangles (Dachsbacher et al. 2003, 3.7).

    lab/papers/spt_split.py MODEL... [--sizes-away D,D,...] [--size WxH] [--out FILE.json]

Builds each model twice, and renders it from two directions per distance at one pixel of error. Instructions are those
of drawing the first one on one thread, counted by valgrind; without it they are left out.
"""
import math
import pathlib
import re
import shutil
import subprocess
import tempfile

import kit

KINDS = ("unified", "split")
DIRECTIONS = ((0.6, 0.36, 0.72), (-0.8, 0.0, 0.6))


def build(model, kind, folder):
    path = folder / f"{kind}.stip"
    kit.stipple("build", model, "-o", path, "--method", "spt", "--error", kind, "--surfel-ratio", 1, "--levels", "off")
    return path


def view_of(bounds, direction, away):
    center = [0.5 * (a + b) for a, b in zip(bounds["min"], bounds["max"])]
    distance = away * math.dist(bounds["min"], bounds["max"])
    eye = [c + d * distance for c, d in zip(center, direction)]
    return ["--eye", ",".join(map(repr, eye)), "--target", ",".join(map(repr, center))]


def count_instructions(arguments, folder):
    """Instructions of drawing a frame on one thread; None without valgrind."""
    if shutil.which("valgrind") is None:
        return None
    call = ["valgrind", "--tool=callgrind", "--toggle-collect=stp_renderer_draw_selected", f"--callgrind-out-file={folder}/calls",
            str(kit.STIPPLE), *map(str, arguments), "--backend", "cpu", "--threads", "1", "--quiet"]
    found = re.search(r"Collected : (\d+)", subprocess.run(call, capture_output=True, text=True, check=True).stderr)
    return int(found[1]) if found else None


def measure(model, sizes_away, size, folder):
    rows = []
    files = {kind: build(model, kind, folder) for kind in KINDS}
    bounds = kit.stipple("info", files["unified"])["bounds"]
    for away in sizes_away:
        figures = {f"bytes_{kind}": path.stat().st_size for kind, path in files.items()}
        for direction in DIRECTIONS:
            view = [*view_of(bounds, direction, away), "--size", size, "--once"]
            kit.stipple("render", model, "-o", folder / "truth.png", "--reference", *view)
            for kind, path in files.items():
                call = ["render", path, "-o", folder / "ours.png", "--splat-size", 1, "--hybrid", "off", *view]
                drawn = kit.stipple(*call)
                likeness = kit.compare(folder / "ours.png", folder / "truth.png")
                means = {"splats": drawn["splats"], "triangles": drawn["triangles"], "ssim": likeness["ssim_covered"]}
                for name, value in means.items():
                    figures[f"{name}_{kind}"] = figures.get(f"{name}_{kind}", 0) + value / len(DIRECTIONS)
                if direction == DIRECTIONS[0]:
                    figures[f"instructions_{kind}"] = count_instructions(call, folder)
        rows.append(kit.result("spt split", {"model": pathlib.Path(model).stem, "sizes_away": away, "size": size}, figures))
    return rows


def show(results):
    rows = []
    for r in results:
        f = r["figures"]
        cells = [r["params"]["model"], f"{r['params']['sizes_away']:g}"]
        for name, form in (("splats", "{:,.0f}"), ("instructions", "{:,.0f}"), ("ssim", "{:.4f}")):
            cells += [form.format(f[f"{name}_{kind}"]) if f[f"{name}_{kind}"] is not None else "-" for kind in KINDS]
        rows.append(cells)
    kit.table(["model", "sizes away", "splats", "split", "instructions", "split", "SSIM", "split"], rows)


def main():
    parser = kit.options(__doc__, size="1280x720")
    parser.add_argument("models", nargs="+")
    parser.add_argument("--sizes-away", default="1.5,3,6", help="default 1.5,3,6")
    given = parser.parse_args()
    results = []
    for model in given.models:
        kit.say(f"{model} ...")
        with tempfile.TemporaryDirectory() as folder:
            results += measure(model, [float(d) for d in given.sizes_away.split(",")], given.size, pathlib.Path(folder))
    show(results)
    kit.keep("spt-split", results, given.out)


if __name__ == "__main__":
    main()
