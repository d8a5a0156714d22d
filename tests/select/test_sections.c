// SPDX-License-Identifier: MIT
#include "support_built.h"

#include "base/math/rng.h"
#include "select/sections.h"
#include "select/visibility.h"
#include "store/clusters/clusters.h"

#include <math.h>

static double random_between(uint64_t seed, uint64_t index, double low, double high)
{
    return low + (high - low) * (double)(stp_rng_hash(seed, index) >> 11) * 0x1p-53;
}

static stp_vec3d random_point(uint64_t seed, double reach)
{
    return (stp_vec3d){random_between(seed, 0, -reach, reach),
                       random_between(seed, 1, -reach, reach),
                       random_between(seed, 2, -reach, reach)};
}

void test_sections_classify_boxes_as_their_corners(test_state* test)
{
    uint32_t outside = 0, inside = 0, between = 0;
    for (uint64_t i = 0; i < 3000; ++i) {
        stp_sections sections = {0};
        uint32_t count = 1 + (uint32_t)(i % 8);
        for (uint64_t k = 0; k < count; ++k) {
            stp_vec3d point = random_point(stp_rng_hash(i, 10 + k), 3.0);
            stp_vec3d normal = random_point(stp_rng_hash(i, 30 + k), 1.0);
            CHECK(stp_sections_add_plane(&sections, point, normal));
            CHECK(fabs(stp_section_beyond(&sections.planes[k], point)) < 1e-12);
        }
        stp_vec3d low = random_point(stp_rng_hash(i, 1), 2.0);
        stp_vec3d size = random_point(stp_rng_hash(i, 2), 1.0);
        stp_boxd box = {low, {low.x + fabs(size.x), low.y + fabs(size.y), low.z + fabs(size.z)}};
        uint32_t all = stp_sections_all(&sections), mask = all;
        bool left = stp_sections_test(&sections, &box, 0.0, &mask);
        bool beyond_one = false;
        uint32_t cutting = 0;
        for (uint32_t k = 0; k < count; ++k) {
            uint32_t beyond = 0;
            for (int corner = 0; corner < 8; ++corner) {
                stp_vec3d p = {(corner & 1) != 0 ? box.max.x : box.min.x,
                               (corner & 2) != 0 ? box.max.y : box.min.y,
                               (corner & 4) != 0 ? box.max.z : box.min.z};
                beyond += stp_section_beyond(&sections.planes[k], p) > 0.0 ? 1 : 0;
            }
            beyond_one = beyond_one || beyond == 8;
            cutting |= beyond > 0 ? 1u << k : 0;
        }
        CHECK(left == !beyond_one);
        CHECK(!left || mask == cutting);
        outside += left ? 0 : 1;
        inside += left && mask == 0 ? 1 : 0;
        between += left && mask != 0 ? 1 : 0;
        stp_vec3d p = random_point(stp_rng_hash(i, 3), 3.0);
        bool cut = false;
        for (uint32_t k = 0; k < count; ++k) {
            cut = cut || stp_section_beyond(&sections.planes[k], p) > 0.0;
        }
        CHECK(cut == stp_sections_exclude(&sections, p));
    }
    CHECK(outside > 100 && inside > 100 && between > 100);
}

void test_sections_turn_with_what_they_cut(test_state* test)
{
    for (uint64_t i = 0; i < 200; ++i) {
        stp_affine t;
        for (uint64_t k = 0; k < 12; ++k) {
            t.m[k / 4][k % 4] = random_between(i, k, -2.0, 2.0) + (k % 4 == 3 ? 4e6 : 0.0);
        }
        stp_sections sections = {0};
        stp_vec3d origin = {t.m[0][3], t.m[1][3], t.m[2][3]};
        CHECK(stp_sections_add_plane(&sections, origin, random_point(stp_rng_hash(i, 99), 1.0)));
        const float offset[3] = {0.5f, -0.25f, 3.0f};
        double row[4];
        stp_section_row(&sections.planes[0], &t, offset, row);
        stp_vec3d p = random_point(stp_rng_hash(i, 98), 5.0);
        stp_vec3d scene = stp_affine_point(&t, p);
        double here = row[0] * (p.x - 0.5) + row[1] * (p.y + 0.25) + row[2] * (p.z - 3.0) + row[3];
        CHECK(fabs(here - stp_section_beyond(&sections.planes[0], scene)) < 1e-7);
    }
}

