// SPDX-License-Identifier: MIT
// Second half of a capture: from covered pixels to candidates.
#include "base/math/color.h"
#include "capture/capture_internal.h"
#include "raster/normal_map.h"
#include "scene/looks.h"

#include <assert.h>
#include <string.h>

enum { RESOLVE_GRAIN = 4096 };

typedef struct resolve_state {
    const stp_capture_job* job;
    stp_candidates* out;
    size_t first; ///< candidate of the first pixel
} resolve_state;

/// The part being resolved; looked up only when it changes.
typedef struct current_part {
    size_t part;
    stp_affine placement;
    double normal_matrix[3][3];
    const stp_mesh* mesh; ///< NULL: a point set
    const stp_point_set* points;
    uint32_t material;
    bool mirrored;    ///< the placement is
    bool mapped;      ///< has a normal map
    bool plain;       ///< one colour everywhere: `color`
    uint8_t color[4]; ///< sRGB
} current_part;

static uint8_t alpha_byte(const stp_material* material, float alpha)
{
    if (material->alpha_mode != STP_ALPHA_BLEND) {
        return 255;
    }
    alpha = alpha < 1.0f ? alpha : 1.0f;
    float scaled = alpha * 255.0f + 0.5f;
    return scaled > 1.0f ? (uint8_t)scaled : 1;
}

static void encode_color(const stp_material* material, const float color[4], uint8_t out[4])
{
    for (int c = 0; c < 3; ++c) {
        out[c] = stp_linear_to_srgb8(color[c]);
    }
    out[3] = alpha_byte(material, color[3]);
}

static void find_part(const stp_capture_job* job, uint64_t primitive, current_part* current)
{
    const uint64_t* first = job->first_primitives;
    if (current->part < job->part_count && primitive >= first[current->part] &&
        primitive < first[current->part + 1]) {
        return;
    }
    assert(primitive < first[job->part_count]);
    size_t low = 0, high = job->part_count; // first[low] <= primitive < first[high]
    while (high - low > 1) {
        size_t middle = low + (high - low) / 2;
        if (primitive >= first[middle]) {
            low = middle;
        } else {
            high = middle;
        }
    }
    assert(first[low] <= primitive && primitive < first[low + 1]);
    stp_part which = job->parts[low].part;
    current->part = low;
    current->placement = stp_capture_placement(job, low);
    stp_affine_normal_matrix(&current->placement, current->normal_matrix);
    current->mirrored = stp_affine_determinant(&current->placement) < 0.0;
    bool is_mesh = which.kind == STP_PART_MESH;
    current->mesh = is_mesh ? &job->scene->meshes[which.index] : NULL;
    current->points = is_mesh ? NULL : &job->scene->point_sets[which.index];
    current->material = is_mesh ? current->mesh->material : current->points->material;
    const stp_material* material = &job->scene->materials[current->material];
    const stp_texture_use* use = &material->base_color_texture;
    bool textured =
        use->texture < job->scene->texture_count && job->pyramids[use->texture].level_count != 0;
    use = &material->normal_texture;
    current->mapped = is_mesh && use->texture < job->scene->texture_count &&
                      job->surfaces[use->texture].level_count != 0;
    current->plain = is_mesh && current->mesh->colors == NULL && !textured;
    encode_color(material, material->base_color, current->color);
}

static stp_vec3d position_of(const float* positions, uint32_t vertex)
{
    const float* p = positions + 3 * (size_t)vertex;
    return (stp_vec3d){(double)p[0], (double)p[1], (double)p[2]};
}

/// A triangle projected into a view.
typedef struct seen_triangle {
    uint32_t corner[3];
    stp_vec3d position[3];
    double x[3], y[3]; ///< pixels, from the centre of the current pixel
    double area;       ///< twice the signed area, in square pixels
    double weight[3];  ///< weights of the corners at the pixel's centre
} seen_triangle;

