#!/usr/bin/env python3
"""Pictures in motion: their times, how true they are, and what was drawn for each covered pixel.

usage: bench/motion.py [--budget-ms MS] [--frames N] [--every N] [--popping] [--size WxH] [--processors LIST] FILE=PATH...

Flies through each FILE along its PATH within a budget, with each kind of vectors. Every Nth frame is
compared with 16 samples a pixel of the original triangles (truth); the ratio is to what the original
triangles reach with one sample, and, filtered, with the same pixel filter. Popping compares every
frame with its originals, which takes long. Results go to bench/results.
"""
import os
import statistics
import sys

import kit

MEDIAN = statistics.median


def fly(given, scene, path, vectors):
    """@return figures of a flight"""
    os.environ["STP_PROCESSOR"] = vectors
    made = kit.stipple("fly", scene, "--path", path, "--budget-ms", given.budget_ms, "--size", given.size, "--frames", given.frames,
                       "--reference-every", given.every, *(["--popping"] if given.popping else []), threads=given.threads)
    frames = [f for f in made["per_frame"] if f["covered_pixels"] > 0]
    compared = made["quality"]
    filtered = [q["truth"] / q["exact_filtered"] for q in compared if q["exact_filtered"]]
    figures = {"frame_ms": made["frame_ms"], "within_1_15": sum(f["frame_ms"] <= 1.15 * given.budget_ms for f in frames) / len(frames),
               "splat_size": MEDIAN(f["splat_size"] for f in frames), "resolution": MEDIAN(f["resolution"] or 1 for f in frames),
               "truth": MEDIAN(q["truth"] for q in compared), "ratio": MEDIAN(q["ratio"] for q in compared),
               "ratio_least": min(q["ratio"] for q in compared), "popping": made["popping"]}
    if filtered:
        figures |= {"filtered_ratio": MEDIAN(filtered), "filtered_ratio_least": min(filtered)}
    for name in ("splats", "triangles", "fragments"):
        figures[f"{name}_a_pixel"] = MEDIAN(f[name] / f["covered_pixels"] for f in frames)
    return kit.result("motion", {"scene": scene, "path": path, "vectors": vectors, "budget_ms": given.budget_ms, "size": given.size,
                                 "frames": given.frames}, figures)


def show(results):
    head = ["flight", "vectors", "ms: median", "99 %", "within 1.15 x", "splat size", "resolution", "ratio: median", "least",
            "filtered: median", "least", *(["popping: median", "99.9 %"] if results[0]["figures"]["popping"] else []), "splats a pixel", "triangles", "fragments"]
    rows = []
    for r in results:
        f = r["figures"]
        rows.append([kit.name_of(r["params"]["path"]).removesuffix(".json"), r["params"]["vectors"], f"{f['frame_ms']['p50']:.1f}", f"{f['frame_ms']['p99']:.1f}",
                     f"{100 * f['within_1_15']:.1f} %", f"{f['splat_size']:.1f}", f"{f['resolution']:.2f}", f"{f['ratio']:.3f}", f"{f['ratio_least']:.3f}",
                     *(f"{f[n]:.3f}" if n in f else "" for n in ("filtered_ratio", "filtered_ratio_least")),
                     *(f"{f['popping'][n]:.2f}" for n in ("p50", "p999") if f["popping"]),
                     *(f"{f[n]:.2f}" for n in ("splats_a_pixel", "triangles_a_pixel", "fragments_a_pixel"))])
    kit.table(head, rows)


def main():
    parser = kit.options(__doc__, "1280x720")
    parser.add_argument("flights", nargs="+", metavar="FILE=PATH")
    parser.add_argument("--budget-ms", type=float, default=33)
    parser.add_argument("--frames", type=int, default=146)
    parser.add_argument("--every", type=int, default=10)
    parser.add_argument("--popping", action="store_true", help="measure it, too")
    parser.add_argument("--processors", default="avx512,avx2", help="values of STP_PROCESSOR; default avx512,avx2")
    given = parser.parse_args()
    results = []
    for flight in given.flights:
        scene, found, path = flight.rpartition("=")
        if not found:
            sys.exit(f"bench/motion.py: {flight}: expected FILE=PATH")
        for vectors in given.processors.split(","):
            kit.say(f"{kit.name_of(path)}, {vectors} ...")
            results.append(fly(given, scene, path, vectors))
    show(results)
    kit.keep("motion", results, given.out)


if __name__ == "__main__":
    main()
