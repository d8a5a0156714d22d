#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Reads a .stip file: verifies every checksum and count, and prints its content as JSON.

    read_store.py FILE.stip [--expect EXPECTED.json]

Written from docs/format.md alone, using only the standard library. If this script and the library
disagree about a file, one of the three is wrong. With --expect, each value of EXPECTED.json must
occur in the output.
"""
import argparse
import json
import math
import struct
import sys
import zlib

from read_levels import check_levels
from read_operators import Operators

NONE = 0xFFFFFFFF
MAGIC = b"\x89STP\r\n\x1a\n"

# Records: struct format (little-endian) and field names. "name:text" is resolved, "reserved" must
# be 0.
RECORDS = {
    1: ("nodes", "6I2Q6d", "first_edge edge_count first_part part_count surfels flags triangle_count point_count "
                           "bounds_min:3 bounds_max:3"),
    2: ("edges", "2I12d", "node reserved transform:12"),
    3: ("parts", "2I", "kind index"),
    4: ("materials", "3I10fI" + 3 * "2I6f",
        "name:text flags alpha alpha_cutoff base_color:4 metallic roughness emissive:3 reserved "
        "base_color_texture:8 metallic_roughness_texture:8 emissive_texture:8"),
    5: ("shadings", "5fI", "metallic roughness emissive:3 flags"),
    6: ("textures", "6I", "width height wrap_u wrap_v nearest block"),
    7: ("meshes", "6I6f", "name:text vertex_count triangle_count material present block bounds_min:3 bounds_max:3"),
    8: ("point_sets", "6I6f", "name:text point_count material present block held_by bounds_min:3 bounds_max:3"),
    9: ("surfels", "6I6f", "count octave_count first_octave breakpoint_count first_breakpoint paper_count "
                           "origin:3 step candidate_radius paper_radius"),
    10: ("octaves", "2I", "end block"),
    11: ("breakpoints", "If", "count radius"),
    12: ("views", "2I10d", "name:text reserved eye:3 target:3 up:3 fov_degrees"),
    13: ("sources", "2IQ", "path:text format:text bytes"),
    14: ("blocks", "4I2QfI", "kind owner octave crc offset size radius encoding"),
    19: ("summary", "17Q6d4I", "FIGURES bounds_min:3 bounds_max:3 material_count texture_count mesh_count "
                               "point_set_count"),
    20: ("scene_parts", "2I17Q", "name:text object FIGURES"),
    21: ("pages", "I", "crc"),
    22: ("keys", "2Q", "low high"),
    17: ("objects", "4I12d", "name:text id:text parent node transform:12"),
    32: ("clusters", "I", "cluster_count"),
    35: ("methods", "6I", "name:text id columns first_set set_count reserved"),
    36: ("method_nodes", "I", "node"),
    34: ("attributes", "2IQ4d", "attribute reserved count low high low_percentile high_percentile"),
    37: ("attribute_values", "2IQ", "attribute value count"),
    38: ("attribute_blocks", "2I", "block attributes"),
    39: ("coordinates", "I", "text:text"),
    40: ("leaves", "2I", "leaf_count block"),
    41: ("certainty", "If", "flags position_error"),
    42: ("levels", "2I", "node flags"),
    43: ("level_clusters", "3I", "made_by used_by one_sided"),
    44: ("level_groups", "5f", "center:3 radius error"),
    45: ("level_figures", "3Q", "levels triangles bytes"),
    46: ("sides", "2IQ", "flags inverted triangles"),
    47: ("growths", "f", "growth"),
    48: ("normal_maps", "If2I6f", "material scale texture:8"),
}
FIGURES = ("objects unique_objects instances nodes unique_nodes lods unique_lods triangles unique_triangles points "
           "unique_points surfels unique_surfels splat_bytes triangle_bytes point_bytes texture_bytes")
TEXT_SECTIONS = {15: "text", 16: "build", 18: "object_text"}
KINDS = {1: "meshes", 2: "point_sets", 3: "textures", 4: "surfels", 5: "meshes", 9: "leaves"}


def need(condition, what):
    if not condition:
        raise ValueError(what)


def align(offset, multiple=64):
    return -(-offset // multiple) * multiple


def read_header(data):
    need(data[:8] == MAGIC[:len(data[:8])], "is not a .stip file, or was damaged by a transfer")
    need(len(data) >= 128, "ends within its header")
    major, minor, header_size, file_size, data_offset, sections, table_crc, root, reserved = struct.unpack_from(
        "<HHIQQIIII", data, 8)
    need(major <= 1, f"unsupported version {major}")
    need(zlib.crc32(data[:124]) == struct.unpack_from("<I", data, 124)[0], "header: wrong checksum")
    need(major == 1 and header_size == 128, "header: wrong version or size")
    need(reserved == 0 and not any(data[57:124]), "header: reserved bytes")
    need(file_size == len(data), f"has {len(data)} bytes; the header states {file_size}")
    need(data_offset <= file_size and data_offset % 64 == 0, "header: data_offset")
    need(sections <= 256 and 128 + 40 * sections <= data_offset, "header: section_count")
    need(zlib.crc32(data[128:128 + 40 * sections]) == table_crc, "section table: wrong checksum")
    unit, up = struct.unpack_from("<dc", data, 48)
    need(math.isfinite(unit) and unit >= 0 and up in (b"x", b"y", b"z"), "header: unit or up axis")
    return {"version": [major, minor], "file_bytes": file_size, "data_offset": data_offset, "root": root,
            "unit_metres": unit, "up": up.decode(), "section_count": sections}


def read_sections(data, header):
    end = 128 + 40 * header["section_count"]
    sections = {}
    for i in range(header["section_count"]):
        kind, flags, offset, size, count, record_size, crc = struct.unpack_from("<IIQQQII", data, 128 + 40 * i)
        place = f"section {i} of type {kind}"
        need(offset == align(end) and offset + size <= header["data_offset"], f"{place}: wrong offset")
        need(not any(data[end:offset]), f"{place}: bytes before it")
        need(flags <= 3 and count < NONE and record_size > 0, f"{place}: flags, count or record_size")
        content = data[offset:offset + size]
        if flags & 2:
            need(kind != 21, f"{place}: is packed")
            content = unpack_section(content, count * record_size, 65536 // record_size * record_size, crc, place)
        else:
            need(zlib.crc32(content) == crc, f"{place}: wrong checksum")
        need(len(content) == count * record_size, f"{place}: size")
        end = offset + size
        if kind in RECORDS or kind in TEXT_SECTIONS:
            need(kind not in sections, f"{place}: occurs twice")
            sections[kind] = (content, count, record_size)
        else:
            need(not flags & 1, f"{place}: critical and unknown")
    need(header["data_offset"] == align(end) and not any(data[end:header["data_offset"]]), "data_offset")
    check_pages(data, header, sections)
    return sections


def unpack_section(stored, length, page_bytes, crc, place):
    """The content of a packed section, joined from its pages."""
    need(page_bytes > 0, f"{place}: its records are longer than a page")
    at = 8 * -(-length // page_bytes)
    need(at <= len(stored) and zlib.crc32(stored[:at]) == crc, f"{place}: table of pages")
    content = []
    for i, (size, page_crc) in enumerate(struct.iter_unpack("<2I", stored[:at])):
        page, at = stored[at:at + size], at + size
        need(len(page) == size and zlib.crc32(page) == page_crc, f"{place}: page {i}")
        content.append(unpack(page, min(page_bytes, length - i * page_bytes), f"{place}: page {i}"))
    need(at == len(stored), f"{place}: bytes after the last page")
    return b"".join(content)


def unpack(piece, length, place):
    """The content of a chunk or page."""
    need(length >= len(piece) >= length // 32, f"{place}: size")
    if len(piece) < length:
        inflater = zlib.decompressobj(-15)
        piece = inflater.decompress(piece, length + 1)
        need(inflater.eof and len(piece) == length and not any(inflater.unused_data), f"{place}: compression")
    return piece


def check_pages(data, header, sections):
    if 21 not in sections:
        return
    pages = []
    for i in range(header["section_count"]):
        kind, flags, begin, size = struct.unpack_from("<IIQQ", data, 128 + 40 * i)
        pages += [zlib.crc32(data[at:min(at + 16384, begin + size)]) for at in range(begin, begin + size, 16384)
                  if kind != 21 and not flags & 2]
    content, count, record_size = sections[21]
    need(pages == [struct.unpack_from("<I", content, i * record_size)[0] for i in range(count)],
         "checksums of pages")


def read_text(texts, offset):
    if offset == NONE:
        return None
    need(offset < len(texts), f"a text at {offset}, beyond the texts")
    return texts[offset:texts.index(b"\0", offset)].decode("utf-8", "replace")


def read_record(values, names, texts, place):
    record, at = {}, 0
    for name in names:
        name, _, what = name.partition(":")
        if what.isdigit():
            record[name] = list(values[at:at + int(what)])
            at += int(what)
        else:
            record[name] = read_text(texts, values[at]) if what else values[at]
            at += 1
    need(record.pop("reserved", 0) == 0, f"{place}: reserved field")
    need(all(math.isfinite(v) for v in values), f"{place}: a number that is not finite")
    return record


def read_tables(sections):
    texts = {}
    for kind, name in TEXT_SECTIONS.items():
        texts[kind], _, record_size = sections.get(kind, (b"", 0, 1))
        need(record_size == 1 and (not texts[kind] or texts[kind][-1] == 0), f"{name}: does not end with a zero byte")
    tables = {"build": read_text(texts[16], 0) if texts[16] else None}
    for kind, (name, layout, names) in RECORDS.items():
        content, count, record_size = sections.get(kind, (b"", 0, 1 << 20))
        need(record_size >= struct.calcsize("<" + layout), f"{name}: records are too short")
        text = texts[18] if name == "objects" else texts[15]
        tables[name] = [read_record(struct.unpack_from("<" + layout, content, i * record_size),
                                    names.replace("FIGURES", FIGURES).split(),
                                    text, f"{name} {i}") for i in range(count)]
    return tables


def check_reference(value, count, place, none=True):
    need(value < count or (none and value == NONE), f"{place}: {value} is not below {count}")


def check_graph(header, t):
    counts = {name: len(table) for name, table in t.items() if isinstance(table, list)}
    check_reference(header["root"], counts["nodes"], "root")
    need(sum(n["edge_count"] for n in t["nodes"]) <= counts["edges"], "nodes: edges")
    need(sum(n["part_count"] for n in t["nodes"]) <= counts["parts"], "nodes: parts")
    for i, node in enumerate(t["nodes"]):
        first, count = node["first_edge"], node["edge_count"]
        need(first + count <= counts["edges"], f"node {i}: edges")
        need(node["first_part"] + node["part_count"] <= counts["parts"], f"node {i}: parts")
        need(all(edge["node"] < i for edge in t["edges"][first:first + count]), f"node {i}: a child is not lower")
        check_reference(node["surfels"], counts["surfels"], f"node {i}: surfels")
        need(node["flags"] <= 1, f"node {i}: flags")
    for i, edge in enumerate(t["edges"]):
        check_reference(edge["node"], counts["nodes"], f"edge {i}", False)
    for i, part in enumerate(t["parts"]):
        need(part["kind"] <= 1, f"part {i}: kind")
        check_reference(part["index"], counts["point_sets" if part["kind"] else "meshes"], f"part {i}", False)
    for i, thing in enumerate(t["objects"]):
        check_reference(thing["parent"], i, f"object {i}: parent")
        check_reference(thing["node"], counts["nodes"], f"object {i}: node")
    for i, material in enumerate(t["materials"]):
        need(material["flags"] <= 3 and material["alpha"] <= 2, f"material {i}: flags or alpha")
        for use in ("base_color_texture", "metallic_roughness_texture", "emissive_texture"):
            check_reference(material[use][0], counts["textures"], f"material {i}: {use}")
            need(material[use][1] <= 1, f"material {i}: texcoord")
    last = -1
    for i, normal_map in enumerate(t["normal_maps"]):
        check_reference(normal_map["material"], counts["materials"], f"normal map {i}: material", False)
        check_reference(normal_map["texture"][0], counts["textures"], f"normal map {i}: texture", False)
        need(last < normal_map["material"] and normal_map["texture"][1] <= 1 and normal_map["scale"] != 0,
             f"normal map {i}")
        last = normal_map["material"]
    need(counts["growths"] in (0, counts["shadings"]), "growths")
    need(all(-1 < s["growth"] <= 63 for s in t["growths"]), "growths")
    need(counts["shadings"] <= 256 and all(s["flags"] <= 7 for s in t["shadings"]), "shadings")
    for i, texture in enumerate(t["textures"]):
        need(0 < texture["width"] <= 65536 and 0 < texture["height"] <= 65536, f"texture {i}: size")
        need(texture["wrap_u"] <= 2 and texture["wrap_v"] <= 2 and texture["nearest"] <= 1, f"texture {i}: wrap")
    need(len(t["summary"]) <= 1 and len(t["scene_parts"]) <= (65 if t["summary"] else 0), "summary or scene parts")
    for i, part in enumerate(t["scene_parts"]):
        check_reference(part["object"], counts["objects"], f"scene part {i}: object")
    need(counts["clusters"] in (0, counts["meshes"]), "clusters")
    need(counts["leaves"] in (0, counts["surfels"]), "leaves")
    need(counts["certainty"] in (0, counts["surfels"]), "certainty")
    for i, certainty in enumerate(t["certainty"]):
        need(certainty["flags"] <= 1 and certainty["position_error"] >= 0, f"splat set {i}: certainty")
    need(counts["sides"] in (0, counts["materials"] + counts["shadings"]), "sides")
    for i, sides in enumerate(t["sides"]):
        need(sides["flags"] <= 1, f"sides {i}: flags")
    for i, leaves in enumerate(t["leaves"]):
        leaves["set"] = t["surfels"][i]
        need(leaves["leaf_count"] > 0 or leaves["block"] == NONE, f"splat set {i}: a block without leaves")
    for i, mesh in enumerate(t["meshes"]):
        mesh["cluster_count"] = t["clusters"][i]["cluster_count"] if t["clusters"] else NONE
    need(counts["keys"] in (0, counts["surfels"] + counts["meshes"]), "keys")
    t["keys"] = [f"{key['high']:016x}{key['low']:016x}" for key in t["keys"]]
    for name in ("meshes", "point_sets"):
        for i, thing in enumerate(t[name]):
            check_reference(thing["material"], counts["materials"], f"{name} {i}: material", False)


def gather_methods(t):
    """Gives each set its method's columns; sets of all methods but the first name their nodes."""
    if not t["methods"]:
        t["methods"] = [{"name": "blue", "id": 1, "columns": 0, "first_set": 0, "set_count": len(t["surfels"])}]
    methods, first = t["methods"], t["methods"][0]["set_count"]
    nodes, end = [record["node"] for record in t.pop("method_nodes")], 0
    need(len(methods) <= 16 and len({method["id"] for method in methods}) == len(methods), "methods")
    for i, method in enumerate(methods):
        need(method["name"] and method["id"] > 0 and method["columns"] <= 31 and method["columns"] & 18 != 16, f"method {i}")
        need(method["first_set"] == end, f"method {i}: its sets do not follow those of the method before")
        end += method["set_count"]
        need(end <= len(t["surfels"]), f"method {i}: sets")
        for s in t["surfels"][method["first_set"]:end]:
            s["method_columns"] = method["columns"]
        if i > 0:
            method["nodes"] = nodes[method["first_set"] - first:end - first]
            need(len(set(method["nodes"])) == method["set_count"], f"method {i}: two sets are of one node")
            need(all(node < len(t["nodes"]) for node in method["nodes"]), f"method {i}: nodes")
    need(end == len(t["surfels"]) and len(nodes) == end - first, "sets of no method")
    need(all(n["surfels"] == NONE or n["surfels"] < first for n in t["nodes"]), "a node's set is not of the first method")


