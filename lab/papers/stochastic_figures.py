#!/usr/bin/env python3
"""Figures 1 to 3 and 5 of Bhakar, Luo, Mudur 2004, of the vertices of a closed mesh.

usage: lab/papers/stochastic_figures.py MESH.ply

Writes stochastic-figures.jpg: leaves that are flat by two thresholds (Figure 1), the octree's leaves as cubes (2), normals that face
inwards, in red, before and after orientation (3: those of `blue`, whose signs are a guess, and those of `stochastic`); and
stochastic-sizes.jpg: the model at the sizes of Table 2, enlarged by whole factors (5).
"""
import bisect
import pathlib
import struct
import subprocess
import sys
import tempfile

import kit
import stochastic
import stochastic_normals

sys.path.insert(0, str(kit.ROOT / "scripts"))
import read_store  # noqa: E402

FLAT, BENT, GREY, RED = (130, 160, 200), (230, 140, 50), (190, 190, 190), (220, 30, 30)
SHRUNK = 0.9  # cubes, so that gaps show between them
CORNERS = [(i & 1, i >> 1 & 1, i >> 2) for i in range(8)]
FACES = ((1, 3, 7, 5), (2, 0, 4, 6), (2, 6, 7, 3), (0, 1, 5, 4), (4, 5, 7, 6), (0, 2, 3, 1))  # counterclockwise from outside


def build(cloud, out, method, *options):
    subprocess.run([kit.STIPPLE, "build", cloud, "-o", out, "--method", method, "--up", "y", *map(str, options), "--fresh", "--progress", "none"],
                   check=True, stdout=subprocess.DEVNULL)
    return out


def read_set(stored):
    """The leaves of a file's only set, its record, and normals and colours of the finest octave."""
    found = {}
    check = read_store.check_content

    def keep(t, record, block, name, column, place):
        if name in ("leaves", "normals", "colors"):
            found[name] = column  # the last octave stays
            found["record"] = record["set"] if name == "leaves" else record
        check(t, record, block, name, column, place)

    read_store.check_content = keep
    read_store.read_store(stored.read_bytes())
    read_store.check_content = check
    return found


def write_cloud(rows, colors, out):
    head = "".join(f"property float {name}\n" for name in ("x", "y", "z", "nx", "ny", "nz")) + "".join(
        f"property uchar {name}\n" for name in ("red", "green", "blue"))
    body = b"".join(struct.pack("<6f3B", *row, *color) for row, color in zip(rows, colors))
    out.write_bytes(f"ply\nformat binary_little_endian 1.0\nelement vertex {len(rows)}\n{head}end_header\n".encode() + body)


def picture(cloud, folder, name, size="480x400"):
    out = folder / f"{name}.png"
    stochastic.draw(build(cloud, folder / "picture.stip", "stochastic"), out, size, "--splat-size", "1")
    return out


def leaves_of(stored):
    found = read_set(stored)
    leaves = [(corner[:3], 1 << 16 - (corner[3] & 31), corner[8]) for corner in struct.iter_unpack("<3H2BI2b2B", found["leaves"])]
    return found["record"], leaves


def morton(corner):
    return sum((corner[k] >> bit & 1) << 3 * bit + k for bit in range(16) for k in range(3))


def flat_leaves(cloud, rows, threshold, folder):
    """Points of flat leaves and of others in two colours."""
    record, leaves = leaves_of(build(cloud, folder / "leaves.stip", "stochastic", "--leaf-flatness", threshold))
    codes = [morton(corner) for corner, _, _ in leaves]
    flat = [code == 0 or struct.unpack("<f", struct.pack("<I", code + 752 << 20))[0] <= threshold for _, _, code in leaves]
    colors = []
    for row in rows:
        at = [int((row[k] - record["origin"][k]) / record["step"] + 0.5) for k in range(3)]
        colors.append(FLAT if flat[max(bisect.bisect_right(codes, morton(at)) - 1, 0)] else BENT)
    colored = folder / "flat.ply"
    write_cloud(rows, colors, colored)
    return picture(colored, folder, f"flat-{threshold}"), len(leaves)


def cubes(cloud, folder):
    record, leaves = leaves_of(build(cloud, folder / "leaves.stip", "stochastic"))
    lines = []
    for corner, width, _ in leaves:
        low = [record["origin"][k] + record["step"] * (corner[k] + 0.5 * (1.0 - SHRUNK) * width) for k in range(3)]
        lines += ["v " + " ".join(f"{low[k] + SHRUNK * width * record['step'] * c[k]:.6f}" for k in range(3)) for c in CORNERS]
    for i in range(len(leaves)):
        lines += ["f " + " ".join(str(8 * i + 1 + c) for c in face) for face in FACES]
    (folder / "cubes.obj").write_text("\n".join(lines) + "\n", encoding="utf-8")
    out = folder / "cubes.png"
    stochastic.draw(build(folder / "cubes.obj", folder / "cubes.stip", "blue"), out, "480x400", "--reference")
    return out


def sides(numbered, rows, truth, method, folder):
    """Points whose normals face inwards in red: those of the finest octave, three of four."""
    found = read_set(build(numbered, folder / "sides.stip", method))
    count = len(found["normals"]) // 2
    codes, first = struct.unpack(f"<{2 * count}b", found["normals"]), len(found["colors"]) // 3 - count
    shown, colors = [], []
    for i in range(count):
        number = int.from_bytes(found["colors"][3 * (first + i):3 * (first + i) + 3], "little")
        normal = stochastic_normals.decode(codes[2 * i], codes[2 * i + 1])
        shown.append(rows[number])
        colors.append(RED if sum(a * b for a, b in zip(normal, truth[number])) < 0.0 else GREY)
    colored = folder / "sides.ply"
    write_cloud(shown, colors, colored)
    return picture(colored, folder, f"sides-{method}")


def main():
    parser = kit.options(__doc__)
    parser.add_argument("model", metavar="MESH.ply")
    given = parser.parse_args()
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        cloud, numbered = stochastic.cloud_of(given.model, folder), folder / "numbered.ply"
        truth = stochastic_normals.write_numbered(cloud, numbered)
        rows = list(struct.iter_unpack("<6f", cloud.read_bytes().split(b"end_header\n", 1)[1]))
        shown = []
        for threshold in (0.005, 0.001):
            path, count = flat_leaves(cloud, rows, threshold, folder)
            shown.append(f"{path}=flatness {threshold}: {count:,} leaves")
        shown += [f"{cubes(cloud, folder)}=leaves as cubes", f"{picture(cloud, folder, 'points')}=all points",
                  f"{sides(numbered, rows, truth, 'blue', folder)}=estimated normals: red faces inwards",
                  f"{sides(numbered, rows, truth, 'stochastic', folder)}=after orientation"]
        kit.say("sheets ...")
        subprocess.run([kit.STIPPLE, "sheet", *shown, "-o", given.images / "stochastic-figures.jpg", "--columns", "3", "--width", "320"],
                       check=True)
        shown, stored = [], build(cloud, folder / "model.stip", "stochastic")
        for side in stochastic.PAPER_SIZES:
            out = folder / f"size-{side}.png"
            count = stochastic.draw(stored, out, f"{side}x{side}", "--splat-size", "2")["splats"]
            shown.append(f"{out}={side} x {side}: {count:,} splats")
        subprocess.run([kit.STIPPLE, "sheet", *shown, "-o", given.images / "stochastic-sizes.jpg", "--columns", "5", "--width", "250"],
                       check=True)


if __name__ == "__main__":
    main()
