// SPDX-License-Identifier: MIT
// Coverage codes of disks.
#include "tests.h"

#include "base/splats/coverage.h"

void test_coverage_codes_draw_their_area(test_state* test)
{
    enum { SIZE = 400 };
    for (int code = STP_COVERAGE_HALVES; code < STP_COVERAGE_WHOLE; ++code) {
        stp_disk_clip clip = stp_coverage_clip((uint8_t)code);
        CHECK(fabsf(clip.across * clip.across + clip.along * clip.along - 1.0f) < 1e-5f);
        int inside = 0, drawn = 0;
        for (int i = 0; i < SIZE * SIZE; ++i) {
            float x = ((float)(i % SIZE) + 0.5f) * 2.0f / SIZE - 1.0f;
            float y = ((float)(i / SIZE) + 0.5f) * 2.0f / SIZE - 1.0f;
            float at = clip.across * x + clip.along * y;
            bool in = x * x + y * y <= 1.0f;
            inside += in;
            drawn += in && at >= clip.low && at <= clip.high;
        }
        float area = stp_coverage_area((uint8_t)code);
        CHECK(area < 1.0f && fabsf((float)drawn / (float)inside - area) < 0.005f);
    }
    CHECK(stp_coverage_area(STP_COVERAGE_WHOLE) == 1.0f);
}

void test_coverage_shares_are_near(test_state* test)
{
    for (int share = 1; share <= 255; ++share) {
        uint8_t code = stp_coverage_of_share(share / 255.0);
        CHECK(!stp_coverage_clips(code));
        CHECK(abs(stp_coverage_share(code) - share) <= share / 16 + 1);
        CHECK_EQUAL(code, stp_coverage_of_plain[share]);
        CHECK(fabsf(stp_coverage_area(code) * 255.0f - (float)stp_coverage_share(code)) < 1e-3f);
    }
    CHECK_EQUAL(0, stp_coverage_of_share(0.0));
    CHECK_EQUAL(STP_COVERAGE_WHOLE, stp_coverage_of_share(1.0));
}

void test_disk_axes_are_orthonormal(test_state* test)
{
    for (int u = -127; u <= 127; u += 2) {
        for (int v = -127; v <= 127; v += 3) {
            stp_vec3 n = stp_normalize(stp_octahedral_unfold((float)u, (float)v));
            stp_disk_axes axes = stp_disk_axes_of((float)u, (float)v);
            stp_vec3 across = stp_cross(axes.x, axes.y);
            CHECK(fabsf(stp_dot(axes.x, axes.x) - 1.0f) < 1e-5f);
            CHECK(fabsf(stp_dot(axes.y, axes.y) - 1.0f) < 1e-5f);
            CHECK(stp_dot(across, n) > 0.9999f || stp_dot(across, n) < -0.9999f);
        }
    }
}
