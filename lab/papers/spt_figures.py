#!/usr/bin/env python3
"""The figures of Dachsbacher et al. 2003 on real models: pictures, plots, tables, and one JSON.

usage: [MODELS=FOLDER] lab/papers/spt_figures.py [PART...]

PARTs, default all:
  cut        Figures 1, 4 and 5: points of the sequence tested and drawn by distance; spt-cut.svg
  near-far   Figure 1: one model as drawn from increasing distances, enlarged; spt-near-far.png
  hybrid     Figure 6: triangles and splats in two colours; spt-hybrid.png
  color      Figure 7: density of points by colour; spt-color.png
  scene      Figure 8: a scene, and points per second; spt-scene.png
  errors     points drawn by distance, with the three errors; spt-errors.svg
  crossing   the distance from which points beat triangles; spt-crossing.svg
  bytes      bytes per point in the file and in memory

Models are those of Debian's assimp-testmodels, and scenes of `stipple build scene:NAME`; those of
MODELS (.glb, .obj, .ply, .stl) join `crossing` and `bytes`. Models get 200,000 samples in one set.
Parts that are not measured keep their results in the JSON.
"""
import json
import math
import os
import pathlib
import statistics
import subprocess
import sys
import tempfile

import kit
import spt_cut

sys.path.insert(0, str(kit.ROOT / "scripts"))
import contact_sheet  # noqa: E402

TESTMODELS = pathlib.Path("/usr/share/assimp/models")
ENGINE, WUSON, DUCK = (str(TESTMODELS / name) for name in ("glTF2/2CylinderEngine-glTF-Binary/2CylinderEngine.glb", "PLY/Wuson.ply",
                                                           "Collada/duck.dae"))
MODELS = [WUSON, DUCK, str(TESTMODELS / "IFC/AC14-FZK-Haus.ifc"), ENGINE, "scene:one-mesh,scale=0.3", "scene:power-plant,scale=0.1"]
ERROR_MODELS = [WUSON, DUCK, ENGINE]
FOREST = "scene:forest,scale=0.3"
DISTANCES = (0.75, 1.5, 3, 6, 12, 24, 48)
CROSSING_DISTANCES = (0.75, 1, 1.5, 2, 3, 4, 6, 8, 12, 16, 24, 32, 48)
CROSSING_WAYS = {"triangles": ("--reference",), "1 px": ("--hybrid", "off", "--epsilon", "1"), "2 px": ("--hybrid", "off", "--epsilon", "2")}
DIRECTION = tuple(v / math.dist((0.6, 0.45, -0.66), (0, 0, 0)) for v in (0.6, 0.45, -0.66))
BLUE_BYTES, SPT_BYTES, GROUP_BYTES, GROUP_SPLATS = 9, 21, 32, 64 # of positions, normals, materials; with colours, shapes, ranges


def build(given, model, method, *more):
    """A file of the model, kept in the work folder until the script ends."""
    key = "-".join((kit.name_of(model).replace(":", "-").replace(",", "-"), method, *more)).replace(",", "-")
    path = given.folder / f"{key}.stip"
    if not path.exists():
        kit.say(f"{kit.name_of(model)} {method} ...")
        subprocess.run([kit.STIPPLE, "build", model, "-o", path, "--method", method, "--progress", "none", "--quiet", *more], check=True,
                       stdout=subprocess.DEVNULL)
    return path


def build_one_set(given, model, method, *more):
    """200,000 samples of the root only, as in the paper: no other node has as many triangles."""
    triangles = kit.stipple("info", model)["triangles"]
    return build(given, model, method, "--surfels", "200000", "--surfel-ratio", "0.001", "--threshold", str(triangles - 1), *more)


def told(model):
    return kit.name_of(model).split(".")[0] if "/" in model else model.removeprefix("scene:")


def models():
    """The default models, and those of MODELS."""
    folder = os.environ.get("MODELS")
    found = sorted(str(p) for p in pathlib.Path(folder).iterdir() if p.suffix in (".glb", ".obj", ".ply", ".stl")) if folder else []
    return MODELS + found


def eye_at(info, distance):
    """An eye `sizes` model sizes from the model's centre, and the centre."""
    low, high = info["bounds"]["min"], info["bounds"]["max"]
    center = [0.5 * (a + b) for a, b in zip(low, high)]
    return [c + d * distance * math.dist(low, high) for c, d in zip(center, DIRECTION)], center


