#!/usr/bin/env python3
"""Method `stochastic` (Bhakar, Luo, Mudur 2004): the paper's Table 2, its cues one by one, and comparisons with the other methods.

usage: lab/papers/stochastic.py [--parts counts,cues,sizes,build,times] [--counts N,N...] [--size WxH] MODEL...

MODEL is a cloud; a mesh as PLY, of which the vertices and their normals are taken; or a mesh in another format, which stays one. Files
are built with each method, and drawn in view iso; the reference is all points, or triangles, four samples a pixel. `counts`: SSIM of
covered pixels, milliseconds (the fastest of three frames) and bytes at equal numbers of splats (`random`: sets of `blue` in random order).
`cues`: splats and SSIM with each cue switched off in turn, by size of splats. `sizes`: splats drawn by size of the picture, as in
Table 2, by the paper's rule and by ours. `build`: CPU seconds, median of three builds in turn. `times`: milliseconds of selecting and drawing by one thread, by number of splats
and by distance: the fastest of nine frames, each drawn by a separate process; the environment variable STIPPLE names another program.
Writes stochastic-MODEL.jpg: the reference, and three methods with equal numbers of splats.
"""
import math
import pathlib
import struct
import subprocess
import tempfile

import kit

METHODS = ("stochastic", "blue", "spt", "psp", "random")
CUES = ("flatness", "edge", "coverage", "silhouette", "occlusion", "error")
PAPER_SIZES = (96, 160, 250, 380, 500)  # Table 2
SIZE = "320x180"


def add_normals(vertices, triangles):
    """The normals of a mesh's vertices, by area."""
    normals = [[0.0, 0.0, 0.0] for _ in vertices]
    for corners in triangles:
        a, b, c = (vertices[k] for k in corners)
        u, v = [b[i] - a[i] for i in range(3)], [c[i] - a[i] for i in range(3)]
        across = (u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0])
        for corner in corners:
            for i in range(3):
                normals[corner][i] += across[i]
    lengths = [math.sqrt(sum(x * x for x in n)) or 1.0 for n in normals]
    return [[x / length for x in n] for n, length in zip(normals, lengths)]


def cloud_of(model, folder):
    """A cloud unchanged; the vertices of a PLY that has only x, y, z and triangles."""
    path = pathlib.Path(model)
    data = path.read_bytes() if path.suffix == ".ply" else b""
    if b"element face" not in data[:1000]:
        return path
    head, body = data.split(b"end_header\n", 1)
    count, faces = (int(line.split()[2]) for line in head.split(b"\n") if line.startswith(b"element"))
    if b"format ascii" in head:
        lines = body.split(b"\n")
        vertices = [tuple(map(float, line.split()[:3])) for line in lines[:count]]
        triangles = [tuple(map(int, line.split()[1:4])) for line in lines[count:count + faces]]
    else:
        vertices = list(struct.iter_unpack("<3f", body[:12 * count]))
        triangles = [face[1:] for face in struct.iter_unpack("<B3i", body[12 * count:12 * count + 13 * faces])]
    out = folder / path.name
    columns = "".join(f"property float {name}\n" for name in ("x", "y", "z", "nx", "ny", "nz"))
    rows = b"".join(struct.pack("<6f", *p, *n) for p, n in zip(vertices, add_normals(vertices, triangles)))
    out.write_bytes(f"ply\nformat binary_little_endian 1.0\nelement vertex {count}\n{columns}end_header\n".encode() + rows)
    return out


def build(cloud, method, folder):
    """The file of a method, and the CPU seconds of building it."""
    out = folder / f"{cloud.stem}-{method}.stip"
    chosen = ("--order", "random") if method == "random" else ("--method", method)
    before = kit.processor_seconds()
    subprocess.run([kit.STIPPLE, "build", cloud, "-o", out, *chosen, "--fresh", "--progress", "none"], check=True, stdout=subprocess.DEVNULL)
    return out, kit.processor_seconds() - before


def draw(stored, picture, size, *options):
    return kit.stipple("render", stored, "-o", picture, "--size", size, "--once", *options)


class Model:
    """A cloud, its files and its reference."""

    def __init__(self, given, model, folder, methods):
        self.name = pathlib.Path(model).stem
        self.folder, self.size = folder, given.size
        self.cloud = cloud_of(model, folder)
        self.files = {}
        for method in methods:
            kit.say(f"{self.name} {method} ...")
            self.files[method] = build(self.cloud, method, folder)[0]
        self.truth = folder / f"{self.name}-truth.png"
        draw(self.files["blue"], self.truth, given.size, "--reference", "--supersample", 2)

    def likeness(self, method, *options):
        picture = self.folder / f"{self.name}-{method}.png"
        named = () if method == "random" else ("--method", method)
        figures = draw(self.files[method], picture, self.size, *named, *options)
        return kit.compare(picture, self.truth)["ssim_covered"], figures

    def least_ms(self, method, count):
        """The fastest of three frames, each drawn by a separate process."""
        named = () if method == "random" else ("--method", method)
        return min(draw(self.files[method], self.folder / "frame.png", self.size, "--splats", count, "--accumulate", 1, *named)["frame_ms"]
                   for _ in range(3))


