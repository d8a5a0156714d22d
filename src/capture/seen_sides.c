// SPDX-License-Identifier: MIT
#include "capture/seen_sides.h"

#include "base/core/arena.h"
#include "capture/capture.h"
#include "raster/triangles.h"

#include <assert.h>
#include <stdatomic.h>
#include <string.h>

enum {
    DEFAULT_DIRECTIONS = 96,
    DEFAULT_RESOLUTION = 512,
    MARGIN_PIXELS = 2, ///< around a picture, for rounding
    ROUNDS_MAX = 64,   ///< of distances that spread by at least an edge each
    COPIED = 4096,     ///< triangles that share copies of their vertices
};

/// A pixel counts if its centre is at least this far within its triangle, in pixels. Closer to an
/// edge, rounding may draw the hidden side of a closed surface's outline. Above the shift of a
/// corner by the sub-pixel grid.
#define CLEAR_MARGIN (1.0 / 256.0)

/// Distance in pixels, along the surface, up to which sides next to seen ones count as seen. Pixels
/// miss tiny triangles, and the directions miss surface behind narrow gaps.
#define COMPLETION_REACH 3.0f

/// Parallel projection: pixels of a point are right . p + shift_x, down . p + shift_y, with p
/// relative to the centre.
typedef struct seen_view {
    stp_vec3d toward;      ///< unit, towards the viewer
    stp_vec3d right, down; ///< per pixel
    double shift_x, shift_y;
    uint32_t width, height;
} seen_view;

/// Per-thread state.
typedef struct seen_worker {
    stp_arena scratch;
    uint64_t* pixels; ///< of the pictures (count_pictures): the first one's, and then others
    uint8_t* sides;   ///< per triangle: sides seen by this thread
} seen_worker;

typedef struct seen_job {
    stp_context* context;
    const float* positions;
    const uint32_t* indices;
    uint32_t vertex_count, triangle_count, resolution;
    const stp_vec3d* directions; ///< of which the opposite ones are meant as well
    const stp_vec3* normals;     ///< per triangle, unit; zero: without area
    stp_vec3 center;             ///< of the bounding box
    stp_vec3d half_extent;       ///< of the bounding box
    double pixel_size;
    /// The mesh as it is drawn: relative to the centre, and each run of COPIED triangles with its
    /// own vertices, so that they follow each other
    float* drawn_positions;
    uint32_t* drawn_indices;
    uint32_t drawn_count;      ///< vertices
    const uint8_t* front_only; ///< as in the desc; NULL if no triangle is drawn from the front only
    /// Of the drawn triangles; NULL: the same. Those drawn from both sides come first
    uint32_t* numbers;
    uint32_t two_sided; ///< how many they are
    seen_worker* workers;
    atomic_bool failed;
} seen_job;

/// A corner relative to the centre.
static stp_vec3d corner_of(const seen_job* job, uint32_t triangle, uint32_t corner)
{
    uint32_t vertex = job->indices[3 * (size_t)triangle + corner];
    assert(vertex < job->vertex_count);
    const float* p = job->positions + 3 * (size_t)vertex;
    return (stp_vec3d){(double)p[0] - (double)job->center.x, (double)p[1] - (double)job->center.y,
                       (double)p[2] - (double)job->center.z};
}

/// The box around all triangles, and the pixels that follow from it.
/// @return false if it is a point: nothing has area
static bool measure(seen_job* job)
{
    stp_box box = stp_box_empty();
    for (size_t i = 0; i < 3 * (size_t)job->triangle_count; ++i) {
        assert(job->indices[i] < job->vertex_count);
        stp_vec3 p;
        memcpy(&p, job->positions + 3 * (size_t)job->indices[i], sizeof(p));
        assert(stp_is_finite(p));
        stp_box_add(&box, p);
    }
    job->center =
        (stp_vec3){box.min.x * 0.5f + box.max.x * 0.5f, box.min.y * 0.5f + box.max.y * 0.5f,
                   box.min.z * 0.5f + box.max.z * 0.5f};
    // the centre is rounded, so take the larger half
    stp_vec3d center = stp_to_double(job->center), low = stp_subd(center, stp_to_double(box.min)),
              high = stp_subd(stp_to_double(box.max), center);
    job->half_extent =
        (stp_vec3d){stp_maxd(low.x, high.x), stp_maxd(low.y, high.y), stp_maxd(low.z, high.z)};
    job->pixel_size = 2.0 * stp_lengthd(job->half_extent) / (double)job->resolution;
    return job->pixel_size > 0.0;
}

