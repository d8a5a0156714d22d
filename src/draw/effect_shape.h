// SPDX-License-Identifier: MIT
//
// Parameters of post-shading effects, shared by all backends: eye-dome lighting and ambient
// occlusion (explained in src/draw/cpu/effects.h).
#pragma once

#include "draw/draw.h"

enum {
    STP_EFFECT_PAIRS = 64,
    STP_EFFECT_NEAR_REACH = 16, ///< pixels: occlusion beyond this distance is read from blocks
};

#define STP_OCCLUSION_STRENGTH 2.2f ///< factor on the share of enclosed pairs
#define STP_OCCLUSION_MIN 0.15f     ///< lowest brightness, as a share
#define STP_EYE_DOME_MAX 1000.0f    ///< upper limit of stp_draw_style.eye_dome
#define STP_EYE_DOME_GAIN 0.22f     ///< factor on the mean rise, at strength 1

/// Two opposite neighbours at (x, y) and (-x, -y).
typedef struct stp_effect_pair {
    int32_t x, y;
    float numbers[3]; ///< 1 / distance, minimum rise, 1 / depth beyond which foreground is ignored
    bool far;         ///< read from blocks
} stp_effect_pair;

typedef struct stp_effect_shape {
    int32_t close;                           ///< radius for closing gaps between disks; 0: no disks
    int32_t light_step;                      ///< pixels between neighbours of eye-dome lighting
    float light;                             ///< factor on sums of rises; 0: no eye-dome lighting
    stp_effect_pair pairs[STP_EFFECT_PAIRS]; ///< samples of ambient occlusion; far ones last
    uint32_t pair_count;
    bool far; ///< some pairs are read from blocks
} stp_effect_shape;

/// @param splat_size size of splats drawn together with triangles; 0: none
stp_effect_shape stp_effect_shape_make(const stp_draw_style* style, uint32_t height,
                                       float splat_size);
