// SPDX-License-Identifier: MIT
// How fast memory is here, to hold other rates against: copying, and updates of pixels at random.
#pragma once

#include "command.h"

/// All zero at first.
typedef struct memory_speed {
    stp_context* context;
    uint8_t* from;
    uint8_t* to;
    uint32_t* places; ///< random, of pixels
    uint64_t* pixels; ///< a picture for each thread
    uint32_t pixel_count, threads;
} memory_speed;

/// Buffers that fit no cache, and pictures of `pixel_count` pixels. @return false where memory runs out
bool memory_speed_create(stp_context* context, uint32_t pixel_count, memory_speed* memory);
void memory_speed_destroy(memory_speed* memory);

/// Bytes a second, read and written both counted, that all threads together copy.
double memory_speed_copy(memory_speed* memory);
/// Pixels a second of 8 bytes each that all threads together compare and replace, each at random in its own picture.
double memory_speed_update(memory_speed* memory);
