#!/usr/bin/env python3
"""OpenGL on this machine's GPU (or on Mesa's software renderer) against the CPU renderer: how alike
their pictures are, splats and triangles a millisecond, and frame times of flights.

    bench/gpu.py                       all scenes: takes minutes, and builds the scene of the flights
    bench/gpu.py --small               small scenes and pictures, as a trial and for software renderers
    bench/gpu.py --flight-scene paper,scale=0.25 --frames 60

Needs a driver with EGL; no display. `bench/gpu.sh` compares the ways in which OpenGL draws splats.
"""
import json
import math
import pathlib
import re
import statistics
import sys
import tempfile
import time

import kit

WAYS = (("cpu",), ("gl", "--gl-splats", "points"), ("gl", "--gl-splats", "compute"))
METHODS = ("blue", "spt", "psp", "stochastic")


def build(folder, name, source, *options):
    path = folder / f"{name}.stip"
    start = time.monotonic()
    kit.say(f"building {name} ...")
    kit.stipple("build", source, "-o", path, "--fresh", *options)
    kit.say(f"{name}: {time.monotonic() - start:.1f} s, {path.stat().st_size / 1e6:.0f} MB")
    return path


def scan(folder, given):
    """A cloud of a small city, and its file for every method."""
    cloud = folder / "cloud.las"
    stations, rays = ("1", "400") if given.small else ("3", "1500")
    kit.stipple("scan", "scene:city-small" + (",scale=0.2" if given.small else ""), "--stations", stations, "--resolution", rays, "-o", cloud)
    return {method: build(folder, f"cloud-{method}", cloud, "--method", method) for method in (METHODS if given.only != "flights" else METHODS[:1])}


def render(path, method, view, size, way, picture, given):
    return kit.stipple("render", path, "--view", view, "--method", method, "--splat-size", size, "--size", given.size, "-o", picture,
                       "--backend", *way)


def compare_pictures(scenes, folder, given):
    """Each scene, method and splat size on the CPU and by both ways of OpenGL."""
    results = []
    for name, method, path, view in scenes:
        for size in given.splat_sizes:
            of = {}
            for way in WAYS:
                label = way[-1]
                picture = given.keep / f"{name}-{method}-{size}-{label}.png"
                of[label] = figures = render(path, method, view, size, way, picture, given)
                alike = kit.compare(picture, given.keep / f"{name}-{method}-{size}-cpu.png")
                rates = {k: figures[k] for k in ("frame_ms", "select_ms", "draw_ms", "shade_ms", "splats", "triangles", "listed_splats", "listed_triangles", "fragments", "covered_pixels")}
                results.append(kit.result("gpu picture", {"scene": name, "method": method, "splat_size": size, "way": label},
                                          {**rates, **(figures["gl"] or {}), **alike}))
            kit.say(f"{name}, {method}, size {size}: " + ", ".join(f"{w} {f['draw_ms']:.2f} ms" for w, f in of.items()))
    return results


def rate(result):
    """Splats and triangles a millisecond of drawing, in thousands."""
    f = result["figures"]
    return tuple(f"{f[k] / f['draw_ms'] / 1e3:,.0f}" if f["draw_ms"] > 0 else "-" for k in ("listed_splats", "listed_triangles"))


def print_pictures(results):
    rows = []
    for r in results:
        p, f = r["params"], r["figures"]
        cpu = p["way"] == "cpu"
        rows.append([p["scene"], p["method"], p["splat_size"], p["way"], f"{f['splats']:,}", f"{f['triangles']:,}", f"{f['select_ms']:.2f}",
                     f"{f['draw_ms']:.2f}", f"{f['shade_ms']:.2f}", "-" if cpu else f"{f['read_ms']:.2f}", f"{f['frame_ms']:.2f}", *rate(r),
                     "-" if cpu else f"{f['ssim']:.4f}", "-" if cpu else f"{f['ssim_covered']:.4f}"])
    kit.table(["scene", "method", "size", "way", "splats", "triangles", "select, ms", "draw", "shade", "read", "frame", "k splats/ms",
               "k triangles/ms", "SSIM", "covered"], rows)


