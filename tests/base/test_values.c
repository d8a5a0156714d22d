// SPDX-License-Identifier: MIT
// Colours, normals, transforms, hashes and sorting: small pure functions against plain definitions.
#include "tests.h"

#include "base/core/sort.h"
#include "base/io/bytes.h"
#include "base/io/hash.h"
#include "base/math/color.h"
#include "base/math/rng.h"
#include "base/splats/octahedral.h"

#include <string.h>

static double srgb_decode(double s)
{
    return s <= 0.04045 ? s / 12.92 : pow((s + 0.055) / 1.055, 2.4);
}

void test_srgb_matches_its_definition(test_state* test)
{
    for (int i = 0; i < 256; ++i) {
        double expected = srgb_decode(i / 255.0);
        CHECK(fabs((double)stp_srgb8_to_linear((uint8_t)i) - expected) < 1e-7);
        CHECK_EQUAL(i, stp_linear_to_srgb8(stp_srgb8_to_linear((uint8_t)i)));
    }
}

void test_srgb_encodes_to_the_nearest_code(test_state* test)
{
    uint8_t last = 0;
    for (int i = 0; i <= 100000; ++i) {
        float linear = (float)i / 100000.0f;
        uint8_t code = stp_linear_to_srgb8(linear);
        CHECK(code >= last);
        last = code;
        float error = fabsf(stp_srgb8_to_linear(code) - linear);
        if (code > 0) {
            CHECK(error <= fabsf(stp_srgb8_to_linear((uint8_t)(code - 1)) - linear) + 1e-7f);
        }
        if (code < 255) {
            CHECK(error <= fabsf(stp_srgb8_to_linear((uint8_t)(code + 1)) - linear) + 1e-7f);
        }
    }
    CHECK_EQUAL(255, last);
}

void test_srgb_clamps_and_survives_non_numbers(test_state* test)
{
    CHECK_EQUAL(0, stp_linear_to_srgb8(-1.0f));
    CHECK_EQUAL(0, stp_linear_to_srgb8(NAN));
    CHECK_EQUAL(0, stp_linear_to_srgb8(-INFINITY));
    CHECK_EQUAL(255, stp_linear_to_srgb8(7.0f));
    CHECK_EQUAL(255, stp_linear_to_srgb8(INFINITY));
}

// A direction from random bits: not uniform, but it reaches every octant.
static stp_vec3 random_direction(uint64_t index)
{
    uint64_t bits = stp_rng_hash(99, index);
    stp_vec3 n = {(float)(int)(bits & 0xffff) - 32768.0f,
                  (float)(int)(bits >> 16 & 0xffff) - 32768.0f,
                  (float)(int)(bits >> 32 & 0xffff) - 32768.0f};
    return stp_normalize(n);
}

void test_octahedral_error_is_small(test_state* test)
{
    float worst = 1.0f;
    for (uint64_t i = 0; i < 200000; ++i) {
        stp_vec3 n = random_direction(i);
        int8_t code[2];
        stp_octahedral_encode(n, code);
        CHECK(code[0] >= -127 && code[1] >= -127);
        stp_vec3 back = stp_octahedral_decode(code[0], code[1]);
        CHECK(fabsf(stp_length(back) - 1.0f) < 1e-6f);
        worst = stp_min(worst, stp_dot(n, back));
    }
    CHECK(worst > 0.99985f); // within one degree
}

void test_octahedral_of_16_bits_is_precise(test_state* test)
{
    for (uint64_t i = 0; i < 100000; ++i) {
        stp_vec3 n = random_direction(i);
        int16_t code[2];
        stp_octahedral_encode16(n, code);
        CHECK(code[0] >= -32767 && code[1] >= -32767);
        stp_vec3 back = stp_octahedral_decode16(code[0], code[1]);
        CHECK(stp_length(stp_sub(back, n)) < 1e-4f);
    }
    int16_t none[2] = {5, 5};
    stp_octahedral_encode16((stp_vec3){0, 0, 0}, none);
    CHECK(none[0] == 0 && none[1] == 0);
    enum { MANY = 300 };
    static float normals[3 * MANY];
    static int16_t many[2 * MANY];
    for (size_t i = 0; i < MANY; ++i) { // runs of three equal ones, as on flat faces
        stp_vec3 n = random_direction(i / 3);
        memcpy(normals + 3 * i, &n, sizeof(n));
    }
    stp_octahedral_encode16_many(normals, MANY, many);
    for (size_t i = 0; i < MANY; ++i) {
        int16_t one[2];
        stp_octahedral_encode16(random_direction(i / 3), one);
        CHECK(one[0] == many[2 * i] && one[1] == many[2 * i + 1]);
    }
}