void test_sections_refuse_invalid_planes(test_state* test)
{
    stp_sections sections = {0};
    stp_vec3d zero = {0, 0, 0}, up = {0, 2, 0};
    CHECK(!stp_sections_add_plane(&sections, zero, zero));
    CHECK(!stp_sections_add_plane(&sections, (stp_vec3d){(double)NAN, 0, 0}, up));
    CHECK_EQUAL(0, sections.count);
    for (int i = 0; i < STP_SECTION_PLANES - 5; ++i) {
        CHECK(stp_sections_add_plane(&sections, zero, up));
    }
    stp_boxd box = {{-1, -1, -1}, {1, 1, 1}};
    CHECK(!stp_sections_add_box(&sections, &box, 0.0)); // one too many
    CHECK_EQUAL(STP_SECTION_PLANES - 5, sections.count);
    sections.count -= 1;
    CHECK(stp_sections_add_box(&sections, &box, 0.0));
    CHECK(stp_sections_are_valid(&sections));
    CHECK(stp_sections_exclude(&sections, (stp_vec3d){0, -0.5, 1.5}));
    CHECK(!stp_sections_exclude(&sections, (stp_vec3d){0.9, -0.9, 0.9}));
    box = stp_boxd_empty();
    CHECK(!stp_sections_add_box(&sections, &box, 0.0));
    sections.count = STP_SECTION_PLANES + 1;
    CHECK(!stp_sections_are_valid(&sections));
}

/// Vertices of a scene that sections cut away.
static uint32_t count_cut(stp_context* context, stp_store* store, const built_places* places,
                          const stp_sections* sections)
{
    uint32_t cut = 0;
    for (uint32_t i = 0; i < places->count; ++i) {
        const stp_instance* place = &places->places[i];
        stp_clusters clusters;
        stp_decoded_mesh mesh;
        if (stp_store_get_clusters(store, place->part.index, &clusters) != STP_OK ||
            stp_clusters_decode(context, &clusters, &mesh) != STP_OK) {
            return UINT32_MAX;
        }
        for (size_t k = 0; k < 3 * (size_t)mesh.triangle_count; ++k) {
            const float* p = mesh.positions + 3 * k;
            stp_vec3d own = {(double)p[0], (double)p[1], (double)p[2]};
            cut += stp_sections_exclude(sections, stp_affine_point(&place->transform, own));
        }
        stp_decoded_mesh_destroy(context, &mesh);
    }
    return cut;
}

void test_sections_around_everything_cut_nothing(test_state* test)
{
    uint32_t cut_without = 0;
    for (uint64_t seed = 50; seed < 54; ++seed) {
        stp_context* context = test_context(NULL, 2, NULL);
        stp_store* store = context != NULL ? built_open(context, seed, seed % 2 == 0) : NULL;
        static built_places all;
        stp_affine identity = stp_affine_identity();
        stp_sections sections = {0}, tight = {0};
        CHECK(store != NULL);
        const stp_store_directory* d = stp_store_get_directory(store);
        stp_boxd box = d->nodes[d->root].bounds;
        all.count = 0;
        CHECK(built_unfold(store, d->root, &identity, &all));
        double rounding = stp_bounds_rounding(context, store);
        double size = stp_lengthd(stp_subd(box.max, box.min));
        CHECK(rounding >= 0.0 && rounding < 1e-3 * size);
        CHECK(stp_sections_add_box(&sections, &box, rounding));
        CHECK_EQUAL(0, count_cut(context, store, &all, &sections));
        CHECK(stp_sections_add_plane(&tight, box.max, (stp_vec3d){1, 0, 0}) &&
              stp_sections_add_plane(&tight, box.max, (stp_vec3d){0, 1, 0}) &&
              stp_sections_add_plane(&tight, box.min, (stp_vec3d){0, 0, -1}));
        cut_without += count_cut(context, store, &all, &tight);
        // such planes need not be tested; one that cuts remains
        CHECK(stp_sections_add_plane(&sections, stp_scaled(stp_addd(box.min, box.max), 0.5),
                                     (stp_vec3d){1, 1, 0}));
        stp_sections_drop_idle(&sections, &box, rounding);
        CHECK(sections.count == 1 && fabs(sections.planes[0].normal.x - sqrt(0.5)) < 1e-9);
        stp_store_close(store);
        stp_context_destroy(context);
    }
    CHECK(cut_without > 0); // stored positions are rounded
}
