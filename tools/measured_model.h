// SPDX-License-Identifier: MIT
// The model that benchmarks of one object measure on.
#pragma once

#include "bench.h"

#include "scene/scene.h"

/// The model that was asked for, or a generated ball with hills of 5,227,200 triangles (quick: 202,800), in one mesh.
/// @return NULL where it fails, with the message printed; freed by stp_scene_destroy
stp_scene* measured_model_load(stp_context* context, const bench_options* options,
                               const char* benchmark_name);
