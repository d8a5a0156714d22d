#!/usr/bin/env python3
"""Runs `stipple bench quality` on every model below the given paths and writes one table, a row a model and series.

usage: bench/quality.py OUT.csv PATH...
"""
import csv
import json
import pathlib
import subprocess
import sys

ROOT = pathlib.Path(__file__).resolve().parent.parent
STIPPLE = ROOT / "build/release/tools/stipple"
ENDINGS = {".glb", ".gltf", ".obj", ".stl", ".ply"}
COLUMNS = ["model", "series", "pictures", "covered_pixels", "splats", "triangles", "ssim", "ssim_covered",
           "ssim_covered_least", "holes_per_10k", "wrong_depth_per_10k", "extra_per_10k", "worst_direction"]


def models(paths):
    for path in map(pathlib.Path, paths):
        yield from sorted(p for p in path.rglob("*") if p.suffix in ENDINGS) if path.is_dir() else [path]


def main():
    if len(sys.argv) < 3:
        sys.exit(__doc__)
    with open(sys.argv[1], "w", newline="") as file:
        table = csv.DictWriter(file, COLUMNS, extrasaction="ignore")
        table.writeheader()
        for model in models(sys.argv[2:]):
            run = subprocess.run([STIPPLE, "bench", "quality", "--model", model, "--json"],
                                 capture_output=True, text=True)
            if run.returncode != 0:
                print(f"{model}: {run.stderr.strip().splitlines()[-1]}", file=sys.stderr)
                continue
            for result in json.loads(run.stdout)["results"]:
                row = {**result["params"], **result["figures"], "model": model.name}
                table.writerow({k: f"{v:.4g}" if isinstance(v, float) else v for k, v in row.items()})
            file.flush()


main()
