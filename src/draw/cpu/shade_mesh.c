// SPDX-License-Identifier: MIT
//
// Surfaces of triangles. Most are flat: all pixels share normal and colour. For the others,
// interpolation weights are cached, and each pixel gets its own surface.
#include "draw/cpu/shade.h"
#include "draw/cpu/triangle.h"
#include "raster/normal_map.h"

#include <assert.h>
#include <string.h>

enum { PLACE_BITS = 8, PLACES = 1 << PLACE_BITS, OPEN_BITS = 5, OPEN = 1 << OPEN_BITS };

/// Four numbers at once, as a compiler vector type: the same bits everywhere.
typedef float four __attribute__((vector_size(16)));
typedef int32_t four_int __attribute__((vector_size(16)));

/// Interpolation data of a triangle. The weight of corner k at pixel (x, y), up to a factor common
/// to all corners, is the linear function line[k][0] + line[k][1] x + line[k][2] y, if above 0.
typedef struct mixed_triangle {
    bool is_smooth; ///< has normals
    bool has_color;
    float density; ///< texels of the base colour per item unit
    double line[3][3];
    four normal[3], flat;  ///< scene space, unit length; the flat normal only if needed
    four color[3];         ///< multiplied by the material's
    bool has_tangents;     ///< a normal map applies
    stp_tangents tangents; ///< scene space
} mixed_triangle;

/// A recently used cluster: ids [first_id, first_id + count).
typedef struct cluster_place {
    uint32_t first_id, count, cluster;
} cluster_place;

typedef struct open_cluster {
    uint32_t item, index; ///< item UINT32_MAX: none
    stp_cluster cluster;
} open_cluster;

struct stp_cpu_triangle_memory {
    cluster_place places[PLACES];
    open_cluster open[OPEN];   ///< neighbouring pixels belong to few clusters
    stp_cpu_reader reader;     ///< for meshes without clusters
    stp_cpu_triangle triangle; ///< read last
    mixed_triangle mixed[SHADE_KEPT];
};

stp_cpu_triangle_memory* stp_cpu_make_triangle_memory(stp_context* context)
{
    return STP_NEW_ZEROED(context, stp_cpu_triangle_memory, 1);
}

void stp_cpu_reset_triangles(stp_cpu_triangle_memory* memory)
{
    memset(memory->places, 0, sizeof(memory->places));
    for (int i = 0; i < OPEN; ++i) {
        memory->open[i].item = UINT32_MAX;
    }
    memory->reader = (stp_cpu_reader){0};
}

static void find_cluster(const stp_cpu_item* item, uint32_t index, cluster_place* place)
{
    const stp_clusters* clusters = &item->clusters;
    uint32_t cluster = stp_clusters_find(clusters, index);
    uint32_t first = stp_clusters_first_triangle(clusters, cluster);
    uint32_t count = stp_clusters_triangles(clusters, cluster);
    // in an overwritten file they may be those of another item
    bool own = first <= index && index - first < count && count <= clusters->triangle_count - first;
    *place = own ? (cluster_place){item->first_id + first, count, cluster}
                 : (cluster_place){item->first_id + index, 1, cluster};
    stp_clusters_prefetch(clusters, cluster);
}

void stp_cpu_prefetch_triangle(const stp_cpu_renderer* r, stp_cpu_shade_memory* memory, uint32_t at)
{
    const stp_cpu_item* item = &r->items[memory->item[at]];
    uint32_t id = memory->slots[at].id;
    assert(at < SHADE_KEPT && id >= item->first_id);
    if (item->clusters.bytes != NULL) {
        uint32_t key = (id >> 6) * 0x9E3779B1u >> (32 - PLACE_BITS);
        cluster_place* place = &memory->triangles->places[key];
        if (id - place->first_id >= place->count) {
            find_cluster(item, id - item->first_id, place);
        }
        memory->cluster[at] = place->cluster;
    }
}

