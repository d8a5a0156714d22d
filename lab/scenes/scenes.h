// SPDX-License-Identifier: MIT
//
// Named procedural scenes for tests, benchmarks and the viewer. Seeded: the same name, scale and
// seed give the same scene, bit for bit. `paper` is the benchmark of Brandt et al. 2019, section
// 5.1, with the numbers of its Table 1.
#pragma once

#include "scene/scene.h"

typedef struct scene_options {
    double scale;  ///< amount of content (not its size): 1 is the whole; 1/16 for quick trials
    uint64_t seed; ///< default 0
} scene_options;

typedef struct scene_recipe {
    const char* name;
    const char* summary; ///< one line, as `stipple-lab scene --list` prints it
    stp_result (*make)(stp_scene* scene, const scene_options* options);
} scene_recipe;

/// All scenes; the last name is NULL.
const scene_recipe* scene_recipes(void);

/// Adds the scene: objects, meshes, materials, views. @return STP_OK, STP_ERROR_ARGUMENT (no such
/// scene; logged), STP_ERROR_OUT_OF_MEMORY, STP_ERROR_CANCELLED
STP_MUST_USE stp_result scene_make(stp_scene* scene, const char* name,
                                   const scene_options* options);

#define SCENES_VERSION "5" ///< increment when a scene changes: caches depend on it

/// The scene of that name; NULL if there is none.
const scene_recipe* scene_find(const char* name);

/// Adds the scene named by an input, "scene:paper,scale=0.1,seed=3" (the prefix is optional), for
/// stp_build_desc.generate. `user` is unused.
STP_MUST_USE stp_result scene_make_input(stp_scene* scene, const char* input, void* user);

// The parts of `paper`. Each adds one object below `parent` (its index through `object`), placed by
// `place`. The space of each has y up, metres, the ground at y = 0, and its content around the
// origin. `options->scale` scales the amounts of Table 1 listed here (objects; unique objects;
// triangles; unique triangles).

/// A factory of several halls with moderately complex machines, conveyors, robots and car bodies in
/// all states: 1,708; 179; 75.85 M; 3.97 M. View "3" of `paper` stands in it. Within about 300 m x
/// 200 m.
STP_MUST_USE stp_result scene_add_car_factory(stp_scene* scene, uint32_t parent,
                                              const stp_affine* place, const scene_options* options,
                                              uint32_t* object);
/// A hall with five identical CAD production lines of about 50 M triangles each: 7,237; 511; 267.80
/// M; 27.70 M. Within about 120 m x 60 m.
STP_MUST_USE stp_result scene_add_bakery(stp_scene* scene, uint32_t parent, const stp_affine* place,
                                         const scene_options* options, uint32_t* object);
/// Sixteen power plants in a 4 x 4 grid, about 12 M triangles each: 4,560; 304; 186.00 M; 12.40 M.
/// Table 1 fits sixteen plants of 285 objects: 283 shared by all, and 2 of a pool of 21. Within
/// about 900 m x 900 m.
STP_MUST_USE stp_result scene_add_power_plants(stp_scene* scene, uint32_t parent,
                                               const stp_affine* place,
                                               const scene_options* options, uint32_t* object);
/// A dense Roman city of 26,878 unique objects: 33,167; 26,878; 62.93 M; 40.35 M. Within about 800
/// m x 600 m.
STP_MUST_USE stp_result scene_add_city(stp_scene* scene, uint32_t parent, const stp_affine* place,
                                       const scene_options* options, uint32_t* object);
/// 260 tiles of 255 m with 4,914 triangles each, 30,000 trees of 6 kinds, 258 road segments:
/// 30,518; 524; 1.74 G; 1.73 M. Flat (y = 0) where the other parts stand.
STP_MUST_USE stp_result scene_add_terrain(stp_scene* scene, uint32_t parent,
                                          const stp_affine* place, const scene_options* options,
                                          uint32_t* object);
