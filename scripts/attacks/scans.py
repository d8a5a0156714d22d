# SPDX-License-Identifier: MIT
"""Scans: small files of each format, and mutations by their structure."""
import os
import random as random_module
import re
import struct
import subprocess

import models

# (offset, layout) of the header fields of LAS
LAS_FIELDS = ((6, "<H"), (24, "<B"), (25, "<B"), (94, "<H"), (96, "<I"), (100, "<I"), (104, "<B"), (105, "<H"), (107, "<I"),
              (111, "<I"), (131, "<d"), (139, "<d"), (147, "<d"), (155, "<d"), (163, "<d"), (171, "<d"), (179, "<d"), (187, "<d"),
              (195, "<d"), (203, "<d"), (211, "<d"), (219, "<d"), (227, "<Q"), (235, "<Q"), (243, "<I"), (247, "<Q"))
PAGE, PAYLOAD = 1024, 1020


def make_crc32c():
    table = []
    for byte in range(256):
        for _ in range(8):
            byte = byte >> 1 ^ (0x82F63B78 if byte & 1 else 0)
        table.append(byte)
    return table


CRC32C = make_crc32c()


def crc32c(data):
    crc = 0xFFFFFFFF
    for byte in data:
        crc = CRC32C[(crc ^ byte) & 255] ^ crc >> 8
    return crc ^ 0xFFFFFFFF


def write_number(random, data, at, layout):
    """Replaces a number of a layout by another, or by one near it."""
    if at + struct.calcsize(layout) > len(data):
        return
    old, = struct.unpack_from(layout, data, at)
    if layout == "<d":
        value = random.choice((0.0, -1.0, 1e-320, 1e300, -1e300, float("nan"), float("inf"), old * 1e9, -old))
    else:
        bits = 8 * struct.calcsize(layout)
        value = random.choice((0, 1, old + 1, old - 1, old * 2, old + 1000, (1 << bits - 1) - 1, 1 << bits - 1, (1 << bits) - 1,
                               random.randrange(1 << bits))) % (1 << bits)
    struct.pack_into(layout, data, at, value)


def vlrs_of(data):
    """Offsets of the variable length records of LAS, and their sizes."""
    at, count = struct.unpack_from("<H", data, 94)[0], struct.unpack_from("<I", data, 100)[0]
    found = []
    for _ in range(min(count, 100)):
        if at + 54 > len(data):
            break
        size, = struct.unpack_from("<H", data, at + 20)
        found.append((at, size))
        at += 54 + size
    return found


def mutate_las(random, data):
    """Mutates header fields, records, points, the chunk table, or the hierarchy of COPC; claims more points."""
    data = bytearray(data)
    points, = struct.unpack_from("<I", data, 96)
    for _ in range(random.choice((1, 1, 1, 2, 4))):
        what = random.random()
        if what < 0.3:
            write_number(random, data, *random.choice(LAS_FIELDS))
        elif what < 0.5:
            for at, size in random.sample(vlrs_of(data), min(1, len(vlrs_of(data)))):
                where = random.choice((18, 20, 54 + random.randrange(max(size, 1))))
                write_number(random, data, at + where, random.choice(("<H", "<I", "<B")))
        elif what < 0.6:  # counts that the points do not prove
            count = random.choice((1000, 100_000, 10_000_000, 2**31 - 1))
            struct.pack_into("<I", data, 107, count)
            if data[25] >= 4 and len(data) >= 255:
                struct.pack_into("<Q", data, 247, count)
        elif what < 0.7 and points + 8 <= len(data):
            write_number(random, data, points, "<Q")  # offset of the chunk table
        elif what < 0.8:
            del data[random.randrange(len(data)):]
        elif points < len(data):  # points, chunk table, extended records
            for _ in range(random.choice((1, 4, 64))):
                write_number(random, data, random.randrange(points, len(data)), random.choice(("<B", "<I")))
        if random.random() < 0.1 and points < len(data):
            data[points + 8:] = bytes(len(data) - points - 8) if points + 8 < len(data) else b""
    return bytes(data)


