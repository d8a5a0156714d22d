// SPDX-License-Identifier: MIT
// Shared by benchmarks: memory speed of the machine and of the GPU, and the model of a single object.
#pragma once

#include "lab/bench/bench.h"
#include "program/options/command.h"
#include "program/present/headless.h"
#include "scene/scene.h"

#include <stdint.h>

// Memory speed of this machine, for comparison with other rates: copies, and random pixel updates.

/// All zero at first.
typedef struct memory_speed {
    stp_context* context;
    uint8_t* from;
    uint8_t* to;
    uint32_t* places; ///< random indices of pixels
    uint64_t* pixels; ///< a picture for each thread
    uint32_t pixel_count, threads;
} memory_speed;

/// Allocates buffers larger than all caches, and pictures of `pixel_count` pixels. @return false if
/// memory runs out
bool memory_speed_create(stp_context* context, uint32_t pixel_count, memory_speed* memory);
void memory_speed_destroy(memory_speed* memory);

/// Bytes per second that all threads together copy, counting reads and writes.
double memory_speed_copy(memory_speed* memory);
/// Pixels (8 bytes each) per second that all threads together compare and replace at random
/// positions of their own pictures.
double memory_speed_update(memory_speed* memory);

// GPU memory copy speed, for comparison with drawing.

/// Bytes per second that the device copies within its memory, counting reads and writes. 0: not
/// measurable.
double gl_measure_copy(const stp_headless* headless, uint64_t size);

// The model for benchmarks of a single object.

/// The requested model, or a generated ball with hills of 5,227,200 triangles (quick: 202,800), in
/// one mesh. @return NULL on failure, with the message printed; freed by stp_scene_destroy
stp_scene* measured_model_load(stp_context* context, const bench_options* options,
                               const char* benchmark_name);
