#!/usr/bin/env bash
# Builds that are killed, run out of disk or change their input never lose work, and give the same
# bytes in the end. Arguments: executable, scratch folder, source folder.
set -u
mkdir -p "$2" && cd "$2" || exit 1
rm -rf ./*
exec python3 - "$1" "$3" << 'END'
import json
import math
import os
import random
import resource
import shutil
import signal
import struct
import subprocess
import sys

stipple, source = sys.argv[1:3]
ROWS, COLUMNS = 24, 36

def write_part(seed, stretch):
    """Positions and indices of a dented ball: about 1,700 triangles."""
    noise = random.Random(seed)
    dents = [[noise.uniform(-1, 1) for _ in range(3)] for _ in range(3)]
    positions, indices = [], []
    for row in range(ROWS + 1):
        for column in range(COLUMNS + 1):
            a, b = math.pi * row / ROWS, 2 * math.pi * column / COLUMNS
            p = [math.sin(a) * math.cos(b), math.cos(a), math.sin(a) * math.sin(b)]
            size = 1 + 0.2 * math.sin(5 * sum(x * y for x, y in zip(p, dents[0]))) * stretch
            positions += [size * x for x in p]
            if row < ROWS and column < COLUMNS:
                k = row * (COLUMNS + 1) + column
                indices += [k, k + 1, k + COLUMNS + 1, k + 1, k + COLUMNS + 2, k + COLUMNS + 1]
    return positions, indices

def write_assembly(name, changed=None):
    """Four groups of four parts each, in the corners of a square; part `changed` is another one."""
    binary = bytearray()
    views, accessors, meshes, nodes = [], [], [], []
    for part in range(16):
        positions, indices = write_part(part, 3.0 if part == changed else 1.0)
        for values, kind in ((positions, "VEC3"), (indices, "SCALAR")):
            packed = struct.pack(f"<{len(values)}{'f' if kind == 'VEC3' else 'I'}", *values)
            accessor = {"bufferView": len(views), "componentType": 5126 if kind == "VEC3" else 5125, "type": kind,
                        "count": len(values) // (3 if kind == "VEC3" else 1)}
            if kind == "VEC3":
                accessor["min"] = [min(values[i::3]) for i in range(3)]
                accessor["max"] = [max(values[i::3]) for i in range(3)]
            accessors.append(accessor)
            views.append({"buffer": 0, "byteOffset": len(binary), "byteLength": len(packed)})
            binary += packed
        meshes.append({"primitives": [{"attributes": {"POSITION": 2 * part}, "indices": 2 * part + 1}]})
        nodes.append({"mesh": part, "name": f"part {part}", "translation": [3 * (part % 2), 0, 3 * (part // 2 % 2)]})
    for group in range(4):
        nodes.append({"name": f"group {group}", "children": list(range(4 * group, 4 * group + 4)),
                      "translation": [30 * (group % 2), 0, 30 * (group // 2)]})
    nodes.append({"name": "all", "children": list(range(16, 20))})
    open(f"{name}.bin", "wb").write(binary)
    json.dump({"asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [20]}], "nodes": nodes, "meshes": meshes,
               "accessors": accessors, "bufferViews": views,
               "buffers": [{"uri": f"{name}.bin", "byteLength": len(binary)}]}, open(f"{name}.gltf", "w"))

def command(output, model="model", *options):
    return [stipple, "build", f"{model}.gltf", "-o", output, "--json", "--surfels", "300", "--surfel-ratio", "0.001", *options]

def build(output, model="model", *options):
    done = subprocess.run(command(output, model, *options), capture_output=True, text=True)
    assert done.returncode == 0, (done.returncode, done.stderr)
    assert not os.path.exists(f"{output}.work"), os.listdir(f"{output}.work")
    return json.loads(done.stdout)["unchanged"]

def read(name):
    return open(name, "rb").read()

def stop_at(stage, fraction, output, end):
    """Starts a build and sends `end` once it reports the stage; the process, or None where it was too fast."""
    process = subprocess.Popen(command(output, "model", "--progress", "json"), stdout=subprocess.PIPE,
                               stderr=subprocess.PIPE, text=True)
    for line in process.stderr:
        report = json.loads(line)
        if report["stage"] == stage and report["fraction"] >= fraction:
            process.send_signal(end)
            break
    return process

def fails(output, *, where, **how):
    """A build that ends with one sentence about `where`."""
    done = subprocess.run(command(output), capture_output=True, text=True, **how)
    assert done.returncode == 1 and done.stdout == "", (done.returncode, done.stdout, done.stderr)
    lines = done.stderr.splitlines()
    assert len(lines) == 1 and lines[0].startswith("stipple: ") and where in lines[0], done.stderr
    return lines[0]

write_assembly("model")
write_assembly("changed", changed=6)
whole = build("expected.stip", "model", "--threads", "1")
assert whole["surfel_sets"] == 0 and whole["surfel_sets_made"] >= 5, whole
expected = read("expected.stip")

# killed at random moments, repeatedly
subprocess.run([sys.executable, f"{source}/scripts/check_resume.py", stipple, "random", "model.gltf", "--kills", "6", "--", "--surfels", "300", "--surfel-ratio", "0.001"],
               check=True)

# killed at each stage; an existing file stays until the end
for stage, fraction in (("import", 0.0), ("partition", 0.0), ("surfels", 0.5), ("write", 0.0)):
    open("out.stip", "wb").write(b"what was there before")
    process = stop_at(stage, fraction, "out.stip", signal.SIGKILL)
    process.communicate()
    killed = process.returncode == -signal.SIGKILL
    assert killed or process.returncode == 0, process.returncode
    assert read("out.stip") == (b"what was there before" if killed and stage != "write" else read("out.stip"))
    kept = build("out.stip")
    assert read("out.stip") == expected, stage
    if stage == "write" and killed:
        assert kept["surfel_sets_made"] == 0, kept # all of it was there
    assert sorted(f for f in os.listdir() if f.startswith("out.stip")) == ["out.stip"], os.listdir()
    os.remove("out.stip")

# a damaged result is recomputed; --fresh reuses nothing
for fresh in (False, True):
    process = stop_at("write", 0.0, "out.stip", signal.SIGKILL)
    process.communicate()
    if process.returncode == -signal.SIGKILL:
        segment = "out.stip.work/segment-000000"
        damaged = bytearray(read(segment))
        damaged[len(damaged) // 2] ^= 0x10
        open(segment, "wb").write(damaged)
        kept = build("out.stip", "model", *(["--fresh"] if fresh else []))
        assert (kept["surfel_sets"] == 0) == fresh, kept
        assert read("out.stip") == expected
        os.remove("out.stip")

# two builds of one file: the second one reports it, and the first one is not affected
process = stop_at("import", 0.0, "out.stip", signal.SIGSTOP)
message = fails("out.stip", where="out.stip.work")
assert "another build" in message, message
process.send_signal(signal.SIGCONT)
process.communicate()
assert process.returncode == 0 and read("out.stip") == expected
os.remove("out.stip")

# a full disk: files end after a fixed number of bytes
def limit_files(size):
    def apply():
        signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
        resource.setrlimit(resource.RLIMIT_FSIZE, (size, size))
    return apply

resumed = 0
for size in (2000, 50000, len(expected) // 2, len(expected) - 1):
    message = fails("out.stip", where="out.stip", preexec_fn=limit_files(size))
    resumes = message.endswith("; the same command resumes where it stopped")
    assert resumes == os.path.isdir("out.stip.work"), message
    resumed += resumes
    assert not os.path.exists("out.stip")
assert resumed > 0
missing = subprocess.run([stipple, "build", "no.gltf", "-o", "out.stip"], capture_output=True, text=True) # of an input
assert missing.returncode == 1 and "resumes" not in missing.stderr and os.path.isdir("out.stip.work"), missing.stderr
kept = build("out.stip")
assert kept["surfel_sets"] > 0 and read("out.stip") == expected, kept
os.remove("out.stip")

# a read-only folder, and a file in place of the work folder
os.mkdir("closed")
if os.geteuid() != 0: # nothing is forbidden to root
    os.chmod("closed", 0o555)
    assert "ermission denied" in fails("closed/out.stip", where="closed/out.stip")
    os.chmod("closed", 0o755)
open("closed/out.stip.work", "w").write("a letter")
fails("closed/out.stip", where="closed/out.stip.work")
assert read("closed/out.stip.work") == b"a letter"
fails("missing/out.stip", where="missing/out.stip")

# one part changes: it and its ancestors are rebuilt
kept = build("new.stip", "changed")
assert kept["surfel_sets"] == 0, kept
shutil.copy("expected.stip", "out.stip")
kept = build("out.stip", "changed")
assert read("out.stip") == read("new.stip")
assert read("out.stip") != expected
# the part, its group, the root with its coarse ellipses, and a node between them
assert 1 <= kept["surfel_sets_made"] <= 5, kept
assert kept["surfel_sets"] >= kept["surfel_sets_made"], kept
assert kept["meshes_made"] == 1 and kept["meshes"] == 15, kept
kept = build("out.stip", "changed") # nothing has changed
assert kept["surfel_sets_made"] == 0 and kept["meshes_made"] == 0, kept
assert read("out.stip") == read("new.stip")
END
