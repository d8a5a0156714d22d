#!/usr/bin/env python3
"""Picture quality by bytes read: SSIM of prefixes of a file, in steps of a twentieth, against the
whole file, seen from outside.

usage: bench/prefix.py [--steps N] [--view NAME] MODEL...

MODEL is a .stip, a model, a named scene (scene:city,scale=0.1), or a folder of .stip files. Models
and scenes are built into a temporary folder. Prints a table with the largest drop from one step to
the next; writes prefix-bytes.svg.
"""
import pathlib
import subprocess
import tempfile

import kit

WIDTH, HEIGHT, LEFT, TOP, BOTTOM = 660, 300, 60, 40, 120


def find_models(names):
    """Expands folders to the .stip files in them."""
    for name in names:
        path = pathlib.Path(name)
        yield from sorted(path.glob("*.stip")) if path.is_dir() else [name]


def build(model, folder):
    if str(model).endswith(".stip"):
        return pathlib.Path(model)
    out = folder / (pathlib.Path(str(model).replace(":", "-").replace("/", "-")).stem + ".stip")
    kit.say(f"{model} ...")
    subprocess.run([kit.STIPPLE, "build", model, "-o", out, "--progress", "none"], check=True, stdout=subprocess.DEVNULL)
    return out


def measure(given, model, folder):
    """SSIM of each prefix; 0 while the directory is incomplete."""
    stored = build(model, folder)
    whole, part = folder / "whole.png", folder / "part.png"
    look = ("--size", given.size)
    drawn = kit.stipple("render", stored, "-o", whole, "--once", "--view", given.view, *look, threads=given.threads)  # as prefixes are drawn
    camera = drawn["camera"]
    look += tuple(f"--{key}={','.join(map(str, camera[key]))}" for key in ("eye", "target", "up")) + ("--fov", camera["fov"])
    bytes_of_file, grown = stored.stat().st_size, []
    for step in range(1, given.steps + 1):
        size = -(-bytes_of_file * step // given.steps)
        call = [kit.STIPPLE, "render", stored, "-o", part, "--prefix", str(size), "--backend", "cpu", "--color", "rgb", "--once", "--quiet", *look]
        done = subprocess.run(list(map(str, call)), capture_output=True, text=True)
        if done.returncode != 0 and "within its directory" not in done.stderr:
            raise SystemExit(done.stderr)
        grown.append(round(kit.compare(part, whole)["ssim"], 4) if done.returncode == 0 else 0.0)
    falls = [before - after for before, after in zip(grown, grown[1:])]
    return {"bytes": bytes_of_file, "ssim": grown, "largest_fall": max(0.0, *falls)}


def plot(results, path):
    drawing = kit.Drawing(WIDTH, TOP + HEIGHT + BOTTOM)
    steps = len(results[0]["figures"]["ssim"])

    def place(part, ssim):
        return LEFT + part * (WIDTH - LEFT - 20), TOP + HEIGHT * (1 - (ssim - 0.5) / 0.5)

    drawing.text(LEFT, 22, "likeness (SSIM) to the whole file's picture, over the part of the file that is read", more='font-weight="bold"')
    for i in range(6):
        x, y = place(0, 0.5 + 0.1 * i)
        drawing.line([(x, y), (WIDTH - 20, y)], "#ddd")
        drawing.text(x - 8, y + 4, f"{0.5 + 0.1 * i:.1f}", "end")
        x, y = place(0.2 * i, 0.5)
        drawing.text(x, y + 20, f"{20 * i} %", "middle")
    for k, r in enumerate(results):
        color = kit.COLORS[k % len(kit.COLORS)]
        points = [place((i + 1) / steps, max(s, 0.5)) for i, s in enumerate(r["figures"]["ssim"]) if s > 0]
        drawing.line(points, color, 2)
        for x, y in points:
            drawing.put(f'<circle cx="{x:.1f}" cy="{y:.1f}" r="2.5" fill="{color}"/>')
        x, y = LEFT + (k % 2) * 290, TOP + HEIGHT + 48 + 20 * (k // 2)
        drawing.line([(x, y - 4), (x + 20, y - 4)], color, 2)
        drawing.text(x + 26, y, f"{kit.name_of(r['params']['model'])}, {r['figures']['bytes'] / 1e6:.1f} MB")
    drawing.write(path)


def main():
    parser = kit.options(__doc__, size="640x360")
    parser.add_argument("models", nargs="+", metavar="MODEL")
    parser.add_argument("--steps", type=int, default=20)
    parser.add_argument("--view", default="iso")
    given = parser.parse_args()
    results, rows = [], []
    with tempfile.TemporaryDirectory() as folder:
        for model in find_models(given.models):
            figures = measure(given, model, pathlib.Path(folder))
            results.append(kit.result("prefix", {"model": str(model), "size": given.size, "view": given.view}, figures))
            kit.say(f"{kit.name_of(model)}: largest fall {figures['largest_fall']:.4f}")
    for r in results:
        f, at = r["figures"], lambda part: r["figures"]["ssim"][max(0, round(part * given.steps) - 1)]
        rows.append([kit.name_of(r["params"]["model"]), f"{f['bytes'] / 1e6:.2f} MB", *(f"{at(p):.3f}" for p in (0.05, 0.1, 0.25, 0.5, 0.75, 0.95)),
                     f"{f['largest_fall']:.3f}"])
    kit.table(["model", "file", "5 %", "10 %", "25 %", "50 %", "75 %", "95 %", "largest fall"], rows)
    kit.keep("prefix", results, given.out)
    plot(results, given.images / "prefix-bytes.svg")


if __name__ == "__main__":
    main()