def make_copc(data):
    """Makes COPC of LAZ 1.4: an info record, and a hierarchy of one node."""
    header, = struct.unpack_from("<H", data, 94)
    points, = struct.unpack_from("<I", data, 96)
    table, = struct.unpack_from("<Q", data, points)
    count, = struct.unpack_from("<Q", data, 247)
    shift, end = 54 + 160, len(data) + 54 + 160
    info = struct.pack("<5d2Q2d", 0, 0, 0, 100, 1, end + 60, 32, 0, 1) + bytes(88)
    vlr = struct.pack("<H16sHH32s", 0, b"copc", 1, 160, b"") + info
    made = bytearray(data[:header] + vlr + data[header:])
    struct.pack_into("<II", made, 96, points + shift, struct.unpack_from("<I", data, 100)[0] + 1)
    struct.pack_into("<Q", made, points + shift, table + shift if table < 2**63 else table)
    struct.pack_into("<QI", made, 235, end, 1)
    entry = struct.pack("<4iQii", 0, 0, 0, 0, points + shift + 8, table - points - 8, count)
    return bytes(made) + struct.pack("<H16sHQ32s", 0, b"copc", 1000, 32, b"") + entry


def read_pages(data):
    """Logical bytes of E57: without the checksums."""
    return bytearray(b"".join(data[i:i + PAYLOAD] for i in range(0, len(data), PAGE)))


def write_pages(logical, keep_size=False):
    logical = bytes(logical) + bytes(-len(logical) % PAYLOAD)
    pages = [logical[i:i + PAYLOAD] for i in range(0, len(logical), PAYLOAD)]
    if not keep_size:
        pages[0] = pages[0][:16] + struct.pack("<Q", PAGE * len(pages)) + pages[0][24:]
    return b"".join(page + struct.pack(">I", crc32c(page)) for page in pages)


def mutate_xml(random, text):
    """Mutates numbers, attributes and elements; repeats scans, which then share their points."""
    for _ in range(random.choice((1, 1, 2, 4))):
        what = random.randrange(5)
        if what <= 1:
            spots = [m for m in re.finditer(r'(?<=")[-+.0-9eE]+(?=")|(?<=>)[-+.0-9eE]+(?=<)|"[A-Za-z]+"|<[A-Za-z0-9:]+', text)]
            if spots:
                spot = random.choice(spots)
                value = str(random.choice(models.NUMBERS)) if spot.group()[:1] not in '"<' else random.choice(
                    ('"Float"', '"Integer"', '"ScaledInteger"', '"String"', "<points", "<prototype", "<rowIndex", "<colorRed"))
                text = text[:spot.start()] + value + text[spot.end():]
        elif what == 2:
            scan = re.search(r"<vectorChild.*?</vectorChild>", text, re.S)
            if scan:
                text = text[:scan.end()] + scan.group() * random.choice((1, 7, 200)) + text[scan.end():]
        elif what == 3:
            at = random.randrange(len(text))
            text = text[:at] + text[at + random.choice((1, 10, 200)):]
        else:
            at = random.randrange(len(text))
            text = text[:at] + random.choice(("<a>" * 300, "&amp;", "<![CDATA[", "\0", "</e57Root>", "\u202e")) + text[at:]
    return text


def mutate_e57(random, data):
    """Mutates the XML, the packets or the header; pages have correct checksums."""
    logical = read_pages(data)
    physical, length = struct.unpack_from("<QQ", logical, 24)
    at = physical // PAGE * PAYLOAD + physical % PAGE
    what = random.random()
    if what < 0.6:
        text = mutate_xml(random, logical[at:at + length].decode("utf-8", "replace")).encode("utf-8", "surrogatepass")
        logical = logical[:at] + text + bytes(len(logical) - at - length)
        struct.pack_into("<Q", logical, 32, len(text))
    elif what < 0.9:
        for _ in range(random.choice((1, 1, 4, 32))):
            write_number(random, logical, random.randrange(48, max(at, 49)), random.choice(("<B", "<H", "<I", "<Q")))
    else:
        write_number(random, logical, random.choice((8, 12, 16, 24, 32, 40)), "<Q")
        return write_pages(logical, True)
    return write_pages(logical)


