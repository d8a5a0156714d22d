// SPDX-License-Identifier: MIT
//
// Ray-triangle tests. Corners are transformed to the ray's axes, where the ray is the point (0, 0);
// a triangle is hit if that point lies on one side of all its edges. Both triangles of a shared
// edge compute the same number for its side, except for the sign, so no ray passes between them
// (Woop, Benthin, Wald 2013).
#include "base/core/context.h"
#include "base/splats/splat_columns.h"
#include "select/pick_internal.h"
#include "store/bytes/columns.h"
#include "store/bytes/format.h"
#include "store/clusters/clusters.h"
#include "store/file/point_attributes.h"
#include "store/residency/residency.h"

#include <assert.h>

/// A corner in ray coordinates.
typedef struct corner {
    double x, y, t;
} corner;

/// Transform from part space to the ray's axes.
typedef struct ray_map {
    double m[3][4];
} ray_map;

/// Nearest hit so far in a part.
typedef struct nearest_element {
    bool found;
    uint32_t index;
    double t;
} nearest_element;

void stp_pick_begin(stp_pick_work* work)
{
    stp_vec3d d = work->desc->ray.direction;
    double x = fabs(d.x), y = fabs(d.y), z = fabs(d.z);
    stp_vec3d other = x <= y && x <= z ? (stp_vec3d){1, 0, 0}
                      : y <= z         ? (stp_vec3d){0, 1, 0}
                                       : (stp_vec3d){0, 0, 1};
    work->across = stp_normalized(stp_crossd(d, other));
    work->off = stp_crossd(d, work->across);
}

static ray_map map_of(const stp_pick_work* work, const stp_affine* transform)
{
    const stp_vec3d axes[3] = {work->across, work->off, work->desc->ray.direction};
    stp_vec3d origin = {transform->m[0][3], transform->m[1][3], transform->m[2][3]};
    stp_vec3d from = stp_subd(origin, work->desc->ray.origin);
    ray_map map;
    for (int k = 0; k < 3; ++k) {
        for (int c = 0; c < 3; ++c) {
            map.m[k][c] = axes[k].x * transform->m[0][c] + axes[k].y * transform->m[1][c] +
                          axes[k].z * transform->m[2][c];
        }
        map.m[k][3] = stp_dotd(axes[k], from);
    }
    return map;
}

static corner turn(const ray_map* map, const float* p)
{
    double x = (double)p[0], y = (double)p[1], z = (double)p[2];
    const double(*m)[4] = map->m;
    return (corner){m[0][0] * x + m[0][1] * y + m[0][2] * z + m[0][3],
                    m[1][0] * x + m[1][1] * y + m[1][2] * z + m[1][3],
                    m[2][0] * x + m[2][1] * y + m[2][2] * z + m[2][3]};
}

/// @param share receives barycentric coordinates
static bool intersects(const corner* a, const corner* b, const corner* c, double* t,
                       double share[3])
{
    double u = b->x * c->y - b->y * c->x;
    double v = c->x * a->y - c->y * a->x;
    double w = a->x * b->y - a->y * b->x;
    if ((u < 0.0 || v < 0.0 || w < 0.0) && (u > 0.0 || v > 0.0 || w > 0.0)) {
        return false;
    }
    double sum = u + v + w;
    if (sum == 0.0) {
        return false; // seen edge-on
    }
    *t = (u * a->t + v * b->t + w * c->t) / sum;
    share[0] = u / sum;
    share[1] = v / sum;
    share[2] = w / sum;
    return true;
}

static stp_vec3d point_at(const stp_ray* ray, double t)
{
    return stp_addd(ray->origin, stp_scaled(ray->direction, t));
}

/// Whether a hit at this position counts.
static bool counts(const stp_pick_work* work, double t, stp_vec3d place)
{
    return t >= work->desc->ray.nearest && t < work->nearest &&
           (work->desc->sections == NULL || !stp_sections_exclude(work->desc->sections, place));
}

/// Source of the corners that a mask needs: a cluster, or a mesh's columns.
typedef struct mask_source {
    stp_pick_mask mask;
    int32_t front; ///< how corners of triangles that are hit turn (stp_affine_front_turn); 0: any
    const stp_clusters* clusters;
    const stp_cluster* cluster;
    const stp_store_mesh* columns;
} mask_source;

