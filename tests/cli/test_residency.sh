#!/usr/bin/env bash
# Pictures and flights with memory limits: identical if the whole file fits, otherwise coarser
# without holes. Arguments: executable, scratch folder.
set -u
mkdir -p "$2" && cd "$2" || exit 1
rm -rf ./*
exec python3 - "$1" << 'END_OF_TEST'
import json
import math
import os
import subprocess
import sys
import zlib

stipple = sys.argv[1]

def write_sheet(name, size):
    """A wavy sheet of 2 * size * size triangles, in nine parts."""
    with open(name, "w") as file:
        for y in range(size + 1):
            for x in range(size + 1):
                file.write(f"v {x} {3 * math.sin(x / 7) * math.cos(y / 5):.3f} {y}\n")
        for part in range(9):
            file.write(f"o part{part}\n")
            for y in range(part // 3 * size // 3, (part // 3 + 1) * size // 3):
                for x in range(part % 3 * size // 3, (part % 3 + 1) * size // 3):
                    a = y * (size + 1) + x + 1
                    file.write(f"f {a} {a + size + 1} {a + 1}\nf {a + 1} {a + size + 1} {a + size + 2}\n")

def run(*options):
    return subprocess.run([stipple, *options], capture_output=True, text=True)

def read_alpha(name):
    """The alpha of each pixel of an RGBA PNG, by rows."""
    data = open(name, "rb").read()
    width, height = int.from_bytes(data[16:20], "big"), int.from_bytes(data[20:24], "big")
    assert data[24:29] == b"\x08\x06\x00\x00\x00", data[24:29]
    packed, at = b"", 8
    while at < len(data):
        size = int.from_bytes(data[at:at + 4], "big")
        if data[at + 4:at + 8] == b"IDAT":
            packed += data[at + 8:at + 8 + size]
        at += 12 + size
    raw, rows, before = zlib.decompress(packed), [], bytearray(4 * width)
    for y in range(height):
        row = bytearray(raw[y * (4 * width + 1) + 1:(y + 1) * (4 * width + 1)])
        kind = raw[y * (4 * width + 1)]
        for i in range(4 * width):
            left = row[i - 4] if i >= 4 else 0
            corner = before[i - 4] if i >= 4 else 0
            up = before[i]
            if kind == 4:
                p = left + up - corner
                distances = abs(p - left), abs(p - up), abs(p - corner)
                guess = (left, up, corner)[distances.index(min(distances))]
            else:
                guess = (0, left, up, (left + up) // 2)[kind]
            row[i] = (row[i] + guess) & 255
        rows += row[3::4]
        before = row
    return rows

write_sheet("sheet.obj", 150)
assert run("build", "sheet.obj", "-o", "sheet.stip", "-q").returncode == 0
size = os.path.getsize("sheet.stip")
views = {"near": ("--eye", "40,9,60", "--target", "90,0,80"), "far": ("--eye", "75,90,260", "--target", "75,0,75")}
for name, view in views.items():
    view = (*view, "--size", "96x64", "--threads", "1", "--json", "--fov", "50")
    done = run("render", "sheet.stip", "-o", "free.png", *view)
    assert done.returncode == 0, done.stderr
    free = json.loads(done.stdout)
    expected = read_alpha("free.png")
    done = run("render", "sheet.stip", "-o", "reference.png", "--reference", *view)
    reference = read_alpha("reference.png")
    done = run("render", "sheet.stip", "-o", "same.png", "--memory", "32M", *view)
    assert done.returncode == 0 and done.stderr == "", done.stderr
    fits = json.loads(done.stdout)
    assert open("same.png", "rb").read() == open("free.png", "rb").read(), name
    assert (fits["splats"], fits["triangles"]) == (free["splats"], free["triangles"])
    base = fits["resident_bytes"]
    coarser = 0
    for limit in range(8 * 1024 * 1024, 2 * 1024 * 1024, -512 * 1024):
        done = run("render", "sheet.stip", "-o", "limited.png", "--memory", str(limit), *view)
        if done.returncode != 0: # not even room for the picture
            lines = done.stderr.splitlines()
            assert len(lines) == 1 and lines[0].startswith("stipple: out of memory"), done.stderr
            break
        figures = json.loads(done.stdout)
        assert figures["resident_bytes"] <= limit, (figures, limit)
        alpha = read_alpha("limited.png")
        holes = sum(1 for a, b in zip(reference, alpha) if a != 0 and b == 0)
        missed = sum(1 for a, b in zip(reference, expected) if a != 0 and b == 0)
        assert holes <= missed + 3, (name, limit, holes, missed)
        assert sum(1 for a in alpha if a) >= 0.99 * sum(1 for a in reference if a), (name, limit)
        coarser += open("limited.png", "rb").read() != open("free.png", "rb").read()
        again = run("render", "sheet.stip", "-o", "again.png", "--memory", str(limit), *view)
        assert again.returncode == 0, again.stderr
        assert open("again.png", "rb").read() == open("limited.png", "rb").read(), (name, limit)
    assert coarser > 0, (name, base, size)

with open("flight.json", "w") as file:
    json.dump({"fov": 50, "fps": 8, "keys": [{"t": 0, "eye": [75, 90, 260], "target": [75, 0, 75]},
                                             {"t": 1, "eye": [40, 9, 60], "target": [90, 0, 80]}]}, file)
flight = ("fly", "sheet.stip", "--path", "flight.json", "--size", "96x64", "--threads", "1", "--json")
done = run(*flight)
assert done.returncode == 0 and "residency" not in json.loads(done.stdout), done.stderr
done = run(*flight, "--memory", "8M", "-o", "pictures/")
assert done.returncode == 0, done.stderr
figures = json.loads(done.stdout)["residency"]
assert sorted(figures) == ["damaged", "dropped", "frames_lacking", "limit_bytes", "loaded", "peak_bytes", "read_bytes",
                           "resident_bytes"], figures
assert 0 < figures["peak_bytes"] <= 8 * 1024 * 1024 and figures["read_bytes"] > 0 and figures["damaged"] == 0, figures
assert figures["resident_bytes"] <= figures["peak_bytes"], figures

# loaded data gives way to the work on a picture: if there is room to draw, there is room to write
# and, with another megabyte for sums, to accumulate; more memory never fails
where = (*views["near"], "--size", "240x160", "--threads", "1")
with open("look.json", "w") as file:
    json.dump({"fov": 50, "keys": [{"t": 0, "eye": [40, 9, 60], "target": [90, 0, 80]}]}, file)
limit = 1 << 20
while run("fly", "sheet.stip", "--path", "look.json", *where[4:], "--memory", str(limit)).returncode != 0:
    limit += 1 << 18
    assert limit < 16 << 20
for more in range(0, 2 << 20, 1 << 18):
    done = run("render", "sheet.stip", "-o", "written.png", *where, "--once", "--memory", str(limit + more))
    assert done.returncode == 0, (limit, more, done.stderr)
    done = run("render", "sheet.stip", "-o", "rests.png", *where, "--accumulate", "4", "--memory", str(limit + more + (1 << 20)))
    assert done.returncode == 0, (limit, more, done.stderr)

# a damaged block is reported once, and the rest is drawn
data = bytearray(open("sheet.stip", "rb").read())
data[-1000] ^= 255
open("damaged.stip", "wb").write(data)
done = run("render", "damaged.stip", "-o", "damaged.png", "--memory", "32M", *views["near"], "--size", "96x64")
assert done.returncode == 0, done.stderr
assert len(done.stderr.splitlines()) <= 1, done.stderr
END_OF_TEST
