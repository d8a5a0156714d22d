// SPDX-License-Identifier: MIT
// The part of a surface that a splat represents, as sums over its samples. Sums of two regions are
// added, so a merge needs no samples.
#pragma once

#include "lod/psp/ellipse.h"

/// A sample of a surface.
typedef struct stp_psp_sample {
    stp_vec3 position; ///< relative to a point near all samples
    stp_vec3 normal;   ///< unit normal, or zero if unknown
    uint8_t color[3];  ///< sRGB
    float area;        ///< surface area that it represents; above 0
} stp_psp_sample;

/// Sums over samples, weighted by area.
typedef struct stp_psp_region {
    double area, position[3], squares[6]; ///< squares: xx, xy, xz, yy, yz, zz
    double color_squares;
    float normal[3], color[3]; ///< colours from 0 to 1, before the weighting by area
} stp_psp_region;

stp_psp_region stp_psp_region_of(const stp_psp_sample* sample);
stp_psp_region stp_psp_region_add(const stp_psp_region* a, const stp_psp_region* b);
/// Turns the normals to the other side.
void stp_psp_region_turn(stp_psp_region* region);

/// The ellipse with the mean, the normal and the variances of a region. An elliptical region yields
/// itself.
/// @param fallback of unit length: normal to use if the samples' normals cancel out
stp_ellipse stp_psp_region_ellipse(const stp_psp_region* region, stp_vec3 fallback);

/// Difference between pictures of the ellipse and of the region, as an area. The sum of a quarter
/// of the ellipse's area, because outlines differ; half the area times the variance of normals;
/// four times the area times the variance of colours; twice the standard deviation from the plane
/// times the larger axis; and the part of the ellipse that the region does not fill.
double stp_psp_region_error(const stp_psp_region* region, const stp_ellipse* ellipse);