void test_clamp_is_within_its_bounds(test_state* test)
{
    CHECK(stp_clampd(-1.0, 0.5, 2.0) == 0.5 && stp_clampd(3.0, 0.5, 2.0) == 2.0);
    CHECK(stp_clampd(1.5, 0.5, 2.0) == 1.5 && stp_clampd(HUGE_VAL, 0.5, 2.0) == 2.0);
    CHECK(stp_clampd((double)NAN, 0.5, 2.0) == 0.5);
    CHECK(stp_maxd(-1.0, 2.0) == 2.0 && stp_maxd(2.0, -1.0) == 2.0);
}

void test_octahedral_is_near_the_best_of_all_codes(test_state* test)
{
    for (uint64_t i = 0; i < 40; ++i) {
        stp_vec3 n = random_direction(1000000 + i);
        float best = -1.0f;
        for (int u = -127; u <= 127; ++u) {
            for (int v = -127; v <= 127; ++v) {
                best = stp_max(best, stp_dot(n, stp_octahedral_decode((int8_t)u, (int8_t)v)));
            }
        }
        int8_t code[2];
        stp_octahedral_encode(n, code);
        float got = stp_dot(n, stp_octahedral_decode(code[0], code[1]));
        CHECK(acosf(stp_min(1.0f, got)) <= 1.3f * acosf(stp_min(1.0f, best)) + 1e-3f);
    }
}

void test_octahedral_keeps_axes_and_special_inputs(test_state* test)
{
    static const stp_vec3 axes[] = {{1, 0, 0},  {-1, 0, 0}, {0, 1, 0},
                                    {0, -1, 0}, {0, 0, 1},  {0, 0, -1}};
    for (int i = 0; i < 6; ++i) {
        int8_t code[2];
        stp_octahedral_encode(stp_scale(axes[i], 1e-30f), code); // length does not matter
        CHECK(stp_dot(axes[i], stp_octahedral_decode(code[0], code[1])) > 0.999999f);
    }
    static const stp_vec3 odd[] = {{0, 0, 0}, {NAN, 0, 0}, {INFINITY, 1, 0}, {-0.0f, -0.0f, -0.0f}};
    for (int i = 0; i < 4; ++i) {
        int8_t code[2] = {55, 55};
        stp_octahedral_encode(odd[i], code);
        CHECK_EQUAL(0, code[0]);
        CHECK_EQUAL(0, code[1]);
    }
    // codes are stable: encoding what a code decodes to gives the same direction again
    for (int u = -127; u <= 127; ++u) {
        for (int v = -127; v <= 127; ++v) {
            int8_t code[2];
            stp_vec3 n = stp_octahedral_decode((int8_t)u, (int8_t)v);
            stp_octahedral_encode(n, code);
            CHECK(stp_dot(n, stp_octahedral_decode(code[0], code[1])) > 0.999999f);
        }
    }
}

