#!/usr/bin/env python3
"""The figures and the table of Wu, Zhang, Kobbelt 2005 on real models: pictures, plots, tables, and
one JSON.

usage: MODELS=FOLDER lab/papers/psp_figures.py [PART...]

PARTs, default all:
  table      Table 1, Figures 2, 7, 8 and 10: all decimators on the bunny at three counts;
             psp-decimators.jpg, psp-errors.svg
  metrics    Figure 4: the dragon with a tenth of its points, by both metrics; psp-metrics.jpg
  progress   Figures 1 and 5: the dragon with more and more splats; psp-progress.jpg
  time       Figure 6: CPU seconds for a reduction to 1 %, by points; psp-time.svg
  mesh       Figure 9: splats and triangles at equal counts and bytes; psp-mesh.jpg
  sweep      distance and SSIM of psp, blue and spt from 10 to 100,000 splats, of the dragon with a
             quarter of its points; psp-sweep-MODEL.svg

MODELS holds bunny.ply and dragon.ply, made by lab/papers/psp_models.py; its other models (.glb, .obj,
.ply) join `sweep`. Parts that are not measured keep their results in the JSON; `sweep` saves each
figure immediately. All parts take about 8 CPU minutes.
"""
import math
import os
import pathlib
import subprocess
import tempfile
import time

import kit

COUNTS = (415, 2591, 11588)
DECIMATORS = {"psp": ("--by", "psp"), "psp, 4 neighbours": ("--by", "psp", "--neighbours", "4"),
              "psp, distances": ("--by", "psp", "--metric", "distances"), "octree-level": ("--by", "octree-level"),
              "octree": ("--by", "octree"), "quadric": ("--by", "quadric"), "subsample": ("--by", "subsample"), "blue": ("--by", "blue"),
              "mesh": ("--by", "mesh")}
PAPER = {"psp": (2.18, 2.52, 3.23), "octree-level": (2.34, 2.71, 3.22), "quadric": (4.14, 4.12, 4.23), "subsample": (1.63, 2.15, 3.13)}
ERROR_COUNTS = (100, 300, 1000, 3000, 10000)
ERROR_WAYS = ("psp", "octree", "quadric", "subsample", "blue")
TIME_WAYS = ("psp", "psp, distances", "octree", "quadric", "subsample", "blue", "mesh")
SWEEP_COUNTS = (10, 30, 100, 300, 1000, 3000, 10000, 30000, 100000)
SWEEP_WAYS = ("psp", "blue", "spt")
QUARTER = "dragon-quarter" # of its points, as a mesh: with all, comparing takes four times as long
SWEEP_KEYS = {"hausdorff_mean_percent": "mean distance, %", "hausdorff_max_percent": "largest distance, %", "ssim": "SSIM"}
SWEEP_SURFELS, SWEEP_SAMPLES, SAMPLES = "200000", 20000, 200000 # samples besides vertices; few also bound the proof of the largest
SPLAT_BYTES, MESH_VERTEX_BYTES, TRIANGLE_BYTES = 40, 12, 12 # ten floats; three floats; three indices of 32 bits
FIGURES = ("splats", "area_ratio", "hausdorff_max_percent", "hausdorff_mean_percent", "ssim", "ssim_covered")


def model(name):
    return pathlib.Path(os.environ["MODELS"]) / f"{name}.ply"


def others():
    """Models other than those of the packages."""
    return sorted(p for p in pathlib.Path(os.environ["MODELS"]).iterdir() if p.suffix in (".glb", ".obj", ".ply") and p.stem not in ("bunny", "dragon"))


def decimate(given, source, count, words, form="stip"):
    """A file of splats, and decimate's output with its CPU seconds."""
    path = given.folder / f"{source.stem}-{count}-{'-'.join(words).replace('-', '')}.{form}"
    return path, kit.timed("decimate", source, "-o", path, "--splats", count, *words, threads=given.threads)


def measure(given, splats, source, *more, samples=SAMPLES):
    figures = kit.stipple("compare-splats", splats, source, "--size", "384x384", "--samples", samples, *more, threads=given.threads)
    return {key: figures[key] for key in FIGURES}