static stp_pick_corner read_corner(const mask_source* source, uint32_t vertex)
{
    stp_pick_corner out = {.alpha = 1.0f};
    uint32_t set = source->mask.material->base_color_texture.texcoord != 0 ? 1 : 0;
    if (source->columns != NULL) {
        const stp_store_mesh* mesh = source->columns;
        if (mesh->texcoords[set] != NULL) {
            const float* uv = mesh->texcoords[set] + 2 * (size_t)vertex;
            out.uv = (stp_vec2){uv[0], uv[1]};
        }
        if (mesh->colors != NULL) {
            out.alpha = (float)mesh->colors[4 * (size_t)vertex + 3] / 65535.0f;
        }
        return out;
    }
    uint32_t present = source->clusters->present;
    if ((present & (set == 0 ? STP_COLUMN_TEXCOORDS_0 : STP_COLUMN_TEXCOORDS_1)) != 0) {
        out.uv = stp_cluster_texcoord(source->clusters, source->cluster, set, vertex);
    }
    if ((present & STP_COLUMN_COLORS) != 0) {
        float color[4];
        stp_cluster_color(source->cluster, vertex, color);
        out.alpha = color[3];
    }
    return out;
}

static bool is_opaque_at(const mask_source* source, const uint32_t vertices[3],
                         const double share[3])
{
    if (!source->mask.asks) {
        return true;
    }
    stp_pick_corner corners[3];
    for (int k = 0; k < 3; ++k) {
        corners[k] = read_corner(source, vertices[k]);
    }
    return stp_pick_mask_has(&source->mask, corners, share);
}

/// Whether the side of a triangle that the ray meets is drawn. The axes across the ray are those of
/// a picture whose rows go down.
static bool is_shown(const mask_source* source, const corner* a, const corner* b, const corner* c)
{
    double turn = (b->x - a->x) * (c->y - a->y) - (b->y - a->y) * (c->x - a->x);
    return source->front == 0 || (source->front > 0) == (turn > 0.0);
}

/// `vertices`: indices in the cluster or the columns.
static void test_triangle(stp_pick_work* work, const corner* a, const corner* b, const corner* c,
                          const mask_source* source, const uint32_t vertices[3], uint32_t index,
                          nearest_element* nearest)
{
    double t, share[3];
    work->pick->tests += 1;
    if (is_shown(source, a, b, c) && intersects(a, b, c, &t, share) &&
        counts(work, t, point_at(&work->desc->ray, t)) && is_opaque_at(source, vertices, share)) {
        assert((!nearest->found || t < nearest->t) && "nearer than the last hit");
        *nearest = (nearest_element){.found = true, .index = index, .t = t};
        work->nearest = t;
    }
}

static void test_cluster(stp_pick_work* work, const ray_map* map, mask_source* source,
                         uint32_t index, nearest_element* nearest)
{
    const stp_clusters* clusters = source->clusters;
    stp_cluster cluster;
    float positions[3 * STP_CLUSTER_VERTICES];
    corner corners[STP_CLUSTER_VERTICES];
    stp_clusters_get(clusters, index, &cluster);
    assert(cluster.vertex_count <= STP_CLUSTER_VERTICES);
    stp_cluster_positions(clusters, &cluster, positions);
    source->cluster = &cluster;
    for (uint32_t i = 0; i < cluster.vertex_count; ++i) {
        corners[i] = turn(map, positions + 3 * (size_t)i);
    }
    for (uint32_t i = 0; i < cluster.triangle_count; ++i) {
        uint32_t c[3];
        stp_cluster_corners(&cluster, i, c);
        test_triangle(work, &corners[c[0]], &corners[c[1]], &corners[c[2]], source, c,
                      cluster.first_triangle + i, nearest);
    }
    source->cluster = NULL;
}

/// Corners of a triangle in clusters.
static void read_triangle(const stp_clusters* clusters, uint32_t triangle, stp_vec3 out[3])
{
    stp_cluster cluster;
    uint32_t c[3];
    stp_clusters_get(clusters, stp_clusters_find(clusters, triangle), &cluster);
    stp_cluster_corners(&cluster, triangle - cluster.first_triangle, c);
    for (int k = 0; k < 3; ++k) {
        out[k] = stp_cluster_position(clusters, &cluster, c[k]);
    }
}

static stp_vec3 read_vertex(const float* positions, uint32_t index)
{
    const float* p = positions + 3 * (size_t)index;
    return (stp_vec3){p[0], p[1], p[2]};
}

