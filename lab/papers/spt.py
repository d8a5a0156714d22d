#!/usr/bin/env python3
"""Point trees and their sequences on several models: points by distance and error, rejections per
test, and drawing time by recursion, as a sequence, and with culled groups, on the CPU or with
OpenGL. On the CPU also the sequence with split errors.

    lab/papers/spt.py [MODEL...] [--count N] [--backend cpu|gl] [--out FILE.json]

Default: models of Debian's assimp-testmodels. Runs `stipple-lab bench spt` on each, prints a table, and
saves the figures in bench/results.
"""
import argparse
import pathlib

import kit

TESTMODELS = pathlib.Path("/usr/share/assimp/models")
MODELS = ["glTF2/2CylinderEngine-glTF-Binary/2CylinderEngine.glb", "PLY/Wuson.ply", "OBJ/spider.obj", "PLY/pond.0.ply",
          "STL/sphereWithHole.stl"]
WAYS = {"traversal": "_gather_ms", "sequence": "_test_ms", "groups": "_test_ms"}  # and their overhead besides drawing


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("models", nargs="*", default=[str(TESTMODELS / name) for name in MODELS])
    parser.add_argument("--count", type=int, default=200000, help="points per model")
    parser.add_argument("--backend", choices=["cpu", "gl"], default="cpu", help="backend that draws")
    parser.add_argument("--out", metavar="FILE.json", help="output file of the figures; default bench/results/MACHINE/DATE-spt.json")
    options = parser.parse_args()
    kept, rows, drawn, directed = [], [], [], []
    for model in options.models:
        name = pathlib.Path(model).stem
        results = kit.bench("spt", "--model", model, "--count", options.count, "--backend", options.backend)["results"]
        build = next(r["figures"] for r in results if r["name"] == "spt build")
        for result in results:
            result["params"]["model"] = name
            kept.append(result)
            if result["name"] == "spt distance":
                f = result["figures"]
                rows.append([name, f"{build['points']:,.0f}", f"{result['params']['sizes_away']:g}", f"{f['unified']:,.0f}",
                             f"{f['split']:,.0f}", f"{f['qsplat']:,.0f}", f"{f['looked_at']:,.0f}", f"{f['selected']:,.0f}",
                             f"{f['rejected_percent']:.0f} %"])
                drawn.append([name, f"{result['params']['sizes_away']:g}", *(f"{f[way + '_draw_ms']:.2f} ms" for way in WAYS),
                              *(f"{100 * f[way + spent] / f[way + '_draw_ms']:.1f} %" for way, spent in WAYS.items()),
                              f"{f['drawn_by_sequence']:,.0f}", f"{f['drawn_by_groups']:,.0f}"])
                if "drawn_by_directed" in f:
                    directed.append([name, f"{result['params']['sizes_away']:g}", f"{f['split']:,.0f}", f"{f['drawn_by_directed']:,.0f}",
                                     f"{100 * f['split'] / f['unified']:.0f} %", f"{100 * f['drawn_by_directed'] / f['drawn_by_sequence']:.0f} %",
                                     f"{f['examined_by_directed']:,.0f}", f"{f['directed_test_ms']:.2f} ms", f"{f['directed_draw_ms']:.2f} ms"])
    kit.table(["model", "points", "sizes away", "unified", "split", "QSplat", "visited", "selected", "rejected"], rows)
    print()
    kit.table(["model", "sizes away", "traversal", "sequence", "with groups", "outside drawing", "the same", "with groups", "drawn",
               "with groups"], drawn)
    if directed:
        print("\nSplit errors:")
        kit.table(["model", "sizes away", "traversal", "sequence", "of unified", "of unified sequence", "visited", "test", "drawing"], directed)
    kit.keep("spt" if options.backend == "cpu" else "spt-gl", kept, options.out)


if __name__ == "__main__":
    main()
