#!/usr/bin/env python3
"""Likeness of pictures to the originals, a mode for each table:

usage: bench/quality.py MODE ...; bench/quality.py MODE --help lists its options

  models OUT.csv|OUT.md PATH...  every model below the paths, from 26 directions
  views [SCENE...]               every named view of every named scene, ours and the paper's
  methods SCENE...               two methods by splat size, or at equal numbers of splats
  levels INPUT...                upper nodes captured from splats, and from triangles
  shapes SCENE...                disks, squares, Gaussians and textured splats

SCENE is a .stip with what is compared, or a model or named scene, which is built. Every view of a
scene (iso if it has none) is compared with its picture without LOD.
"""
import csv
import inspect
import math
import pathlib
import statistics
import subprocess
import sys
import tempfile

import kit


def draw(given, stored, view, picture, *more):
    """Draws one frame; with --warm, as many as a command draws. Returns its figures."""
    once = () if given.warm and "--reference" not in more else ("--once",)
    return kit.stipple("render", stored, "-o", picture, "--view", view, "--size", given.size, *once, *more, threads=given.threads)


def build(given, scene, folder, *more, suffix=""):
    """A scene's file; built into the folder unless it is one, or exists there."""
    if str(scene).endswith(".stip"):
        return pathlib.Path(scene)
    out = folder / f"{kit.name_of(scene).removeprefix('scene:').replace(',', '-').replace('=', '')}{suffix}.stip"
    if not out.exists():
        kit.say(f"{out} ...")
        out.parent.mkdir(parents=True, exist_ok=True)
        kit.stipple("build", scene, "-o", out, *more, threads=given.threads)
    return out


def views_of(stored, default=("iso",)):
    return kit.stipple("info", stored)["views"] or default


def measure(given, stored, view, ways, truth, folder):
    """Likeness and figures of each way (name: options). Times are minima over the repeats, which take turns."""
    frames = {name: [] for name in ways}
    for _ in range(given.repeats):
        for name, options in ways.items():
            frames[name].append(draw(given, stored, view, folder / f"{name}.png", *options))
    figures = {}
    for name in ways:
        best, alike = min(frames[name], key=lambda frame: frame["frame_ms"]), kit.compare(folder / f"{name}.png", truth)
        figures[name] = {"ssim": alike["ssim"], "ssim_covered": alike["ssim_covered"],
                         **{key: best[key] for key in ("frame_ms", "splats", "triangles")}}
    return figures


def sizes_of(given):
    return given.splat_sizes.split(",")


# models

COLUMNS = ["model", "series", "splat_size", "pictures", "covered_pixels", "interior_pixels", "splats", "triangles", "ssim",
           "ssim_covered", "ssim_covered_least", "interior_holes_per_10k", "interior_holes_per_10k_most", "area_ratio",
           "area_ratio_least", "area_ratio_most", "wrong_depth_per_1k", "holes_per_10k", "wrong_depth_per_10k", "extra_per_10k",
           "worst_direction"]
ENDINGS = {".glb", ".gltf", ".obj", ".stl", ".ply", ".laz", ".las", ".hgt", ".stip"}


def measured_models(given):
    """(model, results of `bench quality`); models that fail are skipped with a message."""
    for path in map(pathlib.Path, given.paths):
        for model in sorted(p for p in path.rglob("*") if p.suffix in ENDINGS) if path.is_dir() else [path]:
            try:
                yield model, kit.bench("quality", "--model", model, "--size", given.size)["results"]
            except SystemExit as failure:
                kit.say(failure)


def write_csv(file, measured):
    table = csv.DictWriter(file, COLUMNS, extrasaction="ignore")
    table.writeheader()
    for model, results in measured:
        for result in results:
            row = {**result["params"], **result["figures"], "model": model.name}
            table.writerow({k: f"{v:.4g}" if isinstance(v, float) else v for k, v in row.items()})
        file.flush()


def write_markdown(file, measured):
    for number, (model, results) in enumerate(measured):
        framed = [r for r in results if r["params"]["series"] == "framed"]
        if number == 0:
            sizes = [f"{r['params']['splat_size']:g} px" for r in framed]
            file.write("| model | " + " | ".join(sizes) + " |\n|---|" + "---|" * len(sizes) + "\n")
        cells = [f"{f['interior_holes_per_10k']:.1f}, {f['area_ratio']:.2f}, {f['wrong_depth_per_1k']:.0f}"
                 for f in (r["figures"] for r in framed)]
        file.write(f"| {model.name} | " + " | ".join(cells) + " |\n")
        file.flush()


