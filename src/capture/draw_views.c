// SPDX-License-Identifier: MIT
// The first half of a capture: from parts to covered pixels.
#include "base/rng.h"
#include "capture/capture_internal.h"
#include "raster/triangles.h"

#include <stdatomic.h>
#include <string.h>

/// A band's buffer takes at most this; taller pictures are drawn in more bands.
#define BAND_BYTES ((uint64_t)32 << 20)

/// Unit vectors across the direction of view.
static void view_axes(stp_vec3d toward, stp_vec3d* right, stp_vec3d* down)
{
    stp_vec3d up = fabs(toward.y) > 0.95 ? (stp_vec3d){0.0, 0.0, -1.0} : (stp_vec3d){0.0, 1.0, 0.0};
    *right = stp_normalized(stp_crossd(up, toward));
    *down = stp_crossd(*right, toward);
}

static double extent_along(const stp_capture_job* job, stp_vec3d axis)
{
    stp_vec3d h = job->half_extent;
    return 2.0 * (fabs(axis.x) * h.x + fabs(axis.y) * h.y + fabs(axis.z) * h.z);
}

double stp_capture_widest(const stp_capture_job* job, const stp_vec3d* directions, uint32_t count)
{
    double widest = 0.0;
    for (uint32_t i = 0; i < count; ++i) {
        stp_vec3d right, down;
        view_axes(directions[i], &right, &down);
        double width = extent_along(job, right), height = extent_along(job, down);
        widest = width > widest ? width : widest;
        widest = height > widest ? height : widest;
    }
    return widest;
}

void stp_capture_set_views(stp_capture_job* job, const stp_vec3d* directions, uint32_t count,
                           double pixel_size)
{
    double reach = sqrt(stp_dotd(job->half_extent, job->half_extent));
    reach = reach > 0.0 ? reach : 1.0;
    job->view_count = count;
    for (uint32_t i = 0; i < count; ++i) {
        stp_capture_view* view = &job->views[i];
        stp_vec3d right, down;
        view_axes(directions[i], &right, &down);
        // a pixel more on each side, for what rounding moves outwards
        view->width = (uint32_t)(extent_along(job, right) / pixel_size) + 3;
        view->height = (uint32_t)(extent_along(job, down) / pixel_size) + 3;
        view->shift_x = (double)view->width * 0.5;
        view->shift_y = (double)view->height * 0.5;
        view->toward = directions[i];
        view->right = stp_scaled(right, 1.0 / pixel_size);
        view->down = stp_scaled(down, 1.0 / pixel_size);
        view->depth = stp_scaled(directions[i], 0.4 / reach);
    }
}

/// A part's way to the screen, about the middle of its box.
typedef struct part_projection {
    double row[3][3], middle[3]; ///< x, y, nearness
    stp_vec3 offset;             ///< middle of the box, own space
    double reach[3];             ///< half the extent of the box in x, y, nearness
} part_projection;

static part_projection project_part(const stp_capture_job* job, const stp_capture_view* view,
                                    size_t part, const stp_box* box)
{
    part_projection out;
    stp_affine placement = stp_capture_placement(job, part);
    out.offset =
        (stp_vec3){box->min.x * 0.5f + box->max.x * 0.5f, box->min.y * 0.5f + box->max.y * 0.5f,
                   box->min.z * 0.5f + box->max.z * 0.5f};
    stp_vec3d half = stp_scaled(stp_subd(stp_to_double(box->max), stp_to_double(box->min)), 0.5);
    stp_vec3d centre = stp_affine_point(&placement, stp_to_double(out.offset));
    const stp_vec3d axes[3] = {view->right, view->down, view->depth};
    const double shifts[3] = {view->shift_x, view->shift_y, 1.5};
    for (int r = 0; r < 3; ++r) {
        out.middle[r] = stp_dotd(axes[r], centre) + shifts[r];
        for (int c = 0; c < 3; ++c) {
            stp_vec3d column = {placement.m[0][c], placement.m[1][c], placement.m[2][c]};
            out.row[r][c] = stp_dotd(axes[r], column);
        }
        out.reach[r] = fabs(out.row[r][0]) * half.x + fabs(out.row[r][1]) * half.y +
                       fabs(out.row[r][2]) * half.z;
    }
    return out;
}

