// SPDX-License-Identifier: MIT
// The model for benchmarks of a single object.
#pragma once

#include "lab/bench/bench.h"
#include "scene/scene.h"

/// The requested model, or a generated ball with hills of 5,227,200 triangles (quick: 202,800), in
/// one mesh. @return NULL on failure, with the message printed; freed by stp_scene_destroy
stp_scene* measured_model_load(stp_context* context, const bench_options* options,
                               const char* benchmark_name);
