#!/usr/bin/env python3
"""Gaps in pictures of scans: how much of what points stand for is covered, at rest and in motion.

usage: bench/gaps.py [--views N] [--jobs N] SCAN.stip...

Each scan is seen from the 26 directions d0 to d25, from where it fits into the picture, and from a
third and a ninth of that distance to what is in the middle. The truth is a closing: original points
8, 16 and 32 pixels wide, eroded by half of that. "Rest" and "motion" are the shares of the truth
that splats of 1 and 4 pixels cover. "Beyond" is what splats of 1 pixel cover outside of the truth,
as a share of it. Prints a table. Clouds only.
"""
import concurrent.futures
import math
import pathlib
import statistics
import sys
import tempfile

import kit

sys.path.insert(0, str(kit.ROOT / "tests/cli"))
from read_png import read_png  # noqa: E402

NEARNESS = (1, 3, 9)
WIDTHS = (8, 16, 32)
MOTION = 4


def mask(path):
    """The covered pixels, a whole number for each row: bit x is column x."""
    rows = []
    for row in read_png(path):
        bits = "".join("1" if alpha else "0" for alpha in row[:2:-4])
        rows.append(int(bits, 2))
    return rows, len(bits)


def widen(bits, reach):
    """Sets each bit that is at most `reach` from a set one."""
    grown, done = bits, 0
    while done < reach:
        step = min(reach - done, done + 1)
        grown |= grown << step | grown >> step
        done += step
    return grown


def erode(rows, width, radius):
    """Keeps pixels whose disk is covered. What is beside the picture counts as covered."""
    full, height = (1 << width) - 1, len(rows)
    open_pixels = [full & ~row for row in rows]
    kept = list(rows)
    for dy in range(-radius, radius + 1):
        reach = math.isqrt(radius * radius - dy * dy)
        for y in range(max(0, -dy), min(height, height - dy)):
            if open_pixels[y + dy]:
                kept[y] &= ~widen(open_pixels[y + dy], reach)
    return kept


def count(rows):
    return sum(row.bit_count() for row in rows)


def draw(scan, path, size, camera, *more):
    picture = kit.stipple("render", scan, "-o", path, "--size", size, "--once", "--eye-dome", "off", *camera, *more, threads=1)
    return mask(path), picture


def shares(covered, truth):
    """The covered share of the truth, and what is covered outside of it."""
    whole = max(1, count(truth))
    inside = count([a & b for a, b in zip(covered, truth)])
    return inside / whole, (count(covered) - inside) / whole


def measure_view(job):
    scan, size, view = job
    found = []
    with tempfile.TemporaryDirectory() as folder:
        path = pathlib.Path(folder) / "picture.png"
        across, down = map(int, size.split("x"))
        first = kit.stipple("render", scan, "-o", path, "--size", size, "--once", "--view", view, "--pick", f"{across // 2},{down // 2}", threads=1)
        camera = first["camera"]
        middle = first["pick"]["position"] if first["pick"]["hit"] else camera["target"]
        arm = [e - t for e, t in zip(camera["eye"], camera["target"])]
        for nearer, width in zip(NEARNESS, WIDTHS):
            look = ["--view", view] if nearer == 1 else [
                "--eye", ",".join(str(m + a / nearer) for m, a in zip(middle, arm)), "--target", ",".join(map(str, middle)),
                "--up", ",".join(map(str, camera["up"])), "--fov", camera["fov"]]
            (wide, columns), _ = draw(scan, path, size, look, "--point-size", f"{width}px")
            truth = erode(wide, columns, width // 2)
            (rest, _), figures = draw(scan, path, size, look, "--splat-size", 1)
            (motion, _), _ = draw(scan, path, size, look, "--splat-size", MOTION)
            at_rest, beyond = shares(rest, truth)
            found.append({"view": view, "nearer": nearer, "truth": count(truth), "rest": at_rest, "motion": shares(motion, truth)[0],
                          "beyond": beyond, "fragments": figures["fragments"]})
    return found


def main():
    parser = kit.options(__doc__, size="320x200")
    parser.add_argument("--views", type=int, default=26, help="number of directions; default 26")
    parser.add_argument("--jobs", type=int, default=2, help="pictures drawn at the same time; default 2")
    parser.add_argument("scans", nargs="+")
    given = parser.parse_args()
    results, rows = [], []
    directions = [f"d{i * 26 // given.views}" for i in range(given.views)]
    with concurrent.futures.ProcessPoolExecutor(given.jobs) as pool:
        for scan in given.scans:
            kit.say(f"{kit.name_of(scan)} ...")
            found = sum(pool.map(measure_view, [(scan, given.size, view) for view in directions]), [])
            for nearer in NEARNESS:
                views = [f for f in found if f["nearer"] == nearer and f["truth"] > 0]
                figures = {key: statistics.mean(f[key] for f in views) for key in ("rest", "motion", "beyond")}
                figures["least_rest"] = min(f["rest"] for f in views)
                figures["rest_below_motion"] = sum(f["rest"] < f["motion"] for f in views)
                figures["fragments"] = sum(f["fragments"] for f in views)
                results.append(kit.result("gaps", {"scan": kit.name_of(scan), "nearer": nearer, "size": given.size, "views": len(views)}, figures))
                rows.append([kit.name_of(scan), nearer, *(f"{100 * figures[key]:.2f}" for key in ("rest", "motion", "least_rest", "beyond")),
                             figures["rest_below_motion"], kit.short(figures["fragments"])])
    kit.table(["scan", "times nearer", "rest, %", "motion, %", "least at rest, %", "beyond, %", "views in which rest covers less", "fragments"], rows)
    kit.keep("gaps", results, given.out)


if __name__ == "__main__":
    main()
