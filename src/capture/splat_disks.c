// SPDX-License-Identifier: MIT
// Splat sets in a capture (Brandt 3.4). They are drawn as disks, so that they occlude; the
// output is the splats themselves.
#include "capture/splat_disks.h"

#include "base/core/sort.h"
#include "base/splats/octahedral.h"
#include "raster/splats.h"

#include <assert.h>

// The rim of a disk is pushed back by this fraction of its radius, so that among overlapping disks
// the one with the nearest centre is visible. Disks seen from behind are pushed back further and
// hide nothing that faces the viewer.
#define RIM_DEPTH 0.5f
#define BACK_DEPTH 2.0f

// Disks of front-only materials are left out where they face away by more than this sine, as the
// renderers do (draw/facing.h).
#define BACK_SINE 0.25

#define CHUNK 2048u          // splats transformed at a time
#define SIMILAR 1e-4         // tolerance for rotation plus uniform scale
#define PIXELS_PER_SPLAT 4.0 // pixels worth testing to save one splat
#define BOX_SLACK 1e-5       // of nearness, for rounding

// Projection of a set's grid to the screen.
typedef struct set_projection {
    stp_affine placement; ///< own space to captured space minus its centre
    stp_vec3d origin;     ///< origin of the grid, placed
    /// x, y, nearness: of an offset in own space, and at the grid's origin
    double row[3][3], at_origin[3];
    double middle[3], reach[3]; ///< middle and half extent of the box of all disks
} set_projection;

static set_projection project_set(const stp_capture_job* job, const stp_capture_view* view,
                                  size_t set)
{
    set_projection out;
    const stp_placed_set* placed = &job->sets[set];
    out.placement = stp_capture_set_placement(job, set);
    out.origin = stp_affine_point(&out.placement, stp_to_double(placed->splats->origin));
    stp_boxd box = job->set_boxes[set];
    stp_vec3d centre = stp_subd(stp_scaled(stp_addd(box.min, box.max), 0.5), job->centre);
    stp_vec3d half = stp_scaled(stp_subd(box.max, box.min), 0.5);
    const stp_vec3d axes[3] = {view->right, view->down, view->depth};
    const double shifts[3] = {view->shift_x, view->shift_y, 1.5};
    for (int r = 0; r < 3; ++r) {
        out.at_origin[r] = stp_dotd(axes[r], out.origin) + shifts[r];
        out.middle[r] = stp_dotd(axes[r], centre) + shifts[r];
        out.reach[r] =
            fabs(axes[r].x) * half.x + fabs(axes[r].y) * half.y + fabs(axes[r].z) * half.z;
        for (int c = 0; c < 3; ++c) {
            stp_vec3d column = {out.placement.m[0][c], out.placement.m[1][c],
                                out.placement.m[2][c]};
            out.row[r][c] = stp_dotd(axes[r], column);
        }
    }
    return out;
}

// Whether disks of a set may touch the band.
static bool touches_band(const set_projection* p, const stp_capture_view* view,
                         const stp_capture_band* band)
{
    return p->middle[0] + p->reach[0] >= -1.0 &&
           p->middle[0] - p->reach[0] <= (double)view->width + 1.0 &&
           p->middle[1] + p->reach[1] >= (double)band->row_begin - 1.0 &&
           p->middle[1] - p->reach[1] <= (double)band->row_end + 1.0;
}

// Nearness of the nearest fragment, rounded up.
static float nearest_fragment(const set_projection* p)
{
    return (float)(p->middle[2] + p->reach[2]) + (float)BOX_SLACK;
}

// Whether the pixels drawn so far hide the whole set. Tested only if cheaper than drawing.
static bool is_hidden(const set_projection* p, const stp_raster_target* target, uint32_t first_row,
                      uint32_t splats)
{
    double right = (double)target->width - 1.0, bottom = (double)target->height - 1.0;
    double top = p->middle[1] - (double)first_row;
    size_t x0 = (size_t)stp_clampd(p->middle[0] - p->reach[0] - 1.0, 0.0, right);
    size_t x1 = (size_t)stp_clampd(p->middle[0] + p->reach[0] + 1.0, 0.0, right);
    size_t y0 = (size_t)stp_clampd(top - p->reach[1] - 1.0, 0.0, bottom);
    size_t y1 = (size_t)stp_clampd(top + p->reach[1] + 1.0, 0.0, bottom);
    assert(x0 <= x1 && y0 <= y1);
    if ((double)(x1 - x0 + 1) * (double)(y1 - y0 + 1) > PIXELS_PER_SPLAT * (double)splats) {
        return false;
    }
    uint64_t nearest = stp_raster_pixel(nearest_fragment(p), 0);
    for (size_t y = y0; y <= y1; ++y) {
        const uint64_t* pixels = target->pixels + y * target->stride;
        uint64_t farthest = 0;
        for (size_t x = x0; x <= x1; ++x) {
            farthest = pixels[x] > farthest ? pixels[x] : farthest;
        }
        if (farthest >= nearest) {
            return false;
        }
    }
    return true;
}

