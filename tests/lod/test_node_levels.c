// SPDX-License-Identifier: MIT
// Levels of the triangles of a node: hidden triangles, colours, borders, windings, limits.
#include "support_level_shapes.h"
#include "tests.h"

#include "base/core/sort.h"
#include "base/io/hash.h"
#include "base/math/rng.h"
#include "lod/levels/node_levels.h"

#include <math.h>
#include <string.h>

enum { MATERIALS = 8, VERTICES_MAX = 256, EDGES_MAX = 1 << 17 };

/// A scene whose root gets levels.
typedef struct place {
    stp_context* context;
    stp_scene* scene;
    uint32_t red, blue, white;
    stp_node_levels levels;
    uint8_t shadings[MATERIALS]; ///< of materials
} place;

static bool begin_place(place* p, uint32_t threads, test_heap* heap)
{
    *p = (place){.context = test_context(heap, threads, NULL)};
    if (p->context == NULL || stp_scene_create(p->context, &p->scene) != STP_OK) {
        return false;
    }
    p->red = level_add_material(p->scene, 0.8f, 0.1f, 0.1f);
    p->blue = level_add_material(p->scene, 0.1f, 0.2f, 0.9f);
    p->white = level_add_material(p->scene, 1.0f, 1.0f, 1.0f);
    return p->white != STP_NONE;
}

static stp_result make_levels(place* p)
{
    stp_capture_textures* textures = NULL;
    stp_placed_part* parts = NULL;
    size_t count = 0;
    stp_result result = stp_scene_finish(p->scene);
    result = result == STP_OK
                 ? stp_scene_flatten(p->scene, p->scene->root, STP_LEVELS_MOST, &parts, &count)
                 : result;
    result = result == STP_OK ? stp_capture_textures_create(p->scene, true, &textures) : result;
    result = result == STP_OK
                 ? stp_node_levels_make(p->scene, parts, count, p->shadings, textures, &p->levels)
                 : result;
    stp_free(p->context, parts);
    stp_capture_textures_destroy(textures);
    return result;
}

static void end_place(place* p)
{
    if (p->context != NULL) {
        stp_node_levels_destroy(p->context, &p->levels);
        stp_scene_destroy(p->scene);
    }
    stp_context_destroy(p->context);
}

/// A red torus, and a blue one in a closed red ball.
static bool add_tori(place* p)
{
    stp_affine aside = {{{1, 0, 0, 3}, {0, 1, 0, 0}, {0, 0, 1, 0}}};
    return level_add(p->scene, level_torus(p->context, 120, 60, 1.0, 0.4), p->red,
                     stp_affine_identity()) != STP_NONE &&
           level_add(p->scene, level_ball(p->context, 80, 40, 0, 1.0), p->red, aside) != STP_NONE &&
           level_add(p->scene, level_torus(p->context, 80, 40, 0.5, 0.2), p->blue, aside) !=
               STP_NONE;
}

/// The first triangle of a cluster of a level.
static uint32_t first_of(const stp_node_level* level, uint32_t cluster)
{
    return cluster > 0 ? level->clusters[cluster - 1].end : 0;
}

static bool is_drawn(const stp_node_levels* l, const stp_node_level_cluster* c, double allowed)
{
    return (c->made_by == STP_LEVEL_NONE || l->groups[c->made_by].error <= allowed) &&
           (c->used_by == STP_LEVEL_NONE || l->groups[c->used_by].error > allowed);
}

/// The range of allowed errors: at the first, the finest mixture is drawn, at the last the coarsest.
typedef struct errors {
    double least, most;
} errors;

static errors find_errors(const stp_node_levels* l)
{
    errors e = {HUGE_VAL, 0.0};
    for (uint32_t i = 0; i < l->group_count; ++i) {
        e.least = fmin(e.least, l->groups[i].error);
        e.most = fmax(e.most, l->groups[i].error);
    }
    e.least *= 1.0 - 1e-9; // the least error is not allowed, so what it replaces is drawn
    return e;
}

typedef void triangle_visitor(const stp_node_level* level, uint32_t triangle, bool one_sided,
                              void* user);

/// Visits the triangles that are drawn where an error is allowed. @return their number
static uint32_t visit_mixture(const stp_node_levels* l, double allowed, triangle_visitor* visit,
                              void* user)
{
    uint32_t count = 0;
    for (uint32_t i = 0; i < l->level_count; ++i) {
        const stp_node_level* level = &l->levels[i];
        for (uint32_t k = 0; k < level->cluster_count; ++k) {
            const stp_node_level_cluster* c = &level->clusters[k];
            uint32_t first = first_of(level, k);
            if (is_drawn(l, c, allowed)) {
                for (uint32_t t = first; t < c->end; ++t, ++count) {
                    visit(level, t, t - first < c->one_sided, user);
                }
            }
        }
    }
    return count;
}

