// SPDX-License-Identifier: MIT
// Prefix length of an order for a guaranteed coverage radius.
#pragma once

#include "base/splats/splat_columns.h"

/// Builds a table from the insertion radii of an order: radii[k] is the distance of point k to the
/// nearest earlier one (radii[0] is ignored), so the coverage radius of the prefix of k points is
/// max(radii[k..]). `final_radius`: coverage radius of the whole order (0 if it holds all
/// candidates).
void stp_prefix_table_make(stp_prefix_table* table, const float* radii, uint32_t count,
                           float final_radius);

/// Shortest prefix whose coverage radius is at most `radius`; the whole count if there is none.
uint32_t stp_prefix_table_count(const stp_prefix_table* table, float radius);

/// Upper bound of the coverage radius of the first `count` points.
float stp_prefix_table_radius(const stp_prefix_table* table, uint32_t count);
