// SPDX-License-Identifier: MIT
#include "base/splats/octahedral.h"

#include "base/core/processor.h"

#include <assert.h>
#include <stdbool.h>
#include <string.h>

static int8_t clamp_code(int value)
{
    return (int8_t)(value < -127 ? -127 : value > 127 ? 127 : value);
}

// Maps a unit vector to the unfolded square, -1..1 on each axis; @return false for zero
static bool unfold(stp_vec3 n, float square[2])
{
    float sum = fabsf(n.x) + fabsf(n.y) + fabsf(n.z);
    if (!(sum > 0.0f)) {
        return false;
    }
    float u = n.x / sum, v = n.y / sum;
    if (n.z < 0.0f) {
        float folded = (1.0f - fabsf(v)) * (u >= 0.0f ? 1.0f : -1.0f);
        v = (1.0f - fabsf(u)) * (v >= 0.0f ? 1.0f : -1.0f);
        u = folded;
    }
    assert(fabsf(u) <= 1.0f && fabsf(v) <= 1.0f);
    square[0] = u;
    square[1] = v;
    return true;
}

void stp_octahedral_encode16(stp_vec3 n, int16_t out[2])
{
    float square[2] = {0.0f, 0.0f};
    (void)unfold(stp_normalize(n), square);
    out[0] = (int16_t)((int)(square[0] * 32767.0f + 32768.5f) - 32768);
    out[1] = (int16_t)((int)(square[1] * 32767.0f + 32768.5f) - 32768);
}

void stp_octahedral_encode(stp_vec3 n, int8_t out[2])
{
    float square[2];
    n = stp_normalize(n);
    if (!unfold(n, square)) {
        out[0] = out[1] = 0;
        return;
    }
    float u = square[0], v = square[1];
    int base_u = (int)(u * 127.0f + 128.0f) - 128, base_v = (int)(v * 127.0f + 128.0f) - 128;
    float best = -2.0f;
    for (int i = 0; i < 4; ++i) {
        int8_t code_u = clamp_code(base_u + (i & 1)), code_v = clamp_code(base_v + (i >> 1));
        float agreement = stp_dot(n, stp_octahedral_decode(code_u, code_v));
        if (agreement > best) {
            best = agreement;
            out[0] = code_u;
            out[1] = code_v;
        }
    }
    assert(best > 0.9f && "the best code is close to the direction");
}

void stp_octahedral_encode_portable(const float* normals, size_t count, int8_t* out)
{
    for (size_t i = 0; i < count; ++i) {
        const float* n = normals + 3 * i;
        stp_octahedral_encode((stp_vec3){n[0], n[1], n[2]}, out + 2 * i);
    }
}

void stp_octahedral_encode_many(const float* normals, size_t count, int8_t* out)
{
    STP_VARIANT_OF_TWO(stp_processor_detect(), stp_octahedral_encode)(normals, count, out);
}

void stp_octahedral_encode16_many(const float* normals, size_t count, int16_t* out)
{
    for (size_t i = 0; i < count; ++i) {
        const float* n = normals + 3 * i;
        if (i > 0 && memcmp(n, n - 3, 3 * sizeof(*n)) == 0) { // vertices of a flat face
            memcpy(out + 2 * i, out + 2 * i - 2, 2 * sizeof(*out));
        } else {
            stp_octahedral_encode16((stp_vec3){n[0], n[1], n[2]}, out + 2 * i);
        }
    }
}