static const stp_cluster* open_cluster_of(const stp_cpu_item* item, stp_cpu_shade_memory* memory,
                                          uint32_t at)
{
    uint32_t slot = memory->item[at], index = memory->cluster[at];
    uint32_t key = (slot * 0x85EBCA6Bu + index) * 0x9E3779B1u >> (32 - OPEN_BITS);
    open_cluster* open = &memory->triangles->open[key];
    if (open->item != slot || open->index != index) {
        open->item = slot;
        open->index = index;
        stp_clusters_get(&item->clusters, index, &open->cluster);
    }
    return &open->cluster;
}

/// Triangle of surface `at`, valid until the next call.
static const stp_cpu_triangle* read_triangle(const stp_cpu_item* item, stp_cpu_shade_memory* memory,
                                             uint32_t at)
{
    stp_cpu_triangle_memory* triangles = memory->triangles;
    uint32_t index = memory->slots[at].id - item->first_id;
    if (item->clusters.bytes == NULL) {
        return stp_cpu_read_triangle(&triangles->reader, item, index);
    }
    stp_cpu_read_from_cluster(item, open_cluster_of(item, memory, at), index, &triangles->triangle);
    return &triangles->triangle;
}

static stp_vec3 flat_normal(const float c[3][3])
{
    return stp_normalize(
        stp_cross((stp_vec3){c[1][0] - c[0][0], c[1][1] - c[0][1], c[1][2] - c[0][2]},
                  (stp_vec3){c[2][0] - c[0][0], c[2][1] - c[0][1], c[2][2] - c[0][2]}));
}

/// Weight functions: with corners (X, Y, W) on the screen, the weight of corner 0 is the
/// determinant of (X1 - x W1, Y1 - y W1) and (X2 - x W2, Y2 - y W2), which is linear in x and y;
/// cyclic for the others.
static void make_lines(const stp_cpu_renderer* r, const stp_cpu_item* item,
                       const stp_cpu_triangle* triangle, double line[3][3])
{
    static const int rows[3] = {0, 1, 3};
    double corner[3][3], maximum = 0.0, sign = 0.0;
    for (int k = 0; k < 3; ++k) {
        const float* p = triangle->position[k];
        for (int i = 0; i < 3; ++i) {
            const float* m = item->camera.matrix.m[rows[i]];
            corner[k][i] = (double)m[0] * (double)p[0] + (double)m[1] * (double)p[1] +
                           (double)m[2] * (double)p[2] + (double)m[3];
        }
    }
    for (int k = 0; k < 3; ++k) {
        const double *a = corner[(k + 1) % 3], *b = corner[(k + 2) % 3];
        line[k][0] = a[0] * b[1] - b[0] * a[1];
        line[k][1] = a[1] * b[2] - b[1] * a[2];
        line[k][2] = a[2] * b[0] - b[2] * a[0];
        maximum = stp_maxd(maximum, fabs(line[k][0]));
        maximum = stp_maxd(maximum, fabs(line[k][1]) * r->width);
        maximum = stp_maxd(maximum, fabs(line[k][2]) * r->height);
        sign += corner[k][2] * line[k][0]; // determinant of all three: the orientation
    }
    double factor = maximum > 0.0 && maximum <= DBL_MAX ? (sign < 0.0 ? -1.0 : 1.0) / maximum : 0.0;
    for (int k = 0; k < 9; ++k) {
        line[k / 3][k % 3] *= factor;
    }
}

/// From the item to the scene.
static four turn(const stp_cpu_shade_item* item, stp_vec3 v)
{
    const float(*m)[3] = item->normal_matrix;
    return (four){m[0][0] * v.x + m[0][1] * v.y + m[0][2] * v.z,
                  m[1][0] * v.x + m[1][1] * v.y + m[1][2] * v.z,
                  m[2][0] * v.x + m[2][1] * v.y + m[2][2] * v.z, 0.0f};
}

/// From the item to the scene, normalized; zero stays zero.
static four turn_to_unit(const stp_cpu_shade_item* item, stp_vec3 v)
{
    four turned = turn(item, v), squares = turned * turned;
    float square = squares[0] + squares[1] + squares[2];
    return turned * (square > 0.0f ? 1.0f / sqrtf(square) : 0.0f);
}