def look(info, distance):
    eye, center = eye_at(info, distance)
    return ("--eye", ",".join(f"{v:.9g}" for v in eye), "--target", ",".join(f"{v:.9g}" for v in center))


def draw(given, stored, picture, *more, size=None):
    return kit.stipple("render", stored, "-o", picture, "--size", size or given.size, "--once", *more, threads=given.threads)


def sheet(path, pictures, columns, width):
    """Pictures with captions on one sheet."""
    path.parent.mkdir(parents=True, exist_ok=True)
    subprocess.run([kit.STIPPLE, "sheet", *(f"{picture}={caption}" for picture, caption in pictures), "--columns", str(columns), "--width",
                    str(width), "-o", path, "--quiet"], check=True)
    kit.say(path)


def crop(picture, place):
    subprocess.run([kit.ROOT / "scripts/contact_sheet.py", picture, "1", f"{picture}@{place}"], check=True)


def measure_cut(given):
    stored = build_one_set(given, WUSON, "spt")
    info = kit.stipple("info", stored)
    results = spt_cut.measure(stored, told(WUSON), DISTANCES, DIRECTION, info["bounds"], given.images / "spt-cut.svg")
    kit.table(["sizes away", "visited", "of constant distance", "drawn", "too coarse", "too fine"],
              [[f"{r['params']['sizes_away']:g}", *(f"{r['figures'][k]:,}" for k in ("looked_at", "looked_at_constant", "drawn", "too_coarse",
                                                                                    "too_fine"))] for r in results])
    return results


def measure_near_far(given):
    """Draws the picture from one position with larger splats, which equals drawing from afar at one pixel."""
    stored = build_one_set(given, WUSON, "spt")
    view = look(kit.stipple("info", stored), 0.8)
    top, bottom, results = [], [], []
    for epsilon in (2, 8, 16, 32):
        pictures = [given.folder / f"near-{epsilon}-{scale}.png" for scale in (1, 0.35)]
        for scale, picture in zip((1, 0.35), pictures):
            figures = draw(given, stored, picture, *view, "--hybrid", "off", "--epsilon", epsilon, "--splat-scale", scale, size="400x300")
            crop(picture, "62,50,300,215")
        results.append(kit.result("spt near far", {"model": told(WUSON), "epsilon": epsilon}, {"looked_at": figures["splats"]}))
        top.append((pictures[0], f"{epsilon} px, {kit.short(figures['splats'])} points visited"))
        bottom.append((pictures[1], "splats shrunk to 0.35"))
    sheet(given.images / "spt-near-far.png", top + bottom, 4, 240)
    return results