static stp_vec3d corner_of(const stp_node_level* level, uint32_t triangle, uint32_t corner)
{
    const float* p = level->positions + 3 * (size_t)level->indices[3 * (size_t)triangle + corner];
    return (stp_vec3d){(double)p[0], (double)p[1], (double)p[2]};
}

/// Normal of a triangle, twice as long as its area.
static stp_vec3d normal_of(const stp_node_level* level, uint32_t triangle)
{
    stp_vec3d a = corner_of(level, triangle, 0);
    return stp_crossd(stp_subd(corner_of(level, triangle, 1), a),
                      stp_subd(corner_of(level, triangle, 2), a));
}

void test_node_levels_do_not_depend_on_threads(test_state* test)
{
    place places[2];
    for (uint32_t i = 0; i < 2; ++i) {
        CHECK(begin_place(&places[i], 1 + 2 * i, NULL) && add_tori(&places[i]));
        CHECK_EQUAL(STP_OK, make_levels(&places[i]));
    }
    const stp_node_levels *a = &places[0].levels, *b = &places[1].levels;
    CHECK(a->level_count > 1 && a->level_count == b->level_count);
    CHECK(a->group_count > 3 && a->group_count == b->group_count);
    CHECK(a->from_outside == b->from_outside && a->step == b->step);
    for (uint32_t i = 0; i < a->group_count; ++i) {
        const stp_level_group *g = &a->groups[i], *h = &b->groups[i];
        CHECK(g->error == h->error && g->radius == h->radius && g->center.x == h->center.x &&
              g->center.y == h->center.y && g->center.z == h->center.z && g->level == h->level);
    }
    for (uint32_t i = 0; i < a->level_count; ++i) {
        const stp_node_level *l = &a->levels[i], *m = &b->levels[i];
        CHECK(l->shading == m->shading && l->vertex_count == m->vertex_count &&
              l->triangle_count == m->triangle_count && l->cluster_count == m->cluster_count);
        CHECK(memcmp(l->positions, m->positions, 3 * sizeof(float) * l->vertex_count) == 0);
        CHECK(memcmp(l->colors, m->colors, 4 * sizeof(uint16_t) * l->vertex_count) == 0);
        CHECK(memcmp(l->indices, m->indices, 3 * sizeof(uint32_t) * l->triangle_count) == 0);
        CHECK(memcmp(l->clusters, m->clusters, sizeof(*l->clusters) * l->cluster_count) == 0);
    }
    end_place(&places[0]);
    end_place(&places[1]);
}

/// Counts blue vertices.
static uint32_t count_blue(const stp_node_levels* l)
{
    uint32_t count = 0;
    for (uint32_t i = 0; i < l->level_count; ++i) {
        for (uint32_t v = 0; v < l->levels[i].vertex_count; ++v) {
            const uint16_t* color = l->levels[i].colors + 4 * (size_t)v;
            count += color[2] > color[0] ? 1 : 0;
        }
    }
    return count;
}

void test_node_levels_lack_what_is_hidden(test_state* test)
{
    place p;
    CHECK(begin_place(&p, 2, NULL) && add_tori(&p));
    CHECK_EQUAL(STP_OK, make_levels(&p));
    CHECK(p.levels.level_count > 0 && p.levels.from_outside);
    CHECK_EQUAL(0, count_blue(&p.levels)); // the torus in the ball
    end_place(&p);
    // outside the ball, the same torus is there
    CHECK(begin_place(&p, 2, NULL));
    CHECK(level_add(p.scene, level_ball(p.context, 80, 40, 0, 1.0), p.red, stp_affine_identity()) !=
          STP_NONE);
    CHECK(level_add(p.scene, level_torus(p.context, 80, 40, 1.5, 0.2), p.blue,
                    stp_affine_identity()) != STP_NONE);
    CHECK_EQUAL(STP_OK, make_levels(&p));
    CHECK(p.levels.from_outside && count_blue(&p.levels) > 100);
    end_place(&p);
}

