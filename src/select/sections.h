// SPDX-License-Identifier: MIT
//
// Planes that cut a scene open (stp_view.sections). Selection leaves out what lies beyond one of them, and says of each
// item which planes may cut it (stp_draw_item.sections): backends test splats' centres and triangles' fragments against
// those, and nothing of items that lie wholly inside.
#pragma once

#include "base/math.h"

#include <stipple/view.h>

/// Whether counts and numbers can be used.
bool stp_sections_are_valid(const stp_sections* sections);

/// Appends a plane through `point` beyond which, along `normal`, everything is cut away. @return false where there is no
/// room or it is no plane
bool stp_sections_add_plane(stp_sections* sections, stp_vec3d point, stp_vec3d normal);

/// Appends the six planes of a box outside of which everything is cut away. They stand a millionth of its diagonal farther
/// out, so that faces in the sides of a scene's own box are whole.
bool stp_sections_add_box(stp_sections* sections, const stp_boxd* box);

/// Bits of all planes.
static inline uint32_t stp_sections_all(const stp_sections* sections)
{
    return (1u << sections->count) - 1;
}

/// How far beyond the plane a point lies, times the length of the normal; cut away where above 0.
static inline double stp_section_beyond(const stp_section_plane* plane, stp_vec3d point)
{
    return stp_dotd(plane->normal, point) - plane->distance;
}

/// Whether a point is cut away.
bool stp_sections_cut(const stp_sections* sections, stp_vec3d point);

/// Of the planes of `*mask`, leaves those that may cut a box whose content sticks out by at most `margin`. @return false
/// where all of it lies beyond one of them
bool stp_sections_test(const stp_sections* sections, const stp_boxd* box, double margin,
                       uint32_t* mask);

/// The plane in the space that a transform leads from: with coordinates minus `offset`, x is cut away where
/// row[0..2] . x + row[3] > 0.
void stp_section_row(const stp_section_plane* plane, const stp_affine* transform,
                     const float offset[3], double row[4]);