def draw(given, stored, name, scale=1, size="400x400", view="front"):
    """A picture of splats, or of a mesh's triangles, at full size or shrunk."""
    picture = given.folder / f"{name}-{scale}.png"
    kit.stipple("render", stored, "-o", picture, "--size", size, "--view", view, "--background", "white", "--splat-scale", scale,
                *(["--reference"] if stored.suffix != ".stip" else []), "--supersample", 2, threads=given.threads)
    return picture


def sheet(path, pictures, columns, width):
    path.parent.mkdir(parents=True, exist_ok=True)
    subprocess.run([kit.STIPPLE, "sheet", *(f"{picture}={caption}" for picture, caption in pictures), "--columns", str(columns), "--width",
                    str(width), "-o", path, "--quiet"], check=True)
    kit.say(path)


class Panels:
    """Plots side by side with a logarithmic axis of counts; each has its own value axis."""
    height, left, gap, top = 150, 60, 56, 78

    def __init__(self, title, curves, rows, columns, width=230):
        self.width = width
        self.drawing = kit.Drawing(self.left + columns * (self.width + self.gap) - 20, self.top + rows * (self.height + 56) - 14)
        self.drawing.text(self.left, 20, title, more='font-weight="bold"')
        for i, curve in enumerate(curves):
            self.drawing.line([(self.left + 118 * i, 38), (self.left + 20 + 118 * i, 38)], kit.COLORS[i], 2)
            self.drawing.text(self.left + 26 + 118 * i, 42, curve)

    def add(self, row, column, name, curves, logarithmic):
        """Curves of (count, value)."""
        left, top = self.left + column * (self.width + self.gap), self.top + row * (self.height + 56)
        places = [x for curve in curves for x, _ in curve]
        values = [y for curve in curves for _, y in curve if y > 0 or not logarithmic]
        first, last = math.floor(math.log10(min(places)) + 0.1), math.ceil(math.log10(max(places)))
        step = 1 if logarithmic else 0.2 if min(values) < 0.5 else 0.1
        low, high = (math.floor(math.log10(min(values))), math.ceil(math.log10(max(values)))) if logarithmic else (step * math.floor(min(values) / step), 1)
        self.drawing.text(left, top - 8, name)
        for at in (low + step * k for k in range(round((high - low) / step) + 1)):
            y = top + self.height * (high - at) / (high - low)
            self.drawing.line([(left, y), (left + self.width, y)], "#ddd")
            self.drawing.text(left - 5, y + 4, f"{10.0 ** at:g}" if logarithmic else f"{at:.1f}", "end", 'font-size="10"')
        for power in range(first, last + 1):
            x = left + self.width * (power - first) / (last - first)
            self.drawing.line([(x, top + self.height), (x, top + self.height + 4)], "#888")
            self.drawing.text(x, top + self.height + 16, f"{10 ** power:,}", "middle", 'font-size="10"')
        for i, curve in enumerate(curves):
            points = [(left + self.width * (math.log10(x) - first) / (last - first),
                       top + self.height * (high - (math.log10(max(y, 10.0 ** low)) if logarithmic else y)) / (high - low)) for x, y in curve]
            if points:
                self.drawing.line(points, kit.COLORS[i], 2)
            for x, y in points:
                self.drawing.put(f'<circle cx="{x:.1f}" cy="{y:.1f}" r="2.5" fill="{kit.COLORS[i]}"/>')


