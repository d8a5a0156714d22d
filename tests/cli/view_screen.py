#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""view_screen.py SCREEN OUT.png: converts the screen of an X server with -fbdir
(X window dump, 32 bits per pixel) to PNG."""
import struct
import sys
import zlib

with open(sys.argv[1], "rb") as file:
    dump = file.read()
head = struct.unpack(">25I", dump[:100])
width, height, bits, line, colors = head[4], head[5], head[11], head[12], head[19]
assert bits == 32, bits
start = head[0] + 12 * colors
rows = bytearray()
for y in range(height):
    row = dump[start + y * line:start + y * line + 4 * width]
    rgb = bytearray(3 * width)
    rgb[0::3], rgb[1::3], rgb[2::3] = row[2::4], row[1::4], row[0::4]
    rows += b"\0" + rgb


def chunk(kind, data):
    return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))


with open(sys.argv[2], "wb") as file:
    file.write(b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", struct.pack(">IIBBBBB", width, height, 8, 2, 0, 0, 0)) +
               chunk(b"IDAT", zlib.compress(bytes(rows), 1)) + chunk(b"IEND", b""))