def mutate_pcd(random, data):
    """Mutates the header's words, the sizes of compressed points, or the points."""
    end = data.find(b"\n", data.find(b"DATA ")) + 1
    head, body = data[:end], bytearray(data[end:])
    if random.random() < 0.5:
        head = models.mutate_text(random, head.rstrip(b"\n")) + b"\n"
    elif b"binary_compressed" in head and random.random() < 0.5:
        write_number(random, body, random.choice((0, 4)), "<I")
    else:
        body = bytearray(models.spoil_bytes(random, bytes(body)))
    return head + bytes(body)


MUTATE = {"las": mutate_las, "laz": mutate_las, "e57": mutate_e57, "pcd": mutate_pcd, "xyz": models.mutate_text,
          "pts": models.mutate_text, "ptx": models.mutate_text, "csv": models.mutate_text}


def write_pcd(path, points, encoding):
    head = (f"# .PCD v0.7\nVERSION 0.7\nFIELDS x y z rgb intensity\nSIZE 4 4 4 4 4\nTYPE F F F U F\nCOUNT 1 1 1 1 1\n"
            f"WIDTH {len(points)}\nHEIGHT 1\nVIEWPOINT 0 0 0 1 0 0 0\nPOINTS {len(points)}\nDATA {encoding}\n").encode()
    if encoding == "ascii":
        body = "".join(f"{x:.3f} {y:.3f} {z:.3f} {c} {i:.2f}\n" for x, y, z, c, i in points).encode()
    elif encoding == "binary":
        body = b"".join(struct.pack("<3fIf", *p) for p in points)
    else:  # LZF, of literal runs
        columns = b"".join(struct.pack(f"<{len(points)}{'I' if k == 3 else 'f'}", *(p[k] for p in points)) for k in range(5))
        packed = b"".join(bytes((len(columns[i:i + 32]) - 1,)) + columns[i:i + 32] for i in range(0, len(columns), 32))
        body = struct.pack("<II", len(packed), len(columns)) + packed
    path.write_bytes(head + body)


def write_seeds(folder, stipple):
    """Writes small scans of every format; LAZ needs the unit tests of the same build."""
    random = random_module.Random(1)
    points = [(random.uniform(-5, 5), random.uniform(-5, 5), random.uniform(0, 2), random.randrange(1 << 24), random.random())
              for _ in range(400)]
    for kind, degrees in (("las", "3"), ("ptx", "6"), ("e57", "3")):
        subprocess.run([stipple, "scan", "scene:city-small,scale=0.02", "--stations", "2", "--resolution", degrees, "-o",
                        folder / f"scan.{kind}", "-q"], check=True, capture_output=True, timeout=600)
    for encoding in ("ascii", "binary", "binary_compressed"):
        write_pcd(folder / f"{encoding}.pcd", points, encoding)
    lines = [f"{x:.3f} {y:.3f} {z:.3f} {i:.2f} {c >> 16} {c >> 8 & 255} {c & 255}" for x, y, z, c, i in points]
    (folder / "a.xyz").write_text("\n".join(lines) + "\n")
    (folder / "a.pts").write_text(f"{len(lines)}\n" + "\n".join(lines) + "\n")
    (folder / "a.csv").write_text("x,y,z,intensity,r,g,b\n" + "\n".join(line.replace(" ", ",") for line in lines) + "\n")
    tests = os.path.join(os.path.dirname(os.path.dirname(stipple)), "tests", "stp_tests")
    if os.access(tests, os.X_OK):
        subprocess.run([tests, "las_writes_seeds"], env={**os.environ, "STP_LAS_SEEDS": str(folder)}, check=True,
                       capture_output=True, timeout=600)
        for path in sorted(folder.glob("format-*.las")):
            if path.read_bytes()[104] & 128:
                path = path.rename(path.with_suffix(".laz"))
                if path.name.startswith(("format-6-2", "format-7-2")):
                    path.with_suffix(".copc.laz").write_bytes(make_copc(path.read_bytes()))
