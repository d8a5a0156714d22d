#!/usr/bin/env python3
"""Runs `stipple bench quality` on every model below the given paths and writes one table, with a
row per model, series and splat size.

usage: bench/quality.py [--size WxH] OUT.csv PATH...

With OUT.md instead, a row per model: for each splat size the holes per 10,000 interior pixels, the
covered area relative to the reference, and the wrong depths per 1,000 pixels, from 26 directions.
"""
import csv
import json
import pathlib
import subprocess
import sys

ROOT = pathlib.Path(__file__).resolve().parent.parent
STIPPLE = ROOT / "build/release/lab/stipple-lab"
ENDINGS = {".glb", ".gltf", ".obj", ".stl", ".ply", ".laz", ".las", ".hgt", ".stip"}
COLUMNS = ["model", "series", "splat_size", "pictures", "covered_pixels", "interior_pixels", "splats", "triangles", "ssim",
           "ssim_covered", "ssim_covered_least", "interior_holes_per_10k", "interior_holes_per_10k_most", "area_ratio",
           "area_ratio_least", "area_ratio_most", "wrong_depth_per_1k", "holes_per_10k", "wrong_depth_per_10k", "extra_per_10k",
           "worst_direction"]


def models(paths):
    for path in map(pathlib.Path, paths):
        yield from sorted(p for p in path.rglob("*") if p.suffix in ENDINGS) if path.is_dir() else [path]


def measure(model, more):
    """The results of one model, or None."""
    run = subprocess.run([STIPPLE, "bench", "quality", "--model", model, "--json", *more], capture_output=True, text=True)
    if run.returncode != 0:
        print(f"{model}: {run.stderr.strip().splitlines()[-1]}", file=sys.stderr)
        return None
    return json.loads(run.stdout)["results"]


def write_csv(file, measured):
    table = csv.DictWriter(file, COLUMNS, extrasaction="ignore")
    table.writeheader()
    for model, results in measured:
        for result in results:
            row = {**result["params"], **result["figures"], "model": model.name}
            table.writerow({k: f"{v:.4g}" if isinstance(v, float) else v for k, v in row.items()})
        file.flush()


def write_markdown(file, measured):
    sizes = None
    for model, results in measured:
        framed = [r for r in results if r["params"]["series"] == "framed"]
        if sizes is None:
            sizes = [r["params"]["splat_size"] for r in framed]
            file.write("| model | " + " | ".join(f"{size:g} px" for size in sizes) + " |\n|---|" + "---|" * len(sizes) + "\n")
        cells = [f"{f['interior_holes_per_10k']:.1f}, {f['area_ratio']:.2f}, {f['wrong_depth_per_1k']:.0f}"
                 for f in (r["figures"] for r in framed)]
        file.write(f"| {model.name} | " + " | ".join(cells) + " |\n")
        file.flush()


def main():
    arguments = sys.argv[1:]
    more = []
    if arguments[:1] == ["--size"]:
        more, arguments = arguments[:2], arguments[2:]
    if len(arguments) < 2:
        sys.exit(__doc__)
    measured = ((model, results) for model in models(arguments[1:]) if (results := measure(model, more)) is not None)
    with open(arguments[0], "w", newline="") as file:
        (write_markdown if arguments[0].endswith(".md") else write_csv)(file, measured)


main()
