#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Prints the colour map of src/base/math/color.c: a curve in Oklab with evenly rising lightness.

Lightness rises from 0.27 to 0.94. The hue turns from violet over blue and green to yellow. The
chroma is 0.145, or less where sRGB requires it. So equal steps in value look equal (Ottosson 2020,
"A perceptual color space for image processing").
"""
import math

LIGHT = (0.27, 0.94)
HUE = (312.0, 104.0)  # degrees
CHROMA = (0.115, 0.165)


def to_linear(lightness, a, b):
    l = (lightness + 0.3963377774 * a + 0.2158037573 * b) ** 3
    m = (lightness - 0.1055613458 * a - 0.0638541728 * b) ** 3
    s = (lightness - 0.0894841775 * a - 1.2914855480 * b) ** 3
    return (
        4.0767416621 * l - 3.3077115913 * m + 0.2309699292 * s,
        -1.2684380046 * l + 2.6097574011 * m - 0.3413193965 * s,
        -0.0041960863 * l - 0.7034186147 * m + 1.7076147010 * s,
    )


def to_srgb(linear):
    value = 12.92 * linear if linear <= 0.0031308 else 1.055 * linear ** (1 / 2.4) - 0.055
    return max(0, min(255, int(value * 255 + 0.5)))


def color(t):
    lightness = LIGHT[0] + (LIGHT[1] - LIGHT[0]) * t
    hue = math.radians(HUE[0] + (HUE[1] - HUE[0]) * t)
    chroma = CHROMA[0] + (CHROMA[1] - CHROMA[0]) * t
    while True:  # reduce the chroma until the colour fits sRGB
        linear = to_linear(lightness, chroma * math.cos(hue), chroma * math.sin(hue))
        if all(-1e-4 <= c <= 1.0001 for c in linear) or chroma < 0.001:
            return [to_srgb(min(max(c, 0.0), 1.0)) for c in linear]
        chroma -= 0.001


def main():
    row = []
    for i in range(256):
        row.append("{%d, %d, %d}" % tuple(color(i / 255)))
        if len(row) == 6 or i == 255:
            print("    " + ", ".join(row) + ",")
            row = []


if __name__ == "__main__":
    main()