void test_node_levels_of_sheets_have_both_sides(test_state* test)
{
    place p;
    CHECK(begin_place(&p, 2, NULL));
    CHECK(level_add(p.scene, level_sheet(p.context, 80, 1.0, 0.02), p.white,
                    stp_affine_identity()) != STP_NONE);
    CHECK_EQUAL(STP_OK, make_levels(&p));
    CHECK(p.levels.level_count > 0 && !p.levels.from_outside);
    for (uint32_t i = 0; i < p.levels.level_count; ++i) {
        for (uint32_t k = 0; k < p.levels.levels[i].cluster_count; ++k) {
            CHECK_EQUAL(0, p.levels.levels[i].clusters[k].one_sided);
        }
    }
    end_place(&p);
}

static void check_clusters(test_state* test, const stp_node_levels* l, const stp_node_level* level)
{
    for (uint32_t k = 0; k < level->cluster_count; ++k) {
        const stp_node_level_cluster* c = &level->clusters[k];
        uint32_t first = first_of(level, k), low = UINT32_MAX, high = 0;
        CHECK(c->end > first && c->end - first <= STP_LEVEL_CLUSTER &&
              c->end <= level->triangle_count);
        CHECK(c->one_sided <= c->end - first && (l->from_outside || c->one_sided == 0));
        CHECK(c->made_by == STP_LEVEL_NONE || c->made_by < l->group_count);
        CHECK(c->used_by == STP_LEVEL_NONE || c->used_by < l->group_count);
        if (c->made_by != STP_LEVEL_NONE && c->used_by != STP_LEVEL_NONE) {
            const stp_level_group *made = &l->groups[c->made_by], *used = &l->groups[c->used_by];
            CHECK(used->error > made->error);
            CHECK(stp_lengthd(stp_subd(made->center, used->center)) + made->radius <=
                  used->radius * (1.0 + 1e-6)); // rounded to floats
        }
        for (uint32_t t = first; t < c->end; ++t) {
            const uint32_t* corners = level->indices + 3 * (size_t)t;
            for (int i = 0; i < 3; ++i) {
                CHECK(corners[i] < level->vertex_count);
                low = corners[i] < low ? corners[i] : low;
                high = corners[i] > high ? corners[i] : high;
            }
            CHECK(corners[0] != corners[1] && corners[1] != corners[2] && corners[2] != corners[0]);
        }
        CHECK(high - low < VERTICES_MAX); // its vertices follow each other
    }
    CHECK_EQUAL(level->triangle_count, level->clusters[level->cluster_count - 1].end);
}

static void skip_triangle(const stp_node_level* level, uint32_t triangle, bool one_sided,
                          void* user)
{
    (void)level;
    (void)triangle;
    (void)one_sided;
    (void)user;
}

void test_node_levels_keep_limits(test_state* test)
{
    place p;
    CHECK(begin_place(&p, 2, NULL));
    p.shadings[p.blue] = 7; // a mesh has one shading
    CHECK(add_tori(&p));
    CHECK(level_add(p.scene, level_torus(p.context, 60, 40, 2.2, 0.3), p.blue,
                    stp_affine_identity()) != STP_NONE);
    CHECK_EQUAL(STP_OK, make_levels(&p));
    const stp_node_levels* l = &p.levels;
    uint32_t stored = 0, of_shading = 0;
    CHECK(l->level_count > 1 && l->step > 0.0 && frexp(l->step, &(int){0}) == 0.5);
    for (uint32_t i = 0; i < l->level_count; ++i) {
        const stp_node_level* level = &l->levels[i];
        CHECK(level->triangle_count > 0 && (level->shading == 0 || level->shading == 7));
        check_clusters(test, l, level);
        stored += level->triangle_count;
        of_shading += level->shading == 7 ? 1 : 0;
        for (uint32_t v = 0; v < level->vertex_count; ++v) {
            const uint16_t* color = level->colors + 4 * (size_t)v;
            CHECK((color[2] > color[0]) == (level->shading == 7));
        }
    }
    CHECK(of_shading > 0);
    uint32_t originals = 0;
    for (size_t i = 0; i < p.scene->mesh_count; ++i) {
        originals += p.scene->meshes[i].triangle_count;
    }
    errors e = find_errors(l);
    uint32_t before = originals;
    for (double allowed = e.least; allowed <= 1.5 * e.most; allowed *= 1.5) { // fewer and fewer
        uint32_t drawn = visit_mixture(l, allowed, skip_triangle, NULL);
        CHECK(drawn > 0 && drawn <= before);
        before = drawn;
    }
    CHECK(visit_mixture(l, e.least, skip_triangle, NULL) <= originals / 2);
    CHECK(visit_mixture(l, e.most, skip_triangle, NULL) <= originals / 30);
    CHECK(4 * (uint64_t)stored <= 3 * (uint64_t)originals);
    end_place(&p);
}

