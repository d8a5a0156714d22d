#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""view_report.py REPORT CONDITION [rests]: evaluates a condition about the output of
`stipple view --report`; exits with 1 if it is false. With `rests`: exits with 2 if it is false and
the viewer rests, so that nothing will change by itself. Without a condition: prints the camera as
options of `stipple render`."""
import json
import math
import os
import sys


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


r = load(sys.argv[1])
if r is None:
    sys.exit(1)
k = load("kept.json") if os.path.exists("kept.json") else {}
camera = r["camera"]
tools = r["tools"]
picture = r["picture"] or {"complete": False, "samples": 0, "width": 0, "height": 0}
if len(sys.argv) == 2:
    for name in "eye", "target", "up":
        print(f"--{name}=" + ",".join(repr(x) for x in camera[name]), end=" ")
    if camera["ortho_height"] > 0:
        print(f"--ortho={camera['ortho_height']!r}", end=" ")
    print(f"--fov={camera['fov']!r} --size={picture['width']}x{picture['height']}")
    sys.exit(0)
if eval(sys.argv[2]):
    sys.exit(0)
sys.exit(2 if len(sys.argv) > 3 and r["rests"] else 1)