static bool are_alike(const void* corners, size_t size)
{
    const unsigned char* bytes = corners;
    return memcmp(bytes, bytes + size, size) == 0 && memcmp(bytes, bytes + 2 * size, size) == 0;
}

/// Whether an interpolation of the unit normals may be much shorter than they are.
static bool may_cancel(const four normal[3])
{
    for (int k = 0; k < 3; ++k) {
        four product = normal[k] * normal[(k + 1) % 3];
        if (!(product[0] + product[1] + product[2] > -0.4f)) { // at -0.5 three may be of length 0
            return true;
        }
    }
    return false;
}

static stp_vec3 first_three(four v)
{
    return (stp_vec3){v[0], v[1], v[2]};
}

/// Tangents of a triangle for its item's normal map. Placements keep angles, so what turns normals
/// turns them, too.
static bool find_tangents(const stp_cpu_item* item, const stp_cpu_shade_item* shade,
                          const stp_cpu_triangle* triangle, stp_tangents* tangents)
{
    const stp_store_texture_use* use = &item->material->normal_texture;
    int set = use->texcoord != 0 ? 1 : 0;
    if (!triangle->has_texcoord[set]) {
        return false;
    }
    const float(*p)[3] = triangle->position;
    stp_vec3 edges[2];
    float uv[2][2];
    for (int k = 0; k < 2; ++k) {
        edges[k] = (stp_vec3){p[k + 1][0] - p[0][0], p[k + 1][1] - p[0][1], p[k + 1][2] - p[0][2]};
        const float *a = triangle->texcoord[set][0], *b = triangle->texcoord[set][k + 1];
        for (int i = 0; i < 2; ++i) {
            uv[k][i] = use->transform[i][0] * (b[0] - a[0]) + use->transform[i][1] * (b[1] - a[1]);
        }
    }
    if (!stp_tangents_find(edges, (const float(*)[2])uv, tangents)) {
        return false;
    }
    tangents->right = first_three(turn_to_unit(shade, tangents->right));
    tangents->up = first_three(turn_to_unit(shade, tangents->up));
    return true;
}

static void mix_triangle(const stp_cpu_renderer* r, const stp_cpu_item* item,
                         const stp_cpu_shade_item* shade, const stp_cpu_triangle* triangle,
                         mixed_triangle* mixed)
{
    const float* base = item->material->base_color;
    mixed->is_smooth = triangle->has_normal;
    mixed->has_color = triangle->has_color;
    mixed->density = 0.0f;
    if (item->base_color != NULL) {
        mixed->density =
            stp_cpu_mesh_density(triangle, &item->material->base_color_texture, item->base_color);
    }
    mixed->has_tangents =
        item->normal_map != NULL && find_tangents(item, shade, triangle, &mixed->tangents);
    make_lines(r, item, triangle, mixed->line);
    for (int k = 0; k < 3; ++k) {
        const float* color = triangle->color[k];
        mixed->color[k] = (four){base[0], base[1], base[2], base[3]};
        if (triangle->has_color) {
            mixed->color[k] *= (four){color[0], color[1], color[2], color[3]};
        }
        if (triangle->has_normal) {
            mixed->normal[k] = turn_to_unit(shade, triangle->normal[k]);
        }
    }
    if (!triangle->has_normal || may_cancel(mixed->normal)) {
        mixed->flat = turn_to_unit(shade, flat_normal(triangle->position));
    }
}

/// Normal of a triangle, if it has a single one and its mesh consists of clusters without colours.
/// @return false otherwise
static bool find_only_normal(const stp_cpu_item* item, stp_cpu_shade_memory* memory, uint32_t at,
                             stp_vec3* normal)
{
    if (item->clusters.bytes == NULL || (item->clusters.present & STP_COLUMN_COLORS) != 0) {
        return false;
    }
    const stp_cluster* cluster = open_cluster_of(item, memory, at);
    uint32_t local = memory->slots[at].id - item->first_id - cluster->first_triangle;
    if (local < cluster->smooth_count) {
        return false;
    }
    stp_vec3 normals[3];
    if (stp_cluster_normals(cluster, local, normals)) {
        *normal = normals[0];
        return true;
    }
    uint32_t corner[3];
    float position[3][3];
    stp_cluster_corners(cluster, local, corner);
    for (int k = 0; k < 3; ++k) {
        stp_vec3 p = stp_cluster_position(&item->clusters, cluster, corner[k]);
        position[k][0] = p.x;
        position[k][1] = p.y;
        position[k][2] = p.z;
    }
    *normal = flat_normal((const float(*)[3])position);
    return true;
}

