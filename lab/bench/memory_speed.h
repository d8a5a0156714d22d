// SPDX-License-Identifier: MIT
// Memory speed of this machine, for comparison with other rates: copies, and random pixel updates.
#pragma once

#include "program/options/command.h"

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
