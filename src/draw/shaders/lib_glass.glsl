// Transparent surfaces: src/raster/blue_noise.c, splats_transparent.h.
#include "interface.h"
#include "lib_hash.glsl"

layout(std140, binding = BINDING_NOISE) uniform Noise { uvec4 noise_ranks[NOISE_SIDE * NOISE_SIDE / 8]; };

// flag of a fragment's coverage: the rest is an opacity, 65535 is 1
#define GLASS_HASHED 0x80000000u

// Key of a surface's alpha thresholds. `seed` without the sample.
uint find_glass_key(uint seed, uint side, int cell)
{
    return random_bits(uvec2(seed, 0u), uvec2(uint(cell), side)).y >> 8;
}

// 0 to 1
float find_threshold(uint key, ivec2 pixel, uint sample_number)
{
    uint column = (uint(pixel.x) + key) & uint(NOISE_SIDE - 1), row = (uint(pixel.y) + (key >> 6)) & uint(NOISE_SIDE - 1);
    uint at = row * uint(NOISE_SIDE) + column;
    uint word = noise_ranks[at >> 3][(at >> 1) & 3u], rank = (at & 1u) != 0u ? word >> 16 : word & 0xFFFFu;
    uint step = (key >> 9 & 0x7FFFu) * 2u + 1u;
    return float((rank * 16u + 8u + sample_number * step) & 0xFFFFu) * (1.0 / 65536.0);
}

// Optical depth of an opacity, rounded to a byte (stp_optical_depth).
uint optical_depth(float opacity)
{
    float byte = floor(min(opacity, 254.0 / 255.0) * 255.0 + 0.5);
    return uint(-log2(1.0 - byte * (1.0 / 255.0)) * float(OPTICAL_UNIT) + 0.5);
}

// Opacity of a surface of splats with this coverage (of 255): on average two of them cover a pixel.
float glass_opacity(uint coverage)
{
    float clear = 1.0 - float(coverage) * (1.0 / 255.0);
    return 1.0 - clear * clear;
}
