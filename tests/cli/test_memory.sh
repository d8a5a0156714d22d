#!/usr/bin/env bash
# Builds with memory limits: the same bytes for any limit and number of threads, or one sentence.
# Arguments: executable, scratch folder.
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
MEGABYTE = 1 << 20

def write_sheet(name, size):
    """A wavy sheet of 2 * size * size triangles."""
    with open(name, "w") as file:
        for y in range(size + 1):
            for x in range(size + 1):
                file.write(f"v {x} {3 * math.sin(x / 7) * math.cos(y / 5):.3f} {y}\n")
        for y in range(size):
            for x in range(size):
                a = y * (size + 1) + x + 1
                file.write(f"f {a} {a + size + 1} {a + 1}\nf {a + 1} {a + size + 1} {a + size + 2}\n")

def build(output, *options):
    return subprocess.run([stipple, "build", "sheet.obj", "-o", output, "--surfels", "3000", "--surfel-ratio", "0.001", "--json", *options],
                          capture_output=True, text=True)

write_sheet("sheet.obj", 90)
done = build("expected.stip", "--threads", "1")
assert done.returncode == 0, done.stderr
free = json.loads(done.stdout)["peak_bytes"]
expected = open("expected.stip", "rb").read()
for threads in (1, 2, 3):
    limit = free if threads == 1 else 3 * free # meshes go to the spill file: the bulk may not stay in memory
    done = build("limited.stip", "--fresh", "--threads", str(threads), "--memory", str(limit))
    assert done.returncode == 0, (threads, limit, done.stderr)
    assert json.loads(done.stdout)["peak_bytes"] <= limit, done.stdout
    assert open("limited.stip", "rb").read() == expected, threads
    os.remove("limited.stip")

# too little: one sentence gives the required amount, which suffices
done = build("limited.stip", "--threads", "1", "--memory", str(2 * MEGABYTE))
assert done.returncode == 1 and done.stdout == "", (done.returncode, done.stdout)
lines = done.stderr.splitlines()
assert len(lines) == 1 and lines[0].startswith("stipple-lab: out of memory: the limit of"), done.stderr
assert "(--memory)" in lines[0] and "memory_limit_bytes" not in lines[0], done.stderr
assert not os.path.exists("limited.stip")
if "needs about" in lines[0]: # where it was for surfels
    needed = int(lines[0].split("needs about ")[1].split()[0])
    done = build("limited.stip", "--threads", "1", "--memory", f"{needed}000000")
    assert done.returncode == 0, (needed, done.stderr)
    assert open("limited.stip", "rb").read() == expected

# less than any build could use: a usage error
done = build("limited.stip", "--memory", "10")
assert done.returncode == 2 and done.stdout == "", (done.returncode, done.stdout)
first = done.stderr.split("\n")[0]
assert first == "stipple-lab: --memory: '10' is too small: expected at least 64K", done.stderr

# builds into the cache respect the limit as well: without it, they would plan with the machine's
# memory
environment = {**os.environ, "XDG_CACHE_HOME": os.path.abspath("cache")}
done = subprocess.run([stipple, "render", "scene:power-plant,scale=0.1", "--memory", "32M", "--threads", "2", "--size", "320x180", "-o", "x.png", "--once"],
                      capture_output=True, text=True, env=environment)
assert done.returncode == 0, done.stderr
END_OF_TEST
