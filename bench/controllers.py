#!/usr/bin/env python3
"""Compares two controllers on one flight: the predictive one, and the reactive one of Brandt et al.
2019, 4.3. A table and plots.

usage: bench/controllers.py SCENE [--path FLIGHT.json] [--budget-ms MS|auto] [--frames N]
                            [--repeats N] [--reference-every N]

auto: the budget that splats of 8 pixels can meet, 1.1 times the 99th percentile of the flight's
frame times at that size. Flights alternate. The table covers all their frames, the plot the first
flight of each. Truth is that of the compared frames (docs/measuring.md, Truth). Writes
controllers.svg.
"""
import statistics

import kit

WIDTH, LEFT, TOP, PANEL, GAP = 900, 70, 56, 170, 46


def fly(given, *more):
    arguments = ["fly", given.scene, "--path", given.path, "--size", given.size]
    return kit.stipple(*arguments, *(["--frames", given.frames] if given.frames else []), *more, threads=given.threads)


def fly_all(given, budget):
    """Flies with each controller in turn."""
    flights = {"predict": [], "paper": []}
    for i in range(given.repeats):
        for name, flown in flights.items():
            kit.say(f"{name}, {budget:.1f} ms")
            more = ["--reference-every", given.reference_every] if given.reference_every and i == 0 else []
            flown.append(fly(given, "--budget-ms", f"{budget:.3f}", "--controller", name, *more))
    return flights


def describe(given, name, flown, budget):
    frames = [f for flight in flown for f in flight["per_frame"]]
    ms, sizes = [f["frame_ms"] for f in frames], [f["splat_size"] for f in frames]
    compared = flown[0]["quality"]
    figures = {"frames": len(frames), **{f"frame_ms_{n}": kit.rank(ms, p) for n, p in (("p50", .5), ("p95", .95), ("p99", .99), ("max", 1))},
               "within_1_1": sum(m <= 1.1 * budget for m in ms) / len(ms), "within_1_5": sum(m <= 1.5 * budget for m in ms) / len(ms),
               "splat_size_p50": kit.rank(sizes, 0.5), "splat_size_p95": kit.rank(sizes, 0.95),
               "at_largest_size": sum(s >= 7.99 for s in sizes) / len(sizes),
               "size_change": sum(abs(b / a - 1) for a, b in zip(sizes, sizes[1:])) / max(1, len(sizes) - 1),
               **({"truth": statistics.median(q["truth"] for q in compared), "ratio": statistics.median(q["ratio"] for q in compared),
                   "ratio_least": min(q["ratio"] for q in compared)} if compared else {}),
               "times": [f["t"] for f in flown[0]["per_frame"]], "frame_ms": [f["frame_ms"] for f in flown[0]["per_frame"]],
               "splat_size": [f["splat_size"] for f in flown[0]["per_frame"]]}
    return kit.result("controllers", {"scene": given.scene, "path": str(given.path), "size": given.size, "budget_ms": budget,
                                      "controller": name, "repeats": given.repeats}, figures)


def put_panel(drawing, top, title, results, key, mark):
    high = kit.round_axis(max([mark, *(kit.rank(r["figures"][key], 0.995) for r in results)])) # clips outliers
    times = results[0]["figures"]["times"]
    across = (WIDTH - LEFT - 20) / max(1e-9, times[-1] - times[0])
    drawing.text(LEFT, top - 8, title, more='font-weight="bold"')
    for i in range(5):
        y = top + PANEL * (1 - i / 4)
        drawing.line([(LEFT, y), (WIDTH - 20, y)], "#ddd")
        drawing.text(LEFT - 8, y + 4, f"{high * i / 4:g}", "end")
    for r, color in zip(results[::-1], (kit.COLORS[1], kit.COLORS[0])):
        drawing.line([(LEFT + (t - times[0]) * across, top + PANEL * (1 - min(v, 1.03 * high) / high)) for t, v in zip(times, r["figures"][key])], color)
    if mark:
        y = top + PANEL * (1 - mark / high)
        drawing.line([(LEFT, y), (WIDTH - 20, y)], "#c00", 1, 'stroke-dasharray="6 4"')


def plot(results, path):
    drawing = kit.Drawing(WIDTH, TOP + 2 * PANEL + GAP + 36)
    for i, (words, color) in enumerate((("predictive", kit.COLORS[0]), ("as in the paper, 4.3", kit.COLORS[1]))):
        drawing.line([(LEFT + 180 * i, 18), (LEFT + 180 * i + 24, 18)], color, 2)
        drawing.text(LEFT + 180 * i + 30, 22, words)
    put_panel(drawing, TOP, "frame time, ms", results, "frame_ms", results[0]["params"]["budget_ms"])
    put_panel(drawing, TOP + PANEL + GAP, "size of splats, pixels", results, "splat_size", 0)
    times = results[0]["figures"]["times"]
    step, bottom = kit.round_up(max(1e-3, (times[-1] - times[0]) / 12)), TOP + 2 * PANEL + GAP
    for i in range(int((times[-1] - times[0]) / step + 1e-9) + 1):
        x = LEFT + i * step * (WIDTH - LEFT - 20) / max(1e-9, times[-1] - times[0])
        drawing.text(x, bottom + 18, f"{times[0] + i * step:g} s", "middle")
    drawing.write(path)


def main():
    parser = kit.options(__doc__)
    parser.add_argument("scene")
    parser.add_argument("--path", default=kit.ROOT / "lab/scenes/flights/paper.json")
    parser.add_argument("--budget-ms", default="33")
    parser.add_argument("--frames", type=int, default=800, help="default 800; 0: determined by the flight's fps")
    parser.add_argument("--repeats", type=int, default=1)
    parser.add_argument("--reference-every", type=int, default=0)
    given = parser.parse_args()
    if given.budget_ms == "auto":
        least = fly(given, "--splat-size", 8)
        budget = 1.1 * least["frame_ms"]["p99"]
    else:
        budget = float(given.budget_ms)
    results = [describe(given, name, flown, budget) for name, flown in fly_all(given, budget).items()]
    names = ("frame_ms_p50", "frame_ms_p95", "frame_ms_p99", "frame_ms_max")
    rows = [[r["params"]["controller"], r["figures"]["frames"], *(f"{r['figures'][n]:.1f}" for n in names),
             f"{100 * r['figures']['within_1_1']:.1f} %", f"{100 * r['figures']['within_1_5']:.1f} %",
             f"{r['figures']['splat_size_p50']:.2f}", f"{100 * r['figures']['at_largest_size']:.0f} %", f"{100 * r['figures']['size_change']:.1f} %",
             *(f"{r['figures'][n]:.3f}" if n in r["figures"] else "" for n in ("truth", "ratio", "ratio_least"))] for r in results]
    kit.table([f"budget {budget:.1f} ms", "frames", "median", "95 %", "99 %", "max", "within 1.1 x", "within 1.5 x", "size, median",
               "frames at 8 or more", "change of size", "truth, median", "ratio, median", "ratio, least"], rows)
    suffix = "" if given.budget_ms != "auto" else "-auto"
    plot(results, given.images / f"controllers{suffix}.svg")
    kit.keep(f"controllers{suffix}", results, given.out)


if __name__ == "__main__":
    main()
