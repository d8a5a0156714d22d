// SPDX-License-Identifier: MIT
#include "support_mesh.h"

#include "base/math/rng.h"
#include "base/splats/octahedral.h"

#include <math.h>
#include <stdlib.h>

static float random_number(uint64_t* seed)
{
    *seed += 1;
    return (float)(stp_rng_hash(5, *seed) >> 40) * (1.0f / 16777216.0f);
}

static bool allocate(made_mesh* m, uint32_t vertices, uint32_t triangles, unsigned attributes)
{
    *m = (made_mesh){.vertex_count = vertices, .triangle_count = triangles};
    m->positions = calloc(vertices, 3 * sizeof(float));
    m->indices = calloc(triangles, 3 * sizeof(uint32_t));
    bool made = m->positions != NULL && m->indices != NULL;
    if ((attributes & MADE_NORMALS) != 0) {
        m->normals = calloc(vertices, 2 * sizeof(int16_t));
        made = made && m->normals != NULL;
    }
    if ((attributes & MADE_COLORS) != 0) {
        m->colors = calloc(vertices, 4 * sizeof(uint16_t));
        made = made && m->colors != NULL;
    }
    for (int set = 0; set < 2 && (attributes & MADE_TEXCOORDS) != 0; ++set) {
        m->texcoords[set] = calloc(vertices, 2 * sizeof(float));
        made = made && m->texcoords[set] != NULL;
    }
    return made;
}

static void set_vertex(made_mesh* m, uint32_t v, stp_vec3 p, stp_vec3 n)
{
    memcpy(m->positions + 3 * (size_t)v, &p, sizeof(p));
    if (m->normals != NULL) {
        stp_octahedral_encode16(n, m->normals + 2 * (size_t)v);
    }
    for (int set = 0; set < 2 && m->texcoords[set] != NULL; ++set) {
        float scale = set == 0 ? 1.0f : -37.0f; // the second set repeats many times
        m->texcoords[set][2 * (size_t)v] = scale * (0.3f + 0.2f * p.x);
        m->texcoords[set][2 * (size_t)v + 1] = scale * (0.1f + 0.2f * p.z);
    }
    for (size_t c = 0; c < 4 && m->colors != NULL; ++c) {
        m->colors[4 * (size_t)v + c] = c == 3 ? 65535 : (uint16_t)((v * (c + 3) * 977u) % 65536u);
    }
}

static float height(float x, float z)
{
    return 0.2f * x * (1.0f - x) + 0.15f * z * z * x;
}

static void sheet_vertex(made_mesh* m, uint32_t v, uint32_t column, uint32_t row, uint32_t side,
                         made_shape shape)
{
    float x = (float)column / (float)side, z = (float)row / (float)side;
    stp_vec3 n = stp_normalize((stp_vec3){-(0.2f - 0.4f * x + 0.15f * z * z), 1.0f, -0.3f * z * x});
    stp_vec3 p = {x, height(x, z), z};
    if (shape == MADE_SLIVERS) {
        p.x *= 1000.0f;
        p.z = row % 5 == 4 ? (float)(row - 1) / (float)side : p.z; // some rows coincide
    } else if (shape == MADE_UNEVEN) {
        p = stp_scale(p, 1e-3f);
    } else if (shape == MADE_FAR) {
        p = stp_add(p, (stp_vec3){4000.0f, -300.0f, 70000.0f});
    }
    set_vertex(m, v, p, n);
}

static bool make_sheet(made_shape shape, uint32_t side, unsigned attributes, made_mesh* m)
{
    uint32_t row_size = side + 1, sheet = 2 * side * side, extra = shape == MADE_UNEVEN ? 1 : 0;
    bool soup = shape == MADE_SOUP;
    uint32_t vertices = soup ? 3 * sheet : row_size * row_size + 3 * extra;
    if (!allocate(m, vertices, sheet + extra, attributes)) {
        return false;
    }
    for (uint32_t t = 0; t < sheet; ++t) {
        uint32_t column = t / 2 % side, row = t / 2 / side;
        static const uint32_t corners[2][3][2] = {{{0, 0}, {0, 1}, {1, 0}},
                                                  {{1, 0}, {0, 1}, {1, 1}}};
        for (uint32_t k = 0; k < 3; ++k) {
            uint32_t c = column + corners[t % 2][k][0], r = row + corners[t % 2][k][1];
            uint32_t v = soup ? 3 * t + k : r * row_size + c;
            sheet_vertex(m, v, c, r, side, shape);
            m->indices[3 * (size_t)t + k] = v;
        }
    }
    for (uint32_t k = 0; k < 3 * extra; ++k) {
        uint32_t v = row_size * row_size + k;
        set_vertex(m, v, (stp_vec3){k == 1 ? 900.0f : -1.0f, 2.0f, k == 2 ? 900.0f : -1.0f},
                   (stp_vec3){0, 1, 0});
        m->indices[3 * (size_t)sheet + k] = v;
    }
    return true;
}

