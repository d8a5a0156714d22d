// SPDX-License-Identifier: MIT
#include "lab/scan/scan_target.h"

#include "select/camera.h"
#include "select/select.h"
#include "store/clusters/clusters.h"

#include <assert.h>
#include <string.h>

#define MAX_PARTS ((size_t)1 << 24)

/// From a scene's space (y up, its own unit) to the scanner's.
static stp_affine frame_of(double metres)
{
    return (stp_affine){{{metres, 0, 0, 0}, {0, 0, -metres, 0}, {0, metres, 0, 0}}};
}

static stp_result make_room(scan_target* t, size_t meshes, size_t materials, size_t parts)
{
    t->meshes = STP_NEW_ZEROED(t->context, stp_cast_mesh, meshes + 1);
    t->columns = STP_NEW_ZEROED(t->context, scan_columns, meshes + 1);
    t->materials = STP_NEW_ZEROED(t->context, scan_material, materials + 1);
    t->parts = STP_NEW_ARRAY(t->context, stp_cast_part, parts + 1);
    bool good = t->meshes != NULL && t->columns != NULL && t->materials != NULL && t->parts != NULL;
    t->mesh_count = (uint32_t)meshes;
    t->material_count = (uint32_t)materials;
    return good ? STP_OK : stp_fail_memory(t->context);
}

static stp_result finish(scan_target* t, const char* name, stp_result result)
{
    if (result == STP_OK) {
        result = stp_caster_create(t->context, t->meshes, t->mesh_count, t->parts, t->part_count,
                                   &t->caster);
    }
    if (result == STP_OK && stp_boxd_is_empty(stp_caster_bounds(t->caster))) {
        result = stp_fail(t->context, STP_ERROR_FORMAT,
                          "%s: a scan needs triangles, but there are none", name);
    }
    if (result != STP_OK) {
        scan_target_destroy(t);
    }
    return result;
}

static void set_texture(scan_material* m, const uint8_t* texels, uint32_t width, uint32_t height,
                        bool nearest)
{
    m->textured = texels != NULL && width > 0 && height > 0;
    m->texture.level_count = 1;
    m->texture.width[0] = width;
    m->texture.height[0] = height;
    m->texture.texels[0] = texels;
    m->texture.nearest = nearest;
}

static void add_scene_material(const stp_scene* scene, const stp_material* from, scan_material* to)
{
    const stp_texture_use* use = &from->base_color_texture;
    memcpy(to->base_color, from->base_color, sizeof(to->base_color));
    memcpy(to->uv_transform, use->transform, sizeof(to->uv_transform));
    to->asks = from->alpha_mode != STP_ALPHA_OPAQUE;
    to->cutoff = from->alpha_mode == STP_ALPHA_MASK ? from->alpha_cutoff : 0.0f;
    to->texcoord = use->texcoord != 0 ? 1 : 0;
    if (use->texture != STP_NONE) {
        const stp_texture* x = &scene->textures[use->texture];
        set_texture(to, x->texels, x->width, x->height, x->nearest);
        to->texture.wrap_u = (stp_texture_wrap)x->wrap_u;
        to->texture.wrap_v = (stp_texture_wrap)x->wrap_v;
    }
}

static void add_part(scan_target* t, uint32_t mesh, const stp_affine* transform)
{
    stp_affine frame = frame_of(t->metres);
    t->parts[t->part_count++] =
        (stp_cast_part){.mesh = mesh, .transform = stp_affine_multiply(frame, *transform)};
}

stp_result scan_target_of_scene(const stp_scene* scene, const char* name, scan_target* target)
{
    double metres = scene->unit_metres > 0.0 ? scene->unit_metres : 1.0;
    *target = (scan_target){.context = scene->context, .metres = metres};
    stp_placed_part* placed = NULL;
    size_t count = 0;
    stp_result result = STP_OK;
    if (scene->root != STP_NONE) {
        result = stp_scene_flatten(scene, scene->root, MAX_PARTS, &placed, &count);
    }
    result = result == STP_OK ? make_room(target, scene->mesh_count, scene->material_count, count)
                              : result;
    for (size_t i = 0; result == STP_OK && i < scene->material_count; ++i) {
        add_scene_material(scene, &scene->materials[i], &target->materials[i]);
    }
    for (size_t i = 0; result == STP_OK && i < scene->mesh_count; ++i) {
        const stp_mesh* m = &scene->meshes[i];
        target->meshes[i] = (stp_cast_mesh){
            .positions = m->positions, .indices = m->indices, .triangle_count = m->triangle_count};
        target->columns[i] =
            (scan_columns){.texcoords = m->texcoords[target->materials[m->material].texcoord],
                           .colors = m->colors,
                           .material = m->material};
    }
    for (size_t i = 0; result == STP_OK && i < count; ++i) {
        if (placed[i].part.kind == STP_PART_MESH) {
            add_part(target, placed[i].part.index, &placed[i].transform);
        }
    }
    stp_free(scene->context, placed);
    return finish(target, name, result);
}

