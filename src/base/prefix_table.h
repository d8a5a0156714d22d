// SPDX-License-Identifier: MIT
// How long a prefix of an order must be to cover to a given radius; the radius is guaranteed.
#pragma once

#include "base/splat_columns.h"

/// Builds a table from the insertion radii of a whole order: radii[k] is the distance of point k to
/// the nearest earlier one (radii[0] is ignored), so the prefix of k points covers to
/// max(radii[k..]). `final_radius`: radius to which the whole order covers (0 if it holds all
/// candidates).
void stp_prefix_table_make(stp_prefix_table* table, const float* radii, uint32_t count,
                           float final_radius);

/// Shortest prefix known to cover to `radius`; the whole count if none is.
uint32_t stp_prefix_table_count(const stp_prefix_table* table, float radius);

/// Radius to which the first `count` points are known to cover.
float stp_prefix_table_radius(const stp_prefix_table* table, uint32_t count);