def compare_counts(given, model):
    results, rows = [], []
    for count in map(int, given.counts.split(",")):
        pairs = {method: model.likeness(method, "--splats", count) for method in METHODS}
        for method, (_, figures) in pairs.items():
            figures["frame_ms"] = model.least_ms(method, count)
        if count == int(given.counts.split(",")[0]):
            shown = [f"{model.truth}=all points"] + [f"{model.folder / model.name}-{m}.png={m}, {count:,} splats" for m in METHODS[:3]]
            subprocess.run([kit.STIPPLE, "sheet", *shown, "-o", given.images / f"stochastic-{model.name}.jpg", "--width", "320"], check=True)
        for method, (ssim, figures) in pairs.items():
            results.append(kit.result("stochastic-counts", {"scene": model.name, "method": method, "size": model.size, "splats": count},
                                      {"ssim_covered": ssim, "frame_ms": figures["frame_ms"], "splats": figures["splats"],
                                       "file_bytes": model.files[method].stat().st_size}))
        rows.append([model.name, f"{count:,}", *(f"{pairs[m][0]:.3f}" for m in METHODS), *(f"{pairs[m][1]['frame_ms']:.1f}" for m in METHODS)])
    kit.table(["model", "splats", *(f"SSIM {m}" for m in METHODS), *(f"ms {m}" for m in METHODS)], rows)
    return results


def switch_cues(model):
    results, rows = [], []
    lists = {"all": ",".join(CUES), "paper": "paper", **{f"without {cue}": ",".join(c for c in CUES if c != cue) for cue in CUES}}
    for label, cues in lists.items():
        row = [model.name, label]
        for size in (8, 4, 2):
            ssim, figures = model.likeness("stochastic", "--splat-size", size, "--cues", cues)
            results.append(kit.result("stochastic-cues", {"scene": model.name, "cues": label, "splat_size": size},
                                      {"ssim_covered": ssim, "splats": figures["splats"]}))
            row += [f"{figures['splats']:,}", f"{ssim:.3f}"]
        rows.append(row)
    kit.table(["model", "cues", *(f"{what} at {size} px" for size in (8, 4, 2) for what in ("splats", "SSIM"))], rows)
    return results


def grow_pictures(model):
    results, rows = [], []
    for side in PAPER_SIZES:
        counts = {label: draw(model.files["stochastic"], model.folder / "size.png", f"{side}x{side}", "--splat-size", 2,
                              *(("--cues", "paper") if label == "paper" else ()))["splats"] for label in ("paper", "ours")}
        results.append(kit.result("stochastic-sizes", {"scene": model.name, "size": f"{side}x{side}"}, counts))
        rows.append([model.name, f"{side} x {side}", f"{counts['paper']:,}", f"{counts['ours']:,}"])
    kit.table(["model", "picture", "splats, paper's rule", "splats, ours"], rows)
    return results


def time_builds(model):
    seconds = {method: [] for method in METHODS[:4]}
    for _ in range(3):
        for method, all_of in seconds.items():
            all_of.append(build(model.cloud, method, model.folder)[1])
    medians = {method: round(sorted(all_of)[1], 3) for method, all_of in seconds.items()}
    kit.table(["model", *(f"s {m}" for m in medians), *(f"MB {m}" for m in medians)],
              [[model.name, *(f"{s:.2f}" for s in medians.values()), *(f"{model.files[m].stat().st_size / 1e6:.2f}" for m in medians)]])
    return [kit.result("stochastic-build", {"scene": model.name}, medians)]


DISTANCES = (1, 2.5, 5, 10, 20, 40)  # of the eye from the middle, in half diagonals


def time_frames(given, model):
    """Selecting and drawing, of `stochastic` and `blue`: at equal numbers of splats, and at 2 pixels from growing distances."""
    box = kit.stipple("info", model.files["blue"])["bounds"]
    middle = [(a + b) / 2 for a, b in zip(box["min"], box["max"])]
    half = math.dist(box["min"], box["max"]) / 2
    ways = {f"{count:,} splats": ("--splats", count) for count in map(int, given.counts.split(","))}
    for factor in DISTANCES:
        eye = ",".join(str(m + factor * half * d / math.hypot(1, 0.8, 1.2)) for m, d in zip(middle, (1, 0.8, 1.2)))
        ways[f"distance {factor}"] = (f"--eye={eye}", "--splat-size", 2)
    results, rows = [], []
    for label, options in ways.items():
        row = [model.name, label]
        for method in ("stochastic", "blue"):
            frames = [draw(model.files[method], model.folder / "frame.png", given.size, "--accumulate", 1, "--threads", 1, *options)
                      for _ in range(9)]
            times = {name: min(f[name] for f in frames) for name in ("select_ms", "draw_ms")}
            results.append(kit.result("stochastic-times", {"scene": model.name, "method": method, "size": given.size, "view": label},
                                      {**times, "splats": frames[0]["splats"]}))
            row += [f"{frames[0]['splats']:,}", f"{times['select_ms']:.2f}", f"{times['draw_ms']:.2f}"]
        rows.append(row)
    kit.table(["model", "view", *(f"{what} {m}" for m in ("stochastic", "blue") for what in ("splats", "select ms", "draw ms"))], rows)
    return results


def main():
    parser = kit.options(__doc__, size=SIZE)
    parser.add_argument("models", nargs="+", metavar="MODEL")
    parser.add_argument("--parts", default="counts,cues,sizes,build")
    parser.add_argument("--counts", default="5000,20000,50000")
    given = parser.parse_args()
    parts = given.parts.split(",")
    results = []
    with tempfile.TemporaryDirectory() as name:
        for path in given.models:
            model = Model(given, path, pathlib.Path(name), METHODS if parts != ["times"] else METHODS[:2])
            results += compare_counts(given, model) if "counts" in parts else []
            results += switch_cues(model) if "cues" in parts else []
            results += grow_pictures(model) if "sizes" in parts else []
            results += time_builds(model) if "build" in parts else []
            results += time_frames(given, model) if "times" in parts else []
    kit.keep("stochastic", results, given.out)


if __name__ == "__main__":
    main()