def models(parser):
    """Runs `stipple-lab bench quality` on every model below the paths. OUT.csv gets a row per model, series and splat size;
    OUT.md a row per model: for each splat size the holes per 10,000 interior pixels, the covered area relative to the
    reference, and the wrong depths per 1,000 pixels, from 26 directions."""
    parser.add_argument("table", metavar="OUT.csv|OUT.md")
    parser.add_argument("paths", nargs="+", metavar="PATH")
    given = parser.parse_args(sys.argv[2:])
    with open(given.table, "w", newline="", encoding="utf-8") as file:
        (write_markdown if given.table.endswith(".md") else write_csv)(file, measured_models(given))


# views

SCENES = ("boxes", "spheres,scale=0.02", "one-mesh", "power-plant,scale=0.2", "forest,scale=0.1", "city-small", "city,scale=0.1",
          "terrain,scale=0.02", "bakery-line,scale=0.2", "car-factory,scale=0.1", "twenty-million,scale=0.05", "paper,scale=0.02",
          "paper-huge,scale=0.002")
COUNTS = {"equal": ("splats",), "work": ("splats", "triangles")}  # what is no more than in the paper's picture


def files_of(given, scene):
    """Our file, and the one in the paper's order (None: not requested)."""
    if ".stip" in scene:
        ours, _, other = scene.partition("=")
        return ours, other or None
    name = f"scene:{scene.removeprefix('scene:')}"
    ours = build(given, name, given.files, suffix="-exact")
    return ours, None if given.no_paper else build(given, name, given.files, "--order", given.paper_order, suffix=f"-{given.paper_order}")


def total(drawn, counts):
    return sum(drawn[key] for key in counts)


def find_equal(ours, paper, counts):
    """Ours at the smallest splat size at which it draws no more than the paper's picture."""
    most, low, high, best = total(paper, counts), 1.0, 48.0, None
    for step in range(8):
        size = 1.0 if step == 0 else math.sqrt(low * high)
        drawn = ours(size)
        if total(drawn, counts) <= most:
            best, high = {"ours_size": size, "ours_splats": drawn["splats"], "ours_triangles": drawn["triangles"], "ours": drawn["alike"]}, size
            if step == 0 or total(drawn, counts) > 0.98 * most:
                break
        else:
            low = size
    return best or {}


def measure_view(given, file, paper_file, view, folder):
    def drawn(name, *more, stored=file):
        return folder / f"{name}.png", draw(given, stored, view, folder / f"{name}.png", *more)

    def ours(size):
        if size not in sizes:
            png, figures = drawn("ours-equal", "--splat-size", f"{size:.4f}")
            sizes[size] = {**figures, "alike": kit.compare(png, truth)["ssim_covered"]}
        return sizes[size]

    sizes = {}
    truth, whole = drawn("truth", "--reference")
    picture, frame = drawn("ours", "--splat-size", 1)
    figures = {"splats": frame["splats"], "triangles": frame["triangles"], "triangles_without_lod": whole["triangles"], **kit.compare(picture, truth)}
    if given.supersample > 1:
        fine, _ = drawn("fine", "--reference", "--supersample", given.supersample)
        rest, _ = drawn("rest", "--splat-size", 1, "--accumulate", given.supersample ** 2)
        for key, png in (("fine_ours", picture), ("fine_rest", rest), ("fine_originals", truth)):
            figures[key] = kit.compare(png, fine)["ssim_covered"]
    for splat_size in [] if paper_file is None else sizes_of(given):
        png, paper = drawn("paper", "--splat-size", splat_size, "--policy", "paper", stored=paper_file)
        known = {"paper": kit.compare(png, truth)["ssim_covered"], "paper_splats": paper["splats"], "paper_triangles": paper["triangles"]}
        for kind, counts in COUNTS.items():
            figures[f"{kind}_{splat_size}"] = {**known, **find_equal(ours, paper, counts)}
    return figures


