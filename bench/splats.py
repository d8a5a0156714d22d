#!/usr/bin/env python3
"""Splats per second by size, compared with the same points through software OpenGL, and with memory
bandwidth.

usage: bench/splats.py [--quick]

Runs `stipple-lab bench splats`, which takes a minute.
"""
import kit


def rate(value):
    return "-" if value is None else f"{kit.short(value)}"


def rows_of(threads, results):
    named = f"{threads} thread{'s' if threads > 1 else ''}"
    figures = [r["figures"] for r in results if r["params"]["threads"] == threads]
    return [[named, *(rate(f["cpu_per_second"]) for f in figures)],
            [f"{(figures[0].get('gl') or 'OpenGL').split(' ')[0]}, {named}", *(rate(f["gl_per_second"]) for f in figures)],
            ["ratio", *("-" if f["ratio"] is None else f"{f['ratio']:.0f} x" for f in figures)],
            ["bytes, part of what copying moves", *(f"{f['part_of_copy']:.2f}" for f in figures)],
            ["pixels, part of those at random", *(f"{f['part_of_random_pixels']:.2f}" for f in figures)]]


def main():
    parser = kit.options(__doc__)
    parser.add_argument("--quick", action="store_true", help="300,000 splats, for a trial")
    given = parser.parse_args()
    results = kit.bench("splats", *(["--quick"] if given.quick else []))["results"]
    sizes = sorted({r["params"]["size_px"] for r in results})
    rows = [row for threads in sorted({r["params"]["threads"] for r in results}) for row in rows_of(threads, results)]
    kit.table(["a second", *(f"{size:g} px" for size in sizes)], rows)
    kit.keep("splats", results, given.out)


if __name__ == "__main__":
    main()
