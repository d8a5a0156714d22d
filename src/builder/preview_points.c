// SPDX-License-Identifier: MIT
#include "base/math/color.h"
#include "base/math/rng.h"
#include "base/splats/octahedral.h"
#include "builder/draft_content.h"

#include <assert.h>
#include <string.h>

enum { TRIED = 4 }; ///< triangles examined per point

// A candidate triangle with the total area before it.
typedef struct drawn_triangle {
    uint32_t index;
    double before; ///< twice the total area of the triangles before it
} drawn_triangle;

// A point on a triangle, as weights of its corners.
typedef struct place {
    uint32_t corners[3];
    float weights[3];
} place;

static stp_vec3 corner(const stp_mesh* mesh, uint32_t vertex)
{
    const float* p = mesh->positions + 3 * (size_t)vertex;
    return (stp_vec3){p[0], p[1], p[2]};
}

// Normal scaled to twice the area.
static stp_vec3 face(const stp_mesh* mesh, uint32_t triangle)
{
    const uint32_t* v = mesh->indices + 3 * (size_t)triangle;
    stp_vec3 a = corner(mesh, v[0]);
    return stp_cross(stp_sub(corner(mesh, v[1]), a), stp_sub(corner(mesh, v[2]), a));
}

// Chooses one triangle from each of `count` equal runs, with sums of their areas, all doubled.
// @return the total
static double choose_triangles(const stp_mesh* mesh, uint32_t count, drawn_triangle* chosen)
{
    assert(count <= mesh->triangle_count && "each run has a triangle");
    double sum = 0.0;
    for (uint32_t i = 0; i < count; ++i) {
        uint64_t begin = (uint64_t)i * mesh->triangle_count / count;
        uint64_t end = (uint64_t)(i + 1) * mesh->triangle_count / count;
        uint32_t index =
            (uint32_t)begin + stp_rng_below(mesh->triangle_count, i, (uint32_t)(end - begin));
        stp_vec3 n = face(mesh, index);
        chosen[i] = (drawn_triangle){index, sum};
        sum += sqrt((double)stp_dot(n, n));
    }
    return sum;
}

static float fraction_of(uint64_t bits)
{
    return (float)(bits >> 40) * 0x1p-24f;
}

static place place_in(const stp_mesh* mesh, uint32_t triangle, uint64_t number)
{
    uint64_t bits = stp_rng_hash(triangle, number);
    float u = fraction_of(bits), v = fraction_of(bits << 24);
    if (u + v > 1.0f) {
        u = 1.0f - u;
        v = 1.0f - v;
    }
    place p = {.weights = {1.0f - u - v, u, v}};
    assert(p.weights[0] > -1e-6f && u >= 0.0f && v >= 0.0f && "the point is in the triangle");
    memcpy(p.corners, mesh->indices + 3 * (size_t)triangle, sizeof(p.corners));
    return p;
}

static uint32_t wrap(float at, uint32_t size, stp_wrap how)
{
    float part = how == STP_WRAP_CLAMP ? at : at - floorf(at);
    if (!(part > 0.0f)) {
        return 0;
    }
    float texel = part * (float)size;
    return texel < (float)size ? (uint32_t)texel : size - 1;
}

// The texel at texture coordinates; NULL without a texture.
static const uint8_t* texel_at(const stp_scene* scene, const stp_mesh* mesh, const place* p)
{
    const stp_texture_use* use = &scene->materials[mesh->material].base_color_texture;
    const float* texcoords =
        use->texture != STP_NONE ? mesh->texcoords[use->texcoord != 0 ? 1 : 0] : NULL;
    if (texcoords == NULL) {
        return NULL;
    }
    float at[2] = {0}, uv[2];
    for (int k = 0; k < 3; ++k) {
        at[0] += p->weights[k] * texcoords[2 * (size_t)p->corners[k]];
        at[1] += p->weights[k] * texcoords[2 * (size_t)p->corners[k] + 1];
    }
    for (int k = 0; k < 2; ++k) {
        const float* row = use->transform[k];
        uv[k] = row[0] * at[0] + row[1] * at[1] + row[2];
    }
    const stp_texture* t = &scene->textures[use->texture];
    size_t x = wrap(uv[0], t->width, t->wrap_u), y = wrap(uv[1], t->height, t->wrap_v);
    return t->texels != NULL ? t->texels + 4 * (y * t->width + x) : NULL;
}

// The colour at a point, without the material's base colour. @return false if the point is cut out
static bool color_at(const stp_scene* scene, const stp_mesh* mesh, const place* p, uint8_t out[4])
{
    float color[4] = {1.0f, 1.0f, 1.0f, 1.0f};
    const stp_material* material = &scene->materials[mesh->material];
    const uint8_t* texel = texel_at(scene, mesh, p);
    for (int k = 0; k < 4; ++k) {
        float vertices = 0.0f;
        for (int c = 0; mesh->colors != NULL && c < 3; ++c) {
            vertices += p->weights[c] * (float)mesh->colors[4 * (size_t)p->corners[c] + (size_t)k] /
                        65535.0f;
        }
        color[k] *= mesh->colors != NULL ? vertices : 1.0f;
        if (texel != NULL) {
            color[k] *= k < 3 ? stp_srgb8_to_linear(texel[k]) : (float)texel[k] / 255.0f;
        }
    }
    for (int k = 0; k < 3; ++k) {
        out[k] = stp_linear_to_srgb8(color[k]);
    }
    out[3] = 255;
    bool cutout = material->alpha_mode == STP_ALPHA_MASK &&
                  color[3] * material->base_color[3] < material->alpha_cutoff;
    return !cutout;
}