def gather_sets(t):
    octave, breakpoint_ = 0, 0
    for i, s in enumerate(t["surfels"]):
        place = f"splat set {i}"
        need(s["first_octave"] == octave and s["first_breakpoint"] == breakpoint_, f"{place}: order")
        need(s["octave_count"] <= 24 and s["breakpoint_count"] <= 64, f"{place}: octaves or breakpoints")
        octaves = t["octaves"][octave:octave + s["octave_count"]]
        points = t["breakpoints"][breakpoint_:breakpoint_ + s["breakpoint_count"]]
        octave, breakpoint_ = octave + s["octave_count"], breakpoint_ + s["breakpoint_count"]
        need(len(octaves) == s["octave_count"] and len(points) == s["breakpoint_count"], f"{place}: tables end")
        s["octave_ends"] = [o["end"] for o in octaves]
        s["blocks"] = [o["block"] for o in octaves]
        s["breakpoints"] = [[p["count"], p["radius"]] for p in points]
        need((s["octave_ends"] or [0])[-1] == s["count"], f"{place}: the last octave")
        for low, high in zip([0] + s["octave_ends"], s["octave_ends"]):
            need(low < high, f"{place}: octaves do not ascend")
        need(s["blocks"] == sorted(set(s["blocks"])), f"{place}: blocks are not in order")
        for a, b in zip(s["breakpoints"], s["breakpoints"][1:]):
            need(a[0] < b[0] and a[1] >= b[1], f"{place}: breakpoints are not monotone")
        need(all(n <= s["count"] and r >= 0 for n, r in s["breakpoints"]), f"{place}: breakpoints")
        need(s["count"] == 0 or (s["step"] > 0 and math.frexp(s["step"])[0] == 0.5), f"{place}: step")
        need(s["paper_count"] <= s["count"] and s["paper_radius"] >= 0 and s["candidate_radius"] >= 0,
             f"{place}: paper_count or a radius")
    need(octave == len(t["octaves"]) and breakpoint_ == len(t["breakpoints"]), "octaves or breakpoints are left over")


