// SPDX-License-Identifier: MIT
// First half of a capture: from parts to covered pixels.
#include "capture/capture_internal.h"
#include "capture/fill.h"

#include <assert.h>
#include <stdatomic.h>
#include <string.h>

/// Size limit of a band's buffer; taller pictures use more bands.
#define BAND_BYTES ((uint64_t)32 << 20)
/// Size limit of all silhouettes; if exceeded, none are kept.
#define SILHOUETTE_BYTES ((uint64_t)64 << 20)

enum { GROUP = 8 /**< pixels tested together */ };

/// Per-thread state.
typedef struct draw_worker {
    stp_arena scratch;
    uint64_t* pixels;     ///< room for the largest band
    uint64_t* pass;       ///< the same, if several passes are needed
    uint64_t* primitives; ///< nearest one of each pixel so far, if several passes are needed
} draw_worker;

typedef struct draw_state {
    stp_capture_job* job;
    draw_worker* workers;
    size_t first_band;  ///< first band to draw
    size_t band_pixels; ///< pixels of the largest band
    bool passes;        ///< whether several passes are needed
    atomic_bool failed;
} draw_state;

/// Keeps the nearer of the previous and the new pass for each pixel.
static void merge_pass(draw_worker* worker, size_t pixel_count, uint64_t first_primitive)
{
    for (size_t i = 0; i < pixel_count; ++i) {
        if (worker->pass[i] >> 32 < worker->pixels[i] >> 32) {
            worker->pixels[i] = worker->pass[i];
            worker->primitives[i] = first_primitive + stp_raster_id(worker->pass[i]);
        }
    }
}

/// Draws all sets in as many passes as 32-bit ids require.
static stp_result draw_sets_in_passes(const stp_capture_job* job, const stp_capture_band* band,
                                      const stp_raster_target* pass, size_t pixel_count,
                                      draw_worker* worker)
{
    for (size_t begin = 0; begin < job->set_count;) {
        size_t end = begin + 1;
        while (end < job->set_count &&
               job->first_splats[end + 1] - job->first_splats[begin] <= job->ids_per_pass) {
            end += 1;
        }
        assert(end <= job->set_count);
        memset(worker->pass, 0xFF, pixel_count * sizeof(uint64_t));
        stp_result result = stp_capture_draw_sets(job, band, begin, end, 0, pass, &worker->scratch);
        if (result != STP_OK) {
            return result;
        }
        merge_pass(worker, pixel_count,
                   stp_capture_part_primitives(job) + job->first_splats[begin]);
        begin = end;
    }
    return STP_OK;
}

/// Draws all parts in as many passes as 32-bit ids require. Then worker->primitives holds the
/// nearest primitives.
static stp_result draw_in_passes(const stp_capture_job* job, const stp_capture_band* band,
                                 const stp_raster_target* target, size_t pixel_count,
                                 draw_worker* worker)
{
    memset(worker->pixels, 0xFF, pixel_count * sizeof(uint64_t));
    stp_raster_target pass = *target;
    pass.pixels = worker->pass;
    for (size_t begin = 0; begin < job->part_count;) {
        size_t end = begin + 1;
        while (end < job->part_count &&
               job->first_primitives[end + 1] - job->first_primitives[begin] <= job->ids_per_pass) {
            end += 1;
        }
        memset(worker->pass, 0xFF, pixel_count * sizeof(uint64_t));
        stp_result result = stp_capture_draw_parts(job, band, begin, end, &pass, &worker->scratch);
        if (result != STP_OK) {
            return result;
        }
        merge_pass(worker, pixel_count, job->first_primitives[begin]);
        begin = end;
    }
    return draw_sets_in_passes(job, band, &pass, pixel_count, worker);
}

static stp_result draw_in_one_pass(const stp_capture_job* job, const stp_capture_band* band,
                                   const stp_raster_target* target, size_t pixel_count,
                                   draw_worker* worker)
{
    assert(stp_capture_primitive_count(job) <= job->ids_per_pass);
    memset(worker->pixels, 0xFF, pixel_count * sizeof(uint64_t));
    stp_result result = STP_OK;
    if (job->part_count != 0) {
        result = stp_capture_draw_parts(job, band, 0, job->part_count, target, &worker->scratch);
    }
    return result == STP_OK ? stp_capture_draw_sets(job, band, 0, job->set_count,
                                                    (uint32_t)stp_capture_part_primitives(job),
                                                    target, &worker->scratch)
                            : result;
}

/// Whether eight pixels are all empty. In fill views most are, once known surface is dropped.
static inline bool is_empty_group(const uint64_t* pixels)
{
    uint64_t all = STP_RASTER_EMPTY;
    for (size_t k = 0; k < GROUP; ++k) {
        all &= pixels[k];
    }
    return all == STP_RASTER_EMPTY;
}

