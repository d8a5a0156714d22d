#!/usr/bin/env python3
"""Progressive Splatting and the methods it is compared with (Wu, Zhang, Kobbelt 2005, 6): splats,
area ratio and time.

    lab/papers/decimators.py [MODEL...] [--splats N,N...] [--repeats N] [--out FILE.json]

Runs `stipple-lab decimate MODEL --by METHOD --splats N`. The area ratio is the sum of all splat areas
over the area of the model's triangles (Table 1 of the paper). Times are medians. Methods take
turns, so that a busy machine slows all of them. CPU times include all threads, reading and writing.
Models need triangles. Default: models of Debian's assimp-testmodels.
"""
import argparse
import pathlib
import statistics
import tempfile

import kit

TESTMODELS = pathlib.Path("/usr/share/assimp/models")
MODELS = ["PLY/Wuson.ply", "OBJ/spider.obj"]
METHODS = {"psp": ["--by", "psp"], "psp distances": ["--by", "psp", "--metric", "distances"]} | {
    by: ["--by", by] for by in ("octree", "octree-level", "quadric", "blue", "mesh", "subsample")}


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("models", nargs="*", default=[str(TESTMODELS / name) for name in MODELS])
    parser.add_argument("--splats", default="415,2591,11588", help="numbers of splats; default: those of Table 1")
    parser.add_argument("--repeats", type=int, default=5, help="default 5")
    parser.add_argument("--out", metavar="FILE.json", help="output file of the figures; default bench/results/MACHINE/DATE-decimators.json")
    options = parser.parse_args()
    kept, rows = [], []
    with tempfile.TemporaryDirectory() as folder:
        for model in options.models:
            for count in map(int, options.splats.split(",")):
                runs = {name: [] for name in METHODS}
                for _ in range(options.repeats):
                    for name, words in METHODS.items():
                        runs[name].append(kit.timed("decimate", model, "-o", f"{folder}/out.ply", "--splats", count, *words))
                surface = runs["mesh"][0]["surface"]
                for name, figures in runs.items():
                    first, (seconds, busy) = figures[0], (statistics.median(f[key] for f in figures) for key in ("seconds", "processor_seconds"))
                    made, ratio = first["splats"] or first.get("vertices", 0), first["area"] / surface
                    kept.append({"name": "decimate", "params": {"model": model, "by": name, "asked": count},
                                 "figures": {"points": first["points"], "splats": made, "area_ratio": ratio, "seconds": seconds,
                                             "processor_seconds": busy}})
                    rows.append([pathlib.Path(model).stem, count, name, made, f"{ratio:.2f}", f"{seconds:.3f} s", f"{busy:.2f} s"])
    kit.table(["model", "requested", "method", "splats", "area ratio", "time", "CPU time"], rows)
    kit.keep("decimators", kept, options.out)


if __name__ == "__main__":
    main()
