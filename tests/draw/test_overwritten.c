// SPDX-License-Identifier: MIT
// A mapped file is overwritten while it is drawn: with any content, nothing is read or written
// out of bounds, and all calls return. The pictures are undefined.
#include "exhaustive.h"
#include "support_store.h"
#include "tests.h"

#include "base/math/position_grid.h"
#include "base/math/rng.h"
#include "draw/draw.h"
#include "select/pick_ray.h"
#include "store/clusters/clusters.h"
#include "store/support_mesh.h"

#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

enum { SIDE = 32, TEXELS = 4 * 16 * 16, POINTS = 40 };

typedef struct overwritten {
    stp_context* context;
    stp_store* store;
    stp_renderer* renderer;
    made_mesh mesh;
    stp_coded_mesh coded[2];
    stp_splats splats;
    uint8_t texels[TEXELS], pixels[4 * SIDE * SIDE];
    float points[3 * POINTS];
    int file;
    unsigned char* bytes; ///< as they were written
    size_t size;
    stp_view view;
} overwritten;

static void fill_scene(overwritten* o, made_scene* s, bool coded)
{
    stp_store_mesh mesh = made_mesh_view(&o->mesh);
    mesh.bounds = (stp_box){{-1, -1, -1}, {1, 1, 1}};
    *s = (made_scene){.material_count = 1,
                      .shading_count = 1,
                      .texture_count = 1,
                      .mesh_count = 2,
                      .point_set_count = 1,
                      .set_count = 1,
                      .part_count = 3,
                      .node_count = 3,
                      .edge_count = 2};
    s->materials[0] = made_material();
    s->materials[0].alpha = STP_STORE_MASK;
    s->materials[0].base_color_texture.texture = 0;
    s->shadings[0] = (stp_shading){.roughness = 0.5f};
    s->textures[0] = (stp_store_texture){.width = 16, .height = 16, .texels = o->texels};
    s->meshes[0] = s->meshes[1] = mesh;
    s->coded_meshes = coded ? o->coded : NULL;
    s->point_sets[0] = (stp_store_point_set){
        .point_count = POINTS, .bounds = {{-1, -1, -1}, {1, 1, 1}}, .positions = o->points};
    s->sets[0] = o->splats;
    s->parts[0] = (stp_store_part){STP_STORE_PART_MESH, 0};
    s->parts[1] = (stp_store_part){STP_STORE_PART_POINTS, 0};
    s->parts[2] = (stp_store_part){STP_STORE_PART_MESH, 1};
    stp_boxd box = {{-1, -1, -1}, {1, 1, 1}};
    s->nodes[0] = (stp_store_node){.part_count = 2,
                                   .set = STP_STORE_NONE,
                                   .triangle_count = mesh.triangle_count,
                                   .point_count = POINTS,
                                   .bounds = box};
    s->nodes[1] = (stp_store_node){.first_part = 2,
                                   .part_count = 1,
                                   .set = 0,
                                   .triangle_count = mesh.triangle_count,
                                   .bounds = box};
    for (uint32_t i = 0; i < 2; ++i) {
        s->edges[i] = (stp_store_edge){i, stp_affine_identity()};
        s->edges[i].transform.m[0][3] = i == 0 ? -1.2 : 1.2;
    }
    s->nodes[2] = (stp_store_node){.first_part = 3,
                                   .edge_count = 2,
                                   .set = STP_STORE_NONE,
                                   .triangle_count = 2 * (uint64_t)mesh.triangle_count,
                                   .point_count = POINTS,
                                   .bounds = {{-2.2, -1, -1}, {2.2, 1, 1}}};
}