// Whether a transform is a rotation or reflection with translation and uniform scale.
static bool is_similar(const stp_affine* a)
{
    double product[3][3], trace = 0.0;
    for (int i = 0; i < 3; ++i) {
        for (int k = 0; k < 3; ++k) {
            product[i][k] =
                a->m[0][i] * a->m[0][k] + a->m[1][i] * a->m[1][k] + a->m[2][i] * a->m[2][k];
        }
        trace += product[i][i] / 3.0;
    }
    bool similar = true;
    for (int i = 0; i < 3; ++i) {
        for (int k = 0; k < 3; ++k) {
            double off = product[i][k] - (i == k ? trace : 0.0);
            similar = similar && fabs(off) <= SIMILAR * trace;
        }
    }
    return similar;
}

static stp_vec3d scaled_axis(stp_vec3d axis)
{
    return stp_scaled(axis, 1.0 / sqrt(stp_dotd(axis, axis)));
}

// Camera for points of a space. `linear` maps to the captured space; `at` is the origin's image.
static stp_raster_camera make_camera(const stp_capture_view* view, const stp_affine* linear,
                                     stp_vec3d at)
{
    stp_raster_camera camera = {.parallel = true, .nearness_limit = 4.0f};
    camera.matrix = (stp_raster_matrix){.m = {[3] = {0.0f, 0.0f, 0.0f, 1.0f}}};
    camera.pixel_scale = (float)sqrt(stp_dotd(view->right, view->right));
    const stp_vec3d axes[3] = {view->right, view->down, view->depth};
    const stp_vec3d turns[3] = {scaled_axis(view->right), scaled_axis(view->down),
                                stp_scaled(view->toward, -1.0)};
    const double shifts[3] = {view->shift_x, view->shift_y, 1.5};
    for (int r = 0; r < 3; ++r) {
        for (int c = 0; c < 3; ++c) {
            stp_vec3d column = {linear->m[0][c], linear->m[1][c], linear->m[2][c]};
            camera.matrix.m[r][c] = (float)stp_dotd(axes[r], column);
            camera.view[r][c] = (float)stp_dotd(turns[r], column);
        }
        camera.matrix.m[r][3] = (float)(stp_dotd(axes[r], at) + shifts[r]);
        camera.view[r][3] = (float)stp_dotd(turns[r], at);
    }
    return camera;
}

static bool may_drop_backs(const stp_capture_job* job, const stp_placed_set* placed)
{
    const bool* front_only = job->scene->front_only_shadings;
    bool any = false;
    for (size_t i = 0; i < sizeof(job->scene->front_only_shadings) && !any; ++i) {
        any = front_only[i];
    }
    return any && !placed->unknown_signs;
}

// Finds the splats [begin, end) that are drawn, one bit each. @return NULL, if all are; sets
// `enough` to false if memory is short
static const uint16_t* find_fronts(const stp_capture_job* job, const stp_capture_view* view,
                                   const stp_placed_set* placed, const stp_set_placing* placing,
                                   uint32_t begin, uint32_t end, stp_arena* scratch, bool* enough)
{
    if (!may_drop_backs(job, placed)) {
        return NULL;
    }
    uint16_t* fronts = STP_ARENA_ARRAY(scratch, uint16_t, (size_t)(end - begin) / 16 + 1);
    *enough = fronts != NULL;
    if (fronts == NULL) {
        return NULL;
    }
    memset(fronts, 0, ((size_t)(end - begin) / 16 + 1) * sizeof(*fronts));
    for (uint32_t i = begin; i < end; ++i) {
        bool drops = job->scene->front_only_shadings[placed->splats->materials[i]] &&
                     stp_dotd(stp_set_normal(placing, i), view->toward) < -BACK_SINE;
        fronts[(i - begin) / 16] |= (uint16_t)((drops ? 0u : 1u) << (i - begin) % 16);
    }
    return fronts;
}

// Draws a set under a similarity transform without copying it.
static stp_result draw_similar(const stp_capture_job* job, const stp_capture_band* band, size_t set,
                               const set_projection* projection, const stp_raster_target* target,
                               uint32_t first_id, stp_arena* scratch)
{
    const stp_placed_set* placed = &job->sets[set];
    const stp_splats* from = placed->splats;
    stp_set_entries look = stp_set_entries_of(from, placed->prefix);
    stp_raster_camera camera =
        make_camera(&job->views[band->view], &projection->placement, projection->origin);
    stp_arena_mark mark = stp_arena_get_mark(scratch);
    stp_set_placing placing = stp_set_placing_make(from, &projection->placement);
    bool enough = true;
    const uint16_t* fronts = find_fronts(job, &job->views[band->view], placed, &placing, 0,
                                         placed->prefix, scratch, &enough);
    if (!enough) {
        return STP_ERROR_OUT_OF_MEMORY;
    }
    stp_raster_splats splats = {.positions = from->positions,
                                .wanted = fronts,
                                .normals = from->normals,
                                .end = placed->prefix,
                                .step = from->step,
                                .radius = placed->radius,
                                .rim_depth = RIM_DEPTH,
                                .back_depth = placed->unknown_signs ? 0.0f : BACK_DEPTH,
                                .coverages = from->coverages + look.first};
    stp_raster_draw_splats(target, band->row_begin, band->row_end, &camera, &splats, first_id);
    stp_arena_rewind(scratch, mark);
    return STP_OK;
}

