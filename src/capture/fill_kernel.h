// SPDX-License-Identifier: MIT
//
// The inner loop of the fill. Every variant gives the same bits.
#pragma once

#include "capture/fill.h"

#include <assert.h>

/// A main view, in the coordinates of a further one: column = x . p + x_shift, row = y . p +
/// y_shift, nearness = z . p + 1.5.
typedef struct stp_fill_view {
    float x[3], x_shift, y[3], y_shift, z[3];
    float pixels_per_nearness; ///< depth of a nearness of 1, in pixels
    float width, height;
    size_t words_per_row;
    const stp_fill_word* words;
} stp_fill_view;

/// A further view: its pixel shows the point column * x + row * y + nearness * z + origin.
typedef struct stp_fill_query {
    float x[3], y[3], z[3], origin[3];
    float toward[3];
    const stp_fill_surface* surface; ///< one per candidate
    uint32_t view_count;
    stp_fill_view looks[STP_CAPTURE_FILL_DIRECTIONS];
} stp_fill_query;

typedef void (*stp_fill_kernel)(const stp_fill_query* query, uint32_t first_row,
                                const stp_raster_target* target);

void stp_fill_drop_portable(const stp_fill_query* query, uint32_t first_row,
                            const stp_raster_target* target);
void stp_fill_drop_vector(const stp_fill_query* query, uint32_t first_row,
                          const stp_raster_target* target);

/// Place of a point in a view.
typedef struct stp_fill_place {
    float x, y, nearness;
} stp_fill_place;

static inline stp_fill_place project_point(const stp_fill_view* look, const float p[3])
{
    return (stp_fill_place){
        (look->x[0] * p[0] + look->x[1] * p[1]) + look->x[2] * p[2] + look->x_shift,
        (look->y[0] * p[0] + look->y[1] * p[1]) + look->y[2] * p[2] + look->y_shift,
        (look->z[0] * p[0] + look->z[1] * p[1]) + look->z[2] * p[2] + 1.5f,
    };
}

/// One ten-bit component of a normal.
static inline float normal_part(uint32_t normal, int part)
{
    return (float)((int32_t)(normal << (22 - 10 * part)) >> 22);
}

/// Whether the pixel at an offset from a point's place shows surface that represents the point:
/// within a pixel's size, and facing the further view too.
static inline bool is_represented_at(const stp_fill_query* q, const stp_fill_view* look,
                                     const stp_fill_place* place, float dx, float dy)
{
    float x = place->x + dx, y = place->y + dy;
    if (!(x >= 0.0f && y >= 0.0f && x < look->width && y < look->height)) {
        return false;
    }
    uint32_t column = (uint32_t)x, row = (uint32_t)y;
    assert(column / 32 < look->words_per_row);
    const stp_fill_word* word = &look->words[row * look->words_per_row + column / 32];
    uint32_t bit = (uint32_t)1 << column % 32;
    if ((word->covered & bit) == 0) {
        return false;
    }
    size_t candidate = word->first + (uint32_t)__builtin_popcount(word->covered & (bit - 1));
    stp_fill_surface surface = q->surface[candidate];
    float across = (float)(int32_t)column + 0.5f - place->x;
    float along = (float)(int32_t)row + 0.5f - place->y;
    float deep = (surface.nearness - place->nearness) * look->pixels_per_nearness;
    float facing = (normal_part(surface.normal, 0) * q->toward[0] +
                    normal_part(surface.normal, 1) * q->toward[1]) +
                   normal_part(surface.normal, 2) * q->toward[2];
    return (across * across + along * along) + deep * deep <= 1.0f && facing > 0.0f;
}

/// Tests the pixel that shows the point in a view.
static inline bool is_seen(const stp_fill_query* q, const stp_fill_view* look, const float p[3])
{
    stp_fill_place place = project_point(look, p);
    return is_represented_at(q, look, &place, 0.0f, 0.0f);
}

/// Tests the four surrounding pixels.
static inline bool is_near(const stp_fill_query* q, const stp_fill_view* look, const float p[3])
{
    stp_fill_place place = project_point(look, p);
    return is_represented_at(q, look, &place, -0.5f, -0.5f) ||
           is_represented_at(q, look, &place, 0.5f, -0.5f) ||
           is_represented_at(q, look, &place, -0.5f, 0.5f) ||
           is_represented_at(q, look, &place, 0.5f, 0.5f);
}

static inline bool has_representative(const stp_fill_query* q, const float p[3],
                                      uint32_t* favourite)
{
    assert(*favourite < q->view_count);
    if (is_seen(q, &q->looks[*favourite], p)) { // the view that saw the previous pixel sees most
        return true;
    }
    for (uint32_t i = 0; i < q->view_count; ++i) {
        if (i != *favourite && is_seen(q, &q->looks[i], p)) {
            *favourite = i;
            return true;
        }
    }
    for (uint32_t i = 0; i < q->view_count; ++i) {
        if (is_near(q, &q->looks[i], p)) {
            return true;
        }
    }
    return false;
}

static inline void drop_known(const stp_fill_query* q, uint32_t first_row,
                              const stp_raster_target* target)
{
    uint32_t favourite = 0;
    for (uint32_t row = 0; row < target->height; ++row) {
        uint64_t* pixels = target->pixels + row * target->stride;
        float y = (float)(first_row + row) + 0.5f;
        for (uint32_t column = 0; column < target->width; ++column) {
            if (pixels[column] == STP_RASTER_EMPTY) {
                continue;
            }
            float x = (float)column + 0.5f, z = stp_raster_nearness(pixels[column]), p[3];
            for (int k = 0; k < 3; ++k) {
                p[k] = (x * q->x[k] + y * q->y[k]) + z * q->z[k] + q->origin[k];
            }
            if (has_representative(q, p, &favourite)) {
                pixels[column] = STP_RASTER_EMPTY;
            }
        }
    }
}
