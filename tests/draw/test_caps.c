// SPDX-License-Identifier: MIT
// Section caps: only closed solids are filled, on both backends, from any viewpoint.
#include "support_gl.h"
#include "tests.h"

#include "base/math/rng.h"
#include "draw/caps.h"
#include "select/sections.h"

#include <math.h>
#include <string.h>

enum { SIDES = 12, SHAPE_VERTICES = 16, SHAPE_INDICES = 2 * 3 * SIDES };

/// Triangles of a box from -1 to 1; the sides -z and +z come last.
static const float corners[8][3] = {{-1, -1, -1}, {1, -1, -1}, {1, 1, -1}, {-1, 1, -1},
                                    {-1, -1, 1},  {1, -1, 1},  {1, 1, 1},  {-1, 1, 1}};
static const uint32_t sides[SIDES][3] = {{0, 1, 5}, {0, 5, 4}, {1, 2, 6}, {1, 6, 5},
                                         {2, 3, 7}, {2, 7, 6}, {3, 0, 4}, {3, 4, 7},
                                         {0, 3, 2}, {0, 2, 1}, {4, 5, 6}, {4, 6, 7}};

static struct {
    float positions[MADE_LIMIT][SHAPE_VERTICES][3];
    uint32_t indices[MADE_LIMIT][SHAPE_INDICES];
} made;

/// Appends triangles [begin, end) of a box to a mesh, optionally inside out.
static void append(stp_store_mesh* mesh, int number, float size, int begin, int end, bool turned)
{
    uint32_t base = mesh->vertex_count, at = 3 * mesh->triangle_count;
    for (int i = 0; i < 8; ++i) {
        for (int k = 0; k < 3; ++k) {
            made.positions[number][base + (uint32_t)i][k] = size * corners[i][k];
        }
    }
    for (int i = begin; i < end; ++i) {
        for (int k = 0; k < 3; ++k) {
            made.indices[number][at++] = base + sides[i][turned ? 2 - k : k];
        }
    }
    mesh->vertex_count += 8;
    mesh->triangle_count += (uint32_t)(end - begin);
}

/// Adds an empty mesh with a transform.
static stp_store_mesh* add_mesh(made_picture* p, double scale_x, stp_vec3d move)
{
    made_scene* s = &p->scene;
    uint32_t at = s->node_count;
    made_picture_add(p, 0.0, move, NULL);
    s->edges[s->edge_count - 1].transform.m[0][0] = scale_x;
    s->nodes[at].bounds = (stp_boxd){{-1, -1, -1}, {1, 1, 1}};
    s->nodes[at].triangle_count = SIDES;
    s->meshes[at] = (stp_store_mesh){.name = "shape",
                                     .bounds = {{-1, -1, -1}, {1, 1, 1}},
                                     .positions = made.positions[at][0],
                                     .indices = made.indices[at]};
    return &s->meshes[at];
}

static void add_box(made_picture* p)
{
    append(add_mesh(p, 1.0, (stp_vec3d){0, 0, 0}), 0, 1.0f, 0, SIDES, false);
}

static void add_turned(made_picture* p)
{
    append(add_mesh(p, 1.0, (stp_vec3d){0, 0, 0}), 0, 1.0f, 0, SIDES, true);
}

static void add_mirrored(made_picture* p)
{
    append(add_mesh(p, -1.0, (stp_vec3d){0, 0, 0}), 0, 1.0f, 0, SIDES, false);
}

/// Open at one end.
static void add_open(made_picture* p)
{
    append(add_mesh(p, 1.0, (stp_vec3d){0, 0, 0}), 0, 1.0f, 0, SIDES - 2, false);
}

/// A hollow box with walls.
static void add_walls(made_picture* p)
{
    stp_store_mesh* mesh = add_mesh(p, 1.0, (stp_vec3d){0, 0, 0});
    append(mesh, 0, 1.0f, 0, SIDES, false);
    append(mesh, 0, 0.5f, 0, SIDES, true);
}

/// A solid inside a solid, and another one through its side.
static void add_nested(made_picture* p)
{
    add_box(p);
    append(add_mesh(p, 1.0, (stp_vec3d){0, 0, 0}), 1, 0.5f, 0, SIDES, false);
    append(add_mesh(p, 1.0, (stp_vec3d){0.5, 0, 0}), 2, 0.5f, 0, SIDES, false);
}

/// One box in two pieces, each open.
static void add_pieces(made_picture* p)
{
    append(add_mesh(p, 1.0, (stp_vec3d){0, 0, 0}), 0, 1.0f, 0, 5, false);
    append(add_mesh(p, 1.0, (stp_vec3d){0, 0, 0}), 1, 1.0f, 5, SIDES, false);
}

