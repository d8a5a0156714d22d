// SPDX-License-Identifier: MIT
#include "raster/triangles.h"

#include "base/core/processor.h"
#include "raster/triangles_internal.h"

#include <assert.h>

// Triangles are drawn in chunks whose transformed vertices stay in the CPU cache. A chunk whose
// indices span too wide a range gets separate vertices for each corner: more work, but bounded
// memory.
enum { CHUNK_TRIANGLES = 4096, CHUNK_VERTICES = 3 * CHUNK_TRIANGLES };

typedef struct chunk_memory {
    int32_t x[CHUNK_VERTICES + STP_LANES_MAX];
    int32_t y[CHUNK_VERTICES + STP_LANES_MAX];
    float nearness[CHUNK_VERTICES + STP_LANES_MAX];
    uint32_t clipped[CHUNK_TRIANGLES];
} chunk_memory;

/// Positions and indices of a chunk of unconnected triangles.
typedef struct soup_memory {
    float positions[3 * CHUNK_VERTICES];
    uint32_t indices[CHUNK_VERTICES]; ///< 0, 1, 2 and so on
    size_t index_count;               ///< written so far
} soup_memory;

static const stp_triangle_kernels* choose_kernels(void)
{
    return STP_VARIANT(stp_processor_detect(), &stp_triangle_kernels);
}

/// A triangle with a test per fragment.
typedef struct kept_triangle {
    const stp_raster_mesh* mesh;
    uint32_t triangle, id;
    double corner[3][3]; ///< X, Y, W
} kept_triangle;

/// Perspective-correct weights: l with l0 v0 + l1 v1 + l2 v2 = 0, where v = (X - x W, Y - y W).
static void weights_at(const double corner[3][3], double x, double y, float* weight1,
                       float* weight2)
{
    double vx[3], vy[3];
    for (int k = 0; k < 3; ++k) {
        vx[k] = corner[k][0] - x * corner[k][2];
        vy[k] = corner[k][1] - y * corner[k][2];
    }
    double l0 = vx[1] * vy[2] - vy[1] * vx[2];
    double l1 = vx[2] * vy[0] - vy[2] * vx[0];
    double l2 = vx[0] * vy[1] - vy[0] * vx[1];
    double sign = l0 + l1 + l2 < 0.0 ? -1.0 : 1.0;
    l0 = l0 * sign > 0.0 ? l0 * sign : 0.0;
    l1 = l1 * sign > 0.0 ? l1 * sign : 0.0;
    l2 = l2 * sign > 0.0 ? l2 * sign : 0.0;
    double sum = l0 + l1 + l2;
    bool usable = sum > 0.0 && sum <= DBL_MAX;
    assert(!usable || (l1 <= sum && l2 <= sum));
    *weight1 = usable ? (float)(l1 / sum) : 0.0f;
    *weight2 = usable ? (float)(l2 / sum) : 0.0f;
}

static void draw_fragment(const kept_triangle* kept, const stp_triangle_window* window,
                          float nearness, int32_t x, int32_t y)
{
    const stp_raster_mesh* mesh = kept->mesh;
    uint64_t pixel = stp_raster_pixel(nearness, kept->id);
    uint64_t* place = stp_triangle_row(window, y) + x;
    const stp_raster_layer* layer = mesh->layer;
    if (layer != NULL && !stp_layer_has(layer, (size_t)(place - window->pixels), pixel)) {
        return;
    }
    bool nearest = pixel < *place;
    if (!nearest && (layer == NULL || !layer->tests_all)) {
        return;
    }
    float weight1, weight2;
    weights_at(kept->corner, (double)x + 0.5, (double)y + 0.5, &weight1, &weight2);
    if (mesh->keep(mesh->keep_user, kept->triangle, weight1, weight2, (uint32_t)x, (uint32_t)y) &&
        nearest) {
        *place = pixel;
    }
}

/// Like the kernels' draw_one, but tests each fragment.
static void draw_kept(const stp_triangle_window* window, const stp_screen_vertex corners[3],
                      const kept_triangle* kept)
{
    stp_triangle_setup setup;
    if (!stp_triangle_set_up(window, corners, &setup)) {
        return;
    }
    assert(setup.area > 0 && "oriented");
    stp_triangle_edge edges[3];
    for (int k = 0; k < 3; ++k) {
        edges[k] = stp_triangle_edge_make(setup.corner[(k + 1) % 3], setup.corner[(k + 2) % 3]);
    }
    stp_triangle_plane plane = stp_triangle_plane_make(&setup);
    float inverse_area = 1.0f / (float)setup.area;
    for (int32_t row = setup.top; row <= setup.bottom; ++row) {
        int64_t first = setup.left, last = setup.right;
        for (int k = 0; k < 3; ++k) {
            stp_triangle_edge_narrow(&edges[k], row, &first, &last);
        }
        double row_nearness = stp_triangle_plane_row(&plane, row);
        for (int32_t x = (int32_t)first; x <= last; ++x) {
            assert(x >= setup.left && x <= setup.right);
            float nearness;
            if (setup.small) {
                nearness = stp_triangle_small_nearness(
                    &setup, inverse_area, (int32_t)stp_triangle_edge_at(&edges[1], x, row),
                    (int32_t)stp_triangle_edge_at(&edges[2], x, row));
            } else {
                nearness = stp_triangle_plane_at(&plane, row_nearness, x, setup.low, setup.high);
            }
            draw_fragment(kept, window, nearness, x, row);
        }
        *window->fragments += last < first ? 0 : (uint64_t)(last - first) + 1;
    }
}

