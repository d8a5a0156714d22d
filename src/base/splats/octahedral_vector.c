// SPDX-License-Identifier: MIT
// stp_octahedral_encode, eight at a time: same operations in the same order, so same codes.
#include "base/math/f32x8.h"
#include "base/splats/octahedral.h"

#include <assert.h>
#include <float.h>
#include <math.h>

static inline i32x8 is_negative(f32x8 a)
{
    return f32x8_less(a, f32x8_set(0.0f));
}

// stp_normalize; vectors without a direction become zero here too.
static inline vector3x8 normalize(vector3x8 n)
{
    float x[8], y[8], z[8];
    f32x8_store(x, n.x);
    f32x8_store(y, n.y);
    f32x8_store(z, n.z);
    for (int i = 0; i < 8; ++i) {
        double a = (double)x[i], b = (double)y[i], c = (double)z[i];
        double length = sqrt(a * a + b * b + c * c);
        bool usable = length > 0.0 && length <= DBL_MAX;
        x[i] = usable ? (float)(a / length) : 0.0f;
        y[i] = usable ? (float)(b / length) : 0.0f;
        z[i] = usable ? (float)(c / length) : 0.0f;
    }
    return vector3x8_load(x, y, z);
}

// Places of unit vectors on the unfolded square, in codes, rounded down.
static inline void unfold(vector3x8 n, i32x8* base_u, i32x8* base_v)
{
    f32x8 sum =
        f32x8_add(f32x8_add(f32x8_magnitude(n.x), f32x8_magnitude(n.y)), f32x8_magnitude(n.z));
    f32x8 u = f32x8_div(n.x, sum), v = f32x8_div(n.y, sum), one = f32x8_set(1.0f);
    f32x8 across = f32x8_sub(one, f32x8_magnitude(v)), along = f32x8_sub(one, f32x8_magnitude(u));
    across = f32x8_select(is_negative(u), f32x8_negate(across), across);
    along = f32x8_select(is_negative(v), f32x8_negate(along), along);
    i32x8 below = is_negative(n.z);
    u = f32x8_select(below, across, u);
    v = f32x8_select(below, along, v);
    f32x8 scale = f32x8_set(127.0f), half = f32x8_set(128.0f);
    i32x8 whole = i32x8_set(128);
    u = f32x8_add(f32x8_mul(u, scale), half);
    v = f32x8_add(f32x8_mul(v, scale), half);
    *base_u = i32x8_sub(f32x8_truncate(u), whole);
    *base_v = i32x8_sub(f32x8_truncate(v), whole);
}

static inline i32x8 clamp_codes(i32x8 code)
{
    return i32x8_min(i32x8_max(code, i32x8_set(-127)), i32x8_set(127));
}

// Dot products of the decoded codes with the vectors.
static inline f32x8 measure_agreement(vector3x8 n, i32x8 code_u, i32x8 code_v)
{
    f32x8 scale = f32x8_set(127.0f);
    f32x8 u = f32x8_div(i32x8_to_float(code_u), scale);
    f32x8 v = f32x8_div(i32x8_to_float(code_v), scale);
    f32x8 z = f32x8_sub(f32x8_sub(f32x8_set(1.0f), f32x8_magnitude(u)), f32x8_magnitude(v));
    f32x8 fold = f32x8_keep(f32x8_negate(z), is_negative(z));
    u = f32x8_add(u, f32x8_select(is_negative(u), fold, f32x8_negate(fold)));
    v = f32x8_add(v, f32x8_select(is_negative(v), fold, f32x8_negate(fold)));
    vector3x8 place = {u, v, z};
    f32x8 length = f32x8_root(vector3x8_dot(place, place));
    vector3x8 decoded = {f32x8_div(u, length), f32x8_div(v, length), f32x8_div(z, length)};
    return vector3x8_dot(n, decoded);
}

static void encode_eight(const float* normals, int8_t* out)
{
    vector3x8 n = normalize(vector3x8_load_triples(normals));
    i32x8 base_u, base_v;
    unfold(n, &base_u, &base_v);
    f32x8 best = f32x8_set(-2.0f); // NaN is never better: zero keeps code 0
    i32x8 best_u = i32x8_set(0), best_v = best_u;
    for (int i = 0; i < 4; ++i) {
        i32x8 u = clamp_codes(i32x8_add(base_u, i32x8_set(i & 1)));
        i32x8 v = clamp_codes(i32x8_add(base_v, i32x8_set(i >> 1)));
        f32x8 agreement = measure_agreement(n, u, v);
        i32x8 better = f32x8_less(best, agreement);
        best = f32x8_select(better, agreement, best);
        best_u = i32x8_select(better, u, best_u);
        best_v = i32x8_select(better, v, best_v);
    }
    f32x8 sum =
        f32x8_add(f32x8_add(f32x8_magnitude(n.x), f32x8_magnitude(n.y)), f32x8_magnitude(n.z));
    i32x8 usable = f32x8_less(f32x8_set(0.0f), sum);
    i32x8 byte = i32x8_and(usable, i32x8_set(0xff));
    i32x8 pairs = i32x8_or(i32x8_and(best_u, byte), i32x8_left(i32x8_and(best_v, byte), 8));
    int32_t codes[8];
    i32x8_store(codes, pairs);
    for (int i = 0; i < 8; ++i) {
        out[2 * i] = (int8_t)(uint8_t)(codes[i] & 0xff);
        out[2 * i + 1] = (int8_t)(uint8_t)(codes[i] >> 8);
    }
}

void stp_octahedral_encode_vector(const float* normals, size_t count, int8_t* out)
{
    size_t done = 0;
    for (; count - done >= 8; done += 8) {
        encode_eight(normals + 3 * done, out + 2 * done);
    }
    assert(count - done < 8 && done % 8 == 0);
    stp_octahedral_encode_portable(normals + 3 * done, count - done, out + 2 * done);
}