static void make_flat(const stp_cpu_renderer* r, const stp_cpu_item* item,
                      const stp_cpu_shade_item* shade, stp_vec3 normal, const float* vertex_color,
                      stp_cpu_shade_surface* surface)
{
    four turned = turn(shade, normal);
    memcpy(surface->normal, &turned, sizeof(turned));
    surface->normal[3] = 0.0f;
    surface->material = r->shade_materials[shade->material];
    for (int k = 0; k < 4; ++k) {
        float factor = vertex_color != NULL ? vertex_color[k] : 1.0f;
        surface->color[k] = item->material->base_color[k] * factor;
    }
}

stp_cpu_shade_kind stp_cpu_make_triangle_surface(const stp_cpu_renderer* r,
                                                 stp_cpu_shade_memory* memory, uint32_t at)
{
    const stp_cpu_item* item = &r->items[memory->item[at]];
    const stp_cpu_shade_item* shade = &r->shade_items[memory->item[at]];
    stp_cpu_shade_surface* surface = &memory->surfaces[at];
    assert(item->kind == STP_DRAW_MESH && at < SHADE_KEPT);
    bool textured = item->base_color != NULL || item->metallic_roughness != NULL ||
                    item->emissive != NULL || item->normal_map != NULL;
    stp_vec3 normal;
    if (!textured && find_only_normal(item, memory, at, &normal)) {
        make_flat(r, item, shade, normal, NULL, surface);
        return SHADE_FLAT;
    }
    const stp_cpu_triangle* triangle = read_triangle(item, memory, at);
    bool one_normal = !triangle->has_normal || are_alike(triangle->normal, sizeof(stp_vec3));
    bool one_color = !triangle->has_color || are_alike(triangle->color, sizeof(triangle->color[0]));
    if (textured || !one_normal || !one_color) {
        surface->material = r->shade_materials[shade->material];
        mix_triangle(r, item, shade, triangle, &memory->triangles->mixed[at]);
        return textured ? SHADE_TEXTURED : SHADE_SMOOTH;
    }
    normal = triangle->has_normal ? triangle->normal[0] : flat_normal(triangle->position);
    make_flat(r, item, shade, normal, triangle->has_color ? triangle->color[0] : NULL, surface);
    return SHADE_FLAT;
}

static four mix(const four corners[3], four share)
{
    return corners[0] * share[0] + corners[1] * share[1] + corners[2] * share[2];
}

static void sample_texture(const stp_cpu_triangle* triangle, const stp_store_texture_use* use,
                           const stp_texture_pyramid* pyramid, const float weight[3],
                           float pixel_size, float texel[4])
{
    float footprint = stp_cpu_mesh_density(triangle, use, pyramid) * pixel_size;
    stp_texture_sample(pyramid, stp_cpu_mesh_uv(triangle, use, weight), footprint, texel);
}

/// Turns the normal of a pixel by the normal map.
static void map_normal(const stp_cpu_item* item, const stp_cpu_triangle* triangle,
                       const stp_tangents* tangents, const float weight[3], float pixel_size,
                       stp_vec3 eye, float normal[3])
{
    const stp_store_material* material = item->material;
    float texel[4];
    sample_texture(triangle, &material->normal_texture, item->normal_map, weight, pixel_size,
                   texel);
    stp_vec3 own = stp_normalize((stp_vec3){normal[0], normal[1], normal[2]});
    stp_vec3 turned = stp_normal_map_apply(tangents, own, texel, material->normal_scale, eye);
    memcpy(normal, (const float[3]){turned.x, turned.y, turned.z}, 3 * sizeof(float));
}