static void add_point(const stp_mesh* mesh, uint32_t triangle, const place* p, float* position,
                      int16_t* normal)
{
    for (int k = 0; k < 3; ++k) {
        position[k] = 0.0f;
        for (int c = 0; c < 3; ++c) {
            position[k] += p->weights[c] * mesh->positions[3 * (size_t)p->corners[c] + (size_t)k];
        }
    }
    stp_octahedral_encode16(face(mesh, triangle), normal);
}

bool stp_preview_mesh(stp_arena* arena, const stp_scene* scene, uint32_t index, uint32_t count,
                      stp_store_point_set* points)
{
    const stp_mesh* mesh = &scene->meshes[index];
    uint64_t tried = (uint64_t)TRIED * count;
    uint32_t some = tried < mesh->triangle_count ? (uint32_t)tried : mesh->triangle_count;
    drawn_triangle* chosen = STP_NEW_ARRAY(scene->context, drawn_triangle, (size_t)some + 1);
    float* positions = STP_ARENA_ARRAY(arena, float, 3 * (size_t)count + 1);
    int16_t* normals = STP_ARENA_ARRAY(arena, int16_t, 2 * (size_t)count + 1);
    uint8_t* colors = STP_ARENA_ARRAY(arena, uint8_t, 4 * (size_t)count + 1);
    *points = (stp_store_point_set){.name = mesh->name,
                                    .material = mesh->material,
                                    .bounds = mesh->bounds,
                                    .positions = positions,
                                    .normals = normals,
                                    .colors = colors};
    bool made = chosen != NULL && positions != NULL && normals != NULL && colors != NULL;
    double sum = made ? choose_triangles(mesh, some, chosen) : 0.0;
    for (uint32_t i = 0, at = 0; made && some > 0 && sum > 0.0 && i < count; ++i) {
        double where = sum * ((double)i + 0.5) / (double)count;
        while (at + 1 < some && chosen[at + 1].before <= where) {
            at += 1;
        }
        assert(chosen[at].before <= where && "points are in order of area");
        place p = place_in(mesh, chosen[at].index, i);
        size_t n = points->point_count;
        if (color_at(scene, mesh, &p, colors + 4 * n)) {
            add_point(mesh, chosen[at].index, &p, positions + 3 * n, normals + 2 * n);
            points->point_count += 1;
        }
    }
    stp_free(scene->context, chosen);
    return made;
}

/// Copies each attribute that the set has, for the points that stp_preview_points chooses.
static bool preview_attributes(stp_arena* arena, const stp_point_set* from, uint32_t count,
                               stp_store_point_set* points)
{
    assert(count <= from->point_count && "points would repeat");
    for (int a = 0; a < STP_ATTRIBUTES; ++a) {
        const unsigned char* values = from->attributes[a];
        if (values == NULL) {
            continue;
        }
        size_t size = stp_attribute_size((stp_attribute)a);
        unsigned char* taken = stp_arena_alloc_array(arena, (size_t)count + 1, size);
        if (taken == NULL) {
            return false;
        }
        for (uint32_t i = 0; i < count; ++i) {
            size_t k = (size_t)((uint64_t)i * from->point_count / count);
            memcpy(taken + i * size, values + k * size, size);
        }
        points->attributes[a] = taken;
    }
    return true;
}

bool stp_preview_points(stp_arena* arena, const stp_point_set* from, uint32_t count,
                        stp_store_point_set* points)
{
    uint32_t all = from->point_count, n = count < all ? count : all;
    float* positions = STP_ARENA_ARRAY(arena, float, 3 * (size_t)n + 1);
    int16_t* normals =
        from->normals != NULL ? STP_ARENA_ARRAY(arena, int16_t, 2 * (size_t)n + 1) : NULL;
    uint8_t* colors =
        from->colors != NULL ? STP_ARENA_ARRAY(arena, uint8_t, 4 * (size_t)n + 1) : NULL;
    *points = (stp_store_point_set){.name = from->name,
                                    .point_count = n,
                                    .material = from->material,
                                    .bounds = from->bounds,
                                    .positions = positions,
                                    .normals = normals,
                                    .colors = colors};
    if (positions == NULL || (from->normals != NULL && normals == NULL) ||
        (from->colors != NULL && colors == NULL)) {
        return false;
    }
    for (uint32_t i = 0; i < n; ++i) {
        size_t k = (size_t)((uint64_t)i * all / n);
        memcpy(positions + 3 * (size_t)i, from->positions + 3 * k, 3 * sizeof(*positions));
        if (normals != NULL) {
            const float* normal = from->normals + 3 * k;
            stp_octahedral_encode16((stp_vec3){normal[0], normal[1], normal[2]},
                                    normals + 2 * (size_t)i);
        }
        if (colors != NULL) {
            memcpy(colors + 4 * (size_t)i, from->colors + 4 * k, 4);
        }
    }
    return preview_attributes(arena, from, n, points);
}
