// SPDX-License-Identifier: MIT
#include "lod/levels/node_levels.h"

#include "base/io/hash.h"
#include "lod/levels/mesh_edges.h"

#include <assert.h>
#include <string.h>

#define CORNER_SHARE 0.5 // of a triangle's width: what the colour of a corner averages
#define POINT_SHARE 0.2  // the same inside

/// The triangles of a node, welded.
typedef struct welded {
    stp_context* context;
    const stp_scene* scene;
    const stp_placed_part* parts;
    size_t part_count;
    uint32_t vertex_count, triangle_count;
    float* positions;
    uint32_t* indices;
    uint32_t* tags; ///< materials
    uint8_t* locked;
    uint8_t* front_only;     ///< per material; NULL: none of those used
    float *colors, *spreads; ///< NULL: each material has one colour
    uint32_t* slots;         ///< hash table: 1 + vertex
    uint32_t slot_mask;
    stp_box box;
    double least_step;
    bool has_pieces;
} welded;

bool stp_levels_replace(const stp_scene* scene, stp_part part)
{
    return part.kind == STP_PART_MESH &&
           scene->materials[scene->meshes[part.index].material].alpha_mode == STP_ALPHA_OPAQUE;
}

static uint32_t weld(welded* w, stp_vec3 position)
{
    float at[3] = {position.x + 0.0f, position.y + 0.0f, position.z + 0.0f}; // -0 becomes 0
    // seeded with an address, so that no file can cause collisions
    stp_hash seed = {.low = (uint64_t)(uintptr_t)w};
    uint32_t slot = (uint32_t)stp_hash_bytes(seed, at, sizeof(at)).low & w->slot_mask;
    for (; w->slots[slot] != 0; slot = (slot + 1) & w->slot_mask) {
        uint32_t vertex = w->slots[slot] - 1;
        if (memcmp(w->positions + 3 * (size_t)vertex, at, sizeof(at)) == 0) {
            return vertex;
        }
    }
    memcpy(w->positions + 3 * (size_t)w->vertex_count, at, sizeof(at));
    stp_box_add(&w->box, (stp_vec3){at[0], at[1], at[2]});
    w->slots[slot] = ++w->vertex_count;
    return w->vertex_count - 1;
}

/// The colours of a triangle's corners, and how much colours inside differ from their mixture.
static void find_colors(welded* w, const stp_capture_textures* textures, const stp_mesh* mesh,
                        uint32_t triangle)
{
    static const float corners[3][3] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
    static const float points[6][3] = {{0.6f, 0.2f, 0.2f}, {0.2f, 0.6f, 0.2f}, {0.2f, 0.2f, 0.6f},
                                       {0.4f, 0.4f, 0.2f}, {0.2f, 0.4f, 0.4f}, {0.4f, 0.2f, 0.4f}};
    float* color = w->colors + 9 * (size_t)w->triangle_count;
    double sum = 0.0;
    for (size_t k = 0; k < 3; ++k) {
        stp_capture_triangle_color(textures, mesh, triangle, corners[k], CORNER_SHARE,
                                   color + 3 * k);
    }
    for (int i = 0; i < 6; ++i) {
        float inside[3];
        stp_capture_triangle_color(textures, mesh, triangle, points[i], POINT_SHARE, inside);
        for (int c = 0; c < 3; ++c) {
            float mixed =
                points[i][0] * color[c] + points[i][1] * color[3 + c] + points[i][2] * color[6 + c];
            double d = sqrt(fmax((double)inside[c], 0.0)) - sqrt(fmax((double)mixed, 0.0));
            sum += d * d;
        }
    }
    w->spreads[2 * (size_t)w->triangle_count] = (float)(sum / 18.0);
    w->spreads[2 * (size_t)w->triangle_count + 1] = 0.0f;
}

static void swap_corners(welded* w, uint32_t triangle)
{
    uint32_t* c = w->indices + 3 * (size_t)triangle;
    uint32_t corner = c[1];
    c[1] = c[2];
    c[2] = corner;
    for (size_t k = 0; k < 3 && w->colors != NULL; ++k) {
        float* color = w->colors + 9 * (size_t)triangle;
        float other = color[3 + k];
        color[3 + k] = color[6 + k];
        color[6 + k] = other;
    }
}

/// Whether a transform turns the order of corners around.
static bool is_mirrored(const stp_affine* a)
{
    return stp_affine_determinant(a) < 0.0;
}