static size_t count_covered(const uint64_t* pixels, size_t pixel_count)
{
    size_t count = 0, i = 0;
    for (; i + GROUP <= pixel_count; i += GROUP) {
        if (is_empty_group(pixels + i)) {
            continue;
        }
        for (size_t k = 0; k < GROUP; ++k) {
            count += pixels[i + k] != STP_RASTER_EMPTY;
        }
    }
    for (; i < pixel_count; ++i) {
        count += pixels[i] != STP_RASTER_EMPTY;
    }
    return count;
}

/// Records the covered pixels of a band.
static void mark_silhouette(const stp_capture_view* view, const stp_capture_band* band,
                            const uint64_t* pixels)
{
    uint32_t stride = stp_silhouette_stride(view->width);
    assert(band->row_end <= view->height);
    for (uint32_t row = band->row_begin; row < band->row_end; ++row) {
        const uint64_t* from = pixels + (size_t)(row - band->row_begin) * view->width;
        uint32_t* words = view->silhouette + (size_t)row * stride;
        for (uint32_t x = 0; x < view->width; ++x) {
            words[x / 32] |= (uint32_t)(from[x] != STP_RASTER_EMPTY) << (x % 32);
        }
    }
}

/// Extracts the covered pixels of a band.
static stp_result compact_pixels(stp_context* context, const draw_worker* worker, bool passes,
                                 size_t first, size_t pixel_count, stp_capture_band* band)
{
    const uint64_t* pixels = worker->pixels;
    size_t count = count_covered(pixels, pixel_count);
    if (count == 0) {
        return STP_OK;
    }
    // one extra: each pixel is written unconditionally to the next free place
    band->pixels = STP_NEW_ARRAY(context, uint32_t, count + 1);
    band->primitives = STP_NEW_ARRAY(context, uint64_t, count + 1);
    if (band->pixels == NULL || band->primitives == NULL) {
        return STP_ERROR_OUT_OF_MEMORY;
    }
    assert(count <= pixel_count && band->count == 0);
    band->count = (uint32_t)count;
    for (size_t i = 0, out = 0; out < count;) {
        size_t end = i + GROUP < pixel_count ? i + GROUP : pixel_count;
        if (end - i == GROUP && is_empty_group(pixels + i)) {
            i = end;
            continue;
        }
        for (; i < end; ++i) {
            assert(out <= count && "room for one more than there are");
            band->pixels[out] = (uint32_t)(first + i);
            band->primitives[out] = passes ? worker->primitives[i] : stp_raster_id(pixels[i]);
            out += pixels[i] != STP_RASTER_EMPTY;
        }
    }
    return STP_OK;
}

static bool prepare_worker(stp_context* context, draw_worker* worker, size_t band_pixels,
                           bool passes)
{
    if (worker->pixels == NULL) {
        worker->scratch = stp_arena_create(context, 4096);
        worker->pixels = STP_NEW_ARRAY(context, uint64_t, band_pixels);
        worker->pass = passes ? STP_NEW_ARRAY(context, uint64_t, band_pixels) : NULL;
        worker->primitives = passes ? STP_NEW_ARRAY(context, uint64_t, band_pixels) : NULL;
    }
    return worker->pixels != NULL &&
           (!passes || (worker->pass != NULL && worker->primitives != NULL));
}

static void draw_bands(size_t begin, size_t end, uint32_t worker_index, void* user)
{
    draw_state* state = user;
    stp_capture_job* job = state->job;
    stp_context* context = job->scene->context;
    draw_worker* worker = &state->workers[worker_index];
    for (size_t i = begin; i < end && !atomic_load(&state->failed); ++i) {
        stp_capture_band* band = &job->bands[state->first_band + i];
        const stp_capture_view* view = &job->views[band->view];
        if (!prepare_worker(context, worker, state->band_pixels, state->passes)) {
            atomic_store(&state->failed, true);
            return;
        }
        size_t first = (size_t)band->row_begin * view->width;
        size_t pixel_count = (size_t)(band->row_end - band->row_begin) * view->width;
        assert(pixel_count <= state->band_pixels && first + pixel_count <= UINT32_MAX);
        stp_raster_target target = {
            .width = view->width,
            .height = band->row_end - band->row_begin,
            .stride = view->width,
            .pixels = worker->pixels,
        };
        stp_result result = state->passes
                                ? draw_in_passes(job, band, &target, pixel_count, worker)
                                : draw_in_one_pass(job, band, &target, pixel_count, worker);
        if (result == STP_OK && view->silhouette != NULL) {
            mark_silhouette(view, band, target.pixels);
        }
        if (result == STP_OK) {
            stp_capture_take_splats(job, band, &target, state->passes ? worker->primitives : NULL);
            if (job->represented != NULL) {
                stp_fill_drop_known(job->represented, view, band->row_begin, &target);
            }
            result = compact_pixels(context, worker, state->passes, first, pixel_count, band);
        }
        if (result != STP_OK) {
            atomic_store(&state->failed, true);
        }
    }
}

