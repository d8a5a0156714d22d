#!/usr/bin/env python3
"""Writes models that are difficult for splats: solid ones with many layers, and thin ones.

usage: quality_models.py FOLDER
"""
import math
import pathlib
import random
import sys


class Mesh:
    def __init__(self):
        self.points, self.faces = [], []

    def box(self, low, high, cells=1):
        """A box, each side cut into cells x cells squares."""
        for axis in range(3):
            for side in (0, 1):
                u, v = (axis + 1) % 3, (axis + 2) % 3
                first = len(self.points)
                for i in range(cells + 1):
                    for j in range(cells + 1):
                        p = [0.0] * 3
                        p[axis] = (low, high)[side][axis]
                        p[u] = low[u] + (high[u] - low[u]) * i / cells
                        p[v] = low[v] + (high[v] - low[v]) * j / cells
                        self.points.append(p)
                for i in range(cells):
                    for j in range(cells):
                        a, b = first + i * (cells + 1) + j, first + (i + 1) * (cells + 1) + j
                        corners = (a, b, b + 1, a + 1) if side else (a, a + 1, b + 1, b)
                        self.faces.append(corners)

    def pole(self, a, b, radius, sides=8):
        """A tube without ends."""
        along = [y - x for x, y in zip(a, b)]
        length = math.sqrt(sum(x * x for x in along))
        n = [x / length for x in along]
        axis = (1.0, 0.0, 0.0) if abs(n[0]) < 0.7 else (0.0, 1.0, 0.0)
        u = [n[1] * axis[2] - n[2] * axis[1], n[2] * axis[0] - n[0] * axis[2], n[0] * axis[1] - n[1] * axis[0]]
        scale = 1.0 / math.sqrt(sum(x * x for x in u))
        u = [x * scale for x in u]
        v = [n[1] * u[2] - n[2] * u[1], n[2] * u[0] - n[0] * u[2], n[0] * u[1] - n[1] * u[0]]
        steps = max(1, int(length / (8 * radius)))
        first = len(self.points)
        for k in range(steps + 1):
            for s in range(sides):
                c, d = radius * math.cos(2 * math.pi * s / sides), radius * math.sin(2 * math.pi * s / sides)
                self.points.append([a[i] + along[i] * k / steps + c * u[i] + d * v[i] for i in range(3)])
        for k in range(steps):
            for s in range(sides):
                p, q = first + k * sides + s, first + k * sides + (s + 1) % sides
                self.faces.append((p, q, q + sides, p + sides))

    def write(self, path):
        with open(path, "w") as file:
            for p in self.points:
                file.write("v %.6g %.6g %.6g\n" % tuple(p))
            for f in self.faces:
                file.write("f " + " ".join(str(i + 1) for i in f) + "\n")


def studs():
    """Plates with studs, stacked: each layer alone is full of holes."""
    mesh = Mesh()
    for layer in range(3):
        top = 0.5 * layer
        mesh.box((-2 + 0.3 * layer, top, -2 + 0.3 * layer), (2 - 0.3 * layer, top + 0.32, 2 - 0.3 * layer), 12)
        for i in range(16):
            for k in range(16):
                x, z = -1.9 + 0.25 * i, -1.9 + 0.25 * k
                if max(abs(x), abs(z)) < 1.85 - 0.3 * layer:
                    mesh.pole((x, top + 0.32, z), (x, top + 0.4, z), 0.075, 10)
                    mesh.box((x - 0.055, top + 0.38, z - 0.055), (x + 0.055, top + 0.4, z + 0.055))
    return mesh


def wall():
    mesh = Mesh()
    mesh.box((-2, 0, -0.02), (2, 2.5, 0.02), 24)
    return mesh


def lattice():
    mesh = Mesh()
    for i in range(21):
        x = -2 + 0.2 * i
        mesh.box((x - 0.02, 0, -0.02), (x + 0.02, 3, 0.02), 6)
    for k in range(16):
        mesh.box((-2, 0.2 * k - 0.02, -0.02), (2, 0.2 * k + 0.02, 0.02), 6)
    return mesh


def mast():
    """Four legs and their braces."""
    mesh = Mesh()
    for x in (-0.4, 0.4):
        for z in (-0.4, 0.4):
            mesh.pole((x, 0, z), (0.2 * x, 6, 0.2 * z), 0.05)
    for k in range(12):
        low, high = 1 - 0.8 * k / 12, 1 - 0.8 * (k + 1) / 12
        for s in range(4):
            a, b = (s, (s + 1) % 4)
            corner = lambda n, f: (0.4 * f * (1 if n in (0, 3) else -1), 0.4 * f * (1 if n < 2 else -1))
            p, q = corner(a, low), corner(b, high)
            mesh.pole((p[0], 0.5 * k, p[1]), (q[0], 0.5 * (k + 1), q[1]), 0.025, 6)
    return mesh


