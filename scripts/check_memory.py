#!/usr/bin/env python3
"""Builds under memory limits and measures the memory actually used.

    scripts/check_memory.py build/release/lab/stipple-lab build/memory \\
        --limits 1G,512M scene:power-plant,scale=0.1
    scripts/check_memory.py build/release/lab/stipple-lab build/memory --smallest 8M,1G model.glb

Prints for each limit the bytes that the library counted (peak_bytes), the peak of resident
anonymous memory (RssAnon of /proc/PID/status, sampled; excludes mapped files), and the seconds. All
files must be identical, regardless of the limit. --smallest searches for the limit at which a build just
succeeds. Options of `stipple build` follow `--`. Fails if the counted bytes exceed the limit, or
the resident bytes exceed it by more than a tenth plus BASE.
"""
import argparse
import hashlib
import json
import os
import pathlib
import subprocess
import sys
import time

SAMPLE_SECONDS = 0.02
NEAR_ENOUGH = 1.05
ABOVE_LIMIT = 1.1
# Of any build: written pages of the executable and its libraries, stacks, small library blocks.
BASE = 4 << 20
UNITS = {"K": 1 << 10, "M": 1 << 20, "G": 1 << 30}


def parse_size(text):
    return int(float(text[:-1]) * UNITS[text[-1]]) if text[-1] in UNITS else int(text)


def parse_arguments():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("executable")
    parser.add_argument("folder")
    parser.add_argument("inputs", nargs="+")
    parser.add_argument("--limits", default="", help="comma-separated sizes; 0: unlimited")
    parser.add_argument("--smallest", default="", help="MIN,MAX: range of the search")
    arguments, options = sys.argv[1:], []
    if "--" in arguments:
        at = arguments.index("--")
        arguments, options = arguments[:at], arguments[at + 1:]
    parsed = parser.parse_args(arguments)
    parsed.options = options
    return parsed


def anonymous_bytes(pid):
    try:
        for line in open(f"/proc/{pid}/status"):
            if line.startswith("RssAnon:"):
                return int(line.split()[1]) << 10
    except OSError: # it has ended
        pass
    return 0


def build(args, limit):
    """Exit code, figures or message, peak of anonymous bytes, hash of the file."""
    output = pathlib.Path(args.folder) / "limited.stip"
    output.unlink(missing_ok=True)
    command = [args.executable, "build", *args.inputs, "-o", str(output), "--fresh", "--json", *args.options]
    command += ["--memory", str(limit)] if limit else []
    with open(f"{output}.json", "w+") as figures, open(f"{output}.errors", "w+") as errors:
        process = subprocess.Popen(command, stdout=figures, stderr=errors)
        most = 0
        while process.poll() is None:
            most = max(most, anonymous_bytes(process.pid))
            time.sleep(SAMPLE_SECONDS)
        figures.seek(0)
        errors.seek(0)
        if process.returncode != 0:
            return process.returncode, errors.read().strip(), most, None
        return 0, json.load(figures), most, hashlib.sha256(output.read_bytes()).hexdigest()


def show(args, limit, done):
    code, figures, most, _ = done
    name = f"{limit / (1 << 20):8.1f} MiB" if limit else "    no limit"
    if code != 0:
        print(f"{name}: exit {code}: {figures}", flush=True)
        return
    share = f", {100 * most / limit:5.1f} % of the limit" if limit else ""
    print(f"{name}: counted {figures['peak_bytes'] / (1 << 20):8.1f} MiB, anonymous {most / (1 << 20):8.1f} MiB{share}, "
          f"{figures['seconds']['total']:.2f} s", flush=True)
    if limit and figures["peak_bytes"] > limit:
        sys.exit("the counted bytes exceed the limit")
    if limit and most > ABOVE_LIMIT * limit + BASE:
        sys.exit("the resident bytes exceed the limit")


def search(args):
    """Bisects (geometrically) between a limit that fails and one that succeeds."""
    least, most = (parse_size(size) for size in args.smallest.split(","))
    while most > least * NEAR_ENOUGH:
        limit = int((least * most) ** 0.5)
        done = build(args, limit)
        show(args, limit, done)
        least, most = (least, limit) if done[0] == 0 else (limit, most)
    print(f"smallest: {most / (1 << 20):.1f} MiB")


def main():
    args = parse_arguments()
    args.executable = os.path.abspath(args.executable)
    pathlib.Path(args.folder).mkdir(parents=True, exist_ok=True)
    sums = set()
    for size in args.limits.split(",") if args.limits else []:
        limit = parse_size(size)
        done = build(args, limit)
        show(args, limit, done)
        if done[3] is not None:
            sums.add(done[3])
    if len(sums) > 1:
        sys.exit("the bytes depend on the limit")
    if args.smallest:
        search(args)


main()
