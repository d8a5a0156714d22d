// SPDX-License-Identifier: MIT
// Checks a caller's options, and converts them for selection and renderers.
#include "embed/painter_internal.h"

#include <assert.h>
#include <math.h>
#include <string.h>

static stp_result fail(const stp_painter* painter, const char* what)
{
    return stp_fail(painter->model->context, STP_ERROR_ARGUMENT, "stp_paint_desc: %s", what);
}

/// @return NULL, or a description of the error
static const char* find_fault(const stp_painter* painter, const stp_paint_desc* desc)
{
    bool numbers = isfinite(desc->splat_size) && isfinite(desc->budget_ms) &&
                   isfinite(desc->eye_dome) && isfinite(desc->ambient_occlusion) &&
                   isfinite(desc->ghost) && isfinite(desc->elevation[0]) &&
                   isfinite(desc->elevation[1]);
    if (!numbers) {
        return "a number is not finite";
    }
    if (desc->splat_size < 0.0f || (desc->splat_size > 0.0f && desc->splat_size < 1.0f)) {
        return "splat_size must be at least 1";
    }
    if (desc->budget_ms < 0.0 || desc->eye_dome < 0.0f || desc->ambient_occlusion < 0.0f ||
        desc->ghost < 0.0f || desc->ghost > 1.0f) {
        return "budget_ms, eye_dome, ambient_occlusion or ghost is out of range";
    }
    if ((uint32_t)desc->pixel_filter > STP_PIXEL_FILTER_OFF) {
        return "pixel_filter is not a value of stp_pixel_filter";
    }
    if ((uint32_t)desc->coloring > STP_PIXELS_NORMALS) {
        return "coloring is not a value of stp_pixel_coloring";
    }
    if (desc->smooth && desc->coloring != STP_PIXELS_OWN) {
        return "smooth needs the scene's own colours";
    }
    if (desc->triangles_only && painter->model->residency != NULL) {
        return "triangles_only cannot be drawn while the model streams";
    }
    return NULL;
}

static stp_result find_method(const stp_painter* painter, const char* name, uint32_t* id)
{
    const stp_store_directory* d = stp_store_get_directory(painter->model->store);
    *id = 0;
    for (uint32_t i = 0; name != NULL && i < stp_store_offered_methods(d) && *id == 0; ++i) {
        *id = strcmp(d->methods[i].name, name) == 0 ? d->methods[i].id : 0;
    }
    return name == NULL || *id != 0
               ? STP_OK
               : stp_fail(painter->model->context, STP_ERROR_ARGUMENT,
                          "stp_paint_desc: the file has no splats of method %s", name);
}

static bool filters_pixels(const stp_paint_desc* desc)
{
    bool moves = desc->budget_ms > 0.0 && !desc->accumulate && !desc->triangles_only;
    return desc->pixel_filter == STP_PIXEL_FILTER_AUTO ? moves
                                                       : desc->pixel_filter == STP_PIXEL_FILTER_ON;
}

stp_result stp_painter_read_options(const stp_painter* painter, const stp_paint_desc* desc,
                                    stp_quality* quality, stp_draw_style* style)
{
    const stp_boxd* bounds = &painter->model->summary.bounds;
    const char* fault = find_fault(painter, desc);
    uint32_t method = 0;
    stp_result result =
        fault != NULL ? fail(painter, fault) : find_method(painter, desc->method, &method);
    if (result != STP_OK) {
        return result;
    }
    *quality = (stp_quality){.splat_size = desc->splat_size > 0.0f ? desc->splat_size : 1.0f,
                             .splat_count = desc->splat_count,
                             .method = method,
                             .reference = desc->triangles_only,
                             .splats_only = desc->splats_only,
                             .visibility = painter->model->visibility};
    *style = (stp_draw_style){.splat_scale = 1.0f,
                              .supersample = desc->samples > 0 ? desc->samples : 1,
                              .headlight = desc->headlight,
                              .background = desc->background,
                              .filter = desc->smooth ? STP_FILTER_EWA : STP_FILTER_NONE,
                              .eye_dome = desc->eye_dome,
                              .ambient_occlusion = desc->ambient_occlusion,
                              .ghost = desc->ghost,
                              .caps = desc->caps,
                              .back_faces = desc->back_faces,
                              .pixel_filter = filters_pixels(desc),
                              .coloring = (stp_draw_coloring)desc->coloring,
                              .elevation = {desc->elevation[0], desc->elevation[1]}};
    memcpy(style->background_color, desc->background_color, sizeof(style->background_color));
    if (desc->elevation[0] == 0.0 && desc->elevation[1] == 0.0) {
        style->elevation[0] = bounds->min.y;
        style->elevation[1] = bounds->max.y;
    }
    assert(quality->splat_size >= 1.0f && style->supersample >= 1);
    return STP_OK;
}
_Static_assert((int)STP_PIXELS_ELEVATION == (int)STP_DRAW_ELEVATION &&
                   (int)STP_PIXELS_NORMALS == (int)STP_DRAW_NORMALS,
               "colourings are numbered alike");
