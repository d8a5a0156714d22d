#!/usr/bin/env python3
"""The distribution of frame times over scene `paper`, as in the last column of Table 3 of Brandt et
al. 2019: a table, and box and violin plots.

usage: bench/positions.py SCENE [--count N | --sample PART] [--minutes M] [--resume]
                          [--splat-size PX] [--line MS]

N random positions 200 m above the whole scene, and a quarter as many 2 m above the ground of each
part, with four directions each. Each picture is drawn twice; the second frame counts (`stipple
bench positions`). The paper has about 10,000, and 1,000 in each part (100 in the bakery); --sample
is a fraction of 10,000.

Measures in batches that cover all places, and saves after each. --minutes stops after that time,
--resume continues from the saved file. Positions do not depend on their number, so any number of
batches is a sample of the whole. Writes frame-times.svg.
"""
import math
import time

import kit

LEFT, TOP, HEIGHT, BOTTOM, ACROSS = 60, 44, 340, 60, 130
BINS = 80
WHOLE = 10000 # positions in the paper
LISTS = ("frame_ms", "jump_ms", "splats", "triangles")
ROUNDED = {"frame_ms": 2, "jump_ms": 2, "splats": None, "triangles": None}


def axis(values):
    """Axis range, in half powers of two: frame times differ by orders of magnitude."""
    low = max(0.5, min(kit.rank(v, 0.01) for v in values))
    return math.floor(math.log2(low)), math.ceil(math.log2(max(map(max, values))))


def outline(values, y_of, low, high):
    """Density of the values along the logarithmic axis: smoothed half widths, from the lowest bin up."""
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
        drawing.text(width - 10, y_of(mark) - 4, f"{mark:g} ms", "end", 'font-size="10" fill="#c00"')
    size = results[0]["params"]
    drawing.text(LEFT, 16, f"frame time, ms; {size['width']}x{size['height']}, {size['threads']} threads, "
                           f"splat size {size['splat_size']:g}", more='font-weight="bold"')
    drawing.text(LEFT, 31, "box: quartiles and median; line: 5 % to 95 %", more='font-size="10"')
    for i, r in enumerate(results):
        x = LEFT + ACROSS * (i + 0.5)
        put_violin(drawing, values[i], x, "#8da0cb", y_of, low, high)
        drawing.text(x, TOP + HEIGHT + 20, r["params"]["place"], "middle")
        drawing.text(x, TOP + HEIGHT + 36, f"{r['params']['metres_above_ground']:g} m, {r['params']['pictures']} pictures", "middle",
                     'font-size="10"')
    drawing.write(path)


def add(places, piece):
    """Adds a piece's pictures to the previous ones, by place."""
    for r in piece:
        p, lists = r["params"], {name: [round(v, ROUNDED[name]) for v in r["figures"][name]] for name in LISTS}
        del p["first"]
        known = places.setdefault(p["place"], kit.result("positions", p, {}))
        if known["params"] is not p:
            for key in ("positions", "pictures"):
                known["params"][key] += p[key]
        for name, values in lists.items():
            known["figures"].setdefault(name, []).extend(values)


def describe(r):
    f = r["figures"]
    for name, part in (("min", 0), ("p25", 0.25), ("p50", 0.5), ("p75", 0.75), ("p95", 0.95), ("p99", 0.99), ("max", 1)):
        f[name] = kit.rank(f["frame_ms"], part)
    for name in LISTS[1:]:
        f[f"{name.removesuffix('_ms')}_p50"] = kit.rank(f[name], 0.5)


def resumed(given, path):
    """Saved results by place, if they are of the same pictures."""
    places = {r["params"]["place"]: r for r in kit.read_results(path)}
    for r in places.values():
        p = r["params"]
        if (p["model"], f"{p['width']}x{p['height']}", p["splat_size"]) != (kit.name_of(given.scene), given.size, float(given.splat_size)):
            raise SystemExit(f"{path}: of {p['model']} at {p['width']}x{p['height']} and size {p['splat_size']:g}; --out names another file")
    return places


def measure(given, name):
    path = kit.path_of(name, given.out)
    places = resumed(given, path) if given.resume else {}
    count = given.count or math.ceil(WHOLE * given.sample)
    begun, done = time.monotonic(), places["Overview"]["params"]["positions"] if places else 0
    before = done
    while done < count and not (given.minutes and done > before and time.monotonic() - begun > 60 * given.minutes):
        piece = min(given.piece, count - done)
        add(places, kit.bench("positions", "--model", given.scene, "--first", done, "--count", piece, "--splat-size", given.splat_size,
                              "--size", given.size, "--threads", given.threads)["results"])
        done += piece
        for r in places.values():
            describe(r)
        kit.keep(name, list(places.values()), given.out, silent=True)
        minutes = (time.monotonic() - begun) / 60
        kit.say(f"{done} of {count} positions above the whole, {minutes:.1f} minutes; the rest takes {minutes * (count - done) / (done - before):.1f}")
    kit.say(path)
    return list(places.values())


def main():
    parser = kit.options(__doc__)
    parser.add_argument("scene")
    parser.add_argument("--count", type=int, help="positions above the whole scene; instead of --sample")
    parser.add_argument("--sample", type=float, default=0.06, help="fraction of the paper's 10,000 positions; default 0.06")
    parser.add_argument("--minutes", type=float, help="start no further batch after this time; default: all positions")
    parser.add_argument("--piece", type=int, default=20, help="positions at a time; default 20")
    parser.add_argument("--resume", action="store_true", help="continue from the saved file")
    parser.add_argument("--splat-size", default="4")
    parser.add_argument("--line", type=float, default=33.0, help="line in the plot, ms; default 33")
    given = parser.parse_args()
    results = measure(given, "positions")
    rows = []
    for r in results:
        p, f = r["params"], r["figures"]
        rows.append([p["place"], p["positions"], p["pictures"], *(f"{f[k]:.1f}" for k in ("p25", "p50", "p75", "p95", "p99", "max", "jump_p50")),
                     kit.short(f["splats_p50"]), kit.short(f["triangles_p50"])])
    kit.table(["place", "positions", "pictures", "25 %", "median", "75 %", "95 %", "99 %", "max", "first frame", "splats", "triangles"], rows)
    plot(results, given.images / "frame-times.svg", given.line)
    print("\n![Frame times as box and violin plots](images/frame-times.svg)")


if __name__ == "__main__":
    main()
