#!/usr/bin/env python3
"""Popping with blending between levels, and with hard switching, on a scene small enough to draw
every reference.

usage: bench/popping.py [SCENE] [--path FLIGHT.json] [--frames N] [--splat-size PX] [--supersample
N]

default: scene:one-mesh, and a slow flight to half the distance during which it turns from splats to
triangles. Popping is measured against the original geometry (see `stipple fly --help`), in blocks
of 8 x 8 pixels over all pairs of frames. Frames have 4 x 4 samples per pixel, since with one sample
the edges of splats move by whole pixels in any frame.

The level changes in one pair of 300, which is less than the 99.9th percentile ignores: that
percentile shows ordinary frames. So the table also has the worst block, and "in one frame": the
largest mean over the blocks of a pair, minus that of the median pair. Extra splats are those drawn
while levels blend, as a share of the others.
"""
import json
import pathlib
import tempfile

import kit

SLOW = {"fov": 60, "fps": 60, "keys": [{"t": 0, "eye": [0, 0, 6], "target": [0, 0, 0]}, {"t": 5, "eye": [0, 0, 3], "target": [0, 0, 0]}]}


def compare(given):
    results, rows = [], []
    for policy in ("insertion", "switch"):
        kit.say(policy)
        flight = kit.stipple("fly", given.scene, "--path", given.path, "--size", given.size, "--splat-size", given.splat_size, "--policy", policy,
                             "--supersample", given.supersample, "--popping", *(["--frames", given.frames] if given.frames else []), threads=given.threads)
        splats, extra = (sum(f[key] for f in flight["per_frame"]) for key in ("listed_splats", "extra_splats"))
        means = [f["popping"] for f in flight["per_frame"][1:]]
        figures = {**{f"popping_{k}": v for k, v in flight["popping"].items()}, "frame_p50": kit.rank(means, 0.5), "frame_max": max(means), "frames": means,
                   "extra_part": extra / max(1, splats - extra),
                   "splats_min": min(f["splats"] for f in flight["per_frame"]), "splats_max": max(f["splats"] for f in flight["per_frame"]),
                   "splats_p50": flight["splats"]["p50"], "triangles_p50": flight["triangles"]["p50"], "frame_ms_p50": flight["frame_ms"]["p50"]}
        params = {"scene": given.scene, "path": str(given.path), "size": given.size, "splat_size": given.splat_size, "supersample": given.supersample, "policy": policy,
                  "frames": flight["frames"]}
        results.append(kit.result("popping", params, figures))
        rows.append([policy, flight["frames"], *(f"{figures[f'popping_{n}']:.2f}" for n in ("p50", "p999", "max")),
                     f"{figures['frame_p50']:.3f}", f"{figures['frame_max'] - figures['frame_p50']:.3f}", f"{100 * figures['extra_part']:.1f} %", kit.short(figures["splats_p50"]), kit.short(figures["triangles_p50"])])
    kit.table(["policy", "frames", "popping, median", "99.9 %", "max", "median frame", "in one frame, beyond", "extra splats", "splats", "triangles"], rows)
    if not all(0 < r["figures"]["splats_max"] and r["figures"]["splats_min"] == 0 for r in results):
        raise SystemExit("popping: the flight does not change from splats to triangles")
    ratio, worst = (results[0]["figures"][k] / results[1]["figures"][k] for k in ("popping_p999", "popping_max"))
    spikes = [r["figures"]["frame_max"] - r["figures"]["frame_p50"] for r in results]
    print(f"\nblending / switching: 99.9 % {ratio:.3f} (goal: at most 0.25), worst block {worst:.3f}, in one frame {spikes[0] / max(spikes[1], 1e-9):.3f}")
    kit.keep("popping", results, given.out)


def main():
    parser = kit.options(__doc__, size="480x270")
    parser.add_argument("scene", nargs="?", default="scene:one-mesh")
    parser.add_argument("--path", help="default: the slow flight")
    parser.add_argument("--frames", type=int, default=0, help="default: determined by the flight's fps")
    parser.add_argument("--splat-size", default="2")
    parser.add_argument("--supersample", default="4")
    given = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        if given.path is None:
            given.path = pathlib.Path(folder) / "slow.json"
            given.path.write_text(json.dumps(SLOW), encoding="utf-8")
        compare(given)


main()
