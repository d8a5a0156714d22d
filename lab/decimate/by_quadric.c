// SPDX-License-Identifier: MIT
#include "lab/decimate/contraction.h"

#include <assert.h>

/// Remaining points, in index order, as a separate input.
typedef struct left_points {
    float *positions, *normals;
    uint32_t* numbers;
} left_points;

static stp_result gather(const stp_contraction* c, left_points* left)
{
    stp_context* context = c->context;
    size_t room = 3 * (size_t)c->left + 1;
    bool normals = c->points->normals != NULL;
    left->positions = STP_NEW_ARRAY(context, float, room);
    left->normals = normals ? STP_NEW_ARRAY(context, float, room) : NULL;
    left->numbers = STP_NEW_ARRAY(context, uint32_t, (size_t)c->left + 1);
    if (left->positions == NULL || left->numbers == NULL || (normals && left->normals == NULL)) {
        return stp_fail_memory(context);
    }
    uint32_t count = 0;
    for (uint32_t i = 0; i < c->points->count; ++i) {
        if (c->links.kept[i] != i) {
            continue;
        }
        stp_vec3 p = stp_to_float(stp_addd(c->positions[i], c->middle));
        float* to = left->positions + 3 * (size_t)count;
        to[0] = p.x;
        to[1] = p.y;
        to[2] = p.z;
        if (normals) {
            stp_vec3 n = stp_normalize(stp_decimate_vector(c->points->normals, i));
            float* side = left->normals + 3 * (size_t)count;
            side[0] = n.x;
            side[1] = n.y;
            side[2] = n.z;
        }
        left->numbers[count++] = i;
    }
    assert(count == c->left && "the points that were not contracted into others");
    return STP_OK;
}

/// Turns the remaining points into splats, like initial splats (Wu, Zhang, Kobbelt 2005, 3 and
/// 6.1).
static stp_result make_splats(const stp_contraction* c, stp_decimate_output* output)
{
    left_points left = {0};
    stp_result result = gather(c, &left);
    if (result == STP_OK) {
        const stp_decimate_input input = {
            .count = c->left, .positions = left.positions, .normals = left.normals};
        result = stp_decimate_make_distinct_disks(c->context, &input, &output->ellipses, NULL);
    }
    output->colors =
        result == STP_OK ? STP_NEW_ARRAY(c->context, uint8_t, 3 * (size_t)c->left + 1) : NULL;
    if (result == STP_OK && output->colors == NULL) {
        result = stp_fail_memory(c->context);
    }
    if (result == STP_OK) {
        output->count = c->left;
        for (uint32_t i = 0; i < c->left; ++i) {
            stp_color_mean_write(&c->points->means[left.numbers[i]],
                                 output->colors + 3 * (size_t)i);
        }
    }
    stp_free(c->context, left.positions);
    stp_free(c->context, left.normals);
    stp_free(c->context, left.numbers);
    return result;
}

stp_result stp_decimate_by_quadric(stp_context* context, const stp_decimate_input* input,
                                   uint32_t target, stp_decimate_output* output)
{
    *output = (stp_decimate_output){0};
    stp_distinct points = {0};
    stp_ellipse* disks = NULL;
    uint32_t* neighbours = NULL;
    stp_result result = stp_decimate_check(context, input);
    result = result == STP_OK ? stp_distinct_make(context, input, &points) : result;
    if (result == STP_OK) {
        const stp_decimate_input places = {
            .count = points.count, .positions = points.positions, .normals = points.normals};
        result = stp_decimate_make_distinct_disks(context, &places, &disks, &neighbours);
    }
    stp_contraction c = {.context = context, .points = &points, .disks = disks};
    if (result == STP_OK) {
        result = stp_contraction_make(&c, neighbours, STP_DECIMATE_NEIGHBOURS);
    }
    stp_free(context, neighbours);
    while (result == STP_OK && c.left > target && stp_contraction_step(&c)) {
    }
    result = result == STP_OK ? make_splats(&c, output) : result;
    stp_contraction_destroy(&c);
    stp_distinct_destroy(context, &points);
    stp_free(context, disks);
    return result;
}