static stp_result get_triangle(stp_pick_work* work, stp_store_part part,
                               const stp_affine* transform, const nearest_element* nearest,
                               const stp_vec3 corners[3])
{
    stp_pick* pick = work->pick;
    const stp_ray* ray = &work->desc->ray;
    assert(nearest->found && work->nearest <= nearest->t && "the nearest hit so far");
    pick->hit = true;
    pick->part = part;
    pick->element = nearest->index;
    pick->distance = nearest->t;
    pick->position = point_at(ray, nearest->t);
    pick->material = stp_store_describe_mesh(work->store, part.index)->material;
    for (int k = 0; k < 3; ++k) {
        pick->corners[k] = stp_affine_point(transform, stp_to_double(corners[k]));
    }
    stp_vec3d normal = stp_normalized(stp_crossd(stp_subd(pick->corners[1], pick->corners[0]),
                                                 stp_subd(pick->corners[2], pick->corners[0])));
    bool away = stp_dotd(normal, ray->direction) > 0.0;
    pick->normal = away ? stp_scaled(normal, -1.0) : normal;
    return stp_pick_find_inner(work, part.index, nearest->index, corners);
}

static stp_boxd widen(stp_box box)
{
    return (stp_boxd){stp_to_double(box.min), stp_to_double(box.max)};
}

static const stp_store_material* material_of(const stp_pick_work* work, uint32_t mesh)
{
    return &work->directory->materials[stp_store_describe_mesh(work->store, mesh)->material];
}

static int32_t front_of(const stp_pick_work* work, uint32_t mesh, const stp_affine* transform)
{
    const stp_pick_desc* desc = work->desc;
    bool backs = desc->back_faces || (desc->sections != NULL && desc->sections->count > 0) ||
                 (material_of(work, mesh)->flags & STP_SHADING_FRONT_ONLY) == 0;
    return backs ? 0 : stp_affine_front_turn(transform);
}

/// Finds the nearest hit in a mesh's clusters, and its corners.
static stp_result pick_clusters(stp_pick_work* work, uint32_t mesh, const stp_affine* transform,
                                const ray_map* map, nearest_element* nearest, stp_vec3 corners[3])
{
    stp_clusters clusters;
    mask_source source = {.clusters = &clusters, .front = front_of(work, mesh, transform)};
    stp_result result = stp_store_get_clusters(work->store, mesh, &clusters);
    if (result == STP_OK) {
        result = stp_pick_mask_make(work->store, material_of(work, mesh),
                                    (clusters.present & STP_COLUMN_COLORS) != 0, &source.mask);
    }
    for (uint32_t i = 0; result == STP_OK && i < clusters.cluster_count; ++i) {
        stp_boxd box = widen(stp_clusters_bounds(&clusters, i));
        double near;
        work->pick->tests += 1;
        if (stp_pick_enters(work, transform, &box, 1e-6, false, &near)) {
            test_cluster(work, map, &source, i, nearest);
        }
    }
    if (nearest->found) {
        read_triangle(&clusters, nearest->index, corners);
    }
    return result;
}

/// The same for a mesh stored as columns.
static stp_result pick_columns(stp_pick_work* work, uint32_t mesh, const stp_affine* transform,
                               const ray_map* map, nearest_element* nearest, stp_vec3 corners[3])
{
    stp_store_mesh columns;
    mask_source source = {.columns = &columns, .front = front_of(work, mesh, transform)};
    stp_result result = stp_store_get_mesh(work->store, mesh, &columns);
    if (result == STP_OK) {
        result = stp_pick_mask_make(work->store, material_of(work, mesh), columns.colors != NULL,
                                    &source.mask);
    }
    for (uint32_t i = 0; result == STP_OK && i < columns.triangle_count; ++i) {
        corner c[3];
        uint32_t vertices[3];
        for (size_t k = 0; k < 3; ++k) {
            vertices[k] = stp_store_mesh_corner(&columns, 3 * (size_t)i + k);
            c[k] = turn(map, columns.positions + 3 * (size_t)vertices[k]);
        }
        test_triangle(work, &c[0], &c[1], &c[2], &source, vertices, i, nearest);
    }
    for (size_t k = 0; k < 3 && nearest->found; ++k) {
        corners[k] = read_vertex(columns.positions,
                                 stp_store_mesh_corner(&columns, 3 * (size_t)nearest->index + k));
    }
    return result;
}

