"""The sequence of a point tree in a .stip file, and its cuts from several distances: which points
are too coarse, drawn, or too fine (Figures 1, 4 and 5 of Dachsbacher et al. 2003)."""
import bisect
import math
import pathlib
import struct
import sys

import kit

sys.path.insert(0, str(kit.ROOT / "scripts"))
import read_store  # noqa: E402

BINS = 100
KINDS = ("too coarse", "drawn", "too fine")
FILLS = ("#b8c4d8", "#c44e52", "#e8e4da")
BAR_WIDTH, BAR_HEIGHT, BAR_GAP, GAP, LEFT, TOP = 250, 22, 9, 66, 46, 74


def read_tables(path):
    """The bytes of a file, and its tables, without what the tables describe."""
    data = pathlib.Path(path).read_bytes()
    header = read_store.read_header(data)
    tables = read_store.read_tables(read_store.read_sections(data, header))
    read_store.check_graph(header, tables)
    read_store.gather_methods(tables)
    read_store.gather_sets(tables)
    return data, tables


def columns_of(data, tables, splat_set):
    """Positions and ranges of a set, its octaves joined."""
    joined = {"positions": b"", "ranges": b""}
    for index in splat_set["blocks"]:
        block = tables["blocks"][index]
        stored = data[block["offset"]:block["offset"] + block["size"]]
        record, columns, _ = read_store.block_columns(tables, block)
        plain = read_store.unpack_octave(record, block, stored, f"block {index}") if block["encoding"] == 1 else stored
        at = 0
        for name, size in columns:
            if name in joined:
                joined[name] += plain[at:at + size]
            at += size
    return joined


def level_of(code):
    return struct.unpack("<f", struct.pack("<I", code << 15))[0] if code < 0xFF00 else math.inf


def read_sequence(path):
    """The points of the only set of method spt, by descending highest level: place, lowest, highest level."""
    data, tables = read_tables(path)
    method = next(m for m in tables["methods"] if m["name"] == "spt")
    if method["set_count"] != 1:
        sys.exit(f"{path}: has {method['set_count']} sets of spt; expected 1")
    splat_set = tables["surfels"][method["first_set"]]
    columns = columns_of(data, tables, splat_set)
    levels = {}
    points = []
    for place, (low, high) in zip(struct.iter_unpack("<3H", columns["positions"]), struct.iter_unpack("<2H", columns["ranges"])):
        for code in (low, high):
            if code not in levels:
                levels[code] = level_of(code)
        at = tuple(o + splat_set["step"] * v for o, v in zip(splat_set["origin"], place))
        points.append((at, levels[low], levels[high]))
    points.sort(key=lambda point: -point[2])
    return points


def cut(points, eye, forward, per_depth, level=None):
    """The kind (of KINDS) of each point, with the level of its own depth or one level for all. Also the end
    of the prefix that a view tests: points after it are too fine at the nearest depth."""
    depth_at_eye = sum(e * f for e, f in zip(eye, forward))
    kinds = bytearray(len(points))
    nearest = math.inf
    for i, (at, low, high) in enumerate(points):
        depth = at[0] * forward[0] + at[1] * forward[1] + at[2] * forward[2] - depth_at_eye
        nearest = min(nearest, depth)
        own = per_depth * depth if level is None else level
        kinds[i] = 0 if own < low else 1 if own <= high else 2
    least = per_depth * max(nearest, 0.0) if level is None else level
    end = bisect.bisect_right([-high for _, _, high in points], -least)
    return kinds, end