static seen_triangle project_triangle(const stp_capture_view* view, const current_part* part,
                                      uint32_t triangle, double pixel_x, double pixel_y)
{
    assert(triangle < part->mesh->triangle_count);
    seen_triangle t;
    for (int k = 0; k < 3; ++k) {
        t.corner[k] = part->mesh->indices[3 * (size_t)triangle + (size_t)k];
        t.position[k] =
            stp_affine_point(&part->placement, position_of(part->mesh->positions, t.corner[k]));
        t.x[k] = stp_dotd(view->right, t.position[k]) + view->shift_x - pixel_x;
        t.y[k] = stp_dotd(view->down, t.position[k]) + view->shift_y - pixel_y;
    }
    t.area = (t.x[1] - t.x[0]) * (t.y[2] - t.y[0]) - (t.y[1] - t.y[0]) * (t.x[2] - t.x[0]);
    double sign = t.area < 0.0 ? -1.0 : 1.0, sum = 0.0;
    for (int k = 0; k < 3; ++k) { // snapping may leave the centre slightly outside: clamp
        int a = (k + 1) % 3, b = (k + 2) % 3;
        double opposite = sign * (t.x[a] * t.y[b] - t.y[a] * t.x[b]);
        t.weight[k] = opposite > 0.0 ? opposite : 0.0;
        sum += t.weight[k];
    }
    for (int k = 0; k < 3; ++k) {
        t.weight[k] = sum > 0.0 ? t.weight[k] / sum : 1.0 / 3.0;
    }
    return t;
}

static stp_vec3d turn_normal(const double m[3][3], const float* n)
{
    double x = (double)n[0], y = (double)n[1], z = (double)n[2];
    return (stp_vec3d){m[0][0] * x + m[0][1] * y + m[0][2] * z,
                       m[1][0] * x + m[1][1] * y + m[1][2] * z,
                       m[2][0] * x + m[2][1] * y + m[2][2] * z};
}

typedef struct seen_normal {
    stp_vec3d normal; ///< unit, on the side of the triangle that faces the viewer
    bool behind;      ///< the mesh's own normal points to the other side
} seen_normal;

/// Interpolated normal, on the side of the triangle that faces the viewer. The triangle decides the
/// side: near a silhouette, the vertex normals of a coarse mesh may face away although its front is
/// visible.
static seen_normal triangle_normal(const stp_capture_view* view, const current_part* part,
                                   const seen_triangle* t)
{
    stp_vec3d flat = stp_normalized(stp_crossd(stp_subd(t->position[1], t->position[0]),
                                               stp_subd(t->position[2], t->position[0])));
    bool turned = stp_dotd(flat, view->toward) < 0.0;
    flat = turned ? stp_scaled(flat, -1.0) : flat;
    bool is_line = !(stp_dotd(flat, flat) > 0.0);
    stp_vec3d side = is_line ? view->toward : flat;
    if (part->mesh->normals != NULL) {
        float n[3] = {0.0f, 0.0f, 0.0f};
        for (int k = 0; k < 3; ++k) {
            const float* corner = part->mesh->normals + 3 * (size_t)t->corner[k];
            for (int c = 0; c < 3; ++c) {
                n[c] += (float)t->weight[k] * corner[c];
            }
        }
        stp_vec3d normal = stp_normalized(turn_normal(part->normal_matrix, n));
        bool behind = stp_dotd(normal, side) < 0.0;
        normal = behind ? stp_scaled(normal, -1.0) : normal;
        if (stp_dotd(normal, normal) > 0.5) { // neither zero nor NaN
            return (seen_normal){normal, behind};
        }
    }
    return (seen_normal){side, turned != part->mirrored};
}