static stp_result add_store_material(stp_store* store, const stp_store_material* from,
                                     scan_material* to)
{
    const stp_store_texture_use* use = &from->base_color_texture;
    memcpy(to->base_color, from->base_color, sizeof(to->base_color));
    memcpy(to->uv_transform, use->transform, sizeof(to->uv_transform));
    to->asks = from->alpha != STP_STORE_OPAQUE;
    to->cutoff = from->alpha == STP_STORE_MASK ? from->alpha_cutoff : 0.0f;
    to->texcoord = use->texcoord != 0 ? 1 : 0;
    if (use->texture == STP_STORE_NONE) {
        return STP_OK;
    }
    stp_store_texture x;
    stp_result result = stp_store_get_texture(store, use->texture, &x);
    if (result == STP_OK) {
        set_texture(to, x.texels, x.width, x.height, x.nearest != 0);
        to->texture.wrap_u = (stp_texture_wrap)x.wrap_u;
        to->texture.wrap_v = (stp_texture_wrap)x.wrap_v;
    }
    return result;
}

static stp_result add_clustered(scan_target* t, stp_store* store, uint32_t index)
{
    stp_clusters clusters;
    stp_decoded_mesh mesh = {0};
    stp_result result = stp_store_get_clusters(store, index, &clusters);
    result = result == STP_OK ? stp_clusters_decode(t->context, &clusters, &mesh) : result;
    if (result != STP_OK) {
        return result;
    }
    scan_columns* c = &t->columns[index];
    uint32_t set = t->materials[c->material].texcoord;
    t->meshes[index] =
        (stp_cast_mesh){.positions = mesh.positions, .triangle_count = mesh.triangle_count};
    c->texcoords = mesh.texcoords[set];
    c->wide_colors = mesh.colors;
    c->owned[0] = mesh.positions;
    c->owned[1] = mesh.texcoords[set];
    c->owned[2] = mesh.colors;
    mesh.positions = mesh.texcoords[set] = mesh.colors = NULL;
    stp_decoded_mesh_destroy(t->context, &mesh);
    return STP_OK;
}

static stp_result add_store_mesh(scan_target* t, stp_store* store, uint32_t index)
{
    scan_columns* c = &t->columns[index];
    c->material = stp_store_describe_mesh(store, index)->material;
    if (stp_store_is_clustered(store, index)) {
        return add_clustered(t, store, index);
    }
    stp_store_mesh mesh;
    stp_result result = stp_store_get_mesh(store, index, &mesh);
    if (result != STP_OK) {
        return result;
    }
    // a mapped file can be overwritten after its check: indices are copied as they are checked
    uint32_t* indices = STP_NEW_ARRAY(t->context, uint32_t, 3 * (size_t)mesh.triangle_count + 1);
    if (indices == NULL) {
        return stp_fail_memory(t->context);
    }
    for (size_t i = 0; i < 3 * (size_t)mesh.triangle_count; ++i) {
        indices[i] = stp_store_mesh_corner(&mesh, i);
    }
    t->meshes[index] = (stp_cast_mesh){
        .positions = mesh.positions, .indices = indices, .triangle_count = mesh.triangle_count};
    c->texcoords = mesh.texcoords[t->materials[c->material].texcoord];
    c->colors = mesh.colors;
    c->owned[0] = indices;
    return STP_OK;
}

/// Lists all uses of all meshes.
static stp_result list_store(stp_context* context, stp_store* store, stp_draw_list* items)
{
    const stp_store_directory* d = stp_store_get_directory(store);
    stp_view view = {.width = 256, .height = 256};
    const stp_quality all = {.splat_size = 1.0f, .reference = true};
    if (d->root == STP_STORE_NONE) {
        return STP_OK;
    }
    (void)stp_camera_frame("iso", &d->nodes[d->root].bounds, &view);
    return stp_select(context, store, &view, &all, items);
}

stp_result scan_target_of_store(stp_context* context, stp_store* store, const char* name,
                                scan_target* target)
{
    const stp_store_directory* d = stp_store_get_directory(store);
    *target =
        (scan_target){.context = context, .metres = d->unit_metres > 0.0 ? d->unit_metres : 1.0};
    stp_draw_list items = {0};
    stp_result result = list_store(context, store, &items);
    if (result == STP_OK && items.count > MAX_PARTS) {
        result = stp_fail(context, STP_ERROR_LIMIT, "%s: expected at most %zu uses of parts", name,
                          MAX_PARTS);
    }
    uint32_t meshes = stp_store_first_level_mesh(d); // levels are no part of anything
    result = result == STP_OK ? make_room(target, meshes, d->material_count, items.count) : result;
    for (uint32_t i = 0; result == STP_OK && i < d->material_count; ++i) {
        result = add_store_material(store, &d->materials[i], &target->materials[i]);
    }
    for (uint32_t i = 0; result == STP_OK && i < meshes; ++i) {
        result = add_store_mesh(target, store, i);
    }
    for (size_t i = 0; result == STP_OK && i < items.count; ++i) {
        if (items.items[i].kind == STP_DRAW_MESH) {
            add_part(target, items.items[i].index, &items.items[i].transform);
        }
    }
    stp_draw_list_destroy(context, &items);
    return finish(target, name, result);
}