static void find_normals(const seen_job* job, stp_vec3* normals)
{
    for (uint32_t t = 0; t < job->triangle_count; ++t) {
        stp_vec3d a = corner_of(job, t, 0);
        stp_vec3d cross =
            stp_crossd(stp_subd(corner_of(job, t, 1), a), stp_subd(corner_of(job, t, 2), a));
        normals[t] = stp_to_float(stp_normalized(cross));
    }
}

/// Puts triangles that are drawn from both sides before the others. @return false if out of memory
static bool order_triangles(seen_job* job)
{
    job->two_sided = 0;
    for (uint32_t t = 0; t < job->triangle_count; ++t) {
        job->two_sided += job->front_only == NULL || job->front_only[t] == 0 ? 1 : 0;
    }
    if (job->two_sided == job->triangle_count) {
        job->front_only = NULL; // no need to look without backs
    }
    if (job->front_only == NULL || job->two_sided == 0) {
        return true;
    }
    uint32_t at = 0;
    job->numbers = STP_NEW_ARRAY(job->context, uint32_t, job->triangle_count);
    for (int pass = 0; pass < 2 && job->numbers != NULL; ++pass) {
        for (uint32_t t = 0; t < job->triangle_count; ++t) {
            if ((job->front_only[t] != 0) == (pass == 1)) {
                job->numbers[at++] = t;
            }
        }
    }
    return job->numbers != NULL;
}

/// Copies the mesh as it is drawn. @return false if out of memory
static bool copy_mesh(seen_job* job)
{
    size_t corners = 3 * (size_t)job->triangle_count;
    uint32_t first = 0; // of the run's vertices
    uint32_t* copies = STP_NEW_ARRAY(job->context, uint32_t, job->vertex_count);
    job->drawn_positions = STP_NEW_ARRAY(job->context, float, 3 * corners);
    job->drawn_indices = STP_NEW_ARRAY(job->context, uint32_t, corners);
    bool enough = copies != NULL && job->drawn_positions != NULL && job->drawn_indices != NULL &&
                  order_triangles(job);
    for (uint32_t v = 0; v < job->vertex_count && enough; ++v) {
        copies[v] = UINT32_MAX;
    }
    for (size_t i = 0; i < corners && enough; ++i) {
        size_t t = job->numbers != NULL ? job->numbers[i / 3] : i / 3;
        uint32_t v = job->indices[3 * t + i % 3];
        first = i % (3 * (size_t)COPIED) == 0 ? job->drawn_count : first;
        if (copies[v] == UINT32_MAX || copies[v] < first) {
            const float* p = job->positions + 3 * (size_t)v;
            float* to = job->drawn_positions + 3 * (size_t)job->drawn_count;
            to[0] = p[0] - job->center.x;
            to[1] = p[1] - job->center.y;
            to[2] = p[2] - job->center.z;
            copies[v] = job->drawn_count++;
        }
        job->drawn_indices[i] = copies[v];
    }
    stp_free(job->context, copies);
    return enough;
}

static double extent_along(const seen_job* job, stp_vec3d axis)
{
    stp_vec3d h = job->half_extent;
    return 2.0 * (fabs(axis.x) * h.x + fabs(axis.y) * h.y + fabs(axis.z) * h.z);
}

static seen_view make_view(const seen_job* job, stp_vec3d toward)
{
    // edges along the axes should not run along rows or columns, where one that meets a pixel's
    // centre meets many
    stp_vec3d up = {0.48, 0.6, 0.64}, other = {0.8, -0.36, 0.48};
    up = fabs(stp_dotd(up, toward)) > 0.9 ? other : up;
    stp_vec3d right = stp_normalized(stp_crossd(up, toward)), down = stp_crossd(right, toward);
    seen_view view = {.toward = toward,
                      .right = stp_scaled(right, 1.0 / job->pixel_size),
                      .down = stp_scaled(down, 1.0 / job->pixel_size)};
    view.width = (uint32_t)extent_along(job, view.right) + 1 + MARGIN_PIXELS;
    view.height = (uint32_t)extent_along(job, view.down) + 1 + MARGIN_PIXELS;
    view.shift_x = 0.5 * (double)view.width;
    view.shift_y = 0.5 * (double)view.height;
    return view;
}

/// Pixels of the largest picture.
static size_t count_pixels(const seen_job* job)
{
    // extents are at most the diagonal; one more for rounding
    size_t side = (size_t)job->resolution + 2 + MARGIN_PIXELS;
    return side * side;
}

