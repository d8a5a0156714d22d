#!/usr/bin/env python3
"""Speed and memory of Progressive Splatting by number of points: a table.

usage: lab/papers/psp_scale.py [--millions 1,4,20] [--repeats N] [--scratch FOLDER]

Each million points are random points on a bumpy sphere; larger clouds are several such spheres. All
are decimated to 1 %. The first cloud is also merged with one queue instead of pieces, with the lazy
queue, and with the distance metric; the largest with --memory 2G, and with 256M, where most data is
in files. CPU time includes all threads, reading and writing. The machine may be busy, so times are
medians of --repeats.
"""
import array
import math
import os
import pathlib
import random
import statistics

import kit

MILLION = 1_000_000


def sphere():
    """A million points on a bumpy sphere."""
    chance, points = random.Random(7), array.array("f")
    for _ in range(MILLION):
        z, around = 2 * chance.random() - 1, math.tau * chance.random()
        across = math.sqrt(1 - z * z)
        x, y = across * math.cos(around), across * math.sin(around)
        away = 1 + 0.05 * math.sin(9 * x) * math.sin(11 * y) * math.sin(10 * z) + 0.01 * math.sin(40 * x + 3 * y) * math.cos(37 * z)
        points.extend((x * away, y * away, z * away))
    return points


def write_cloud(path, points, millions):
    with open(path, "wb") as file:
        names = "".join(f"property float {axis}\n" for axis in "xyz")
        file.write(f"ply\nformat binary_little_endian 1.0\nelement vertex {millions * MILLION}\n{names}end_header\n".encode())
        for i in range(millions):
            moved = points[:]
            moved[0::3] = array.array("f", (x + 2.5 * i for x in points[0::3]))
            moved.tofile(file)


def measure(given, path, millions, threads, *more):
    kit.say(f"{millions} million, {threads} threads {' '.join(more)} ...")
    runs = []
    for _ in range(given.repeats if millions < 10 else 1):
        runs.append(kit.timed("decimate", path, "-o", given.scratch / "splats.ply", "--splats", millions * MILLION // 100, *more, threads=threads))
    figures = {key: statistics.median(r[key] for r in runs) for key in ("seconds", "processor_seconds", "area", "peak_bytes", "splats")}
    figures["points_per_second"] = round(millions * MILLION / figures["seconds"])
    figures["points_per_processor_second"] = round(millions * MILLION / figures["processor_seconds"])
    figures["load_average"] = round(os.getloadavg()[0], 1)
    return kit.result("psp-scale", {"points": millions * MILLION, "threads": threads, "options": " ".join(more)}, figures)


def main():
    parser = kit.options(__doc__)
    parser.add_argument("--millions", default="1,4,20")
    parser.add_argument("--repeats", type=int, default=3)
    parser.add_argument("--scratch", type=pathlib.Path, default=kit.ROOT / "build/psp-scale", help="of clouds; default build/psp-scale")
    given = parser.parse_args()
    given.scratch.mkdir(parents=True, exist_ok=True)
    sizes, points, results = sorted(map(int, given.millions.split(","))), None, []
    threads = given.threads or os.cpu_count()
    for size in sizes:
        path = given.scratch / f"spheres-{size}.ply"
        if not path.exists():
            kit.say(f"{path} ...")
            points = points or sphere()
            write_cloud(path, points, size)
        calls = [(threads,)]
        if size == sizes[0]:
            calls += [(1,), (1, "--piece-size", str(size * MILLION)), (1, "--queue", "lazy"), (threads, "--metric", "distances")]
        if size == sizes[-1]:
            calls = [(threads, "--memory", "2G"), (threads, "--memory", "256M"), *calls[1:]]
        results += [measure(given, path, size, *call) for call in calls]
    kit.keep("psp-scale", results, given.out)
    kit.table(("points", "threads", "options", "s", "processor s", "points / s", "points / CPU s", "area", "peak MB"),
              [(kit.short(r["params"]["points"]), r["params"]["threads"], r["params"]["options"], f"{r['figures']['seconds']:.2f}",
                f"{r['figures']['processor_seconds']:.2f}", kit.short(r["figures"]["points_per_second"]),
                kit.short(r["figures"]["points_per_processor_second"]), f"{r['figures']['area']:.4g}",
                f"{r['figures']['peak_bytes'] / 1e6:.0f}") for r in results])


if __name__ == "__main__":
    main()