def fly(name, path, flight, options, given):
    backend = options[0]
    kit.say(f"flight {name} {' '.join(options)} ...")
    return backend, kit.stipple("fly", path, "--path", flight, "--frames", given.frames, "--size", given.size, "--backend", *options)


def middle(frames, key, within=None):
    values = [(f[within] if within else f)[key] for f in frames]
    return statistics.median(values) if values else 0


def describe_flight(figures):
    frames, first = figures["per_frame"], figures["first_frame"]
    kept = {"frame_ms_p50": figures["frame_ms"]["p50"], "frame_ms_p99": figures["frame_ms"]["p99"], "frame_ms_max": figures["frame_ms"]["max"],
            "splat_size": middle(frames, "splat_size"), "first_ms": first["frame_ms"],
            **{key: middle(frames, key) for key in ("select_ms", "draw_ms", "shade_ms", "splats", "triangles", "fragments", "nodes")}}
    if frames[0]["gl"]:
        kept |= {key: middle(frames, key, "gl") for key in ("prepare_ms", "issue_ms", "uploaded_bytes", "resident_bytes", "missing")}
        kept["uploaded_bytes_max"] = max(f["gl"]["uploaded_bytes"] for f in frames)
        kept["first_uploaded_bytes"] = first["gl"]["uploaded_bytes"]
    if figures["budget"]:
        kept["within_1_1"] = figures["budget"]["within_1_1"]
    return kept


def orbit(path, folder):
    """A flight around a scene, from outside to near it and back."""
    info = kit.stipple("info", path)
    low, high = info["bounds"]["min"], info["bounds"]["max"]
    center = [(a + b) / 2 for a, b in zip(low, high)]
    radius = math.dist(low, high) / 2
    keys = []
    for i in range(13):
        angle, away = math.tau * i / 12, radius * (0.55 + 0.45 * math.cos(math.tau * i / 12))
        keys.append({"t": i, "eye": [center[0] + away * math.cos(angle), center[1] + 0.3 * away, center[2] + away * math.sin(angle)],
                     "target": center, "up": [0, 1, 0]})
    flight = folder / (path.stem + "-orbit.json")
    flight.write_text(json.dumps({"fov": 60, "fps": 60, "keys": keys}))
    return flight


def fly_all(flights, given):
    results = []
    sizes = [("--splat-size", str(s)) for s in given.splat_sizes]
    budgets = [("--budget-ms", str(ms)) for ms in given.budgets]
    for name, path, flight in flights:
        for setting in sizes + budgets:
            for backend in ("cpu", "gl"):
                if backend == "cpu" and given.no_cpu:
                    continue
                used, figures = fly(name, path, flight, (backend, *setting), given)
                results.append(kit.result("gpu flight", {"scene": name, "backend": used, "setting": " ".join(setting)[2:], "frames": given.frames},
                                          describe_flight(figures)))
    return results


def print_flights(results):
    rows = []
    for r in results:
        p, f = r["params"], r["figures"]
        gl = p["backend"] == "gl"
        rows.append([p["scene"], p["backend"], p["setting"], f"{f['frame_ms_p50']:.2f}", f"{f['frame_ms_p99']:.2f}", f"{f['first_ms']:.0f}",
                     f"{f['select_ms']:.2f}", f"{f['prepare_ms']:.2f}" if gl else "-", f"{f['issue_ms']:.2f}" if gl else "-", f"{f['draw_ms']:.2f}",
                     f"{f['shade_ms']:.2f}", f"{f['splat_size']:.2f}", f"{f['splats']:,.0f}", f"{f['triangles']:,.0f}",
                     f"{f['uploaded_bytes_max'] / 1e6:.1f}" if gl else "-", f"{f['resident_bytes'] / 1e6:.0f}" if gl else "-",
                     f"{f['missing']:.0f}" if gl else "-"])
    kit.table(["scene", "by", "setting", "median, ms", "99 %", "first", "select", "prepare", "issue", "draw", "shade", "size", "splats", "triangles",
               "upload max, MB", "resident, MB", "missing"], rows)


