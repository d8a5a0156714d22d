// SPDX-License-Identifier: MIT
// From the visibility buffer to colours: each pixel is looked up and lit once.
#include "base/octahedral.h"
#include "draw/cpu/cpu.h"

/// What one band of the picture needs to know.
typedef struct shader {
    cpu_renderer* r;
    cpu_light light;
    const cpu_item* item; ///< that the last pixel belonged to
    cpu_reader* reader;
    stp_vec3 row_start, column_step;
} shader;

/// Of unit length, or zero; the matrix is near unit scale, so floats do.
static stp_vec3 turn_normal(const cpu_item* item, stp_vec3 n)
{
    const float(*m)[3] = item->normal_matrix;
    stp_vec3 turned = {m[0][0] * n.x + m[0][1] * n.y + m[0][2] * n.z,
                       m[1][0] * n.x + m[1][1] * n.y + m[1][2] * n.z,
                       m[2][0] * n.x + m[2][1] * n.y + m[2][2] * n.z};
    float square = stp_dot(turned, turned);
    return square > 0.0f ? stp_scale(turned, 1.0f / sqrtf(square)) : (stp_vec3){0};
}

static void set_material(const stp_store_material* material, cpu_surface* surface)
{
    surface->metallic = material->metallic;
    surface->roughness = material->roughness;
    surface->unlit = (material->flags & STP_SHADING_UNLIT) != 0;
    for (int k = 0; k < 3; ++k) {
        surface->emissive[k] = material->emissive[k];
    }
}

static void surfel_surface(const shader* s, const cpu_item* item, uint32_t index,
                           cpu_surface* surface)
{
    const cpu_renderer* r = s->r;
    const uint8_t* color = item->colors + 3 * (size_t)index;
    for (int k = 0; k < 3; ++k) {
        surface->color[k] = r->decode[color[k]];
    }
    if (index < item->low_count && item->blend < 1.0f) {
        const uint8_t* low = item->low_colors + 3 * (size_t)index;
        for (int k = 0; k < 3; ++k) {
            float before = r->decode[low[k]];
            surface->color[k] = before + (surface->color[k] - before) * item->blend;
        }
    }
    const int8_t* code = item->surfels.normals + 2 * (size_t)index;
    surface->normal = turn_normal(item, stp_octahedral_decode(code[0], code[1]));
    uint8_t number = item->surfels.materials[index];
    if (number < r->directory->shading_count) {
        const stp_shading* shading = &r->directory->shadings[number];
        surface->metallic = shading->metallic;
        surface->roughness = shading->roughness;
        surface->unlit = (shading->flags & STP_SHADING_UNLIT) != 0;
        for (int k = 0; k < 3; ++k) {
            surface->emissive[k] = shading->emissive[k];
        }
    }
}

static void point_surface(const shader* s, const cpu_item* item, uint32_t index,
                          cpu_surface* surface)
{
    set_material(item->material, surface);
    for (int k = 0; k < 3; ++k) {
        surface->color[k] = item->material->base_color[k];
        if (item->points.colors != NULL) {
            surface->color[k] *= s->r->decode[item->points.colors[4 * (size_t)index + (size_t)k]];
        }
    }
    if (item->points.normals != NULL) {
        surface->normal =
            turn_normal(item, cpu_decode_normal(item->points.normals + 2 * (size_t)index));
    } else {
        surface->unlit = true;
    }
}

static stp_vec3 flat_normal(const float c[3][3])
{
    return stp_normalize(
        stp_cross((stp_vec3){c[1][0] - c[0][0], c[1][1] - c[0][1], c[1][2] - c[0][2]},
                  (stp_vec3){c[2][0] - c[0][0], c[2][1] - c[0][1], c[2][2] - c[0][2]}));
}

/// The normal between the corners' normals, on the side of the triangle that is seen.
static stp_vec3 smooth_normal(const cpu_triangle* triangle, const float weight[3], stp_vec3 flat)
{
    stp_vec3 sum = {0};
    for (int k = 0; k < 3 && triangle->has_normal; ++k) {
        stp_vec3 n = triangle->normal[k];
        sum = stp_add(sum, stp_scale(n, weight[k] / stp_length(n)));
    }
    return stp_dot(sum, sum) > 1e-6f ? sum : flat;
}