def wire():
    """Three cables between two posts."""
    mesh = Mesh()
    for x in (-3, 3):
        mesh.pole((x, 0, 0), (x, 3, 0), 0.08)
    for z in (-0.3, 0.0, 0.3):
        last = None
        for k in range(25):
            x = -3 + 0.25 * k
            p = (x, 2.4 + 0.05 * x * x, z)
            if last is not None:
                mesh.pole(last, p, 0.02, 6)
            last = p
    return mesh


def tree():
    mesh = Mesh()
    mesh.pole((0, 0, 0), (0, 2.6, 0), 0.09)
    rng = random.Random(5)
    for _ in range(7000):
        while True:
            p = [rng.uniform(-1, 1) for _ in range(3)]
            if sum(x * x for x in p) < 1:
                break
        center = (1.3 * p[0], 3.2 + 1.5 * p[1], 1.3 * p[2])
        a = [rng.gauss(0, 0.04) for _ in range(3)]
        b = [rng.gauss(0, 0.04) for _ in range(3)]
        first = len(mesh.points)
        for s, t in ((-1, -1), (1, -1), (1, 1), (-1, 1)):
            mesh.points.append([center[i] + s * a[i] + t * b[i] for i in range(3)])
        mesh.faces.append((first, first + 1, first + 2, first + 3))
    return mesh


def house():
    """Walls, and a roof of two thin sheets over rafters."""
    mesh = Mesh()
    mesh.box((-3, 0, -2), (3, 2.4, 2), 16)

    def sheet(x0, x1, rise0, rise1, z0, z1, thick, cells):
        first = len(mesh.points)
        for i in range(cells + 1):
            for k in range(cells + 1):
                for t in (0, thick):
                    s = i / cells
                    mesh.points.append([x0 + (x1 - x0) * s, rise0 + (rise1 - rise0) * s + t, z0 + (z1 - z0) * k / cells])
        at = lambda i, k, t: first + 2 * (i * (cells + 1) + k) + t
        for i in range(cells):
            for k in range(cells):
                for t in (0, 1):
                    mesh.faces.append((at(i, k, t), at(i + 1, k, t), at(i + 1, k + 1, t), at(i, k + 1, t)))
        for i in range(cells):
            for k in (0, cells):
                mesh.faces.append((at(i, k, 0), at(i + 1, k, 0), at(i + 1, k, 1), at(i, k, 1)))
                mesh.faces.append((at(k, i, 0), at(k, i + 1, 0), at(k, i + 1, 1), at(k, i, 1)))

    for side in (-1, 1):
        sheet(side * 3.5, 0, 2.3, 4.5, -2.4, 2.4, 0.05, 20)
        for k in range(12):
            z = -2.3 + 0.41 * k
            sheet(side * 3.4, 0, 2.15, 4.3, z, z + 0.08, 0.18, 4)
    return mesh


def cloud(path):
    """A field of points on a plane with hills, with two thirds of them duplicated."""
    rng = random.Random(2)
    points = []
    for i in range(200):
        for k in range(200):
            x, z = i / 100 - 1, k / 100 - 1
            y = 0.1 * math.sin(5 * x) * math.cos(4 * z)
            points += [(x, y, z)] * (1 + (rng.random() < 0.66))
    with open(path, "w") as file:
        file.write("ply\nformat ascii 1.0\nelement vertex %d\nproperty float x\nproperty float y\nproperty float z\n"
                   "end_header\n" % len(points))
        for p in points:
            file.write("%.6g %.6g %.6g\n" % p)


def rubble():
    """Bricks heaped at random: surfaces are short, and the heap is opaque."""
    mesh, draw = Mesh(), random.Random(7)
    for _ in range(3000):
        low = [draw.uniform(-1, 1), draw.uniform(-0.1, 0.1), draw.uniform(-1, 1)]
        size = [draw.uniform(0.02, 0.12) for _ in range(3)]
        mesh.box(low, [x + s for x, s in zip(low, size)], 3)
    return mesh


def main():
    folder = pathlib.Path(sys.argv[1])
    folder.mkdir(parents=True, exist_ok=True)
    for make in (studs, wall, lattice, mast, wire, tree, house, rubble):
        make().write(folder / f"{make.__name__}.obj")
    cloud(folder / "cloud.ply")


main()
