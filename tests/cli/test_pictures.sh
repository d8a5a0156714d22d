#!/usr/bin/env bash
# Pictures of a model are stored once, in their original form; other formats become a lossless PNG.
# Arguments: executable, scratch folder.
set -u
mkdir -p "$2" && cd "$2" || exit 1
rm -rf ./*
exec python3 - "$1" << 'END_OF_TEST'
import json
import os
import struct
import subprocess
import sys
import zlib

stipple = sys.argv[1]

def run(*options, code=0):
    done = subprocess.run([stipple, *options], capture_output=True, text=True)
    assert done.returncode == code, (options, done.returncode, done.stderr)
    return done

def read(name):
    with open(name, "rb") as file:
        return file.read()

def texel(x, y):
    return (x * 3 % 256, y * 5 % 256, (x * y >> 4) % 256)

def png(size):
    rows = b"".join(b"\0" + b"".join(bytes(texel(x, y)) for x in range(size)) for y in range(size))
    def chunk(kind, data):
        return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))
    header = struct.pack(">2I5B", size, size, 8, 2, 0, 0, 0)
    return b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", header) + chunk(b"IDAT", zlib.compress(rows, 9)) + chunk(b"IEND", b"")

def write_glb(name, picture):
    """Two squares of one picture, with samplers that differ."""
    squares = []
    for offset in (0.0, 1.2):
        corners = [(offset + x, y, 0.0) for y in (0.0, 1.0) for x in (0.0, 1.0)]
        squares.append(b"".join(struct.pack("<3f", *c) for c in corners))
    uvs = b"".join(struct.pack("<2f", 2 * x, 2 * y) for y in (0, 1) for x in (0, 1))
    indices = struct.pack("<6H", 0, 1, 2, 2, 1, 3)
    parts, views, data = [*squares, uvs, indices, picture], [], b""
    for part in parts:
        views.append({"buffer": 0, "byteOffset": len(data), "byteLength": len(part)})
        data += part + b"\0" * (-len(part) % 4)
    box = [{"min": [o, 0, 0], "max": [o + 1, 1, 0]} for o in (0, 1.2)]
    accessors = [{"bufferView": i, "componentType": 5126, "count": 4, "type": "VEC3", **box[i]} for i in (0, 1)]
    accessors += [{"bufferView": 2, "componentType": 5126, "count": 4, "type": "VEC2"},
                  {"bufferView": 3, "componentType": 5123, "count": 6, "type": "SCALAR"}]
    scene = {
        "asset": {"version": "2.0"}, "buffers": [{"byteLength": len(data)}], "bufferViews": views,
        "accessors": accessors, "images": [{"bufferView": 4, "mimeType": "image/png"}],
        "samplers": [{}, {"wrapS": 33071, "wrapT": 33071}],
        "textures": [{"source": 0, "sampler": 0}, {"source": 0, "sampler": 1}],
        "materials": [{"pbrMetallicRoughness": {"baseColorTexture": {"index": i}}} for i in (0, 1)],
        "meshes": [{"primitives": [{"attributes": {"POSITION": i, "TEXCOORD_0": 2}, "indices": 3, "material": i}]}
                   for i in (0, 1)],
        "nodes": [{"mesh": 0}, {"mesh": 1}], "scenes": [{"nodes": [0, 1]}], "scene": 0}
    text = json.dumps(scene).encode()
    text += b" " * (-len(text) % 4)
    with open(name, "wb") as file:
        file.write(struct.pack("<3I", 0x46546C67, 2, 28 + len(text) + len(data)))
        file.write(struct.pack("<2I", len(text), 0x4E4F534A) + text)
        file.write(struct.pack("<2I", len(data), 0x004E4942) + data)

picture = png(256)
write_glb("model.glb", picture)
run("build", "model.glb", "-o", "model.stip", "--threads", "1")
stored = read("model.stip")
assert stored.count(picture) == 1, stored.count(picture)
grown = len(stored) / os.path.getsize("model.glb")
assert grown < 1.05, grown
run("check", "model.stip")
run("build", "model.glb", "-o", "again.stip", "--threads", "3")
assert read("again.stip") == stored

# the same picture however it is read
camera = ("--view", "front", "--size", "320x240")
run("render", "model.stip", *camera, "--threads", "1", "-o", "one.png")
run("render", "model.stip", *camera, "--threads", "3", "-o", "three.png")
run("render", "model.stip", *camera, "--memory", "32M", "-o", "memory.png")
assert read("one.png") == read("three.png") == read("memory.png")
assert len(set(read("one.png"))) > 100

# TGA is decoded: it becomes a PNG, which is smaller
with open("tiles.tga", "wb") as file:
    file.write(struct.pack("<3B5x2h2H2B", 0, 0, 2, 0, 0, 256, 256, 24, 32))
    file.write(b"".join(bytes(reversed(texel(x, y))) for y in range(256) for x in range(256)))
with open("square.mtl", "w") as file:
    file.write("newmtl m\nmap_Kd tiles.tga\n")
with open("square.obj", "w") as file:
    file.write("mtllib square.mtl\nusemtl m\nv 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n"
               "vt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\nf 1/1 2/2 3/3 4/4\n")
run("build", "square.obj", "-o", "square.stip")
tiles = read("square.stip")
assert tiles.count(b"\x89PNG\r\n\x1a\n") == 1 and len(tiles) < 100000, len(tiles)
run("check", "square.stip")

# a damaged picture: one sentence, and no picture
damaged = bytearray(stored)
damaged[stored.find(picture) + len(picture) // 2] ^= 1
with open("damaged.stip", "wb") as file:
    file.write(damaged)
for command in (("check", "damaged.stip"), ("render", "damaged.stip", *camera, "-o", "damaged.png")):
    said = run(*command, code=1).stderr
    assert said.count("\n") == 1 and "damaged.stip" in said, said
assert not os.path.exists("damaged.png")
END_OF_TEST
