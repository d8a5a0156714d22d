// SPDX-License-Identifier: MIT
// Garland, Heckbert. Surface Simplification Using Quadric Error Metrics. 1997: the reference for
// splats in Figure 9 of the paper, at an equal number of vertices.
#include "lab/decimate/contraction.h"
#include "lab/decimate/point_disks.h"
#include "lod/levels/collapse.h"

#include <string.h>

static const double border_weight = 1.0, least_cosine = 0.2;

/// Writes the used vertices, numbered in the order of their positions.
static stp_result write(stp_context* context, const stp_distinct* distinct,
                        const stp_collapse_mesh* mesh, stp_decimate_output* output)
{
    size_t corners = 3 * (size_t)mesh->triangle_count;
    uint32_t* numbers = STP_NEW_ZEROED(context, uint32_t, (size_t)mesh->vertex_count + 1);
    uint32_t used = 0;
    for (size_t i = 0; i < corners && numbers != NULL; ++i) {
        used += numbers[mesh->indices[i]] == 0 ? 1 : 0;
        numbers[mesh->indices[i]] = 1;
    }
    output->vertices = STP_NEW_ARRAY(context, float, 3 * (size_t)used + 1);
    output->colors = STP_NEW_ARRAY(context, uint8_t, 3 * (size_t)used + 1);
    output->triangles = STP_NEW_ARRAY(context, uint32_t, corners + 1);
    if (numbers == NULL || output->vertices == NULL || output->colors == NULL ||
        output->triangles == NULL) {
        stp_free(context, numbers);
        return stp_fail_memory(context);
    }
    size_t next = 0;
    for (size_t i = 0; i < mesh->vertex_count; ++i) {
        if (numbers[i] != 0) {
            memcpy(output->vertices + 3 * next, mesh->positions + 3 * i, 3 * sizeof(float));
            stp_color_mean_write(&distinct->means[i], output->colors + 3 * next);
            numbers[i] = (uint32_t)next++;
        }
    }
    for (size_t i = 0; i < corners; ++i) {
        output->triangles[i] = numbers[mesh->indices[i]];
    }
    output->vertex_count = used;
    output->triangle_count = mesh->triangle_count;
    stp_free(context, numbers);
    return STP_OK;
}

stp_result stp_decimate_by_mesh(stp_context* context, const stp_decimate_input* input,
                                uint32_t target, stp_decimate_output* output)
{
    *output = (stp_decimate_output){0};
    stp_result result = stp_decimate_check(context, input);
    if (result == STP_OK && input->triangles == NULL) {
        result = stp_fail(context, STP_ERROR_ARGUMENT,
                          "mesh simplification: expected triangles, found points alone");
    }
    stp_distinct distinct = {0};
    uint32_t* indices = NULL;
    if (result == STP_OK) {
        result = stp_distinct_make(context, input, &distinct);
        indices = STP_NEW_ARRAY(context, uint32_t, 3 * (size_t)input->triangle_count + 1);
    }
    if (result == STP_OK && indices == NULL) {
        result = stp_fail_memory(context);
    }
    if (result == STP_OK) {
        stp_collapse_mesh mesh = {.vertex_count = distinct.count,
                                  .triangle_count = stp_distinct_weld(
                                      &distinct, input->triangles, input->triangle_count, indices),
                                  .positions = distinct.positions,
                                  .indices = indices};
        stp_collapse_desc desc = {.vertex_target = target,
                                  .error_limit = HUGE_VAL,
                                  .border_weight = border_weight,
                                  .least_cosine = least_cosine};
        double error;
        result = stp_collapse(context, &mesh, &desc, &error);
        result = result == STP_OK ? write(context, &distinct, &mesh, output) : result;
    }
    stp_free(context, indices);
    stp_distinct_destroy(context, &distinct);
    return result;
}
