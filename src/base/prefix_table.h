// SPDX-License-Identifier: MIT
// How long a prefix of an order must be to cover to a given radius, with a guarantee.
#pragma once

#include <stipple/surfels.h>

/// Makes a table from the insertion radii of a whole order: radii[k] is the distance of point k to the
/// nearest earlier one (radii[0] is ignored), so the prefix of k points covers to max(radii[k..]).
/// `final_radius`: to what the whole order covers (0 where it holds all candidates).
void stp_prefix_table_make(stp_prefix_table* table, const float* radii, uint32_t count,
                           float final_radius);

/// The shortest prefix that is known to cover to `radius`; the whole count where none is.
uint32_t stp_prefix_table_count(const stp_prefix_table* table, float radius);

/// A radius to which the first `count` points are known to cover.
float stp_prefix_table_radius(const stp_prefix_table* table, uint32_t count);