void test_affine_products_and_normals(test_state* test)
{
    stp_affine a = {{{0, -2, 0, 5}, {1, 0, 0, -3}, {0, 0, 3, 1}}};
    stp_affine b = {{{1, 0.5, 0, 2}, {0, 1, 0, 7}, {0, 0, -1, 4}}}; // sheared and mirrored
    stp_affine ab = stp_affine_multiply(a, b);
    stp_vec3d p = {1.5, -2, 8};
    stp_vec3d inner = stp_affine_point(&b, p);
    stp_vec3d expected = stp_affine_point(&a, inner), got = stp_affine_point(&ab, p);
    CHECK(expected.x == got.x && expected.y == got.y && expected.z == got.z);
    CHECK(stp_affine_determinant(&ab) == stp_affine_determinant(&a) * stp_affine_determinant(&b));
    // a normal stays orthogonal to the transformed tangents, on the transformed outer side
    double m[3][3];
    stp_affine_normal_matrix(&ab, m);
    stp_vec3d n = {0, 0, 1}, t1 = {1, 0, 0}, t2 = {0, 1, 0}, origin = {0, 0, 0};
    stp_vec3d turned = {m[0][0] * n.x + m[0][1] * n.y + m[0][2] * n.z,
                        m[1][0] * n.x + m[1][1] * n.y + m[1][2] * n.z,
                        m[2][0] * n.x + m[2][1] * n.y + m[2][2] * n.z};
    stp_vec3d base = stp_affine_point(&ab, origin);
    CHECK(fabs(stp_dotd(turned, stp_subd(stp_affine_point(&ab, t1), base))) < 1e-12);
    CHECK(fabs(stp_dotd(turned, stp_subd(stp_affine_point(&ab, t2), base))) < 1e-12);
    CHECK(stp_dotd(turned, stp_subd(stp_affine_point(&ab, n), base)) > 0.0);
    stp_boxd box = {{-1, -1, -1}, {1, 1, 1}};
    stp_boxd out = stp_affine_box(&a, box);
    CHECK(out.min.x == 3 && out.max.x == 7 && out.min.y == -4 && out.max.y == -2);
    CHECK(stp_boxd_is_empty(stp_affine_box(&a, stp_boxd_empty())));
}

void test_normalize_takes_any_length(test_state* test)
{
    static const float lengths[] = {1e-38f, 1e-20f, 1.0f, 1e19f, 3e38f};
    for (int i = 0; i < 5; ++i) {
        stp_vec3 n = stp_normalize((stp_vec3){0.6f * lengths[i], 0, 0.8f * lengths[i]});
        CHECK(fabsf(stp_length(n) - 1.0f) < 1e-5f && fabsf(n.x - 0.6f) < 1e-3f);
    }
    stp_vec3 none = stp_normalize((stp_vec3){0, NAN, 0});
    CHECK(none.x == 0 && none.y == 0 && none.z == 0);
}

void test_hashes_tell_contents_and_sequences_apart(test_state* test)
{
    unsigned char bytes[300];
    for (int i = 0; i < 300; ++i) {
        bytes[i] = (unsigned char)(i * 37);
    }
    stp_hash zero = {0};
    stp_hash whole = stp_hash_bytes(zero, bytes, 300);
    CHECK(stp_hash_equal(whole, stp_hash_bytes(zero, bytes, 300)));
    for (int i = 0; i < 300; ++i) {
        bytes[i] ^= 1;
        CHECK(!stp_hash_equal(whole, stp_hash_bytes(zero, bytes, 300)));
        bytes[i] ^= 1;
        CHECK(!stp_hash_equal(whole, stp_hash_bytes(zero, bytes, (size_t)i)));
    }
    stp_hash ab = stp_hash_bytes(stp_hash_bytes(zero, "a", 1), "b", 1);
    stp_hash ba = stp_hash_bytes(stp_hash_bytes(zero, "b", 1), "a", 1);
    CHECK(!stp_hash_equal(ab, ba));
    // both halves of the previous hash count
    stp_hash one = {.low = 1, .high = 2}, other = {.low = 1, .high = 3};
    CHECK(!stp_hash_equal(stp_hash_bytes(one, "x", 1), stp_hash_bytes(other, "x", 1)));
    CHECK(!stp_hash_equal(stp_hash_bytes(zero, NULL, 0), zero));
    // the same on every machine: XXH3's published value for no bytes and no seed
    CHECK_EQUAL(0x6001c324468d497full, stp_hash_bytes(zero, "", 0).low);
}

static int compare_u64(const void* a, const void* b)
{
    uint64_t x = *(const uint64_t*)a, y = *(const uint64_t*)b;
    return x < y ? -1 : x > y;
}

