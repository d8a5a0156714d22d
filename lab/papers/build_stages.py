#!/usr/bin/env python3
"""Building a cloud by `stochastic` and by `blue`: seconds of the whole build, and of the sets alone.

usage: lab/papers/build_stages.py [--runs N] [--out FILE.json] CLOUD...

Both methods in turn, by one thread. Of a mesh as PLY the vertices and their normals are taken. `all` is the CPU time of `stipple
build`, including the kernel's part. `sets` is what the methods do (stages capture, order and finish of `build --json`, in seconds of
wall time); the rest, which both share, is reading, decoding, cutting and writing. Medians.
"""
import pathlib
import statistics
import tempfile

import kit
from stochastic import cloud_of

METHODS = ("stochastic", "blue")


def build(cloud, method, folder):
    """CPU seconds of all, seconds of the sets, and megabytes of the file."""
    out = folder / "built.stip"
    out.unlink(missing_ok=True)
    before = kit.processor_seconds()
    stages = kit.stipple("build", cloud, "-o", out, "--method", method, "--fresh", "--progress", "none", threads=1)["seconds"]
    after = kit.processor_seconds()
    return after - before, sum(stages[name] for name in ("capture", "order", "finish")), out.stat().st_size / 1e6


def main():
    parser = kit.options(__doc__)
    parser.add_argument("clouds", nargs="+", metavar="CLOUD", type=pathlib.Path)
    parser.add_argument("--runs", type=int, default=5)
    given = parser.parse_args()
    results, rows = [], []
    with tempfile.TemporaryDirectory() as name:
        for cloud in given.clouds:
            kit.say(f"{cloud.stem} ...")
            runs = {method: [] for method in METHODS}
            points = cloud_of(cloud, pathlib.Path(name))
            for _ in range(given.runs):
                for method, measured in runs.items():
                    measured.append(build(points, method, pathlib.Path(name)))
            medians = {method: [statistics.median(column) for column in zip(*measured)] for method, measured in runs.items()}
            (all_s, sets_s, size_s), (all_b, sets_b, size_b) = medians["stochastic"], medians["blue"]
            rows.append([cloud.stem, f"{all_s:.2f}", f"{all_b:.2f}", f"{all_b / all_s:.2f}", f"{sets_s:.2f}", f"{sets_b:.2f}",
                         f"{sets_b / sets_s:.2f}", f"{size_s:.2f}", f"{size_b:.2f}"])
            results.append(kit.result("build-stages", {"cloud": cloud.name, "threads": 1},
                                      {f"{part}_{method}": round(value, 4) for method, values in medians.items()
                                       for part, value in zip(("all", "sets", "megabytes"), values)}))
    kit.table(["cloud", "all, stochastic", "all, blue", "ratio", "sets, stochastic", "sets, blue", "ratio", "MB, stochastic", "MB, blue"], rows)
    kit.keep("build-stages", results, given.out)


if __name__ == "__main__":
    main()