static void draw_kept_triangle(const stp_triangle_transform* transform, const stp_raster_mesh* mesh,
                               const stp_triangle_chunk* chunk, const float* const positions[3],
                               const stp_screen_vertex* polygon, uint32_t count, uint32_t triangle,
                               uint32_t first_id)
{
    kept_triangle kept = {.mesh = mesh, .triangle = triangle, .id = first_id + triangle};
    for (int k = 0; k < 3; ++k) {
        float p[4];
        stp_triangle_project(transform, positions[k], p);
        kept.corner[k][0] = (double)p[0];
        kept.corner[k][1] = (double)p[1];
        kept.corner[k][2] = (double)p[3];
    }
    for (uint32_t i = 2; i < count; ++i) {
        stp_screen_vertex corners[3] = {polygon[0], polygon[i - 1], polygon[i]};
        draw_kept(&chunk->window, corners, &kept);
    }
}

static void chunk_positions(const stp_raster_mesh* mesh, uint32_t triangle,
                            const float* positions[3])
{
    for (size_t k = 0; k < 3; ++k) {
        positions[k] = mesh->positions + 3 * (size_t)mesh->indices[3 * (size_t)triangle + k];
    }
}

static void draw_clipped(const stp_triangle_kernels* kernels,
                         const stp_triangle_transform* transform, const stp_raster_mesh* mesh,
                         const stp_triangle_chunk* chunk, uint32_t triangle, uint32_t first_id)
{
    const float* positions[3];
    chunk_positions(mesh, triangle, positions);
    stp_screen_vertex polygon[STP_CLIPPED_MAX];
    uint32_t count = stp_triangle_clip(transform, positions, polygon);
    if (mesh->keep != NULL) {
        draw_kept_triangle(transform, mesh, chunk, positions, polygon, count, triangle, first_id);
        return;
    }
    for (uint32_t i = 2; i < count; ++i) {
        stp_screen_vertex corners[3] = {polygon[0], polygon[i - 1], polygon[i]};
        uint32_t number = mesh->numbers != NULL ? mesh->numbers[triangle] : triangle;
        kernels->draw_one(&chunk->window, corners, first_id + number);
    }
}

/// Draws triangles [begin, begin + chunk->triangle_count) of a mesh with a fragment test.
static void draw_kept_chunk(const stp_triangle_transform* transform, const stp_raster_mesh* mesh,
                            stp_triangle_chunk* chunk, uint32_t begin, uint32_t first_id)
{
    for (uint32_t t = 0; t < chunk->triangle_count; ++t) {
        stp_screen_vertex corners[3];
        bool outside = false;
        for (size_t k = 0; k < 3; ++k) {
            uint32_t v = chunk->indices[3 * (size_t)t + k] - chunk->index_base;
            corners[k] = (stp_screen_vertex){chunk->x[v], chunk->y[v], chunk->nearness[v]};
            outside = outside || chunk->x[v] == STP_OUTSIDE;
        }
        stp_triangle_setup setup;
        if (outside) {
            chunk->clipped[chunk->clipped_count++] = t;
        } else if (stp_triangle_set_up(&chunk->window, corners, &setup)) {
            const float* positions[3];
            chunk_positions(mesh, begin + t, positions);
            draw_kept_triangle(transform, mesh, chunk, positions, corners, 3, begin + t, first_id);
        }
    }
}

/// Chooses and transforms the vertices of a chunk: the range its indices span, or a copy for each
/// corner.
/// @return false if out of memory
static bool transform_chunk(const stp_triangle_kernels* kernels,
                            const stp_triangle_transform* transform, const stp_raster_mesh* mesh,
                            uint32_t begin, stp_triangle_chunk* chunk, soup_memory** soup,
                            stp_arena* scratch)
{
    const uint32_t* indices = mesh->indices + 3 * (size_t)begin;
    size_t corner_count = 3 * (size_t)chunk->triangle_count;
    assert(corner_count > 0 && corner_count <= CHUNK_VERTICES);
    uint32_t minimum, maximum;
    kernels->find_range(indices, corner_count, &minimum, &maximum);
    assert(minimum <= maximum && maximum < mesh->vertex_count && "indices of the mesh");
    if (maximum - minimum < corner_count) {
        chunk->indices = indices;
        chunk->index_base = minimum;
        kernels->transform(transform, mesh->positions + 3 * (size_t)minimum,
                           (size_t)(maximum - minimum) + 1, chunk->x, chunk->y, chunk->nearness);
        return true;
    }
    if (*soup == NULL) {
        *soup = stp_arena_alloc(scratch, sizeof(**soup));
        if (*soup == NULL) {
            return false;
        }
        (*soup)->index_count = 0;
    }
    for (; (*soup)->index_count < corner_count; ++(*soup)->index_count) {
        (*soup)->indices[(*soup)->index_count] = (uint32_t)(*soup)->index_count;
    }
    for (size_t i = 0; i < corner_count; ++i) {
        memcpy((*soup)->positions + 3 * i, mesh->positions + 3 * (size_t)indices[i],
               3 * sizeof(float));
    }
    chunk->indices = (*soup)->indices;
    chunk->index_base = 0;
    kernels->transform(transform, (*soup)->positions, corner_count, chunk->x, chunk->y,
                       chunk->nearness);
    return true;
}