static stp_result pick_mesh(stp_pick_work* work, stp_store_part part, const stp_affine* transform,
                            const ray_map* map)
{
    nearest_element nearest = {0};
    stp_vec3 corners[3];
    stp_result result = stp_store_is_clustered(work->store, part.index)
                            ? pick_clusters(work, part.index, transform, map, &nearest, corners)
                            : pick_columns(work, part.index, transform, map, &nearest, corners);
    return result == STP_OK && nearest.found
               ? get_triangle(work, part, transform, &nearest, corners)
               : result;
}

/// Points of a point set, or splats of the set that contains them.
typedef struct point_source {
    stp_store_point_set points;
    stp_splats set;           ///< positions NULL: no set
    const uint8_t* coverages; ///< per splat, if classes are hidden: 0 is hidden
    uint32_t count;
} point_source;

static stp_result open_points(stp_pick_work* work, uint32_t index, point_source* source)
{
    bool hides = stp_store_get_coloring(work->store)->hides;
    *source = (point_source){.points = *stp_store_describe_point_set(work->store, index)};
    if (source->points.held_by == 0) {
        stp_result result = stp_store_get_point_set(work->store, index, &source->points);
        source->points.colors = hides ? source->points.colors : NULL;
        source->count = source->points.point_count;
        return result;
    }
    stp_splats* set = &source->set;
    stp_result result = stp_store_get_splat_set(work->store, source->points.held_by - 1, set);
    source->points.colors = NULL;
    source->count = set->count;
    if (result == STP_OK && hides && set->count > 0) {
        source->coverages = set->coverages + stp_store_colors_begin(set, set->octave_count - 1);
    }
    return result;
}

static bool is_hidden(const point_source* source, uint32_t index)
{
    return (source->points.colors != NULL && source->points.colors[4 * (size_t)index + 3] == 0) ||
           (source->coverages != NULL && source->coverages[index] == 0);
}

static stp_vec3 place_of(const point_source* source, uint32_t index)
{
    return source->set.positions != NULL ? stp_to_float(stp_splat_place(&source->set, index))
                                         : read_vertex(source->points.positions, index);
}

static stp_result pick_points(stp_pick_work* work, stp_store_part part, const stp_affine* transform,
                              const ray_map* map)
{
    point_source source;
    nearest_element nearest = {0};
    stp_result result = open_points(work, part.index, &source);
    if (result != STP_OK) {
        return result;
    }
    const stp_pick_desc* desc = work->desc;
    for (uint32_t i = 0; i < source.count; ++i) {
        if (is_hidden(&source, i)) {
            continue;
        }
        stp_vec3 own = place_of(&source, i);
        corner c = turn(map, (float[3]){own.x, own.y, own.z});
        double reach = desc->point_base + desc->point_slope * c.t;
        stp_vec3d place = stp_affine_point(transform, stp_to_double(own));
        if (reach > 0.0 && c.x * c.x + c.y * c.y <= reach * reach && counts(work, c.t, place)) {
            nearest = (nearest_element){.found = true, .index = i, .t = c.t};
            work->nearest = c.t;
        }
    }
    work->pick->tests += source.count;
    if (nearest.found) {
        stp_pick* pick = work->pick;
        pick->hit = true;
        pick->part = part;
        pick->element = nearest.index;
        pick->distance = nearest.t;
        pick->position =
            stp_affine_point(transform, stp_to_double(place_of(&source, nearest.index)));
        pick->material = source.points.material;
        pick->normal = stp_scaled(desc->ray.direction, -1.0);
        pick->corners[0] = pick->corners[1] = pick->corners[2] = pick->position;
    }
    return STP_OK;
}

stp_result stp_pick_part(stp_pick_work* work, stp_store_part part, const stp_affine* transform)
{
    bool is_mesh = part.kind == STP_STORE_PART_MESH;
    stp_boxd box = widen(is_mesh ? stp_store_describe_mesh(work->store, part.index)->bounds
                                 : stp_store_describe_point_set(work->store, part.index)->bounds);
    double near;
    work->pick->tests += 1;
    if (!stp_pick_enters(work, transform, &box, 1e-6, !is_mesh, &near)) {
        return STP_OK;
    }
    bool resident = is_mesh ? stp_store_is_mesh_resident(work->store, part.index)
                            : stp_store_are_points_resident(work->store, part.index);
    if (!resident) {
        work->pick->incomplete = true;
        return STP_OK;
    }
    ray_map map = map_of(work, transform);
    return is_mesh ? pick_mesh(work, part, transform, &map)
                   : pick_points(work, part, transform, &map);
}