/// Triangles of a mixture, by the places of their corners.
typedef struct edge_list {
    uint64_t* edges; ///< ends, the smaller first, and a bit for the direction
    size_t count;
} edge_list;

static uint64_t hash_place(const float* p)
{
    return stp_hash_bytes((stp_hash){0}, p, 3 * sizeof(float)).low;
}

static void add_edges(const stp_node_level* level, uint32_t triangle, bool one_sided, void* user)
{
    edge_list* to = user;
    (void)one_sided;
    for (size_t k = 0; k < 3 && to->count < EDGES_MAX; ++k) {
        const uint32_t* c = level->indices + 3 * (size_t)triangle;
        uint64_t a = hash_place(level->positions + 3 * (size_t)c[k]);
        uint64_t b = hash_place(level->positions + 3 * (size_t)c[(k + 1) % 3]);
        // the ends cannot be told from their sum; the direction is one bit
        to->edges[to->count++] = (a + b) << 1 | (a < b ? 1 : 0);
    }
}

// Each edge is walked as often one way as the other, in the mixtures that are drawn.
void test_stored_levels_are_closed(test_state* test)
{
    static uint64_t edges[EDGES_MAX], scratch[EDGES_MAX];
    place p;
    CHECK(begin_place(&p, 2, NULL));
    CHECK(level_add(p.scene, level_torus(p.context, 120, 60, 1.0, 0.4), p.red,
                    stp_affine_identity()) != STP_NONE);
    CHECK_EQUAL(STP_OK, make_levels(&p));
    CHECK(p.levels.level_count > 0);
    errors e = find_errors(&p.levels);
    for (double allowed = e.least; allowed < 1.1 * e.most; allowed *= 1.1) {
        edge_list list = {.edges = edges};
        CHECK(visit_mixture(&p.levels, allowed, add_edges, &list) > 0 && list.count < EDGES_MAX);
        const uint64_t* sorted = stp_sort_u64(edges, scratch, list.count, 0, 64);
        for (size_t i = 0; i < list.count;) {
            int balance = 0;
            uint64_t edge = sorted[i] >> 1;
            for (; i < list.count && sorted[i] >> 1 == edge; ++i) {
                balance += (sorted[i] & 1) != 0 ? 1 : -1;
            }
            CHECK_EQUAL(0, balance);
        }
    }
    end_place(&p);
}

static bool is_color(const uint16_t* code, float red, float green, float blue)
{
    const float color[3] = {red, green, blue};
    bool same = code[3] == 65535;
    for (int k = 0; k < 3; ++k) {
        same = same && fabs((double)code[k] - 65535.0 * (double)color[k]) <= 2.0;
    }
    return same;
}

/// Areas of a mixture, and its mean colour.
typedef struct look {
    double area, red_area, color[3];
} look;

static void add_look(const stp_node_level* level, uint32_t triangle, bool one_sided, void* user)
{
    look* to = user;
    double area = 0.5 * stp_lengthd(normal_of(level, triangle));
    (void)one_sided;
    to->area += area;
    for (size_t k = 0; k < 3; ++k) {
        const uint16_t* color =
            level->colors + 4 * (size_t)level->indices[3 * (size_t)triangle + k];
        to->red_area += color[0] > color[2] ? area / 3.0 : 0.0;
        for (int c = 0; c < 3; ++c) {
            to->color[c] += area / 3.0 * color[c] / 65535.0;
        }
    }
}

static look look_at(const stp_node_levels* l, double allowed)
{
    look sum = {0};
    visit_mixture(l, allowed, add_look, &sum);
    sum.red_area /= sum.area;
    for (int c = 0; c < 3; ++c) {
        sum.color[c] /= sum.area;
    }
    return sum;
}

/// Gives a mesh vertex colours of one value, or as a function of the vertex.
static void color_mesh(const place* p, stp_mesh* mesh, void (*color_of)(uint32_t, uint16_t[4]))
{
    mesh->colors = STP_NEW_ARRAY(p->context, uint16_t, 4 * (size_t)mesh->vertex_count);
    for (uint32_t v = 0; v < mesh->vertex_count && mesh->colors != NULL; ++v) {
        color_of(v, mesh->colors + 4 * (size_t)v);
    }
}

