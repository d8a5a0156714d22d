#!/usr/bin/env python3
"""Prints the values that tests/measure/test_image_compare.c expects, computed with scikit-image and SciPy.

Needs python3-skimage. The pictures follow from integer formulas, which the test repeats in C."""
import math

import numpy
import scipy.ndimage
import skimage.metrics

WIDTH, HEIGHT = 203, 171
WEIGHTS = [0.0448, 0.2856, 0.3001, 0.2363, 0.1333]


def mix(value):
    value = (value * 2654435761) % 2**32
    value ^= value >> 15
    value = (value * 2246822519) % 2**32
    return value ^ value >> 13


def picture(is_second):
    """Rows of (r, g, b, a): waves and a checkerboard; the second picture has noise, a shift and other alphas."""
    rows = []
    for y in range(HEIGHT):
        row = []
        for x in range(WIDTH):
            shift = 1 if is_second and x > 120 else 0
            u, v = x + shift, y
            red = (u * u // 40 + v * 3) % 256
            green = 40 + 170 * ((u // 9 + v // 7) % 2)
            blue = abs((u * 5 + v * 2) % 510 - 255)
            noise = mix(y * WIDTH + x) % 41 - 20 if is_second else 0
            alpha = 0 if (x - 60) ** 2 + (y - 90) ** 2 < 900 else 255
            if is_second and (x - 64) ** 2 + (y - 90) ** 2 < 1100:
                alpha = 128
            row.append(tuple(min(255, max(0, c + noise)) for c in (red, green, blue)) + (alpha,))
        rows.append(row)
    return numpy.array(rows, dtype=numpy.int64)


def over_black(pixels):
    return (pixels[..., :3] * pixels[..., 3:] + 127) // 255


def blur(plane):
    return scipy.ndimage.gaussian_filter(plane, 1.5, truncate=3.5, mode="reflect")


def contrast_structure(a, b):
    """Mean over whole windows of (2 cov + C2) / (va + vb + C2)."""
    c2 = (0.03 * 255) ** 2
    ma, mb = blur(a), blur(b)
    va, vb, cov = blur(a * a) - ma * ma, blur(b * b) - mb * mb, blur(a * b) - ma * mb
    return ((2 * cov + c2) / (va + vb + c2))[5:-5, 5:-5].mean()


def ssim(a, b):
    return skimage.metrics.structural_similarity(a, b, data_range=255, gaussian_weights=True, sigma=1.5,
                                                 use_sample_covariance=False, K1=0.01, K2=0.03)


def halve(plane):
    height, width = plane.shape
    padded = numpy.pad(plane, ((0, height % 2), (0, width % 2)), mode="symmetric")
    return (padded[::2, ::2] + padded[::2, 1::2] + padded[1::2, ::2] + padded[1::2, 1::2]) / 4


color_a, color_b = over_black(picture(False)), over_black(picture(True))
grey_a, grey_b = (c @ numpy.array([299, 587, 114]) / 1000 for c in (color_a, color_b))
print(f"ssim    {ssim(grey_a, grey_b):.15f}")
print(f"psnr    {skimage.metrics.peak_signal_noise_ratio(color_a, color_b, data_range=255):.12f}")
multi_scale, a, b = 1.0, grey_a, grey_b
for i, weight in enumerate(WEIGHTS):
    multi_scale *= (contrast_structure(a, b) if i < 4 else ssim(a, b)) ** weight
    a, b = halve(a), halve(b)
print(f"ms_ssim {multi_scale:.15f}")