/// Whether a range of the screen holds a pixel centre of [begin, end).
static bool holds_centre(double middle, double reach, uint32_t begin, uint32_t end)
{
    const double margin =
        1.0 / 64.0; // coordinates are snapped to 1/256, and rounded to float before
    double low = middle - reach - margin - 0.5, high = middle + reach + margin - 0.5;
    if (!(high >= (double)begin && low <= (double)end - 1.0)) {
        return false;
    }
    double first = low > 0.0 ? (double)(uint64_t)low : 0.0;
    first = first < low ? first + 1.0 : first;
    return first <= high;
}

/// What the mask of a part needs to answer.
typedef struct mask_state {
    const stp_mesh* mesh;
    const stp_material* material;
    stp_texture_pyramid level0;
    uint64_t first_primitive;
} mask_state;

static bool keep_masked(const void* user, uint32_t triangle, float weight1, float weight2,
                        uint32_t x, uint32_t y)
{
    const mask_state* state = user;
    float alpha =
        stp_capture_alpha(state->material, &state->level0, state->mesh, triangle, weight1, weight2);
    if (state->material->alpha_mode == STP_ALPHA_MASK) {
        return alpha >= state->material->alpha_cutoff;
    }
    if (alpha >= 254.5f / 255.0f) {
        return true;
    }
    uint64_t pixel = (uint64_t)y << 32 | x;
    return alpha >= 1.0f / 255.0f &&
           (stp_rng_hash(state->first_primitive + triangle, pixel) & 1) != 0;
}

/// What one thread works with.
typedef struct draw_worker {
    stp_arena scratch;
    uint64_t* pixels;     ///< room for the largest band
    uint64_t* pass;       ///< the same, where more than one pass is needed
    uint64_t* primitives; ///< of the nearest so far, where more than one pass is needed
} draw_worker;

typedef struct draw_state {
    stp_capture_job* job;
    draw_worker* workers;
    size_t band_pixels; ///< of the largest band
    bool passes;        ///< more than one is needed
    atomic_bool failed;
} draw_state;

static stp_result draw_mesh(const stp_capture_job* job, size_t part,
                            const part_projection* projection, const stp_raster_target* target,
                            const stp_capture_band* band, uint64_t pass_begin, stp_arena* scratch)
{
    const stp_mesh* mesh = &job->scene->meshes[job->parts[part].part.index];
    const stp_material* material = &job->scene->materials[mesh->material];
    bool masked = material->alpha_mode != STP_ALPHA_OPAQUE;
    mask_state mask = {
        .mesh = mesh, .material = material, .first_primitive = job->first_primitives[part]};
    if (masked) {
        mask.level0 = stp_capture_level0(job->scene, material);
    }
    stp_raster_matrix matrix = {.m = {[3] = {0.0f, 0.0f, 0.0f, 1.0f}}};
    for (int r = 0; r < 3; ++r) {
        for (int c = 0; c < 3; ++c) {
            matrix.m[r][c] = (float)projection->row[r][c];
        }
        matrix.m[r][3] = (float)projection->middle[r];
    }
    stp_raster_mesh drawn = {
        .positions = mesh->positions,
        .vertex_count = mesh->vertex_count,
        .indices = mesh->indices,
        .triangle_count = mesh->triangle_count,
        .offset = {projection->offset.x, projection->offset.y, projection->offset.z},
        .keep = masked ? keep_masked : NULL,
        .keep_user = &mask,
    };
    return stp_raster_triangles_in_band(target, band->row_begin, &matrix, 4.0f, &drawn,
                                        (uint32_t)(job->first_primitives[part] - pass_begin),
                                        scratch);
}