void test_radix_sort_agrees_with_qsort(test_state* test)
{
    static uint64_t items[5000], scratch[5000], expected[5000];
    static const size_t counts[] = {0, 1, 2, 3, 1000, 5000};
    for (size_t c = 0; c < 6; ++c) {
        for (size_t i = 0; i < counts[c]; ++i) {
            items[i] = expected[i] = stp_rng_hash(c, i);
        }
        qsort(expected, counts[c], sizeof(uint64_t), compare_u64);
        uint64_t* sorted = stp_sort_u64(items, scratch, counts[c], 0, 64);
        CHECK(sorted == items || sorted == scratch);
        CHECK(memcmp(sorted, expected, counts[c] * sizeof(uint64_t)) == 0);
    }
}

void test_radix_sort_is_stable_in_the_other_bits(test_state* test)
{
    static uint64_t items[4000], scratch[4000];
    static const unsigned bit_counts[] = {1, 3, 10, 11, 12, 22, 23, 30};
    for (size_t b = 0; b < 8; ++b) {
        uint64_t mask = ((uint64_t)1 << bit_counts[b]) - 1;
        for (uint64_t i = 0; i < 4000; ++i) {
            uint64_t key = stp_rng_hash(b, i) % 17 & mask; // many equal keys
            items[i] =
                i | key << 20 | (stp_rng_hash(5, i) & 0xf) << 60; // high bits must not matter
        }
        uint64_t* sorted = stp_sort_u64(items, scratch, 4000, 20, bit_counts[b]);
        for (size_t i = 1; i < 4000; ++i) {
            uint64_t before = sorted[i - 1] >> 20 & mask, after = sorted[i] >> 20 & mask;
            CHECK(before < after ||
                  (before == after && (sorted[i - 1] & 0xfffff) < (sorted[i] & 0xfffff)));
        }
    }
}

void test_numbers_cross_bytes_at_any_alignment(test_state* test)
{
    unsigned char bytes[24];
    for (size_t at = 0; at < 8; ++at) {
        stp_write_u64(bytes + at, UINT64_C(0x0123456789abcdef));
        CHECK_EQUAL(0xef, bytes[at]); // little-endian
        CHECK_EQUAL(UINT64_C(0x0123456789abcdef), stp_read_u64(bytes + at));
        CHECK_EQUAL(0x89abcdef, stp_read_u32(bytes + at));
        CHECK_EQUAL(0xcdef, stp_read_u16(bytes + at));
        stp_write_f32(bytes + at, -1.5f);
        CHECK(stp_read_f32(bytes + at) == -1.5f);
        stp_write_f64(bytes + at, 1e300);
        CHECK(stp_read_f64(bytes + at) == 1e300);
    }
}

void test_random_bits_are_a_pure_function_and_even(test_state* test)
{
    CHECK(stp_rng_hash(1, 2) == stp_rng_hash(1, 2));
    CHECK(stp_rng_hash(1, 2) != stp_rng_hash(2, 1));
    unsigned hits[10] = {0};
    for (uint64_t i = 0; i < 100000; ++i) {
        uint32_t value = stp_rng_below(3, i, 10);
        CHECK(value < 10);
        hits[value] += 1;
    }
    for (int i = 0; i < 10; ++i) {
        CHECK(hits[i] > 9600 && hits[i] < 10400);
    }
    CHECK_EQUAL(0, stp_rng_below(3, 7, 1));
}

void test_affine_scale_bounds_shears(test_state* test)
{
    // three columns of length 1 that enclose small angles
    stp_affine shear = {{{0.8, 0.6, 0.6, 0}, {0.6, 0.8, 0.6, 0}, {0, 0, sqrt(0.28), 0}}};
    stp_affine turn = {{{0.6, -0.8, 0, 5}, {0.8, 0.6, 0, 6}, {0, 0, 1, 7}}};
    double length = 0.0;
    for (int r = 0; r < 3; ++r) {
        double sum = shear.m[r][0] + shear.m[r][1] + shear.m[r][2]; // of (1, 1, 1)
        length += sum * sum / 3.0;
    }
    CHECK(sqrt(length) > 1.5 && stp_affine_scale(&shear) >= sqrt(length));
    CHECK(fabs(stp_affine_scale(&turn) - 1.0) < 1e-12);
}