def block_columns(t, block):
    """The record of a block, its columns with their sizes, and their alignment."""
    record = t[KINDS[block["kind"]]][block["owner"]]
    if block["kind"] == 5:
        return record, [], 1
    if block["kind"] == 9:
        return record, [("leaves", 16 * record["leaf_count"])], 1
    n = record.get("vertex_count", record.get("point_count", 0))
    has = record.get("present", 0)
    corners = [("positions", 12 * n), ("normals", 4 * n * (has & 1))]
    if block["kind"] == 1:
        return record, corners + [("texcoords_0", 8 * n * (has >> 2 & 1)), ("texcoords_1", 8 * n * (has >> 3 & 1)),
                                  ("colors", 8 * n * (has >> 1 & 1)), ("indices", 12 * record["triangle_count"])], 16
    if block["kind"] == 2:
        return record, corners + [("colors", 4 * n * (has >> 1 & 1))], 16
    if block["kind"] == 3 and block["encoding"] != 0:
        return record, [("picture", block["size"])], 1
    if block["kind"] == 3:
        return record, [("texels", 4 * record["width"] * record["height"])], 16
    end = record["octave_ends"][block["octave"]]
    n = end - ([0] + record["octave_ends"])[block["octave"]]
    has = record["method_columns"]
    entries = n if has & 4 else end
    lights = end if block["encoding"] == 3 else 0
    return record, [("positions", 6 * n), ("normals", 2 * n), ("materials", n), ("colors", 3 * entries),
                    ("coverages", entries), ("shapes", 4 * n * (has & 1)), ("ranges", 4 * n * (has >> 1 & 1)),
                    ("errors", 4 * n * (has >> 4 & 1)), ("turns", 2 * lights), ("spreads", lights)], 1


