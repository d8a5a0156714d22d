// SPDX-License-Identifier: MIT
#include "base/splats/coverage.h"

#include <assert.h>

// Each is about an eighth more than the one before. The shaders have a copy
// (src/draw/shaders/lib_splat.glsl).
const uint8_t stp_coverage_shares[STP_COVERAGE_CHANCES] = {
    1,  2,  3,  4,  5,  6,  7,  8,  9,  10, 11, 12,  13,  15,  17,  19,  21,  23,  26, 29,
    32, 36, 40, 45, 50, 56, 63, 70, 78, 87, 97, 109, 122, 137, 153, 171, 191, 214, 240};

// Code with the nearest share.
const uint8_t stp_coverage_of_plain[256] = {
    0,  0,  1,  2,  3,  4,  5,   6,   7,   8,   9,   10,  11,  12,  12, 13, 13, 14, 14, 15, 15, 16,
    16, 17, 17, 18, 18, 18, 19,  19,  19,  20,  20,  20,  20,  21,  21, 21, 21, 22, 22, 22, 22, 23,
    23, 23, 23, 23, 24, 24, 24,  24,  24,  24,  25,  25,  25,  25,  25, 25, 26, 26, 26, 26, 26, 26,
    26, 27, 27, 27, 27, 27, 27,  27,  27,  28,  28,  28,  28,  28,  28, 28, 28, 29, 29, 29, 29, 29,
    29, 29, 29, 29, 29, 30, 30,  30,  30,  30,  30,  30,  30,  30,  30, 30, 31, 31, 31, 31, 31, 31,
    31, 31, 31, 31, 31, 31, 32,  32,  32,  32,  32,  32,  32,  32,  32, 32, 32, 32, 32, 32, 33, 33,
    33, 33, 33, 33, 33, 33, 33,  33,  33,  33,  33,  33,  33,  33,  34, 34, 34, 34, 34, 34, 34, 34,
    34, 34, 34, 34, 34, 34, 34,  34,  34,  35,  35,  35,  35,  35,  35, 35, 35, 35, 35, 35, 35, 35,
    35, 35, 35, 35, 35, 35, 36,  36,  36,  36,  36,  36,  36,  36,  36, 36, 36, 36, 36, 36, 36, 36,
    36, 36, 36, 36, 36, 37, 37,  37,  37,  37,  37,  37,  37,  37,  37, 37, 37, 37, 37, 37, 37, 37,
    37, 37, 37, 37, 37, 37, 37,  37,  38,  38,  38,  38,  38,  38,  38, 38, 38, 38, 38, 38, 38, 38,
    38, 38, 38, 38, 38, 38, 255, 255, 255, 255, 255, 255, 255, 255,
};

// Cosines of multiples of 15 degrees.
static const float cosines[7] = {1.0f, 0.96592583f, 0.86602540f, 0.70710678f,
                                 0.5f, 0.25881905f, 0.0f};

static const float half_offsets[STP_CLIP_HALF_OFFSETS] = {0.08f, 0.35f, 0.65f};
static const float half_areas[STP_CLIP_HALF_OFFSETS] = {0.55088f, 0.71818f, 0.88246f};

static const float strip_offsets[STP_CLIP_STRIP_OFFSETS][2] = {
    {-0.05f, 0.05f}, {-0.05f, 0.15f}, {-0.15f, 0.05f}, {-0.15f, 0.15f},
    {-0.05f, 0.35f}, {-0.35f, 0.05f}, {-0.35f, 0.15f}, {-0.15f, 0.35f},
    {-0.35f, 0.35f}, {-0.15f, 0.65f}, {-0.65f, 0.15f}, {-0.5f, 0.5f}};
static const float strip_areas[STP_CLIP_STRIP_OFFSETS] = {0.06364f, 0.12695f, 0.12695f, 0.19027f,
                                                          0.25f,    0.25f,    0.31331f, 0.31331f,
                                                          0.43636f, 0.4776f,  0.4776f,  0.609f};

static float cosine(uint32_t direction)
{
    uint32_t turned = direction % STP_CLIP_DIRECTIONS;
    turned = turned > 12 ? 24 - turned : turned;
    return turned > 6 ? -cosines[12 - turned] : cosines[turned];
}

float stp_coverage_area(uint8_t code)
{
    if (code < STP_COVERAGE_CHANCES) {
        return (float)stp_coverage_shares[code] / 255.0f;
    }
    if (code == STP_COVERAGE_WHOLE) {
        return 1.0f;
    }
    return code < STP_COVERAGE_STRIPS
               ? half_areas[(code - STP_COVERAGE_HALVES) % STP_CLIP_HALF_OFFSETS]
               : strip_areas[(code - STP_COVERAGE_STRIPS) % STP_CLIP_STRIP_OFFSETS];
}

stp_disk_clip stp_coverage_clip(uint8_t code)
{
    assert(stp_coverage_clips(code) && "the code clips the disk");
    bool half = code < STP_COVERAGE_STRIPS;
    uint32_t at = code - (uint32_t)(half ? STP_COVERAGE_HALVES : STP_COVERAGE_STRIPS);
    uint32_t offsets = half ? STP_CLIP_HALF_OFFSETS : STP_CLIP_STRIP_OFFSETS;
    uint32_t direction = at / offsets, offset = at % offsets;
    return (stp_disk_clip){
        .across = cosine(direction),
        .along = cosine(direction + 18),
        .low = half ? -2.0f : strip_offsets[offset][0],
        .high = half ? half_offsets[offset] : strip_offsets[offset][1],
    };
}

uint8_t stp_coverage_of_share(double share)
{
    double value = share * 255.0;
    uint8_t code = 0;
    while (code + 1 < STP_COVERAGE_CHANCES &&
           value > 0.5 * (double)(stp_coverage_shares[code] + stp_coverage_shares[code + 1])) {
        code += 1;
    }
    double last = stp_coverage_shares[STP_COVERAGE_CHANCES - 1];
    assert(stp_coverage_shares[code] > 0 && "some of the disk is drawn");
    return value > 0.5 * (last + 255.0) ? STP_COVERAGE_WHOLE : code;
}