def measure_table(given):
    results, rows, pictures, source = [], [], {}, model("bunny")
    for name, words in DECIMATORS.items():
        found = []
        for count in COUNTS:
            path, made = decimate(given, source, count, words, "ply" if name == "mesh" else "stip")
            figures = {**measure(given, path, source), "processor_seconds": made["processor_seconds"]}
            found.append(figures)
            results.append(kit.result("psp table", {"model": "bunny", "by": name, "asked": count}, figures))
            for scale in (0.3, 1):
                pictures[name, count, scale] = (draw(given, path, f"{name}-{count}", scale, view="front"), f"{name}, {figures['splats'] or count:,}")
        rows.append([name, *(f"{f['area_ratio']:.2f}" for f in found), ", ".join(map(str, PAPER.get(name, ("-",)))),
                     ", ".join(f"{f['hausdorff_max_percent']:.2f}" for f in found), ", ".join(f"{f['ssim']:.3f}" for f in found)])
    kit.table(["method", *(f"{count:,}" for count in COUNTS), "the paper", "largest distance, %", "SSIM"], rows)
    ways = ("octree-level", "quadric", "psp", "subsample")
    sheet(given.images / "psp-decimators.jpg", [pictures[way, count, 0.3] for way in ways for count in COUNTS], 3, 240)
    sheet(given.images / "psp-decimators-full.png", [pictures[way, COUNTS[0], 1] for way in ("octree-level", "quadric", "psp", "subsample")], 4, 240)
    curves = []
    for way in ERROR_WAYS:
        curve = []
        for count in ERROR_COUNTS:
            path, _ = decimate(given, source, count, DECIMATORS[way])
            figures = measure(given, path, source, "--no-pictures")
            curve.append((figures["splats"], figures))
            results.append(kit.result("psp table errors", {"model": "bunny", "by": way, "asked": count}, {k: v for k, v in figures.items() if v is not None}))
        curves.append(curve)
    panels = Panels("distance from the bunny to its splats, % of the diagonal, by splats", ERROR_WAYS, 1, 2)
    for column, key in enumerate(("hausdorff_max_percent", "hausdorff_mean_percent")):
        panels.add(0, column, ("largest", "mean")[column], [[(n, f[key]) for n, f in curve] for curve in curves], True)
    panels.drawing.write(given.images / "psp-errors.svg")
    return results


