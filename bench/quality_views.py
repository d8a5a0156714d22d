#!/usr/bin/env python3
"""Similarity of named scenes to the originals: every named view, at splat size 1 and at equal
numbers of splats.

usage: bench/quality_views.py [--files FOLDER] [--splat-sizes 1,2,4] [--supersample N] [--no-paper]
                              [SCENE...]

default: all named scenes, the large ones scaled. Each is built into FOLDER (default build/scenes)
unless it exists, once with our order and once with --order paper-fast. A SCENE that is a .stip is
drawn unchanged, with OTHER for the paper's order as SCENE=OTHER. For each view:
- SSIM on covered pixels at splat size 1, against the original triangles;
- against a picture of N x N samples per pixel: ours at rest (N x N accumulated frames) and in one
frame, and the original triangles with one sample;
- the paper's order with --policy paper at each size, and ours at the smallest size at which it
draws no more splats, and no more splats plus triangles, each against the original triangles.
"""
import math
import pathlib
import statistics
import tempfile

import kit

SCENES = ("boxes", "spheres,scale=0.02", "one-mesh", "power-plant,scale=0.2", "forest,scale=0.1", "city-small", "city,scale=0.1",
          "terrain,scale=0.02", "bakery-line,scale=0.2", "car-factory,scale=0.1", "twenty-million,scale=0.05", "paper,scale=0.02",
          "paper-huge,scale=0.002")


def files_of(given, scene):
    """Our file, and the one in the paper's order (None: not requested)."""
    if ".stip" in scene:
        ours, _, other = scene.partition("=")
        return ours, other or None
    name = scene.removeprefix("scene:")
    files = []
    for order in ("exact",) if given.no_paper else ("exact", "paper-fast"):
        path = given.files / f"{name.replace(',', '-').replace('=', '')}-{order}.stip"
        if not path.exists():
            kit.say(f"{path} ...")
            path.parent.mkdir(parents=True, exist_ok=True)
            kit.stipple("build", f"scene:{name}", "-o", path, *([] if order == "exact" else ["--order", order]), threads=given.threads)
        files.append(path)
    return files[0], files[1] if len(files) > 1 else None


class Viewer:
    """Pictures of one view."""

    def __init__(self, given, file, view, folder):
        self.given, self.file, self.view, self.folder = given, file, view, folder

    def draw(self, name, *more, file=None):
        png = self.folder / f"{name}.png"
        figures = kit.stipple("render", file or self.file, "--view", self.view, "--size", self.given.size, "-o", png, "--once", *more,
                              threads=self.given.threads)
        return png, figures


def splats_of(drawn):
    return drawn["splats"]


def work_of(drawn):
    return drawn["splats"] + drawn["triangles"]


class PaperView:
    """The paper's picture at a splat size, and ours with no larger count."""

    def __init__(self, viewer, paper_file, truth, splat_size):
        self.viewer, self.truth, self.sizes = viewer, truth, {}
        png, self.paper = viewer.draw("paper", "--splat-size", splat_size, "--policy", "paper", file=paper_file)
        self.figures = {"paper": kit.compare(png, truth)["ssim_covered"], "paper_splats": self.paper["splats"],
                        "paper_triangles": self.paper["triangles"]}

    def ours(self, size):
        if size not in self.sizes:
            png, drawn = self.viewer.draw("ours-equal", "--splat-size", f"{size:.4f}")
            self.sizes[size] = (size, drawn, kit.compare(png, self.truth)["ssim_covered"])
        return self.sizes[size]

    def equal(self, count_of):
        """Ours at the smallest size at which it draws no more than the paper's."""
        most, low, high, best = count_of(self.paper), 1.0, 48.0, None
        for step in range(8):
            size = 1.0 if step == 0 else math.sqrt(low * high)
            drawn = self.ours(size)
            if count_of(drawn[1]) <= most:
                best, high = drawn, size
                if step == 0 or count_of(drawn[1]) > 0.98 * most:
                    break
            else:
                low = size
        if best is None:
            return self.figures
        return self.figures | {"ours_size": best[0], "ours_splats": best[1]["splats"], "ours_triangles": best[1]["triangles"], "ours": best[2]}


