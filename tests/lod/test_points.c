// SPDX-License-Identifier: MIT
#include "tests.h"

#include "lod/candidate_helpers.h"
#include "lod/points.h"

void test_estimated_normals_of_a_sphere(test_state* test)
{
    enum { COUNT = 4000 };
    stp_context* context = test_context(NULL, 2, NULL);
    maker* m = maker_create(0.06);
    CHECK(context != NULL);
    for (int i = 0; i < COUNT; ++i) {
        double z = 1.0 - (2.0 * i + 1.0) / COUNT, r = sqrt(1.0 - z * z),
               turn = 2.39996322972865332 * i;
        stp_vec3 n = {(float)(r * cos(turn)), (float)(r * sin(turn)), (float)z};
        maker_add(m, n, (stp_vec3){0, 1, 0}, 0x808080ff);
    }
    CHECK_EQUAL(STP_OK, stp_estimate_point_normals(context, &m->candidates, 0.15f));
    for (int i = 0; i < COUNT; ++i) {
        const float* p = m->candidates.positions + 3 * (size_t)i;
        const float* n = m->candidates.normals + 3 * (size_t)i;
        CHECK(fabsf(p[0] * n[0] + p[1] * n[1] + p[2] * n[2]) > 0.99f);
        CHECK(n[1] >= 0.0f);
    }
    maker_destroy(m);
    stp_context_destroy(context);
}

void test_normals_of_lonely_points_face_up(test_state* test)
{
    stp_context* context = test_context(NULL, 1, NULL);
    maker* m = maker_create(0.1);
    CHECK(context != NULL);
    for (int i = 0; i < 10; ++i) { // the last five coincide: no direction is flattest
        maker_add(m, (stp_vec3){i < 5 ? (float)i : 9.0f, 0, 0}, (stp_vec3){1, 0, 0}, 0x808080ff);
    }
    CHECK_EQUAL(STP_OK, stp_estimate_point_normals(context, &m->candidates, 0.1f));
    for (int i = 0; i < 10; ++i) {
        CHECK(m->candidates.normals[3 * i + 1] == 1.0f);
    }
    CHECK_EQUAL(STP_OK, stp_estimate_point_normals(context, &m->candidates, 0.0f));
    maker_destroy(m);
    stp_context_destroy(context);
}