static void be_white(uint32_t vertex, uint16_t color[4])
{
    (void)vertex;
    color[0] = color[1] = color[2] = color[3] = 65535;
}

// Two sheets that touch each other; `colored`: their vertices have colours, all white. On a plane,
// nothing but their border shows.
static void check_two_materials(test_state* test, bool colored, double bump)
{
    place p;
    CHECK(begin_place(&p, 2, NULL));
    for (int i = 0; i < 2; ++i) {
        stp_mesh mesh = level_sheet(p.context, 60, 1.0, bump);
        stp_affine aside = {{{1, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, 1, i}}};
        for (uint32_t v = 0; v < mesh.vertex_count; ++v) { // level at the common border
            float z = mesh.positions[3 * v + 2];
            mesh.positions[3 * v + 1] *= 4.0f * z * (1.0f - z);
        }
        if (colored) {
            color_mesh(&p, &mesh, be_white);
        }
        CHECK(level_add(p.scene, mesh, i == 0 ? p.red : p.blue, aside) != STP_NONE);
    }
    CHECK_EQUAL(STP_OK, make_levels(&p));
    const stp_node_levels* l = &p.levels;
    CHECK(l->level_count > 0);
    for (uint32_t i = 0; i < l->level_count; ++i) {
        for (uint32_t v = 0; v < l->levels[i].vertex_count; ++v) {
            const uint16_t* color = l->levels[i].colors + 4 * (size_t)v;
            CHECK(is_color(color, 0.8f, 0.1f, 0.1f) || is_color(color, 0.1f, 0.2f, 0.9f));
        }
    }
    errors e = find_errors(l);
    for (double allowed = e.least; allowed <= 1.4 * e.most; allowed *= 1.4) {
        CHECK(fabs(look_at(l, allowed).red_area - 0.5) < 0.02); // the border stays
    }
    end_place(&p);
}

void test_node_levels_do_not_mix_materials(test_state* test)
{
    check_two_materials(test, false, 0.02);
    check_two_materials(test, true, 0.02);
    check_two_materials(test, false, 0.0);
}

static void grade(uint32_t vertex, uint16_t color[4])
{
    // 61 vertices in a row: red grows along it
    color[0] = (uint16_t)(vertex % 61 * 65535 / 60);
    color[1] = 20000;
    color[2] = (uint16_t)(vertex / 61 % 7 * 9000);
    color[3] = 65535;
}

void test_node_levels_keep_mean_colors(test_state* test)
{
    place p;
    CHECK(begin_place(&p, 2, NULL));
    stp_mesh mesh = level_sheet(p.context, 60, 1.0, 0.02);
    color_mesh(&p, &mesh, grade);
    CHECK(level_add(p.scene, mesh, p.white, stp_affine_identity()) != STP_NONE);
    CHECK_EQUAL(STP_OK, make_levels(&p));
    CHECK(p.levels.level_count > 0);
    double mean[3] = {0};
    for (uint32_t v = 0; v < 61 * 61; ++v) {
        uint16_t color[4];
        bool border_x = v % 61 == 0 || v % 61 == 60, border_z = v / 61 == 0 || v / 61 == 60;
        double weight = (border_x ? 0.5 : 1.0) * (border_z ? 0.5 : 1.0) / 3600.0;
        grade(v, color);
        for (int c = 0; c < 3; ++c) {
            mean[c] += weight * color[c] / 65535.0;
        }
    }
    errors e = find_errors(&p.levels);
    for (double allowed = e.least; allowed <= 0.1; allowed *= 1.4) {
        look now = look_at(&p.levels, allowed);
        for (int c = 0; c < 3; ++c) {
            CHECK(fabs(now.color[c] - mean[c]) < 0.02);
        }
    }
    end_place(&p);
}

enum { BOARD = 64 };

typedef enum board { BOARD_PLAIN, BOARD_VERTICES, BOARD_TEXTURE, BOARDS } board;

static void check_vertex(uint32_t vertex, uint16_t color[4])
{
    be_white(vertex, color);
    if ((vertex % (BOARD + 1) + vertex / (BOARD + 1)) % 2 != 0) {
        color[0] = color[1] = color[2] = 0;
    }
}

