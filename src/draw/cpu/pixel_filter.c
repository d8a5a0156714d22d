// SPDX-License-Identifier: MIT
// Filters a picture in place, band by band. The rows at the borders of bands are copied first,
// because the bands beside them need them as they were.
#include "draw/cpu/pixel_filter.h"

#include "base/core/processor.h"

#include <assert.h>
#include <string.h>

enum {
    ALIGNMENT = 64,
    LINES = 3, ///< rows whose means across are known at a time
};

/// Means across of a row.
typedef struct filtered_line {
    uint16_t *values, *weights;
} filtered_line;

typedef struct pixel_filter {
    stp_cpu_renderer* r;
    const stp_cpu_pixel_kernels* kernels;
    size_t row; ///< numbers of a row
} pixel_filter;

const stp_cpu_pixel_kernels* stp_cpu_choose_pixel_kernels(void)
{
    return STP_VARIANT(stp_processor_detect(), &stp_cpu_pixel_kernels);
}

static size_t align(size_t bytes)
{
    return (bytes + ALIGNMENT - 1) / ALIGNMENT * ALIGNMENT;
}

static uint32_t band_count(const stp_cpu_renderer* r)
{
    return (r->height + CPU_BAND_ROWS - 1) / CPU_BAND_ROWS;
}

/// Bytes of a row of 16-bit numbers, with a pixel before it and one behind it.
static size_t line_bytes(const stp_cpu_renderer* r)
{
    return align((4 * (size_t)r->width + 8) * sizeof(uint16_t));
}

/// Bytes of a worker's scratch memory: values and weights of each line, and light.
static size_t scratch_bytes(const stp_cpu_renderer* r)
{
    return (2 * LINES + 1) * line_bytes(r);
}

/// Warns that pictures are not filtered.
static void warn(stp_cpu_renderer* r)
{
    if (!r->pixel_filter.warned) {
        r->pixel_filter.warned = true;
        stp_warn(r->base.context,
                 "the memory limit leaves no room to filter a picture of %ux%u: it is not filtered",
                 r->width, r->height);
    }
}

bool stp_cpu_begin_pixel_filter(stp_cpu_renderer* r)
{
    stp_cpu_pixel_filter* f = &r->pixel_filter;
    size_t kinds = align((size_t)r->width * r->height), row = 4 * (size_t)r->width;
    size_t borders = align(2 * band_count(r) * row);
    size_t needed = kinds + borders + r->team.threads * scratch_bytes(r);
    f->kinds = NULL;
    if (needed > f->capacity) {
        f->capacity = 0;
        stp_free(r->base.context, f->memory);
        f->memory = STP_NEW_ARRAY(r->base.context, uint8_t, needed);
        if (f->memory == NULL) {
            warn(r);
            return false;
        }
        f->capacity = needed;
    }
    f->kinds = f->memory;
    f->borders = f->kinds + kinds;
    f->scratch = f->borders + borders;
    return true;
}

static uint8_t* border_row(const pixel_filter* f, uint32_t band, bool last)
{
    assert(band < band_count(f->r));
    return f->r->pixel_filter.borders + (2 * (size_t)band + (last ? 1 : 0)) * f->row;
}

static uint32_t band_end(const stp_cpu_renderer* r, uint32_t band)
{
    uint32_t end = (band + 1) * CPU_BAND_ROWS;
    return end < r->height ? end : r->height;
}

static void copy_borders(size_t begin, size_t end, uint32_t worker, void* user)
{
    const pixel_filter* f = user;
    const uint8_t* pixels = f->r->image->pixels;
    (void)worker;
    for (size_t i = begin; i < end; ++i) {
        uint32_t band = (uint32_t)i;
        size_t last = band_end(f->r, band) - 1;
        memcpy(border_row(f, band, false), pixels + (size_t)band * CPU_BAND_ROWS * f->row, f->row);
        memcpy(border_row(f, band, true), pixels + last * f->row, f->row);
    }
}

/// A row as it was before the filter.
static const uint8_t* original_row(const pixel_filter* f, uint32_t band, uint32_t y)
{
    if (y < band * CPU_BAND_ROWS) {
        return border_row(f, band - 1, true);
    }
    return y < band_end(f->r, band) ? f->r->image->pixels + y * f->row
                                    : border_row(f, band + 1, false);
}

