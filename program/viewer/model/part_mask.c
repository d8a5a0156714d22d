// SPDX-License-Identifier: MIT
#include "program/viewer/model/part_mask.h"

#include "base/core/context.h"
#include "select/sections.h"
#include "select/view_frame.h"
#include "store/clusters/clusters.h"

#include <assert.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

/// Depths that differ by less than this share count as the same surface.
static const float same_depth = 0.02f;

enum {
    DEPTH_MAX = 1000,    ///< levels of the graph
    VISITS_MAX = 1000000 ///< nodes that are asked
};

static void add_corner(part_shape* shape, const stp_affine* transform, size_t corner, stp_vec3 p)
{
    stp_vec3d place = stp_affine_point(transform, stp_to_double(p));
    stp_vec3 relative = stp_to_float(stp_subd(place, shape->origin));
    float* out = shape->corners + 3 * corner;
    out[0] = relative.x;
    out[1] = relative.y;
    out[2] = relative.z;
}

static void add_clusters(part_shape* shape, size_t room, const stp_clusters* clusters,
                         const stp_affine* transform)
{
    for (uint32_t i = 0; i < clusters->cluster_count; ++i) {
        stp_cluster cluster;
        stp_clusters_get(clusters, i, &cluster);
        for (uint32_t t = 0; t < cluster.triangle_count && shape->count < room; ++t) {
            uint32_t corners[3];
            stp_cluster_corners(&cluster, t, corners);
            for (size_t k = 0; k < 3; ++k) {
                add_corner(shape, transform, 3 * shape->count + k,
                           stp_cluster_position(clusters, &cluster, corners[k]));
            }
            shape->count += 1;
        }
    }
}

static void add_mesh(part_shape* shape, size_t room, stp_store* store, uint32_t index,
                     const stp_affine* transform)
{
    stp_clusters clusters;
    stp_store_mesh mesh;
    if (stp_store_is_clustered(store, index)) {
        if (stp_store_get_clusters(store, index, &clusters) == STP_OK) {
            add_clusters(shape, room, &clusters, transform);
        }
        return;
    }
    if (stp_store_get_mesh(store, index, &mesh) != STP_OK) {
        return;
    }
    for (size_t t = 0; t < mesh.triangle_count && shape->count < room; ++t) {
        for (size_t k = 0; k < 3; ++k) {
            const float* p = mesh.positions + 3 * (size_t)stp_store_mesh_corner(&mesh, 3 * t + k);
            add_corner(shape, transform, 3 * shape->count + k, (stp_vec3){p[0], p[1], p[2]});
        }
        shape->count += 1;
    }
}

static void add_node(part_shape* shape, size_t room, stp_store* store, uint32_t node,
                     const stp_affine* transform, int depth, uint32_t* visits)
{
    const stp_store_directory* d = stp_store_get_directory(store);
    const stp_store_node* n = &d->nodes[node];
    if (n->triangle_count == 0 || depth == DEPTH_MAX || shape->count == room ||
        *visits == VISITS_MAX) {
        return;
    }
    *visits += 1;
    for (uint32_t i = 0; i < n->part_count; ++i) {
        stp_store_part part = d->parts[n->first_part + i];
        if (part.kind == STP_STORE_PART_MESH) {
            add_mesh(shape, room, store, part.index, transform);
        }
    }
    for (uint32_t i = 0; i < n->edge_count; ++i) {
        const stp_store_edge* edge = &d->edges[n->first_edge + i];
        stp_affine below = stp_affine_multiply(*transform, edge->transform);
        add_node(shape, room, store, edge->node, &below, depth + 1, visits);
    }
}

void part_shape_make(stp_context* context, stp_store* store, const stp_placed_node* placed,
                     part_shape* shape)
{
    const stp_store_directory* d = stp_store_get_directory(store);
    part_shape_destroy(shape);
    if (placed->node >= d->node_count) {
        return;
    }
    const stp_store_node* node = &d->nodes[placed->node];
    if (node->triangle_count == 0 || node->triangle_count > PART_SHAPE_TRIANGLES) {
        return;
    }
    shape->corners = malloc(9 * (size_t)node->triangle_count * sizeof(float));
    if (shape->corners == NULL) {
        return;
    }
    shape->origin = stp_affine_point(&placed->transform,
                                     stp_scaled(stp_addd(node->bounds.min, node->bounds.max), 0.5));
    stp_hold_errors(context); // what cannot be read is reported where it is drawn
    uint32_t visits = 0;
    add_node(shape, (size_t)node->triangle_count, store, placed->node, &placed->transform, 0,
             &visits);
    stp_release_errors(context, false);
}

void part_shape_destroy(part_shape* shape)
{
    free(shape->corners);
    *shape = (part_shape){0};
}

/// A corner in cells, with 1 / depth.
typedef struct corner {
    float x, y, nearness;
} corner;

static bool project(const stp_view_frame* frame, stp_vec3d point, corner* out)
{
    stp_vec3d q = stp_subd(point, frame->eye);
    double depth = frame->parallel ? 1.0 : stp_dotd(q, frame->forward);
    double scale = frame->scale / (depth * PART_MASK_CELL);
    out->x = (float)(frame->center_x / PART_MASK_CELL + scale * stp_dotd(q, frame->right));
    out->y = (float)(frame->center_y / PART_MASK_CELL + scale * stp_dotd(q, frame->down));
    out->nearness = (float)(1.0 / depth);
    return depth > 0.0 && fabsf(out->x) < 1e6f && fabsf(out->y) < 1e6f;
}

static void cover(part_mask* mask, int x, int y, float nearness)
{
    if (x >= 0 && y >= 0 && x < (int)mask->width && y < (int)mask->height) {
        float* cell = &mask->nearness[(size_t)y * mask->width + (size_t)x];
        *cell = fmaxf(*cell, nearness);
    }
}

