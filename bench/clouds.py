#!/usr/bin/env python3
"""CPU time of building point clouds, alternating between several executables.

    bench/clouds.py build/release/tools/stipple [OTHER...] [--counts 10000,100000,1000000]
                    [--runs 5] [--json FILE]

A cloud is a wavy sheet without normals, far from the origin (as maps are), with coordinates in
double precision. Times are user and system time of the whole process, the median over the runs. The
start of a process that builds nothing is shown separately.
"""
import argparse
import array
import json
import math
import os
import random
import resource
import statistics
import subprocess
import tempfile


def write_cloud(path, count):
    numbers, side = random.Random(1), math.sqrt(count) / 10
    values = array.array("d")
    for _ in range(count):
        x, y = numbers.random() * side, numbers.random() * side
        z = 5 * math.sin(x * 0.2) * math.cos(y * 0.17) + 0.02 * numbers.random()
        values.extend((674000 + x, 1206000 + y, 600 + z))
    header = f"ply\nformat binary_little_endian 1.0\nelement vertex {count}\n"
    with open(path, "wb") as file:
        file.write((header + "".join(f"property double {c}\n" for c in "xyz") + "end_header\n").encode())
        values.tofile(file)


def seconds(*command):
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    subprocess.run(command, check=True, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return after.ru_utime - before.ru_utime, after.ru_stime - before.ru_stime


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("executables", nargs="+")
    parser.add_argument("--counts", default="10000,100000,1000000")
    parser.add_argument("--runs", type=int, default=5)
    parser.add_argument("--json")
    options = parser.parse_args()
    rows = []
    with tempfile.TemporaryDirectory() as folder:
        cloud, output = os.path.join(folder, "cloud.ply"), os.path.join(folder, "cloud.stip")
        for count in [0] + [int(c) for c in options.counts.split(",")]:
            if count:
                write_cloud(cloud, count)
            times = {name: [] for name in options.executables}
            for _ in range(options.runs):
                for name in options.executables:
                    if os.path.exists(output):
                        os.remove(output)  # else the build would reuse its results
                    times[name].append(seconds(name, "build", cloud, "-o", output) if count else seconds(name, "help"))
            for name, runs in times.items():
                user, system = (statistics.median(run[k] for run in runs) for k in (0, 1))
                rows.append({"executable": name, "points": count, "user_s": user, "system_s": system})
                rate = f"{count / user:12,.0f} points/s of user time" if count else "a process"
                print(f"{name:40} {count:9,} {user:8.3f} s user {system:8.3f} s system {rate}", flush=True)
    if options.json:
        with open(options.json, "w", encoding="utf-8") as file:
            json.dump(rows, file, indent=1)
            file.write("\n")


main()
