// SPDX-License-Identifier: MIT
//
// Plans of the industrial parts of `paper`, and the small scenes made from each.
#pragma once

#include "lab/scenes/assembly.h"

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