/// Longer side of a pixel's footprint in the texture, in texels.
static float texture_footprint(const seen_triangle* t, const stp_texture_pyramid* pyramid,
                               double uv[3][2])
{
    double size[2] = {(double)pyramid->width[0], (double)pyramid->height[0]};
    double x1 = t->x[1] - t->x[0], x2 = t->x[2] - t->x[0];
    double y1 = t->y[1] - t->y[0], y2 = t->y[2] - t->y[0];
    double along_x = 0.0, along_y = 0.0; // squared lengths
    for (int c = 0; c < 2; ++c) {
        double d1 = (uv[1][c] - uv[0][c]) * size[c], d2 = (uv[2][c] - uv[0][c]) * size[c];
        double dx = (d1 * y2 - d2 * y1) / t->area, dy = (d2 * x1 - d1 * x2) / t->area;
        along_x += dx * dx;
        along_y += dy * dy;
    }
    double longer = sqrt(along_x > along_y ? along_x : along_y);
    return longer < 65536.0 ? (float)longer : 65536.0f;
}

/// Reads a texture at the pixel. @return false if the mesh lacks its coordinates
static bool sample(const stp_mesh* mesh, const stp_texture_use* use,
                   const stp_texture_pyramid* pyramid, const seen_triangle* t, stp_vec2* at,
                   float texel[4])
{
    double uv[3][2], u = 0.0, v = 0.0;
    for (int k = 0; k < 3; ++k) {
        if (!stp_capture_texcoord(mesh, use, t->corner[k], uv[k])) {
            return false;
        }
        u += t->weight[k] * uv[k][0];
        v += t->weight[k] * uv[k][1];
    }
    *at = (stp_vec2){(float)u, (float)v};
    stp_texture_sample(pyramid, *at, texture_footprint(t, pyramid, uv), texel);
    return true;
}

/// The normal as the map of the material turns it, by less than a right angle.
static stp_vec3d map_normal(const stp_capture_job* job, const current_part* part,
                            const seen_triangle* t, const seen_normal* seen)
{
    const stp_material* material = &job->scene->materials[part->material];
    const stp_texture_use* use = &material->normal_texture;
    float texel[4], along[2][2];
    stp_vec3 edges[2];
    stp_vec2 at;
    double uv[3][2];
    if (!sample(part->mesh, use, &job->surfaces[use->texture], t, &at, texel)) {
        return seen->normal;
    }
    for (int k = 0; k < 3; ++k) {
        (void)stp_capture_texcoord(part->mesh, use, t->corner[k], uv[k]); // it was sampled
    }
    for (int k = 0; k < 2; ++k) {
        edges[k] = stp_to_float(stp_subd(t->position[k + 1], t->position[0]));
        along[k][0] = (float)(uv[k + 1][0] - uv[0][0]);
        along[k][1] = (float)(uv[k + 1][1] - uv[0][1]);
    }
    stp_tangents tangents;
    if (!stp_tangents_find(edges, (const float(*)[2])along, &tangents)) {
        return seen->normal;
    }
    double sign = seen->behind ? -1.0 : 1.0;
    stp_vec3 own = stp_to_float(stp_scaled(seen->normal, sign));
    stp_vec3 turned = stp_normal_map_apply(&tangents, own, texel, material->normal_scale, own);
    return stp_scaled(stp_to_double(turned), sign);
}

/// The material, or its variant that has the roughness, metal and emission there.
static uint32_t triangle_material(const stp_capture_job* job, const current_part* part,
                                  const seen_triangle* t)
{
    const stp_material* material = &job->scene->materials[part->material];
    if (material->look == 0) {
        return part->material;
    }
    const stp_look* look = &job->scene->looks[material->look - 1];
    const stp_look_bins *surfaces = stp_look_surface(job->scene, look),
                        *glows = stp_look_glow(job->scene, look);
    const stp_texture_use *surface = &material->metallic_roughness_texture,
                          *glow = &material->emissive_texture;
    uint32_t bins[2] = {0, 0};
    float texel[4];
    stp_vec2 at;
    if (surfaces->count > 1) {
        if (!sample(part->mesh, surface, &job->surfaces[surface->texture], t, &at, texel)) {
            return part->material;
        }
        bins[0] = stp_look_surface_bin(surfaces, texel[2], texel[1]);
    }
    if (glows->count > 1) {
        if (!sample(part->mesh, glow, &job->pyramids[glow->texture], t, &at, texel)) {
            return part->material;
        }
        bins[1] = stp_look_glow_bin(glows, texel);
    }
    return stp_look_index(job->scene, look, bins[0], bins[1]);
}

