# SPDX-License-Identifier: MIT
"""Reads the output of stipple-lab scan, each format according to its specification: scan_files.py NAME REPORT.json [air]
checks that NAME.las, .ptx, .ply and .e57 hold the same points, and that REPORT describes them."""
import json
import re
import struct
import sys
import xml.etree.ElementTree as xml


def read_las(path):
    data = open(path, "rb").read()
    assert data[:4] == b"LASF" and data[24:26] == b"\1\4", "not LAS 1.4"
    header, start, vlrs = struct.unpack_from("<HII", data, 94)
    kind, size = struct.unpack_from("<BH", data, 104)
    assert (header, vlrs, kind, size) == (375, 1, 7, 36), (header, vlrs, kind, size)
    user, record, length = struct.unpack_from("<16sHH", data, 377)
    assert (user.rstrip(b"\0"), record, start) == (b"LASF_Projection", 2112, 375 + 54 + length), user
    assert data[429:start].endswith(b"]]\0") and b'UNIT["metre",1]' in data[429:start], data[429:start]
    count, first = struct.unpack_from("<QQ", data, 247)
    assert count == first and len(data) == start + count * size, (count, first, len(data))
    assert struct.unpack_from("<H", data, 6)[0] & 16, "formats above 5 ask for the WKT bit"
    scale, offset = struct.unpack_from("<3d", data, 131), struct.unpack_from("<3d", data, 155)
    box = struct.unpack_from("<6d", data, 179)
    points = []
    for i in range(count):
        x, y, z, intensity, returns, _, _, _, angle, source, time, r, g, b = struct.unpack_from(
            "<3iHBBBBhHd3H", data, start + i * size)
        assert returns == 0x11 and -10000 <= angle <= 15000 and r % 257 == g % 257 == b % 257 == 0
        place = tuple(v * s + o for v, s, o in zip((x, y, z), scale, offset))
        points.append((source, time, place, (r // 257, g // 257, b // 257), intensity, angle * 0.006))
    for k in range(3):
        values = [p[2][k] for p in points]
        assert abs(box[2 * k] - max(values)) < 1e-6 and abs(box[2 * k + 1] - min(values)) < 1e-6, "bounds"
    return points


def read_ply(path):
    data = open(path, "rb").read()
    end = data.index(b"end_header\n") + 11
    lines = data[:end].decode().split("\n")
    assert lines[:2] == ["ply", "format binary_little_endian 1.0"], lines[:2]
    count = next(int(line.split()[2]) for line in lines if line.startswith("element vertex "))
    kinds = {"double": "d", "float": "f", "uchar": "B", "ushort": "H", "uint": "I"}
    columns = [line.split()[1:] for line in lines if line.startswith("property ")]
    record = struct.Struct("<" + "".join(kinds[kind] for kind, _ in columns))
    assert len(data) == end + count * record.size, (len(data), end, count, record.size)
    names = [name for _, name in columns]
    return [dict(zip(names, row)) for row in record.iter_unpack(data[end:])]


def read_ptx(path):
    lines, at, stations = open(path).read().split("\n"), 0, []
    while at + 1 < len(lines):
        columns, rows = int(lines[at]), int(lines[at + 1])
        pose = [[float(v) for v in line.split()] for line in lines[at + 2:at + 10]]
        assert pose[1:4] == [[1, 0, 0], [0, 1, 0], [0, 0, 1]] and pose[7] == pose[0] + [1], pose
        cells = [[float(v) for v in line.split()] for line in lines[at + 10:at + 10 + columns * rows]]
        stations.append((columns, rows, pose[0], cells))
        at += 10 + columns * rows
    return stations


def crc32c(data):
    crc = 0xFFFFFFFF
    for byte in data:
        crc ^= byte
        for _ in range(8):
            crc = crc >> 1 ^ (0x82F63B78 if crc & 1 else 0)
    return crc ^ 0xFFFFFFFF


def read_e57(path):
    raw = open(path, "rb").read()
    assert crc32c(b"123456789") == 0xE3069283
    assert len(raw) % 1024 == 0
    for page in range(0, len(raw), 1024):
        assert page > 64 * 1024 and page % 7168 or crc32c(raw[page:page + 1020]) == struct.unpack_from(
            ">I", raw, page + 1020)[0], f"checksum of page {page // 1024}"
    data = b"".join(raw[i:i + 1020] for i in range(0, len(raw), 1024))
    magic, major, minor, length, at, size, page = struct.unpack_from("<8sIIQQQQ", data)
    assert (magic, major, minor, length, page) == (b"ASTM-E57", 1, 0, len(raw), 1024)
    logical = lambda physical: physical // 1024 * 1020 + physical % 1024
    root = xml.fromstring(data[logical(at):logical(at) + size])
    space = {"e": "http://www.astm.org/COMMIT/E57/2010-e57-v1.0"}
    stations = []
    for scan in root.findall("e:data3D/e:vectorChild", space):
        origin = [float(scan.find(f"e:pose/e:translation/e:{k}", space).text) for k in "xyz"]
        points = scan.find("e:points", space)
        count, section = int(points.get("recordCount")), logical(int(points.get("fileOffset")))
        kind, long, begin, index = struct.unpack_from("<B7xQQQ", data, section)
        assert kind == 1 and long % 4 == 0 and section < logical(begin) <= logical(index) < section + long
        streams, place = [b""] * 9, logical(begin)
        while place < logical(index):
            kind, _, less, many = struct.unpack_from("<BBHH", data, place)
            assert kind == 1 and many == 9 and (less + 1) % 4 == 0, (kind, many, less)
            sizes, packet = struct.unpack_from("<9H", data, place + 6), place + 24
            for k, size in enumerate(sizes):
                streams[k] += data[packet:packet + size]
                packet += size
            place += less + 1
        assert place == logical(index)
        columns = [struct.unpack(f"<{count}{kind}", s) for kind, s in zip("ffffBBBHH", streams)]
        bounds = {c.tag.split("}")[1]: float(c.text) for c in scan.find("e:cartesianBounds", space)}
        for k, axis in enumerate("xyz"):
            assert bounds[axis + "Minimum"] == min(columns[k]) and bounds[axis + "Maximum"] == max(columns[k])
        stations.append((origin, list(zip(*columns))))
    return stations


def main():
    name, report = sys.argv[1], json.load(open(sys.argv[2]))
    las, ply, ptx, e57 = (read(name + end) for read, end in (
        (read_las, ".las"), (read_ply, ".ply"), (read_ptx, ".ptx"), (read_e57, ".e57")))
    columns, rows = report["columns"], report["rows"]
    lowest, span = (-30, 60) if len(sys.argv) > 3 else (-60, 150)
    count, stations = report["points"], report["stations"]
    assert len(las) == len(ply) == count > 200 and len(ptx) == len(e57) == stations
    assert count + report["misses"] == columns * rows * stations
    assert sum(len(s[1]) for s in e57) == count
    flat = [(i, origin, row) for i, (origin, rows_) in enumerate(e57) for row in rows_]
    for a, b, (station, origin, c) in zip(las, ply, flat):
        place = (b["x"], b["y"], b["z"])
        assert a[0] == b["point_source_id"] == station + 1 and a[1] == b["gps_time"]
        ray = int(a[1]) - station * columns * rows
        assert (c[8], c[7]) == divmod(ray, rows), "row and column"
        assert max(abs(u - v) for u, v in zip(a[2], place)) < 0.0005001, "LAS"
        assert max(abs(u + v - w) for u, v, w in zip(c[:3], origin, place)) < 1e-5, "E57"
        cell = ptx[station][3][ray]
        assert max(abs(u + v - w) for u, v, w in zip(cell[:3], ptx[station][2], place)) < 2e-6, "PTX"
        color = (b["red"], b["green"], b["blue"])
        assert a[3] == color == c[4:7] == tuple(int(v) for v in cell[4:7]), "colour"
        assert a[4] == b["intensity"] and abs(a[4] / 65535 - c[3]) < 1e-6 and abs(c[3] - cell[3]) < 1e-6
        assert abs(a[5] - (span * (ray % rows + 0.5) / rows + lowest)) < 0.0031, "scan angle"
    for (width, height, place, cells), wanted, scan in zip(ptx, report["station_positions"], e57):
        assert (width, height) == (columns, rows)
        assert max(abs(u - v) for u, v in zip(place, wanted)) < 1e-6 and scan[0] == wanted
        assert sum(any(cell[:3]) for cell in cells) == len(scan[1])
        assert all(cell == [0] * 7 for cell in cells if not any(cell[:3]))
    for k, axis in enumerate("xyz"):
        values = [p[axis] for p in ply]
        assert abs(report["bounds"]["min"][k] - min(values)) < 1e-6
        assert abs(report["bounds"]["max"][k] - max(values)) < 1e-6
    assert re.fullmatch(r"[0-9.e+-]+", str(report["rays_per_second"])) and report["rays_per_second"] > 0


if __name__ == "__main__":
    main()
