// SPDX-License-Identifier: MIT
#include "lab/decimate/point_disks.h"

#include "base/math/color.h"
#include "lod/psp/initial.h"

#include <assert.h>

enum { POINTS_MAX = 1 << 30 };

stp_result stp_decimate_check(stp_context* context, const stp_decimate_input* input)
{
    if (input->count > POINTS_MAX) {
        return stp_fail(context, STP_ERROR_LIMIT, "decimation: %u points, at most %d", input->count,
                        POINTS_MAX);
    }
    return STP_OK;
}

stp_box stp_decimate_box(const stp_decimate_input* input)
{
    stp_box box = stp_box_empty();
    for (uint32_t i = 0; i < input->count; ++i) {
        stp_box_add(&box, stp_decimate_vector(input->positions, i));
    }
    return input->count > 0 ? box : (stp_box){0};
}

stp_result stp_decimate_make_distinct_disks(stp_context* context, const stp_decimate_input* input,
                                            stp_ellipse** disks, uint32_t** neighbours)
{
    const stp_psp_points points = {.count = input->count,
                                   .positions = input->positions,
                                   .normals = input->normals,
                                   .colors = input->colors};
    size_t links = (size_t)input->count * STP_DECIMATE_NEIGHBOURS;
    uint32_t* near = STP_NEW_ARRAY(context, uint32_t, links + 1);
    *disks = STP_NEW_ARRAY(context, stp_ellipse, (size_t)input->count + 1);
    stp_result result = near != NULL && *disks != NULL ? STP_OK : stp_fail_memory(context);
    if (result == STP_OK) {
        result = stp_psp_make_initial(context, &points, STP_DECIMATE_NEIGHBOURS, *disks, near);
    }
    if (neighbours != NULL) {
        *neighbours = near;
    } else {
        stp_free(context, near);
    }
    return result;
}

stp_result stp_decimate_make_room(stp_context* context, stp_decimate_output* output, uint32_t count)
{
    output->ellipses = STP_NEW_ARRAY(context, stp_ellipse, (size_t)count + 1);
    output->colors = STP_NEW_ARRAY(context, uint8_t, 3 * (size_t)count + 1);
    if (output->ellipses == NULL || output->colors == NULL) {
        return stp_fail_memory(context);
    }
    output->count = count;
    return STP_OK;
}

void stp_decimate_output_destroy(stp_context* context, stp_decimate_output* output)
{
    stp_free(context, output->ellipses);
    stp_free(context, output->colors);
    stp_free(context, output->vertices);
    stp_free(context, output->triangles);
    *output = (stp_decimate_output){0};
}

void stp_color_mean_add(stp_color_mean* mean, const stp_decimate_input* input, size_t point,
                        double weight)
{
    assert(point < input->count && !(weight < 0.0));
    mean->weight += weight;
    for (size_t k = 0; k < 3; ++k) {
        uint8_t color = input->colors != NULL ? input->colors[3 * point + k] : 255;
        mean->sum[k] += weight * (double)stp_srgb8_to_linear(color);
    }
}

void stp_color_mean_write(const stp_color_mean* mean, uint8_t* color)
{
    for (int k = 0; k < 3; ++k) {
        double value = mean->weight > 0.0 ? mean->sum[k] / mean->weight : 1.0;
        color[k] = stp_linear_to_srgb8((float)value);
    }
}