def picture_size(encoding, data):
    """Width and height in the header of a PNG, JPEG or WebP file."""
    if encoding == 1:
        need(data[:8] == b"\x89PNG\r\n\x1a\n" and data[12:16] == b"IHDR", "no PNG")
        return struct.unpack_from(">2I", data, 16)
    if encoding == 2:
        need(data[:2] == b"\xff\xd8", "no JPEG")
        at = 2
        while data[at + 1] not in (0xC0, 0xC1, 0xC2):  # the frame header; skips segments before it
            at += 2 + struct.unpack_from(">H", data, at + 2)[0]
        return struct.unpack_from(">2H", data, at + 5)[::-1]
    need(data[:4] == b"RIFF" and data[8:12] == b"WEBP", "no WebP")
    if data[12:16] == b"VP8X":
        return tuple(1 + int.from_bytes(data[i:i + 3], "little") for i in (24, 27))
    if data[12:16] == b"VP8L":
        bits = struct.unpack_from("<I", data, 21)[0]
        return 1 + (bits & 0x3FFF), 1 + (bits >> 14 & 0x3FFF)
    return tuple(v & 0x3FFF for v in struct.unpack_from("<2H", data, 26))


def check_textures(t):
    """Textures may share the block of an earlier texture, which is a picture file of their size."""
    for i, texture in enumerate(t["textures"]):
        need(texture["block"] < len(t["blocks"]), f"texture {i}: its block does not exist")
        block = t["blocks"][texture["block"]]
        owner = t["textures"][block["owner"]] if block["owner"] <= i else None
        need(block["kind"] == 3 and owner is not None and owner["block"] == texture["block"], f"texture {i}: block")
        if owner is not texture:
            same = all(owner[k] == texture[k] for k in ("width", "height"))
            need(same and block["encoding"] != 0, f"texture {i}: shares a block")
            texture["columns"] = owner["columns"]