def measure_view(given, file, paper_file, view, folder):
    viewer = Viewer(given, file, view, folder)
    truth, whole = viewer.draw("truth", "--reference")
    ours, drawn = viewer.draw("ours", "--splat-size", 1)
    alike = kit.compare(ours, truth)
    figures = {"splats": drawn["splats"], "triangles": drawn["triangles"], "triangles_without_lod": whole["triangles"], **alike}
    if given.supersample > 1:
        fine, _ = viewer.draw("fine", "--reference", "--supersample", given.supersample)
        figures["fine_ours"] = kit.compare(ours, fine)["ssim_covered"]
        rest, _ = viewer.draw("rest", "--splat-size", "1", "--accumulate", given.supersample ** 2)
        figures["fine_rest"] = kit.compare(rest, fine)["ssim_covered"]
        figures["fine_originals"] = kit.compare(truth, fine)["ssim_covered"]
    for splat_size in [] if paper_file is None else given.splat_sizes.split(","):
        paper = PaperView(viewer, paper_file, truth, splat_size)
        figures[f"equal_{splat_size}"] = paper.equal(splats_of)
        figures[f"work_{splat_size}"] = paper.equal(work_of)
    return figures


def row_of(given, scene, view, f):
    def value(key):
        return f"{f[key]:.4f}" if key in f else ""

    row = [scene, view, kit.short(f["splats"]), kit.short(f["triangles"]), value("ssim"), value("ssim_covered"), value("fine_rest"),
           value("fine_ours"), value("fine_originals")]
    for splat_size in [] if given.no_paper else given.splat_sizes.split(","):
        for kind, counts in (("equal", ("splats",)), ("work", ("splats", "triangles"))):
            found = f.get(f"{kind}_{splat_size}", {})
            row.append(f"{found['ours']:.4f} / {found['paper']:.4f} ({kit.short(sum(found[f'paper_{c}'] for c in counts))})" if "ours" in found else "")
    return row


def conclude(results):
    """Counts for the goals."""
    views = [r["figures"] for r in results]
    fine = [f for f in views if "fine_ours" in f]
    covered = [f["ssim_covered"] for f in views]
    print(f"\n- covered SSIM of {len(views)} views: median {statistics.median(covered):.4f}, least {min(covered):.4f}")
    for key, words in (("fine_rest", "ours at rest"), ("fine_ours", "ours in one frame")):
        if fine:
            closer, equal = sum(f[key] > f["fine_originals"] for f in fine), sum(f[key] == f["fine_originals"] for f in fine)
            print(f"- {words} is closer to the supersampled picture than the originals at one sample in\n"
                  f"  {closer} of {len(fine)} views, equal in {equal}")
    for kind, words in (("equal_", "splats"), ("work_", "splats and triangles")):
        pairs = [e for f in views for k, e in f.items() if k.startswith(kind) and "ours" in e]
        if pairs:
            gains = [e["ours"] - e["paper"] for e in pairs]
            print(f"- with no more {words}, ours is higher than `--policy paper --order paper-fast`\n"
                  f"  in {sum(g > 0 for g in gains)} of {len(gains)} cases, lower in {sum(g < 0 for g in gains)} "
                  f"(least {min(gains):+.4f}, median {statistics.median(gains):+.4f})")


def main():
    parser = kit.options(__doc__)
    parser.add_argument("scenes", nargs="*", metavar="SCENE", default=SCENES)
    parser.add_argument("--files", type=pathlib.Path, default=kit.ROOT / "build/scenes")
    parser.add_argument("--splat-sizes", default="1,2,4")
    parser.add_argument("--supersample", type=int, default=4, help="default 4; 1: none")
    parser.add_argument("--no-paper", action="store_true", help="skip --order paper-fast")
    parser.add_argument("--views", help="only these, comma-separated")
    given = parser.parse_args()
    results, rows = [], []
    for scene in given.scenes or SCENES:
        file, paper_file = files_of(given, scene)
        views = given.views.split(",") if given.views else kit.stipple("info", file)["views"] or ["iso"]
        for view in views:
            kit.say(f"{scene}, {view}")
            with tempfile.TemporaryDirectory() as folder:
                figures = measure_view(given, file, paper_file, view, pathlib.Path(folder))
            results.append(kit.result("quality_views", {"scene": scene, "view": view, "size": given.size}, figures))
            rows.append(row_of(given, kit.name_of(scene.partition("=")[0]) if ".stip" in scene else scene, view, figures))
    equal = [] if given.no_paper else [f"{what} of the paper's size {s}: ours / paper's ({what})"
                                       for s in given.splat_sizes.split(",") for what in ("splats", "splats and triangles")]
    kit.table(["scene", "view", "splats", "triangles", "SSIM", "covered", f"{given.supersample}x{given.supersample}: ours at rest", "in one frame", "originals", *equal], rows)
    conclude(results)
    kit.keep("quality-views", results, given.out)


main()
