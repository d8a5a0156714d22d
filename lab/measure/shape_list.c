// SPDX-License-Identifier: MIT
#include "lab/measure/shape_list.h"

#include "base/splats/coverage.h"
#include "base/splats/octahedral.h"
#include "base/splats/splat_codes.h"
#include "base/splats/splat_columns.h"
#include "program/files/point_file.h"
#include "select/camera.h"
#include "store/clusters/clusters.h"

#include <assert.h>
#include <string.h>

/// Transform from a file to its own axes, relative to the origin.
typedef struct placing {
    stp_context* context;
    tool_shape_list* list;
    char up;
    stp_affine transform; ///< to the scene
} placing;

static stp_vec3d place(const placing* p, stp_vec3d at)
{
    const double* origin = p->list->origin;
    at = tool_own_axes(p->up, stp_affine_point(&p->transform, at));
    return stp_subd(at, (stp_vec3d){origin[0], origin[1], origin[2]});
}

/// Room for `count` more triples of floats. @return the first of them; NULL: memory ran out (logged)
static float* add_triples(const placing* p, float** array, size_t* capacity, size_t used,
                          size_t count)
{
    assert(3 * used <= *capacity && "the capacity counts floats");
    if (!STP_MAKE_ROOM(p->context, *array, *capacity, 3 * (used + count))) {
        (void)stp_fail_memory(p->context);
        return NULL;
    }
    return *array + 3 * used;
}

/// Room for `count` more disks. @return the first of them; NULL: memory ran out (logged)
static stp_disk_shape* add_disks(stp_context* context, tool_shape_list* list, size_t count)
{
    if (!STP_MAKE_ROOM(context, list->disks, list->disk_capacity, list->disk_count + count)) {
        (void)stp_fail_memory(context);
        return NULL;
    }
    return list->disks + list->disk_count;
}

static void place_many(const placing* p, const float* from, size_t count, float* to)
{
    for (size_t i = 0; i < count; ++i) {
        const float* at = from + 3 * i;
        stp_vec3 placed =
            stp_to_float(place(p, (stp_vec3d){(double)at[0], (double)at[1], (double)at[2]}));
        memcpy(to + 3 * i, &placed, sizeof(placed));
    }
}

static stp_result add_points(const placing* p, const float* positions, size_t count)
{
    tool_shape_list* s = p->list;
    float* to = add_triples(p, &s->points, &s->point_capacity, s->point_count, count);
    if (to == NULL) {
        return STP_ERROR_OUT_OF_MEMORY;
    }
    place_many(p, positions, count, to);
    s->point_count += count;
    return STP_OK;
}

/// @param indices NULL: three vertices a triangle, one after the other
static stp_result add_triangles(const placing* p, const float* positions, size_t vertex_count,
                                const uint32_t* indices, size_t triangle_count)
{
    tool_shape_list* s = p->list;
    if (s->vertex_count + vertex_count > UINT32_MAX ||
        s->triangle_count + triangle_count > UINT32_MAX) {
        return stp_fail(p->context, STP_ERROR_LIMIT,
                        "distances: expected fewer than 4294967296 vertices and triangles");
    }
    float* to = add_triples(p, &s->positions, &s->position_capacity, s->vertex_count, vertex_count);
    if (to == NULL) {
        return STP_ERROR_OUT_OF_MEMORY;
    }
    if (!STP_MAKE_ROOM(p->context, s->indices, s->index_capacity,
                       3 * (s->triangle_count + triangle_count))) {
        return stp_fail_memory(p->context);
    }
    uint32_t* corners = s->indices + 3 * s->triangle_count;
    place_many(p, positions, vertex_count, to);
    for (size_t i = 0; i < 3 * triangle_count; ++i) {
        uint32_t vertex = indices != NULL ? indices[i] : (uint32_t)i;
        corners[i] = (uint32_t)s->vertex_count + (vertex < vertex_count ? vertex : 0);
    }
    s->vertex_count += vertex_count;
    s->triangle_count += triangle_count;
    return STP_OK;
}

