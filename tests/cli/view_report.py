#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""view_report.py REPORT [CONDITION [PID]]: evaluates a condition about the output of
`stipple view --report`; exits with 1 if it is false. With the process of the viewer: waits until
the condition is true; exits with 2 if it is false although the viewer has rested for a minute, so
that nothing will change by itself, and with 3 if the viewer has ended. Without a condition: prints
the camera as options of `stipple render`."""
import json
import math
import os
import sys
import time

PAUSE = 0.02  # s between looks at the file
RESTED = 60.0  # s at rest after which nothing will come


def near(a, b):
    return abs(a - b) < 1e-6


def distance(a, b):
    return math.dist(a, b)


def load(path):
    try:
        with open(path, encoding="utf-8") as file:
            return json.load(file)
    except (OSError, ValueError):
        return None


def names_of(r):
    """What a condition may refer to."""
    picture = r["picture"] or {"complete": False, "samples": 0, "width": 0, "height": 0}
    return {"r": r, "k": kept, "camera": r["camera"], "tools": r["tools"], "picture": picture, "near": near, "distance": distance}


def print_camera(r):
    camera, picture = r["camera"], names_of(r)["picture"]
    for name in "eye", "target", "up":
        print(f"--{name}=" + ",".join(repr(x) for x in camera[name]), end=" ")
    if camera["ortho_height"] > 0:
        print(f"--ortho={camera['ortho_height']!r}", end=" ")
    print(f"--fov={camera['fov']!r} --size={picture['width']}x{picture['height']}")


def has_ended(pid):
    try:
        with open(f"/proc/{pid}/stat") as file:
            return file.read().rpartition(")")[2].split()[0] == "Z"
    except OSError:
        return True


def holds(condition, r):
    try:
        return eval(condition, names_of(r))
    except (ArithmeticError, LookupError, TypeError):  # of a state in between
        return False


def wait(path, condition, pid):
    """Evaluates the condition whenever the file is another one."""
    seen, rested, rests = None, 0.0, False
    while True:
        ended = has_ended(pid)  # before the last look at its report
        try:
            status = os.stat(path)
            changed = (status.st_ino, status.st_mtime_ns)
        except OSError:
            changed = None
        if changed != seen:
            r = load(path)
            if r is not None and holds(condition, r):
                return 0
            seen, rests = changed, r is not None and r["rests"]
        if ended:
            return 3
        rested = rested + PAUSE if rests else 0.0
        if rested > RESTED:
            return 2
        time.sleep(PAUSE)


kept = (load("kept.json") if os.path.exists("kept.json") else None) or {}
if len(sys.argv) > 3:
    sys.exit(wait(*sys.argv[1:4]))
report = load(sys.argv[1])
if report is None:
    sys.exit(1)
if len(sys.argv) == 2:
    print_camera(report)
    sys.exit(0)
sys.exit(0 if eval(sys.argv[2], names_of(report)) else 1)