static stp_result draw_mesh(stp_triangle_window* window, const stp_raster_matrix* matrix,
                            float nearness_limit, const stp_raster_mesh* mesh, uint32_t first_id,
                            stp_arena* scratch)
{
    if (window->row_begin >= window->row_end || window->width == 0 || mesh->triangle_count == 0) {
        return STP_OK;
    }
    assert((mesh->layer == NULL || mesh->keep != NULL) && "layers are tested with masks");
    assert((mesh->keep == NULL || mesh->numbers == NULL) && "masks take the triangle's index");
    assert((mesh->keep == NULL || mesh->behind == 0) && "masks are tested for one picture");
    assert(window->stride >= (size_t)window->width && window->row_begin >= window->first_row);
    uint64_t fragments = 0;
    window->fragments = &fragments;
    window->facing = mesh->facing;
    window->behind = mesh->behind;
    const stp_triangle_kernels* kernels = choose_kernels();
    stp_triangle_transform transform = {.nearness_limit = nearness_limit};
    memcpy(transform.matrix, matrix->m, sizeof(transform.matrix));
    memcpy(transform.offset, mesh->offset, sizeof(transform.offset));
    stp_arena_mark mark = stp_arena_get_mark(scratch);
    chunk_memory* memory = stp_arena_alloc(scratch, sizeof(*memory));
    soup_memory* soup = NULL;
    bool enough = memory != NULL;
    for (uint32_t begin = 0; enough && begin < mesh->triangle_count;) {
        uint32_t left = mesh->triangle_count - begin;
        stp_triangle_chunk chunk = {
            .window = *window,
            .triangle_count = left < CHUNK_TRIANGLES ? left : CHUNK_TRIANGLES,
            .first_id = mesh->numbers != NULL ? first_id : first_id + begin,
            .numbers = mesh->numbers != NULL ? mesh->numbers + begin : NULL,
            .x = memory->x,
            .y = memory->y,
            .nearness = memory->nearness,
            .clipped = memory->clipped,
        };
        enough = transform_chunk(kernels, &transform, mesh, begin, &chunk, &soup, scratch);
        if (enough && mesh->keep != NULL) {
            draw_kept_chunk(&transform, mesh, &chunk, begin, first_id);
        } else if (enough) {
            kernels->draw_chunk(&chunk);
        }
        assert(chunk.clipped_count <= chunk.triangle_count);
        for (uint32_t i = 0; enough && i < chunk.clipped_count; ++i) {
            draw_clipped(kernels, &transform, mesh, &chunk, begin + memory->clipped[i], first_id);
        }
        begin += chunk.triangle_count;
    }
    stp_arena_rewind(scratch, mark);
    if (mesh->fragments != NULL) {
        *mesh->fragments += fragments;
    }
    return enough ? STP_OK : STP_ERROR_OUT_OF_MEMORY;
}

stp_result stp_raster_triangles(const stp_raster_target* target, uint32_t row_begin,
                                uint32_t row_end, const stp_raster_matrix* matrix,
                                float nearness_limit, const stp_raster_mesh* mesh,
                                uint32_t first_id, stp_arena* scratch)
{
    stp_triangle_window window = {
        .pixels = target->pixels,
        .stride = target->stride,
        .width = (int32_t)target->width,
        .row_begin = (int32_t)row_begin,
        .row_end = (int32_t)(row_end < target->height ? row_end : target->height),
    };
    return draw_mesh(&window, matrix, nearness_limit, mesh, first_id, scratch);
}

stp_result stp_raster_triangles_in_band(const stp_raster_target* band, uint32_t first_row,
                                        const stp_raster_matrix* matrix, float nearness_limit,
                                        const stp_raster_mesh* mesh, uint32_t first_id,
                                        stp_arena* scratch)
{
    stp_triangle_window window = {
        .pixels = band->pixels,
        .stride = band->stride,
        .width = (int32_t)band->width,
        .first_row = (int32_t)first_row,
        .row_begin = (int32_t)first_row,
        .row_end = (int32_t)(first_row + band->height),
    };
    return draw_mesh(&window, matrix, nearness_limit, mesh, first_id, scratch);
}