stp_result tool_shapes_add_scene(tool_shape_list* list, const stp_scene* scene)
{
    stp_placed_part* parts = NULL;
    size_t count = 0;
    placing p = {
        .context = scene->context, .list = list, .up = scene->up != NULL ? scene->up[0] : 'y'};
    stp_result result = STP_OK;
    if (scene->root != STP_NONE) {
        result = stp_scene_flatten(scene, scene->root, SIZE_MAX, &parts, &count);
    }
    for (size_t i = 0; i < count && result == STP_OK; ++i) {
        p.transform = parts[i].transform;
        if (parts[i].part.kind == STP_PART_MESH) {
            const stp_mesh* m = &scene->meshes[parts[i].part.index];
            result =
                add_triangles(&p, m->positions, m->vertex_count, m->indices, m->triangle_count);
        } else {
            const stp_point_set* set = &scene->point_sets[parts[i].part.index];
            result = add_points(&p, set->positions, set->point_count);
        }
    }
    stp_free(scene->context, parts);
    return result;
}

static stp_result add_mesh(const placing* p, stp_store* store, uint32_t index)
{
    if (!stp_store_is_clustered(store, index)) {
        stp_store_mesh mesh;
        stp_result result = stp_store_get_mesh(store, index, &mesh);
        return result == STP_OK ? add_triangles(p, mesh.positions, mesh.vertex_count, mesh.indices,
                                                mesh.triangle_count)
                                : result;
    }
    stp_clusters clusters;
    stp_decoded_mesh mesh = {0};
    stp_result result = stp_store_get_clusters(store, index, &clusters);
    result = result == STP_OK ? stp_clusters_decode(p->context, &clusters, &mesh) : result;
    if (result == STP_OK) {
        size_t count = mesh.triangle_count;
        result = add_triangles(p, mesh.positions, 3 * count, NULL, count);
    }
    stp_decoded_mesh_destroy(p->context, &mesh);
    return result;
}

/// How splats of an item become ellipses of the scene.
typedef struct item_splats {
    const placing* placing;
    const stp_splats* set;
    const stp_draw_item* item;
    double turn[3][3]; ///< normal matrix
    double scale;      ///< scale of radii, as renderers compute it
} item_splats;

static stp_vec3d turn_normal(const item_splats* s, stp_vec3d n)
{
    const double(*m)[3] = s->turn;
    return stp_normalized((stp_vec3d){m[0][0] * n.x + m[0][1] * n.y + m[0][2] * n.z,
                                      m[1][0] * n.x + m[1][1] * n.y + m[1][2] * n.z,
                                      m[2][0] * n.x + m[2][1] * n.y + m[2][2] * n.z});
}

static stp_vec3d turn_direction(const placing* p, stp_vec3 d)
{
    const double(*m)[4] = p->transform.m;
    stp_vec3d v = stp_to_double(d);
    return (stp_vec3d){m[0][0] * v.x + m[0][1] * v.y + m[0][2] * v.z,
                       m[1][0] * v.x + m[1][1] * v.y + m[1][2] * v.z,
                       m[2][0] * v.x + m[2][1] * v.y + m[2][2] * v.z};
}