def bins_of(kinds, end):
    """Number of points of each kind in each of BINS equal parts of the first `end` points."""
    counts = [[0] * BINS for _ in KINDS]
    for i in range(end):
        counts[kinds[i]][i * BINS // end] += 1
    return counts


def put_bar(drawing, counts, left, top, width, height):
    """Stacked columns of the shares of each kind: drawn at the bottom, too coarse above, too fine at the top."""
    step = width / BINS
    drawing.put(f'<rect x="{left}" y="{top}" width="{width}" height="{height}" fill="{FILLS[2]}"/>')
    for kinds, fill in (((1, 0), FILLS[0]), ((1,), FILLS[1])):
        path, last = f"M{left} {top + height}", None
        for i in range(BINS):
            total = sum(c[i] for c in counts)
            share = sum(counts[k][i] for k in kinds) / total if total else 0.0
            y = f"{top + height * (1 - share):.1f}"
            path += ("" if y == last else f"V{y}") + f"H{left + (i + 1) * step:.1f}"
            last = y
        drawing.put(f'<path fill="{fill}" d="{path}V{top + height}Z"/>')
    drawing.put(f'<rect x="{left}" y="{top}" width="{width}" height="{height}" fill="none" stroke="#888" stroke-width="0.7"/>')


def plot(rows, name, count, path):
    """A row per distance: the whole sequence; the prefix with one level for all; with the level of each point's depth."""
    across = BAR_WIDTH + GAP
    drawing = kit.Drawing(LEFT + 3 * across, TOP + len(rows) * (BAR_HEIGHT + BAR_GAP) + 4)
    drawing.text(LEFT, 18, f"{name}: {count:,} points by r_max, from coarse to fine; a row for each distance, in sizes of the model",
                 more='font-weight="bold"')
    for i, kind in enumerate(KINDS):
        drawing.put(f'<rect x="{LEFT + 110 * i}" y="28" width="12" height="12" fill="{FILLS[i]}" stroke="#888" stroke-width="0.7"/>')
        drawing.text(LEFT + 18 + 110 * i, 38, kind)
    heads = ("all points; the line ends the prefix", "the prefix, if all points had one distance", "the prefix, with the distance of each point")
    for k, head in enumerate(heads):
        drawing.text(LEFT + k * across, TOP - 12, head)
    for i, row in enumerate(rows):
        top = TOP + i * (BAR_HEIGHT + BAR_GAP)
        drawing.text(LEFT - 8, top + 15, f"{row['distance']:g}", "end")
        for k, (bins, end) in enumerate(((row["all"], None), (row["constant"], row["constant_end"]), (row["own"], row["looked_at"]))):
            left = LEFT + k * across
            put_bar(drawing, bins, left, top, BAR_WIDTH, BAR_HEIGHT)
            if end is None:
                x = left + BAR_WIDTH * row["looked_at"] / count
                drawing.line([(x, top - 4), (x, top + BAR_HEIGHT + 4)], "#222", 1.2)
            else:
                drawing.text(left + BAR_WIDTH + 6, top + 15, f"{end:,}", more='font-size="11"')
    drawing.write(path)


def measure(path, name, distances, direction, bounds, image, epsilon=1, picture_rows=720):
    """Cuts from each distance in a direction, with a vertical angle of 60 degrees: counts as results, and the plot."""
    points = read_sequence(path)
    center = [0.5 * (a + b) for a, b in zip(bounds["min"], bounds["max"])]
    size = math.dist(bounds["min"], bounds["max"])
    per_depth = 0.5 * epsilon * 2.0 * math.tan(math.radians(30.0)) / picture_rows
    rows, results = [], []
    for distance in distances:
        eye = [c + d * distance * size for c, d in zip(center, direction)]
        forward = [-d for d in direction]
        own, end = cut(points, eye, forward, per_depth)
        constant, constant_end = cut(points, eye, forward, per_depth, per_depth * distance * size)
        rows.append({"distance": distance, "all": bins_of(own, len(points)), "own": bins_of(own, end), "looked_at": end,
                     "constant": bins_of(constant, constant_end), "constant_end": constant_end})
        figures = {"points": len(points), "looked_at": end, "looked_at_constant": constant_end,
                   "drawn": own.count(1), "drawn_constant": constant.count(1),
                   "too_coarse": own[:end].count(0), "too_fine": own[:end].count(2),
                   "drawn_after_prefix": own[end:].count(1), "first_too_fine": own.find(2)}
        results.append(kit.result("spt cut", {"model": name, "sizes_away": distance, "epsilon": epsilon, "rows": picture_rows}, figures))
    plot(rows, name, len(points), image)
    return results