/// A box with a crack through the plane: an edge of one side has an additional vertex, slightly
/// displaced.
static void add_cracked(made_picture* p)
{
    static const uint32_t side[3][3] = {{0, 1, 8}, {0, 8, 5}, {0, 5, 4}};
    stp_store_mesh* mesh = add_mesh(p, 1.0, (stp_vec3d){0, 0, 0});
    append(mesh, 0, 1.0f, 2, SIDES, false);
    memcpy(made.positions[0][8], (const float[3]){0.98f, -1.0f, 0.1f}, sizeof(float[3]));
    memcpy(made.indices[0] + 3 * (size_t)mesh->triangle_count, side, sizeof(side));
    mesh->vertex_count += 1;
    mesh->triangle_count += 3;
}

/// The cap hides everything behind it.
static void add_glass(made_picture* p)
{
    add_box(p);
    p->scene.materials[0].alpha = STP_STORE_BLEND;
    p->scene.materials[0].base_color[3] = 0.5f;
}

static bool is_cap(const uint8_t* pixel)
{
    return pixel[3] == 255 && pixel[0] > pixel[1] + 20 && pixel[1] > pixel[2] + 10;
}

static int count_caps(const uint8_t* pixels)
{
    int count = 0;
    for (int i = 0; i < PICTURE_SIDE * PICTURE_SIDE; ++i) {
        count += is_cap(pixels + 4 * i) ? 1 : 0;
    }
    return count;
}

/// A square at z = 0 from -1 to 1 has 32 x 32 pixels.
static const struct {
    void (*add)(made_picture* p);
    int caps;
    bool middle; ///< is filled
} cases[] = {{add_box, 1024, true},    {add_turned, 1024, true},  {add_mirrored, 1024, true},
             {add_open, 0, false},     {add_walls, 768, false},   {add_nested, 1024, true},
             {add_pieces, 1024, true}, {add_cracked, 1024, true}, {add_glass, 1024, true}};
enum { CASES = sizeof(cases) / sizeof(cases[0]) };

static bool open_case(made_picture* p, void (*add)(made_picture* p))
{
    memset(&made, 0, sizeof(made));
    if (!made_picture_begin(p, NULL, 2)) {
        return false;
    }
    add(p);
    p->style.caps = true;
    return made_picture_open(p) == STP_OK;
}

static bool cut_at_zero(made_picture* p)
{
    return stp_sections_add_plane(&p->view.sections, (stp_vec3d){0, 0, 0}, (stp_vec3d){0, 0, 1});
}

void test_caps_fill_closed_solids_only(test_state* test)
{
    for (int i = 0; i < CASES; ++i) {
        made_picture p;
        CHECK(open_case(&p, cases[i].add));
        CHECK_EQUAL(STP_OK, made_picture_draw(&p));
        CHECK_EQUAL(0, count_caps(p.pixels)); // nothing is cut
        CHECK(cut_at_zero(&p));
        CHECK_EQUAL(STP_OK, made_picture_draw(&p));
        CHECK_EQUAL(cases[i].caps, count_caps(p.pixels));
        CHECK(is_cap(made_picture_pixel(&p, 32, 32)) == cases[i].middle);
        float near = stp_renderer_depth(p.renderer)[32 * PICTURE_SIDE + 32];
        float at_plane = (float)(1e-4 * 5.0 / 5.0), at_wall = (float)(1e-4 * 5.0 / 5.5);
        float wanted = cases[i].middle ? at_plane : cases[i].add == add_walls ? at_wall : near;
        CHECK(fabsf(near - wanted) < 1e-3f * wanted);
        p.style.ambient_occlusion = 0.05f; // works on filled pixels, too
        CHECK_EQUAL(STP_OK, made_picture_draw(&p));
        CHECK(abs(cases[i].caps - count_caps(p.pixels)) < 150);
        p.style.ambient_occlusion = 0.0f;
        p.style.caps = false;
        CHECK_EQUAL(STP_OK, made_picture_draw(&p));
        CHECK_EQUAL(0, count_caps(p.pixels));
        made_picture_end(&p);
    }
}

void test_caps_leave_out_hidden_objects(test_state* test)
{
    made_picture p;
    stp_visibility* visibility;
    CHECK(open_case(&p, add_box) && cut_at_zero(&p));
    CHECK_EQUAL(STP_OK, stp_visibility_create(p.context, p.store, &visibility));
    p.quality.visibility = visibility;
    CHECK_EQUAL(STP_OK, made_picture_draw(&p));
    CHECK_EQUAL(1024, count_caps(p.pixels));
    stp_visibility_reset(visibility, STP_SHOW_NOT);
    CHECK_EQUAL(STP_OK, made_picture_draw(&p));
    CHECK_EQUAL(0, count_caps(p.pixels));
    stp_visibility_reset(visibility, STP_SHOW);
    CHECK_EQUAL(STP_OK, made_picture_accumulate(&p));
    CHECK_EQUAL(1024, count_caps(p.pixels));
    stp_visibility_destroy(visibility);
    made_picture_end(&p);
}