/// Cuts the views into bands: few, as each band draws everything that touches it, but within the
/// buffer limit and enough for all threads.
static stp_result make_bands(stp_capture_job* job, uint32_t begin, uint32_t end,
                             size_t* band_pixels)
{
    stp_context* context = job->scene->context;
    uint32_t threads = stp_context_thread_count(context);
    uint32_t parallel = threads > 1 ? (2 * threads + end - begin - 1) / (end - begin) : 1;
    size_t capacity = job->band_count;
    *band_pixels = 0;
    for (uint32_t v = begin; v < end; ++v) {
        const stp_capture_view* view = &job->views[v];
        uint64_t maximum = BAND_BYTES / sizeof(uint64_t) / view->width;
        uint64_t even = ((uint64_t)view->height + parallel - 1) / parallel;
        uint32_t rows = (uint32_t)(even < maximum ? even : maximum);
        rows = rows > 0 ? rows : 1;
        for (uint32_t row = 0; row < view->height; row += rows) {
            if (!STP_MAKE_ROOM(context, job->bands, capacity, job->band_count + 1)) {
                return STP_ERROR_OUT_OF_MEMORY;
            }
            uint32_t left = view->height - row;
            uint32_t row_end = row + (left < rows ? left : rows);
            assert(row < row_end && row_end <= view->height);
            job->bands[job->band_count++] =
                (stp_capture_band){.view = v, .row_begin = row, .row_end = row_end};
        }
        size_t largest = (size_t)rows * view->width;
        *band_pixels = largest > *band_pixels ? largest : *band_pixels;
    }
    return STP_OK;
}

void stp_capture_drop_bands(stp_capture_job* job)
{
    stp_context* context = job->scene->context;
    for (size_t i = 0; i < job->band_count; ++i) {
        stp_free(context, job->bands[i].pixels);
        stp_free(context, job->bands[i].primitives);
    }
    stp_free(context, job->bands);
    job->bands = NULL;
    job->band_count = 0;
    job->covered_pixels = 0;
    for (uint32_t v = 0; job->keeps_silhouettes && v < job->view_count; ++v) {
        stp_free(context, job->views[v].silhouette);
        job->views[v].silhouette = NULL;
    }
}

/// Allocates the silhouettes of views [begin, end), unless they exceed the limit together.
static stp_result make_silhouettes(const stp_capture_job* job, uint32_t begin, uint32_t end)
{
    uint64_t bytes = 0;
    for (uint32_t v = 0; v < job->view_count && v < STP_SILHOUETTES; ++v) {
        bytes += 4 * (uint64_t)stp_silhouette_stride(job->views[v].width) * job->views[v].height;
    }
    if (!job->keeps_silhouettes || bytes > SILHOUETTE_BYTES) {
        return STP_OK;
    }
    for (uint32_t v = begin; v < end && v < STP_SILHOUETTES; ++v) {
        stp_capture_view* view = &job->views[v];
        size_t words = (size_t)stp_silhouette_stride(view->width) * view->height;
        view->silhouette = STP_NEW_ZEROED(job->scene->context, uint32_t, words);
        if (view->silhouette == NULL) {
            return STP_ERROR_OUT_OF_MEMORY;
        }
    }
    return STP_OK;
}

stp_result stp_capture_draw(stp_capture_job* job, uint32_t begin, uint32_t end)
{
    assert(begin <= end && end <= job->view_count);
    if (begin == end) { // the probe has drawn the only view
        return STP_OK;
    }
    stp_context* context = job->scene->context;
    draw_state state = {
        .job = job,
        .first_band = job->band_count,
        .passes = stp_capture_primitive_count(job) > job->ids_per_pass,
    };
    atomic_init(&state.failed, false);
    uint32_t threads = stp_context_thread_count(context);
    state.workers = STP_NEW_ZEROED(context, draw_worker, threads);
    if (state.workers == NULL || make_silhouettes(job, begin, end) != STP_OK ||
        make_bands(job, begin, end, &state.band_pixels) != STP_OK) {
        stp_free(context, state.workers);
        stp_capture_drop_bands(job);
        return stp_fail_memory(context);
    }
    stp_parallel_for(context, job->band_count - state.first_band, 1, draw_bands, &state);
    for (uint32_t i = 0; i < threads; ++i) {
        stp_free(context, state.workers[i].pixels);
        stp_free(context, state.workers[i].pass);
        stp_free(context, state.workers[i].primitives);
        if (state.workers[i].scratch.context != NULL) {
            stp_arena_destroy(&state.workers[i].scratch);
        }
    }
    stp_free(context, state.workers);
    if (atomic_load(&state.failed)) {
        stp_capture_drop_bands(job);
        return stp_fail_memory(context);
    }
    for (size_t i = state.first_band; i < job->band_count; ++i) {
        job->covered_pixels += job->bands[i].count;
    }
    return STP_OK;
}
