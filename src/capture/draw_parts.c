// SPDX-License-Identifier: MIT
// Draws parts into the buffer of a band, nearest first, so that hidden parts can be skipped. The
// picture does not depend on the order.
#include "base/core/sort.h"
#include "base/math/rng.h"
#include "capture/capture_internal.h"
#include "capture/fill.h"
#include "raster/triangles.h"

#include <assert.h>
#include <string.h>

/// Pixels worth testing to save one triangle.
#define PIXELS_PER_TRIANGLE 4.0

/// Thresholds of 8-bit alpha: opaque, and not fully transparent.
#define ALPHA_OPAQUE (254.5f / 255.0f)
#define ALPHA_MIN (1.0f / 255.0f)

/// Projection of a part, relative to the middle of its box.
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

/// Whether a screen range contains a pixel centre of [begin, end).
static bool holds_centre(double middle, double reach, uint32_t begin, uint32_t end)
{
    assert(begin <= end);
    // coordinates are snapped to 1/256, and rounded to float before
    const double margin = 1.0 / 64.0;
    double low = middle - reach - margin - 0.5, high = middle + reach + margin - 0.5;
    if (!(high >= (double)begin && low <= (double)end - 1.0)) {
        return false;
    }
    double first = low > 0.0 ? (double)(uint64_t)low : 0.0;
    first = first < low ? first + 1.0 : first;
    return first <= high;
}

/// How the corners of fronts turn in the picture (stp_raster_mesh.facing): counter-clockwise to the
/// viewer, so clockwise where the axes of the picture are mirrored.
static int32_t front_turn(const part_projection* p)
{
    stp_affine turn = {0};
    for (int r = 0; r < 3; ++r) {
        memcpy(turn.m[r], p->row[r], sizeof(p->row[r]));
    }
    return -stp_affine_front_turn(&turn);
}

/// Nearness of the nearest corner of a part's box, an upper bound for drawn pixels.
static float nearest_point(const part_projection* projection)
{
    return (float)(projection->middle[2] + projection->reach[2]) + 1e-5f;
}

/// Inputs of a part's alpha mask.
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
    if (alpha >= ALPHA_OPAQUE) {
        return true;
    }
    uint64_t pixel = (uint64_t)y << 32 | x;
    return alpha >= ALPHA_MIN && (stp_rng_hash(state->first_primitive + triangle, pixel) & 1) != 0;
}

/// How a part's alpha mask behaves; alpha that is the same everywhere needs no test per pixel.
typedef enum mask_kind { MASK_NOTHING, MASK_ALL, MASK_ASK } mask_kind;

static mask_kind prepare_mask(const stp_capture_job* job, mask_state* mask)
{
    const stp_material* material = mask->material;
    if (material->alpha_mode == STP_ALPHA_OPAQUE) {
        return MASK_ALL;
    }
    mask->level0 = stp_capture_level0(job->scene, material);
    if (mask->level0.level_count != 0 || mask->mesh->colors != NULL) {
        return MASK_ASK;
    }
    float alpha = material->base_color[3];
    if (material->alpha_mode == STP_ALPHA_MASK) {
        return alpha >= material->alpha_cutoff ? MASK_ALL : MASK_NOTHING;
    }
    return alpha >= ALPHA_OPAQUE ? MASK_ALL : alpha >= ALPHA_MIN ? MASK_ASK : MASK_NOTHING;
}

static stp_result draw_mesh(const stp_capture_job* job, size_t part,
                            const part_projection* projection, const stp_raster_target* target,
                            const stp_capture_band* band, uint64_t pass_begin, stp_arena* scratch)
{
    const stp_mesh* mesh = &job->scene->meshes[job->parts[part].part.index];
    assert(job->first_primitives[part] >= pass_begin);
    assert(job->first_primitives[part + 1] - pass_begin <= UINT32_MAX && "ids are 32-bit numbers");
    mask_state mask = {
        .mesh = mesh,
        .material = &job->scene->materials[mesh->material],
        .first_primitive = job->first_primitives[part],
    };
    mask_kind kind = prepare_mask(job, &mask);
    if (kind == MASK_NOTHING) {
        return STP_OK;
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
        .keep = kind == MASK_ASK ? keep_masked : NULL,
        .keep_user = &mask,
        .facing = mask.material->front_only ? front_turn(projection) : 0,
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
    assert(job->first_primitives[part] >= pass_begin);
    assert(job->first_primitives[part + 1] - pass_begin <= UINT32_MAX && "ids are 32-bit numbers");
    uint32_t first_id = (uint32_t)(job->first_primitives[part] - pass_begin);
    for (uint32_t i = 0; i < points->point_count; ++i) {
        if (job->represented != NULL &&
            stp_fill_knows_point(job->represented, job->first_primitives[part] + i)) {
            continue;
        }
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
            assert(row < target->height);
            uint64_t* place = target->pixels + row * target->stride + (size_t)screen[0];
            *place = pixel < *place ? pixel : *place;
        }
    }
}

/// Sort key of a part that reaches into a band: nearness, descending, above the index.
static uint64_t part_key(const part_projection* projection, size_t index)
{
    return stp_raster_pixel(nearest_point(projection), (uint32_t)index);
}