/// Pictures of a view: the view, that from behind as the last, and between them one whose content
/// does not matter, if some triangles are drawn from the front only.
static size_t count_pictures(const seen_job* job)
{
    return job->front_only != NULL ? 3 : 2;
}

static stp_raster_matrix make_matrix(const seen_job* job, const seen_view* view)
{
    stp_vec3d depth = stp_scaled(view->toward, 0.4 / stp_lengthd(job->half_extent));
    const stp_vec3d axes[3] = {view->right, view->down, depth};
    const double shifts[3] = {view->shift_x, view->shift_y, 0.5};
    stp_raster_matrix matrix = {.m = {[3] = {0.0f, 0.0f, 0.0f, 1.0f}}};
    for (int r = 0; r < 3; ++r) {
        matrix.m[r][0] = (float)axes[r].x;
        matrix.m[r][1] = (float)axes[r].y;
        matrix.m[r][2] = (float)axes[r].z;
        matrix.m[r][3] = (float)shifts[r];
    }
    return matrix;
}

/// Draws `count` triangles from `first` on, of those the ones of a facing (stp_raster_mesh), into a
/// picture, and `behind` pictures farther into that from behind.
static stp_result draw_some(const seen_job* job, const seen_view* view, uint32_t first,
                            uint32_t count, int32_t facing, size_t picture, size_t behind,
                            seen_worker* worker)
{
    size_t pixel_count = (size_t)view->width * view->height;
    assert(picture + behind < count_pictures(job));
    stp_raster_matrix matrix = make_matrix(job, view);
    stp_raster_target target = {.width = view->width,
                                .height = view->height,
                                .stride = view->width,
                                .pixels = worker->pixels + picture * pixel_count};
    stp_raster_mesh mesh = {.positions = job->drawn_positions,
                            .vertex_count = job->drawn_count,
                            .indices = job->drawn_indices + 3 * (size_t)first,
                            .triangle_count = count,
                            .numbers = job->numbers != NULL ? job->numbers + first : NULL,
                            .facing = facing,
                            .behind = behind * pixel_count};
    return count == 0 ? STP_OK
                      : stp_raster_triangles(&target, 0, view->height, &matrix, 1.0f, &mesh, 0,
                                             &worker->scratch);
}

/// Draws the view, and that from behind. @param culls without backs of triangles whose backs are
/// not drawn
static stp_result draw(const seen_job* job, const seen_view* view, bool culls, seen_worker* worker)
{
    size_t pixel_count = (size_t)view->width * view->height, last = count_pictures(job) - 1;
    assert(pixel_count <= count_pixels(job));
    memset(worker->pixels, 0xFF, (last + 1) * pixel_count * sizeof(uint64_t));
    if (!culls) {
        return draw_some(job, view, 0, job->triangle_count, 0, 0, last, worker);
    }
    uint32_t first = job->two_sided, count = job->triangle_count - first;
    stp_result result = draw_some(job, view, 0, first, 0, 0, last, worker);
    // rows go down: the corners of fronts turn the other way
    result = result == STP_OK ? draw_some(job, view, first, count, -1, 0, 0, worker) : result;
    return result == STP_OK ? draw_some(job, view, first, count, 1, 1, last - 1, worker) : result;
}

/// Whether the centre of a pixel is clearly within a triangle whose given side faces the viewer of
/// the picture that is not from behind.
static bool is_clear(const seen_job* job, const seen_view* view, uint32_t triangle, uint8_t side,
                     uint32_t column, uint32_t row)
{
    double x[3], y[3]; // of the corners, from the pixel's centre
    for (uint32_t k = 0; k < 3; ++k) {
        stp_vec3d p = corner_of(job, triangle, k);
        x[k] = stp_dotd(view->right, p) + view->shift_x - ((double)column + 0.5);
        y[k] = stp_dotd(view->down, p) + view->shift_y - ((double)row + 0.5);
    }
    // rows go down: the corners of front sides turn the other way
    double sign = side == STP_SEEN_FRONT ? -1.0 : 1.0;
    bool clear = true;
    for (uint32_t k = 0; k < 3; ++k) {
        uint32_t next = (k + 1) % 3;
        double dx = x[next] - x[k], dy = y[next] - y[k];
        double within = sign * (x[k] * y[next] - y[k] * x[next]);
        clear = clear && within >= CLEAR_MARGIN * sqrt(dx * dx + dy * dy);
    }
    return clear;
}

