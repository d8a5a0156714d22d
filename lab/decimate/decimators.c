// SPDX-License-Identifier: MIT
#include "lab/decimate/decimators.h"

#include "base/core/clock.h"
#include "base/math/math.h"
#include "lab/decimate/decimator.h"
#include "program/files/splat_store.h"
#include "program/options/tool.h"

#include <assert.h>
#include <stdio.h>
#include <string.h>

/// As DECIMATOR_WORDS has them, psp left out.
static const struct {
    const char* name;
    stp_decimate_function run;
} table[] = {
    {"octree", stp_decimate_by_octree},   {"octree-level", stp_decimate_by_octree_level},
    {"quadric", stp_decimate_by_quadric}, {"mesh", stp_decimate_by_mesh},
    {"blue", stp_decimate_by_blue},       {"subsample", stp_decimate_by_subsample},
};

static stp_vec3d vertex_at(const float* vertices, size_t i)
{
    return (stp_vec3d){(double)vertices[3 * i], (double)vertices[3 * i + 1],
                       (double)vertices[3 * i + 2]};
}

static double area_of(const float* vertices, const uint32_t* triangles, uint32_t count)
{
    double sum = 0.0;
    for (size_t i = 0; i < 3 * (size_t)count; i += 3) {
        stp_vec3d a = vertex_at(vertices, triangles[i]);
        stp_vec3d b = stp_subd(vertex_at(vertices, triangles[i + 1]), a);
        stp_vec3d c = stp_subd(vertex_at(vertices, triangles[i + 2]), a);
        stp_vec3d across = stp_crossd(b, c);
        sum += 0.5 * sqrt(stp_dotd(across, across));
    }
    return sum;
}

static int print_report(const tool_decimation* task, const stp_decimate_output* out, double seconds)
{
    const tool_points* points = task->points;
    bool mesh = out->vertices != NULL;
    double area = mesh ? area_of(out->vertices, out->triangles, out->triangle_count) : 0.0;
    for (uint32_t i = 0; i < out->count; ++i) {
        area += (double)stp_ellipse_area(&out->ellipses[i]);
    }
    if (!task->json) {
        if (mesh) {
            printf("%u triangles with %u vertices for %u points, area %.4g, in %.2f s\n",
                   out->triangle_count, out->vertex_count, points->count, area, seconds);
        } else {
            printf("%u splats for %u points, area %.4g, in %.2f s\n", out->count, points->count,
                   area, seconds);
        }
        return 0;
    }
    json_t* json = json_pack("{s:s, s:I, s:I, s:f, s:f}", "by", table[task->by - 1].name, "points",
                             (json_int_t)points->count, "splats", (json_int_t)out->count, "area",
                             area, "seconds", seconds);
    if (mesh) {
        json_object_set_new(json, "vertices", json_integer(out->vertex_count));
        json_object_set_new(json, "triangles", json_integer(out->triangle_count));
    }
    if (points->triangles != NULL) {
        double surface = area_of(points->positions, points->triangles, points->triangle_count);
        json_object_set_new(json, "surface", json_real(surface));
    }
    return tool_print_json(json);
}

static stp_result write_splats(stp_context* context, const tool_decimation* task,
                               const stp_decimate_output* out)
{
    uint32_t* indices = STP_NEW_ARRAY(context, uint32_t, (size_t)out->count + 1);
    if (indices == NULL) {
        return stp_fail_memory(context);
    }
    for (uint32_t i = 0; i < out->count; ++i) {
        indices[i] = i;
    }
    tool_splats splats = {
        .ellipses = out->ellipses, .colors = out->colors, .indices = indices, .count = out->count};
    memcpy(splats.origin, task->points->origin, sizeof(splats.origin));
    stp_result result = tool_write_any_splats(context, task->output, &splats, task->points->up);
    stp_free(context, indices);
    return result;
}

static stp_result write_triangles(stp_context* context, const tool_decimation* task,
                                  const stp_decimate_output* out)
{
    tool_triangles triangles = {.vertices = out->vertices,
                                .colors = out->colors,
                                .triangles = out->triangles,
                                .vertex_count = out->vertex_count,
                                .triangle_count = out->triangle_count};
    memcpy(triangles.origin, task->points->origin, sizeof(triangles.origin));
    return tool_write_triangles(context, task->output, &triangles);
}

int tool_decimate_by(stp_context* context, const tool_decimation* task)
{
    const tool_points* points = task->points;
    assert(task->by >= 1 && (size_t)task->by <= sizeof(table) / sizeof(table[0]));
    const stp_decimate_input input = {.count = points->count,
                                      .positions = points->positions,
                                      .normals = points->normals,
                                      .colors = task->colors,
                                      .triangles = points->triangles,
                                      .triangle_count = points->triangle_count};
    stp_decimate_output out = {0};
    double start = stp_clock_ms();
    stp_result result = table[task->by - 1].run(context, &input, task->target, &out);
    double seconds = 1e-3 * (stp_clock_ms() - start);
    uint32_t count = out.vertices != NULL ? out.vertex_count : out.count;
    if (result == STP_OK && count > task->target) {
        stp_notice(context, "%s: %u %s are left; %u were requested", table[task->by - 1].name,
                   count, out.vertices != NULL ? "vertices" : "splats", task->target);
    }
    if (result == STP_OK) {
        result = out.vertices != NULL ? write_triangles(context, task, &out)
                                      : write_splats(context, task, &out);
    }
    int code = result == STP_OK ? print_report(task, &out, seconds) : 1;
    stp_decimate_output_destroy(context, &out);
    return code;
}