def view_row(given, scene, view, f):
    row = [scene, view, kit.short(f["splats"]), kit.short(f["triangles"]),
           *(f"{f[key]:.4f}" if key in f else "" for key in ("ssim", "ssim_covered", "fine_rest", "fine_ours", "fine_originals"))]
    for splat_size in [] if given.no_paper else sizes_of(given):
        for kind, counts in COUNTS.items():
            found = f.get(f"{kind}_{splat_size}", {})
            row.append(f"{found['ours']:.4f} / {found['paper']:.4f} ({kit.short(sum(found[f'paper_{c}'] for c in counts))})" if "ours" in found else "")
    return row


def conclude_views(given, results):
    """Counts for the goals."""
    of_views = [r["figures"] for r in results]
    fine = [f for f in of_views if "fine_ours" in f]
    covered = [f["ssim_covered"] for f in of_views]
    print(f"\n- covered SSIM of {len(of_views)} views: median {statistics.median(covered):.4f}, least {min(covered):.4f}")
    for key, words in (("fine_rest", "ours at rest"), ("fine_ours", "ours in one frame")):
        if fine:
            closer, equal = sum(f[key] > f["fine_originals"] for f in fine), sum(f[key] == f["fine_originals"] for f in fine)
            print(f"- {words} is closer to the supersampled picture than the originals at one sample in\n"
                  f"  {closer} of {len(fine)} views, equal in {equal}")
    for kind, counts in COUNTS.items():
        gains = [e["ours"] - e["paper"] for f in of_views for k, e in f.items() if k.startswith(f"{kind}_") and "ours" in e]
        if gains:
            print(f"- with no more {' and '.join(counts)}, ours is higher than `--policy paper --order {given.paper_order}`\n"
                  f"  in {sum(g > 0 for g in gains)} of {len(gains)} cases, lower in {sum(g < 0 for g in gains)} "
                  f"(least {min(gains):+.4f}, median {statistics.median(gains):+.4f})")


def views(parser):
    """Every view of the scenes, by default all named ones, the large ones scaled. Each is built into --files unless it
    exists, once with our order and once with the paper's. A SCENE that is a .stip is drawn unchanged, with OTHER
    for the paper's order as SCENE=OTHER. For each view:
    - SSIM on covered pixels at splat size 1, against the original triangles;
    - against a picture of N x N samples per pixel: ours at rest (N x N accumulated frames) and in one frame, and the
      original triangles with one sample;
    - the paper's order with --policy paper at each splat size, and ours at the smallest size at which it draws no more
      splats, and no more splats plus triangles, each against the original triangles."""
    parser.add_argument("scenes", nargs="*", metavar="SCENE", default=SCENES)
    parser.add_argument("--files", type=pathlib.Path, default=kit.ROOT / "build/scenes", help="default build/scenes")
    parser.add_argument("--splat-sizes", default="1,2,4")
    parser.add_argument("--supersample", type=int, default=4, help="default 4; 1: none")
    parser.add_argument("--paper-order", choices=("paper-fast", "paper-text"), default="paper-fast", help="default paper-fast")
    parser.add_argument("--no-paper", action="store_true", help="skip the paper's order")
    parser.add_argument("--views", help="only these, comma-separated")
    given = parser.parse_args(sys.argv[2:])
    results, rows = [], []
    for scene in given.scenes or SCENES:
        file, paper_file = files_of(given, scene)
        for view in given.views.split(",") if given.views else views_of(file):
            kit.say(f"{scene}, {view}")
            with tempfile.TemporaryDirectory() as folder:
                figures = measure_view(given, file, paper_file, view, pathlib.Path(folder))
            results.append(kit.result("quality_views", {"scene": scene, "view": view, "size": given.size}, figures))
            rows.append(view_row(given, kit.name_of(scene.partition("=")[0]) if ".stip" in scene else scene, view, figures))
    equal = [] if given.no_paper else [f"{what} of the paper's size {s}: ours / paper's ({what})"
                                       for s in sizes_of(given) for what in map(" and ".join, COUNTS.values())]
    kit.table(["scene", "view", "splats", "triangles", "SSIM", "covered", f"{given.supersample}x{given.supersample}: ours at rest",
               "in one frame", "originals", *equal], rows)
    conclude_views(given, results)
    kit.keep("quality-views" + ("-text" if given.paper_order == "paper-text" else ""), results, given.out)


