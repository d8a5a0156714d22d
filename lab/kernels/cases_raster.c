// SPDX-License-Identifier: MIT
// Triangles, and splats of a ball, drawn in perspective.
#include "base/splats/octahedral.h"
#include "base/splats/splat_codes.h"
#include "lab/kernels/kernel_cases.h"
#include "raster/splats_blend.h"
#include "raster/triangles.h"

#include <float.h>

enum { SIDE = 512, PIXELS = SIDE * SIDE, SPLATS = 1 << 15, TRIANGLES = 1 << 14 };
enum { SHIFT = 3, COLUMNS = SIDE >> SHIFT, BLOCKS = COLUMNS * COLUMNS };

#define FOCAL 600.0f
#define DISTANCE 3.0f
#define NEAR 0.01f
#define GRID_STEP (1.0f / 30000.0f)

typedef struct raster_input {
    uint16_t positions[3 * SPLATS];
    int8_t normals[2 * SPLATS];
    uint32_t ranges[SPLATS], errors[SPLATS];
    float windows[BLOCKS];
    stp_raster_splats splats;
    stp_raster_occluder occluder;
    float corners[9 * TRIANGLES];
    uint32_t indices[3 * TRIANGLES];
} raster_input;

static const stp_raster_camera camera = {
    .matrix = {{{FOCAL, 0, 0.5f * SIDE, 0.5f * SIDE* DISTANCE},
                {0, FOCAL, 0.5f * SIDE, 0.5f * SIDE* DISTANCE},
                {0, 0, 0, NEAR},
                {0, 0, 1, DISTANCE}}},
    .view = {{1, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, 1, DISTANCE}},
    .pixel_scale = FOCAL,
    .nearness_limit = 1.0f,
};

static void place_splat(raster_input* in, uint32_t i)
{
    stp_vec3 n = {kernel_random(1, 3 * i, -1, 1), kernel_random(1, 3 * i + 1, -1, 1),
                  kernel_random(1, 3 * i + 2, -1, 1)};
    n = stp_normalize(n);
    const float p[3] = {n.x, n.y, n.z};
    for (size_t k = 0; k < 3; ++k) {
        in->positions[3 * (size_t)i + k] = (uint16_t)(32768.0f + 30000.0f * p[k]);
    }
    stp_octahedral_encode(n, in->normals + 2 * (size_t)i);
}

static raster_input* make_splats(kernel_case* c)
{
    raster_input* in = stp_arena_alloc(c->arena, sizeof(*in));
    if (in == NULL) {
        return NULL;
    }
    memset(in, 0, sizeof(*in));
    for (uint32_t i = 0; i < SPLATS; ++i) {
        place_splat(in, i);
    }
    const float low = -32768.0f * GRID_STEP;
    in->splats = (stp_raster_splats){.positions = in->positions,
                                     .normals = in->normals,
                                     .end = SPLATS,
                                     .origin = {low, low, low},
                                     .step = GRID_STEP,
                                     .radius = 0.008f,
                                     .rim_depth = 4.0f,
                                     .back_depth = 2.0f};
    c->input = in;
    return in;
}

static bool set_picture(kernel_case* c, uint64_t elements)
{
    return kernel_set_output(c, PIXELS * sizeof(uint64_t), elements);
}

bool kernel_make_disk_splats(kernel_case* c)
{
    return make_splats(c) != NULL && set_picture(c, SPLATS);
}

bool kernel_make_square_splats(kernel_case* c)
{
    raster_input* in = make_splats(c);
    if (in != NULL) {
        in->splats.squares = true;
    }
    return in != NULL && set_picture(c, SPLATS);
}

void kernel_run_splats(kernel_case* c)
{
    const raster_input* in = c->input;
    const stp_raster_target target = {SIDE, SIDE, SIDE, c->output};
    stp_raster_draw_splats(&target, 0, SIDE, &camera, &in->splats, 0);
}

/// Blocks at random depths in front of the ball, within it or behind it.
bool kernel_make_hidden(kernel_case* c)
{
    raster_input* in = make_splats(c);
    if (in == NULL) {
        return false;
    }
    for (uint32_t i = 0; i < BLOCKS; ++i) {
        in->windows[i] = NEAR / kernel_random(2, i, 1.5f, 4.5f);
    }
    in->occluder = (stp_raster_occluder){.windows = in->windows,
                                         .columns = COLUMNS,
                                         .shift = SHIFT,
                                         .width = SIDE,
                                         .height = SIDE,
                                         .pixel_scale = FOCAL,
                                         .scale = 1.0f,
                                         .corner = 1.3f,
                                         .near_distance = NEAR,
                                         .behind = 1.00001f,
                                         .apart = 1.0f};
    for (int k = 0; k < 3; ++k) {
        memcpy(in->occluder.matrix[k], camera.matrix.m[k == 2 ? 3 : k], sizeof(float[4]));
    }
    in->splats.occluder = &in->occluder;
    return kernel_set_output(c, SPLATS / 8, SPLATS);
}

void kernel_run_hidden(kernel_case* c)
{
    const raster_input* in = c->input;
    stp_raster_test_splats(&in->splats, c->output);
}