void scan_target_destroy(scan_target* target)
{
    stp_context* context = target->context;
    stp_caster_destroy(context, target->caster);
    for (uint32_t i = 0; target->columns != NULL && i < target->mesh_count; ++i) {
        for (int k = 0; k < 3; ++k) {
            stp_free(context, target->columns[i].owned[k]);
        }
    }
    stp_free(context, target->meshes);
    stp_free(context, target->columns);
    stp_free(context, target->materials);
    stp_free(context, target->parts);
    *target = (scan_target){.context = context};
}

/// Colour and alpha at a ray's hit on a triangle.
static void color_of(const scan_target* t, const stp_cast_hit* hit, float out[4])
{
    uint32_t mesh = t->parts[hit->part].mesh;
    const scan_columns* c = &t->columns[mesh];
    const scan_material* m = &t->materials[c->material];
    const uint32_t* indices = t->meshes[mesh].indices;
    float uv[2] = {0.0f, 0.0f}, own[4] = {0.0f, 0.0f, 0.0f, 0.0f};
    for (size_t k = 0; k < 3; ++k) {
        size_t at = 3 * (size_t)hit->triangle + k, vertex = indices != NULL ? indices[at] : at;
        float share = (float)hit->share[k];
        for (size_t i = 0; i < 2 && c->texcoords != NULL; ++i) {
            uv[i] += share * c->texcoords[2 * vertex + i];
        }
        for (size_t i = 0; i < 4; ++i) {
            own[i] += share * (c->colors != NULL ? (float)c->colors[4 * vertex + i] / 65535.0f
                               : c->wide_colors != NULL ? c->wide_colors[4 * vertex + i]
                                                        : 1.0f);
        }
    }
    float texel[4] = {1.0f, 1.0f, 1.0f, 1.0f};
    if (m->textured && c->texcoords != NULL) {
        const float(*x)[3] = m->uv_transform;
        stp_vec2 place = {x[0][0] * uv[0] + x[0][1] * uv[1] + x[0][2],
                          x[1][0] * uv[0] + x[1][1] * uv[1] + x[1][2]};
        stp_texture_sample(&m->texture, place, 1.0f, texel);
    }
    for (int i = 0; i < 4; ++i) {
        out[i] = stp_clamp(m->base_color[i] * own[i] * texel[i], 0.0f, 1.0f);
    }
}

static bool is_opaque_hit(const stp_cast_hit* hit, void* user)
{
    const scan_target* t = user;
    const scan_material* m = &t->materials[t->columns[t->parts[hit->part].mesh].material];
    if (!m->asks) {
        return true;
    }
    float color[4];
    color_of(t, hit, color);
    return m->cutoff > 0.0f ? color[3] >= m->cutoff : color[3] > 0.0f;
}

bool scan_target_intersect(const scan_target* target, stp_vec3d origin, stp_vec3d direction,
                           double nearest, double farthest, scan_surface* surface)
{
    stp_cast_hit hit;
    assert(fabs(stp_dotd(direction, direction) - 1.0) < 1e-4 && "unit length");
    const stp_cast_ray ray = {origin, direction, nearest, farthest};
    scan_target* t = (scan_target*)(uintptr_t)target; // is_opaque_hit only reads it
    if (!stp_caster_intersect(target->caster, &ray, is_opaque_hit, t, &hit)) {
        return false;
    }
    stp_vec3d c[3];
    float color[4];
    stp_caster_corners(target->caster, hit.part, hit.triangle, c);
    color_of(target, &hit, color);
    stp_vec3d normal = stp_normalized(stp_crossd(stp_subd(c[1], c[0]), stp_subd(c[2], c[0])));
    bool behind = stp_dotd(normal, direction) > 0.0;
    bool mirrored =
        stp_affine_determinant(&target->parts[hit.part].transform) < 0.0; // winding is turned, too
    *surface = (scan_surface){.place = stp_addd(origin, stp_scaled(direction, hit.distance)),
                              .normal = behind ? stp_scaled(normal, -1.0) : normal,
                              .from_behind = behind != mirrored,
                              .color = {color[0], color[1], color[2]},
                              .distance = hit.distance,
                              .object = hit.part};
    return true;
}