static void triangle_color(const stp_capture_job* job, const current_part* part,
                           const seen_triangle* t, float color[4])
{
    const stp_mesh* mesh = part->mesh;
    const stp_material* material = &job->scene->materials[part->material];
    const stp_texture_use* use = &material->base_color_texture;
    for (int c = 0; c < 4; ++c) {
        color[c] = material->base_color[c];
    }
    if (mesh->colors != NULL) {
        for (int c = 0; c < 4; ++c) {
            float sum = 0.0f;
            for (int k = 0; k < 3; ++k) {
                sum +=
                    (float)t->weight[k] * (float)mesh->colors[4 * (size_t)t->corner[k] + (size_t)c];
            }
            color[c] *= sum / 65535.0f;
        }
    }
    bool textured = use->texture < job->scene->texture_count;
    if (!textured || job->pyramids[use->texture].level_count == 0) {
        return;
    }
    const stp_texture_pyramid* pyramid = &job->pyramids[use->texture];
    float texel[4];
    stp_vec2 at;
    if (!sample(mesh, use, pyramid, t, &at, texel)) {
        return;
    }
    if (material->alpha_mode == STP_ALPHA_BLEND) { // as the mask read it
        texel[3] = stp_texture_sample_alpha(pyramid, at);
    }
    for (int c = 0; c < 4; ++c) {
        color[c] *= texel[c];
    }
}

static void put(float* column, size_t i, stp_vec3d value)
{
    column[3 * i] = (float)value.x;
    column[3 * i + 1] = (float)value.y;
    column[3 * i + 2] = (float)value.z;
}

static void store(stp_candidates* out, size_t i, stp_vec3d position, stp_vec3d normal)
{
    put(out->positions, i, position);
    put(out->normals, i, normal);
    if (out->light_normals != NULL) {
        put(out->light_normals, i, normal);
    }
}

static void resolve_point(const stp_capture_job* job, const stp_capture_view* view,
                          const current_part* part, uint32_t point, stp_candidates* out, size_t i)
{
    assert(point < part->points->point_count);
    const stp_point_set* points = part->points;
    const stp_material* material = &job->scene->materials[part->material];
    stp_vec3d normal = {0};
    if (points->normals != NULL) {
        normal =
            stp_normalized(turn_normal(part->normal_matrix, points->normals + 3 * (size_t)point));
        normal = stp_dotd(normal, view->toward) < 0.0 ? stp_scaled(normal, -1.0) : normal;
    }
    if (!(stp_dotd(normal, normal) > 0.5)) {
        normal = view->toward;
    }
    store(out, i, stp_affine_point(&part->placement, position_of(points->positions, point)),
          normal);
    const uint8_t* color = points->colors != NULL ? points->colors + 4 * (size_t)point : NULL;
    for (int c = 0; c < 3; ++c) {
        float value = color != NULL ? stp_srgb8_to_linear(color[c]) : 1.0f;
        out->colors[4 * i + (size_t)c] = stp_linear_to_srgb8(value * material->base_color[c]);
    }
    float alpha = color != NULL ? (float)color[3] / 255.0f : 1.0f;
    out->colors[4 * i + 3] = alpha_byte(material, alpha * material->base_color[3]);
}

