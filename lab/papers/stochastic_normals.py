#!/usr/bin/env python3
"""Normals that method `stochastic` estimates for clouds without normals: how many are correct, and how many face inwards.

usage: lab/papers/stochastic_normals.py [--neighbors K1,K1...] MESH.ply...

Takes the vertices of closed meshes, with their number as colour instead of a normal, builds a set of them with `--normal-neighbors K1`,
and compares the normals in the file with those of the mesh's vertices. Prints the share within 10 degrees, regardless of their sign, and
of those, the share that faces inwards; of the others which side is outside is not known well.
"""
import array
import pathlib
import struct
import subprocess
import sys
import tempfile

import kit
import stochastic

sys.path.insert(0, str(kit.ROOT / "scripts"))
import read_store  # noqa: E402

COSINE = 0.98480775  # of 10 degrees


def write_numbered(cloud, out):
    """The points of a cloud of `stochastic.cloud_of`, coloured by their number. @return their normals"""
    head, body = cloud.read_bytes().split(b"end_header\n", 1)
    rows = list(struct.iter_unpack("<6f", body))
    columns = "".join(f"property float {name}\n" for name in "xyz") + "".join(f"property uchar {name}\n" for name in ("red", "green", "blue"))
    points = b"".join(struct.pack("<3f3B", *row[:3], i & 255, i >> 8 & 255, i >> 16) for i, row in enumerate(rows))
    out.write_bytes(f"ply\nformat binary_little_endian 1.0\nelement vertex {len(rows)}\n{columns}end_header\n".encode() + points)
    return [row[3:] for row in rows]


def decode(x, y):
    """An octahedral normal, of unit length."""
    x, y = max(x / 127.0, -1.0), max(y / 127.0, -1.0)
    z = 1.0 - abs(x) - abs(y)
    if z < 0.0:
        x, y = (1.0 - abs(y)) * (1.0 if x >= 0 else -1.0), (1.0 - abs(x)) * (1.0 if y >= 0 else -1.0)
    length = (x * x + y * y + z * z) ** 0.5
    return x / length, y / length, z / length


def read_normals(stored):
    """Number of each splat's point, and its normal, of all sets."""
    columns = []
    check = read_store.check_content

    def keep(t, record, block, name, column, place):
        if block["kind"] == 4 and name in ("normals", "colors"):
            columns.append((name, column))
        check(t, record, block, name, column, place)

    read_store.check_content = keep
    read_store.read_store(stored.read_bytes())
    read_store.check_content = check
    for (_, normals), (_, colors) in zip(columns[::2], columns[1::2]):
        codes = array.array("b", normals)
        for i in range(len(codes) // 2):
            yield int.from_bytes(colors[3 * i:3 * i + 3], "little"), decode(codes[2 * i], codes[2 * i + 1])


def measure(model, neighbors, folder):
    cloud, numbered, stored = stochastic.cloud_of(model, folder), folder / "numbered.ply", folder / "numbered.stip"
    truth = write_numbered(cloud, numbered)
    subprocess.run([kit.STIPPLE, "build", numbered, "-o", stored, "--method", "stochastic", "--up", "y", "--normal-neighbors", neighbors,
                    "--fresh", "--progress", "none"], check=True, stdout=subprocess.DEVNULL)
    count = near = inwards = all_inwards = 0
    for number, normal in read_normals(stored):
        cosine = sum(a * b for a, b in zip(normal, truth[number]))
        count += 1
        near += abs(cosine) > COSINE
        inwards += cosine < -COSINE
        all_inwards += cosine < 0.0
    return {"splats": count, "within_10_degrees": near / count, "inwards_of_those": inwards / max(near, 1), "inwards": all_inwards / count}


def main():
    parser = kit.options(__doc__)
    parser.add_argument("models", nargs="+", metavar="MESH.ply")
    parser.add_argument("--neighbors", default="8,20,50")
    given = parser.parse_args()
    results, rows = [], []
    with tempfile.TemporaryDirectory() as name:
        for model in given.models:
            for neighbors in given.neighbors.split(","):
                figures = measure(model, neighbors, pathlib.Path(name))
                results.append(kit.result("stochastic-normals", {"scene": pathlib.Path(model).stem, "neighbors": int(neighbors)}, figures))
                rows.append([pathlib.Path(model).stem, neighbors, *(f"{100 * figures[key]:.2f} %" for key in
                                                                      ("within_10_degrees", "inwards_of_those", "inwards"))])
    kit.table(["model", "K1", "within 10 degrees", "inwards, of these", "inwards, of all"], rows)
    kit.keep("stochastic-normals", results, given.out)


if __name__ == "__main__":
    main()