/// A texture of black and white squares, as many as the sheet has.
static uint32_t add_board_texture(place* p)
{
    stp_texture texture = {.width = 2 * BOARD,
                           .height = 2 * BOARD,
                           .texels = STP_NEW_ARRAY(p->context, uint8_t, 16 * BOARD * BOARD)};
    uint32_t index = STP_NONE;
    for (uint32_t i = 0; i < 4 * BOARD * BOARD && texture.texels != NULL; ++i) {
        uint8_t value = (i / 2 % BOARD + i / (4 * BOARD)) % 2 == 0 ? 255 : 0;
        const uint8_t texel[4] = {value, value, value, 255};
        memcpy(texture.texels + 4 * (size_t)i, texel, sizeof(texel));
    }
    return texture.texels != NULL && stp_scene_add_texture(p->scene, &texture, &index) == STP_OK
               ? index
               : STP_NONE;
}

static bool add_board(place* p, board kind)
{
    stp_mesh mesh = level_sheet(p->context, BOARD, 1.0, 0.0);
    uint32_t material = p->white;
    if (kind == BOARD_VERTICES) {
        color_mesh(p, &mesh, check_vertex);
    }
    if (kind == BOARD_TEXTURE) {
        stp_material textured = p->scene->materials[p->white];
        textured.base_color_texture.texture = add_board_texture(p);
        mesh.texcoords[0] = STP_NEW_ARRAY(p->context, float, 2 * (size_t)mesh.vertex_count);
        for (uint32_t v = 0; v < mesh.vertex_count && mesh.texcoords[0] != NULL; ++v) {
            mesh.texcoords[0][2 * v] = mesh.positions[3 * v];
            mesh.texcoords[0][2 * v + 1] = mesh.positions[3 * v + 2];
        }
        if (mesh.texcoords[0] == NULL ||
            stp_scene_add_material(p->scene, &textured, &material) != STP_OK) {
            return false;
        }
    }
    return level_add(p->scene, mesh, material, stp_affine_identity()) != STP_NONE;
}

// Errors count what a mixture of colours loses: a plane has none, unless its squares differ.
void test_node_levels_see_patterns(test_state* test)
{
    double least[BOARDS];
    for (int i = 0; i < BOARDS; ++i) {
        place p;
        CHECK(begin_place(&p, 2, NULL) && add_board(&p, (board)i));
        CHECK_EQUAL(STP_OK, make_levels(&p));
        least[i] = find_errors(&p.levels).least; // infinite: it has no levels
        CHECK(i != BOARD_PLAIN || p.levels.level_count > 0);
        end_place(&p);
    }
    double square = 1.0 / BOARD;
    CHECK(least[BOARD_PLAIN] < 0.02 * square);
    CHECK(least[BOARD_VERTICES] > 0.3 * square);
    CHECK(least[BOARD_TEXTURE] > 0.3 * square);
}

enum { PIECE = 60 };

static void note_vertices(const stp_node_level* level, uint32_t triangle, bool one_sided,
                          void* user)
{
    uint8_t* met = user; // per vertex of the sheet
    (void)one_sided;
    for (uint32_t k = 0; k < 3; ++k) {
        stp_vec3d p = corner_of(level, triangle, k);
        double x = p.x * PIECE, z = p.z * PIECE;
        uint32_t column = (uint32_t)(x + 0.5), row = (uint32_t)(z + 0.5);
        if (fabs(x - column) < 1e-4 && fabs(z - row) < 1e-4) {
            met[row * (PIECE + 1) + column] = 1;
        }
    }
}

static uint32_t count_border(const stp_node_levels* l, double allowed)
{
    uint8_t met[(PIECE + 1) * (PIECE + 1)] = {0};
    uint32_t count = 0;
    visit_mixture(l, allowed, note_vertices, met);
    for (uint32_t i = 0; i < PIECE; ++i) {
        count += met[i] + met[PIECE * (PIECE + 1) + i + 1];
        count += met[(i + 1) * (PIECE + 1)] + met[i * (PIECE + 1) + PIECE];
    }
    return count;
}

void test_node_levels_keep_borders_of_pieces(test_state* test)
{
    for (int piece = 0; piece < 2; ++piece) {
        place p;
        CHECK(begin_place(&p, 2, NULL));
        stp_mesh mesh = level_sheet(p.context, PIECE, 1.0, 0.02);
        mesh.is_piece = piece != 0;
        CHECK(level_add(p.scene, mesh, p.white, stp_affine_identity()) != STP_NONE);
        CHECK_EQUAL(STP_OK, make_levels(&p));
        CHECK(p.levels.level_count > 0 && !p.levels.from_outside);
        errors e = find_errors(&p.levels);
        for (double allowed = e.least; allowed <= 1.4 * e.most && piece != 0; allowed *= 1.4) {
            CHECK_EQUAL(4 * PIECE, count_border(&p.levels, allowed));
        }
        CHECK(piece != 0 || count_border(&p.levels, e.most) < 2 * PIECE);
        end_place(&p);
    }
}