static bool make_scattered(uint32_t side, unsigned attributes, made_mesh* m)
{
    uint32_t triangles = 2 * side * side;
    uint64_t seed = 1;
    if (!allocate(m, 3 * triangles, triangles, attributes)) {
        return false;
    }
    for (uint32_t v = 0; v < 3 * triangles; ++v) {
        float x = random_number(&seed), y = random_number(&seed), z = random_number(&seed);
        float a = random_number(&seed), b = random_number(&seed);
        set_vertex(m, v, (stp_vec3){x, y, z}, (stp_vec3){a - 0.5f, b - 0.5f, 0.1f});
        m->indices[v] = v;
    }
    return true;
}

static bool make_boxes(uint32_t side, unsigned attributes, made_mesh* m)
{
    uint32_t boxes = side * side / 6 + 1;
    if (!allocate(m, 24 * boxes, 12 * boxes, attributes)) {
        return false;
    }
    for (uint32_t f = 0; f < 6 * boxes; ++f) {
        uint32_t axis = f % 3, far_side = f / 3 % 2, box = f / 6;
        for (uint32_t k = 0; k < 4; ++k) {
            float p[3], n[3] = {0};
            p[axis] = (float)far_side;
            p[(axis + 1) % 3] = (float)(k == 1 || k == 2);
            p[(axis + 2) % 3] = (float)(k >> 1);
            n[axis] = far_side != 0 ? 1.0f : -1.0f;
            set_vertex(m, 4 * f + k,
                       (stp_vec3){p[0] + 1.3f * (float)(box % 40), 0.1f * p[1],
                                  p[2] + 1.3f * (float)(box / 40)},
                       (stp_vec3){n[0], n[1], n[2]});
        }
        static const uint32_t corners[2][6] = {{0, 2, 1, 0, 3, 2}, {0, 1, 2, 0, 2, 3}};
        for (uint32_t k = 0; k < 6; ++k) {
            m->indices[6 * (size_t)f + k] = 4 * f + corners[far_side][k];
        }
    }
    return true;
}

bool made_mesh_create(made_shape shape, uint32_t side, unsigned attributes, made_mesh* m)
{
    bool made = shape == MADE_SCATTERED ? make_scattered(side, attributes, m)
                : shape == MADE_BOXES   ? make_boxes(side, attributes, m)
                                        : make_sheet(shape, side, attributes, m);
    if (!made) {
        made_mesh_destroy(m);
    }
    return made;
}

void made_mesh_destroy(made_mesh* m)
{
    free(m->positions);
    free(m->normals);
    free(m->texcoords[0]);
    free(m->texcoords[1]);
    free(m->colors);
    free(m->indices);
    *m = (made_mesh){0};
}

void made_mesh_shuffle(made_mesh* m, uint64_t seed)
{
    for (uint32_t t = m->triangle_count; t > 1; --t) {
        uint32_t* a = m->indices + 3 * (size_t)(t - 1);
        uint32_t* b = m->indices + 3 * (size_t)stp_rng_below(seed, t, t);
        uint32_t old[3] = {a[0], a[1], a[2]};
        memmove(a, b, sizeof(old));
        b[0] = old[1];
        b[1] = old[2];
        b[2] = old[0];
    }
}

stp_store_mesh made_mesh_view(const made_mesh* m)
{
    return (stp_store_mesh){.vertex_count = m->vertex_count,
                            .triangle_count = m->triangle_count,
                            .positions = m->positions,
                            .normals = m->normals,
                            .texcoords = {m->texcoords[0], m->texcoords[1]},
                            .colors = m->colors,
                            .indices = m->indices};
}
