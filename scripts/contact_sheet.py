#!/usr/bin/env python3
"""Arranges PNG files (8-bit RGB or RGBA, as stipple writes them) on one sheet, for the documents.

usage: contact_sheet.py OUT.png COLUMNS[/N] IN.png...

Cells are as large as the largest picture. Smaller pictures are enlarged by whole factors, without
smoothing. IN.png@X,Y,W,H uses a part of the picture; =IN.png keeps its size. /N shrinks pictures
first: each pixel is the mean of N x N.
"""
import struct
import sys
import zlib

BACKGROUND = bytes((255, 255, 255))
GAP = 4


def read_png(path):
    data = open(path, "rb").read()
    if data[:8] != b"\x89PNG\r\n\x1a\n":
        sys.exit(f"{path}: not a PNG")
    at, packed, width, height, channels = 8, b"", 0, 0, 0
    while at < len(data):
        size, kind = struct.unpack(">I4s", data[at:at + 8])
        body = data[at + 8:at + 8 + size]
        if kind == b"IHDR":
            width, height, depth, color, _, _, interlace = struct.unpack(">IIBBBBB", body)
            channels = {2: 3, 6: 4}.get(color, 0)
            if depth != 8 or interlace or not channels:
                sys.exit(f"{path}: expected 8-bit RGB or RGBA without interlacing")
        elif kind == b"IDAT":
            packed += body
        at += 12 + size
    raw, stride = zlib.decompress(packed), width * channels
    rows, before = [], bytes(stride)
    for y in range(height):
        line = bytearray(raw[y * (stride + 1) + 1:(y + 1) * (stride + 1)])
        unfilter(raw[y * (stride + 1)], line, before, channels)
        rows.append(composite(line) if channels == 4 else bytes(line))
        before = line
    return width, height, rows


def unfilter(kind, line, before, step):
    for i in range(len(line)):
        a = line[i - step] if i >= step else 0
        b, c = before[i], before[i - step] if i >= step else 0
        if kind == 1:
            line[i] = (line[i] + a) & 255
        elif kind == 2:
            line[i] = (line[i] + b) & 255
        elif kind == 3:
            line[i] = (line[i] + (a + b) // 2) & 255
        elif kind == 4:
            p = a + b - c
            near = min((abs(p - a), 0, a), (abs(p - b), 1, b), (abs(p - c), 2, c))[2]
            line[i] = (line[i] + near) & 255


def composite(line):
    out = bytearray()
    for i in range(0, len(line), 4):
        alpha = line[i + 3]
        out += bytes((line[i + k] * alpha + BACKGROUND[k] * (255 - alpha)) // 255 for k in range(3))
    return bytes(out)


def write_png(path, width, rows):
    def chunk(kind, body):
        return struct.pack(">I", len(body)) + kind + body + struct.pack(">I", zlib.crc32(kind + body))

    packed = zlib.compress(b"".join(b"\0" + row for row in rows), 9)
    with open(path, "wb") as file:
        file.write(b"\x89PNG\r\n\x1a\n"
                   + chunk(b"IHDR", struct.pack(">IIBBBBB", width, len(rows), 8, 2, 0, 0, 0))
                   + chunk(b"IDAT", packed) + chunk(b"IEND", b""))


def load(name):
    path, _, part = name.lstrip("=").partition("@")
    width, height, rows = read_png(path)
    if part:
        x, y, w, h = map(int, part.split(","))
        width, height, rows = w, h, [row[3 * x:3 * (x + w)] for row in rows[y:y + h]]
    return width, height, rows


def shrink(picture, factor):
    if factor == 1:
        return picture
    width, height, rows = picture[0] // factor, picture[1] // factor, []
    for y in range(height):
        sums = [sum(column) for column in zip(*picture[2][y * factor:(y + 1) * factor])]
        rows.append(bytes((sum(sums[3 * (x * factor + i) + k] for i in range(factor)) + factor * factor // 2) // (factor * factor)
                          for x in range(width) for k in range(3)))
    return width, height, rows


def enlarge(picture, cell_width, cell_height):
    width, height, rows = picture
    factor = max(1, min(cell_width // width, cell_height // height))
    if factor == 1:
        return picture
    wide = [b"".join(row[3 * x:3 * x + 3] * factor for x in range(width)) for row in rows]
    return width * factor, height * factor, [row for row in wide for _ in range(factor)]


def main():
    if len(sys.argv) < 4:
        sys.exit(__doc__)
    columns, _, factor = sys.argv[2].partition("/")
    out, columns, pictures = sys.argv[1], int(columns), [shrink(load(name), int(factor or 1)) for name in sys.argv[3:]]
    cell_width, cell_height = max(p[0] for p in pictures), max(p[1] for p in pictures)
    pictures = [p if name.startswith("=") else enlarge(p, cell_width, cell_height)
                for name, p in zip(sys.argv[3:], pictures)]
    sheet = []
    for first in range(0, len(pictures), columns):
        line = pictures[first:first + columns]
        for y in range(max(height for _, height, _ in line)):
            row = b""
            for width, height, rows in line:
                inside = y < height
                row += (rows[y] if inside else BACKGROUND * width) + BACKGROUND * (cell_width - width + GAP)
            row += BACKGROUND * ((cell_width + GAP) * (columns - len(line)))
            sheet.append(row[:-3 * GAP])
        sheet += [BACKGROUND * ((cell_width + GAP) * columns - GAP)] * GAP
    write_png(out, (cell_width + GAP) * columns - GAP, sheet[:-GAP])


if __name__ == "__main__":
    main()
