// SPDX-License-Identifier: MIT
//
// Light normals: for each entry of the colour pyramid, the mean of the unit normals of the surface
// that a splat stands for as that octave draws it. Its direction lights the splat, its length (1
// where all normals agree) tells how far they are spread. Entries are relative to the splat's own
// normal, so zeros mean that normal, and octaves of nothing else have no entries.
#pragma once

#include "base/splats/octahedral.h"
#include "base/splats/splat_columns.h"

#include <assert.h>

/// Turns are multiples of this many steps of a code, about 3 degrees; spreads have at most two
/// significant bits up to 64, then multiples of 16. Finer ones cannot be seen, and compress worse.
enum { STP_TURN_STEP = 4, STP_SPREAD_STEP = 16 };

/// Light normals of one octave.
typedef struct stp_light_normals {
    const int8_t* turns;    ///< NULL: the splats' own normals
    const uint8_t* spreads; ///< as turns
} stp_light_normals;

static inline bool stp_has_light_normals(const stp_splats* splats, uint32_t octave)
{
    return (splats->light_octaves >> octave & 1u) != 0;
}

/// Number of entries before octave `octave`, or of all octaves if it is the octave count.
static inline uint64_t stp_light_normals_begin(const stp_splats* splats, uint32_t octave)
{
    uint64_t entries = 0;
    assert(octave <= splats->octave_count);
    for (uint32_t i = 0; i < octave; ++i) {
        entries += stp_has_light_normals(splats, i) ? splats->octave_ends[i] : 0;
    }
    return entries;
}

/// The octave's entries, of splat 0 first.
static inline stp_light_normals stp_light_normals_of(const stp_splats* splats, uint32_t octave)
{
    stp_light_normals found = {0};
    if (stp_has_light_normals(splats, octave)) {
        size_t first = (size_t)stp_light_normals_begin(splats, octave);
        found.turns = splats->turns + 2 * first;
        found.spreads = splats->spreads + first;
    }
    return found;
}

/// The light normal of a splat, of length 0 to 1. @param own code of the splat's normal
static inline stp_vec3 stp_light_normal(const stp_light_normals* of, const int8_t own[2],
                                        size_t splat)
{
    if (of->turns == NULL) {
        return stp_octahedral_decode(own[0], own[1]);
    }
    const int8_t* turn = of->turns + 2 * splat;
    int8_t code[2]; // differences of codes, modulo 256
    for (int k = 0; k < 2; ++k) {
        code[k] = (int8_t)(uint8_t)((uint8_t)own[k] + (uint8_t)turn[k]);
    }
    float length = 1.0f - (float)of->spreads[splat] * (1.0f / 255.0f);
    return stp_scale(stp_octahedral_decode(code[0], code[1]), length);
}

/// A turn to another code, rounded; the code that it leads to stays valid.
static inline int8_t stp_light_turn(int8_t own, int8_t code)
{
    int turn = code - own, low = (turn + STP_TURN_STEP / 2) & ~(STP_TURN_STEP - 1);
    low = own + low > 127 ? low - STP_TURN_STEP : own + low < -127 ? low + STP_TURN_STEP : low;
    return (int8_t)(uint8_t)low; // modulo 256
}

static inline uint8_t stp_light_spread(float length)
{
    int spread = (int)((1.0f - length) * 255.0f + 0.5f), step = 1;
    while (4 * step <= spread && step < STP_SPREAD_STEP) {
        step *= 2;
    }
    int rounded = spread <= 1 ? 0 : (spread + step / 2) / step * step;
    return (uint8_t)(rounded < 255 ? rounded : 255);
}

/// @param mean of unit normals; of length 0, it has the direction of `own`
static inline void stp_light_normal_encode(stp_vec3 mean, const int8_t own[2], int8_t turn[2],
                                           uint8_t* spread)
{
    float length = stp_min(stp_length(mean), 1.0f);
    int8_t code[2] = {own[0], own[1]};
    if (length > 0.0f) {
        stp_octahedral_encode(mean, code);
    }
    for (int k = 0; k < 2; ++k) {
        turn[k] = stp_light_turn(own[k], code[k]);
    }
    *spread = stp_light_spread(length);
}
