#!/usr/bin/env python3
"""Frame times of one flight over scenes with more and more triangles: a table, ratios, and the
curve.

usage: bench/growth.py [--path FLIGHT.json] [--splat-size PX] [--frames N] [--repeats N] SCENE...

SCENE is a .stip, or a named scene, which is first built into the cache (scene:paper,scale=0.0625).
Order them from small to large; ratios are to the previous and to the first. Flights take turns;
times are medians over all frames. Writes growth.svg.
"""
import math
import statistics

import kit

WIDTH, HEIGHT, LEFT, TOP, BOTTOM = 640, 300, 60, 40, 50


def fly(given, scene):
    kit.say(scene)
    return kit.stipple("fly", scene, "--path", given.path, "--size", given.size, "--splat-size", given.splat_size, "--frames", given.frames,
                       threads=given.threads)


def plot(results, path):
    drawing = kit.Drawing(WIDTH, TOP + HEIGHT + BOTTOM)
    xs = [math.log10(r["params"]["triangles"]) for r in results]
    low, high = math.floor(min(xs)), math.ceil(max(xs))
    top = kit.round_axis(max(r["figures"]["frame_ms_p95"] for r in results))

    def place(x, ms):
        return LEFT + (x - low) / (high - low) * (WIDTH - LEFT - 20), TOP + HEIGHT * (1 - ms / top)

    drawing.text(LEFT, 22, f"frame time over triangles of the scene, ms; splat size {results[0]['params']['splat_size']}",
                 more='font-weight="bold"')
    for i in range(5):
        x, y = place(low, top * i / 4)
        drawing.line([(x, y), (WIDTH - 20, y)], "#ddd")
        drawing.text(x - 8, y + 4, f"{top * i / 4:g}", "end")
    for power in range(low, high + 1):
        x, y = place(power, 0)
        drawing.line([(x, y), (x, y + 5)], "#888")
        drawing.text(x, y + 20, f"{10 ** (power % 3)} {('', 'k', 'M', 'G', 'T')[power // 3]}", "middle")
    for key, color in (("frame_ms_p50", kit.COLORS[0]), ("frame_ms_p95", kit.COLORS[1])):
        points = [place(x, r["figures"][key]) for x, r in zip(xs, results)]
        drawing.line(points, color, 2)
        drawing.text(points[-1][0], points[-1][1] - 8, "median" if key.endswith("p50") else "95 %", "end", f'fill="{color}"')
        for x, y in points:
            drawing.put(f'<circle cx="{x:.1f}" cy="{y:.1f}" r="4" fill="{color}"/>')
    drawing.write(path)


def main():
    parser = kit.options(__doc__)
    parser.add_argument("scenes", nargs="+", metavar="SCENE")
    parser.add_argument("--path", default=kit.ROOT / "lab/scenes/flights/paper.json")
    parser.add_argument("--splat-size", default="4")
    parser.add_argument("--frames", type=int, default=200)
    parser.add_argument("--repeats", type=int, default=2)
    given = parser.parse_args()
    flights = {scene: [] for scene in given.scenes}
    for _ in range(given.repeats):
        for scene, flown in flights.items():
            flown.append(fly(given, scene))
    results, rows = [], []
    for scene, flown in flights.items():
        frames = [f for flight in flown for f in flight["per_frame"]]
        ms = [f["frame_ms"] for f in frames]
        figures = {"frame_ms_p50": kit.rank(ms, 0.5), "frame_ms_p95": kit.rank(ms, 0.95), "frame_ms_max": max(ms),
                   "splats_p50": statistics.median(f["splats"] for f in frames), "triangles_p50": statistics.median(f["triangles"] for f in frames),
                   "draw_calls_p50": flown[0]["draw_calls"]["p50"]}
        params = {"scene": scene, "triangles": kit.stipple("info", scene)["triangles"], "size": given.size, "splat_size": given.splat_size,
                  "frames": given.frames, "repeats": given.repeats}
        results.append(kit.result("growth", params, figures))
    for i, r in enumerate(results):
        p, f = r["params"], r["figures"]
        ratios = [f"{f['frame_ms_p50'] / results[max(0, k)]['figures']['frame_ms_p50']:.2f}" for k in (i - 1, 0)]
        rows.append([kit.name_of(p["scene"]), kit.short(p["triangles"]), *(f"{f[n]:.1f}" for n in ("frame_ms_p50", "frame_ms_p95", "frame_ms_max")),
                     kit.short(f["splats_p50"]), kit.short(f["triangles_p50"]), kit.short(f["draw_calls_p50"]), *ratios])
    kit.table(["scene", "triangles", "median, ms", "95 %", "max", "splats drawn", "triangles drawn", "draw items", "to the one before", "to the first"],
              rows)
    plot(results, given.images / "growth.svg")
    kit.keep("growth", results, given.out)


if __name__ == "__main__":
    main()
