// SPDX-License-Identifier: MIT
#include "program/files/splat_store.h"

#include "base/splats/coverage.h"
#include "base/splats/octahedral.h"
#include "lod/psp/forest.h"
#include "lod/set_columns.h"
#include "program/files/point_file.h"
#include "store/writer/writer.h"

#include <assert.h>
#include <limits.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

enum { GRID_STEPS = 65535 };

typedef struct store_maker {
    stp_context* context;
    const tool_splats* splats;
    char up;
    stp_vec3d origin;      ///< position of the node in the scene, along the scene's axes
    stp_boxd bounds, room; ///< bounding boxes of the ellipses and of their centres
    stp_shape_directions directions;
    stp_splats set;
} store_maker;

/// An ellipse along the axes of the scene, less the origin.
typedef struct scene_ellipse {
    stp_vec3d center, normal, larger, smaller;
} scene_ellipse;

static scene_ellipse turn_ellipse(const store_maker* m, uint32_t i)
{
    const stp_ellipse* e = &m->splats->ellipses[m->splats->indices[i]];
    stp_vec3d normal = stp_to_double(e->normal), major = stp_to_double(e->major);
    stp_vec3d across = stp_normalized(stp_crossd(normal, major));
    return (scene_ellipse){tool_scene_axes(m->up, stp_to_double(e->center)),
                           tool_scene_axes(m->up, normal), tool_scene_axes(m->up, major),
                           tool_scene_axes(m->up, stp_scaled(across, (double)e->minor))};
}

static void measure_splats(store_maker* m)
{
    m->bounds = m->room = stp_boxd_empty();
    for (uint32_t i = 0; i < m->splats->count; ++i) {
        scene_ellipse e = turn_ellipse(m, i);
        stp_vec3d u = e.larger, v = e.smaller;
        stp_vec3d reach = {sqrt(u.x * u.x + v.x * v.x), sqrt(u.y * u.y + v.y * v.y),
                           sqrt(u.z * u.z + v.z * v.z)};
        stp_boxd_add(&m->room, e.center);
        stp_boxd_add(&m->bounds, stp_subd(e.center, reach));
        stp_boxd_add(&m->bounds, stp_addd(e.center, reach));
    }
}

// A power of two with which all centres fit on the grid, and radii are at most 2^29 steps, so that
// they can be represented.
static float choose_step(const store_maker* m)
{
    stp_vec3d size = stp_subd(m->room.max, m->room.min);
    stp_vec3d whole = stp_subd(m->bounds.max, m->bounds.min);
    double minimum = fmax(size.x, fmax(size.y, size.z)) / (double)(GRID_STEPS - 1);
    minimum = fmax(minimum, fmax(whole.x, fmax(whole.y, whole.z)) * 0x1p-28);
    int exponent = 0;
    (void)frexp(fmax(minimum, 0x1p-100), &exponent);
    return (float)ldexp(1.0, exponent);
}

static void fill_splats(size_t begin, size_t end, uint32_t worker, void* user)
{
    (void)worker;
    const store_maker* m = user;
    const stp_splats* set = &m->set;
    for (size_t i = begin; i < end; ++i) {
        scene_ellipse e = turn_ellipse(m, (uint32_t)i);
        set->positions[3 * i] = stp_splats_grid_place((float)e.center.x, set->origin.x, set->step);
        set->positions[3 * i + 1] =
            stp_splats_grid_place((float)e.center.y, set->origin.y, set->step);
        set->positions[3 * i + 2] =
            stp_splats_grid_place((float)e.center.z, set->origin.z, set->step);
        stp_octahedral_encode(stp_to_float(e.normal), set->normals + 2 * i);
        double step = (double)set->step;
        set->shapes[i] =
            stp_shape_of_ellipse(&m->directions, (float)(sqrt(stp_dotd(e.larger, e.larger)) / step),
                                 (float)(sqrt(stp_dotd(e.smaller, e.smaller)) / step),
                                 stp_to_float(e.larger), set->normals + 2 * i);
        set->ranges[i] = m->splats->ranges != NULL ? m->splats->ranges[i] : (uint32_t)STP_RANGE_ANY;
        size_t splat = m->splats->indices[i];
        set->materials[i] = m->splats->materials != NULL ? m->splats->materials[splat] : 0;
        set->coverages[i] =
            m->splats->coverages != NULL ? m->splats->coverages[splat] : STP_COVERAGE_WHOLE;
        static const uint8_t white[3] = {255, 255, 255};
        memcpy(set->colors + 3 * i,
               m->splats->colors != NULL ? m->splats->colors + 3 * splat : white, 3);
    }
}