static void sample_texture(const cpu_triangle* triangle, const stp_store_texture_use* use,
                           const stp_texture_pyramid* pyramid, const float weight[3],
                           float pixel_size, float texel[4])
{
    float footprint = cpu_mesh_density(triangle, use, pyramid) * pixel_size;
    stp_texture_sample(pyramid, cpu_mesh_uv(triangle, use, weight), footprint, texel);
}

static void sample_materials(const cpu_item* item, const cpu_triangle* triangle,
                             const float weight[3], float pixel_size, cpu_surface* surface)
{
    const stp_store_material* material = item->material;
    float texel[4];
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
}

static void mesh_surface(const shader* s, const cpu_item* item, uint32_t index, uint32_t x,
                         uint32_t y, float nearness, cpu_surface* surface)
{
    const cpu_renderer* r = s->r;
    const cpu_triangle* triangle = cpu_read_triangle(s->reader, item, index);
    const float(*corners)[3] = triangle->position;
    float weight[3];
    stp_raster_weights(&item->camera.matrix, corners[0], corners[1], corners[2], (float)x + 0.5f,
                       (float)y + 0.5f, &weight[1], &weight[2]);
    weight[0] = 1.0f - weight[1] - weight[2];
    float depth = item->camera.parallel ? 1.0f : (float)r->nearness_scale / nearness;
    float pixel = depth / (item->camera.pixel_scale * item->scale);
    float color[4];
    cpu_mesh_color(item, triangle, weight, pixel, color);
    for (int k = 0; k < 3; ++k) {
        surface->color[k] = color[k];
    }
    set_material(item->material, surface);
    sample_materials(item, triangle, weight, pixel, surface);
    surface->normal = turn_normal(item, smooth_normal(triangle, weight, flat_normal(corners)));
}

static const cpu_item* find_item(const shader* s, uint32_t id)
{
    const cpu_renderer* r = s->r;
    if (s->item != NULL && id >= s->item->first_id && id - s->item->first_id < s->item->count) {
        return s->item;
    }
    size_t low = 0, high = r->item_count;
    while (high - low > 1) {
        size_t middle = low + (high - low) / 2;
        if (r->items[middle].first_id <= id) {
            low = middle;
        } else {
            high = middle;
        }
    }
    return &r->items[low];
}

/// From a pixel towards the eye: (forward + right u + down v) turned round.
static stp_vec3 direction_to_eye(const shader* s, uint32_t x)
{
    if (s->r->frame.parallel) {
        return s->row_start;
    }
    stp_vec3 d = stp_add(s->row_start, stp_scale(s->column_step, (float)x + 0.5f));
    return stp_scale(d, 1.0f / sqrtf(stp_dot(d, d)));
}

/// What direction_to_eye needs for a row.
static void begin_row(shader* s, uint32_t y)
{
    const cpu_renderer* r = s->r;
    const stp_view_frame* f = &r->frame;
    stp_vec3d start = stp_scaled(f->forward, -1.0);
    if (!f->parallel) {
        double u = (-f->center_x - r->shift_x) / f->scale;
        double v = ((double)y + 0.5 - f->center_y - r->shift_y) / f->scale;
        start = stp_subd(start, stp_addd(stp_scaled(f->right, u), stp_scaled(f->down, v)));
    }
    s->row_start = stp_to_float(start);
    s->column_step = stp_to_float(stp_scaled(f->right, -1.0 / f->scale));
}

static void shade_pixel(shader* s, uint64_t pixel, uint32_t x, uint32_t y, float out[3])
{
    uint32_t id = stp_raster_id(pixel);
    const cpu_item* item = find_item(s, id);
    s->item = item;
    cpu_surface surface = {.roughness = 1.0f};
    uint32_t index = id - item->first_id;
    switch (item->kind) {
    case STP_DRAW_SURFELS:
        surfel_surface(s, item, index, &surface);
        break;
    case STP_DRAW_MESH:
        mesh_surface(s, item, index, x, y, cpu_true_nearness(item, stp_raster_nearness(pixel)),
                     &surface);
        break;
    case STP_DRAW_POINTS:
        point_surface(s, item, index, &surface);
        break;
    }
    cpu_light_surface(&s->light, direction_to_eye(s, x), &surface, out);
}

static uint8_t encode(const cpu_renderer* r, float linear)
{
    float scaled = linear * (float)CPU_ENCODE_SIZE;
    float top = (float)(CPU_ENCODE_SIZE - 1);
    return r->encode[scaled >= top ? CPU_ENCODE_SIZE - 1 : scaled > 0.0f ? (int)scaled : 0];
}