def check_content(t, record, block, name, column, place):
    if name in ("positions", "texcoords_0", "texcoords_1") and block["kind"] <= 2:
        need(all(math.isfinite(v[0]) for v in struct.iter_unpack("<f", column)), f"{place}: {name} not finite")
    if name == "indices":
        need(all(v[0] < record["vertex_count"] for v in struct.iter_unpack("<I", column)), f"{place}: indices")
    if name == "picture":
        need(picture_size(block["encoding"], column) == (record["width"], record["height"]), f"{place}: picture size")
    if name == "leaves":
        check_leaves(record["set"], column, place)
    if name == "shapes":
        need(all(v[0] & 0xFFF != 0xFFF and v[0] >> 12 & 0xFFF <= v[0] & 0xFFF for v in struct.iter_unpack("<I", column)),
             f"{place}: shapes")
    if name == "ranges":
        need(all(low <= high <= 0xFF00 for low, high in struct.iter_unpack("<2H", column)), f"{place}: ranges")
    if name == "materials":
        need(max(column, default=-1) < len(t["shadings"]), f"{place}: materials")


def check_leaves(surfels, column, place):
    """Checks that leaves are disjoint cubes along the curve, with all splats of the set."""
    end, total = 0, 0
    for *corner, where, extent, count, _, _, _, _ in struct.iter_unpack("<3H2BI2b2B", column):
        depth = where & 31
        width = 1 << (16 - min(depth, 16))
        need(depth <= 16 and where < 128 and extent > 0 and count > 0, f"{place}: a leaf")
        need(all(c % width == 0 for c in corner), f"{place}: a leaf is not a cube of the grid")
        code = sum((corner[k] >> bit & 1) << (3 * bit + k) for bit in range(16) for k in range(3))
        need(code >= end, f"{place}: leaves overlap, or are not along the curve")
        end, total = code + width ** 3, total + count
    octaves = 1
    while total >> 2 * (octaves - 1) >= 64:
        octaves += 1
    need(total == surfels["count"], f"{place}: splats of leaves")
    need(surfels["octave_ends"] == [total >> 2 * (octaves - 1 - k) for k in range(octaves)], f"{place}: octaves")