def ways_of(path):
    """The device, and the times of splats that OpenGL measures to choose how to draw them."""
    found = [r for r in kit.bench("gl", "--quick", "--model", path)["results"] if r["name"] == "gl ways"]
    if not found:
        sys.exit("OpenGL 4.5 through EGL is not available")
    return found[0]["params"]["device"].split("/")[0], found


def print_ways(ways):
    for r in ways:
        for way in ("points", "compute"):
            f = r["figures"].get(way)
            if f:
                print(f"{way}: " + ", ".join(f"{k}: {v:.3f}" for k, v in f.items()))


def make_parser():
    parser = kit.options(__doc__)
    parser.add_argument("--small", action="store_true", help="small scenes, pictures and flights")
    parser.add_argument("--flight-scene", default="paper", metavar="SCENE", help="of the flights, as in scene:SCENE; default paper")
    parser.add_argument("--flight-file", type=pathlib.Path, metavar="FILE.stip", help="the built scene, to save the time")
    parser.add_argument("--frames", type=int, default=120, help="of each flight; default 120")
    parser.add_argument("--splat-sizes", type=float, nargs="+", default=[1, 4, 16])
    parser.add_argument("--budgets", type=float, nargs="+", default=[16, 33], metavar="MS")
    parser.add_argument("--only", choices=("pictures", "flights"))
    parser.add_argument("--no-cpu", action="store_true", help="fly only with OpenGL")
    parser.add_argument("--keep", type=pathlib.Path, metavar="FOLDER", help="for the pictures; default: not kept")
    return parser


def main():
    given = make_parser().parse_args()
    if given.small:
        given.size, given.frames, given.flight_scene = "320x180", min(given.frames, 6), "paper,scale=0.001"
    with tempfile.TemporaryDirectory(prefix="stipple-gpu-") as name:
        folder = pathlib.Path(name)
        given.keep = given.keep or folder
        given.keep.mkdir(parents=True, exist_ok=True)
        cloud = scan(folder, given)
        device, ways = ways_of(cloud["blue"])
        kit.say(device)
        slug = re.sub(r"[^a-z0-9]+", "-", device.lower()).strip("-")
        given.out = given.out or kit.path_of("gpu").parent.parent / slug / kit.path_of("gpu").name
        results = list(ways)
        pictures, flown = [], []
        if given.only != "flights":
            mesh = build(folder, "mesh", "scene:one-mesh" + (",scale=0.02" if given.small else ""))
            cad = build(folder, "cad", "scene:power-plant" + (",scale=0.03" if given.small else ""))
            scenes = [("one-mesh", "blue", mesh, "front"), ("power-plant", "blue", cad, "overview"),
                      *(("cloud", method, path, "iso") for method, path in cloud.items())]
            pictures = compare_pictures(scenes, folder, given)
            results += pictures
            kit.keep("gpu", results, given.out, silent=True)
        if given.only != "pictures":
            flight_name = re.split(r"[,.-]", given.flight_scene)[0]
            large = given.flight_file or build(folder, flight_name, f"scene:{given.flight_scene}")
            flights = [(f"{given.flight_scene}", large, kit.ROOT / f"lab/scenes/flights/{flight_name}.json"),
                       ("cloud", cloud["blue"], orbit(cloud["blue"], folder))]
            flown = fly_all(flights, given)
            results += flown
    for r in results:
        r["params"]["device"] = device
    kit.keep("gpu", results, given.out)
    print(f"{device}, pictures of {given.size}\n")
    print_ways(ways)
    if pictures:
        print()
        print_pictures(pictures)
    if flown:
        print()
        print_flights(flown)


if __name__ == "__main__":
    main()
