// SPDX-License-Identifier: MIT
//
// Some positions of a file, of which one chooses the origin of all: floats relative to it keep their
// digits where most points are, and a few points far away do not matter.
#pragma once

#include <stddef.h>
#include <stdint.h>

enum { STP_PLACE_SAMPLES = 65 };

/// Zeroed at first.
typedef struct stp_place_sample {
    double places[3][STP_PLACE_SAMPLES];
    uint32_t count;
} stp_place_sample;

/// Adds a position. Those that are not finite are ignored, and so are more than STP_PLACE_SAMPLES.
void stp_place_sample_add(stp_place_sample* sample, const double place[3]);

/// A distance in which floats keep hundredths.
#define STP_PLACE_NEAR 65536.0

/// On each axis the first position, unless the median is STP_PLACE_NEAR away; then the median. Zero
/// without positions. Reorders the sample.
void stp_place_sample_choose(stp_place_sample* sample, double place[3]);

/// Index of sample `i` below STP_PLACE_SAMPLES among `count` elements, spread evenly.
static inline size_t stp_place_sample_index(uint32_t i, size_t count)
{
    return count / STP_PLACE_SAMPLES * i + count % STP_PLACE_SAMPLES * i / STP_PLACE_SAMPLES;
}
