// SPDX-License-Identifier: MIT
// Light normals come back from their codes, and those that tell nothing are zeros.
#include "tests.h"

#include "base/math/rng.h"
#include "base/splats/light_normal.h"

static float unit(uint64_t index)
{
    return (float)(stp_rng_hash(31, index) >> 40) * (1.0f / 16777216.0f);
}

static stp_vec3 direction(uint64_t index)
{
    return stp_normalize((stp_vec3){2.0f * unit(3 * index) - 1.0f,
                                    2.0f * unit(3 * index + 1) - 1.0f,
                                    2.0f * unit(3 * index + 2) - 1.0f});
}

void test_light_normals_come_back(test_state* test)
{
    for (uint64_t i = 0; i < 2000; ++i) {
        int8_t own[2], turn[2];
        uint8_t spread;
        stp_vec3 wanted = direction(2 * i);
        float length = 0.01f + 0.99f * unit(10000 + i);
        stp_octahedral_encode(direction(2 * i + 1), own); // any other direction
        stp_light_normal_encode(stp_scale(wanted, length), own, turn, &spread);
        const stp_light_normals of = {turn, &spread};
        stp_vec3 got = stp_light_normal(&of, own, 0);
        CHECK(fabsf(stp_length(got) - length) <= (length > 0.97f ? 1.51f : 8.51f) / 255.0f);
        CHECK(length < 0.1f || stp_dot(stp_normalize(got), wanted) > 0.995f); // 6 degrees
    }
}

void test_light_normals_of_nothing_else_are_zeros(test_state* test)
{
    const stp_light_normals none = {0};
    for (uint64_t i = 0; i < 200; ++i) {
        int8_t own[2], turn[2] = {1, 1};
        uint8_t spread = 1;
        stp_vec3 n = direction(i);
        stp_octahedral_encode(n, own);
        stp_light_normal_encode(stp_scale(n, 0.998f), own, turn, &spread);
        CHECK(turn[0] == 0 && turn[1] == 0 && spread == 0);
        const stp_light_normals zeros = {turn, &spread};
        stp_vec3 a = stp_light_normal(&none, own, 7), b = stp_light_normal(&zeros, own, 0);
        CHECK(stp_length(stp_sub(a, b)) < 1e-6f);
        stp_light_normal_encode((stp_vec3){0}, own, turn, &spread); // all normals cancel
        CHECK(turn[0] == 0 && turn[1] == 0 && spread == 255);
        CHECK(stp_length(stp_light_normal(&zeros, own, 0)) == 0.0f);
    }
}

void test_light_normals_of_octaves_follow_each_other(test_state* test)
{
    int8_t turns[2 * 112] = {0};
    uint8_t spreads[112] = {0};
    const stp_splats s = {.count = 400,
                          .octave_count = 4,
                          .octave_ends = {2, 10, 110, 400},
                          .light_octaves = 5,
                          .turns = turns,
                          .spreads = spreads};
    CHECK_EQUAL(0, stp_light_normals_begin(&s, 0));
    CHECK_EQUAL(2, stp_light_normals_begin(&s, 1));
    CHECK_EQUAL(2, stp_light_normals_begin(&s, 2));
    CHECK_EQUAL(112, stp_light_normals_begin(&s, 4));
    CHECK(stp_light_normals_of(&s, 0).turns == turns);
    CHECK(stp_light_normals_of(&s, 1).turns == NULL && stp_light_normals_of(&s, 3).spreads == NULL);
    CHECK(stp_light_normals_of(&s, 2).turns == turns + 4);
    CHECK(stp_light_normals_of(&s, 2).spreads == spreads + 2);
}