/// Marks the sides that won pixels of a picture. What is marked already is not looked at again.
static void mark_seen(const seen_job* job, const seen_view* view, const uint64_t* picture,
                      bool from_behind, seen_worker* worker)
{
    const uint8_t both = STP_SEEN_FRONT | STP_SEEN_BACK;
    stp_vec3 toward = stp_to_float(view->toward);
    for (uint32_t row = 0; row < view->height; ++row) {
        const uint64_t* pixels = picture + (size_t)row * view->width;
        for (uint32_t column = 0; column < view->width; ++column) {
            if (pixels[column] == STP_RASTER_EMPTY) {
                continue;
            }
            uint32_t t = stp_raster_id(pixels[column]);
            assert(t < job->triangle_count);
            if (worker->sides[t] == both) {
                continue;
            }
            float cosine = stp_dot(job->normals[t], toward);
            uint8_t facing = cosine > 0.0f ? STP_SEEN_FRONT : cosine < 0.0f ? STP_SEEN_BACK : 0;
            uint8_t side = from_behind && facing != 0 ? facing ^ both : facing;
            if ((side & ~worker->sides[t]) != 0 && is_clear(job, view, t, facing, column, row)) {
                worker->sides[t] |= side;
            }
        }
    }
}

static bool prepare_worker(const seen_job* job, seen_worker* worker)
{
    if (worker->scratch.context == NULL) {
        worker->scratch = stp_arena_create(job->context, 4096);
        worker->pixels =
            STP_NEW_ARRAY(job->context, uint64_t, count_pictures(job) * count_pixels(job));
        worker->sides = STP_NEW_ZEROED(job->context, uint8_t, job->triangle_count);
    }
    return worker->pixels != NULL && worker->sides != NULL;
}

static void look(size_t begin, size_t end, uint32_t worker_index, void* user)
{
    seen_job* job = user;
    seen_worker* worker = &job->workers[worker_index];
    for (size_t i = begin; i < end && !atomic_load(&job->failed); ++i) {
        seen_view view = make_view(job, job->directions[i]);
        for (int pass = 0; pass < (job->front_only != NULL ? 2 : 1); ++pass) {
            if (!prepare_worker(job, worker) || draw(job, &view, pass == 1, worker) != STP_OK) {
                atomic_store(&job->failed, true);
                return;
            }
            size_t last = count_pictures(job) - 1;
            const uint64_t* behind = worker->pixels + last * (size_t)view.width * view.height;
            mark_seen(job, &view, worker->pixels, false, worker);
            mark_seen(job, &view, behind, true, worker);
        }
    }
}

/// Joins what the threads have seen, and frees their memory.
static void join_workers(const seen_job* job, uint32_t threads, uint8_t* sides)
{
    memset(sides, 0, job->triangle_count);
    for (uint32_t i = 0; i < threads; ++i) {
        seen_worker* worker = &job->workers[i];
        for (uint32_t t = 0; t < job->triangle_count && worker->sides != NULL; ++t) {
            sides[t] |= worker->sides[t];
        }
        stp_free(job->context, worker->pixels);
        stp_free(job->context, worker->sides);
        if (worker->scratch.context != NULL) {
            stp_arena_destroy(&worker->scratch);
        }
    }
}

/// Length of the edge opposite a corner, in pixels.
static float edge_length(const seen_job* job, uint32_t triangle, uint32_t opposite)
{
    stp_vec3d a = corner_of(job, triangle, (opposite + 1) % 3);
    stp_vec3d b = corner_of(job, triangle, (opposite + 2) % 3);
    return (float)(stp_lengthd(stp_subd(a, b)) / job->pixel_size);
}

/// Shortens the distances of an edge's ends. @return whether one has changed
static bool relax_edge(float* a, float* b, float length)
{
    float from_a = *a + length, from_b = *b + length;
    bool shorter_a = from_b < *a && from_b <= COMPLETION_REACH;
    bool shorter_b = from_a < *b && from_a <= COMPLETION_REACH;
    *a = shorter_a ? from_b : *a;
    *b = shorter_b ? from_a : *b;
    return shorter_a || shorter_b;
}

