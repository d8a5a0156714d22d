// SPDX-License-Identifier: MIT
// Levels of triangles: OpenGL draws the clusters that suit their depth, as the CPU does.
#include "support_gl.h"
#include "tests.h"

#include "builder/build_scene.h"
#include "draw/gl/gl_renderer.h"
#include "lod/support_level_shapes.h"
#include "scene/scene.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

enum { AROUND = 140, ACROSS = 70 };

/// Two tori: one turned, the other mirrored.
static stp_result generate(stp_scene* scene, const char* name, void* user)
{
    (void)name;
    (void)user;
    stp_mesh mesh = level_torus(scene->context, AROUND, ACROSS, 1.0, 0.4);
    if (mesh.positions == NULL || mesh.indices == NULL) {
        stp_free(scene->context, mesh.positions);
        stp_free(scene->context, mesh.indices);
        return stp_fail_memory(scene->context);
    }
    stp_result result = stp_scene_add_mesh(scene, &mesh, NULL);
    for (int i = 0; i < 2 && result == STP_OK; ++i) {
        stp_object object = {.name = "torus", .parent = STP_NONE};
        object.transform = (stp_affine){{{i == 0 ? 1.0 : -1.0, 0, 0, 0},
                                         {0, 0.6, -0.8, 0},
                                         {0, 0.8, 0.6, i == 0 ? 0.0 : -3.0}}};
        result = stp_scene_add_object(scene, &object, NULL);
        result =
            result == STP_OK ? stp_scene_add_part(scene, (stp_part){STP_PART_MESH, 0}) : result;
    }
    return result;
}

static bool open_tori(made_gl* m)
{
    char folder[64] = "stp_tori_XXXXXX", path[96];
    made_picture* p = &m->picture;
    if (!made_picture_begin(p, NULL, 2) || mkdtemp(folder) == NULL) {
        return false;
    }
    snprintf(path, sizeof(path), "%s/a.stip", folder);
    const char* input = "scene:tori";
    stp_build_desc desc = {.inputs = &input,
                           .input_count = 1,
                           .output = path,
                           .blue = {.capture = {.wanted_candidates = 2000}},
                           .splat_rule = {1e-9, 200},
                           .generate = generate};
    stp_result result = stp_build(p->context, &desc, NULL);
    result = result == STP_OK ? stp_store_open(p->context, path, &p->store) : result;
    unlink(path);
    rmdir(folder);
    result = result == STP_OK ? stp_draw_cpu_create(p->context, p->store, &p->renderer) : result;
    return result == STP_OK && made_gl_renew(m, NULL) == STP_OK;
}

/// What the renderer's shares of clusters hold.
typedef struct share_counts {
    uint32_t levels, drawn, left_out, wrong;
} share_counts;

/// Compares the shares of the levels' clusters with those computed one by one.
static share_counts compare_shares(made_gl* m)
{
    stp_gl_renderer* r = (stp_gl_renderer*)m->renderer;
    const stp_draw_list* list = &m->picture.list;
    share_counts counts = {0};
    r->frame.shares.next = 0;
    for (size_t i = 0; i < list->count; ++i) {
        const stp_draw_item* item = &list->items[i];
        stp_clusters clusters;
        stp_placed_item placed;
        float offset[3];
        if (!item->is_level) {
            continue;
        }
        counts.levels += 1;
        const float* shares = stp_gl_cluster_shares_get(&r->frame.shares, i);
        stp_mesh_offset(r->store, r->directory, item, offset);
        stp_placement_place(&r->placement, item, offset, &placed);
        const float(*rows)[4] = (const float(*)[4])placed.camera.matrix.m;
        stp_bounding bounding = stp_bounding_make(rows, placed.camera.nearness_limit, offset,
                                                  r->target.width, r->target.height);
        stp_level_choice choice = stp_level_choice_make(r->directory, item, rows, offset);
        if (stp_store_get_clusters(r->store, item->index, &clusters) != STP_OK) {
            counts.wrong += 1;
            continue;
        }
        for (uint32_t c = 0; c < clusters.cluster_count; ++c) {
            stp_box box = stp_clusters_bounds(&clusters, c);
            float share = stp_draw_share(item, stp_bounding_min_depth(&bounding, box));
            bool suits = stp_level_choice_draws(&choice, c) &&
                         stp_bounding_max_depth(&bounding, box) >= item->level_from;
            bool shown = suits && share > 0.0f && !stp_bounding_misses(&bounding, box);
            counts.wrong += shares[c] != (shown ? share : 0.0f);
            counts.drawn += shown;
            counts.left_out += !suits;
        }
    }
    return counts;
}

/// Number of pixels whose depths differ by more than a part, or where only one picture has any.
static int count_far(const float* a, const float* b, float part)
{
    int count = 0;
    for (int i = 0; i < PICTURE_SIDE * PICTURE_SIDE; ++i) {
        count += !(fabsf(a[i] - b[i]) <= part * fmaxf(a[i], b[i]));
    }
    return count;
}

/// Draws with both backends. @return what OpenGL draws
static share_counts compare(test_state* test, made_gl* m, double distance, float splat_size)
{
    static float depths[PICTURE_SIDE * PICTURE_SIDE];
    made_picture* p = &m->picture;
    p->view.eye = (stp_vec3d){0.3 * distance, 0.2 * distance, distance};
    p->quality.splat_size = splat_size;
    CHECK_EQUAL(STP_OK, made_picture_draw(p));
    uint64_t covered = p->stats.covered_pixels;
    memcpy(depths, stp_renderer_depth(p->renderer), sizeof(depths));
    CHECK_EQUAL(STP_OK, made_gl_draw(m));
    share_counts counts = compare_shares(m);
    CHECK_EQUAL(0, counts.wrong);
    CHECK(covered > 200 && llabs((long long)(covered - p->stats.covered_pixels)) <= 4);
    CHECK(count_far(depths, stp_renderer_depth(m->renderer), 1e-3f) <= 8);
    CHECK(made_count_different(m->pixels, p->pixels, 6) <= 8);
    return counts;
}

void test_gl_draws_levels_as_the_cpu_does(test_state* test)
{
    const stp_headless_desc wanted = {.debug = true};
    const float sizes[] = {1, 4};
    made_gl m = {.renderer = NULL};
    if (stp_headless_create(&wanted, &m.headless) != NULL) {
        test->skipped = "there is no OpenGL";
        return;
    }
    CHECK(open_tori(&m));
    share_counts all = {0};
    for (int i = 0; i < 2; ++i) {
        for (double distance = 1.5; distance < 10.0; distance *= 1.7) {
            share_counts counts = compare(test, &m, distance, sizes[i]);
            all.levels += counts.levels;
            all.drawn += counts.drawn;
            all.left_out += counts.left_out;
        }
    }
    CHECK(all.levels > 10 && all.drawn > 100 && all.left_out > 100);
    made_gl_end(&m);
}
