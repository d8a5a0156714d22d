#!/usr/bin/env python3
"""Compares splat shapes: quality and time of pictures of disks, squares, Gaussians and textured
splats.

usage: bench/splat_shapes.py [--sizes 4,8,16] [--views N] [--repeats N] [--backend cpu|gl]
                             [--picture SCENE VIEW PX X,Y,W,H] SCENE...

SCENE is a .stip or a named scene, drawn with triangles where splats do not suffice; or a model, of
which --surfels splats are made and drawn alone. Each of its first N views (iso, front and top if it
has none) is drawn at each size with each shape and compared with its reference. Times are minima
over the repeats, which take turns. Prints a table; --picture writes splat-shapes.png: part of one
view, with each shape and the reference side by side.
"""
import pathlib
import subprocess
import tempfile

import kit

SHAPES = {"disk": (), "square": ("--splat-shape", "square"), "gaussian": ("--filter", "ewa"), "textured": ("--filter", "textured")}


def is_model(scene):
    return not scene.startswith("scene:") and not scene.endswith(".stip")


def build(given, scene, folder):
    if scene.endswith(".stip"):
        return pathlib.Path(scene)
    out = folder / (pathlib.Path(str(scene).replace(":", "-").replace(",", "-").replace("/", "-")).stem + ".stip")
    kit.say(f"{scene} ...")
    subprocess.run([kit.STIPPLE, "build", scene, "-o", out, "--method", "blue,spt", "--progress", "none",
                    *(["--surfels", str(given.surfels)] if is_model(scene) else [])], check=True, stdout=subprocess.DEVNULL)
    return out


def draw(given, scene, stored, view, size, shape, picture):
    hybrid = "off" if is_model(scene) else "on"
    options = (*SHAPES[shape], "--splat-size", size, "--hybrid", hybrid, "--method", given.method)
    return kit.stipple("render", stored, "-o", picture, "--view", view, "--size", given.size, "--once", "--backend", given.backend, *options,
                       threads=given.threads)


def draw_reference(given, stored, view, picture):
    kit.stipple("render", stored, "-o", picture, "--view", view, "--size", given.size, "--reference", "--once", threads=given.threads)


def measure(given, scene, stored, view, size, truth, folder):
    """SSIM and figures of each shape."""
    pictures = {shape: folder / f"{shape}.png" for shape in SHAPES}
    frames = {shape: [] for shape in SHAPES}
    for _ in range(given.repeats):
        for shape in SHAPES:
            frames[shape].append(draw(given, scene, stored, view, size, shape, pictures[shape]))
    figures = {}
    for shape in SHAPES:
        best = min(frames[shape], key=lambda frame: frame["frame_ms"])
        likeness = kit.compare(pictures[shape], truth)
        figures[shape] = {"ssim": likeness["ssim"], "ssim_covered": likeness["ssim_covered"], "frame_ms": best["frame_ms"],
                          "splats": best["splats"]}
    return figures


def show(given, stored, folder):
    """Part of a view in each shape and as the reference, enlarged three times, on one sheet."""
    scene, view, size, place = given.picture
    tiles = []
    for name in (*SHAPES, "reference"):
        whole, tile = folder / f"show-{name}.png", folder / f"tile-{name}.png"
        if name == "reference":
            draw_reference(given, stored, view, whole)
        else:
            draw(given, scene, stored, view, size, name, whole)
        subprocess.run([kit.ROOT / "scripts/contact_sheet.py", tile, "1", f"{whole}@{place}"], check=True)
        tiles.append(f"{tile}={name}")
    width = 3 * int(place.split(",")[2])
    path = given.images / "splat-shapes.png"
    subprocess.run([kit.STIPPLE, "sheet", *tiles, "--columns", str(len(tiles)), "--width", str(width), "-o", path, "--quiet"], check=True)
    kit.say(path)


def main():
    parser = kit.options(__doc__, size="1280x720")
    parser.add_argument("scenes", nargs="+", metavar="SCENE")
    parser.add_argument("--sizes", default="4,8,16")
    parser.add_argument("--views", type=int, default=3, help="views per scene; default 3")
    parser.add_argument("--surfels", type=int, default=200000, help="splats of a model; default 200000")
    parser.add_argument("--method", default="blue", choices=("blue", "spt"))
    parser.add_argument("--backend", default="cpu", choices=("cpu", "gl"))
    parser.add_argument("--repeats", type=int, default=3)
    parser.add_argument("--picture", nargs=4, metavar=("SCENE", "VIEW", "PX", "X,Y,W,H"))
    given = parser.parse_args()
    results, rows = [], []
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        for scene in given.scenes:
            stored = build(given, scene, folder)
            told = kit.name_of(scene).removesuffix(".stip")
            if given.picture and given.picture[0] == scene:
                show(given, stored, folder)
            for view in (kit.stipple("info", stored)["views"] or ["iso", "front", "top"])[:given.views]:
                truth = folder / "truth.png"
                draw_reference(given, stored, view, truth)
                for size in given.sizes.split(","):
                    figures = measure(given, scene, stored, view, size, truth, folder)
                    for shape, of in figures.items():
                        results.append(kit.result("splat-shapes", {"scene": told, "view": view, "size": given.size, "shape": shape,
                                                                   "splat_size": float(size), "method": given.method,
                                                                   "backend": given.backend}, of))
                    rows.append([told, view, size, *(f"{of['ssim_covered']:.3f}" for of in figures.values()),
                                 *(f"{of['frame_ms']:.1f}" for of in figures.values())])
                kit.say(f"{told} {view}")
    kit.table(["scene", "view", "px", *(f"SSIM {shape}" for shape in SHAPES), *(f"ms {shape}" for shape in SHAPES)], rows)
    kit.keep("splat-shapes", results, given.out)


if __name__ == "__main__":
    main()
