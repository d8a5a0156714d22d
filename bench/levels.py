#!/usr/bin/env python3
"""Upper nodes captured from their children's surfels, and from triangles (Brandt 3.4): cost and
picture quality of each.

usage: bench/levels.py [--size WxH] [--splat-sizes N,N] INPUT...

Builds each input both ways with one thread, draws every named view (or `iso`) at every splat size,
and compares with the original triangles. Prints one JSON object, in the format of `stipple bench
--json`.
"""
import argparse
import json
import pathlib
import statistics
import subprocess
import tempfile

STIPPLE = pathlib.Path(__file__).resolve().parent.parent / "build/release/lab/stipple-lab"


def run(*arguments):
    done = subprocess.run([STIPPLE, *map(str, arguments), "--quiet", "--json"], capture_output=True, text=True, check=True)
    return json.loads(done.stdout)


def draw(file, view, size, png, *options):
    return run("render", file, "--view", view, "--size", size, "-o", png, *options)


def measure(path, folder, size, splat_sizes):
    results = []
    for capture in ("splats", "triangles"):
        file = folder / f"{capture}.stip"
        built = run("build", path, "-o", file, "--fresh", "--threads", 1, "--capture", capture)
        views = run("info", file)["views"] or ["iso"]
        for splat_size in splat_sizes:
            alike, covered, splats = [], [], []
            for view in views:
                truth = folder / f"{view}.png"
                if not truth.exists():
                    draw(file, view, size, truth, "--reference")
                picture = folder / "picture.png"
                splats.append(draw(file, view, size, picture, "--splat-size", splat_size)["splats"])
                figures = run("compare", picture, truth)
                alike.append(figures["ssim"])
                covered.append(figures["ssim_covered"])
            results.append({
                "name": "levels",
                "params": {"input": str(path), "capture": capture, "splat_size": splat_size, "views": len(views)},
                "figures": {
                    "surfels": built["unique_surfels"],
                    "capture_seconds": built["seconds"]["capture"],
                    "total_seconds": built["seconds"]["total"],
                    "splats": statistics.median(splats),
                    "ssim": statistics.median(alike),
                    "ssim_covered": statistics.median(covered),
                    "ssim_covered_least": min(covered),
                },
            })
    return results


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("inputs", nargs="+", metavar="INPUT")
    parser.add_argument("--size", default="960x540")
    parser.add_argument("--splat-sizes", default="1,2,4")
    options = parser.parse_args()
    results = []
    for path in options.inputs:
        with tempfile.TemporaryDirectory() as folder:
            results += measure(path, pathlib.Path(folder), options.size, options.splat_sizes.split(","))
    print(json.dumps({"results": results}, indent=2))


main()