// Pieces of closed meshes: the inside of a piece may be seen through its borders.
void test_node_levels_of_pieces_hide_nothing(test_state* test)
{
    place p;
    CHECK(begin_place(&p, 2, NULL));
    stp_mesh ball = level_ball(p.context, 80, 40, 0, 1.0);
    ball.is_piece = true;
    CHECK(level_add(p.scene, ball, p.red, stp_affine_identity()) != STP_NONE);
    CHECK(level_add(p.scene, level_torus(p.context, 80, 40, 0.5, 0.2), p.blue,
                    stp_affine_identity()) != STP_NONE);
    CHECK_EQUAL(STP_OK, make_levels(&p));
    CHECK(p.levels.level_count > 0 && !p.levels.from_outside && count_blue(&p.levels) > 100);
    end_place(&p);
}

/// Areas of triangles that face the right way, and of all.
typedef struct facing {
    double right, all;
    uint32_t two_sided;
} facing;

// The torus of radius 1 around the y axis.
static void add_outward(const stp_node_level* level, uint32_t triangle, bool one_sided, void* user)
{
    facing* f = user;
    stp_vec3d n = normal_of(level, triangle), sum = {0, 0, 0};
    for (uint32_t k = 0; k < 3; ++k) {
        sum = stp_addd(sum, stp_scaled(corner_of(level, triangle, k), 1.0 / 3.0));
    }
    double flat = sqrt(sum.x * sum.x + sum.z * sum.z);
    stp_vec3d middle = {sum.x / flat, 0.0, sum.z / flat};
    f->all += stp_lengthd(n);
    f->right += stp_dotd(n, stp_subd(sum, middle)) > 0.0 ? stp_lengthd(n) : 0.0;
    f->two_sided += one_sided ? 0 : 1;
}

static void add_upward(const stp_node_level* level, uint32_t triangle, bool one_sided, void* user)
{
    facing* f = user;
    stp_vec3d n = normal_of(level, triangle);
    (void)one_sided;
    f->all += stp_lengthd(n);
    f->right += n.y > 0.0 ? stp_lengthd(n) : 0.0;
}

static facing find_facing(place* p, double allowed, triangle_visitor* visit)
{
    facing f = {0};
    visit_mixture(&p->levels, allowed, visit, &f);
    return f;
}

// Fronts stay fronts in a mirror: a mirrored transform turns the corners around.
void test_node_levels_of_mirrored_meshes_face_outward(test_state* test)
{
    for (int mirrored = 0; mirrored < 2; ++mirrored) {
        double x = mirrored != 0 ? -1.0 : 1.0;
        stp_affine mirror = {{{x, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, 1, 0}}};
        place p;
        CHECK(begin_place(&p, 2, NULL));
        CHECK(level_add(p.scene, level_sheet(p.context, 60, 1.0, 0.02), p.white, mirror) !=
              STP_NONE);
        CHECK_EQUAL(STP_OK, make_levels(&p));
        errors e = find_errors(&p.levels);
        for (double allowed = e.least; allowed <= 1.4 * e.most; allowed *= 1.4) {
            facing f = find_facing(&p, allowed, add_upward);
            CHECK(f.all > 0.0 && f.right == f.all);
        }
        end_place(&p);
    }
}

// A torus whose fronts are inside, in effect: only its backs can be seen, and they become fronts.
void test_node_levels_show_the_side_that_is_seen(test_state* test)
{
    for (int turned = 0; turned < 2; ++turned) {
        place p;
        CHECK(begin_place(&p, 2, NULL));
        stp_mesh mesh = level_torus(p.context, 120, 60, 1.0, 0.4);
        for (size_t i = 0; turned != 0 && i < 3 * (size_t)mesh.triangle_count; i += 3) {
            uint32_t corner = mesh.indices[i];
            mesh.indices[i] = mesh.indices[i + 1];
            mesh.indices[i + 1] = corner;
        }
        CHECK(level_add(p.scene, mesh, p.white, stp_affine_identity()) != STP_NONE);
        CHECK_EQUAL(STP_OK, make_levels(&p));
        CHECK(p.levels.level_count > 0 && p.levels.from_outside);
        errors e = find_errors(&p.levels);
        for (double allowed = e.least; allowed <= 0.5; allowed *= 1.4) {
            facing f = find_facing(&p, allowed, add_outward);
            CHECK(f.right > 0.999 * f.all && f.two_sided == 0);
        }
        end_place(&p);
    }
}