/// Whether a row has pixels that are neither open nor covered.
static bool has_partial(const uint8_t* pixels, uint32_t width)
{
    uint32_t any = 0;
    for (uint32_t x = 0; x < width; ++x) {
        any |= (uint32_t)(pixels[4 * (size_t)x + 3] + 1) & 254u;
    }
    return any != 0;
}

/// Light times coverage of a row with such pixels.
static void light_partial(const uint8_t* pixels, uint16_t* light, uint32_t width)
{
    for (uint32_t x = 0; x < width; ++x, pixels += 4, light += 4) {
        uint32_t alpha = pixels[3];
        for (int c = 0; c < 3; ++c) {
            light[c] = (uint16_t)((uint32_t)pixels[c] * pixels[c] * alpha / 255u);
        }
        light[3] = (uint16_t)(alpha * 255u);
    }
}

/// Finds the means across of row `y`.
static void fill_line(const pixel_filter* f, uint32_t band, uint32_t y, uint16_t* light,
                      filtered_line* line)
{
    uint32_t width = f->r->width;
    const uint8_t* pixels = original_row(f, band, y);
    assert(y < f->r->height && width > 0);
    light += 4;
    if (has_partial(pixels, width)) {
        light_partial(pixels, light, width);
    } else {
        f->kernels->light(pixels, light, width);
    }
    memcpy(light - 4, light, 4 * sizeof(*light)); // beside the picture: the pixel itself
    memcpy(light + 4 * (size_t)width, light + 4 * ((size_t)width - 1), 4 * sizeof(*light));
    f->kernels->weigh(f->r->pixel_filter.kinds + (size_t)y * width, line->weights, width);
    f->kernels->across(light, line->weights, line->values, width);
}

static void filter_band(const pixel_filter* f, uint32_t band, uint8_t* scratch)
{
    const stp_cpu_renderer* r = f->r;
    size_t bytes = line_bytes(r);
    uint32_t begin = band * CPU_BAND_ROWS, end = band_end(r, band);
    filtered_line lines[LINES];
    for (int i = 0; i < LINES; ++i) {
        lines[i].values = (uint16_t*)(void*)(scratch + (size_t)(2 * i) * bytes);
        lines[i].weights = (uint16_t*)(void*)(scratch + (size_t)(2 * i + 1) * bytes);
    }
    uint16_t* light = (uint16_t*)(void*)(scratch + (size_t)(2 * LINES) * bytes);
    uint32_t first = begin > 0 ? begin - 1 : begin, filled = first;
    for (uint32_t y = begin; y < end; ++y) {
        uint32_t above = y > 0 ? y - 1 : y, below = y + 1 < r->height ? y + 1 : y;
        for (; filled <= below; ++filled) {
            fill_line(f, band, filled, light, &lines[filled % LINES]);
        }
        const uint16_t* const rows[3] = {lines[above % LINES].values, lines[y % LINES].values,
                                         lines[below % LINES].values};
        f->kernels->down(rows, lines[y % LINES].weights, light, r->image->pixels + y * f->row,
                         r->width);
    }
}

static void filter_bands(size_t begin, size_t end, uint32_t worker, void* user)
{
    const pixel_filter* f = user;
    for (size_t band = begin; band < end; ++band) {
        filter_band(f, (uint32_t)band, f->r->pixel_filter.scratch + worker * scratch_bytes(f->r));
    }
}

void stp_cpu_filter_pixels(stp_cpu_renderer* r)
{
    assert(r->pixel_filter.kinds != NULL && "begun before shading");
    pixel_filter f = {
        .r = r, .kernels = stp_cpu_choose_pixel_kernels(), .row = 4 * (size_t)r->width};
    stp_team_run(&r->team, band_count(r), 1, copy_borders, &f);
    stp_team_run(&r->team, band_count(r), 1, filter_bands, &f);
    r->pixel_filter.kinds = NULL;
}

void stp_cpu_destroy_pixel_filter(stp_cpu_renderer* r)
{
    stp_free(r->base.context, r->pixel_filter.memory);
}