void test_caps_are_the_same_on_both_backends(test_state* test)
{
    for (int i = 0; i < CASES; ++i) {
        made_gl m;
        bool failed;
        memset(&made, 0, sizeof(made));
        if (!made_gl_begin_with(&m, cases[i].add, NULL, NULL, &failed)) {
            CHECK(!failed);
            SKIP("no OpenGL");
        }
        made_picture* p = &m.picture;
        p->style.caps = true;
        CHECK(cut_at_zero(p));
        CHECK(stp_sections_add_plane(&p->view.sections, (stp_vec3d){0.7, 0, 0},
                                     (stp_vec3d){1, 0.3, 0.1}));
        p->view.eye = (stp_vec3d){2, 1, 4};
        for (int side = 1; side <= 2; ++side) {
            p->style.supersample = (uint32_t)side;
            CHECK_EQUAL(STP_OK, made_picture_draw(p));
            CHECK_EQUAL(STP_OK, made_gl_draw(&m));
            CHECK((count_caps(p->pixels) > 300) == (cases[i].caps > 0));
            CHECK(made_count_different(p->pixels, m.pixels, 3) <= 8);
        }
        made_gl_end(&m);
    }
}

static stp_vec3d random_vector(uint64_t seed, double reach)
{
    double v[3];
    for (uint64_t k = 0; k < 3; ++k) {
        v[k] = reach * (2.0 * (double)(stp_rng_hash(seed, k) >> 11) * 0x1p-53 - 1.0);
    }
    return (stp_vec3d){v[0], v[1], v[2]};
}

/// Depth of a point inside the box; negative outside.
static double depth_in_box(stp_vec3d p)
{
    return 1.0 - fmax(fmax(fabs(p.x), fabs(p.y)), fabs(p.z));
}

/// Intersection of a pixel's ray with a plane. @return false if it is not in front of the eye
static bool visit_object(const stp_view_frame* f, const stp_section_plane* plane, int x, int y,
                         stp_vec3d* point)
{
    stp_vec3d aside = stp_addd(stp_scaled(f->right, (x + 0.5 - f->center_x) / f->scale),
                               stp_scaled(f->down, (y + 0.5 - f->center_y) / f->scale));
    stp_vec3d from = f->parallel ? stp_addd(f->eye, aside) : f->eye;
    stp_vec3d along = f->parallel ? f->forward : stp_addd(f->forward, aside);
    double t = -stp_section_beyond(plane, from) / stp_dotd(plane->normal, along);
    *point = stp_addd(from, stp_scaled(along, t));
    return isfinite(t) && (t > f->near_distance);
}

/// From random eyes, also inside the solid and next to the plane, a pixel shows a cap if its point
/// of the plane is in the box.
void test_caps_lie_where_planes_cut_solids(test_state* test)
{
    made_picture p;
    stp_caps* caps;
    CHECK(open_case(&p, add_box));
    CHECK_EQUAL(STP_OK, stp_caps_create(p.context, p.store, &caps));
    uint32_t filled = 0, empty = 0;
    for (uint64_t i = 0; i < 300; ++i) {
        stp_view view = p.view;
        view.eye = random_vector(stp_rng_hash(i, 0), i % 2 == 0 ? 4.0 : 1.2);
        view.target = random_vector(stp_rng_hash(i, 1), 1.0);
        view.fov_degrees = 20.0 + (double)(i % 100);
        view.ortho_height = i % 5 == 0 ? 4.0 : 0.0;
        stp_view_frame f;
        stp_cap_picture picture;
        CHECK(stp_sections_add_plane(&view.sections, random_vector(stp_rng_hash(i, 2), 0.9),
                                     random_vector(stp_rng_hash(i, 3), 1.0)));
        CHECK(stp_view_frame_make(&view, &f));
        f.near_distance = f.parallel ? f.near_distance : 1e-4;
        const stp_section_plane* plane = &view.sections.planes[0];
        bool seen = f.parallel ? stp_dotd(plane->normal, f.forward) < 0.0
                               : stp_section_beyond(plane, f.eye) > 0.0;
        stp_cap_depth depth = {f.parallel ? -0.001 : 1.0, f.parallel ? 1.0 : 0.0};
        CHECK_EQUAL(STP_OK, stp_caps_find(caps, &view.sections, NULL));
        CHECK_EQUAL(STP_OK, stp_caps_fill(caps, &f, false, &depth, &picture));
        for (int y = 0; y < PICTURE_SIDE; ++y) {
            for (int x = 0; x < PICTURE_SIDE; ++x) {
                stp_vec3d point;
                bool meets = seen && visit_object(&f, plane, x, y, &point);
                double within = meets ? depth_in_box(point) : -1.0;
                bool cap = picture.any && picture.nearness[y * PICTURE_SIDE + x] > 0.0f;
                CHECK(cap || within < 1e-4);
                CHECK(!cap || within > -1e-4);
                filled += cap ? 1 : 0;
                empty += cap ? 0 : 1;
            }
        }
    }
    CHECK(filled > 20000 && empty > 20000);
    stp_caps_destroy(caps);
    made_picture_end(&p);
}