/// Splat `i`, as raster/splats_kernel.h draws it.
static stp_disk_shape make_disk(const item_splats* s, uint32_t i)
{
    const stp_splats* set = s->set;
    const int8_t* code = set->normals + 2 * (size_t)i;
    double step = (double)set->step, larger = (double)s->item->radius, smaller = larger;
    stp_vec3d position = stp_splat_place(set, i);
    stp_disk_axes axes = stp_disk_axes_of((float)code[0], (float)code[1]);
    stp_vec3 direction = axes.x;
    if (set->shapes != NULL) {
        uint32_t shape = set->shapes[i];
        stp_shape_axis axis = stp_shape_smaller(shape);
        larger = step * (double)stp_shape_radius(shape & 0xFFFu);
        smaller = step * (double)stp_shape_radius(shape >> 12 & 0xFFFu);
        direction = stp_add(stp_scale(axes.x, axis.along_x), stp_scale(axes.y, axis.along_y));
    }
    stp_vec3d normal = turn_normal(s, stp_to_double(stp_octahedral_decode(code[0], code[1])));
    stp_vec3d along = turn_direction(s->placing, direction);
    along = stp_normalized(stp_subd(along, stp_scaled(normal, stp_dotd(along, normal))));
    stp_vec3d across = stp_normalized(stp_crossd(along, normal));
    char up = s->placing->up;
    return (stp_disk_shape){stp_to_float(place(s->placing, position)),
                            stp_to_float(tool_own_axes(up, stp_scaled(across, larger * s->scale))),
                            stp_to_float(tool_own_axes(up, stp_scaled(along, smaller * s->scale)))};
}

// All levels hold everywhere in a list made for a number of splats. As
// raster/splats_levels_kernel.h compares them.
static bool is_drawn(const stp_splats* set, const stp_draw_item* item, uint32_t i)
{
    if (set->ranges == NULL) {
        return true;
    }
    uint32_t level = stp_bits_of_float(i < item->divide ? item->level_below : item->level_min);
    uint32_t range = set->ranges[i];
    return level >= (range & 0xFFFFu) << 15 && level <= range >> 16 << 15;
}

static stp_result add_splats(const placing* p, stp_store* store, const stp_draw_item* item)
{
    tool_shape_list* list = p->list;
    stp_splats set;
    const stp_splats* known = stp_store_describe_splat_set(store, item->index);
    uint32_t octaves = stp_store_octaves_for(known, item->prefix);
    stp_result result = stp_store_get_splat_set_prefix(store, item->index, octaves, &set);
    if (result != STP_OK) {
        return result;
    }
    item_splats s = {.placing = p, .set = &set, .item = item};
    stp_affine_normal_matrix(&p->transform, s.turn);
    for (int k = 0; k < 9; ++k) {
        double entry = p->transform.m[k / 3][k % 3];
        s.scale += entry * entry / 3.0;
    }
    s.scale = sqrt(s.scale);
    uint32_t count = item->prefix < set.count ? item->prefix : set.count;
    if (add_disks(p->context, list, count) == NULL) {
        return STP_ERROR_OUT_OF_MEMORY;
    }
    for (uint32_t i = 0; i < count; ++i) {
        if (is_drawn(&set, item, i)) {
            list->disks[list->disk_count++] = make_disk(&s, i);
        }
    }
    assert(list->disk_count <= list->disk_capacity);
    return STP_OK;
}

/// Adds the drawn content of a list of items: splats as ellipses at their drawn size, triangles,
/// and points. Coverage (cuts, holes, opacity) is ignored: an ellipse counts as a whole. Ranges of
/// levels hold for an error that is the same everywhere, as in lists of a number of
/// splats.
static stp_result add_items(stp_context* context, tool_shape_list* list, stp_store* store,
                            const stp_draw_list* items)
{
    placing p = {.context = context, .list = list, .up = stp_store_get_directory(store)->up};
    stp_result result = STP_OK;
    for (size_t i = 0; i < items->count && result == STP_OK; ++i) {
        const stp_draw_item* item = &items->items[i];
        p.transform = item->transform;
        if (item->kind == STP_DRAW_SPLATS) {
            result = add_splats(&p, store, item);
        } else if (item->kind == STP_DRAW_MESH) {
            result = add_mesh(&p, store, item->index);
        } else {
            stp_store_point_set set;
            result = stp_store_get_point_set(store, item->index, &set);
            result = result == STP_OK ? add_points(&p, set.positions, set.point_count) : result;
        }
    }
    return result;
}

