#!/usr/bin/env python3
"""The distribution of frame times over scene `paper`, as in the last column of Table 3 of Brandt et al. 2019: a table, and box and violin plots.

usage: bench/positions.py SCENE [--count N] [--splat-size PX] [--line MS]

Runs `stipple bench positions`: N random positions 200 m above the whole scene and a quarter as many 2 m above the
ground of each part (the paper: about 10,000, and 1,000; 100 for the bakery), four directions each, every picture
drawn twice. Writes frame-times.svg.
"""
import math

import kit

LEFT, TOP, HEIGHT, BOTTOM, ACROSS = 60, 36, 340, 60, 130
BINS = 80


def axis(values):
    """From a half of a power of two below to one above: frame times differ by orders of magnitude."""
    low = max(0.5, min(kit.rank(v, 0.01) for v in values))
    return math.floor(math.log2(low)), math.ceil(math.log2(max(map(max, values))))


def outline(values, y_of, low, high):
    """How dense the values are along the logarithmic axis: half widths, from the lowest bin up, smoothed."""
    bins = [0.0] * BINS
    for value in values:
        part = (math.log2(max(value, 2.0 ** low)) - low) / (high - low)
        bins[min(BINS - 1, max(0, int(part * BINS)))] += 1.0
    for _ in range(3):
        bins = [0.25 * bins[max(0, i - 1)] + 0.5 * bins[i] + 0.25 * bins[min(BINS - 1, i + 1)] for i in range(BINS)]
    most = max(bins)
    return [(bins[i] / most, y_of(2.0 ** (low + (i + 0.5) / BINS * (high - low)))) for i in range(BINS) if bins[i] > 0.004 * most]


def put_violin(drawing, values, x, color, y_of, low, high):
    half = 0.42 * ACROSS
    edge = outline(values, y_of, low, high)
    drawing.shape([(x - half * w, y) for w, y in edge] + [(x + half * w, y) for w, y in reversed(edge)], color)
    q = [y_of(kit.rank(values, part)) for part in (0.05, 0.25, 0.5, 0.75, 0.95)]
    drawing.line([(x, q[0]), (x, q[4])], "#222")
    drawing.shape([(x - 7, q[1]), (x + 7, q[1]), (x + 7, q[3]), (x - 7, q[3])], "#fff")
    drawing.line([(x - 7, q[2]), (x + 7, q[2])], "#222", 2)


def plot(results, path, mark):
    values = [r["figures"]["frame_ms"] for r in results]
    low, high = axis(values)
    width = LEFT + ACROSS * len(results) + 20
    drawing = kit.Drawing(width, TOP + HEIGHT + BOTTOM)

    def y_of(ms):
        return TOP + HEIGHT * (1 - (math.log2(max(ms, 2.0 ** low)) - low) / (high - low))

    for power in range(low, high + 1):
        drawing.line([(LEFT, y_of(2.0 ** power)), (width - 10, y_of(2.0 ** power))], "#ddd")
        drawing.text(LEFT - 8, y_of(2.0 ** power) + 4, f"{2.0 ** power:g}", "end")
    if mark:
        drawing.line([(LEFT, y_of(mark)), (width - 10, y_of(mark))], "#c00", 1, 'stroke-dasharray="6 4"')
    size = results[0]["params"]
    drawing.text(LEFT, 20, f"frame time, ms; {size['width']}x{size['height']}, {size['threads']} threads, "
                           f"splat size {size['splat_size']:g}", more='font-weight="bold"')
    for i, r in enumerate(results):
        x = LEFT + ACROSS * (i + 0.5)
        put_violin(drawing, values[i], x, "#8da0cb", y_of, low, high)
        drawing.text(x, TOP + HEIGHT + 20, r["params"]["place"], "middle")
        drawing.text(x, TOP + HEIGHT + 36, f"{r['params']['metres_above_ground']:g} m, {r['params']['pictures']} pictures", "middle",
                     'font-size="10"')
    drawing.write(path)


def main():
    parser = kit.options(__doc__)
    parser.add_argument("scene")
    parser.add_argument("--count", type=int, default=20)
    parser.add_argument("--splat-size", default="1")
    parser.add_argument("--line", type=float, default=33.0, help="marked in the plot, ms; default 33")
    given = parser.parse_args()
    results = kit.bench("positions", "--model", given.scene, "--count", given.count, "--splat-size", given.splat_size)["results"]
    rows = []
    for r in results:
        p, f = r["params"], r["figures"]
        rows.append([p["place"], p["positions"], p["pictures"], *(f"{f[k]:.1f}" for k in ("p25", "p50", "p75", "p95", "p99", "max", "jump_p50")),
                     kit.short(f["splats_p50"]), kit.short(f["triangles_p50"])])
    kit.table(["place", "positions", "pictures", "25 %", "median", "75 %", "95 %", "99 %", "max", "first frame", "splats", "triangles"], rows)
    plot(results, given.images / "frame-times.svg", given.line)
    kit.keep("positions", results, given.out)


main()