static int clamp_cell(float at, uint32_t count)
{
    return at < 0.0f ? 0 : at > (float)count ? (int)count : (int)at;
}

/// The columns in which the edges of a triangle cross the middle of a row, and one more on each side.
static void find_span(const corner c[3], float py, uint32_t width, int* first, int* last)
{
    float low = INFINITY, high = -INFINITY;
    for (int k = 0; k < 3; ++k) {
        const corner *a = &c[k], *b = &c[(k + 1) % 3];
        if ((a->y <= py) != (b->y <= py)) {
            float x = a->x + (py - a->y) / (b->y - a->y) * (b->x - a->x);
            low = fminf(low, x);
            high = fmaxf(high, x);
        }
    }
    int from = low <= high ? clamp_cell(low - 1.0f, width) : 0;
    int to = low <= high ? clamp_cell(high + 2.0f, width) : 0;
    *first = from > *first ? from : *first;
    *last = to < *last ? to : *last;
}

static void fill(part_mask* mask, const corner c[3])
{
    float area = (c[1].x - c[0].x) * (c[2].y - c[0].y) - (c[2].x - c[0].x) * (c[1].y - c[0].y);
    for (int k = 0; k < 3; ++k) { // also of triangles that miss all centres of cells
        cover(mask, (int)floorf(c[k].x), (int)floorf(c[k].y), c[k].nearness);
    }
    if (area == 0.0f) {
        return;
    }
    int x0 = clamp_cell(fminf(fminf(c[0].x, c[1].x), c[2].x), mask->width);
    int x1 = clamp_cell(fmaxf(fmaxf(c[0].x, c[1].x), c[2].x) + 1.0f, mask->width);
    int y0 = clamp_cell(fminf(fminf(c[0].y, c[1].y), c[2].y), mask->height);
    int y1 = clamp_cell(fmaxf(fmaxf(c[0].y, c[1].y), c[2].y) + 1.0f, mask->height);
    for (int y = y0; y < y1; ++y) {
        int first = x0, last = x1;
        find_span(c, (float)y + 0.5f, mask->width, &first, &last);
        for (int x = first; x < last; ++x) {
            float px = (float)x + 0.5f, py = (float)y + 0.5f, share[3], nearness = 0.0f;
            bool inside = true;
            for (int k = 0; k < 3; ++k) {
                const corner *a = &c[(k + 1) % 3], *b = &c[(k + 2) % 3];
                share[k] = ((a->x - px) * (b->y - py) - (b->x - px) * (a->y - py)) / area;
                inside = inside && share[k] >= 0.0f;
                nearness += share[k] * c[k].nearness;
            }
            if (inside) {
                cover(mask, x, y, nearness);
            }
        }
    }
}

static bool make_room(part_mask* mask, uint32_t width, uint32_t height)
{
    size_t count = (size_t)width * height;
    if (mask->width != width || mask->height != height) {
        part_mask_destroy(mask);
        mask->cells = malloc(count);
        mask->nearness = malloc(count * sizeof(float));
        if (mask->cells == NULL || mask->nearness == NULL) {
            part_mask_destroy(mask);
            return false;
        }
        mask->width = width;
        mask->height = height;
    }
    memset(mask->nearness, 0, count * sizeof(float));
    mask->visible = mask->hidden = 0;
    return true;
}

/// Compares the part's depth with that of the picture.
static void classify(part_mask* mask, const stp_view* view, const float* nearness,
                     double near_distance)
{
    for (uint32_t y = 0; y < mask->height; ++y) {
        for (uint32_t x = 0; x < mask->width; ++x) {
            size_t cell = (size_t)y * mask->width + x;
            size_t pixel = (size_t)(PART_MASK_CELL * y) * view->width + PART_MASK_CELL * x;
            float own = mask->nearness[cell] * (float)near_distance;
            bool hidden = nearness != NULL && nearness[pixel] * (1.0f - same_depth) > own;
            mask->cells[cell] = mask->nearness[cell] == 0.0f ? PART_CELL_NONE
                                : hidden                     ? PART_CELL_HIDDEN
                                                             : PART_CELL_VISIBLE;
            mask->hidden += mask->cells[cell] == PART_CELL_HIDDEN;
            mask->visible += mask->cells[cell] == PART_CELL_VISIBLE;
        }
    }
}

bool part_mask_draw(part_mask* mask, const part_shape* shape, const stp_view* view,
                    const float* nearness, double near_distance)
{
    stp_view_frame frame;
    if (!stp_view_frame_make(view, &frame) ||
        !make_room(mask, (view->width + PART_MASK_CELL - 1) / PART_MASK_CELL,
                   (view->height + PART_MASK_CELL - 1) / PART_MASK_CELL)) {
        part_mask_destroy(mask);
        return false;
    }
    for (size_t t = 0; t < shape->count; ++t) {
        corner c[3];
        stp_vec3d middle = {0};
        bool good = true;
        for (size_t k = 0; k < 3; ++k) {
            const float* p = shape->corners + 9 * t + 3 * k;
            stp_vec3d point =
                stp_addd(shape->origin, (stp_vec3d){(double)p[0], (double)p[1], (double)p[2]});
            middle = stp_addd(middle, stp_scaled(point, 1.0 / 3.0));
            good = project(&frame, point, &c[k]) && good;
        }
        if (good && !stp_sections_exclude(&view->sections, middle)) {
            fill(mask, c);
        }
    }
    classify(mask, view, frame.parallel ? NULL : nearness, near_distance);
    return true;
}

void part_mask_destroy(part_mask* mask)
{
    free(mask->cells);
    free(mask->nearness);
    *mask = (part_mask){0};
}
