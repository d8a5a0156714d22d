// SPDX-License-Identifier: MIT
#include "program/options/cloud_style.h"

#include "program/options/tool.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

static const double max_metres = 1e6, min_pixels = 1.0;

bool cloud_style_read_size(const char* text, cloud_point_size* size)
{
    *size = (cloud_point_size){0};
    if (strcmp(text, "adaptive") == 0) {
        return true;
    }
    char* end;
    double width = *text >= '0' && *text <= '9' ? strtod(text, &end) : 0.0;
    if (!(width > 0.0) || !isfinite(width)) {
        return false;
    }
    if (strcmp(end, "m") == 0) {
        *size = (cloud_point_size){.in_metres = true, .width = width};
        return width <= max_metres;
    }
    *size = (cloud_point_size){.width = width};
    return (*end == '\0' || strcmp(end, "px") == 0) && width >= min_pixels &&
           width <= CLOUD_POINT_PIXELS;
}

int cloud_style_refuse_size(const char* text)
{
    return tool_usage_error("--point-size must be 1 to %d pixels (3 or 3px), metres (0.05m) or "
                            "adaptive, not %s",
                            CLOUD_POINT_PIXELS, text);
}

bool cloud_style_is_cloud(const stp_store* store)
{
    const stp_store_directory* d = stp_store_get_directory(store);
    return d->root != STP_STORE_NONE && d->nodes[d->root].triangle_count == 0 &&
           d->nodes[d->root].point_count > 0;
}

float cloud_style_eye_dome(const stp_store* store)
{
    return cloud_style_is_cloud(store) ? CLOUD_EYE_DOME : 0.0f;
}

void cloud_style_set_size(const cloud_point_size* size, const stp_store* store,
                          stp_draw_style* style)
{
    double unit = stp_store_get_directory(store)->unit_metres;
    style->point_sizing = !(size->width > 0.0) ? STP_POINTS_ADAPTIVE
                          : size->in_metres    ? STP_POINTS_UNITS
                                               : STP_POINTS_PIXELS;
    style->point_size = (float)(size->in_metres && unit > 0.0 ? size->width / unit : size->width);
}