# methods

PANEL_WIDTH, PANEL_HEIGHT, GAP, TOP = 250, 150, 46, 66


def plot_panel(drawing, left, top, found, names):
    most = max(r["figures"]["frame_ms"] for r in found)
    for i in range(3):
        y = top + PANEL_HEIGHT * i / 2
        drawing.line([(left, y), (left + PANEL_WIDTH, y)], "#ddd")
        drawing.text(left - 6, y + 4, f"{1 - i / 2:.1f}", "end")
    drawing.text(left, top + PANEL_HEIGHT + 16, "0")
    drawing.text(left + PANEL_WIDTH, top + PANEL_HEIGHT + 16, f"{most:.0f} ms", "end")
    for color, method in zip(kit.COLORS, names):
        points = [(left + PANEL_WIDTH * r["figures"]["frame_ms"] / most, top + PANEL_HEIGHT * (1 - max(0.0, r["figures"]["ssim_covered"])))
                  for r in found if r["params"]["method"] == method]
        drawing.line(points, color, 2)
        for x, y in points:
            drawing.put(f'<circle cx="{x:.1f}" cy="{y:.1f}" r="2.5" fill="{color}"/>')


def plot_methods(results, names, path):
    panels = sorted({(r["params"]["scene"], r["params"]["view"]) for r in results})
    columns = 3
    rows = -(-len(panels) // columns)
    drawing = kit.Drawing(columns * (PANEL_WIDTH + GAP) + 30, TOP + rows * (PANEL_HEIGHT + 70))
    drawing.text(40, 22, "likeness (SSIM of covered pixels) over the time of a frame, by splat size", more='font-weight="bold"')
    for i, method in enumerate(names):
        drawing.line([(40 + 90 * i, 40), (60 + 90 * i, 40)], kit.COLORS[i], 2)
        drawing.text(66 + 90 * i, 44, method)
    for k, panel in enumerate(panels):
        left, top = 40 + k % columns * (PANEL_WIDTH + GAP), TOP + k // columns * (PANEL_HEIGHT + 70) + 20
        drawing.text(left, top - 8, f"{panel[0]}, {panel[1]}")
        plot_panel(drawing, left, top, [r for r in results if (r["params"]["scene"], r["params"]["view"]) == panel], names)
    drawing.write(path)


def method_results(given, names, told, view, quality, figures):
    """In the results, counts have a list of both methods' figures, and sizes a result of each method."""
    params = {"scene": told, "view": view, "size": given.size}
    if given.counts:
        pairs = {key: [figures[name][key] for name in names] for key in figures[names[0]]}
        return [kit.result("methods-counts", {**params, "splats": int(quality)}, pairs)]
    return [kit.result("methods", {**params, "splat_size": float(quality), "method": name}, figures[name]) for name in names]


def methods(parser):
    """Compares two methods: quality and time of pictures. Each view is drawn at each size by each method. Prints a table
    at sizes 2 and 8; writes methods.svg, quality over time. With --counts, each view is drawn with that many splats
    instead (`render --splats N`; an upper limit for spt), and without triangles. The method auto is the default without
    --method: blue, and psp where few splats suffice. With --warm, times are medians of repeated frames, as in a flight."""
    parser.add_argument("scenes", nargs="+", metavar="SCENE")
    parser.add_argument("--methods", default="blue,spt", help="two of them")
    parser.add_argument("--splat-sizes", default="1,2,4,8,16")
    parser.add_argument("--counts", help="compare at equal numbers of splats instead, as 10000,100000")
    parser.add_argument("--repeats", type=int, default=5)
    parser.add_argument("--warm", action="store_true", help="medians of repeated frames")
    given = parser.parse_args(sys.argv[2:])
    names = given.methods.split(",")
    option, qualities = ("--splats", given.counts.split(",")) if given.counts else ("--splat-size", sizes_of(given))
    results, rows = [], []
    for told, view, quality, figures in compared(given, lambda scene: ("--method", given.methods.replace("auto", "psp")), qualities,
                                                 lambda scene, quality: {name: (option, quality, *(() if name == "auto" else ("--method", name)))
                                                                         for name in names}):
        results += method_results(given, names, told, view, quality, figures)
        pair = [figures[name] for name in names]
        if given.counts:
            rows.append([told, view, f"{int(quality):,}", *(f"{f['ssim_covered']:.3f}" for f in pair), *(f"{f['frame_ms']:.1f}" for f in pair),
                         f"{pair[1]['splats']:,}"])
        elif float(quality) in (2, 8) or given.warm:
            rows.append([told, view, quality, *(f"{f['ssim_covered']:.3f}" for f in pair), *(f"{f['frame_ms']:.0f}" for f in pair),
                         *(f"{f['splats']:,}" for f in pair), *(f"{f['triangles']:,}" for f in pair)])
    kept = "-".join(("methods", *(("counts",) if given.counts else ()), *(() if names == ["blue", "spt"] else names[1:])))
    if given.counts:
        kit.table(["scene", "view", "splats", *(f"{what} {name}" for what in ("SSIM", "ms") for name in names), f"splats of {names[1]}"], rows)
    else:
        kit.table(["scene", "view", "px", *(f"{what} {name}" for what in ("SSIM", "ms", "splats", "triangles") for name in names)], rows)
        plot_methods(results, names, given.images / f"{kept}.svg")
    kit.keep(kept, results, given.out)


def compared(given, built_with, qualities, ways_of, default=("iso",), most=None):
    """(scene, view, quality, figures of each way) of the first `most` views of all scenes."""
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        for scene in given.scenes:
            stored = build(given, scene, folder, *built_with(scene))
            told = kit.name_of(scene).removesuffix(".stip")
            for view in views_of(stored, default)[:most]:
                truth = folder / "truth.png"
                draw(given, stored, view, truth, "--reference")
                for quality in qualities:
                    yield told, view, quality, measure(given, stored, view, ways_of(scene, quality), truth, folder)
                kit.say(f"{told} {view}")


# levels

def measure_levels(given, path, capture, folder):
    """Figures of all views at each size. Both captures share the references."""
    file = folder / f"{capture}.stip"
    built = kit.stipple("build", path, "-o", file, "--fresh", "--capture", capture, threads=1)
    found = views_of(file)
    for splat_size in sizes_of(given):
        pictures = []
        for view in found:
            truth = folder / f"truth-{view}.png"
            if not truth.exists():
                draw(given, file, view, truth, "--reference")
            pictures.append(measure(given, file, view, {"picture": ("--splat-size", splat_size)}, truth, folder)["picture"])
        params = {"input": str(path), "capture": capture, "splat_size": splat_size, "views": len(found)}
        yield kit.result("levels", params, {
            "surfels": built["unique_surfels"], "capture_seconds": built["seconds"]["capture"], "total_seconds": built["seconds"]["total"],
            **{key: statistics.median(p[key] for p in pictures) for key in ("splats", "ssim", "ssim_covered")},
            "ssim_covered_least": min(p["ssim_covered"] for p in pictures)})


def levels(parser):
    """Upper nodes captured from their children's surfels, and from triangles (Brandt 3.4): cost and likeness of each.
    Builds each input both ways with one thread, and draws every view at every splat size."""
    parser.add_argument("inputs", nargs="+", metavar="INPUT")
    parser.add_argument("--splat-sizes", default="1,2,4")
    given = parser.parse_args(sys.argv[2:])
    results = []
    for path in given.inputs:
        with tempfile.TemporaryDirectory() as folder:
            for capture in ("splats", "triangles"):
                results += measure_levels(given, path, capture, pathlib.Path(folder))
    keys = ("surfels", "capture_seconds", "total_seconds", "splats", "ssim", "ssim_covered", "ssim_covered_least")
    kit.table(["input", "captured from", "px", *keys],
              [[kit.name_of(r["params"]["input"]), r["params"]["capture"], r["params"]["splat_size"],
                *(f"{r['figures'][key]:.4g}" for key in keys)] for r in results])
    kit.keep("levels", results, given.out)


# shapes

SHAPES = {"disk": (), "square": ("--splat-shape", "square"), "gaussian": ("--filter", "ewa"), "textured": ("--filter", "textured")}


def is_model(scene):
    return not scene.startswith("scene:") and not scene.endswith(".stip")


def shapes_of(given, scene, splat_size):
    hybrid = "off" if is_model(scene) else "on"
    return {shape: (*options, "--splat-size", splat_size, "--hybrid", hybrid, "--method", given.method, "--backend", given.backend)
            for shape, options in SHAPES.items()}


def built_shapes(given, scene):
    return "--method", "blue,spt", *(("--surfels", given.surfels, "--surfel-ratio", 0.001) if is_model(scene) else ())


def show_shapes(given, folder):
    """Part of a view in each shape and as the reference, enlarged three times, on one sheet."""
    scene, view, splat_size, place = given.picture
    stored = build(given, scene, folder, *built_shapes(given, scene))
    tiles = []
    for name, options in (*shapes_of(given, scene, splat_size).items(), ("reference", ("--reference",))):
        whole, tile = folder / f"show-{name}.png", folder / f"tile-{name}.png"
        draw(given, stored, view, whole, *options)
        subprocess.run([kit.ROOT / "scripts/contact_sheet.py", tile, "1", f"{whole}@{place}"], check=True)
        tiles.append(f"{tile}={name}")
    path = given.images / "splat-shapes.png"
    width = 3 * int(place.split(",")[2])
    subprocess.run([kit.STIPPLE, "sheet", *tiles, "--columns", str(len(tiles)), "--width", str(width), "-o", path, "--quiet"], check=True)
    kit.say(path)


def shapes(parser):
    """Compares splat shapes: likeness and time of pictures of disks, squares, Gaussians and textured splats. A .stip or a
    named scene is drawn with triangles where splats do not suffice; of a model, --surfels splats are made and drawn alone.
    Each of the first --views views (iso, front and top if a scene has none) is drawn at each size with each shape.
    --picture writes splat-shapes.png: part of one view, with each shape and the reference side by side."""
    parser.add_argument("scenes", nargs="+", metavar="SCENE")
    parser.add_argument("--splat-sizes", default="4,8,16")
    parser.add_argument("--views", type=int, default=3, help="views per scene; default 3")
    parser.add_argument("--surfels", type=int, default=200000, help="splats of a model; default 200000")
    parser.add_argument("--method", default="blue", choices=("blue", "spt"))
    parser.add_argument("--backend", default="cpu", choices=("cpu", "gl"))
    parser.add_argument("--repeats", type=int, default=3)
    parser.add_argument("--picture", nargs=4, metavar=("SCENE", "VIEW", "PX", "X,Y,W,H"))
    given = parser.parse_args(sys.argv[2:])
    results, rows = [], []
    if given.picture:
        with tempfile.TemporaryDirectory() as folder:
            show_shapes(given, pathlib.Path(folder))
    for told, view, splat_size, figures in compared(given, lambda scene: built_shapes(given, scene), sizes_of(given),
                                                    lambda scene, splat_size: shapes_of(given, scene, splat_size),
                                                    ("iso", "front", "top"), given.views):
        for shape, of in figures.items():
            params = {"scene": told, "view": view, "size": given.size, "shape": shape, "splat_size": float(splat_size),
                      "method": given.method, "backend": given.backend}
            results.append(kit.result("splat-shapes", params, of))
        rows.append([told, view, splat_size, *(f"{of['ssim_covered']:.3f}" for of in figures.values()),
                     *(f"{of['frame_ms']:.1f}" for of in figures.values())])
    kit.table(["scene", "view", "px", *(f"{what} {shape}" for what in ("SSIM", "ms") for shape in SHAPES)], rows)
    kit.keep("splat-shapes", results, given.out)


MODES = {"models": (models, "1920x1080"), "views": (views, "1920x1080"), "methods": (methods, "1280x720"),
         "levels": (levels, "960x540"), "shapes": (shapes, "1280x720")}  # and the default --size


def main():
    if len(sys.argv) < 2 or sys.argv[1] not in MODES:
        sys.exit(__doc__)
    mode, size = MODES[sys.argv[1]]
    parser = kit.options(inspect.cleandoc(mode.__doc__), size)
    parser.prog = f"bench/quality.py {sys.argv[1]}"
    parser.set_defaults(warm=False, repeats=1)
    mode(parser)


if __name__ == "__main__":
    main()