def paint(drawn, shrunk, truth, picture):
    """Marks pixels that show a splat in red: those that change if splats shrink, or differ from the original triangles."""
    width, _, rows = contact_sheet.read_png(drawn)
    others = [contact_sheet.read_png(path)[2] for path in (shrunk, truth)]
    out, red = [], 0
    for y, row in enumerate(rows):
        line = bytearray(row)
        for x in range(width):
            at = slice(3 * x, 3 * x + 3)
            if row[at] != b"\xff\xff\xff" and any(other[y][at] != row[at] for other in others):
                grey = sum(row[at]) // 3
                line[at] = bytes((90 + grey * 150 // 255, grey * 80 // 255, grey * 70 // 255))
                red += 1
        out.append(bytes(line))
    contact_sheet.write_png(picture, width, out)
    return red


def measure_hybrid(given):
    stored = build(given, ENGINE, "spt", "--surfels", "200000", "--surfel-ratio", "0.001")
    truth, size, place = given.folder / "truth.png", "640x360", "50,45,550,240"
    draw(given, stored, truth, "--view", "front", "--background", "white", "--reference", size=size)
    plain, painted, results = [], [], []
    for hybrid in ("on", "nodes", "off"):
        drawn, shrunk, red = (given.folder / f"hybrid-{hybrid}-{k}.png" for k in ("drawn", "shrunk", "red"))
        options = ("--view", "front", "--background", "white", "--epsilon", 8, "--hybrid", hybrid)
        figures = draw(given, stored, drawn, *options, size=size)
        draw(given, stored, shrunk, *options, "--splat-scale", 0.01, size=size)
        share = paint(drawn, shrunk, truth, red) / figures["covered_pixels"]
        likeness = kit.compare(drawn, truth)
        results.append(kit.result("spt hybrid", {"model": told(ENGINE), "hybrid": hybrid, "epsilon": 8, "size": size},
                                  {**{k: figures[k] for k in ("splats", "triangles", "frame_ms")}, "ssim_covered": likeness["ssim_covered"],
                                   "splat_pixels": share}))
        for picture in (drawn, red):
            crop(picture, place)
        plain.append((drawn, f"--hybrid {hybrid}: {figures['triangles']:,} triangles"))
        painted.append((red, f"red: splats, {100 * share:.0f} % of pixels"))
    sheet(given.images / "spt-hybrid.png", plain + painted, 3, 340)
    kit.table(["hybrid", "splats", "triangles", "SSIM", "pixels of splats"],
              [[r["params"]["hybrid"], f"{r['figures']['splats']:,}", f"{r['figures']['triangles']:,}", f"{r['figures']['ssim_covered']:.3f}",
                f"{100 * r['figures']['splat_pixels']:.0f} %"] for r in results])
    return results


def measure_color(given):
    """The head of a textured model: with the geometric error only, and with colour in the error."""
    top, bottom, results = [], [], []
    for threshold in (255, 48, 16):
        stored = build_one_set(given, DUCK, "spt", "--color-threshold", str(threshold))
        view, size = look(kit.stipple("info", stored), 0.8)[2:], "960x720"
        pictures = [given.folder / f"color-{threshold}-{scale}.png" for scale in (0.3, 1)]
        truth = given.folder / "color-truth.png"
        for scale, picture in zip((0.3, 1), pictures):
            figures = draw(given, stored, picture, "--view", "iso", *view, "--hybrid", "off", "--epsilon", 16, "--splat-scale", scale, size=size)
        draw(given, stored, truth, "--view", "iso", *view, "--reference", size=size)
        likeness = kit.compare(pictures[1], truth)["ssim_covered"]
        results.append(kit.result("spt color", {"model": told(DUCK), "color_threshold": threshold, "epsilon": 16},
                                  {"looked_at": figures["splats"], "ssim_covered": likeness}))
        top.append((pictures[0], f"threshold {threshold}, shrunk to 0.3"))
        bottom.append((pictures[1], f"in full size, SSIM {likeness:.3f}"))
    place = "430,110,330,250"
    for picture, _ in top + bottom + [(truth, "")]:
        crop(picture, place)
    sheet(given.images / "spt-color.png", top + bottom, 3, int(place.split(",")[2]))
    return results


def measure_scene(given):
    """A view at several errors: points tested per second of drawing, also for splats only."""
    stored = build(given, FOREST, "spt")
    results, rows = [], []
    for epsilon in (4, 8, 16):
        for hybrid in ("nodes", "on"):
            picture = given.folder / f"scene-{epsilon}-{hybrid}.png"
            frames = [draw(given, stored, picture, "--view", "overview", "--epsilon", epsilon, "--hybrid", hybrid, "--background", "b9d0e6")
                      for _ in range(given.repeats)]
            f = {k: statistics.median(frame[k] for frame in frames) for k in ("splats", "triangles", "frame_ms", "select_ms", "draw_ms")}
            f["splats_per_second"] = 1e3 * f["splats"] / (f["select_ms"] + f["draw_ms"])
            f["primitives_per_second"] = 1e3 * (f["splats"] + f["triangles"]) / (f["select_ms"] + f["draw_ms"])
            results.append(kit.result("spt scene", {"scene": told(FOREST), "view": "overview", "epsilon": epsilon, "hybrid": hybrid,
                                                    "size": given.size}, f))
            rows.append([epsilon, hybrid, f"{f['splats']:,.0f}", f"{f['triangles']:,.0f}", f"{f['frame_ms']:.0f}",
                         kit.short(f["splats_per_second"]), kit.short(f["primitives_per_second"])])
    kit.table(["epsilon", "hybrid", "splats", "triangles", "ms", "splats a second", "both a second"], rows)
    sheet(given.images / "spt-scene.png", [(given.folder / "scene-8-on.png", "")], 1, 500)
    return results


class Panels:
    """Logarithmic plots side by side, with a common distance axis."""
    width, height, left, gap, top = 230, 170, 56, 50, 78

    def __init__(self, title, curves, count, columns):
        self.columns = columns
        rows = -(-count // columns)
        self.drawing = kit.Drawing(self.left + columns * (self.width + self.gap) - 20, self.top + rows * (self.height + 66) - 24)
        self.drawing.text(self.left, 20, title, more='font-weight="bold"')
        for i, curve in enumerate(curves):
            self.drawing.line([(self.left + 110 * i, 38), (self.left + 20 + 110 * i, 38)], kit.COLORS[i], 2)
            self.drawing.text(self.left + 26 + 110 * i, 42, curve)

    def add(self, k, name, curves, low, high, unit=""):
        """Curves of (distance, value, whether the point is filled)."""
        left, top = self.left + k % self.columns * (self.width + self.gap), self.top + k // self.columns * (self.height + 66)
        first, last = math.log2(0.75), math.log2(48)
        self.drawing.text(left, top - 8, name)
        for power in range(low, high + 1):
            y = top + self.height * (high - power) / (high - low)
            self.drawing.line([(left, y), (left + self.width, y)], "#ddd")
            self.drawing.text(left - 5, y + 4, f"{10.0 ** power:,g}{unit}" if power < 4 else f"{10 ** (power - 3):,g} k", "end", 'font-size="10"')
        for distance in DISTANCES:
            x = left + self.width * (math.log2(distance) - first) / (last - first)
            self.drawing.line([(x, top + self.height), (x, top + self.height + 4)], "#888")
            self.drawing.text(x, top + self.height + 16, f"{distance:g}", "middle", 'font-size="10"')
        for i, curve in enumerate(curves):
            points = [(left + self.width * (math.log2(x) - first) / (last - first),
                       top + self.height * (high - math.log10(max(y, 10.0 ** low))) / (high - low)) for x, y, _ in curve]
            self.drawing.line(points, kit.COLORS[i], 2)
            for (x, y), (_, _, filled) in zip(points, curve):
                self.drawing.put(f'<circle cx="{x:.1f}" cy="{y:.1f}" r="3" stroke="{kit.COLORS[i]}" stroke-width="1.2" '
                                 f'fill="{kit.COLORS[i] if filled else "#fff"}"/>')


def measure_errors(given):
    results, kinds = [], ("unified", "split", "qsplat")
    panels = Panels("points drawn, by distance in sizes of the model; 1 px of 1080 rows", ("unified", "split", "QSplat"), len(ERROR_MODELS), 3)
    for k, model in enumerate(ERROR_MODELS):
        found = [r for r in kit.bench("spt", "--model", model, "--count", 200000)["results"] if r["name"] == "spt distance"]
        for r in found:
            results.append(kit.result("spt errors", {"model": told(model), "points": 200000, **r["params"]}, {k: r["figures"][k] for k in (*kinds, "looked_at", "drawn_by_sequence", "sequence_draw_ms")}))
        panels.add(k, told(model), [[(r["params"]["sizes_away"], max(1, r["figures"][kind]), True) for r in found] for kind in kinds], 2, 6)
    panels.drawing.write(given.images / "spt-errors.svg")
    kit.table(["model", "sizes away", *kinds, "visited per second", "drawn per second, one thread"],
              [[r["params"]["model"], r["params"]["sizes_away"], *(f"{r['figures'][kind]:,}" for kind in kinds),
                *(kit.short(1e3 * r["figures"][k] / r["figures"]["sequence_draw_ms"]) for k in ("looked_at", "drawn_by_sequence"))] for r in results])
    return results


def times_at(given, stored, info, distance):
    """The fastest frame (selection plus drawing) of each way. Ways take turns; the flights stand still, so all
    frames after the first are warm. Excludes shading, which is the same for all."""
    eye, center = eye_at(info, distance)
    keys = [{"t": t, "eye": eye, "target": center, "up": [0, 1, 0]} for t in (0, 1)]
    path = given.folder / "still.json"
    path.write_text(json.dumps({"fov": 60, "fps": 5, "keys": keys}), encoding="utf-8")
    frames = {way: [] for way in CROSSING_WAYS}
    for _ in range(given.repeats):
        for way, options in CROSSING_WAYS.items():
            frames[way] += kit.stipple("fly", stored, "--path", path, "--frames", 5, "--size", given.size, *options,
                                       threads=given.threads)["per_frame"]
    best = {way: min(found, key=lambda frame: frame["select_ms"] + frame["draw_ms"]) for way, found in frames.items()}
    return {way: {"ms": frame["select_ms"] + frame["draw_ms"], "median_ms": statistics.median(f["select_ms"] + f["draw_ms"] for f in frames[way]),
                  **{k: frame[k] for k in ("frame_ms", "splats", "triangles")}} for way, frame in best.items()}


def likeness_at(given, stored, info, distance, way):
    """SSIM of splats and of triangles, with one sample per pixel, against triangles with 16 samples per pixel."""
    ours, truth = given.folder / "ours.png", given.folder / "truth.png"
    draw(given, stored, truth, *look(info, distance), "--reference", "--supersample", 4)
    found = {}
    for name in ("triangles", way):
        draw(given, stored, ours, *look(info, distance), *CROSSING_WAYS[name])
        found[name] = kit.compare(ours, truth)["ssim_covered"]
    return found[way], found["triangles"]


def crossing_of(at):
    """The distance from which on splats are faster at all measured ones, by way."""
    found = {}
    for way in list(CROSSING_WAYS)[1:]:
        faster = [d for d in CROSSING_DISTANCES if all(at[e][way]["ms"] < at[e]["triangles"]["ms"] for e in CROSSING_DISTANCES if e >= d)]
        found[way] = faster[0] if faster else None
    return found


def cross(given, model):
    """Times by distance of one model, and its crossings."""
    stored = build_one_set(given, model, "spt")
    info = kit.stipple("info", stored)
    at = {d: times_at(given, stored, info, d) for d in CROSSING_DISTANCES}
    enough = {way: {d: draw(given, stored, given.folder / "probe.png", *look(info, d), "--hybrid", "nodes", *options[2:])["triangles"] == 0
                    for d in CROSSING_DISTANCES} for way, options in CROSSING_WAYS.items() if way != "triangles"}
    results = [kit.result("spt crossing time", {"model": told(model), "way": way, "size": given.size, "threads": given.threads},
                          {"sizes_away": list(CROSSING_DISTANCES),
                           **{k: [round(at[d][way][k], 4) for d in CROSSING_DISTANCES] for k in at[CROSSING_DISTANCES[0]][way]},
                           **({"splats_suffice": [int(v) for v in enough[way].values()]} if way in enough else {})}) for way in CROSSING_WAYS]
    for way, distance in crossing_of(at).items():
        suffices = [d for d in CROSSING_DISTANCES if all(enough[way][e] for e in CROSSING_DISTANCES if e >= d)]
        figures = {"triangles": info["triangles"], "points": info["surfels"], "sizes_away": distance, "suffices_from": suffices[0] if suffices else None}
        if distance is not None:
            figures["ssim_covered"], figures["ssim_covered_triangles"] = likeness_at(given, stored, info, distance, way)
            figures["splats"] = at[distance][way]["splats"]
            figures["triangles_ms"], figures["splats_ms"] = (at[distance][w]["ms"] for w in ("triangles", way))
        results.append(kit.result("spt crossing", {"model": told(model), "way": way}, figures))
    return results, [[(d, at[d][way]["ms"], enough.get(way, {}).get(d, True)) for d in CROSSING_DISTANCES] for way in CROSSING_WAYS]


def measure_crossing(given):
    names, results, rows = models(), [], []
    panels = Panels(f"selecting and drawing, ms, by distance in sizes of the model; {given.size}; filled: splats suffice", CROSSING_WAYS, len(names), 3)
    for k, model in enumerate(names):
        found, curves = cross(given, model)
        results += found
        triangles = next(r["figures"]["triangles"] for r in found if "triangles" in r["figures"] and r["name"] == "spt crossing")
        panels.add(k, f"{told(model)}, {kit.short(triangles)} triangles", curves, -2, 2)
        for r in found:
            f = r["figures"]
            if r["name"] == "spt crossing":
                rows.append([r["params"]["model"], f"{f['triangles']:,}", r["params"]["way"], f["sizes_away"] or "none", f["suffices_from"] or "none",
                             *([f"{f['splats']:,}", f"{f['triangles_ms']:.2f}", f"{f['splats_ms']:.2f}", f"{f['ssim_covered']:.3f}", f"{f['ssim_covered_triangles']:.3f}"]
                               if f["sizes_away"] else ["-"] * 5)])
        kit.say(told(model))
    panels.drawing.write(given.images / "spt-crossing.svg")
    kit.table(["model", "triangles", "error", "faster from", "splats suffice from", "splats there", "ms of triangles", "ms of splats", "SSIM there", "of triangles"], rows)
    return results


def memory_of(path):
    """Bytes per point of the columns in memory, by method: blue stores colours and coverages for each octave's whole prefix."""
    _, tables = spt_cut.read_tables(path)
    found = {}
    for method in tables["methods"]:
        sets = tables["surfels"][method["first_set"]:method["first_set"] + method["set_count"]]
        count = sum(s["count"] for s in sets)
        if method["columns"] & 4:
            found[method["name"]] = SPT_BYTES + GROUP_BYTES * sum(-(-s["count"] // GROUP_SPLATS) for s in sets) / count
        else:
            found[method["name"]] = BLUE_BYTES + 4 * sum(sum(s["octave_ends"]) for s in sets) / count
        found[f"{method['name']} points"] = count
    return found


def measure_bytes(given):
    results, rows = [], []
    for model in models():
        alone = {method: kit.stipple("info", build_one_set(given, model, method)) for method in ("blue", "spt")}
        both_path = build_one_set(given, model, "blue,spt")
        both, memory = kit.stipple("info", both_path), memory_of(both_path)
        f = {"triangles": both["triangles"], "both_splat_bytes": both["splat_bytes"], "both_file_bytes": both["file_bytes"],
             "triangle_bytes": both["triangle_bytes"]}
        for method, info in alone.items():
            f.update({f"{method}_points": memory[f"{method} points"], f"{method}_splat_bytes": info["splat_bytes"], f"{method}_file_bytes": info["file_bytes"],
                      f"{method}_in_file": info["splat_bytes"] / memory[f"{method} points"], f"{method}_in_memory": memory[method]})
        results.append(kit.result("spt bytes", {"model": told(model)}, f))
        rows.append([told(model), f"{f['blue_points']:,}", f"{f['spt_points']:,}", *(f"{f[k]:.1f}" for k in ("blue_in_file", "spt_in_file", "blue_in_memory",
                                                                                                         "spt_in_memory")),
                     f"{f['spt_splat_bytes'] / f['blue_splat_bytes']:.2f}", f"{f['both_splat_bytes'] / (f['blue_splat_bytes'] + f['spt_splat_bytes']):.3f}"])
    kit.table(["model", "points blue", "points spt", "in the file, blue", "spt", "in memory, blue", "spt", "bytes of spt, of blue's", "of both, of the sum"], rows)
    return results


PARTS = {"cut": measure_cut, "near-far": measure_near_far, "hybrid": measure_hybrid, "color": measure_color, "scene": measure_scene,
         "errors": measure_errors, "crossing": measure_crossing, "bytes": measure_bytes}
NAMES = {"near-far": "spt near far"}


def main():
    parser = kit.options(__doc__, size="1280x720")
    parser.add_argument("parts", nargs="*", metavar="PART", help=", ".join(PARTS))
    parser.add_argument("--repeats", type=int, default=2, help="flights or pictures per median; default 2")
    given = parser.parse_args()
    unknown = [part for part in given.parts if part not in PARTS]
    if unknown:
        parser.error(f"unknown part: {unknown[0]}")
    path = kit.path_of("spt-figures", given.out)
    kept = kit.read_results(path) if path.exists() else []
    with tempfile.TemporaryDirectory() as name:
        given.folder = pathlib.Path(name)
        for part in given.parts or PARTS:
            names = {"crossing": ("spt crossing", "spt crossing time")}.get(part, (NAMES.get(part, f"spt {part}"),))
            kept = [r for r in kept if r["name"] not in names] + PARTS[part](given)
            kit.keep("spt-figures", kept, given.out)


if __name__ == "__main__":
    main()