static void draw_points(const stp_capture_job* job, size_t part, const part_projection* projection,
                        const stp_raster_target* target, const stp_capture_band* band,
                        uint64_t pass_begin)
{
    const stp_point_set* points = &job->scene->point_sets[job->parts[part].part.index];
    uint32_t first_id = (uint32_t)(job->first_primitives[part] - pass_begin);
    for (uint32_t i = 0; i < points->point_count; ++i) {
        const float* p = points->positions + 3 * (size_t)i;
        double x = (double)(p[0] - projection->offset.x), y = (double)(p[1] - projection->offset.y);
        double z = (double)(p[2] - projection->offset.z), screen[3];
        for (int r = 0; r < 3; ++r) {
            const double* row = projection->row[r];
            screen[r] = row[0] * x + row[1] * y + row[2] * z + projection->middle[r];
        }
        if (screen[0] >= 0.0 && screen[0] < (double)target->width &&
            screen[1] >= (double)band->row_begin && screen[1] < (double)band->row_end) {
            uint64_t pixel = stp_raster_pixel((float)screen[2], first_id + i);
            size_t row = (size_t)screen[1] - band->row_begin;
            uint64_t* place = target->pixels + row * target->stride + (size_t)screen[0];
            *place = pixel < *place ? pixel : *place;
        }
    }
}

/// Draws parts [begin, end).
static stp_result draw_parts(const stp_capture_job* job, const stp_capture_band* band, size_t begin,
                             size_t end, const stp_raster_target* target, stp_arena* scratch)
{
    const stp_capture_view* view = &job->views[band->view];
    uint64_t pass_begin = job->first_primitives[begin];
    for (size_t part = begin; part < end; ++part) {
        stp_part which = job->parts[part].part;
        bool is_mesh = which.kind == STP_PART_MESH;
        const stp_box* box = is_mesh ? &job->scene->meshes[which.index].bounds
                                     : &job->scene->point_sets[which.index].bounds;
        part_projection projection = project_part(job, view, part, box);
        if (!is_mesh) {
            draw_points(job, part, &projection, target, band, pass_begin);
            continue;
        }
        if (!holds_centre(projection.middle[0], projection.reach[0], 0, view->width) ||
            !holds_centre(projection.middle[1], projection.reach[1], band->row_begin,
                          band->row_end)) {
            continue;
        }
        stp_result result = draw_mesh(job, part, &projection, target, band, pass_begin, scratch);
        if (result != STP_OK) {
            return result;
        }
    }
    return STP_OK;
}

/// Draws all parts in as many passes as 32-bit ids need; then worker->primitives holds what is
/// nearest.
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
               job->first_primitives[end + 1] - job->first_primitives[begin] <= job->ids_a_pass) {
            end += 1;
        }
        memset(worker->pass, 0xFF, pixel_count * sizeof(uint64_t));
        stp_result result = draw_parts(job, band, begin, end, &pass, &worker->scratch);
        if (result != STP_OK) {
            return result;
        }
        for (size_t i = 0; i < pixel_count; ++i) {
            if (worker->pass[i] >> 32 < worker->pixels[i] >> 32) {
                worker->pixels[i] = worker->pass[i];
                worker->primitives[i] =
                    job->first_primitives[begin] + stp_raster_id(worker->pass[i]);
            }
        }
        begin = end;
    }
    return STP_OK;
}

