// SPDX-License-Identifier: MIT
//
// Pixels of triangles looked up. A triangle covers pixels of several rows, so those shaded lately are remembered with
// all that their pixels have in common.
#include "draw/cpu/shade.h"

enum { MEMORY_BITS = 8, MEMORY_SIZE = 1 << MEMORY_BITS };

/// Four numbers at once, in the compiler's own notation: the same bits everywhere.
typedef float four __attribute__((vector_size(16)));

/// What all pixels of a triangle have in common. The share of corner k at pixel (x, y), times a factor that is the
/// same for all corners, is the linear function line[k][0] + line[k][1] x + line[k][2] y, where that is above 0.
typedef struct seen_triangle {
    uint32_t id;      ///< UINT32_MAX: none
    bool is_smooth;   ///< has normals
    bool is_constant; ///< colour and normal are the same everywhere on it
    bool has_color;
    float density; ///< texels of the base colour along an item unit
    double line[3][3];
    four normal[3]; ///< of unit length
    four color[3];  ///< times the material's
    four flat;
} seen_triangle;

struct cpu_mesh_memory {
    cpu_reader reader;
    seen_triangle seen[MEMORY_SIZE];
};

cpu_mesh_memory* cpu_make_mesh_memory(stp_context* context)
{
    return STP_NEW_ZEROED(context, cpu_mesh_memory, 1);
}

void cpu_forget_triangles(cpu_mesh_memory* memory)
{
    memory->reader = (cpu_reader){0};
    for (int i = 0; i < MEMORY_SIZE; ++i) {
        memory->seen[i].id = UINT32_MAX;
    }
}

static stp_vec3 flat_normal(const float c[3][3])
{
    return stp_normalize(
        stp_cross((stp_vec3){c[1][0] - c[0][0], c[1][1] - c[0][1], c[1][2] - c[0][2]},
                  (stp_vec3){c[2][0] - c[0][0], c[2][1] - c[0][1], c[2][2] - c[0][2]}));
}

/// Lines of weights: with corners (X, Y, W) on the screen, the weight of corner 0 is the determinant of
/// (X1 - x W1, Y1 - y W1) and (X2 - x W2, Y2 - y W2), which is linear in x and y; and so on round.
static void make_lines(const cpu_renderer* r, const cpu_item* item, const cpu_triangle* triangle,
                       double line[3][3])
{
    static const int rows[3] = {0, 1, 3};
    double corner[3][3], most = 0.0, sign = 0.0;
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
        most = fmax(most, fabs(line[k][0]));
        most = fmax(most, fmax(fabs(line[k][1]) * r->width, fabs(line[k][2]) * r->height));
        sign += corner[k][2] * line[k][0]; // the determinant of all three: which way round it is
    }
    double factor = most > 0.0 && most <= DBL_MAX ? (sign < 0.0 ? -1.0 : 1.0) / most : 0.0;
    for (int k = 0; k < 9; ++k) {
        line[k / 3][k % 3] *= factor;
    }
}

static four widen(stp_vec3 v)
{
    return (four){v.x, v.y, v.z, 0.0f};
}

static void read_triangle(const cpu_renderer* r, cpu_mesh_memory* memory, const cpu_item* item,
                          uint32_t id, seen_triangle* seen)
{
    const cpu_triangle* triangle = cpu_read_triangle(&memory->reader, item, id - item->first_id);
    const float* base = item->material->base_color;
    seen->id = id;
    seen->is_smooth = triangle->has_normal;
    seen->has_color = triangle->has_color;
    seen->is_constant = !triangle->has_normal && !triangle->has_color && item->base_color == NULL &&
                        item->metallic_roughness == NULL && item->emissive == NULL;
    seen->density = 0.0f;
    if (item->base_color != NULL) {
        seen->density =
            cpu_mesh_density(triangle, &item->material->base_color_texture, item->base_color);
    }
    seen->flat = widen(flat_normal(triangle->position));
    if (!seen->is_constant) {
        make_lines(r, item, triangle, seen->line);
    }
    for (int k = 0; k < 3; ++k) {
        const float* color = triangle->color[k];
        seen->color[k] = (four){base[0], base[1], base[2], 1.0f};
        if (triangle->has_color) {
            seen->color[k] *= (four){color[0], color[1], color[2], 1.0f};
        }
        if (triangle->has_normal) {
            stp_vec3 normal = triangle->normal[k];
            seen->normal[k] = widen(stp_scale(normal, 1.0f / stp_length(normal)));
        }
    }
}

/// Shares of the corners, and their sum.
static float find_shares(const seen_triangle* seen, double x, double y, float share[3])
{
    for (int k = 0; k < 3; ++k) {
        const double* line = seen->line[k];
        double at = line[0] + line[1] * x + line[2] * y;
        share[k] = at > 0.0 ? (float)at : 0.0f;
    }
    float sum = share[0] + share[1] + share[2];
    if (!(sum > 0.0f)) { // seen from its edge
        share[0] = sum = 1.0f;
        share[1] = share[2] = 0.0f;
    }
    return sum;
}

static four mix(const four corners[3], const float share[3])
{
    return corners[0] * share[0] + corners[1] * share[1] + corners[2] * share[2];
}

static void sample_texture(const cpu_triangle* triangle, const stp_store_texture_use* use,
                           const stp_texture_pyramid* pyramid, const float weight[3],
                           float pixel_size, float texel[4])
{
    float footprint = cpu_mesh_density(triangle, use, pyramid) * pixel_size;
    stp_texture_sample(pyramid, cpu_mesh_uv(triangle, use, weight), footprint, texel);
}