void test_small_nodes_have_no_levels(test_state* test)
{
    place p;
    CHECK(begin_place(&p, 1, NULL));
    CHECK(level_add(p.scene, level_sheet(p.context, 22, 1.0, 0.0), p.white, // 968
                    stp_affine_identity()) != STP_NONE);
    CHECK_EQUAL(STP_OK, make_levels(&p));
    CHECK(p.levels.level_count == 0 && p.levels.group_count == 0);
    end_place(&p);
}

// A node whose triangles have no area, or are all at one place.
void test_node_levels_take_degenerate_triangles(test_state* test)
{
    for (int kind = 0; kind < 2; ++kind) {
        place p;
        CHECK(begin_place(&p, 1, NULL));
        stp_mesh mesh = level_sheet(p.context, 40, 1.0, 0.0);
        for (uint32_t v = 0; v < mesh.vertex_count; ++v) { // a line, or a point
            mesh.positions[3 * v + 2] = 0.0f;
            mesh.positions[3 * v] *= kind == 0 ? 1.0f : 0.0f;
        }
        CHECK(level_add(p.scene, mesh, p.white, stp_affine_identity()) != STP_NONE);
        CHECK_EQUAL(STP_OK, make_levels(&p));
        CHECK(kind == 0 || p.levels.level_count == 0);
        end_place(&p);
    }
}

void test_node_levels_survive_failing_allocator(test_state* test)
{
    bool made = false;
    uint32_t failures = 0;
    for (int n = 1; !made && n < 20000; n += 1 + n / 4) {
        test_heap heap = TEST_HEAP(n);
        place p;
        if (begin_place(&p, 1, &heap)) {
            stp_mesh ball = level_ball(p.context, 40, 20, 0, 1.0);
            if (ball.positions != NULL) {
                color_mesh(&p, &ball, be_white);
            }
            if (level_add(p.scene, ball, p.red, stp_affine_identity()) != STP_NONE) {
                stp_result result = make_levels(&p);
                made = result == STP_OK && heap.count <= n;
                CHECK(result == STP_OK || result == STP_ERROR_OUT_OF_MEMORY);
                CHECK(!made || p.levels.level_count > 0);
                failures += result != STP_OK ? 1 : 0;
            }
        }
        end_place(&p);
        CHECK_EQUAL(0, heap.live_bytes);
    }
    CHECK(made && failures > 10);
}

/// 3,000 leaves of two triangles, scattered in a ball.
static stp_mesh make_leaves(stp_context* context)
{
    enum { LEAVES = 3000 };
    stp_mesh mesh = {.vertex_count = 4 * LEAVES, .triangle_count = 2 * LEAVES};
    mesh.positions = STP_NEW_ARRAY(context, float, 3 * (size_t)mesh.vertex_count);
    mesh.indices = STP_NEW_ARRAY(context, uint32_t, 3 * (size_t)mesh.triangle_count);
    for (uint32_t i = 0; i < LEAVES && mesh.positions != NULL && mesh.indices != NULL; ++i) {
        double at[6];
        for (uint64_t k = 0; k < 6; ++k) {
            at[k] = 2.0 * (double)(stp_rng_hash(i, k) >> 40) / 0x1p24 - 1.0;
        }
        for (uint32_t v = 0; v < 4; ++v) {
            float* p = mesh.positions + 3 * (size_t)(4 * i + v);
            double a = (v & 1) != 0 ? 0.02 : -0.02, b = (v & 2) != 0 ? 0.02 : -0.02;
            p[0] = (float)(at[0] + a * at[3]);
            p[1] = (float)(at[1] + b);
            p[2] = (float)(at[2] + a * at[4]);
        }
        const uint32_t f = 4 * i, corners[6] = {f, f + 1, f + 2, f + 1, f + 3, f + 2};
        memcpy(mesh.indices + 6 * (size_t)i, corners, sizeof(corners));
    }
    return mesh;
}

// Each leaf may be left out where it is smaller than the error, but all together show much.
void test_node_levels_leave_no_foliage_out(test_state* test)
{
    static place p;
    CHECK(begin_place(&p, 2, NULL));
    CHECK(level_add(p.scene, make_leaves(p.context), p.red, stp_affine_identity()) != STP_NONE);
    CHECK_EQUAL(STP_OK, make_levels(&p));
    CHECK_EQUAL(0, p.levels.level_count);
    end_place(&p);
}