// Draws a set under a non-uniform transform, splat by splat. Disks stay round; their radius uses
// the largest scale.
static stp_result draw_stretched(const stp_capture_job* job, const stp_capture_band* band,
                                 size_t set, const set_projection* projection,
                                 const stp_raster_target* target, uint32_t first_id,
                                 stp_arena* scratch)
{
    stp_affine identity = stp_affine_identity();
    const stp_placed_set* placed = &job->sets[set];
    stp_set_entries look = stp_set_entries_of(placed->splats, placed->prefix);
    stp_raster_camera camera = make_camera(&job->views[band->view], &identity, projection->origin);
    stp_arena_mark mark = stp_arena_get_mark(scratch);
    float* points = STP_ARENA_ARRAY(scratch, float, 3 * (size_t)CHUNK);
    int8_t* normals = STP_ARENA_ARRAY(scratch, int8_t, 2 * (size_t)CHUNK);
    if (points == NULL || normals == NULL) {
        return STP_ERROR_OUT_OF_MEMORY;
    }
    stp_set_placing placing = stp_set_placing_make(placed->splats, &projection->placement);
    for (uint32_t begin = 0; begin < placed->prefix; begin += CHUNK) {
        uint32_t left = placed->prefix - begin, count = left < CHUNK ? left : CHUNK;
        for (uint32_t i = 0; i < count; ++i) {
            stp_vec3 at =
                stp_to_float(stp_subd(stp_set_position(&placing, begin + i), projection->origin));
            memcpy(points + 3 * (size_t)i, &at, sizeof(at));
            stp_octahedral_encode(stp_to_float(stp_set_normal(&placing, begin + i)),
                                  normals + 2 * (size_t)i);
        }
        bool enough = true;
        const uint16_t* fronts = find_fronts(job, &job->views[band->view], placed, &placing, begin,
                                             begin + count, scratch, &enough);
        if (!enough) {
            return STP_ERROR_OUT_OF_MEMORY;
        }
        stp_raster_splats splats = {
            .points = points,
            .wanted = fronts,
            .normals = normals,
            .end = count,
            .radius = (float)((double)placed->radius * stp_affine_stretch(&placed->transform)),
            .rim_depth = RIM_DEPTH,
            .back_depth = placed->unknown_signs ? 0.0f : BACK_DEPTH,
            .coverages = placed->splats->coverages + look.first + begin};
        stp_raster_draw_splats(target, band->row_begin, band->row_end, &camera, &splats,
                               first_id + begin);
    }
    stp_arena_rewind(scratch, mark);
    return STP_OK;
}

stp_result stp_capture_draw_sets(const stp_capture_job* job, const stp_capture_band* band,
                                 size_t begin, size_t end, uint32_t first_id,
                                 const stp_raster_target* target, stp_arena* scratch)
{
    assert(begin <= end && end <= job->set_count);
    assert(first_id + (job->first_splats[end] - job->first_splats[begin]) <= UINT32_MAX &&
           "ids are 32-bit numbers");
    if (begin == end) {
        return STP_OK;
    }
    const stp_capture_view* view = &job->views[band->view];
    stp_arena_mark mark = stp_arena_get_mark(scratch);
    uint64_t* keys = STP_ARENA_ARRAY(scratch, uint64_t, end - begin);
    uint64_t* spare = STP_ARENA_ARRAY(scratch, uint64_t, end - begin);
    if (keys == NULL || spare == NULL) {
        return STP_ERROR_OUT_OF_MEMORY;
    }
    size_t count = 0;
    for (size_t set = begin; set < end; ++set) {
        set_projection projection = project_set(job, view, set);
        if (touches_band(&projection, view, band)) {
            keys[count++] =
                stp_raster_pixel(nearest_fragment(&projection), (uint32_t)(set - begin));
        }
    }
    keys = stp_sort_u64(keys, spare, count, 32, 32);
    // the rasteriser counts rows from the picture's top; rows above the band are never touched
    stp_raster_target picture = *target;
    picture.height = view->height;
    size_t above = (size_t)band->row_begin * target->stride * sizeof(uint64_t);
    picture.pixels = (uint64_t*)((uintptr_t)target->pixels - above);
    stp_result result = STP_OK;
    for (size_t i = 0; i < count && result == STP_OK; ++i) {
        size_t set = begin + stp_raster_id(keys[i]);
        assert(set < end);
        set_projection projection = project_set(job, view, set);
        uint32_t id = first_id + (uint32_t)(job->first_splats[set] - job->first_splats[begin]);
        if (is_hidden(&projection, target, band->row_begin, job->sets[set].prefix)) {
            continue;
        }
        if (is_similar(&projection.placement)) {
            result = draw_similar(job, band, set, &projection, &picture, id, scratch);
        } else {
            result = draw_stretched(job, band, set, &projection, &picture, id, scratch);
        }
    }
    stp_arena_rewind(scratch, mark);
    return result;
}
