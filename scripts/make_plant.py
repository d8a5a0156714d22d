#!/usr/bin/env python3
"""Builds a plant from copies of a real model: halls, each with racks of machines, as one GLB of
nested nodes.

usage: make_plant.py MODEL.glb PLANT.glb FLIGHT.json [MACHINES]

MODEL is a GLB without extensions beyond those of its meshes. MACHINES (default 1,200) is rounded up
to whole halls of 200. FLIGHT.json receives a flight of 12 seconds: over the plant, down between two
halls, and along the machines.
"""
import json
import math
import struct
import sys

ROW, LEVELS, ROWS = 10, 4, 5 # machines per shelf, shelves per rack, racks per hall
MACHINES = ROW * LEVELS * ROWS


def read_glb(path):
    data = open(path, "rb").read()
    if data[:4] != b"glTF" or struct.unpack_from("<I", data, 4)[0] != 2:
        sys.exit(f"{path}: not a GLB of version 2")
    size = struct.unpack_from("<I", data, 12)[0]
    model = json.loads(data[20:20 + size])
    at = 20 + size
    return model, data[at + 8:at + 8 + struct.unpack_from("<I", data, at)[0]] if at < len(data) else b""


def write_glb(path, model, binary):
    def chunk(kind, body, fill):
        body += fill * (-len(body) % 4)
        return struct.pack("<I4s", len(body), kind) + body

    body = chunk(b"JSON", json.dumps(model, separators=(",", ":")).encode(), b" ") + chunk(b"BIN\0", binary, b"\0")
    with open(path, "wb") as file:
        file.write(b"glTF" + struct.pack("<II", 2, 12 + len(body)) + body)


