#!/usr/bin/env python3
"""CPU time of building point clouds, alternating between several executables.

    bench/clouds.py build/release/lab/stipple-lab [OTHER...] [--counts 10000,100000,1000000] [--runs 5] [--json FILE]
        [--cloud FILE --memory SIZE]

A cloud is a wavy sheet without normals, far from the origin (as in maps), with coordinates as doubles. Time is user
and system time of the whole process, the median over the runs; the time of a process that builds nothing is shown separately.
With --cloud, a file's points are built instead; prints its points, the bytes of the result and the peak resident memory.
"""
import argparse
import array
import json
import math
import os
import random
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


def measure(*command):
    """User and system seconds, and peak resident MB."""
    child = subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    _, status, usage = os.wait4(child.pid, 0)
    child.returncode = os.waitstatus_to_exitcode(status)
    if child.returncode != 0:
        raise subprocess.CalledProcessError(child.returncode, command)
    return usage.ru_utime, usage.ru_stime, usage.ru_maxrss / 1024


def count_points(name, stip):
    info = subprocess.run([name, "info", stip, "--json"], check=True, capture_output=True, text=True)
    return json.loads(info.stdout)["points"]


def measure_file(options, folder):
    """Builds a given cloud with each executable."""
    output, rows = os.path.join(folder, "cloud.stip"), []
    limit = ["--memory", options.memory] if options.memory else []
    runs, sizes = {name: [] for name in options.executables}, {}
    for _ in range(options.runs):
        for name in options.executables:
            runs[name].append(measure(name, "build", options.cloud, "-o", output, "--fresh", *limit))
            sizes[name] = os.path.getsize(output)
            points = count_points(name, output)
    for name, measured in runs.items():
        user, system, resident = (statistics.median(run[k] for run in measured) for k in range(3))
        rows.append({"executable": name, "points": points, "memory": options.memory, "user_s": user, "system_s": system,
                     "resident_mb": resident, "bytes_per_point": sizes[name] / points})
        print(f"{name:40} {points:11,} {user:8.2f} s user {system:7.2f} s system {resident:7.0f} MB "
              f"{sizes[name] / points:6.2f} bytes per point", flush=True)
    return rows


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("executables", nargs="+")
    parser.add_argument("--counts", default="10000,100000,1000000")
    parser.add_argument("--runs", type=int, default=5)
    parser.add_argument("--json")
    parser.add_argument("--cloud")
    parser.add_argument("--memory")
    options = parser.parse_args()
    rows = []
    with tempfile.TemporaryDirectory() as folder:
        cloud, output = os.path.join(folder, "cloud.ply"), os.path.join(folder, "cloud.stip")
        if options.cloud:
            rows = measure_file(options, folder)
        for count in [] if options.cloud else [0] + [int(c) for c in options.counts.split(",")]:
            if count:
                write_cloud(cloud, count)
            times = {name: [] for name in options.executables}
            for _ in range(options.runs):
                for name in options.executables:
                    if os.path.exists(output):
                        os.remove(output)  # else its results would be used again
                    times[name].append(measure(name, "build", cloud, "-o", output) if count else measure(name, "help"))
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
