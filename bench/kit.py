"""Shared by the benchmark scripts: running stipple, tables, result files, and SVG drawings."""
import argparse
import datetime
import json
import math
import os
import pathlib
import re
import subprocess
import sys

ROOT = pathlib.Path(__file__).resolve().parent.parent
STIPPLE = pathlib.Path(os.environ.get("STIPPLE", ROOT / "build/release/lab/stipple-lab")).absolute()
COLORS = ("#4c72b0", "#dd8452", "#55a868", "#8172b3", "#c44e52", "#937860", "#64b5cd")


def options(doc, size="1920x1080"):
    """A parser with the options of all scripts."""
    parser = argparse.ArgumentParser(description=doc, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--size", default=size, metavar="WxH", help=f"of pictures; default {size}")
    parser.add_argument("--threads", type=int, default=0, help="default: all")
    parser.add_argument("--out", metavar="FILE.json", help="output file of the results; default bench/results/MACHINE/DATE-NAME.json")
    parser.add_argument("--references", metavar="FOLDER", type=pathlib.Path, default=ROOT / "build/references",
                        help="cache of pictures without LOD; default build/references")
    parser.add_argument("--images", metavar="FOLDER", type=pathlib.Path, default=ROOT / "docs/images", help="default docs/images")
    return parser


def stipple(*arguments, threads=0):
    """Runs a command with --json and returns its output. Uses the CPU backend unless specified."""
    draws = arguments[0] in ("render", "fly") and "--backend" not in arguments
    call = [str(STIPPLE), *map(str, arguments), "--json", "--quiet", *(["--backend", "cpu"] if draws else []),
            *(["--color", "rgb"] if arguments[0] in ("render", "fly") and "--color" not in arguments else []),
            *(["--threads", str(threads)] if threads else [])]
    done = subprocess.run(call, capture_output=True, text=True)
    if done.returncode != 0:
        sys.exit(f"{' '.join(call)}: {done.stderr.strip() or done.returncode}")
    return json.loads(done.stdout)


def processor_seconds():
    """CPU time of all commands so far, including all threads, reading and writing: hardly affected by other load."""
    times = os.times()
    return times.children_user + times.children_system


def timed(*arguments, threads=0):
    """Like `stipple`, plus `processor_seconds` of the command."""
    before = processor_seconds()
    figures = stipple(*arguments, threads=threads)
    return {**figures, "processor_seconds": round(processor_seconds() - before, 3)}


def bench(name, *arguments):
    """Runs a benchmark and returns its JSON object: machine and results."""
    call = [str(STIPPLE), "bench", name, *map(str, arguments), "--json"]
    done = subprocess.run(call, capture_output=True, text=True)
    if done.returncode != 0:
        sys.exit(f"{' '.join(call)}: {done.stderr.strip() or done.returncode}")
    return json.loads(done.stdout)


def compare(ours, truth):
    figures = stipple("compare", ours, truth)
    return {name: figures[name] for name in ("ssim", "ssim_covered", "psnr")}


def bytes_of(scene):
    """A file's size, which distinguishes scenes of the same name; None for a named scene."""
    path = pathlib.Path(scene)
    return path.stat().st_size if path.exists() else None


def reference(given, view, size, *more, stereo=False):
    """A view without LOD: its PNG and figures. Drawn unless it is cached in --references; delete the folder to redraw."""
    path = given.references / pathlib.Path(str(name_of(given.scene)).replace(":", "-")) / f"{size}{'-stereo' if stereo else ''}-{view}.png"
    figures_path, scene = path.with_suffix(".json"), {"name": name_of(given.scene), "bytes": bytes_of(given.scene), "options": list(map(str, more))}
    if path.exists() and figures_path.exists():
        kept = json.loads(figures_path.read_text(encoding="utf-8"))
        if kept.get("scene") == scene:
            return path, kept
    say(f"{path} ...")
    path.parent.mkdir(parents=True, exist_ok=True)
    unfinished = path.with_suffix(".unfinished.png")
    try:
        figures = stipple("render", given.scene, "--view", view, "--size", size, "-o", unfinished, "--reference", "--once", *more,
                          *(["--stereo"] if stereo else []), threads=given.threads)
        unfinished.replace(path)
    finally:
        unfinished.unlink(missing_ok=True)
    figures["scene"] = scene
    write_whole(figures_path, json.dumps(figures, indent=1) + "\n")
    return path, figures


def processor():
    with open("/proc/cpuinfo", encoding="utf-8") as file:
        names = [line.split(":", 1)[1].strip() for line in file if line.startswith("model name")]
    return names[0] if names else "unknown"


def result(name, params, figures):
    return {"name": name, "params": params, "figures": figures}


def name_of(scene):
    """Display name of a scene: files without their folders."""
    return pathlib.Path(scene).name if "/" in str(scene) else str(scene)


def write_whole(path, text):
    """Writes a file atomically."""
    unfinished = path.with_name(f"{path.name}.{os.getpid()}")
    try:
        unfinished.write_text(text, encoding="utf-8")
        unfinished.replace(path)
    finally:
        unfinished.unlink(missing_ok=True)


def path_of(name, out=None):
    """Path of the results."""
    folder = re.sub(r"[^a-z0-9]+", "-", processor().lower()).strip("-")
    return pathlib.Path(out) if out else ROOT / f"bench/results/{folder}-{os.cpu_count()}/{datetime.date.today()}-{name}.json"


def keep(name, results, out=None, silent=False):
    """Writes results in the format of `stipple-lab bench --json`; files without their folders."""
    for r in results:
        r["params"] = {key: name_of(value) if isinstance(value, str) else value for key, value in r["params"].items()}
    path = path_of(name, out)
    path.parent.mkdir(parents=True, exist_ok=True)
    version = subprocess.run([STIPPLE, "--version"], capture_output=True, text=True).stdout.strip()
    machine = {"processor": processor(), "threads": os.cpu_count(), "version": version, "date": str(datetime.date.today())}
    text = json.dumps({"machine": machine, "results": results}, indent=1)
    text = re.sub(r"\[\s+([-+0-9.eE,\s]+?)\s+\]", lambda m: "[" + re.sub(r"\s+", " ", m[1]) + "]", text) # numbers on one line
    write_whole(path, text + "\n")
    if not silent:
        print(f"\n{path}", file=sys.stderr)


def read_results(path):
    """Results written by `keep`; empty if the file does not exist."""
    path = pathlib.Path(path)
    if not path.exists():
        say(f"{path}: does not exist; skipped")
    return json.loads(path.read_text(encoding="utf-8"))["results"] if path.exists() else []


def say(text):
    """Prints progress."""
    print(text, file=sys.stderr, flush=True)


def table(head, rows):
    """A table in Markdown."""
    print("| " + " | ".join(map(str, head)) + " |")
    print("|" + "---|" * len(head))
    for row in rows:
        print("| " + " | ".join(map(str, row)) + " |")


def short(value, digits=3):
    """A count in short form: 1.78 M."""
    for unit, letter in ((1e9, " G"), (1e6, " M"), (1e4, "")):
        if value >= unit and letter:
            return f"{value / unit:.{digits}g}{letter}"
    return f"{value:,.0f}"


def rank(values, part):
    """The smallest value that a fraction `part` does not exceed."""
    ordered = sorted(values)
    return ordered[max(0, math.ceil(part * len(ordered) - 1e-9) - 1)]


def round_up(value):
    """1, 2 or 5 times a power of ten, at least `value`."""
    power = 10.0 ** math.floor(math.log10(value))
    return next(step * power for step in (1, 2, 5, 10) if step * power >= value * (1 - 1e-9))


def round_axis(value):
    """A round number, at least `value`, whose quarter is also short."""
    power = 10.0 ** math.floor(math.log10(value))
    return next(step * power for step in (1, 1.2, 1.6, 2, 2.4, 3.2, 4, 6, 8, 10) if step * power >= value * (1 - 1e-9))


class Drawing:
    """An SVG on a white background."""

    def __init__(self, width, height):
        self.parts = [f'<svg xmlns="http://www.w3.org/2000/svg" width="{width}" height="{height}" '
                      f'viewBox="0 0 {width} {height}" font-family="sans-serif" font-size="12">\n'
                      f'<rect width="{width}" height="{height}" fill="#fff"/>\n']

    def put(self, text):
        self.parts.append(text + "\n")

    def text(self, x, y, words, anchor="start", more=""):
        words = str(words).replace("&", "&amp;").replace("<", "&lt;")
        self.put(f'<text x="{x:.1f}" y="{y:.1f}" text-anchor="{anchor}" {more}>{words}</text>')

    def line(self, points, color, width=1.0, more=""):
        places = "L".join(f"{x:.2f} {y:.2f}" for x, y in points)
        self.put(f'<path fill="none" stroke="{color}" stroke-width="{width}" {more} d="M{places}"/>')

    def shape(self, points, fill):
        places = "L".join(f"{x:.2f} {y:.2f}" for x, y in points)
        self.put(f'<path fill="{fill}" stroke="#444" stroke-width="0.7" d="M{places}Z"/>')

    def write(self, path):
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text("".join(self.parts) + "</svg>\n", encoding="utf-8")
        print(path, file=sys.stderr)
