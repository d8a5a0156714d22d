#!/usr/bin/env python3
"""One cloud and the programs that process clouds: seconds, CPU seconds, memory and bytes written, in one run.

usage: bench/cloud_peers.py [FILE.ply] [--scene SCENE] [--resolution N] [--spacing M] [--runs N] [--out FILE.json]

Scans a scene from the air (`stipple-lab scan --airborne`), or takes a binary PLY file of points. All programs read the same points: positions as floats, and
colours, as PLY or PCD. Those that are not installed are skipped; runs take turns, and figures are medians. Programs do different
amounts of work, which the table says. On Debian: apt-get install cloudcompare pcl-tools python3-open3d
"""
import array
import os
import pathlib
import shutil
import statistics
import struct
import subprocess
import tempfile
import time

import kit

TYPES = {"char": "b", "uchar": "B", "short": "h", "ushort": "H", "int": "i", "uint": "I", "float": "f", "double": "d",
         "int8": "b", "uint8": "B", "int16": "h", "uint16": "H", "int32": "i", "uint32": "I", "float32": "f", "float64": "d"}
OPEN3D = """
import sys, open3d
open3d.utility.set_verbosity_level(open3d.utility.VerbosityLevel.Error)
cloud = open3d.io.read_point_cloud(sys.argv[1])
if sys.argv[3] == "normals":
    cloud.estimate_normals(open3d.geometry.KDTreeSearchParamKNN(int(sys.argv[4])))
else:
    cloud = cloud.voxel_down_sample(float(sys.argv[4]))
open3d.io.write_point_cloud(sys.argv[2], cloud)
"""


def read_ply(path):
    """Yields the position and colour of each point of a binary PLY file; positions relative to the first point."""
    with open(path, "rb") as file:
        names, code, count, words = [], "<", 0, [b""]
        while words[0] != b"end_header":
            words = file.readline().split()
            if words[0] == b"element" and words[1] == b"vertex":
                count = int(words[2])
            elif words[0] == b"property":
                code += TYPES[words[1].decode()]
                names.append(words[2].decode())
        at = [names.index(name) for name in ("x", "y", "z", "red", "green", "blue")]
        row, origin = struct.Struct(code), None
        for values in row.iter_unpack(file.read(count * row.size)):
            origin = origin or [values[i] for i in at[:3]]
            yield *(values[i] - o for i, o in zip(at, origin)), *(values[i] for i in at[3:])


def write_inputs(source, folder):
    """The same points as PLY and PCD. @return how many, and the side of the square that each has of the ground"""
    ply, pcd, count = bytearray(), array.array("f"), 0
    as_ply, as_float = struct.Struct("<3f3B"), struct.Struct("<f")
    for x, y, z, r, g, b in read_ply(source):
        ply += as_ply.pack(x, y, z, r, g, b)
        pcd.extend((x, y, z, as_float.unpack(struct.pack("<I", r << 16 | g << 8 | b))[0]))
        count += 1
    sides = [max(pcd[k::4]) - min(pcd[k::4]) for k in (0, 1)]
    colors = "".join(f"property uchar {c}\n" for c in ("red", "green", "blue"))
    (folder / "cloud.ply").write_bytes(("ply\nformat binary_little_endian 1.0\n" f"element vertex {count}\n" +
                                        "".join(f"property float {c}\n" for c in "xyz") + colors + "end_header\n").encode() + ply)
    (folder / "cloud.pcd").write_bytes((f"VERSION 0.7\nFIELDS x y z rgb\nSIZE 4 4 4 4\nTYPE F F F F\nCOUNT 1 1 1 1\nWIDTH {count}\nHEIGHT 1\n"
                                        f"VIEWPOINT 0 0 0 1 0 0 0\nPOINTS {count}\nDATA binary\n").encode() + pcd.tobytes())
    return count, (sides[0] * sides[1] / count) ** 0.5