/// Distance in pixels, along edges, of each vertex from the nearest triangle with a seen side;
/// FLT_MAX: beyond COMPLETION_REACH.
static void find_distances(const seen_job* job, const uint8_t* sides, uint8_t side,
                           float* distances)
{
    for (uint32_t v = 0; v < job->vertex_count; ++v) {
        distances[v] = FLT_MAX;
    }
    for (size_t i = 0; i < 3 * (size_t)job->triangle_count; ++i) {
        if ((sides[i / 3] & side) != 0) {
            distances[job->indices[i]] = 0.0f;
        }
    }
    bool changed = true;
    for (int round = 0; round < ROUNDS_MAX && changed; ++round) {
        changed = false;
        for (uint32_t t = 0; t < job->triangle_count; ++t) {
            const uint32_t* c = job->indices + 3 * (size_t)t;
            if ((sides[t] & side) != 0 ||
                (distances[c[0]] == distances[c[1]] && distances[c[1]] == distances[c[2]])) {
                continue;
            }
            for (uint32_t k = 0; k < 3; ++k) {
                float* a = &distances[c[(k + 1) % 3]];
                float* b = &distances[c[(k + 2) % 3]];
                if (*a != *b && relax_edge(a, b, edge_length(job, t, k))) {
                    changed = true;
                }
            }
        }
    }
}

static bool is_near(const seen_job* job, uint32_t triangle, const float* distances)
{
    const uint32_t* c = job->indices + 3 * (size_t)triangle;
    int count = (distances[c[0]] <= COMPLETION_REACH) + (distances[c[1]] <= COMPLETION_REACH) +
                (distances[c[2]] <= COMPLETION_REACH);
    return count >= 2;
}

/// Gives triangles the sides of seen ones near two of their corners.
static stp_result complete(const seen_job* job, uint8_t* sides)
{
    float* fronts = STP_NEW_ARRAY(job->context, float, job->vertex_count);
    float* backs = STP_NEW_ARRAY(job->context, float, job->vertex_count);
    bool enough = fronts != NULL && backs != NULL;
    if (enough) {
        find_distances(job, sides, STP_SEEN_FRONT, fronts);
        find_distances(job, sides, STP_SEEN_BACK, backs);
    }
    for (uint32_t t = 0; t < job->triangle_count && enough; ++t) {
        uint32_t added = (is_near(job, t, fronts) ? STP_SEEN_FRONT : 0u) |
                         (is_near(job, t, backs) ? STP_SEEN_BACK : 0u);
        sides[t] |= (uint8_t)added;
    }
    stp_free(job->context, fronts);
    stp_free(job->context, backs);
    return enough ? STP_OK : stp_fail_memory(job->context);
}

stp_result stp_find_seen_sides(stp_context* context, const float* positions, uint32_t vertex_count,
                               const uint32_t* indices, uint32_t triangle_count,
                               const stp_seen_desc* desc, uint8_t* sides)
{
    uint32_t count = desc->direction_count > 0 ? desc->direction_count : DEFAULT_DIRECTIONS;
    seen_job job = {.context = context,
                    .positions = positions,
                    .indices = indices,
                    .vertex_count = vertex_count,
                    .triangle_count = triangle_count,
                    .front_only = desc->front_only,
                    .resolution = desc->resolution > 0 ? desc->resolution : DEFAULT_RESOLUTION};
    assert(count % 2 == 0 && count > 26 && "half of the directions are opposite to the others");
    assert(job.resolution <= STP_SEEN_RESOLUTION_MAX && triangle_count < UINT32_MAX);
    if (triangle_count == 0) {
        return STP_OK;
    }
    if (!measure(&job)) {
        memset(sides, 0, triangle_count);
        return STP_OK;
    }
    uint32_t threads = stp_context_thread_count(context);
    stp_vec3d* directions = STP_NEW_ARRAY(context, stp_vec3d, count);
    stp_vec3* normals = STP_NEW_ARRAY(context, stp_vec3, triangle_count);
    job.workers = STP_NEW_ZEROED(context, seen_worker, threads);
    bool enough = directions != NULL && normals != NULL && job.workers != NULL && copy_mesh(&job);
    if (enough) {
        stp_capture_directions(count, directions);
        find_normals(&job, normals);
        job.directions = directions;
        job.normals = normals;
        atomic_init(&job.failed, false);
        stp_parallel_for(context, count / 2, 1, look, &job); // half of the spiral is half a sphere
        join_workers(&job, threads, sides);
        enough = !atomic_load(&job.failed);
    }
    stp_free(context, directions);
    stp_free(context, normals);
    stp_free(context, job.drawn_positions);
    stp_free(context, job.drawn_indices);
    stp_free(context, job.numbers);
    stp_free(context, job.workers);
    return enough ? complete(&job, sides) : stp_fail_memory(context);
}