/// Whether nearer geometry already covers every pixel the part could touch. Tested only if cheaper
/// than drawing.
static bool is_hidden(const part_projection* projection, const stp_raster_target* target,
                      uint32_t first_row, uint32_t triangle_count)
{
    const double margin = 1.0 / 64.0;
    double left = projection->middle[0] - projection->reach[0] - margin;
    double right = projection->middle[0] + projection->reach[0] + margin;
    double top = projection->middle[1] - projection->reach[1] - margin - (double)first_row;
    double bottom = projection->middle[1] + projection->reach[1] + margin - (double)first_row;
    left = left > 0.0 ? left : 0.0;
    top = top > 0.0 ? top : 0.0;
    right = right < (double)target->width - 1.0 ? right : (double)target->width - 1.0;
    bottom = bottom < (double)target->height - 1.0 ? bottom : (double)target->height - 1.0;
    if (!(left <= right && top <= bottom) || (right - left + 1.0) * (bottom - top + 1.0) >
                                                 PIXELS_PER_TRIANGLE * (double)triangle_count) {
        return false;
    }
    uint64_t nearest = stp_raster_pixel(nearest_point(projection), 0);
    size_t first = (size_t)left, last = (size_t)right;
    for (size_t row = (size_t)top; row <= (size_t)bottom; ++row) {
        const uint64_t* pixels = target->pixels + row * target->stride;
        uint64_t farthest = 0;
        for (size_t column = first; column <= last; ++column) {
            farthest = pixels[column] > farthest ? pixels[column] : farthest;
        }
        if (farthest >= nearest) {
            return false;
        }
    }
    return true;
}

/// Parts [begin, end) that may cover a pixel of the band, nearest first: keys in scratch memory.
static uint64_t* find_parts(const stp_capture_job* job, const stp_capture_band* band, size_t begin,
                            size_t end, stp_arena* scratch, size_t* count)
{
    const stp_capture_view* view = &job->views[band->view];
    uint64_t* keys = STP_ARENA_ARRAY(scratch, uint64_t, end - begin);
    uint64_t* spare = STP_ARENA_ARRAY(scratch, uint64_t, end - begin);
    if (keys == NULL || spare == NULL) {
        return NULL;
    }
    *count = 0;
    for (size_t part = begin; part < end; ++part) {
        part_projection projection = project_part(job, view, part, &job->boxes[part]);
        bool is_mesh = job->parts[part].part.kind == STP_PART_MESH;
        bool touches =
            !is_mesh || (holds_centre(projection.middle[0], projection.reach[0], 0, view->width) &&
                         holds_centre(projection.middle[1], projection.reach[1], band->row_begin,
                                      band->row_end));
        if (touches) {
            keys[(*count)++] = part_key(&projection, part - begin);
        }
    }
    return stp_sort_u64(keys, spare, *count, 32, 32);
}

/// Prefetches parts that are drawn soon, in the order of use. Small parts that follow each other in
/// depth are scattered in memory; waiting for them would take longer than drawing them.
static void prefetch_parts(const stp_capture_job* job, const uint64_t* keys, size_t left,
                           size_t begin)
{
    enum { PART = 12, MESH = 8, ARRAYS = 4, LINE = 64 };
    if (PART < left) {
        size_t part = begin + stp_raster_id(keys[PART]);
        __builtin_prefetch(&job->parts[part]);
        __builtin_prefetch((const char*)&job->parts[part] + LINE);
        __builtin_prefetch(&job->boxes[part]);
    }
    if (MESH < left) {
        stp_part which = job->parts[begin + stp_raster_id(keys[MESH])].part;
        if (which.kind == STP_PART_MESH) {
            __builtin_prefetch(&job->scene->meshes[which.index]);
            __builtin_prefetch((const char*)&job->scene->meshes[which.index] + LINE);
        }
    }
    if (ARRAYS < left) {
        stp_part which = job->parts[begin + stp_raster_id(keys[ARRAYS])].part;
        if (which.kind == STP_PART_MESH) {
            const stp_mesh* mesh = &job->scene->meshes[which.index];
            __builtin_prefetch(mesh->indices);
            __builtin_prefetch((const char*)mesh->indices + LINE);
            __builtin_prefetch(mesh->positions);
            __builtin_prefetch((const char*)mesh->positions + LINE);
        }
    }
}

stp_result stp_capture_draw_parts(const stp_capture_job* job, const stp_capture_band* band,
                                  size_t begin, size_t end, const stp_raster_target* target,
                                  stp_arena* scratch)
{
    assert(begin < end && end <= job->part_count);
    assert(target->height == band->row_end - band->row_begin);
    stp_arena_mark mark = stp_arena_get_mark(scratch);
    size_t count = 0;
    const uint64_t* keys = find_parts(job, band, begin, end, scratch, &count);
    stp_result result = keys != NULL ? STP_OK : STP_ERROR_OUT_OF_MEMORY;
    uint64_t pass_begin = job->first_primitives[begin];
    for (size_t i = 0; i < count && result == STP_OK; ++i) {
        size_t part = begin + stp_raster_id(keys[i]);
        assert(part < end);
        prefetch_parts(job, keys + i, count - i, begin);
        part_projection projection =
            project_part(job, &job->views[band->view], part, &job->boxes[part]);
        stp_part which = job->parts[part].part;
        if (which.kind == STP_PART_POINTS) {
            draw_points(job, part, &projection, target, band, pass_begin);
        } else if (!is_hidden(&projection, target, band->row_begin,
                              job->scene->meshes[which.index].triangle_count)) {
            result = draw_mesh(job, part, &projection, target, band, pass_begin, scratch);
        }
    }
    stp_arena_rewind(scratch, mark);
    return result;
}
