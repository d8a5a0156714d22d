#!/usr/bin/env python3
"""Says how old the figures of README.md and docs/performance.md are: for each row of a table with the
columns "command" (or "measured by") and "date", how many commits since that date touch the rooms that
the command measures.

usage: scripts/figure_ages.py [--root FOLDER] [--check]

--check prints only faults, and exits with 1 if there are any: a row without a command or a date, a date
in the future, or a command whose rooms this script does not know (ROOMS below).
"""
import argparse
import datetime
import pathlib
import re
import subprocess
import sys

DRAWING = ["src/draw", "src/raster", "src/select", "src/store"]
BUILDING = ["src/builder", "src/capture", "src/import", "src/lod", "src/order", "src/scene", "src/store"]
# What the figures of a command depend on: the first entry that the command begins with.
ROOMS = {
    "stipple-lab bench build": BUILDING,
    "stipple-lab bench order": ["src/order"],
    "stipple-lab bench splats": ["src/raster"],
    "stipple-lab bench triangles": ["src/raster"],
    "stipple-lab build": BUILDING,
    "stipple build": BUILDING,
    "bench/run order": ["src/order"],
    "bench/splats.py": ["src/raster"],
    "bench/cloud_peers.py": BUILDING,
    "bench/clouds.py": BUILDING,
    "bench/peers.sh": BUILDING + ["src/draw", "src/raster"],
    "bench/budget_views.py": DRAWING + ["src/lod"],
    "bench/controllers.py": DRAWING + ["src/lod"],
    "bench/gaps.py": DRAWING + ["src/lod"],
    "bench/jumps.py": DRAWING + ["src/lod"],
    "bench/motion.py": DRAWING + ["src/lod"],
    "bench/growth.py": DRAWING + ["src/lod"],
    "bench/popping.py": DRAWING + ["src/lod"],
    "bench/positions.py": DRAWING + ["src/lod"],
    "bench/quality.py": DRAWING + ["src/lod", "src/capture"],
    "bench/table3.py": DRAWING + ["src/lod", "src/capture"],
}
DOCUMENTS = ["README.md", "docs/performance.md"]


def cells_of(line):
    return [cell.strip() for cell in line.strip().strip("|").split("|")]


def rows_of(text):
    """Line number, name, command and date of each figure of the tables that have both columns."""
    heads = None
    for number, line in enumerate(text.splitlines(), 1):
        if not line.startswith("|"):
            heads = None
        elif heads is None:
            heads = [cell.lower() for cell in cells_of(line)]
        elif not re.fullmatch(r"[|\s:-]+", line):
            row = dict(zip(heads, cells_of(line)))
            command = row.get("command", row.get("measured by"))
            if command is not None and "date" in row and row.get("measured") != "not measured":
                yield number, cells_of(line)[0], command, row["date"]


def rooms_of(command):
    text = command.replace("`", "")
    return next((rooms for start, rooms in ROOMS.items() if text.startswith(start)), None)


def fault_of(command, date):
    if not command:
        return "has no command"
    if rooms_of(command) is None:
        return f"the rooms of {command} are not known"
    if not re.fullmatch(r"\d{4}-\d\d-\d\d", date):
        return "has no date"
    return "its date is in the future" if date > datetime.date.today().isoformat() else None


def commits_since(root, date, rooms):
    done = subprocess.run(["git", "-C", root, "log", "--oneline", "--no-merges", f"--since-as-filter={date}T23:59:59", "--", *rooms],
                          capture_output=True, text=True, check=False)
    return len(done.stdout.splitlines()) if done.returncode == 0 else None


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--root", type=pathlib.Path, default=pathlib.Path(__file__).resolve().parent.parent)
    parser.add_argument("--check", action="store_true", help="print only faults")
    given = parser.parse_args()
    faults = rows = 0
    for name in DOCUMENTS:
        for number, figure, command, date in rows_of((given.root / name).read_text(encoding="utf-8")):
            rows += 1
            fault = fault_of(command, date)
            if fault is not None:
                faults += 1
                print(f"{name}:{number}: {figure}: {fault}")
            elif not given.check:
                commits = commits_since(given.root, date, rooms_of(command))
                age = "no history" if commits is None else f"{commits} commits since"
                print(f"{name}:{number}: {figure}: {date}, {age}")
    if rows == 0:
        print("no table has figures")
    return 1 if faults > 0 or rows == 0 else 0


if __name__ == "__main__":
    sys.exit(main())
