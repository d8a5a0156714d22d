#!/usr/bin/env bash
# Truncated files: render, info and fly show the available part, with a notice, and pictures improve
# with every twentieth of the file; check rejects them. Arguments: executable, scratch folder.
# needs: stipple-lab
set -u
mkdir -p "$2" && cd "$2" || exit 1
rm -rf ./*
exec python3 - "$1" << 'END_OF_TEST'
import json
import math
import os
import subprocess
import sys

stipple = sys.argv[1]
SIZE = ("--size", "160x120", "--backend", "cpu", "--accumulate", "1", "--once")
failures = 0


def fail(text):
    global failures
    failures += 1
    print("FAIL:", text, file=sys.stderr)


def run(*options):
    return subprocess.run([stipple, *map(str, options)], capture_output=True, text=True)


def good(*options):
    done = run(*options)
    if done.returncode != 0:
        fail(f"{options}: {done.stderr}")
    return done


def write_statue(name, size):
    """A knobbly closed surface of 2 * size * size triangles in one mesh."""
    with open(name, "w") as file:
        for j in range(size + 1):
            for i in range(size):
                u, v = 2 * math.pi * i / size, math.pi * j / size
                r = 1 + 0.2 * math.sin(5 * u) * math.sin(4 * v) + 0.05 * math.sin(17 * u + 11 * v)
                file.write(f"v {r * math.cos(u) * math.sin(v):.4f} {r * math.cos(v):.4f} {r * math.sin(u) * math.sin(v):.4f}\n")
        for j in range(size):
            for i in range(size):
                a, b = j * size + i + 1, j * size + (i + 1) % size + 1
                file.write(f"f {a} {b} {a + size}\nf {b} {b + size} {a + size}\n")


def check_growth(name):
    """From one twentieth of the file to the next, the picture loses at most 0.02 of SSIM."""
    camera = json.loads(good("render", f"{name}.stip", "-o", "whole.png", "--json", *SIZE).stdout)["camera"]
    same = [f"--{key}={','.join(map(str, camera[key]))}" for key in ("eye", "target", "up")] + ["--fov", str(camera["fov"])]
    before, line = 0.0, []
    for percent in range(5, 101, 5):
        done = run("render", f"{name}.stip", "--prefix", f"{percent}%", "-o", "part.png", *same, *SIZE)
        if done.returncode != 0:  # the directory of a small file may be more than that
            if "within its directory" not in done.stderr or before > 0.0:
                fail(f"{name} {percent}%: {done.stderr}")
            continue
        if percent < 100 and "showing the part that is there" not in done.stderr:
            fail(f"{name} {percent}%: no notice: {done.stderr}")
        ssim = json.loads(good("compare", "part.png", "whole.png", "--json").stdout)["ssim"]
        line.append(f"{ssim:.3f}")
        if ssim < before - 0.02:
            fail(f"{name} {percent}%: SSIM falls from {before:.3f} to {ssim:.3f}")
        before = ssim
    print(name, *line)
    if before < 0.9999:
        fail(f"{name}: all of the file is not the whole picture: {before}")


write_statue("statue.obj", 160)
models = {"statue": "statue.obj", "spheres": "scene:spheres,scale=0.2 --surfels 16000 --surfel-ratio 0.001", "one-mesh": "scene:one-mesh,scale=0.02",
          "forest": "scene:forest,scale=0.003", "terrain": "scene:terrain,scale=0.02"}
for name, source in models.items():
    good("build", *source.split(), "-o", f"{name}.stip", "--progress", "none")
    check_growth(name)

# messages about a truncated file
size = os.path.getsize("statue.stip")
whole = open("statue.stip", "rb").read()
part = size // 3
open("cut.stip", "wb").write(whole[:part])
wanted = {"truncated": True, "file_bytes": part, "whole_bytes": size}
for done in (run("info", "cut.stip", "--json"), run("render", "cut.stip", "-o", "cut.png", "--json", *SIZE)):
    if done.returncode != 0 or f"ends after {part} of {size} bytes" not in done.stderr:
        fail(f"a cut file: {done.stderr}")
        continue
    described = json.loads(done.stdout)
    if {key: described.get(key) for key in wanted} != wanted:
        fail(f"a cut file is described as {described}")
if "truncated" not in good("info", "cut.stip").stdout:
    fail("info does not say that a file is truncated")
if json.loads(good("info", "statue.stip", "--json").stdout)["truncated"]:
    fail("info calls a whole file truncated")
done = run("check", "cut.stip")
if done.returncode == 0 or f"ends after {part} of {size} bytes" not in done.stderr:
    fail(f"check of a cut file: {done.stderr}")
flight = {"fov": 50, "fps": 2, "keys": [{"t": 0, "eye": [0, 0, 4], "target": [0, 0, 0], "up": [0, 1, 0]},
                                      {"t": 2, "eye": [4, 0, 0], "target": [0, 0, 0], "up": [0, 1, 0]}]}
with open("flight.json", "w") as file:
    json.dump(flight, file)
done = run("fly", "cut.stip", "--path", "flight.json", "--json", "--size", "64x48")
if done.returncode != 0 or "showing the part that is there" not in done.stderr or not json.loads(done.stdout)["truncated"]:
    fail(f"fly of a cut file: {done.stderr}")

# the same picture from the same bytes, for a truncated file, with --prefix, and with a memory limit
good("render", "statue.stip", "--prefix", part, "-o", "said.png", *SIZE)
good("render", "cut.stip", "--memory", "256M", "-o", "streamed.png", *SIZE)
for other in ("said.png", "streamed.png"):
    if open(other, "rb").read() != open("cut.png", "rb").read():
        fail(f"{other} is another picture than cut.png")

# any truncation: a picture or one sentence
for length in [0, 1, 3, 4, 7, 8, 60, 127, 128, 129, 500, 2000, 5000, *range(10000, size, size // 5 + 1), size - 1]:
    open("any.stip", "wb").write(whole[:length])
    for command in (("render", "any.stip", "-o", "any.png", *SIZE), ("info", "any.stip")):
        done = run(*command)
        said = [line for line in done.stderr.splitlines() if line.startswith("stipple-lab: ")]
        if done.returncode not in (0, 1) or len(said) != 1 or "any.stip" not in said[0]:
            fail(f"{command[0]} of {length} bytes: exit {done.returncode}, {done.stderr}")
    if run("check", "any.stip").returncode == 0:
        fail(f"check takes {length} bytes of {size} for the whole file")

# a reference needs the whole file; invalid sizes and parts are refused
done = run("render", "cut.stip", "--reference", "-o", "any.png", *SIZE)
if done.returncode != 1 or "ends after" not in done.stderr:
    fail(f"a reference of a cut file: {done.stderr}")
for bad in ("0", "0%", "101%", "-5%", "many", "5%%", "1Q"):
    if run("render", "statue.stip", "--prefix", bad, "-o", "any.png").returncode != 2:
        fail(f"--prefix {bad} is not refused")
for same in ("64K", "65536", "64KiB"):
    good("render", "statue.stip", "--prefix", same, "-o", f"{same}.png", *SIZE)
if len({open(f"{same}.png", "rb").read() for same in ("64K", "65536", "64KiB")}) != 1:
    fail("sizes of prefixes are not read alike")
sys.exit(1 if failures else 0)
END_OF_TEST
