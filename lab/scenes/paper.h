// SPDX-License-Identifier: MIT
// The benchmark scene of Brandt et al. 2019, section 5.1, and its parts.
#pragma once

#include "lab/scenes/scenes.h"

/// A named view, "1".."5" as in Table 3.
typedef struct paper_view {
    const char* name;
    stp_vec3d eye, target;
    double fov_degrees;
    double table3_triangles; ///< "No LOD": minimum number in the frustum
} paper_view;

enum { PAPER_VIEWS = 5 };
extern const paper_view paper_views[PAPER_VIEWS];

/// Adds only the content below `parent` (which may be STP_NONE: each part becomes a root object).
STP_MUST_USE stp_result scene_add_paper(stp_scene* scene, uint32_t parent,
                                        const scene_options* options);

stp_result scene_make_paper(stp_scene* scene, const scene_options* options);
stp_result scene_make_paper_huge(stp_scene* scene, const scene_options* options);
