#!/usr/bin/env python3
"""Similarity of CPU and OpenGL pictures: all named views of all named scenes, at splat sizes 1, 2
and 4, with fovea, section, ghosts, effects, accumulation, stereo and filters, with splats as points
and by compute shaders (stipple-lab bench backends). The table shows the worst view of each scene.

    bench/backends.py                          all scenes, at default scales
    bench/backends.py forest city=0.01         these scenes, at these scales
"""
import pathlib
import sys
import tempfile

import kit

# Scales at which Mesa's llvmpipe draws a view within half a minute.
SCALES = {"boxes": 1, "paper": 0.003, "forest": 0.02, "city": 0.004, "bakery-line": 0.02, "power-plant": 0.03, "car-factory": 0.01,
          "terrain": 0.002, "city-small": 0.1, "one-mesh": 0.02, "twenty-million": 0.002, "spheres": 0.0005, "paper-huge": 0.0002}
GOAL = 0.98


def measure(scene, scale, given):
    path = given.scratch / f"{scene}.stip"
    kit.say(f"{scene} ...")
    kit.stipple("build", f"scene:{scene},scale={scale}", "-o", path)
    found = kit.bench("backends", "--model", path, "--size", given.size, *(["--threads", given.threads] if given.threads else []))
    path.unlink()
    results = [r for r in found["results"] if r["name"] == "backends"]
    for r in results:
        r["params"]["model"] = f"scene:{scene},scale={scale}"
    return results


def column_of(result):
    p = result["params"]
    return p["case"] + (f", size {p['splat_size']:g}" if p["case"] in ("ewa", "blend") else "")


def rows_of(results):
    """The minimum per scene over all views and both ways, and OpenGL's worst loss of similarity to the originals."""
    columns = list(dict.fromkeys(map(column_of, results)))
    rows = []
    for model in dict.fromkeys(r["params"]["model"] for r in results):
        own = [r for r in results if r["params"]["model"] == model]
        views = len({r["params"]["view"] for r in own})
        least = [min((r["figures"]["ssim"] for r in own if column_of(r) == c), default=None) for c in columns]
        worse = max(r["figures"]["ssim_reference_cpu"] - r["figures"]["ssim_reference_gl"] for r in own if "ssim_reference_gl" in r["figures"])
        calls = max(r["figures"]["draw_calls"] for r in own)
        rows.append([f"`{model[6:]}`", views, *("no room" if v is None else f"{v:.4f}" for v in least), f"{max(worse, 0):.5f}", calls])
    return ["scene", "views", *columns, "less like originals by", "draw calls"], rows


def by_view(results):
    """Stored results: for each view and case, SSIM of points and of compute shaders, and of the CPU and both against the originals."""
    kept = {}
    for r in results:
        p, f = r["params"], r["figures"]
        own = kept.setdefault((p["model"], p["view"]), kit.result("backends", {"model": p["model"], "view": p["view"]}, {"draw_calls": 0}))["figures"]
        own["draw_calls"] = max(own["draw_calls"], f["draw_calls"])
        own.setdefault(column_of(r), []).append(round(f["ssim"], 6))
        if "ssim_reference_gl" in f:
            like = own.setdefault(column_of(r) + ", to originals", [round(f["ssim_reference_cpu"], 6)])
            like.append(round(f["ssim_reference_gl"], 6))
    return list(kept.values())


def main():
    parser = kit.options(__doc__, size="480x270")
    parser.add_argument("scenes", nargs="*", metavar="SCENE[=SCALE]")
    given = parser.parse_args()
    wanted = {}
    for text in given.scenes:
        name, _, scale = text.partition("=")
        wanted[name] = scale or SCALES.get(name, 1)
    results = []
    with tempfile.TemporaryDirectory(prefix="stipple-backends-") as folder:
        given.scratch = pathlib.Path(folder)
        for name, scale in (wanted or SCALES).items():
            results += measure(name, scale, given)
            kit.keep("backends", by_view(results), given.out, silent=True)
    if not results:
        sys.exit("nothing was compared: OpenGL 4.5 is not available")
    kit.table(*rows_of(results))
    least = min(r["figures"]["ssim"] for r in results)
    print(f"\nThe least of {len(results)} pictures is {least:.4f} (goal {GOAL}).")
    sys.exit(least < GOAL)


if __name__ == "__main__":
    main()
