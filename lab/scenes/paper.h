// SPDX-License-Identifier: MIT
// The benchmark scene of Brandt et al. 2019, section 5.1, and its parts.
#pragma once

#include "lab/scenes/assembly.h"
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

stp_result scene_make_paper(stp_scene* scene, const scene_options* options);
stp_result scene_make_paper_huge(stp_scene* scene, const scene_options* options);

// Plans of the industrial parts of `paper`, and the small scenes made from each.

/// The counts in Table 1 of Brandt et al. 2019.
extern const plan_counts power_plants_counts, bakery_counts, car_factory_counts;

// A whole part, not yet fitted. Call plan_begin first.
void plan_power_plants(assembly_plan* plan);
void plan_bakery(assembly_plan* plan);
void plan_car_factory(assembly_plan* plan);
/// A single line.
void plan_bakery_line(assembly_plan* plan);
/// A single plant, without the modules in which the sixteen differ.
void plan_power_plant(assembly_plan* plan);
/// Two plants that use no part twice.
void plan_twenty_million(assembly_plan* plan);

stp_result scene_make_power_plant(stp_scene* scene, const scene_options* options);
stp_result scene_make_twenty_million(stp_scene* scene, const scene_options* options);
stp_result scene_make_car_factory(stp_scene* scene, const scene_options* options);
stp_result scene_make_bakery_line(stp_scene* scene, const scene_options* options);

// Power lines across the terrain. The totals in Table 1 of Brandt et al. 2019 exceed the sum of its
// rows by 305 objects, one unique mesh and some 60,000 unique triangles: here, the pylons account
// for those.

STP_MUST_USE stp_result scene_add_pylons(stp_scene* scene, uint32_t parent,
                                         const scene_options* options);
/// Makes one lattice tower, 42 m tall (a mesh_maker without parameters).
struct mesh_builder;
void pylon_make(struct mesh_builder* builder, const void* parameters);