/// Octaves and prefix table: one octave of all splats, or octaves of which views of any size need the
/// base set.
static void divide_set(store_maker* m)
{
    stp_splats* s = &m->set;
    uint32_t base = m->splats->ranges != NULL ? m->splats->base : s->count;
    assert(base > 0 && base <= s->count);
    if (base == s->count) {
        s->octave_count = 1;
        s->octave_ends[0] = s->count;
        s->table = (stp_prefix_table){.size = 1, .count = {s->count}};
        return;
    }
    stp_set_octaves_make(s);
    s->table = (stp_prefix_table){
        .size = 2, .count = {base, s->count}, .radius = {STP_PSP_RANK_MAX, 0.0f}};
}

static stp_result make_set(store_maker* m)
{
    stp_splats* s = &m->set;
    size_t count = m->splats->count;
    *s = (stp_splats){.count = m->splats->count,
                      .columns = STP_SPLATS_SHAPES | STP_SPLATS_RANGES | STP_SPLATS_FLAT_COLORS};
    s->step = choose_step(m);
    assert((double)s->step * GRID_STEPS >= m->room.max.x - m->room.min.x &&
           (double)s->step * GRID_STEPS >= m->room.max.y - m->room.min.y &&
           (double)s->step * GRID_STEPS >= m->room.max.z - m->room.min.z);
    s->origin = stp_to_float(m->room.min);
    stp_result result = stp_splats_make_columns(m->context, s);
    if (result != STP_OK) {
        return result;
    }
    divide_set(m);
    stp_shape_directions_make(&m->directions);
    stp_parallel_for(m->context, count, 4096, fill_splats, m);
    return STP_OK;
}

static stp_result write_set(const store_maker* m, const char* path)
{
    static const stp_shading plain = {.roughness = 1.0f, .flags = STP_SHADING_DOUBLE_SIDED};
    const stp_shading* shadings = m->splats->shadings;
    stp_affine placed = stp_affine_identity();
    placed.m[0][3] = m->origin.x;
    placed.m[1][3] = m->origin.y;
    placed.m[2][3] = m->origin.z;
    const stp_store_edge edge = {.node = 0, .transform = placed};
    const stp_store_node nodes[2] = {
        {.set = 0, .bounds = m->bounds},
        {.set = STP_STORE_NONE, .edge_count = 1, .bounds = stp_affine_box(&placed, m->bounds)},
    };
    const stp_store_object object = {
        .name = "splats", .parent = STP_STORE_NONE, .node = 1, .transform = stp_affine_identity()};
    const stp_store_method method = {
        .name = "psp", .id = STP_METHOD_PSP, .columns = m->set.columns, .set_count = 1};
    const stp_store_content content = {
        .directory = {.node_count = 2,
                      .edge_count = 1,
                      .object_count = 1,
                      .shading_count = shadings != NULL ? m->splats->shading_count : 1,
                      .set_count = 1,
                      .method_count = 1,
                      .nodes = nodes,
                      .edges = &edge,
                      .objects = &object,
                      .shadings = shadings != NULL ? shadings : &plain,
                      .methods = &method,
                      .root = 1,
                      .up = m->up,
                      .build_json = "{\"method\":\"psp\"}"},
        .sets = &m->set};
    return stp_store_write(m->context, &content, path);
}

static stp_result write_splat_store(stp_context* context, const char* path,
                                    const tool_splats* splats, char up)
{
    store_maker m = {.context = context, .splats = splats, .up = up};
    const double* o = splats->origin;
    m.origin = tool_scene_axes(up, (stp_vec3d){o[0], o[1], o[2]});
    if (splats->count == 0) {
        return stp_fail(context, STP_ERROR_ARGUMENT, "%s: there are no splats to write", path);
    }
    measure_splats(&m);
    stp_result result = make_set(&m);
    result = result == STP_OK ? write_set(&m, path) : result;
    stp_splats_destroy(context, &m.set);
    return result;
}

stp_result tool_write_any_splats(stp_context* context, const char* path, const tool_splats* splats,
                                 char up)
{
    size_t length = strlen(path);
    bool store = length > 5 && strcmp(path + length - 5, ".stip") == 0;
    return store ? write_splat_store(context, path, splats, up)
                 : tool_write_splats(context, path, splats);
}

stp_result tool_open_splat_store(stp_context* context, const tool_splats* splats, char up,
                                 stp_store** store)
{
    char path[PATH_MAX];
    const char* folder = getenv("TMPDIR");
    snprintf(path, sizeof(path), "%s/stipple-splats-XXXXXX",
             folder != NULL && folder[0] != '\0' ? folder : "/tmp");
    int descriptor = mkstemp(path);
    if (descriptor < 0) {
        return stp_fail(context, STP_ERROR_IO, "%s: cannot be created", path);
    }
    stp_result result = write_splat_store(context, path, splats, up);
    result = result == STP_OK ? stp_store_open(context, path, store) : result;
    (void)unlink(path);
    (void)close(descriptor);
    return result;
}