/// Applies textures to a pixel.
static void texture_pixel(const stp_cpu_item* item, const stp_cpu_triangle* triangle, float density,
                          const float weight[3], float pixel_size, stp_cpu_shade_surface* out)
{
    const stp_store_material* material = item->material;
    float texel[4];
    stp_cpu_mesh_color(item, triangle, weight, density * pixel_size, texel);
    memcpy(out->color, texel, sizeof(out->color));
    if (item->metallic_roughness != NULL) {
        sample_texture(triangle, &material->metallic_roughness_texture, item->metallic_roughness,
                       weight, pixel_size, texel);
        stp_cpu_shade_material made = stp_cpu_make_shade_material(
            material->metallic * texel[2], material->roughness * texel[1], out->material.emissive,
            out->material.unlit > 0.0f);
        out->material = made;
    }
    if (item->emissive != NULL) {
        sample_texture(triangle, &material->emissive_texture, item->emissive, weight, pixel_size,
                       texel);
        for (int k = 0; k < 3; ++k) {
            out->material.emissive[k] *= texel[k];
        }
    }
}

/// Size of a pixel at its depth, in item units.
static float pixel_size_at(const stp_cpu_renderer* r, const stp_cpu_item* item, float nearness)
{
    float depth = item->camera.parallel ? 1.0f : (float)r->nearness_scale / nearness;
    return depth / (item->camera.pixel_scale * item->scale);
}

/// Corner weights at a run's first pixel, and their change per pixel.
static four find_shares(const mixed_triangle* mixed, uint32_t x, uint32_t y, four* step)
{
    double px = (double)x + 0.5, py = (double)y + 0.5;
    four share = {0};
    *step = share;
    for (int k = 0; k < 3; ++k) {
        const double* line = mixed->line[k];
        share[k] = (float)(line[0] + line[1] * px + line[2] * py);
        (*step)[k] = (float)line[1];
    }
    return share;
}

void stp_cpu_make_pixel_surfaces(const stp_cpu_renderer* r, stp_cpu_shade_memory* memory,
                                 const stp_cpu_shade_run* run, uint32_t x, uint32_t y,
                                 const float* nearness, stp_cpu_shade_surface* out)
{
    assert(run->surface < SHADE_KEPT && memory->kind[run->surface] != SHADE_FLAT);
    const mixed_triangle* mixed = &memory->triangles->mixed[run->surface];
    const stp_cpu_shade_surface* surface = &memory->surfaces[run->surface];
    const stp_cpu_item* item = &r->items[memory->item[run->surface]];
    stp_cpu_shade_nearness near = memory->nearness[run->surface];
    const stp_cpu_triangle* textured = memory->kind[run->surface] == SHADE_TEXTURED
                                           ? read_triangle(item, memory, run->surface)
                                           : NULL;
    four step, start = find_shares(mixed, x, y, &step);
    for (uint32_t i = 0; i < run->length; ++i, ++out) {
        four share = start + step * (float)i;
        share = (four)((share > 0.0f) & (four_int)share);
        float sum = share[0] + share[1] + share[2];
        if (!(sum > 0.0f)) { // seen edge-on
            share = (four){sum = 1.0f};
        }
        four color = mixed->color[0], normal = mixed->flat;
        if (mixed->has_color) {
            color = mix(mixed->color, share) * (1.0f / sum);
        }
        if (mixed->is_smooth) {
            four between = mix(mixed->normal, share), square = between * between;
            normal = square[0] + square[1] + square[2] > 1e-6f * (sum * sum) ? between : normal;
        }
        out->material = surface->material;
        memcpy(out->color, &color, sizeof(color));
        memcpy(out->normal, &normal, sizeof(normal));
        out->normal[3] = 0.0f;
        if (textured != NULL) {
            const float weight[3] = {share[0] / sum, share[1] / sum, share[2] / sum};
            float size = pixel_size_at(r, item, near.factor * nearness[i] + near.shift);
            texture_pixel(item, textured, mixed->density, weight, size, out);
            if (mixed->has_tangents) {
                stp_vec3 eye =
                    stp_normalize(stp_cpu_toward_eye(r, (double)(x + i) + 0.5, (double)y + 0.5));
                map_normal(item, textured, &mixed->tangents, weight, size, eye, out->normal);
            }
        }
    }
}
