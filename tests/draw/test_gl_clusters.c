// SPDX-License-Identifier: MIT
// Clusters of many items are culled by all threads (draw/gl/cluster_shares.h).
#include "support_gl.h"
#include "tests.h"

#include "draw/gl/cluster_shares.h"
#include "draw/gl/gl_renderer.h"
#include "draw/placement.h"
#include "store/support_mesh.h"

#include <string.h>

enum { ITEMS = 7, SIDE = 110, SHARED_FROM = 1024 }; // fewer clusters are culled by one thread

static made_mesh wave;
static stp_coded_mesh coded;

/// A sheet of clusters in several places: in the middle of the picture, beside it, and far away.
static void add_sheets(made_picture* p)
{
    made_scene* s = &p->scene;
    if (!made_mesh_create(MADE_WAVE, SIDE, MADE_NORMALS, &wave)) {
        return;
    }
    stp_store_mesh mesh = made_mesh_view(&wave);
    if (stp_clusters_encode(p->context, &mesh, 1.0 / 1024, &coded) != STP_OK) {
        return;
    }
    mesh.bounds = coded.bounds;
    stp_vec3d low = stp_to_double(coded.bounds.min), high = stp_to_double(coded.bounds.max);
    double scale = 2.0 / (high.x - low.x);
    made_picture_add(p, 0.0, (stp_vec3d){0, 0, 0}, NULL);
    s->meshes[0] = mesh;
    s->nodes[0].triangle_count = mesh.triangle_count;
    s->nodes[0].bounds = (stp_boxd){low, high};
    s->coded_meshes = &coded;
    for (int i = 0; i < ITEMS; ++i) {
        stp_affine m = stp_affine_identity();
        for (int k = 0; k < 3; ++k) {
            m.m[k][k] = scale;
        }
        m.m[0][3] = -scale * low.x + 1.1 * (i % 3) - 2.4;
        m.m[1][3] = -scale * low.y + 0.9 * (i / 3) - 2.0;
        m.m[2][3] = -scale * low.z - 0.7 * i;
        s->edges[i] = (stp_store_edge){0, m};
    }
    s->edge_count = ITEMS;
}

static bool begin(test_state* test, made_gl* m, void (*add)(made_picture* p))
{
    wave = (made_mesh){0};
    coded = (stp_coded_mesh){0};
    return made_gl_begin_or_skip(test, m, add, NULL, NULL);
}

/// Compares the shares of all clusters with those computed one by one. @return how many are drawn
static uint32_t compare_shares(test_state* test, made_gl* m)
{
    stp_gl_renderer* r = (stp_gl_renderer*)m->renderer;
    stp_box box = coded.bounds;
    const float offset[3] = {0.5f * (box.min.x + box.max.x), 0.5f * (box.min.y + box.max.y),
                             0.5f * (box.min.z + box.max.z)};
    uint32_t drawn = 0;
    r->frame.shares.next = 0;
    for (size_t i = 0; i < m->picture.list.count; ++i) {
        const stp_draw_item* item = &m->picture.list.items[i];
        const float* shares = stp_gl_cluster_shares_get(&r->frame.shares, i);
        stp_clusters clusters;
        stp_placed_item placed;
        CHECK(item->kind == STP_DRAW_MESH);
        CHECK_EQUAL(STP_OK, stp_store_get_clusters(m->picture.store, item->index, &clusters));
        stp_placement_place(&r->placement, item, offset, &placed);
        stp_bounding bounding = stp_bounding_make((const float(*)[4])placed.camera.matrix.m,
                                                  placed.camera.nearness_limit, offset,
                                                  r->target.width, r->target.height);
        for (uint32_t c = 0; c < clusters.cluster_count; ++c) {
            stp_box bounds = stp_clusters_bounds(&clusters, c);
            float share = stp_draw_share(item, stp_bounding_min_depth(&bounding, bounds));
            bool shown = share > 0.0f && !stp_bounding_misses(&bounding, bounds);
            CHECK(shares[c] == (shown ? share : 0.0f));
            drawn += shown;
        }
    }
    return drawn;
}

static void compare(test_state* test, made_gl* m)
{
    CHECK_EQUAL(STP_OK, made_picture_draw(&m->picture));
    uint64_t covered = m->picture.stats.covered_pixels, triangles = m->picture.stats.triangles;
    CHECK(covered > 100 && triangles > 1000);
    CHECK_EQUAL(STP_OK, made_gl_draw(m));
    uint64_t more = m->picture.stats.covered_pixels;
    CHECK(more + 8 >= covered && covered + 8 >= more);
    CHECK(made_count_different(m->pixels, m->picture.pixels, 6) <=
          PICTURE_SIDE * PICTURE_SIDE / 50);
    uint32_t drawn = compare_shares(test, m);
    CHECK(drawn > 20 && drawn < ITEMS * coded.cluster_count - 20);
}

