#!/usr/bin/env python3
"""Kills builds at random moments, resumes them, and compares their bytes with an undisturbed build.

    scripts/check_resume.py build/release/lab/stipple-lab build/resume --kills 50 scene:one-mesh

Prints one line per kill: its time, the stage, and the content of the work folder. A build is
killed up to eight times before it may finish. Options of `stipple build` follow `--`.
"""
import argparse
import json
import os
import pathlib
import random
import signal
import subprocess
import sys
import time

KILLS_OF_A_BUILD = 8


def parse_arguments():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("executable")
    parser.add_argument("folder")
    parser.add_argument("inputs", nargs="+")
    parser.add_argument("--kills", type=int, default=20)
    parser.add_argument("--seed", type=int, default=1)
    arguments = sys.argv[1:]
    options = []
    if "--" in arguments:
        at = arguments.index("--")
        arguments, options = arguments[:at], arguments[at + 1:]
    parsed = parser.parse_args(arguments)
    parsed.options = options
    return parsed


def build_command(args, output):
    return [os.path.abspath(args.executable), "build", *args.inputs, "-o", str(output), "--json",
            "--progress", "json", *args.options]


def run_whole(command):
    """An undisturbed build: its figures and seconds."""
    start = time.monotonic()
    done = subprocess.run(command, capture_output=True, text=True)
    if done.returncode != 0:
        sys.exit(f"{' '.join(command)}: exit {done.returncode}: {done.stderr}")
    return json.loads(done.stdout), time.monotonic() - start


def run_killed(command, delay, log):
    """Kills a build after `delay` seconds. Returns its stage, or None if it had already ended."""
    with open(log, "w") as errors:
        process = subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=errors)
        try:
            code = process.wait(timeout=delay)
        except subprocess.TimeoutExpired:
            process.send_signal(signal.SIGKILL)
            code = process.wait()
    lines = [line for line in open(log).read().splitlines() if line.startswith("{") and line.endswith("}")]
    if code == 0:
        return None
    if code != -signal.SIGKILL:
        sys.exit(f"{' '.join(command)}: exit {code}: {open(log).read()}")
    last = json.loads(lines[-1]) if lines else {"stage": "start", "fraction": 0.0}
    return f"{last['stage']} {100 * last['fraction']:3.0f} %"


def work_bytes(output):
    folder = pathlib.Path(f"{output}.work")
    return sum(file.stat().st_size for file in folder.iterdir()) if folder.is_dir() else 0


def leftovers(folder, output):
    return [name.name for name in folder.iterdir() if name.name.startswith(output.name + ".")]


def main():
    args = parse_arguments()
    folder = pathlib.Path(args.folder)
    folder.mkdir(parents=True, exist_ok=True)
    args.inputs = [i if i.startswith("scene:") else os.path.abspath(i) for i in args.inputs]
    choose = random.Random(args.seed)
    expected, output, log = folder / "undisturbed.stip", folder / "killed.stip", folder / "log"
    for file in (expected, output):
        file.unlink(missing_ok=True)
    _, seconds = run_whole(build_command(args, expected))
    wanted = expected.read_bytes()
    print(f"undisturbed: {seconds:.2f} s, {len(wanted)} bytes")
    kills = builds = resumed = 0
    command = build_command(args, output)
    while kills < args.kills:
        builds += 1
        for _ in range(KILLS_OF_A_BUILD):
            delay = choose.uniform(0.0, 1.1 * seconds)
            stage = run_killed(command, delay, log)
            if stage is None:
                break
            kills += 1
            print(f"kill {kills:4}: after {delay:6.2f} s at {stage}, {work_bytes(output)} bytes kept")
            if output.exists() and output.read_bytes() != wanted:
                sys.exit("a killed build left an incomplete file")
            if kills >= args.kills:
                break
        figures, took = run_whole(command)
        kept = figures.get("unchanged", {})
        found = kept.get("surfel_sets", 0)
        resumed += found > 0
        same = output.read_bytes() == wanted
        print(f"build {builds:3}: {took:.2f} s, {found} surfel sets reused, {kept.get('surfel_sets_made', 0)} made, "
              f"{'the same bytes' if same else 'OTHER BYTES'}")
        if not same:
            sys.exit(f"{output} differs from {expected}")
        if leftovers(folder, output):
            sys.exit(f"left behind: {' '.join(leftovers(folder, output))}")
        output.unlink()
    print(f"{kills} kills, {builds} builds, {resumed} of them resumed; all bytes are the same")


main()
