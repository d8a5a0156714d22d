#!/usr/bin/env python3
"""The table of goals: each goal with the newest result of its kind in bench/results.

usage: bench/goals.py [--results FOLDER] [--document FILE.md --tables FOLDER]

--document replaces tables between `<!-- measured: NAME -->` and `<!-- end -->` in that file by
FOLDER/NAME.md if it exists, and the table named "goals" by this one.
"""
import argparse
import json
import pathlib
import re

import kit

MARKED = re.compile(r"(<!-- measured: ([a-z0-9-]+) -->\n).*?(<!-- end -->)", re.S)
NAMED = re.compile(r"(\d{4}-\d\d-\d\d)-(.+)\.json")


class Results:
    """The newest results of each name."""

    def __init__(self, folder):
        self.files = {}
        for path in sorted(folder.rglob("*.json"), key=lambda p: p.name):
            named = NAMED.fullmatch(path.name)
            self.files[named[2] if named else path.stem] = (named[1] if named else "", path)

    def of(self, name):
        """A list of {params, figures}; empty if there are no results of that name."""
        if name not in self.files:
            return []
        return json.loads(self.files[name][1].read_text(encoding="utf-8"))["results"]

    def day(self, name):
        return self.files.get(name, ("", None))[0]


def within(value, limit):
    """Whether a goal was reached, as "yes" or "no"."""
    return "yes" if value <= limit else "no"


def flight(results):
    for r in results.of("controllers"):
        if r["params"]["controller"] == "predict":
            f = r["figures"]
            yield f"{f['frame_ms_p50']:.0f} ms, {f['frame_ms_p99']:.0f} ms", within(max(f["frame_ms_p50"] / 33, f["frame_ms_p99"] / 50), 1)


def views(results):
    ours = [r["figures"]["frame_ms"] for r in results.of("budget-views") if r["params"]["policy"] == "ours"]
    if ours:
        yield f"{max(ours):.0f} ms", within(max(ours), 66)


def likeness_in_time(results):
    pairs = {}
    for r in results.of("budget-views"):
        pairs.setdefault(r["params"]["view"], {})[r["params"]["policy"]] = r["figures"]["ssim_covered"]
    gains = [p["ours"] - max(v for k, v in p.items() if k != "ours") for p in pairs.values() if "ours" in p and len(p) > 1]
    if gains:
        yield f"higher in {sum(g >= 0 for g in gains)} of {len(gains)} views, least {min(gains):+.3f}", within(-min(gains), 0)


def attainable(results):
    for r in results.of("controllers-auto"):
        if r["params"]["controller"] == "predict":
            f = r["figures"]
            yield (f"{100 * f['within_1_1']:.1f} %, {100 * f['within_1_5']:.1f} % of {r['params']['budget_ms']:.0f} ms",
                   "yes" if f["within_1_1"] >= 0.95 and f["within_1_5"] >= 0.99 else "no")


def growth(results):
    found = sorted((r["params"]["triangles"], r["figures"]) for r in results.of("growth"))
    if found and found[-1][0] > 1e11 and len(found) > 1:
        paper, huge = found[-2][1], found[-1][1]
        ratio = huge["frame_ms_p50"] / paper["frame_ms_p50"]
        yield f"{ratio:.2f} times", within(ratio, 1.2)


def splats(results):
    found = [r for r in results.of("splats") if r["params"]["size_px"] == 1 and r["figures"]["ratio"]]
    if found:
        ratios = [r["figures"]["ratio"] for r in found]
        yield " and ".join(f"{x:.1f}" for x in ratios) + " times with 1 and 2 threads", within(15, min(ratios))


def memory(results):
    found = [r["figures"] for r in results.of("splats") if r["params"]["size_px"] == 1 and "part_of_copy" in r["figures"]]
    if found:
        f = found[-1]
        yield f"{100 * f['part_of_copy']:.0f} % of the rate of copying, {f['part_of_random_pixels']:.2f} of the rate of random pixels", ""


def popping(results, key):
    found = {r["params"]["policy"]: r["figures"] for r in results.of("popping")}
    if len(found) >= 2 and "switch" in found and "insertion" in found:
        ratio = found["insertion"][key] / max(1e-9, found["switch"][key])
        yield f"{ratio:.2f} times", within(ratio, 0.25)


def extra(results):
    for r in results.of("popping"):
        if r["params"]["policy"] == "insertion":
            yield f"{100 * r['figures']['extra_part']:.1f} %", within(r["figures"]["extra_part"], 0.1)


def fine(results):
    found = [r["figures"] for r in results.of("quality-views") if "fine_ours" in r["figures"]]
    if found:
        rest, higher = (sum(f.get(key, 0) > f["fine_originals"] for f in found) for key in ("fine_rest", "fine_ours"))
        yield f"at rest in {rest} of {len(found)} views, in one frame in {higher}", within(len(found), rest)


def equal_splats(results, name):
    pairs = [e for r in results.of(name) for k, e in r["figures"].items() if k.startswith("equal_") and "ours" in e]
    if pairs:
        lower = sum(e["ours"] < e["paper"] for e in pairs)
        yield f"lower in {lower} of {len(pairs)} cases", within(lower, 0)


def all_views(results):
    covered = [r["figures"]["ssim_covered"] for r in results.of("quality-views")]
    if covered:
        yield f"median {kit.rank(covered, 0.5):.3f}, least {min(covered):.3f} of {len(covered)} views", ""


