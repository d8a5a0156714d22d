// SPDX-License-Identifier: MIT
//
// What is done with a picture after shading, in numbers that all backends share: eye-dome lighting and ambient occlusion
// (src/draw/cpu/effects.h says how they work).
#pragma once

#include "draw/draw.h"

enum {
    STP_EFFECT_PAIRS = 64,
    STP_EFFECT_NEAR_REACH = 16, ///< pixels: occlusion from farther away is read from blocks
};

#define STP_OCCLUSION_STRENGTH 2.2f ///< what full enclosure takes away
#define STP_OCCLUSION_LEAST 0.15f   ///< how dark it may get
#define STP_EYE_DOME_MOST 1000.0f
#define STP_EYE_DOME_GAIN 0.22f ///< of mean rises, at strength 1

/// Two opposite neighbours at (x, y) and (-x, -y).
typedef struct stp_effect_pair {
    int32_t x, y;
    float numbers
        [3]; ///< 1 / distance, what a rise must exceed, 1 / depth from which on what is in front does not count
    bool far; ///< read from blocks
} stp_effect_pair;

typedef struct stp_effect_shape {
    int32_t close;      ///< reach of what closes gaps between disks; 0: there are none
    int32_t light_step; ///< pixels between neighbours of eye-dome lighting
    float light;        ///< strength times sums of rises; 0: none
    stp_effect_pair pairs[STP_EFFECT_PAIRS]; ///< of ambient occlusion
    uint32_t pair_count;
    bool far; ///< some pairs are read from blocks
} stp_effect_shape;

/// @param splat_size of splats that are drawn beside triangles, 0: there are none
stp_effect_shape stp_effect_shape_make(const stp_draw_style* style, uint32_t height,
                                       float splat_size);