/// Appends a triangle, unless two corners are the same vertex.
static void add_triangle(welded* w, const stp_capture_textures* textures, const stp_mesh* mesh,
                         uint32_t triangle, bool mirrored)
{
    const uint32_t* c = w->indices + 3 * (size_t)w->triangle_count;
    if (c[0] == c[1] || c[1] == c[2] || c[2] == c[0]) {
        return;
    }
    w->tags[w->triangle_count] = mesh->material;
    if (w->colors != NULL) {
        find_colors(w, textures, mesh, triangle);
    }
    if (mirrored) {
        swap_corners(w, w->triangle_count);
    }
    w->triangle_count += 1;
}

static stp_result add_mesh(welded* w, const stp_capture_textures* textures, const stp_mesh* mesh,
                           const stp_affine* transform)
{
    bool mirrored = is_mirrored(transform);
    w->has_pieces = w->has_pieces || mesh->is_piece;
    double step = mesh->grid_step * stp_affine_scale(transform);
    if (step > 0.0) {
        w->least_step = fmin(w->least_step, step);
    }
    uint32_t* numbers = STP_NEW_ARRAY(w->context, uint32_t, (size_t)mesh->vertex_count + 1);
    if (numbers == NULL) {
        return stp_fail_memory(w->context);
    }
    memset(numbers, 0xff, mesh->vertex_count * sizeof(*numbers));
    for (uint32_t t = 0; t < mesh->triangle_count; ++t) {
        uint32_t* c = w->indices + 3 * (size_t)w->triangle_count;
        for (size_t k = 0; k < 3; ++k) {
            uint32_t v = mesh->indices[3 * (size_t)t + k];
            const float* p = mesh->positions + 3 * (size_t)v;
            if (numbers[v] == UINT32_MAX) {
                stp_vec3d at = {(double)p[0], (double)p[1], (double)p[2]};
                numbers[v] = weld(w, stp_to_float(stp_affine_point(transform, at)));
            }
            c[k] = numbers[v];
        }
        add_triangle(w, textures, mesh, t, mirrored);
    }
    stp_free(w->context, numbers);
    return STP_OK;
}

static bool has_colors(const welded* w, const stp_capture_textures* textures)
{
    bool any = false;
    for (size_t i = 0; i < w->part_count; ++i) {
        stp_part part = w->parts[i].part;
        any = any || (stp_levels_replace(w->scene, part) &&
                      stp_capture_has_colors(textures, &w->scene->meshes[part.index]));
    }
    return any;
}

/// @param vertices of all meshes, at most
static stp_result allocate(welded* w, uint32_t triangles, uint64_t vertices, bool colors)
{
    size_t corners = 3 * (size_t)triangles + 1;
    uint32_t slots = 64;
    while (slots < 2 * vertices && slots < 2 * corners && slots < UINT32_C(1) << 31) {
        slots *= 2;
    }
    w->slot_mask = slots - 1;
    w->positions = STP_NEW_ARRAY(w->context, float, 3 * corners);
    w->indices = STP_NEW_ARRAY(w->context, uint32_t, corners + 3);
    w->tags = STP_NEW_ARRAY(w->context, uint32_t, (size_t)triangles + 1);
    w->slots = STP_NEW_ZEROED(w->context, uint32_t, slots);
    bool good = w->positions != NULL && w->indices != NULL && w->tags != NULL && w->slots != NULL;
    if (good && colors) {
        w->colors = STP_NEW_ARRAY(w->context, float, 9 * ((size_t)triangles + 1));
        w->spreads = STP_NEW_ARRAY(w->context, float, 2 * ((size_t)triangles + 1));
        good = w->colors != NULL && w->spreads != NULL;
    }
    return good ? STP_OK : stp_fail_memory(w->context);
}

/// Locks the ends of open edges: neighbouring pieces of the mesh end there.
static stp_result lock_borders(welded* w)
{
    stp_mesh_edges edges;
    bool good =
        stp_mesh_edges_make(w->context, w->indices, w->triangle_count, w->vertex_count, &edges);
    w->locked = STP_NEW_ZEROED(w->context, uint8_t, (size_t)w->vertex_count + 1);
    good = good && w->locked != NULL;
    for (uint32_t e = 0, begin = 0; e < edges.count && good; begin = edges.ends[e++]) {
        uint32_t ends[2];
        if (edges.ends[e] == begin + 1) {
            stp_edge_ends(w->indices, edges.corners[begin], ends);
            w->locked[ends[0]] = w->locked[ends[1]] = 1;
        }
    }
    stp_mesh_edges_destroy(w->context, &edges);
    return good ? STP_OK : stp_fail_memory(w->context);
}

