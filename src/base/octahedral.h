// SPDX-License-Identifier: MIT
// Unit vectors in two numbers: the octahedron unfolded onto a square.
// Cigolle et al. A Survey of Efficient Representations for Independent Unit Vectors. 2014.
#pragma once

#include "base/math.h"

#include <stddef.h>

/// Decodes two signed bytes, each -127..127.
static inline stp_vec3 stp_octahedral_decode(int8_t u8, int8_t v8)
{
    float u = (float)u8 / 127.0f, v = (float)v8 / 127.0f;
    float z = 1.0f - fabsf(u) - fabsf(v);
    float fold = z < 0.0f ? -z : 0.0f;
    u += u >= 0.0f ? -fold : fold;
    v += v >= 0.0f ? -fold : fold;
    float length = sqrtf(u * u + v * v + z * z);
    return (stp_vec3){u / length, v / length, z / length};
}

/// Encodes a direction (need not be of unit length; zero encodes as +z) so that its decoding is the nearest
/// of the four codes around it.
void stp_octahedral_encode(stp_vec3 n, int8_t out[2]);
/// The same for `count` directions, 3 floats each.
void stp_octahedral_encode_many(const float* normals, size_t count, int8_t* out);

/// The same in two 16-bit numbers, 32767 is 1: for the normals of vertices.
static inline stp_vec3 stp_octahedral_decode16(int16_t u16, int16_t v16)
{
    float u = (float)u16 / 32767.0f, v = (float)v16 / 32767.0f;
    float z = 1.0f - fabsf(u) - fabsf(v);
    float fold = z < 0.0f ? -z : 0.0f;
    u += u >= 0.0f ? -fold : fold;
    v += v >= 0.0f ? -fold : fold;
    float length = sqrtf(u * u + v * v + z * z);
    return (stp_vec3){u / length, v / length, z / length};
}

/// Rounded to the nearest code on each axis: within a hundredth of a degree.
void stp_octahedral_encode16(stp_vec3 n, int16_t out[2]);
