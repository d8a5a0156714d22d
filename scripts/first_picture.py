#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Draws a .stip file from the few byte ranges that its first picture needs, and counts them.

    first_picture.py FILE.stip -o PICTURE.ppm [--surfels N] [--size WxH]

A network reader fetches ranges like these: header and section table, the directory pages that lead
to the root's surfels, and the first octaves of these. Prints the counts as JSON. Like
read_store.py, it uses only docs/format.md.
"""
import argparse
import json
import math
import struct
import sys
import zlib

from read_store import NONE, RECORDS, need, unpack, unpack_octave

PAGE = 16384
SECTION = {name: (kind, struct.calcsize("<" + layout), "<" + layout, names)
           for kind, (name, layout, names) in RECORDS.items()}


class Ranges:
    """A file read by ranges; bytes already read cost nothing."""

    def __init__(self, file):
        self.file, self.known = file, {}
        self.ranges = self.bytes = 0

    def read(self, offset, size):
        if (offset, size) not in self.known:
            self.file.seek(offset)
            self.known[offset, size] = self.file.read(size)
            self.ranges, self.bytes = self.ranges + 1, self.bytes + size
        need(len(self.known[offset, size]) == size, f"ends before {offset + size}")
        return self.known[offset, size]


class Directory:
    """Header, section table, and records by index, each from its page."""

    def __init__(self, ranges):
        self.ranges = ranges
        header = ranges.read(0, 128)
        need(header[:4] == b"\x89STP" and zlib.crc32(header[:124]) == struct.unpack_from("<I", header, 124)[0], "header")
        count, crc, self.root = struct.unpack_from("<3I", header, 32)
        table = ranges.read(128, 40 * count)
        need(zlib.crc32(table) == crc, "section table")
        self.sections, self.first_pages, pages = {}, {}, 0
        for kind, flags, offset, size, records, record_size, crc in struct.iter_unpack("<IIQQQII", table):
            self.sections[kind] = (flags, offset, size, records, record_size, crc)
            self.first_pages[kind] = pages
            pages += 0 if flags & 2 or kind == 21 else -(-size // PAGE)

    def packed_page(self, kind, page):
        _, offset, _, records, record_size, crc = self.sections[kind]
        need(0 < record_size <= 65536, f"section {kind}: record size")
        page_bytes = 65536 // record_size * record_size
        length = records * record_size
        table = self.ranges.read(offset, 8 * -(-length // page_bytes))
        need(zlib.crc32(table) == crc, f"section {kind}: table of pages")
        pages = list(struct.iter_unpack("<2I", table))
        size, crc = pages[page]
        stored = self.ranges.read(offset + len(table) + sum(s for s, _ in pages[:page]), size)
        need(zlib.crc32(stored) == crc, f"section {kind}: page {page}")
        return unpack(stored, min(page_bytes, length - page * page_bytes), f"section {kind}: page {page}")

    def plain_page(self, kind, page):
        _, offset, size, _, _, crc = self.sections[kind]
        if kind == 21 or size <= PAGE:
            content = self.ranges.read(offset, size)
            need(zlib.crc32(content) == crc, f"section {kind}: checksum")
            return content[page * PAGE:(page + 1) * PAGE]
        content = self.ranges.read(offset + page * PAGE, min(PAGE, size - page * PAGE))
        at = 4 * (self.first_pages[kind] + page)
        crc = (self.plain_page(21, at // PAGE) + b"\0" * 4)[at % PAGE:at % PAGE + 4]
        need(zlib.crc32(content) == struct.unpack("<I", crc)[0], f"section {kind}: page {page}")
        return content

    def record(self, name, index):
        """A record as a dictionary of its fields; arrays become lists."""
        kind, known, layout, names = SECTION[name]
        flags, _, _, count, record_size, _ = self.sections[kind]
        need(index < count, f"{name} {index} does not exist")
        if flags & 2:
            each = 65536 // record_size
            bytes_ = self.packed_page(kind, index // each)[index % each * record_size:]
        else:
            at = index * record_size
            bytes_ = b"".join(self.plain_page(kind, p) for p in range(at // PAGE, (at + record_size - 1) // PAGE + 1))
            bytes_ = bytes_[at % PAGE:]
        values, fields, at = struct.unpack_from(layout, bytes_[:known]), {}, 0
        for field in names.split():
            field, _, many = field.partition(":")
            many = int(many) if many.isdigit() else 0
            fields[field] = list(values[at:at + many]) if many else values[at]
            at += max(many, 1)
        return fields


def find_set(directory):
    """The root's box, and its splat set with its octaves and breakpoints."""
    need(directory.root != NONE, "the scene is empty")
    root = directory.record("nodes", directory.root)
    need(root["surfels"] != NONE, "the root has no surfels: the whole scene is a few triangles")
    found = directory.record("surfels", root["surfels"])
    octaves = [directory.record("octaves", found["first_octave"] + i) for i in range(found["octave_count"])]
    points = [directory.record("breakpoints", found["first_breakpoint"] + i) for i in range(found["breakpoint_count"])]
    need(found["count"] > 0, "the root has no surfels")
    # the root's set belongs to the first method; files without a method table use `blue`, without
    # options
    found["method_columns"] = directory.record("methods", 0)["columns"] if 35 in directory.sections else 0
    need(octaves and octaves[-1]["end"] == found["count"], "octaves")
    found["octave_ends"] = [octave["end"] for octave in octaves]
    found["blocks"] = [octave["block"] for octave in octaves]
    found["breakpoints"] = [(point["count"], point["radius"]) for point in points]
    found["records"] = [directory.record("blocks", block) for block in found["blocks"]]
    return root, found