void test_gl_clusters_of_many_items(test_state* test)
{
    made_gl m;
    if (!begin(test, &m, add_sheets)) {
        return;
    }
    CHECK(ITEMS * coded.cluster_count > SHARED_FROM);
    // Each view leaves out other clusters than the one before it: shares of an earlier frame would
    // show.
    for (int i = 0; i < 4; ++i) {
        m.picture.view.eye = (stp_vec3d){i % 2 == 0 ? -1.5 : 1.5, i < 2 ? -1.5 : 1.2, 3.0};
        m.picture.view.target = (stp_vec3d){m.picture.view.eye.x, m.picture.view.eye.y, 0.0};
        compare(test, &m);
    }
    stp_coded_mesh_destroy(m.picture.context, &coded);
    made_gl_end(&m);
    made_mesh_destroy(&wave);
}

/// A mesh of columns that takes more than two batches of words, above a small one, which comes first.
static void add_large(made_picture* p)
{
    enum { LARGE_SIDE = 300 };
    made_scene* s = &p->scene;
    if (!made_mesh_create(MADE_WAVE, LARGE_SIDE, MADE_NORMALS, &wave)) {
        return;
    }
    stp_store_mesh mesh = made_mesh_view(&wave);
    stp_box box = stp_box_of(wave.positions, wave.vertex_count);
    mesh.bounds = box;
    const stp_boxd bounds = {stp_to_double(box.min), stp_to_double(box.max)};
    double size = bounds.max.x - bounds.min.x;
    p->view.target = stp_scaled(stp_addd(bounds.min, bounds.max), 0.5);
    stp_vec3d below = p->view.target;
    below.z -= 100.0 * (size + 1.0);
    made_picture_add(p, 0.0, below, NULL);
    made_picture_add(p, 0.0, (stp_vec3d){0, 0, 0}, NULL);
    s->meshes[1] = mesh;
    s->nodes[1].triangle_count = mesh.triangle_count;
    s->nodes[1].bounds = bounds;
    p->view.eye = p->view.target;
    p->view.eye.z += 0.5 * size;
}

void test_gl_meshes_larger_than_a_batch_are_whole(test_state* test)
{
    made_gl m;
    if (!begin(test, &m, add_large)) {
        return;
    }
    m.picture.quality.splat_size = 0;
    CHECK_EQUAL(STP_OK, made_picture_draw(&m.picture));
    uint64_t covered = m.picture.stats.covered_pixels;
    CHECK(covered > PICTURE_SIDE * PICTURE_SIDE / 4);
    CHECK_EQUAL(STP_OK, made_gl_draw(&m));
    CHECK_EQUAL(2, m.picture.list.count);
    CHECK_EQUAL(0, m.picture.list.items[0].index); // it begins the first batch
    CHECK(stp_draw_gl_get_stats(m.renderer).uploaded_bytes > 8 * (uint64_t)POOL_PART_WORDS);
    CHECK(m.picture.stats.covered_pixels + 8 >= covered);
    CHECK(m.picture.stats.covered_pixels <= covered + 8);
    CHECK(made_count_different(m.pixels, m.picture.pixels, 6) <= PICTURE_SIDE * PICTURE_SIDE / 50);
    made_gl_end(&m);
    made_mesh_destroy(&wave);
}

static void write_nothing(const stp_gl_source* source, const stp_gl_piece* piece, uint32_t* words)
{
    (void)source;
    memset(words, 0, piece->words * sizeof(*words));
}

// A file that is overwritten during an upload may have more or fewer words than announced.
void test_gl_uploads_of_other_sizes_are_refused(test_state* test)
{
    made_gl m;
    if (!begin(test, &m, add_large)) {
        return;
    }
    stp_gl_renderer* r = (stp_gl_renderer*)m.renderer;
    const uint32_t entry = r->entries.meshes;
    for (uint32_t words = 9; words <= 11; ++words) {
        stp_gl_conversions* c = &r->conversions;
        const stp_gl_piece piece = {.convert = write_nothing, .end = 1, .words = words};
        CHECK(stp_gl_pool_take(&r->pool, entry, 10));
        CHECK(stp_gl_conversions_begin(c, &r->pool, entry, 10) != NULL);
        stp_result result = stp_gl_conversions_add(c, &r->pool, piece);
        CHECK_EQUAL(words > 10 ? STP_ERROR_FORMAT : STP_OK, result);
        if (words <= 10) {
            CHECK_EQUAL(words < 10 ? STP_ERROR_FORMAT : STP_OK,
                        stp_gl_conversions_end(c, &r->pool));
        }
        stp_gl_conversions_drop(c, &r->pool);
        CHECK(!stp_gl_pool_has(&r->pool, entry));
    }
    CHECK_EQUAL(STP_OK, made_gl_draw(&m)); // nothing of them is left
    made_gl_end(&m);
    made_mesh_destroy(&wave);
}
