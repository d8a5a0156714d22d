// SPDX-License-Identifier: MIT
// Unit vectors as two numbers: the octahedron unfolded onto a square.
// Cigolle et al. A Survey of Efficient Representations for Independent Unit Vectors. 2014.
#pragma once

#include "base/math/math.h"

#include <stddef.h>

/// Direction of a point of the unfolded octahedron; u and v from -1 to 1.
static inline stp_vec3 stp_octahedral_direction(float u, float v)
{
    float z = 1.0f - fabsf(u) - fabsf(v);
    float fold = z < 0.0f ? -z : 0.0f;
    u += u >= 0.0f ? -fold : fold;
    v += v >= 0.0f ? -fold : fold;
    float length = sqrtf(u * u + v * v + z * z);
    return (stp_vec3){u / length, v / length, z / length};
}

/// Decodes two signed bytes, each -127..127.
static inline stp_vec3 stp_octahedral_decode(int8_t u, int8_t v)
{
    return stp_octahedral_direction((float)u / 127.0f, (float)v / 127.0f);
}

/// Encodes a direction of any length. Chooses the best of the four codes around it; zero encodes as
/// +z.
void stp_octahedral_encode(stp_vec3 n, int8_t out[2]);
/// Encodes `count` directions, 3 floats each.
void stp_octahedral_encode_many(const float* normals, size_t count, int8_t* out);

/// 16 bits per number, 32767 is 1: for vertex normals.
static inline stp_vec3 stp_octahedral_decode16(int16_t u, int16_t v)
{
    return stp_octahedral_direction((float)u / 32767.0f, (float)v / 32767.0f);
}

/// Rounds each axis to the nearest code: the error is below a hundredth of a degree.
void stp_octahedral_encode16(stp_vec3 n, int16_t out[2]);
/// Encodes `count` directions, 3 floats each.
void stp_octahedral_encode16_many(const float* normals, size_t count, int16_t* out);

/// Variants of stp_octahedral_encode_many, which chooses.
void stp_octahedral_encode_portable(const float* normals, size_t count, int8_t* out);
void stp_octahedral_encode_vector(const float* normals, size_t count, int8_t* out);
