#!/usr/bin/env python3
"""Popping with blending between levels, and with hard switching, on a scene small enough to draw every reference.

usage: bench/popping.py [SCENE] [--path FLIGHT.json] [--frames N] [--splat-size PX]

default: scene:city-small and its flight. What pops is measured against the original geometry (see `stipple fly --help`);
extra splats are those drawn while levels blend, as a part of all.
"""
import kit


def main():
    parser = kit.options(__doc__, size="960x540")
    parser.add_argument("scene", nargs="?", default="scene:city-small")
    parser.add_argument("--path", default=kit.ROOT / "scenes/flights/city-small.json")
    parser.add_argument("--frames", type=int, default=0, help="default: as many as the flight's fps makes")
    parser.add_argument("--splat-size", default="1")
    given = parser.parse_args()
    results, rows = [], []
    for policy in ("insertion", "switch"):
        kit.say(policy)
        flight = kit.stipple("fly", given.scene, "--path", given.path, "--size", given.size, "--splat-size", given.splat_size, "--policy", policy,
                             "--popping", *(["--frames", given.frames] if given.frames else []), threads=given.threads)
        splats, extra = (sum(f[key] for f in flight["per_frame"]) for key in ("splats", "extra_splats"))
        figures = {**{f"popping_{k}": v for k, v in flight["popping"].items()}, "extra_part": extra / max(1, splats - extra),
                   "splats_p50": flight["splats"]["p50"], "triangles_p50": flight["triangles"]["p50"], "frame_ms_p50": flight["frame_ms"]["p50"]}
        params = {"scene": given.scene, "path": str(given.path), "size": given.size, "splat_size": given.splat_size, "policy": policy,
                  "frames": flight["frames"]}
        results.append(kit.result("popping", params, figures))
        rows.append([policy, flight["frames"], *(f"{figures[f'popping_{n}']:.2f}" for n in ("p50", "p999", "max")),
                     f"{100 * figures['extra_part']:.1f} %", kit.short(figures["splats_p50"]), kit.short(figures["triangles_p50"])])
    kit.table(["policy", "frames", "popping, median", "99.9 %", "max", "extra splats", "splats", "triangles"], rows)
    ratio = results[0]["figures"]["popping_p999"] / results[1]["figures"]["popping_p999"]
    print(f"\n99.9 %, blending / switching: {ratio:.3f} (goal: at most 0.25)")
    kit.keep("popping", results, given.out)


main()
