#!/usr/bin/env python3
"""Late frames after jumps of the camera.

usage: bench/jumps.py [--stays N] [--frames N] [--budget-ms MS] [--size WxH] [--runs N] FILE PATH

The camera stays at random places of the flight PATH and moves on from there as the flight does, for
some frames each; then it jumps. Prints how many frames took more than 1.15 times the budget: of
all, and of the first after a jump; and the longest frame. Medians of the runs.
"""
import argparse
import json
import pathlib
import random
import statistics
import tempfile

import kit

PARTS = ("eye", "target", "up")


def place(keys, time):
    """The camera between two keys, on a straight line."""
    before, after = next(((a, b) for a, b in zip(keys, keys[1:]) if time <= b["t"]), (keys[-1], keys[-1]))
    share = (time - before["t"]) / (after["t"] - before["t"]) if after["t"] > before["t"] else 0.0
    return {part: [x + (y - x) * share for x, y in zip(before[part], after[part])] for part in PARTS}


def make_path(flight, stays, frames):
    """A key for each frame, so nothing is interpolated."""
    draw, fps, keys = random.Random(5), flight.get("fps", 30), []
    for stay in range(stays):
        start = draw.uniform(0, 0.95 * flight["keys"][-1]["t"])
        for frame in range(frames):
            keys.append({"t": (stay * frames + frame) / fps, **place(flight["keys"], start + frame / fps)})
    return {**flight, "keys": keys}


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("file")
    parser.add_argument("path", type=pathlib.Path)
    parser.add_argument("--stays", type=int, default=15)
    parser.add_argument("--frames", type=int, default=12, help="of each stay")
    parser.add_argument("--budget-ms", type=float, default=33)
    parser.add_argument("--size", default="1280x720")
    parser.add_argument("--runs", type=int, default=3)
    given = parser.parse_args()
    count, runs = given.stays * given.frames, []
    with tempfile.TemporaryDirectory() as folder:
        path = pathlib.Path(folder) / "jumps.json"
        path.write_text(json.dumps(make_path(json.loads(given.path.read_text()), given.stays, given.frames)))
        for _ in range(given.runs):
            made = kit.stipple("fly", given.file, "--path", path, "--frames", count, "--budget-ms", given.budget_ms, "--size", given.size)
            times = [frame["frame_ms"] for frame in made["per_frame"]]
            late = [time > 1.15 * given.budget_ms for time in times]
            runs.append((sum(late), sum(late[given.frames::given.frames]), max(times)))
    late, first, longest = (statistics.median(values) for values in zip(*runs))
    print(f"{count} frames, {given.stays - 1} jumps: {late:g} late, {first:g} of them the first after a jump; longest {longest:.1f} ms")


if __name__ == "__main__":
    main()