static void resolve_triangle(const stp_capture_job* job, const stp_capture_view* view,
                             const current_part* part, uint32_t triangle, uint32_t pixel,
                             stp_candidates* out, size_t i)
{
    uint32_t column = pixel % view->width, row = pixel / view->width;
    assert(row < view->height);
    double x = (double)column + 0.5, y = (double)row + 0.5;
    seen_triangle t = project_triangle(view, part, triangle, x, y);
    stp_vec3d position = {0};
    for (int k = 0; k < 3; ++k) {
        position = stp_addd(position, stp_scaled(t.position[k], t.weight[k]));
    }
    seen_normal seen = triangle_normal(view, part, &t);
    store(out, i, position, seen.normal);
    if (part->mapped) {
        assert(out->light_normals != NULL && "a material has a normal map");
        put(out->light_normals, i, map_normal(job, part, &t, &seen));
    }
    out->materials[i] = triangle_material(job, part, &t);
    uint8_t* bytes = out->colors + 4 * i;
    if (part->plain) {
        memcpy(bytes, part->color, sizeof(part->color));
        return;
    }
    float color[4];
    triangle_color(job, part, &t, color);
    encode_color(&job->scene->materials[part->material], color, bytes);
}

/// Prefetches the triangle of a pixel a few places on: screen neighbours may be far apart in
/// memory.
static void prefetch_triangle(const stp_capture_job* job, const stp_capture_band* band, size_t i,
                              size_t end, const current_part* part)
{
    enum { INDICES_AHEAD = 16, CORNERS_AHEAD = 8 };
    uint64_t first = job->first_primitives[part->part], count = part->mesh->triangle_count;
    uint64_t far = i + INDICES_AHEAD < end ? band->primitives[i + INDICES_AHEAD] - first : count;
    uint64_t near = i + CORNERS_AHEAD < end ? band->primitives[i + CORNERS_AHEAD] - first : count;
    if (far < count) {
        __builtin_prefetch(part->mesh->indices + 3 * far);
    }
    for (uint64_t k = 0; near < count && k < 3; ++k) {
        __builtin_prefetch(part->mesh->positions + 3 * (size_t)part->mesh->indices[3 * near + k]);
    }
}

/// Resolves entries [begin, end) of one band to candidates from `first` on.
static void resolve_entries(const resolve_state* state, const stp_capture_band* band, size_t begin,
                            size_t end, size_t first, current_part* part)
{
    const stp_capture_job* job = state->job;
    const stp_capture_view* view = &job->views[band->view];
    for (size_t i = begin; i < end; ++i) {
        uint64_t primitive = band->primitives[i];
        size_t candidate = first + (i - begin);
        assert(candidate < job->room);
        find_part(job, primitive, part);
        uint32_t within = (uint32_t)(primitive - job->first_primitives[part->part]);
        if (part->mesh != NULL) {
            prefetch_triangle(job, band, i, end, part);
            resolve_triangle(job, view, part, within, band->pixels[i], state->out, candidate);
        } else {
            resolve_point(job, view, part, within, state->out, candidate);
            state->out->materials[candidate] = part->material;
        }
    }
}

static void resolve_range(size_t begin, size_t end, uint32_t worker, void* user)
{
    (void)worker;
    const resolve_state* state = user;
    const stp_capture_job* job = state->job;
    current_part part = {.part = SIZE_MAX};
    size_t first = 0; // candidate of the band's first entry
    for (size_t b = 0; b < job->band_count && first < end; ++b) {
        const stp_capture_band* band = &job->bands[b];
        size_t from = begin > first ? begin - first : 0;
        size_t to = end - first < band->count ? end - first : band->count;
        if (from < to) {
            resolve_entries(state, band, from, to, state->first + first + from, &part);
        }
        first += band->count;
    }
}

void stp_capture_resolve(const stp_capture_job* job, stp_candidates* candidates, size_t first)
{
    assert(first + job->covered_pixels <= job->room);
    resolve_state state = {job, candidates, first};
    stp_parallel_for(job->scene->context, (size_t)job->covered_pixels, RESOLVE_GRAIN, resolve_range,
                     &state);
}