stp_result tool_shapes_add_store(stp_context* context, tool_shape_list* list, stp_store* store,
                                 const stp_quality* quality)
{
    const stp_store_directory* d = stp_store_get_directory(store);
    stp_draw_list items = {0};
    stp_quality all = *quality;
    all.splat_size = all.splat_size >= 1.0f ? all.splat_size : 1.0f;
    all.splat_count = quality->reference         ? 0
                      : quality->splat_count > 0 ? quality->splat_count
                                                 : UINT64_MAX;
    stp_view view = {.width = 256, .height = 256};
    if (d->root == STP_STORE_NONE) {
        return STP_OK;
    }
    (void)stp_camera_frame("iso", &d->nodes[d->root].bounds, &view);
    stp_result result = stp_select(context, store, &view, &all, &items);
    result = result == STP_OK ? add_items(context, list, store, &items) : result;
    stp_draw_list_destroy(context, &items);
    return result;
}

stp_result tool_shapes_add_splats(stp_context* context, tool_shape_list* list,
                                  const tool_splat_set* splats)
{
    stp_disk_shape* to = add_disks(context, list, splats->count);
    if (to == NULL) {
        return STP_ERROR_OUT_OF_MEMORY;
    }
    for (uint32_t i = 0; i < splats->count; ++i) {
        const stp_ellipse* e = &splats->ellipses[i];
        stp_vec3d center = {(double)e->center.x + splats->origin[0] - list->origin[0],
                            (double)e->center.y + splats->origin[1] - list->origin[1],
                            (double)e->center.z + splats->origin[2] - list->origin[2]};
        stp_vec3 across = stp_normalize(stp_cross(e->normal, e->major));
        to[i] = (stp_disk_shape){stp_to_float(center), e->major, stp_scale(across, e->minor)};
    }
    list->disk_count += splats->count;
    return STP_OK;
}

stp_result tool_shapes_draw_points(stp_context* context, tool_shape_list* list)
{
    stp_disk_shape* to = add_disks(context, list, list->point_count);
    if (to == NULL) {
        return STP_ERROR_OUT_OF_MEMORY;
    }
    for (size_t i = 0; i < list->point_count; ++i) {
        const float* p = list->points + 3 * i;
        to[i] = (stp_disk_shape){.center = {p[0], p[1], p[2]}};
    }
    list->disk_count += list->point_count;
    list->point_count = 0;
    return STP_OK;
}

static void add_to_box(stp_boxd* box, const float* p)
{
    stp_boxd_add(box, (stp_vec3d){(double)p[0], (double)p[1], (double)p[2]});
}

stp_boxd tool_shapes_bounds(const tool_shape_list* list)
{
    stp_boxd box = stp_boxd_empty();
    for (size_t i = 0; i < 3 * list->triangle_count; ++i) {
        add_to_box(&box, list->positions + 3 * (size_t)list->indices[i]);
    }
    for (size_t i = 0; i < list->point_count; ++i) {
        add_to_box(&box, list->points + 3 * i);
    }
    return box;
}

stp_shapes tool_shapes_drawn(const tool_shape_list* list)
{
    return (stp_shapes){.disks = list->disks,
                        .disk_count = list->disk_count,
                        .positions = list->positions,
                        .indices = list->indices,
                        .triangle_count = list->triangle_count};
}

stp_measured_surface tool_shapes_surface(const tool_shape_list* list)
{
    return (stp_measured_surface){.positions = list->positions,
                                  .vertex_count = list->vertex_count,
                                  .indices = list->indices,
                                  .triangle_count = list->triangle_count,
                                  .points = list->points,
                                  .point_count = list->point_count};
}

void tool_shapes_destroy(stp_context* context, tool_shape_list* list)
{
    stp_free(context, list->disks);
    stp_free(context, list->positions);
    stp_free(context, list->indices);
    stp_free(context, list->points);
    *list = (tool_shape_list){0};
}
