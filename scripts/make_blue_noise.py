#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Writes src/raster/blue_noise_table.h: a tileable 64 x 64 void-and-cluster mask (Ulichney 1993), ranks 0 to 4095.

Uses only integers, so the table is the same on every machine. Takes some seconds."""
import math
import os
import random

SIDE = 64
REACH = 9          # cut-off radius of the filter
SIGMA = 1.9
ONE = 1 << 24


def make_filter():
    weights = []
    for y in range(-REACH, REACH + 1):
        for x in range(-REACH, REACH + 1):
            weights.append((x, y, round(ONE * math.exp(-(x * x + y * y) / (2 * SIGMA * SIGMA)))))
    return weights


class Pattern:
    """Points on a torus and the sum of their filters."""

    def __init__(self, weights):
        self.weights = weights
        self.there = [False] * (SIDE * SIDE)
        self.energy = [0] * (SIDE * SIDE)

    def change(self, place, sign):
        self.there[place] = sign > 0
        px, py = place % SIDE, place // SIDE
        for x, y, weight in self.weights:
            self.energy[(py + y) % SIDE * SIDE + (px + x) % SIDE] += sign * weight

    def tightest_cluster(self):
        return max((i for i in range(SIDE * SIDE) if self.there[i]), key=lambda i: (self.energy[i], -i))

    def largest_void(self):
        return min((i for i in range(SIDE * SIDE) if not self.there[i]), key=lambda i: (self.energy[i], i))


def make_mask():
    weights = make_filter()
    start = Pattern(weights)
    generator = random.Random(20261123)
    for place in generator.sample(range(SIDE * SIDE), SIDE * SIDE // 10):
        start.change(place, 1)
    while True:
        cluster = start.tightest_cluster()
        start.change(cluster, -1)
        void = start.largest_void()
        start.change(void, 1)
        if void == cluster:
            break
    ranks = [0] * (SIDE * SIDE)
    count = sum(start.there)
    fewer = Pattern(weights)
    for place in range(SIDE * SIDE):
        if start.there[place]:
            fewer.change(place, 1)
    for rank in range(count - 1, -1, -1):
        place = fewer.tightest_cluster()
        fewer.change(place, -1)
        ranks[place] = rank
    for rank in range(count, SIDE * SIDE):
        place = start.largest_void()
        start.change(place, 1)
        ranks[place] = rank
    return ranks


def main():
    ranks = make_mask()
    path = os.path.join(os.path.dirname(os.path.dirname(os.path.abspath(__file__))), "src/raster/blue_noise_table.h")
    with open(path, "w") as out:
        out.write("// SPDX-License-Identifier: MIT\n")
        out.write("// Written by scripts/make_blue_noise.py. Do not edit.\n#pragma once\n\n#include <stdint.h>\n\n")
        out.write("// clang-format off\n")
        out.write("static const uint16_t blue_noise_ranks[%d] = {\n" % (SIDE * SIDE))
        for first in range(0, SIDE * SIDE, 16):
            out.write("    " + ", ".join("%4d" % rank for rank in ranks[first:first + 16]) + ",\n")
        out.write("};\n// clang-format on\n")


if __name__ == "__main__":
    main()