def read_surfels(ranges, found, count):
    """Positions, normals and colours of the first `count` surfels, from the chunks that hold them."""
    positions, normals, last = [], [], next(k for k, end in enumerate(found["octave_ends"]) if end >= count)
    colors = b""
    for k in range(last + 1):
        block = found["records"][k]
        end, first = found["octave_ends"][k], ([0] + found["octave_ends"])[k]
        stored = ranges.read(block["offset"], block["size"])
        if block["encoding"] in (1, 2, 3):
            stored = unpack_octave(found, {**block, "octave": k}, stored, f"octave {k}")
        else:
            need(zlib.crc32(stored) == block["crc"], f"octave {k}: checksum")
        n = end - first
        positions += struct.iter_unpack("<3H", stored[:6 * n])
        normals += struct.iter_unpack("<2b", stored[6 * n:8 * n])
        flat = found["method_columns"] & 4
        colors = (colors if flat else b"") + stored[9 * n:9 * n + 3 * (n if flat else end)]
    step, origin = found["step"], found["origin"]
    places = [[o + step * v for o, v in zip(origin, position)] for position in positions[:count]]
    return places, [decode_normal(n) for n in normals[:count]], [colors[3 * i:3 * i + 3] for i in range(count)]


def decode_normal(value):
    x, y = max(value[0] / 127, -1.0), max(value[1] / 127, -1.0)
    z = 1.0 - abs(x) - abs(y)
    if z < 0.0:
        x, y = math.copysign(1.0 - abs(y), x), math.copysign(1.0 - abs(x), y)
    length = math.sqrt(x * x + y * y + z * z)
    return x / length, y / length, z / length


def draw(box, surfels, radius, width, height):
    """Draws squares as large as the disks, nearest first, from a corner above the box, with simple lighting. @return RGB bytes"""
    low, high = box
    center = [(a + b) / 2 for a, b in zip(low, high)]
    reach = math.dist(low, high) / 2 or 1.0
    back, right = (0.577, 0.577, 0.577), (0.707, 0.0, -0.707)
    up = (-0.408, 0.816, -0.408)
    scale = 0.5 * min(width, height) / reach * 1.4
    half = max(0, round(radius * scale))
    picture, depths = bytearray(b"\xe8" * (3 * width * height)), [-math.inf] * (width * height)
    for place, normal, color in zip(*surfels):
        offset = [a - b for a, b in zip(place, center)]
        x = round(width / 2 + scale * sum(a * b for a, b in zip(offset, right)))
        y = round(height / 2 - scale * sum(a * b for a, b in zip(offset, up)))
        depth = sum(a * b for a, b in zip(offset, back))
        light = 0.45 + 0.55 * abs(0.3 * normal[0] + 0.9 * normal[1] + 0.3 * normal[2])
        shade = bytes(min(255, round(light * c)) for c in color)
        for row in range(max(0, y - half), min(height, y + half + 1)):
            for at in range(row * width + max(0, x - half), row * width + min(width, x + half + 1)):
                if depth > depths[at]:
                    depths[at] = depth
                    picture[3 * at:3 * at + 3] = shade
    return bytes(picture)


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("file")
    parser.add_argument("-o", dest="output", required=True, metavar="PICTURE.ppm")
    parser.add_argument("--surfels", type=int, default=16000, metavar="N", help="maximum number of surfels (default: 16000)")
    parser.add_argument("--size", default="960x540", metavar="WxH")
    options = parser.parse_args()
    try:
        width, height = map(int, options.size.split("x"))
        with open(options.file, "rb") as file:
            ranges = Ranges(file)
            directory = Directory(ranges)
            root, found = find_set(directory)
            spent = ranges.bytes
            count = min(max(options.surfels, 1), found["count"])
            surfels = read_surfels(ranges, found, count)
            radius = next((r for n, r in reversed(found["breakpoints"]) if n <= count), found["candidate_radius"])
            box = root["bounds_min"], root["bounds_max"]
            file_bytes = file.seek(0, 2)
        with open(options.output, "wb") as output:
            output.write(b"P6 %d %d 255\n" % (width, height) + draw(box, surfels, radius, width, height))
    except (OSError, ValueError, IndexError, KeyError, ArithmeticError, StopIteration, struct.error) as fault:
        sys.exit(f"{options.file}: {fault}")
    print(json.dumps({"surfels": count, "bytes": ranges.bytes, "directory_bytes": spent, "ranges": ranges.ranges,
                      "file_bytes": file_bytes}))


if __name__ == "__main__":
    main()
