// SPDX-License-Identifier: MIT
#include "capture/fill.h"

#include "base/core/processor.h"
#include "capture/fill_kernel.h"

#include <assert.h>
#include <string.h>

enum {
    CORNERS = 8,
    FACES_AND_CORNERS = 14,
    GRAIN = 16384,
    /// Stop adding directions once they find less than 1 / MIN_GAIN of the candidates.
    MIN_GAIN = 1000,
    /// Same limit for captures with sets. They are seen from afar, where surface deep inside a wood
    /// or a hall shows little but makes up most of what further views draw.
    WORTH_OF_SETS = 20,
};

static size_t words_per_row(const stp_capture_view* view)
{
    return ((size_t)view->width + 31) / 32;
}

static void to_floats(stp_vec3d v, float out[3])
{
    out[0] = (float)v.x;
    out[1] = (float)v.y;
    out[2] = (float)v.z;
}

static void mark_band(stp_fill_map* map, const stp_capture_band* band)
{
    const stp_capture_view* view = &map->views[band->view];
    stp_fill_word* words = map->words + map->starts[band->view];
    size_t row = band->row_begin, row_start = row * view->width; // pixel at which it begins
    for (uint32_t i = 0; i < band->count; ++i) {
        while (band->pixels[i] - row_start >= view->width) {
            row += 1;
            row_start += view->width;
        }
        size_t column = band->pixels[i] - row_start;
        assert(row < band->row_end && (i == 0 || band->pixels[i] > band->pixels[i - 1]));
        words[row * words_per_row(view) + column / 32].covered |= (uint32_t)1 << column % 32;
    }
}

static bool has_points(const stp_capture_job* job)
{
    for (size_t i = 0; i < job->part_count; ++i) {
        if (job->parts[i].part.kind == STP_PART_POINTS) {
            return true;
        }
    }
    return false;
}

// Also marks triangles, which are never queried.
static stp_result mark_points(const stp_capture_job* job, stp_fill_map* map)
{
    size_t words = (size_t)(stp_capture_primitive_count(job) / 64) + 1;
    map->points = STP_NEW_ZEROED(job->scene->context, uint64_t, words);
    if (map->points == NULL) {
        return stp_fail_memory(job->scene->context);
    }
    for (size_t b = 0; b < job->band_count; ++b) {
        const stp_capture_band* band = &job->bands[b];
        for (uint32_t i = 0; i < band->count; ++i) {
            uint64_t primitive = band->primitives[i];
            assert(primitive < stp_capture_part_primitives(job) && "splats are taken before");
            map->points[primitive / 64] |= (uint64_t)1 << primitive % 64;
        }
    }
    return STP_OK;
}

stp_result stp_fill_map_create(const stp_capture_job* job, const stp_candidates* candidates,
                               stp_fill_map* map)
{
    assert(job->view_count < STP_CAPTURE_FILL_DIRECTIONS && candidates->pixel_size > 0.0);
    *map = (stp_fill_map){
        .views = job->views, .view_count = job->view_count, .pixel_size = candidates->pixel_size};
    size_t total = 0;
    for (uint32_t v = 0; v < job->view_count; ++v) {
        map->starts[v] = total;
        total += words_per_row(&job->views[v]) * job->views[v].height;
    }
    map->words = STP_NEW_ZEROED(job->scene->context, stp_fill_word, total);
    map->surface = STP_NEW_ARRAY(job->scene->context, stp_fill_surface, job->covered_pixels);
    if (map->words == NULL || map->surface == NULL) {
        return stp_fail_memory(job->scene->context);
    }
    for (size_t b = 0; b < job->band_count; ++b) {
        mark_band(map, &job->bands[b]);
    }
    uint32_t sum = 0;
    for (size_t i = 0; i < total; ++i) { // candidates have the same order: view, row, column
        map->words[i].first = sum;
        sum += (uint32_t)__builtin_popcount(map->words[i].covered);
    }
    assert(sum == (uint32_t)job->covered_pixels && "each candidate has its pixel");
    return has_points(job) ? mark_points(job, map) : STP_OK;
}

typedef struct surface_job {
    const stp_fill_map* map;
    const stp_candidates* candidates;
} surface_job;

static void write_surface(size_t begin, size_t end, uint32_t worker, void* user)
{
    (void)worker;
    const surface_job* job = user;
    const stp_candidates* c = job->candidates;
    uint32_t view = 0;
    for (size_t i = begin; i < end; ++i) {
        while (i >= c->view_starts[view + 1]) {
            view += 1;
        }
        assert(view < job->map->view_count);
        float depth[3];
        to_floats(job->map->views[view].depth, depth);
        const float *p = c->positions + 3 * i, *n = c->normals + 3 * i;
        stp_fill_surface* surface = &job->map->surface[i];
        surface->nearness = (depth[0] * p[0] + depth[1] * p[1]) + depth[2] * p[2] + 1.5f;
        surface->normal = 0;
        for (int k = 0; k < 3; ++k) {
            uint32_t bits = (uint32_t)(int32_t)(n[k] * 511.0f) & 1023u;
            surface->normal |= bits << (10 * k);
        }
    }
}