def local_matrix(node):
    if "matrix" in node:
        m = node["matrix"]
        return [[m[4 * c + r] for c in range(4)] for r in range(4)]
    x, y, z, w = node.get("rotation", (0, 0, 0, 1))
    s, t = node.get("scale", (1, 1, 1)), node.get("translation", (0, 0, 0))
    turn = [[1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
            [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
            [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)]]
    return [[turn[r][c] * s[c] for c in range(3)] + [t[r]] for r in range(3)] + [[0, 0, 0, 1]]


def multiply(a, b):
    return [[sum(a[r][k] * b[k][c] for k in range(4)) for c in range(4)] for r in range(4)]


def bounds(model, roots):
    low, high = [math.inf] * 3, [-math.inf] * 3
    stack = [(index, [[float(r == c) for c in range(4)] for r in range(4)]) for index in roots]
    while stack:
        index, above = stack.pop()
        node = model["nodes"][index]
        world = multiply(above, local_matrix(node))
        for primitive in model["meshes"][node["mesh"]]["primitives"] if "mesh" in node else ():
            accessor = model["accessors"][primitive["attributes"]["POSITION"]]
            for corner in range(8):
                p = [accessor["max" if corner >> i & 1 else "min"][i] for i in range(3)] + [1]
                for r in range(3):
                    value = sum(world[r][k] * p[k] for k in range(4))
                    low[r], high[r] = min(low[r], value), max(high[r], value)
        stack += [(child, world) for child in node.get("children", ())]
    return low, high


def add_slab(model, binary):
    """A unit cube, grey, for floors. Returns its mesh."""
    corners = [(x, y, z) for x in (0, 1) for y in (-1, 0) for z in (0, 1)]
    faces = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
    indices = [i for a, b, c, d in faces for i in (a, b, c, a, c, d)]
    binary += b"\0" * (-len(binary) % 4)
    views = model.setdefault("bufferViews", [])
    accessors = model.setdefault("accessors", [])
    for data, component, count, kind in ((b"".join(struct.pack("<3f", *c) for c in corners), 5126, 8, "VEC3"),
                                         (struct.pack("<36H", *indices), 5123, 36, "SCALAR")):
        views.append({"buffer": 0, "byteOffset": len(binary), "byteLength": len(data)})
        accessors.append({"bufferView": len(views) - 1, "componentType": component, "count": count, "type": kind})
        binary += data
    accessors[-2].update(min=[0, -1, 0], max=[1, 0, 1])
    model.setdefault("materials", []).append(
        {"name": "floor", "pbrMetallicRoughness": {"baseColorFactor": [0.35, 0.36, 0.38, 1], "metallicFactor": 0}})
    model["meshes"].append({"name": "floor", "primitives": [{"attributes": {"POSITION": len(accessors) - 2},
                                                             "indices": len(accessors) - 1,
                                                             "material": len(model["materials"]) - 1}]})
    return len(model["meshes"]) - 1, binary


class Builder:
    def __init__(self, model, roots):
        self.source, self.roots, self.nodes = model["nodes"], roots, []

    def add(self, node):
        self.nodes.append(node)
        return len(self.nodes) - 1

    def copy(self, index):
        node = {k: v for k, v in self.source[index].items() if k not in ("children", "camera", "skin")}
        children = [self.copy(child) for child in self.source[index].get("children", ())]
        return self.add({**node, **({"children": children} if children else {})})

    def machine(self, x, y, angle, middle):
        """The model, rotated about its centre, which moves to (x, y, 0)."""
        sine, cosine = math.sin(angle), math.cos(angle)
        tx, tz = x - (cosine * middle[0] + sine * middle[2]), -(-sine * middle[0] + cosine * middle[2])
        return self.add({"name": "machine", "translation": [tx, y - middle[1], tz],
                         "rotation": [0, math.sin(angle / 2), 0, math.cos(angle / 2)],
                         "children": [self.copy(root) for root in self.roots]})

    def slab(self, mesh, at, size):
        return self.add({"name": "floor", "mesh": mesh, "translation": at, "scale": size})

    def rack(self, mesh, row, step, row_step, tall, reach, middle):
        """Shelves of machines, stacked."""
        parts = []
        for level in range(LEVELS):
            y = level * tall
            parts += [self.machine((i + 0.5) * step, y, (level % 2) * math.pi, middle) for i in range(ROW)]
            if level > 0:
                parts.append(self.slab(mesh, [0, y, -0.3 * reach], [ROW * step, 0.05 * tall, 0.6 * reach]))
        return self.add({"name": f"rack {row + 1}", "translation": [0, 0, (row + 0.5) * row_step], "children": parts})


def main():
    if len(sys.argv) not in (4, 5):
        sys.exit(__doc__)
    model, binary = read_glb(sys.argv[1])
    halls = max(1, -(-int(sys.argv[4] if len(sys.argv) == 5 else 1200) // MACHINES))
    roots = model["scenes"][model.get("scene", 0)]["nodes"]
    low, high = bounds(model, roots)
    reach = max(high[0] - low[0], high[2] - low[2])
    middle = [(low[0] + high[0]) / 2, low[1], (low[2] + high[2]) / 2]
    tall = 1.25 * (high[1] - low[1])
    step, row_step, lane = 1.08 * reach, 1.5 * reach, 1.6 * reach
    width, depth = ROW * step, ROWS * row_step
    slab, binary = add_slab(model, binary)
    build, plant = Builder(model, roots), []
    lines = max(n for n in range(1, math.isqrt(halls) + 1) if halls % n == 0)
    columns = halls // lines
    for hall in range(halls):
        rows = [build.rack(slab, row, step, row_step, tall, reach, middle) for row in range(ROWS)]
        at = [(hall % columns) * (width + lane), 0, (hall // columns) * (depth + lane)]
        plant.append(build.add({"name": f"hall {hall + 1}", "translation": at, "children": rows}))
    size = [columns * (width + lane) - lane, LEVELS * tall, lines * (depth + lane) - lane]
    plant.append(build.slab(slab, [-lane, 0, -lane], [size[0] + 2 * lane, 0.05 * reach, size[2] + 2 * lane]))
    root = build.add({"name": "plant", "children": plant})
    model["buffers"] = [{"byteLength": len(binary)}]
    model.update(nodes=build.nodes, scenes=[{"nodes": [root]}], scene=0)
    for key in ("animations", "skins", "cameras"):
        model.pop(key, None)
    write_glb(sys.argv[2], model, binary)
    path = flight(size, width, lane, tall)
    json.dump(path, open(sys.argv[3], "w"))
    print(f"{halls * MACHINES} machines in {halls} halls")


def flight(size, width, lane, tall):
    middle, across = [size[0] / 2, 0, size[2] / 2], math.hypot(size[0], size[2])
    alley = width + lane / 2 if size[0] > width else -lane / 2
    keys = [(0, [middle[0] + 0.45 * across, 0.32 * across, middle[2] + 0.62 * across], middle),
            (3, [middle[0] - 0.2 * across, 0.2 * across, middle[2] + 0.6 * across], middle),
            (6, [alley, 8 * tall, size[2] * 1.12], [alley, 0, 0.62 * size[2]]),
            (9, [alley, 1.6 * tall, 0.7 * size[2]], [alley, 1.6 * tall, 0.2 * size[2]]),
            (12, [alley, 2.5 * tall, 0.45 * size[2]], [alley - width / 2, 1.5 * tall, 0.3 * size[2]])]
    return {"fov": 60, "fps": 30,
            "keys": [{"t": t, "eye": eye, "target": target, "up": [0, 1, 0]} for t, eye, target in keys]}


main()