/// Keeps what is covered of a band.
static stp_result squeeze(stp_context* context, const draw_worker* worker, bool passes,
                          size_t first, size_t pixel_count, stp_capture_band* band)
{
    size_t count = 0;
    for (size_t i = 0; i < pixel_count; ++i) {
        count += worker->pixels[i] != STP_RASTER_EMPTY;
    }
    if (count == 0) {
        return STP_OK;
    }
    band->pixels = STP_NEW_ARRAY(context, uint32_t, count);
    band->primitives = STP_NEW_ARRAY(context, uint64_t, count);
    if (band->pixels == NULL || band->primitives == NULL) {
        return STP_ERROR_OUT_OF_MEMORY;
    }
    band->count = (uint32_t)count;
    for (size_t i = 0, out = 0; out < count; ++i) {
        if (worker->pixels[i] != STP_RASTER_EMPTY) {
            band->pixels[out] = (uint32_t)(first + i);
            band->primitives[out] =
                passes ? worker->primitives[i] : stp_raster_id(worker->pixels[i]);
            out += 1;
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
        stp_capture_band* band = &job->bands[i];
        const stp_capture_view* view = &job->views[band->view];
        if (!prepare_worker(context, worker, state->band_pixels, state->passes)) {
            atomic_store(&state->failed, true);
            return;
        }
        size_t first = (size_t)band->row_begin * view->width;
        size_t pixel_count = (size_t)(band->row_end - band->row_begin) * view->width;
        stp_raster_target target = {
            .width = view->width,
            .height = band->row_end - band->row_begin,
            .stride = view->width,
            .pixels = worker->pixels,
        };
        stp_result result = STP_OK;
        if (state->passes) {
            result = draw_in_passes(job, band, &target, pixel_count, worker);
        } else {
            memset(worker->pixels, 0xFF, pixel_count * sizeof(uint64_t));
            result = draw_parts(job, band, 0, job->part_count, &target, &worker->scratch);
        }
        if (result == STP_OK) {
            result = squeeze(context, worker, state->passes, first, pixel_count, band);
        }
        if (result != STP_OK) {
            atomic_store(&state->failed, true);
        }
    }
}

/// Cuts the views into bands: few, as each draws all that touches it, but no larger than a buffer
/// may be, and enough for all threads.
static stp_result make_bands(stp_capture_job* job, size_t* band_pixels)
{
    stp_context* context = job->scene->context;
    uint32_t threads = stp_context_thread_count(context);
    uint32_t parallel = threads > 1 ? (2 * threads + job->view_count - 1) / job->view_count : 1;
    size_t capacity = 0;
    *band_pixels = 0;
    for (uint32_t v = 0; v < job->view_count; ++v) {
        const stp_capture_view* view = &job->views[v];
        uint64_t most = BAND_BYTES / sizeof(uint64_t) / view->width;
        uint64_t even = ((uint64_t)view->height + parallel - 1) / parallel;
        uint32_t rows = (uint32_t)(even < most ? even : most);
        rows = rows > 0 ? rows : 1;
        for (uint32_t row = 0; row < view->height; row += rows) {
            stp_capture_band* grown = stp_grow_array(context, job->bands, &capacity,
                                                     job->band_count + 1, sizeof(*job->bands));
            if (grown == NULL) {
                return STP_ERROR_OUT_OF_MEMORY;
            }
            job->bands = grown;
            uint32_t left = view->height - row;
            uint32_t row_end = row + (left < rows ? left : rows);
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
}

stp_result stp_capture_draw(stp_capture_job* job)
{
    stp_context* context = job->scene->context;
    draw_state state = {
        .job = job,
        .passes = stp_capture_primitive_count(job) > job->ids_a_pass,
    };
    atomic_init(&state.failed, false);
    uint32_t threads = stp_context_thread_count(context);
    state.workers = STP_NEW_ZEROED(context, draw_worker, threads);
    if (state.workers == NULL || make_bands(job, &state.band_pixels) != STP_OK) {
        stp_free(context, state.workers);
        stp_capture_drop_bands(job);
        return stp_fail_memory(context);
    }
    stp_parallel_for(context, job->band_count, 1, draw_bands, &state);
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
    for (size_t i = 0; i < job->band_count; ++i) {
        job->covered_pixels += job->bands[i].count;
    }
    return STP_OK;
}