void stp_fill_map_set_surface(stp_context* context, stp_fill_map* map,
                              const stp_candidates* candidates)
{
    assert(candidates->view_starts[map->view_count] == candidates->count);
    surface_job job = {map, candidates};
    stp_parallel_for(context, candidates->view_starts[map->view_count], GRAIN, write_surface, &job);
}

void stp_fill_map_destroy(stp_context* context, stp_fill_map* map)
{
    stp_free(context, map->points);
    stp_free(context, map->surface);
    stp_free(context, map->words);
    *map = (stp_fill_map){0};
}

/// The axis along which a view coordinate grows by one per step.
static stp_vec3d step_of(stp_vec3d axis)
{
    return stp_scaled(axis, 1.0 / stp_dotd(axis, axis));
}

void stp_fill_drop_known(const stp_fill_map* map, const stp_capture_view* view, uint32_t first_row,
                         const stp_raster_target* target)
{
    assert(map->view_count > 0 && map->view_count < STP_CAPTURE_FILL_DIRECTIONS);
    stp_fill_query query = {
        .surface = map->surface,
        .view_count = map->view_count,
    };
    stp_vec3d x = step_of(view->right), y = step_of(view->down), z = step_of(view->depth);
    stp_vec3d origin = stp_addd(stp_scaled(x, -view->shift_x), stp_scaled(y, -view->shift_y));
    to_floats(x, query.x);
    to_floats(y, query.y);
    to_floats(z, query.z);
    to_floats(stp_addd(origin, stp_scaled(z, -1.5)), query.origin);
    to_floats(view->toward, query.toward);
    for (uint32_t v = 0; v < map->view_count; ++v) {
        const stp_capture_view* first = &map->views[v];
        stp_fill_view* look = &query.looks[v];
        to_floats(first->right, look->x);
        to_floats(first->down, look->y);
        to_floats(first->depth, look->z);
        double pixels = 1.0 / (sqrt(stp_dotd(first->depth, first->depth)) * map->pixel_size);
        look->pixels_per_nearness = (float)pixels;
        look->x_shift = (float)first->shift_x;
        look->y_shift = (float)first->shift_y;
        look->width = (float)first->width;
        look->height = (float)first->height;
        look->words_per_row = words_per_row(first);
        look->words = map->words + map->starts[v];
    }
    STP_VARIANT_OF_TWO(stp_processor_detect(), stp_fill_drop)(&query, first_row, target);
}

// The corners, faces and edges of a cube that were not drawn. Captures of 8 and 14 directions draw
// the first ones (capture.h); a spiral shares none.
static uint32_t find_directions(uint32_t count, stp_vec3d* directions)
{
    stp_vec3d all[STP_CAPTURE_FILL_DIRECTIONS];
    stp_capture_directions(STP_CAPTURE_FILL_DIRECTIONS, all);
    uint32_t shared = count == CORNERS || count == FACES_AND_CORNERS ? count : 0;
    uint32_t left = STP_CAPTURE_FILL_DIRECTIONS - shared;
    assert(shared <= STP_CAPTURE_FILL_DIRECTIONS);
    memcpy(directions, all + shared, left * sizeof(all[0]));
    return left;
}

// Draws some further views and appends the surface they find.
static stp_result draw_fill_views(stp_capture_job* job, const stp_fill_map* map,
                                  const stp_vec3d* directions, uint32_t count,
                                  stp_candidates* candidates)
{
    assert(count > 0 && count <= STP_CAPTURE_FILL_DIRECTIONS);
    stp_capture_view views[STP_CAPTURE_FILL_DIRECTIONS];
    stp_capture_job further = *job;
    further.views = views;
    further.bands = NULL;
    further.band_count = 0;
    further.covered_pixels = 0;
    further.represented = map;
    stp_capture_set_views(&further, directions, count, candidates->pixel_size);
    stp_result result = stp_capture_draw(&further, 0, count);
    if (result == STP_OK) {
        result = stp_capture_append(&further, 0, candidates);
    }
    job->room = further.room;
    stp_capture_drop_bands(&further);
    return result;
}

stp_result stp_capture_fill(stp_capture_job* job, const stp_fill_map* map,
                            stp_candidates* candidates)
{
    assert(candidates->count == candidates->view_starts[map->view_count] &&
           "the candidates are those of the map");
    assert(!job->keeps_silhouettes && "further views have none");
    stp_vec3d directions[STP_CAPTURE_FILL_DIRECTIONS];
    uint32_t count = find_directions(candidates->direction_count, directions);
    uint32_t first = candidates->count, faces = FACES_AND_CORNERS - CORNERS;
    faces = faces < count ? faces : count;
    uint64_t seen = stp_capture_seen_count(job);
    stp_result result = draw_fill_views(job, map, directions, faces, candidates);
    uint64_t found = candidates->count - first + stp_capture_seen_count(job) - seen;
    bool worth =
        job->set_count == 0 ? found >= first / MIN_GAIN : found > (first + seen) / WORTH_OF_SETS;
    if (result == STP_OK && worth && faces < count) {
        result = draw_fill_views(job, map, directions + faces, count - faces, candidates);
    }
    return result;
}