def table3(results):
    import table3 as paper # its figures
    gains = [r["figures"]["ssim"] - paper.PAPER[r["params"]["view"]][r["params"]["column"]][4] for r in results.of("table3-size-2")
             if "ssim" in r["figures"] and paper.PAPER[r["params"]["view"]][r["params"]["column"]][4] is not None]
    if gains:
        yield f"higher in {sum(g >= -0.005 for g in gains)} of {len(gains)}, least {min(gains):+.2f}", ""


def everywhere(results):
    for r in results.of("positions"):
        if r["params"]["place"] == "Overview":
            f = r["figures"]
            yield f"median {f['p50']:.0f} ms, 99 % {f['p99']:.0f} ms at splat size {r['params']['splat_size']:g}", ""


def triangles(results):
    found = [r["figures"]["cpu_per_second"] for r in results.of("triangles") if r["params"]["size_px"] == 1 and r["params"]["threads"] == 1]
    if found:
        yield f"{kit.short(found[0])} a second", within(30e6, found[0])


def order(results, key, limit):
    found = [r["figures"][key] for r in results.of("order") if key in r["figures"] and r["params"]["threads"] == 1 and r["params"]["surfels"] == 100000]
    if found:
        yield f"{found[0]:.2f}", within(found[0], limit)


GOALS = (
    ("flight through all five places, budget 33 ms", "median 33 ms, 99 % 50 ms", flight, "controllers", "bench/controllers.py"),
    ("slowest of the five views, budget 33 ms", "66 ms", views, "budget-views", "bench/budget_views.py"),
    ("covered SSIM in that time, against the paper's policy and the better of its orders", "not lower", likeness_in_time, "budget-views", "bench/budget_views.py"),
    ("frames within 1.1 and 1.5 times a budget that size 8 can hold", "95 %, 99 %", attainable, "controllers-auto", "bench/controllers.py --budget-ms auto"),
    ("median frame of a trillion triangles, against 2.35 G", "1.2 times", growth, "growth", "bench/growth.py"),
    ("frames 200 m above the whole scene", "", everywhere, "positions", "bench/positions.py"),
    ("SSIM in Table 3 against the paper's, splat size 2", "", table3, "table3-size-2", "bench/table3.py"),
    ("covered SSIM at splat size 1, every named view", "", all_views, "quality-views", "bench/quality.py views"),
    ("the same with equal splats, against the paper's policy and `paper-fast`", "never lower", lambda r: equal_splats(r, "quality-views"),
     "quality-views", "bench/quality.py views"),
    ("the same with equal splats, against the paper's policy and `paper-text`", "never lower", lambda r: equal_splats(r, "quality-views-text"),
     "quality-views-text", "bench/quality.py views --paper-order paper-text"),
    ("closer to a supersampled picture than the originals at one sample", "always", fine, "quality-views", "bench/quality.py views"),
    ("popping with blending against hard switching, 99.9 %", "0.25 times", lambda r: popping(r, "popping_p999"), "popping", "bench/popping.py"),
    ("the same, worst block", "0.25 times", lambda r: popping(r, "popping_max"), "popping", "bench/popping.py"),
    ("extra splats while levels blend", "10 %", extra, "popping", "bench/popping.py"),
    ("one-pixel splats a second, against points of llvmpipe", "15 times", splats, "splats", "stipple-lab bench splats"),
    ("their memory traffic, against the speed of memory", "", memory, "splats", "stipple-lab bench splats"),
    ("one-pixel triangles a second, one thread", "30 M", triangles, "triangles", "stipple-lab bench triangles"),
    ("time of the exact order of 100k, against `paper-text`", "0.45", lambda r: order(r, "ratio_to_paper_text", 0.45), "order", "stipple-lab bench order"),
    ("time of the exact order of 100k, against `paper-fast`", "1.1", lambda r: order(r, "ratio_to_paper_fast", 1.1), "order", "stipple-lab bench order"),
)


def goals_table(results):
    lines = ["| what | goal | measured | reached | command | date |", "|---|---|---|---|---|---|"]
    for what, goal, measure, name, command in GOALS:
        measured, reached = next(iter(measure(results)), ("not measured", ""))
        reached = f"**{reached}**" if reached == "no" else reached
        lines.append(f"| {what} | {goal} | {measured} | {reached} | `{command}` | {results.day(name)} |")
    return "\n".join(lines) + "\n"


def pages():
    """The documents with marked tables: the page on performance, and notes."""
    return [kit.ROOT / "docs/performance.md", *sorted((kit.ROOT / "docs/notes").glob("*.md"))]


def fill(document, tables, goals):
    """Replaces marked tables of a document by measured ones; writes it only if it changed. @return their names"""
    replaced = []

    def new(match):
        name = match[2]
        path = tables / f"{name}.md"
        if name != "goals" and not (path.exists() and (tables / f"{name}.done").exists()):
            return match[0]
        replaced.append(name)
        return match[1] + (goals if name == "goals" else path.read_text(encoding="utf-8").strip() + "\n") + match[3]

    text = document.read_text(encoding="utf-8")
    filled = MARKED.sub(new, text)
    if filled != text:
        kit.write_whole(document, filled)
    return replaced


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--results", type=pathlib.Path, default=kit.path_of("x").parent, metavar="FOLDER", help="default: this machine's of bench/results")
    parser.add_argument("--document", type=pathlib.Path, metavar="FILE.md")
    parser.add_argument("--tables", type=pathlib.Path, default=kit.ROOT / "build/proof", metavar="FOLDER", help="default build/proof")
    given = parser.parse_args()
    table = goals_table(Results(given.results))
    print(table, end="")
    if given.document is not None:
        kit.say(f"{given.document}: {', '.join(fill(given.document, given.tables, table))}")


if __name__ == "__main__":
    main()
