// SPDX-License-Identifier: MIT
//
// Plans of the industrial parts of `paper`, and the small scenes made of one of them each.
#pragma once

#include "scenes/assembly.h"

/// What Table 1 of Brandt et al. 2019 gives.
extern const plan_counts power_plants_counts, bakery_counts, car_factory_counts;

// A whole part, not fitted yet. The plan must have been begun.
void plan_power_plants(assembly_plan* plan);
void plan_bakery(assembly_plan* plan);
void plan_car_factory(assembly_plan* plan);
/// One line alone.
void plan_bakery_line(assembly_plan* plan);
/// One plant alone, without what the sixteen differ in.
void plan_power_plant(assembly_plan* plan);
/// Two plants in which no part is used twice.
void plan_twenty_million(assembly_plan* plan);

stp_result scene_make_power_plant(stp_scene* scene, const scene_options* options);
stp_result scene_make_twenty_million(stp_scene* scene, const scene_options* options);
stp_result scene_make_car_factory(stp_scene* scene, const scene_options* options);
stp_result scene_make_bakery_line(stp_scene* scene, const scene_options* options);
