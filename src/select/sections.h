// SPDX-License-Identifier: MIT
//
// Section planes (stp_view.sections). Selection culls everything beyond a plane, and lists for each
// item the planes that may cut it (stp_draw_item.sections). Backends test splat centres and
// triangle fragments against those planes only.
#pragma once

#include "base/math/math.h"

#include <stipple/view.h>

/// Whether counts and numbers are valid.
bool stp_sections_are_valid(const stp_sections* sections);

/// Appends a plane through `point` beyond which, along `normal`, everything is cut away. @return
/// false if there is no room, or the plane is invalid
bool stp_sections_add_plane(stp_sections* sections, stp_vec3d point, stp_vec3d normal);

/// Appends the six planes of a box; everything outside is cut away. The planes are moved outwards
/// by `rounding` (stp_bounds_rounding) and a millionth of the diagonal, so that faces in the sides
/// of the box stay whole.
bool stp_sections_add_box(stp_sections* sections, const stp_boxd* box, double rounding);

/// How far the planes of stp_sections_add_box lie outside the box.
double stp_sections_box_margin(const stp_boxd* box, double rounding);

/// Drops the planes that cut nothing off a box whose content may lie outside it by `rounding`: near
/// a plane, views draw less freely.
void stp_sections_drop_idle(stp_sections* sections, const stp_boxd* box, double rounding);

/// Bits of all planes.
static inline uint32_t stp_sections_all(const stp_sections* sections)
{
    return (1u << sections->count) - 1;
}

/// Distance of a point beyond the plane, times the length of the normal; above 0: cut away.
static inline double stp_section_beyond(const stp_section_plane* plane, stp_vec3d point)
{
    return stp_dotd(plane->normal, point) - plane->distance;
}

/// Whether a point is cut away.
bool stp_sections_exclude(const stp_sections* sections, stp_vec3d point);

/// Keeps the planes of `*mask` that may cut a box whose content extends beyond it by at most
/// `margin`. @return false if everything lies beyond one plane
bool stp_sections_test(const stp_sections* sections, const stp_boxd* box, double margin,
                       uint32_t* mask);

/// Transforms a plane into the source space of a transform: with x relative to `offset`, x is cut
/// away if row[0..2] . x + row[3] > 0.
void stp_section_row(const stp_section_plane* plane, const stp_affine* transform,
                     const float offset[3], double row[4]);