def programs(folder, spacing, neighbors, depth):
    """Name, work, command and output of each program that is installed."""
    ply, pcd, out = folder / "cloud.ply", folder / "cloud.pcd", folder / "out"
    cloudcompare = ("CloudCompare", "-SILENT", "-AUTO_SAVE", "OFF", "-C_EXPORT_FMT", "PLY", "-PLY_EXPORT_FMT", "BINARY_LE", "-NO_TIMESTAMP",
                    "-O", ply)
    save = ("-SAVE_CLOUDS", "FILE", out / "cc.ply")
    open3d = ("/usr/bin/python3", "-c", OPEN3D, ply, out / "open3d.ply")
    stipple = (kit.STIPPLE, "build", ply, "-o", out / "cloud.stip", "--fresh", "--quiet")
    known = [
        ("stipple build", "normals, order, all levels, all points", stipple),
        ("stipple build, one thread", "the same", (*stipple, "--threads", 1)),
        ("stipple build --method stochastic", "normals, octree, all points", (*stipple, "--method", "stochastic")),
        ("pcl_outofcore_process -gen_lod", "octree with levels, no normals", ("pcl_outofcore_process", "-depth", depth, "-gen_lod", pcd, out / "tree")),
        ("pcl_normal_estimation", f"normals of {neighbors} neighbours", ("pcl_normal_estimation", pcd, out / "pcl.pcd", "-k", neighbors)),
        ("CloudCompare -OCTREE_NORMALS", "octree, normals", (*cloudcompare, "-OCTREE_NORMALS", round(1.5 * spacing, 3), *save)),
        ("CloudCompare -SS SPATIAL", "one level: a least distance", (*cloudcompare, "-SS", "SPATIAL", spacing, *save)),
        ("pcl_voxel_grid", "one level: a mean per cube", ("pcl_voxel_grid", pcd, out / "voxel.pcd", "-leaf", ",".join(3 * [str(spacing)]))),
    ]
    known = [(name, work, command) for name, work, command in known if shutil.which(str(command[0]))]
    if subprocess.run([open3d[0], "-c", "import open3d"], capture_output=True).returncode == 0:
        known.append(("Open3D estimate_normals", f"normals of {neighbors} neighbours", (*open3d, "normals", neighbors)))
        known.append(("Open3D voxel_down_sample", "one level: a mean per cube", (*open3d, "level", spacing)))
    return known


def size_of(folder):
    return sum(file.stat().st_size for file in folder.rglob("*") if file.is_file())


def run(command, out):
    """Wall seconds, CPU seconds, peak resident bytes of the largest process, bytes written; None on failure."""
    shutil.rmtree(out, ignore_errors=True)
    out.mkdir()
    start = time.monotonic()
    with open(out.parent / "log", "wb") as log:
        child = subprocess.Popen([*map(str, command)], stdout=log, stderr=log, env={**os.environ, "QT_QPA_PLATFORM": "offscreen"})
        _, status, usage = os.wait4(child.pid, 0)
    seconds = time.monotonic() - start
    child.returncode = os.waitstatus_to_exitcode(status)
    written = size_of(out)
    if child.returncode != 0 or written == 0:
        kit.say((out.parent / "log").read_text(errors="replace")[-400:])
        return None
    return seconds, usage.ru_utime + usage.ru_stime, usage.ru_maxrss * 1024, written


def measure(given, source, folder):
    count, ground = write_inputs(source, folder)
    spacing = given.spacing or round(2 * ground, 3)
    known = programs(folder, spacing, given.neighbors, given.depth)
    measured, results, rows = {name: [] for name, _, _ in known}, [], []
    for _ in range(given.runs):
        for name, _, command in known:
            kit.say(f"{name} ...")
            figures = run(command, folder / "out")
            if figures:
                measured[name].append(figures)
    for name, work, _ in known:
        if not measured[name]:
            continue
        wall, cpu, memory, written = (statistics.median(values) for values in zip(*measured[name]))
        results.append(kit.result("cloud-peers", {"program": name, "work": work, "points": count, "runs": len(measured[name]), "spacing": spacing},
                                  {"seconds": round(wall, 3), "cpu_seconds": round(cpu, 3), "resident_bytes": int(memory),
                                   "written_bytes": int(written)}))
        rows.append([name, work, f"{wall:.2f}", f"{cpu:.2f}", f"{memory / 1e6:,.0f}", f"{written / count:.1f}"])
    print(f"{count:,} points, {spacing} m between those of one level, {(folder / 'cloud.ply').stat().st_size / count:.0f} bytes each as PLY\n")
    kit.table(["program", "work", "seconds", "CPU seconds", "MB at most", "bytes a point"], rows)
    return results


def main():
    parser = kit.options(__doc__)
    parser.add_argument("file", nargs="?", type=pathlib.Path, metavar="FILE.ply")
    parser.add_argument("--scene", default="scene:city")
    parser.add_argument("--resolution", type=int, default=2400, help="rays a turn; default 2400, which is 1.3 M points")
    parser.add_argument("--spacing", type=float, help="of the programs that make one level; default twice that of the points on the ground")
    parser.add_argument("--neighbors", type=int, default=16, help="of estimated normals; default 16")
    parser.add_argument("--depth", type=int, default=6, help="of PCL's octree; default 6")
    parser.add_argument("--runs", type=int, default=3)
    given = parser.parse_args()
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        source = given.file
        if source is None:
            source = folder / "scan.ply"
            kit.say(f"{given.scene} is scanned ...")
            kit.stipple("scan", given.scene, "--airborne", "--stations", 3, "--resolution", given.resolution, "-o", source)
        kit.keep("cloud-peers", measure(given, source, folder), given.out)


main()