def measure_metrics(given):
    source, results, top, bottom = model("dragon"), [], [], []
    for metric in ("distances", "normals"):
        path, made = decimate(given, source, made_of(source) // 10, ("--metric", metric))
        figures = {**measure(given, path, source), "processor_seconds": made["processor_seconds"]}
        results.append(kit.result("psp metrics", {"model": "dragon", "metric": metric}, figures))
        told = f"{metric}: {figures['splats']:,}, {figures['processor_seconds']:.1f} s, {figures['hausdorff_max_percent']:.3f} %"
        top.append((draw(given, path, metric, 1, "560x400"), told))
        bottom.append((draw(given, path, metric, 0.3, "560x400"), "shrunk to 0.3"))
    kit.table(["metric", "splats", "processor seconds", "largest distance, %", "mean, %", "SSIM", "area ratio"],
              [[r["params"]["metric"], f"{r['figures']['splats']:,}", f"{r['figures']['processor_seconds']:.2f}",
                *(f"{r['figures'][k]:.3f}" for k in ("hausdorff_max_percent", "hausdorff_mean_percent", "ssim", "area_ratio"))] for r in results])
    sheet(given.images / "psp-metrics.jpg", top + bottom, 2, 420)
    return results


def made_of(source):
    """Number of points that decimate reads."""
    with tempfile.TemporaryDirectory() as folder:
        return kit.stipple("decimate", source, "-o", f"{folder}/out.ply", "--splats", 10, "--by", "octree")["points"]


def measure_progress(given):
    results, pictures, source = [], [], model("dragon")
    for count in (2000, 6000, 20000, 70000):
        path, made = decimate(given, source, count, ())
        figures = measure(given, path, source)
        results.append(kit.result("psp progress", {"model": "dragon", "asked": count}, {**figures, "processor_seconds": made["processor_seconds"]}))
        for scale in (1, 0.3):
            pictures.append((draw(given, path, f"progress-{count}", scale, "480x340"), f"{count:,} splats" + (", shrunk to 0.3" if scale < 1 else f", SSIM {figures['ssim']:.3f}")))
    sheet(given.images / "psp-progress.jpg", pictures[0::2] + pictures[1::2], 4, 260)
    return results


def measure_time(given):
    """CPU seconds for a reduction to 1 %; methods take turns."""
    results = []
    for source in (model("bunny"), *others(), model("dragon")):
        points = made_of(source)
        left_out = {"subsample"} if points > 100_000 else set() # takes minutes
        left_out |= {"mesh"} if kit.stipple("info", source)["triangles"] == 0 else set()
        ways = [way for way in TIME_WAYS if way not in left_out]
        runs = [{way: decimate(given, source, points // 100, DECIMATORS[way], "ply")[1]["processor_seconds"] for way in ways}
                for _ in range(given.repeats)]
        results += [kit.result("psp time", {"model": source.name, "by": way}, {"points": points, "processor_seconds": min(run[way] for run in runs)})
                    for way in ways]
        kit.say(source.name)
    show_time(given, results)
    return results


def show_time(given, results):
    found = {way: sorted((r["figures"]["points"], r["figures"]["processor_seconds"]) for r in results if r["params"]["by"] == way) for way in TIME_WAYS}
    panels = Panels("CPU seconds for a reduction to 1 %, by number of points", TIME_WAYS, 1, 1, 780)
    panels.add(0, 0, "seconds", found.values(), True)
    panels.drawing.write(given.images / "psp-time.svg")
    kit.table(["points", *TIME_WAYS], [[f"{n:,}", *(f"{dict(found[way])[n]:.2f}" if n in dict(found[way]) else "-" for way in TIME_WAYS)]
                                       for n, _ in found["psp"]])


def measure_mesh(given):
    """Compares at equal counts, and with a mesh of as many bytes as the splats."""
    results, pictures, source = [], [], model("dragon")
    for count in (2000, 10000):
        path, made = decimate(given, source, count, DECIMATORS["psp"])
        runs = [("psp", path, made, count * SPLAT_BYTES)]
        vertices = count
        for name in ("mesh, equal count", "mesh, equal bytes"):
            path, made = decimate(given, source, vertices, DECIMATORS["mesh"], "ply")
            size = made["vertices"] * MESH_VERTEX_BYTES + made["triangles"] * TRIANGLE_BYTES
            runs.append((name, path, made, size))
            vertices = round(vertices * count * SPLAT_BYTES / size)
        for name, path, made, size in runs:
            figures = {**measure(given, path, source), "processor_seconds": made["processor_seconds"], "bytes": size, "vertices": made.get("vertices") or 0}
            results.append(kit.result("psp mesh", {"model": "dragon", "by": name, "asked": count}, figures))
            if count == 2000:
                pictures.append((draw(given, path, f"mesh-{name}", 1, "480x340"), f"{name}: {size:,} bytes, {figures['hausdorff_max_percent']:.2f} %"))
    kit.table(["splats", "", "vertices", "bytes", "processor seconds", "largest distance, %", "mean, %", "SSIM"],
              [[r["params"]["asked"], r["params"]["by"], r["figures"]["vertices"] or "-", f"{r['figures']['bytes']:,}", f"{r['figures']['processor_seconds']:.2f}",
                *(f"{r['figures'][k]:.3f}" for k in ("hausdorff_max_percent", "hausdorff_mean_percent", "ssim"))] for r in results])
    sheet(given.images / "psp-mesh.jpg", pictures, 3, 320)
    return results


def sweep_model(given, source, results):
    """Adds missing figures of all methods at all counts."""
    there = {(r["params"]["model"], r["params"]["method"], r["params"]["asked"]) for r in results}
    missing = [(way, count) for way in SWEEP_WAYS for count in SWEEP_COUNTS if (source.name, way, count) not in there]
    if not missing:
        return
    if source.stem == QUARTER:
        kit.stipple("decimate", model("dragon"), "-o", source, "--by", "mesh", "--splats", made_of(model("dragon")) // 4)
    stored = given.folder / f"{source.stem}-all.stip"
    subprocess.run([kit.STIPPLE, "build", source, "-o", stored, "--method", ",".join(SWEEP_WAYS), "--surfels", SWEEP_SURFELS, "--surfel-ratio", "0.001", "--progress", "none",
                    "--quiet"], check=True, stdout=subprocess.DEVNULL)
    for way, count in missing:
        figures = measure(given, stored, source, "--splats", count, "--method", way, samples=SWEEP_SAMPLES)
        figures = {k: v for k, v in figures.items() if v is not None}
        results.append(kit.result("psp sweep", {"model": source.name, "method": way, "asked": count}, figures))
        given.save(results)
    stored.unlink()


def value_at(curve, count):
    """The linearly interpolated value at a count; `spt` draws fewer splats than it tests. None outside."""
    for (n, y), (m, z) in zip(curve, curve[1:]):
        if n <= count <= m and n < m:
            return y + (z - y) * math.log(count / n) / math.log(m / n)
    return None


def winners(at, key):
    """Methods whose value is the best, or within 1 % of a distance or 0.001 of SSIM."""
    if len(at) < 2:
        return "-"
    best = (max if key == "ssim" else min)(at.values())
    good = [way for way, value in at.items() if abs(value - best) <= (0.001 if key == "ssim" else 0.01 * best)]
    return "all" if len(good) == len(SWEEP_WAYS) else ", ".join(good)


def show_sweep(given, results):
    """A plot per model, and the counts at which each method wins."""
    rows = []
    for name in dict.fromkeys(r["params"]["model"] for r in results):
        stem = name.rsplit(".", 1)[0]
        panels = Panels(f"{stem}: psp, blue and spt, by splats", SWEEP_WAYS, 1, len(SWEEP_KEYS))
        for column, (key, title) in enumerate(SWEEP_KEYS.items()):
            curves = {way: sorted((r["figures"]["splats"], r["figures"][key]) for r in results
                                  if (r["params"]["model"], r["params"]["method"]) == (name, way)) for way in SWEEP_WAYS}
            panels.add(0, column, title, curves.values(), key != "ssim")
            at = [{way: value for way, curve in curves.items() if (value := value_at(curve, count)) is not None} for count in SWEEP_COUNTS]
            rows.append([stem if column == 0 else "", title, *(winners(found, key) for found in at)])
        panels.drawing.write(given.images / f"psp-sweep-{stem.replace('_', '-')}.svg")
    kit.table(["model", "", *(f"{count:,}" for count in SWEEP_COUNTS)], rows)


def measure_sweep(given):
    results = [r for r in given.kept if r["name"] == "psp sweep" and given.resume]
    for source in (model("bunny"), given.folder / f"{QUARTER}.ply", *others()):
        sweep_model(given, source, results)
        kit.say(source.name)
    show_sweep(given, results)
    return results


PARTS = {"table": measure_table, "metrics": measure_metrics, "progress": measure_progress, "mesh": measure_mesh, "time": measure_time, "sweep": measure_sweep}


def run_part(given, part):
    """Measures a part; replaces its earlier results and seconds."""
    names = ("psp table", "psp table errors") if part == "table" else (f"psp {part}",)
    others_kept = [r for r in given.kept if r["name"] not in names and (r["name"], r["params"].get("part")) != ("psp seconds", part)]
    given.save = lambda results: kit.keep("psp-figures", others_kept + results, given.out, silent=True)
    start, busy = time.monotonic(), kit.processor_seconds()
    results = PARTS[part](given)
    figures = {"seconds": round(time.monotonic() - start), "processor_seconds": round(kit.processor_seconds() - busy)}
    kit.say(f"{part}: {figures['seconds']} s, {figures['processor_seconds']} CPU s")
    if not given.resume:
        results.append(kit.result("psp seconds", {"part": part}, figures))
    given.save(results)
    given.kept = others_kept + results


def main():
    parser = kit.options(__doc__)
    parser.add_argument("parts", nargs="*", metavar="PART", help=", ".join(PARTS))
    parser.add_argument("--repeats", type=int, default=2, help="runs whose fastest counts; default 2")
    parser.add_argument("--resume", action="store_true", help="`sweep`: skip results already in the JSON")
    given = parser.parse_args()
    unknown = [part for part in given.parts if part not in PARTS]
    if unknown:
        parser.error(f"unknown part: {unknown[0]}")
    if not os.environ.get("MODELS") or not model("bunny").exists() or not model("dragon").exists():
        parser.error("MODELS must name a folder with bunny.ply and dragon.ply: lab/papers/psp_models.py FOLDER")
    path = kit.path_of("psp-figures", given.out)
    given.kept = kit.read_results(path) if path.exists() else []
    with tempfile.TemporaryDirectory() as name:
        given.folder = pathlib.Path(name)
        for part in given.parts or PARTS:
            run_part(given, part)


if __name__ == "__main__":
    main()