/// A pixel whose material changes from point to point is lit by itself.
static void light_textured(const cpu_item* item, const cpu_triangle* triangle,
                           const float weight[3], float pixel_size, const cpu_shade_row* row,
                           uint32_t x, cpu_surface* surface, float out[3])
{
    const stp_store_material* material = item->material;
    float texel[4];
    surface->metallic = material->metallic;
    surface->roughness = material->roughness;
    surface->unlit = (material->flags & STP_SHADING_UNLIT) != 0;
    for (int k = 0; k < 3; ++k) {
        surface->emissive[k] = material->emissive[k];
    }
    if (item->metallic_roughness != NULL) {
        sample_texture(triangle, &material->metallic_roughness_texture, item->metallic_roughness,
                       weight, pixel_size, texel);
        surface->roughness *= texel[1];
        surface->metallic *= texel[2];
    }
    if (item->emissive != NULL) {
        sample_texture(triangle, &material->emissive_texture, item->emissive, weight, pixel_size,
                       texel);
        for (int k = 0; k < 3; ++k) {
            surface->emissive[k] *= texel[k];
        }
    }
    const float(*m)[3] = item->normal_matrix;
    stp_vec3 n = surface->normal;
    stp_vec3 turned = {m[0][0] * n.x + m[0][1] * n.y + m[0][2] * n.z,
                       m[1][0] * n.x + m[1][1] * n.y + m[1][2] * n.z,
                       m[2][0] * n.x + m[2][1] * n.y + m[2][2] * n.z};
    float square = stp_dot(turned, turned);
    surface->normal = square > 0.0f ? stp_scale(turned, 1.0f / sqrtf(square)) : (stp_vec3){0};
    stp_vec3 to_eye = row->start;
    if (!row->parallel) {
        to_eye = stp_add(row->start, stp_scale(row->step, (float)x + 0.5f));
        to_eye = stp_scale(to_eye, 1.0f / sqrtf(stp_dot(to_eye, to_eye)));
    }
    cpu_light_surface(&row->light, to_eye, surface, out);
}

/// Colours with textures, and all that depends on textures.
static bool look_up_textured(const cpu_renderer* r, cpu_worker* worker, const cpu_shade_row* row,
                             const cpu_shade_chunk* chunk, uint32_t lane, uint32_t x, float density,
                             const float weight[3], four normal, float color[4], float out[3])
{
    const cpu_item* item = &r->items[chunk->item[lane]];
    uint64_t pixel = chunk->pixels[lane];
    const cpu_triangle* triangle =
        cpu_read_triangle(&worker->triangles->reader, item, stp_raster_id(pixel) - item->first_id);
    float nearness = cpu_true_nearness(item, stp_raster_nearness(pixel));
    float depth = item->camera.parallel ? 1.0f : (float)r->nearness_scale / nearness;
    float pixel_size = depth / (item->camera.pixel_scale * item->scale);
    cpu_mesh_color(item, triangle, weight, density * pixel_size, color);
    if (item->metallic_roughness == NULL && item->emissive == NULL) {
        return true;
    }
    cpu_surface surface = {.color = {color[0], color[1], color[2]},
                           .normal = {normal[0], normal[1], normal[2]}};
    light_textured(item, triangle, weight, pixel_size, row, x, &surface, out);
    return false;
}

static inline void set_lane(cpu_shade_chunk* chunk, uint32_t lane, four color, four normal)
{
    for (int k = 0; k < 3; ++k) {
        chunk->linear[k][lane] = color[k];
        chunk->normal[k][lane] = normal[k];
    }
}

bool cpu_look_up_triangle(const cpu_renderer* r, cpu_worker* worker, const cpu_shade_row* row,
                          cpu_shade_chunk* chunk, uint32_t lane, uint32_t x, uint32_t y,
                          float out[3])
{
    uint32_t id = stp_raster_id(chunk->pixels[lane]);
    const cpu_item* item = &r->items[chunk->item[lane]];
    seen_triangle* seen = &worker->triangles->seen[id * 0x9E3779B1u >> (32 - MEMORY_BITS)];
    chunk->material[lane] = (int32_t)row->items[chunk->item[lane]].material;
    if (seen->id != id) {
        read_triangle(r, worker->triangles, item, id, seen);
    }
    if (seen->is_constant) {
        set_lane(chunk, lane, seen->color[0], seen->flat);
        return true;
    }
    float share[3];
    float sum = find_shares(seen, (double)x + 0.5, (double)y + 0.5, share);
    four color = seen->color[0], normal = seen->flat;
    if (seen->has_color) {
        color = mix(seen->color, share) * (1.0f / sum);
    }
    if (seen->is_smooth) {
        four mixed = mix(seen->normal, share), square = mixed * mixed;
        normal = square[0] + square[1] + square[2] > 1e-6f * (sum * sum) ? mixed : normal;
    }
    if (item->base_color == NULL && item->metallic_roughness == NULL && item->emissive == NULL) {
        set_lane(chunk, lane, color, normal);
        return true;
    }
    float textured[4];
    const float weight[3] = {share[0] / sum, share[1] / sum, share[2] / sum};
    bool done = look_up_textured(r, worker, row, chunk, lane, x, seen->density, weight, normal,
                                 textured, out);
    set_lane(chunk, lane, (four){textured[0], textured[1], textured[2], 0.0f}, normal);
    return done;
}
