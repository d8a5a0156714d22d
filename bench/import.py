#!/usr/bin/env python3
"""Import alone: millions of points per CPU second, for each format of scans, with one thread.

usage: bench/import.py [FILE...] [--scene SCENE] [--resolution N] [--runs N] [--out FILE.json]

Scans a scene (`stipple-lab scan`) as LAS, PLY, PTX and E57, and writes the points of the PTX file as XYZ, PTS and PCD. Files that are
named are measured too: compressed formats (LAZ, COPC) come from them. Each figure is the median of `stipple-lab bench import`. Its CPU
time includes the kernel's part, which maps the file and clears memory, and no build.
"""
import pathlib
import struct
import tempfile

import kit

HEADER = 10 # lines of a PTX file before its points


def columns(line):
    """x, y, z, intensity (0 to 1), and a colour."""
    x, y, z, intensity, r, g, b = line.split()
    return float(x), float(y), float(z), float(intensity), int(r), int(g), int(b)


def write_texts(lines, folder):
    with open(folder / "scan.xyz", "w", encoding="ascii") as xyz, open(folder / "scan.pts", "w", encoding="ascii") as pts:
        pts.write(f"{len(lines)}\n")
        for line in lines:
            x, y, z, intensity, *color = line.split()
            place, color = " ".join((x, y, z)), " ".join(color)
            xyz.write(f"{place} {color}\n")
            pts.write(f"{place} {int(4095 * float(intensity)) - 2048} {color}\n")


def write_pcd(lines, path):
    row = struct.Struct("<3fIf")
    with open(path, "wb") as pcd:
        pcd.write("# .PCD v0.7 - Point Cloud Data file format\nVERSION 0.7\nFIELDS x y z rgb intensity\nSIZE 4 4 4 4 4\n"
                  f"TYPE F F F U F\nCOUNT 1 1 1 1 1\nWIDTH {len(lines)}\nHEIGHT 1\nVIEWPOINT 0 0 0 1 0 0 0\nPOINTS {len(lines)}\nDATA binary\n".encode())
        for line in lines:
            x, y, z, intensity, r, g, b = columns(line)
            pcd.write(row.pack(x, y, z, r << 16 | g << 8 | b, intensity))


def write_all(scene, resolution, folder):
    files = [folder / f"scan.{ending}" for ending in ("las", "ply", "e57", "ptx")]
    for path in files:
        kit.say(f"{path.name} ...")
        kit.stipple("scan", scene, "--resolution", resolution, "-o", path)
    text = files[-1].read_text(encoding="ascii").splitlines()[HEADER:]
    lines = [line for line in text if not line.startswith("0 0 0")]
    write_texts(lines, folder)
    write_pcd(lines, folder / "scan.pcd")
    return [*files, folder / "scan.xyz", folder / "scan.pts", folder / "scan.pcd"]


def measure(paths, runs):
    results, rows = [], []
    for path in paths:
        measured = kit.bench("import", "--model", path, "--count", runs)["results"][0]
        figures = measured["figures"]
        results.append(measured)
        rows.append([pathlib.Path(path).name, f"{figures['points']:,}", f"{figures['bytes'] / figures['points']:.1f}",
                     f"{figures['points_per_cpu_second'] / 1e6:.1f}", f"{figures['bytes'] / figures['cpu_seconds'] / 1e6:.0f}"])
    kit.table(["file", "points", "bytes per point", "M points/s", "MB/s"], rows)
    return results


def main():
    parser = kit.options(__doc__)
    parser.add_argument("files", nargs="*", metavar="FILE")
    parser.add_argument("--scene", default="scene:city")
    parser.add_argument("--resolution", type=int, default=2400, help="rays per turn; default 2400, which is about 2 M points")
    parser.add_argument("--runs", type=int, default=7)
    given = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        paths = write_all(given.scene, given.resolution, pathlib.Path(folder))
        kit.keep("import", measure([*paths, *given.files], given.runs), given.out)


main()