class Cluster:
    """One cluster of a coded mesh: its triangles' corners, and their values by channel."""

    def __init__(self, data, at, entry, present):
        self.offset, self.first_triangle = struct.unpack_from("<2I", data, entry)
        self.triangle_count, last_vertex, self.smooth, self.faces, group = struct.unpack_from("<5B", data, entry + 23)
        counts, own = struct.unpack_from("<2H", data, entry + 28)
        self.normal_count, shift, repeats, grouped = counts & 511, counts >> 9 & 31, counts >> 14 & 1, own >> 15
        self.vertex_count = last_vertex + 1
        need(4 * self.offset == at and counts >> 15 == 0, "wrong offset of a cluster")
        need(1 <= self.triangle_count <= 128 and self.smooth + self.faces <= self.triangle_count and
             self.normal_count <= self.vertex_count, "counts of a cluster")
        parts = -(-self.vertex_count // group) if group else 1
        period = self.triangle_count // parts if repeats else self.triangle_count
        lit = self.smooth + self.faces
        need(group or not (repeats or grouped), "parts of a cluster")
        need(not repeats or (group * parts == self.vertex_count and period * parts == self.triangle_count and
                             (lit == 0 or (lit, self.normal_count) == (self.triangle_count, self.vertex_count))),
             "repeated parts of a cluster")
        sizes = [(2, self.normal_count), (2, self.vertex_count * (present >> 2 & 1)),
                 (2, self.vertex_count * (present >> 3 & 1)), (4, self.vertex_count * (present >> 1 & 1))]
        origins, widths = struct.unpack_from("<3i", data, entry + 8), data[entry + 20:entry + 23]
        channels = [(self.vertex_count, (origins[k], widths[k], own >> 5 * k & 31, grouped, shift)) for k in range(3)]
        for channel_count, count in sizes:
            for _ in range(channel_count):
                channels.append((count, struct.unpack_from("<i4B", data, at) if count else None))
                at += 8 if count else 0
        self.indices = [group * (i // (3 * period)) + data[at + i % (3 * period)] for i in range(3 * self.triangle_count)]
        at += 3 * period
        self.values = []
        for count, channel in channels:
            values = []
            if count:
                values, at = self.read_channel(data, at, count, group, *channel)
            self.values.append(values)
        self.end = align(at, 4)
        need(max(self.indices) < self.vertex_count, "indices of a cluster")
        for i, index in enumerate(self.indices):
            if i < 3 * self.smooth or (i < 3 * (self.smooth + self.faces) and i % 3 == 0):
                need(index < self.normal_count, "a corner without a normal")

    @staticmethod
    def read_channel(data, at, count, group, origin, width, own_width, layout, shift):
        """The values of a channel that begins at `at`, and its end."""
        need(width <= 32 and own_width <= 32 and shift <= 24 and layout <= 2 and
             (group != 0 if layout else own_width == 0), "a channel of a cluster")

        def bits(at, count, width):
            size = (count * width + 7) // 8
            number = int.from_bytes(data[at:at + size], "little")
            return [number >> i * width & (1 << width) - 1 for i in range(count)], at + size

        if layout == 0:
            values, at = bits(at, count, width)
        else:
            bases, at = bits(at, -(-count // group), width)
            owns, at = bits(at, count if layout == 1 else group, own_width)
            values = [bases[i // group] + owns[i if layout == 1 else i % group] for i in range(count)]
        return [origin + (value << shift) for value in values], at

    def corners(self, channels, triangles, first=False):
        """The values of these channels at the corners of the first triangles (or of their first corner)."""
        return [self.values[c][self.indices[i - i % 3 if first and i >= 3 * self.smooth else i]]
                for i in range(3 * triangles) for c in channels if self.values[c]]


def read_clusters(data, begin, end, record):
    count, triangles, vertices, present, step, u, v, reserved = struct.unpack_from("<3IH3hI", data, begin)
    need((count, triangles, vertices, present, reserved) == (record["cluster_count"], record["triangle_count"],
                                                            record["vertex_count"], record["present"], 0), "counts")
    need(all(-149 <= exponent <= 96 for exponent in (step, u, v)), "steps")
    record["step"] = 2.0 ** step
    at, first, sums = 24 + 32 * count, 0, dict.fromkeys(("corners", "normals", "texcoords_0", "texcoords_1", "colors"), 0)
    block = data[begin:end]
    for i in range(count):
        cluster = Cluster(block, at, 24 + 32 * i, present)
        need(cluster.first_triangle == first, "triangles do not follow each other")
        lit = cluster.smooth + cluster.faces
        for name, values in (("corners", cluster.corners((0, 1, 2), cluster.triangle_count)),
                             ("normals", cluster.corners((3, 4), lit, True)),
                             ("texcoords_0", cluster.corners((5, 6), cluster.triangle_count)),
                             ("texcoords_1", cluster.corners((7, 8), cluster.triangle_count)),
                             ("colors", cluster.corners((9, 10, 11, 12), cluster.triangle_count))):
            sums[name] = zlib.crc32(struct.pack(f"<{len(values)}i", *values), sums[name])
        need(not record.get("one_sided") or record["one_sided"][i] <= cluster.triangle_count, "one_sided")
        at, first, vertices = cluster.end, first + cluster.triangle_count, vertices - cluster.vertex_count
    need(first == triangles and vertices == 0 and at + 8 == len(block) and not any(block[at:]), "end")
    record["columns"] = sums


def chunk_ends(at, first, end, color_bytes, place_bytes):
    """The surfels at the ends of an octave's chunks, the first of which begins at `at`: 64 KiB hold
    `color_bytes` each and `place_bytes` more from `first` on."""
    most = 65536 // color_bytes
    while at < end:
        room = 65536 - color_bytes * max(0, min(at + most, first) - at)
        at = at + most if at + most <= first else max(at, first) + room // (color_bytes + place_bytes)
        yield min(at, end)


def unpack_octave(record, block, stored, place):
    """The columns of a compressed octave, joined from its chunks."""
    end = record["octave_ends"][block["octave"]]
    first = ([0] + record["octave_ends"])[block["octave"]]
    has = record["method_columns"]
    shape, level, errors = 4 * (has & 1), 4 * (has >> 1 & 1), 4 * (has >> 4 & 1)
    start = first if has & 4 else 0
    lights = 3 if block["encoding"] == 3 else 0
    ends = list(chunk_ends(start, first, end, 4 + lights, 9 + shape + level + errors))
    table = [(len(stored), block["crc"])]
    at = 0
    if len(ends) > 1:
        at = 8 * len(ends)
        need(at <= len(stored) and zlib.crc32(stored[:at]) == block["crc"], f"{place}: chunk table")
        table = list(struct.iter_unpack("<2I", stored[:at]))
    columns = {name: b"" for name in ("positions", "normals", "materials", "colors", "coverages", "shapes", "ranges", "errors",
                                      "turns", "spreads")}
    operators = record.setdefault("operators", Operators(record["step"])) if has == 7 else None
    need(block["encoding"] == 1 or (operators if block["encoding"] == 2 else has == 0), f"{place}: encoding")
    for begin, stop, (size, crc) in zip([start] + ends, ends, table):
        chunk, at = stored[at:at + size], at + size
        places, colors = max(0, stop - max(begin, first)), stop - begin
        length = (9 + shape + level + errors) * places + (4 + lights) * colors
        need(len(chunk) == size and zlib.crc32(chunk) == crc, f"{place}: chunk")
        if block["encoding"] != 2 or size == length:
            chunk = unpack(chunk, length, f"{place}: chunk")
            if operators:
                operators.skip(chunk, places)
        else:
            need(length > size >= length // 32, f"{place}: size")
            try:
                chunk = operators.decode(chunk, places)
            except (ValueError, struct.error) as fault:
                raise ValueError(f"{place}: operators: {fault}") from fault
        part = 0
        for name, step in (("positions", 6 * places), ("normals", 2 * places), ("materials", places), ("colors", 3 * colors),
                           ("coverages", colors), ("shapes", shape * places), ("ranges", level * places),
                           ("errors", errors * places), ("turns", 2 * colors if lights else 0),
                           ("spreads", colors if lights else 0)):
            columns[name] += chunk[part:part + step]
            part += step
    need(at == len(stored), f"{place}: bytes after the last chunk")
    return b"".join(columns.values())


ATTRIBUTES = "HBBBhHdH"  # types of values, by attribute


def read_values(t, block, attributes, stored, place):
    """The columns of a block of attributes, by attribute: lists of values."""
    if block["kind"] == 7:
        ends = [0] + t["surfels"][block["owner"]]["octave_ends"]
        count = ends[block["octave"] + 1] - ends[block["octave"]]
    else:
        need(block["octave"] == 0, f"{place}: octave")
        count = t["point_sets"][block["owner"]]["point_count"]
    runs = []
    for a, letter in enumerate(ATTRIBUTES):
        size = struct.calcsize("<" + letter)
        if attributes >> a & 1:
            runs += [(a, letter, size, min(65536 // size, count - i)) for i in range(0, count, 65536 // size)]
    begin, at, columns = len(stored) - 8 * len(runs) - 4, 0, {}
    need(begin >= 0 and zlib.crc32(stored[begin:-4]) == struct.unpack_from("<I", stored, len(stored) - 4)[0],
         f"{place}: checksum of its table")
    for i, (a, letter, size, n) in enumerate(runs):
        length, crc = struct.unpack_from("<II", stored, begin + 8 * i)
        chunk = stored[at:at + length]
        need(at + length <= begin and zlib.crc32(chunk) == crc, f"{place}: chunk {i}")
        at += length
        if length < n * size:
            need(length >= n * size // 32, f"{place}: chunk {i} is too short")
            unpacker = zlib.decompressobj(-15)
            chunk = unpacker.decompress(chunk)
            need(unpacker.eof and not any(unpacker.unused_data), f"{place}: chunk {i}")
        need(len(chunk) == n * size, f"{place}: chunk {i}")
        numbers = [int.from_bytes(chunk[k::n], "little") for k in range(n)]
        for k in range(1, n if block["kind"] == 8 else 0):
            numbers[k] = (numbers[k] + numbers[k - 1]) % 256 ** size
        joined = b"".join(number.to_bytes(size, "little") for number in numbers)
        columns.setdefault(a, []).extend(struct.unpack(f"<{n}{letter}", joined))
    need(at == begin, f"{place}: bytes between chunks and table")
    need(all(map(math.isfinite, columns.get(6, []))), f"{place}: a time")
    return columns


def read_attributes(data, t):
    """Checks blocks of attributes, and their statistics against the points."""
    blocks = [i for i, block in enumerate(t["blocks"]) if block["kind"] in (7, 8)]
    need([record["block"] for record in t["attribute_blocks"]] == blocks, "blocks of attributes")
    owners, points = set(), {}
    for record in t["attribute_blocks"]:
        block, place = t["blocks"][record["block"]], f"block {record['block']}"
        need(block["encoding"] == 0 and 1 <= record["attributes"] <= 255, f"{place}: attributes")
        need(block["owner"] < len(t["surfels" if block["kind"] == 7 else "point_sets"]), f"{place}: owner")
        owners.add((block["kind"], block["owner"], block["octave"]))
        columns = read_values(t, block, record["attributes"], data[block["offset"]:block["offset"] + block["size"]], place)
        for a, column in columns.items() if block["kind"] == 8 else ():
            points.setdefault(a, []).extend(column)
    need(len(owners) == len(blocks), "two blocks of attributes belong together")
    for figures in t["attributes"] if points else ():
        column = points[figures["attribute"]]
        need(figures["count"] == len(column) and figures["low"] == min(column) and figures["high"] == max(column),
             f"attribute {figures['attribute']}: figures")
    for value in t["attribute_values"] if points else ():
        need(points[value["attribute"]].count(value["value"]) == value["count"], f"value {value['value']}: count")


def read_blocks(data, header, t):
    end, radius, owned = header["data_offset"], math.inf, set()
    for i, block in enumerate(t["blocks"]):
        place = f"block {i}"
        begin = block["offset"]
        need(begin == align(end) and begin + block["size"] <= len(data), f"{place}: wrong offset")
        need(not any(data[end:begin]), f"{place}: bytes before it")
        end = begin + block["size"]
        chunked = block["kind"] == 4 and block["encoding"] in (1, 2, 3)
        need(chunked or zlib.crc32(data[begin:end]) == block["crc"], f"{place}: wrong checksum")
        need(0 <= block["radius"] <= radius, f"{place}: radius ascends")
        radius = block["radius"]
        if block["kind"] not in KINDS:
            continue
        need(block["encoding"] == 0 or chunked or block["kind"] == 3 and block["encoding"] <= 3, f"{place}: encoding")
        need(block["owner"] < len(t[KINDS[block["kind"]]]), f"{place}: owner")
        if KINDS[block["kind"]] == "meshes":
            coded = t["meshes"][block["owner"]]["cluster_count"] != NONE
            need(coded == (block["kind"] == 5), f"{place}: its mesh has a different encoding")
        record, columns, alignment = block_columns(t, block)
        named = record["blocks"][block["octave"]] if block["kind"] == 4 else record["block"]
        need(named == i and (block["kind"] == 4 or block["octave"] == 0), f"{place}: its owner has a different one")
        owned.add((block["kind"], block["owner"], block["octave"]))
        if block["kind"] == 5:
            try:
                read_clusters(data, begin, end, record)
            except (ValueError, struct.error) as fault:
                raise ValueError(f"{place}: clusters: {fault}") from fault
            continue
        plain = unpack_octave(record, block, data[begin:end], place) if chunked else data[begin:end]
        if block["kind"] == 4 and not chunked and record["method_columns"] == 7:
            operators = record.setdefault("operators", Operators(record["step"]))
            operators.skip(plain, record["octave_ends"][block["octave"]] - len(operators.splats))
        at, sums = 0, record.setdefault("columns", {})
        for name, size in columns:
            start = align(at, alignment) if size else at
            need(not any(plain[at:start]), f"{place}: bytes between columns")
            column = plain[start:start + size]
            check_content(t, record, block, name, column, place)
            sums[name] = zlib.crc32(column, sums.get(name, 0))
            at = start + size
        need(at == len(plain), f"{place}: size")
    need(end == len(data), "bytes after the last block")
    check_textures(t)
    for i, surfels in enumerate(t["surfels"]):
        operators = surfels.pop("operators", None)
        if operators and any(t["blocks"][b]["encoding"] == 2 for b in surfels["blocks"]):
            need(not operators.waiting and (len(operators.splats) - operators.base) % 2 == 0, f"splat set {i}: splits")
    owners = len({texture["block"] for texture in t["textures"]})
    held = [points for points in t["point_sets"] if points["held_by"]]
    for points in held:
        need(points["held_by"] <= len(t["surfels"]) and points["block"] == NONE and points["present"] == 3, "held points")
        surfels = t["surfels"][points["held_by"] - 1]
        need(surfels["count"] == points["point_count"] and surfels["method_columns"] in (0, 5), "count of held points")
        told = t["certainty"][points["held_by"] - 1]["position_error"] if t["certainty"] else 0
        need(told == 0 or surfels["step"] > 0, "exactness of held points")
    wanted = len(t["meshes"]) + len(t["point_sets"]) - len(held) + owners + len(t["octaves"])
    wanted += sum(leaves["leaf_count"] > 0 for leaves in t["leaves"])
    need(len(owned) == wanted, "a mesh, point set, texture, octave or table of leaves has no block")
    for leaves in t["leaves"]:  # named by their number
        leaves["set"] = t["surfels"].index(leaves["set"])


def read_store(data):
    header = read_header(data)
    tables = read_tables(read_sections(data, header))
    check_graph(header, tables)
    gather_methods(tables)
    gather_sets(tables)
    check_levels(tables)
    read_blocks(data, header, tables)
    read_attributes(data, tables)
    return {**header, **tables}


def find_difference(expected, found, place="file"):
    """Path of the first value of `expected` that is not in `found`; None if there is none."""
    if isinstance(expected, dict) and isinstance(found, dict):
        pairs = [(value, found.get(key), f"{place}.{key}") for key, value in expected.items()]
    elif isinstance(expected, list) and isinstance(found, list) and len(expected) == len(found):
        pairs = [(a, b, f"{place}[{i}]") for i, (a, b) in enumerate(zip(expected, found))]
    else:
        return None if expected == found else f"{place}: expected {expected!r}, found {found!r}"
    return next((d for d in (find_difference(*pair) for pair in pairs) if d), None)


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("file")
    parser.add_argument("--expect", metavar="JSON")
    options = parser.parse_args()
    try:
        with open(options.file, "rb") as file:
            found = read_store(file.read())
    except (OSError, ValueError, IndexError, struct.error) as fault:
        sys.exit(f"{options.file}: {fault}")
    if options.expect:
        with open(options.expect, encoding="utf-8") as file:
            difference = find_difference(json.load(file), found)
        if difference:
            sys.exit(f"{options.file}: {difference}")
    json.dump(found, sys.stdout, indent=1)
    print()


if __name__ == "__main__":
    main()