static stp_result weld_parts(welded* w, uint32_t triangles, const stp_capture_textures* textures)
{
    uint64_t vertices = 0;
    for (size_t i = 0; i < w->part_count; ++i) {
        stp_part part = w->parts[i].part;
        vertices +=
            stp_levels_replace(w->scene, part) ? w->scene->meshes[part.index].vertex_count : 0;
    }
    stp_result result = allocate(w, triangles, vertices, has_colors(w, textures));
    for (size_t i = 0; i < w->part_count && result == STP_OK; ++i) {
        stp_part part = w->parts[i].part;
        if (stp_levels_replace(w->scene, part)) {
            result = add_mesh(w, textures, &w->scene->meshes[part.index], &w->parts[i].transform);
        }
    }
    assert(w->triangle_count <= triangles);
    return result == STP_OK && w->has_pieces ? lock_borders(w) : result;
}

/// Notes which materials are drawn from the front only, if any of the triangles' is.
static stp_result find_front_only(welded* w)
{
    const stp_scene* scene = w->scene;
    bool any = false;
    for (uint32_t t = 0; t < w->triangle_count && !any; ++t) {
        any = scene->materials[w->tags[t]].front_only;
    }
    if (!any) {
        return STP_OK;
    }
    w->front_only = STP_NEW_ARRAY(w->context, uint8_t, scene->material_count);
    for (size_t i = 0; i < scene->material_count && w->front_only != NULL; ++i) {
        w->front_only[i] = scene->materials[i].front_only ? 1 : 0;
    }
    return w->front_only != NULL ? STP_OK : stp_fail_memory(w->context);
}

stp_result stp_node_levels_make(const stp_scene* scene, const stp_placed_part* parts,
                                size_t part_count, const uint8_t* shading_of_material,
                                const stp_capture_textures* textures, stp_node_levels* levels)
{
    uint32_t triangles = 0;
    for (size_t i = 0; i < part_count; ++i) {
        if (stp_levels_replace(scene, parts[i].part)) {
            triangles += scene->meshes[parts[i].part.index].triangle_count;
        }
    }
    assert(triangles <= STP_LEVELS_MOST);
    welded w = {.context = scene->context,
                .scene = scene,
                .parts = parts,
                .part_count = part_count,
                .box = stp_box_empty(),
                .least_step = HUGE_VAL};
    stp_level_graph graph = {0};
    *levels = (stp_node_levels){0};
    stp_result result = triangles > 0 ? weld_parts(&w, triangles, textures) : STP_OK;
    result = result == STP_OK ? find_front_only(&w) : result;
    double diagonal = stp_lengthd(stp_subd(stp_to_double(w.box.max), stp_to_double(w.box.min)));
    if (result == STP_OK && w.triangle_count >= STP_LEVELS_LEAST && diagonal > 0.0 &&
        isfinite(diagonal)) {
        const stp_level_source source = {.vertex_count = w.vertex_count,
                                         .triangle_count = w.triangle_count,
                                         .positions = w.positions,
                                         .indices = w.indices,
                                         .tags = w.tags,
                                         .front_only = w.front_only,
                                         .locked = w.locked,
                                         .colors = w.colors,
                                         .spreads = w.spreads};
        stp_level_desc desc = stp_level_defaults(diagonal);
        desc.hides = !w.has_pieces;
        result = stp_level_graph_make(scene->context, &source, &desc, &graph);
        if (result == STP_OK) {
            result = stp_level_meshes_make(scene, &graph, shading_of_material, w.triangle_count,
                                           desc.useful_error, w.least_step, levels);
        }
    }
    stp_level_graph_destroy(scene->context, &graph);
    void* arrays[] = {w.positions, w.indices, w.tags,  w.locked,
                      w.colors,    w.spreads, w.slots, w.front_only};
    for (size_t i = 0; i < sizeof(arrays) / sizeof(arrays[0]); ++i) {
        stp_free(scene->context, arrays[i]);
    }
    return result;
}

void stp_node_levels_destroy(stp_context* context, stp_node_levels* levels)
{
    for (uint32_t i = 0; i < levels->level_count; ++i) {
        stp_node_level* level = &levels->levels[i];
        stp_free(context, level->positions);
        stp_free(context, level->colors);
        stp_free(context, level->indices);
        stp_free(context, level->clusters);
    }
    stp_free(context, levels->levels);
    stp_free(context, levels->groups);
    *levels = (stp_node_levels){0};
}
