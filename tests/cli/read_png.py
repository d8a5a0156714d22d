# SPDX-License-Identifier: MIT
"""Reads the PNG files that the executable writes: 8 bits per channel, RGBA."""
import struct
import zlib


def read_png(path):
    """Rows of pixels: bytes of RGBA."""
    data, pixels, at = open(path, "rb").read(), b"", 8
    while at < len(data):
        size, kind = struct.unpack(">I4s", data[at:at + 8])
        body = data[at + 8:at + 8 + size]
        if kind == b"IHDR":
            width, height, depth, color = struct.unpack(">IIBB", body[:10])
            assert (depth, color) == (8, 6), (path, depth, color)
        pixels += body if kind == b"IDAT" else b""
        at += size + 12
    line, raw = 4 * width, zlib.decompress(pixels)
    rows, before = [], bytes(line)
    for y in range(height):
        kind, row = raw[(line + 1) * y], bytearray(raw[(line + 1) * y + 1:(line + 1) * (y + 1)])
        for i in range(line):
            a, b, c = (row[i - 4] if i >= 4 else 0), before[i], (before[i - 4] if i >= 4 else 0)
            nearest = min((abs(b - c), 0, a), (abs(a - c), 1, b), (abs(a + b - 2 * c), 2, c))[2]
            row[i] = (row[i] + (0, a, b, (a + b) // 2, nearest)[kind]) & 255
        rows.append(before := bytes(row))
    return rows


def covered(path):
    """The margins around what is not transparent, as shares of width and height: left, right, top, bottom."""
    rows = read_png(path)
    height, width = len(rows), len(rows[0]) // 4
    columns = [x for x in range(width) if any(row[4 * x + 3] for row in rows)]
    lines = [y for y in range(height) if any(rows[y][3::4])]
    return columns[0] / width, 1 - (columns[-1] + 1) / width, lines[0] / height, 1 - (lines[-1] + 1) / height