static void write_pixel(const cpu_renderer* r, const float color[3], float coverage, uint8_t* out)
{
    const stp_draw_style* style = r->style;
    float back = style->background ? 1.0f - coverage : 0.0f;
    for (int k = 0; k < 3; ++k) {
        float linear = style->background
                           ? color[k] * coverage + back * r->decode[style->background_color[k]]
                           : color[k];
        out[k] = encode(r, linear);
    }
    out[3] = style->background ? 255 : (uint8_t)(coverage * 255.0f + 0.5f);
    if (!style->background && coverage <= 0.0f) {
        out[0] = out[1] = out[2] = 0;
    }
}

/// The nearest of all workers' pixels, each left empty.
static void merge_row(cpu_renderer* r, uint32_t y, uint64_t* row)
{
    size_t first = (size_t)y * r->width;
    for (uint32_t x = 0; x < r->width; ++x) {
        row[x] = STP_RASTER_EMPTY;
    }
    for (uint32_t w = 0; w < r->team.threads; ++w) {
        uint64_t* pixels = r->workers[w].pixels + first;
        if (!r->workers[w].drew) {
            continue;
        }
        for (uint32_t x = 0; x < r->width; ++x) {
            row[x] = pixels[x] < row[x] ? pixels[x] : row[x];
            pixels[x] = STP_RASTER_EMPTY;
        }
    }
}

static cpu_light make_light(const cpu_renderer* r)
{
    const stp_view_frame* f = &r->frame;
    stp_vec3d up = stp_scaled(f->down, -1.0), back = stp_scaled(f->forward, -1.0);
    stp_vec3d toward = back;
    if (!r->style->headlight) { // above the viewer's left shoulder
        toward = stp_addd(stp_scaled(f->right, -0.45), stp_scaled(up, 0.65));
        toward = stp_normalized(stp_addd(toward, stp_scaled(back, 0.62)));
    }
    return (cpu_light){.toward = stp_to_float(toward), .up = stp_to_float(up)};
}

static void add_to_sum(cpu_renderer* r, size_t at, const float color[3], float coverage)
{
    float* sum = r->sums + 4 * at;
    for (int k = 0; k < 3; ++k) {
        float linear = color[k] < 1.0f ? color[k] : 1.0f; // so that glints do not outshine edges
        sum[k] = r->sample == 0 ? linear : sum[k] + linear;
    }
    sum[3] = r->sample == 0 ? coverage : sum[3] + coverage;
}

void cpu_shade_rows(cpu_renderer* r, uint32_t begin, uint32_t end, uint64_t* row, uint64_t* covered)
{
    cpu_reader reader = {0};
    shader s = {.r = r, .light = make_light(r), .reader = &reader};
    const float nothing[3] = {0};
    uint8_t empty[4];
    write_pixel(r, nothing, 0.0f, empty);
    for (uint32_t y = begin; y < end; ++y) {
        merge_row(r, y, row);
        begin_row(&s, y);
        for (uint32_t x = 0; x < r->width; ++x) {
            size_t at = (size_t)y * r->width + x;
            float color[3];
            if (row[x] == STP_RASTER_EMPTY) {
                r->depth[at] = 0.0f;
                if (r->sample_count > 1) {
                    add_to_sum(r, at, nothing, 0.0f);
                } else {
                    memcpy(r->image->pixels + 4 * at, empty, sizeof(empty));
                }
                continue;
            }
            shade_pixel(&s, row[x], x, y, color);
            r->depth[at] = cpu_true_nearness(s.item, stp_raster_nearness(row[x]));
            if (r->sample_count > 1) {
                add_to_sum(r, at, color, 1.0f);
            } else {
                *covered += 1;
                write_pixel(r, color, 1.0f, r->image->pixels + 4 * at);
            }
        }
    }
}

void cpu_average_rows(cpu_renderer* r, uint32_t begin, uint32_t end, uint64_t* covered)
{
    for (size_t at = (size_t)begin * r->width; at < (size_t)end * r->width; ++at) {
        const float* sum = r->sums + 4 * at;
        float share = sum[3] > 0.0f ? 1.0f / sum[3] : 0.0f;
        float color[3] = {sum[0] * share, sum[1] * share, sum[2] * share};
        *covered += sum[3] > 0.0f;
        write_pixel(r, color, sum[3] / (float)r->sample_count, r->image->pixels + 4 * at);
    }
}