bool kernel_make_levels(kernel_case* c)
{
    raster_input* in = make_splats(c);
    for (uint32_t i = 0; in != NULL && i < SPLATS; ++i) {
        float lowest = kernel_random(3, 2 * i, 0.0f, 0.04f);
        in->ranges[i] = stp_range_code(lowest, lowest + kernel_random(3, 2 * i + 1, 0.0f, 0.02f));
        in->errors[i] = (uint32_t)kernel_random(4, i, 0.0f, 65536.0f) |
                        (uint32_t)(uint8_t)in->normals[2 * i] << 16 |
                        (uint32_t)(uint8_t)in->normals[2 * i + 1] << 24;
    }
    return in != NULL && kernel_set_output(c, SPLATS / 8, SPLATS);
}

void kernel_run_levels(kernel_case* c)
{
    const raster_input* in = c->input;
    const stp_raster_levels levels = {.per_depth = 0.01f};
    stp_raster_pick_levels(&camera, &in->splats, in->ranges, &levels, c->output);
}

void kernel_run_split_levels(kernel_case* c)
{
    const raster_input* in = c->input;
    const stp_raster_levels levels = {.per_depth = 0.01f, .errors = in->errors};
    stp_raster_pick_levels(&camera, &in->splats, in->ranges, &levels, c->output);
}

/// Planes and sums of each pixel: the output.
typedef struct blended_picture {
    stp_raster_plane planes[PIXELS];
    _Atomic uint64_t sums[2 * PIXELS];
} blended_picture;

typedef struct blend_input {
    const raster_input* scene;
    stp_raster_plane visible[PIXELS];
    uint64_t pixels[PIXELS];
} blend_input;

bool kernel_make_blend(kernel_case* c)
{
    const raster_input* scene = make_splats(c);
    blend_input* in = stp_arena_alloc(c->arena, sizeof(*in));
    if (scene == NULL || in == NULL) {
        return false;
    }
    in->scene = scene;
    c->input = in;
    const stp_raster_target target = {SIDE, SIDE, SIDE, in->pixels};
    memset(in->pixels, 0xFF, sizeof(in->pixels));
    stp_raster_draw_splats(&target, 0, SIDE, &camera, &scene->splats, 0);
    for (int i = 0; i < PIXELS; ++i) {
        in->visible[i] =
            (stp_raster_plane){.id = stp_raster_id(in->pixels[i]), .nearness = FLT_MAX};
    }
    return kernel_set_output(c, sizeof(blended_picture), SPLATS);
}

void kernel_reset_blend(kernel_case* c)
{
    const blend_input* in = c->input;
    blended_picture* picture = c->output;
    memset(picture, 0, sizeof(*picture));
    memcpy(picture->planes, in->visible, sizeof(in->visible));
}

static void color_splats(void* user, uint32_t first, uint32_t count, const float* x, const float* y,
                         uint32_t (*out)[3])
{
    (void)user, (void)x, (void)y;
    for (uint32_t i = 0; i < count; ++i) {
        for (uint32_t k = 0; k < 3; ++k) {
            out[i][k] = (first + i) * (2 * k + 1) % STP_BLEND_COLORS;
        }
    }
}

void kernel_run_blend(kernel_case* c)
{
    const blend_input* in = c->input;
    blended_picture* picture = c->output;
    const stp_raster_blend blend = {.width = SIDE,
                                    .height = SIDE,
                                    .planes = picture->planes,
                                    .sums = picture->sums,
                                    .colors = color_splats};
    stp_raster_find_planes(&blend, &camera, &in->scene->splats);
    stp_raster_blend_splats(&blend, &camera, &in->scene->splats);
}

/// Triangles of a few pixels.
bool kernel_make_triangles(kernel_case* c)
{
    raster_input* in = stp_arena_alloc(c->arena, sizeof(*in));
    if (in == NULL) {
        return false;
    }
    for (uint32_t i = 0; i < 3 * TRIANGLES; ++i) {
        uint32_t t = i / 3;
        float x = kernel_random(4, 3 * t, -250.0f, 250.0f) + kernel_random(5, 3 * i, -4.0f, 4.0f);
        float y =
            kernel_random(4, 3 * t + 1, -250.0f, 250.0f) + kernel_random(5, 3 * i + 1, -4.0f, 4.0f);
        float depth =
            kernel_random(4, 3 * t + 2, 2.0f, 4.0f) + kernel_random(5, 3 * i + 2, 0.0f, 0.01f);
        float* p = in->corners + 3 * (size_t)i;
        p[0] = x * depth / FOCAL;
        p[1] = y * depth / FOCAL;
        p[2] = depth - DISTANCE;
        in->indices[i] = i;
    }
    c->input = in;
    return set_picture(c, TRIANGLES);
}

void kernel_run_triangles(kernel_case* c)
{
    const raster_input* in = c->input;
    const stp_raster_target target = {SIDE, SIDE, SIDE, c->output};
    const stp_raster_mesh mesh = {.positions = in->corners,
                                  .vertex_count = 3 * TRIANGLES,
                                  .indices = in->indices,
                                  .triangle_count = TRIANGLES};
    if (stp_raster_triangles(&target, 0, SIDE, &camera.matrix, 1.0f, &mesh, 0, c->arena) !=
        STP_OK) {
        memset(c->output, 0, c->output_bytes); // differs from the other variants
    }
}