static bool begin(overwritten* o, bool coded)
{
    static const uint8_t color[3] = {90, 120, 200};
    const unsigned attributes = MADE_NORMALS | MADE_TEXCOORDS | MADE_COLORS;
    *o = (overwritten){.context = test_context(NULL, 1, NULL), .file = -1};
    if (o->context == NULL || !made_mesh_create(MADE_BOXES, coded ? 12 : 5, attributes, &o->mesh)) {
        return false;
    }
    stp_store_mesh mesh = made_mesh_view(&o->mesh);
    double step = stp_choose_grid_step(mesh.positions, mesh.indices, mesh.triangle_count);
    for (int i = 0; i < 2 && coded; ++i) {
        if (stp_clusters_encode(o->context, &mesh, step, &o->coded[i]) != STP_OK) {
            return false;
        }
    }
    for (size_t i = 0; i < TEXELS; ++i) {
        o->texels[i] = (uint8_t)(i * 7);
    }
    for (uint32_t i = 0; i < 3 * POINTS; ++i) {
        o->points[i] = (float)(i % 17) / 8.5f - 1.0f;
    }
    o->splats = made_square_set(o->context, 4, color);
    made_scene scene;
    fill_scene(o, &scene, coded);
    o->store = made_open_file(o->context, &scene, &o->file);
    struct stat stat;
    if (o->store == NULL || o->file < 0 || fstat(o->file, &stat) != 0) {
        return false;
    }
    o->size = (size_t)stat.st_size;
    o->bytes = malloc(o->size);
    o->view = (stp_view){
        .eye = {0.3, 0.4, 4}, .up = {0, 1, 0}, .fov_degrees = 60, .width = SIDE, .height = SIDE};
    return o->bytes != NULL && pread(o->file, o->bytes, o->size, 0) == (ssize_t)o->size &&
           stp_draw_cpu_create(o->context, o->store, &o->renderer) == STP_OK;
}

static void end(overwritten* o)
{
    stp_renderer_destroy(o->renderer);
    stp_store_close(o->store);
    made_free_set(o->context, &o->splats);
    stp_coded_mesh_destroy(o->context, &o->coded[0]);
    stp_coded_mesh_destroy(o->context, &o->coded[1]);
    made_mesh_destroy(&o->mesh);
    free(o->bytes);
    close(o->file);
    stp_context_destroy(o->context);
}

/// Splats, triangles, section caps, and a ray. Each may fail.
static bool use(overwritten* o, bool reference, bool sections)
{
    stp_quality quality = {.splat_size = 3, .reference = reference, .early_switch = 1};
    stp_draw_style style = {.caps = sections};
    stp_draw_list list = {0};
    stp_draw_stats stats;
    stp_view view = o->view;
    stp_image image = {SIDE, SIDE, o->pixels};
    if (sections) {
        view.sections.count = 1;
        view.sections.planes[0].normal = (stp_vec3d){0, 0, 1};
    }
    stp_result result = stp_select(o->context, o->store, &view, &quality, &list);
    if (result == STP_OK) {
        result = stp_renderer_draw(o->renderer, &view, &list, &style, &image, &stats);
    }
    stp_draw_list_destroy(o->context, &list);
    stp_pick pick;
    stp_pick_desc desc = {
        .ray = {.origin = {-1.1, 0.1, 4}, .direction = {0, 0, -1}, .farthest = 100}};
    stp_result picked = stp_pick_ray(o->context, o->store, &desc, &pick);
    return result == STP_OK && picked == STP_OK;
}

/// Overwrites `length` bytes at a time, draws, and restores them. Short pieces: every third.
static bool overwrite(overwritten* o, size_t length, int pattern)
{
    unsigned char other[256];
    size_t stride = length < 256 ? length * test_stride(3) : length;
    for (size_t at = 0; at < o->size; at += stride) {
        size_t count = o->size - at < length ? o->size - at : length;
        for (size_t i = 0; i < count; ++i) {
            uint64_t random = stp_rng_hash(at * 31 + i, length);
            other[i] = pattern >= 0 ? (unsigned char)pattern : (unsigned char)(random >> 32);
        }
        if (pwrite(o->file, other, count, (off_t)at) != (ssize_t)count) {
            return false;
        }
        use(o, at / length % 2 == 0, at / length % 4 == 0);
        if (pwrite(o->file, o->bytes + at, count, (off_t)at) != (ssize_t)count) {
            return false;
        }
    }
    return true;
}

static void overwrite_all(test_state* test, bool coded)
{
    overwritten o;
    CHECK(begin(&o, coded));
    CHECK(use(&o, true, true) && use(&o, false, false)); // all blocks are checked and mapped
    CHECK(overwrite(&o, 1, 0xFF));
    CHECK(overwrite(&o, 4, 0));
    CHECK(overwrite(&o, 4, -1));
    CHECK(overwrite(&o, 256, 0xFF));
    CHECK(overwrite(&o, 256, -1));
    CHECK(use(&o, true, true) && use(&o, false, false)); // as before
    end(&o);
}

void test_files_overwritten_while_drawn(test_state* test)
{
    overwrite_all(test, true);
}

void test_columns_overwritten_while_drawn(test_state* test)
{
    overwrite_all(test, false);
}
