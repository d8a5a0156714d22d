// SPDX-License-Identifier: MIT
// Method stochastic: the octree, its leaves' normals, and sets (src/lod/stochastic), against brute
// force.
#include "tests.h"

#include "base/math/rng.h"
#include "base/splats/leaf_codes.h"
#include "base/splats/leaf_runs.h"
#include "base/splats/leaf_tree.h"
#include "base/splats/octahedral.h"
#include "lod/set_columns.h"
#include "lod/stochastic/leaf_passes.h"
#include "lod/stochastic/scatter.h"
#include "lod/stochastic/set.h"

#include <string.h>

enum { POINTS = 6000 };

static double unit(uint64_t seed, uint64_t index)
{
    return (double)(stp_rng_hash(seed, index) >> 11) * 0x1p-53;
}

typedef enum cloud_kind { BALL, CUBE, SHEETS, CROWD, CLOUD_KINDS } cloud_kind;

typedef struct cloud {
    stp_candidates candidates;
    float positions[3 * POINTS], normals[3 * POINTS];
    float truth[3 * POINTS]; ///< normals of a block
    uint8_t colors[4 * POINTS];
    uint32_t materials[POINTS];
    uint16_t intensities[POINTS]; ///< intensity of point i: i
    double times[POINTS];         ///< and 0.5 i
} cloud;

/// True outward direction at a point of a ball or a cube; for sheets, away from the plane between
/// them.
static stp_vec3 outwards(cloud_kind kind, const float* p)
{
    if (kind == SHEETS) {
        return (stp_vec3){0, p[1] > 0.0f ? 1.0f : -1.0f, 0};
    }
    if (kind == BALL) {
        return stp_normalize((stp_vec3){p[0], p[1], p[2]});
    }
    int widest = fabsf(p[1]) > fabsf(p[0]) ? 1 : 0;
    widest = fabsf(p[2]) > fabsf(p[widest]) ? 2 : widest;
    float n[3] = {0};
    n[widest] = p[widest] > 0.0f ? 1.0f : -1.0f;
    return (stp_vec3){n[0], n[1], n[2]};
}

/// Most points of a crowd lie at a few places.
static void make_cloud(cloud* c, cloud_kind kind, uint64_t seed)
{
    c->candidates = (stp_candidates){
        .count = POINTS,
        .positions = c->positions,
        .normals = c->normals,
        .colors = c->colors,
        .materials = c->materials,
        .attributes = {[STP_ATTRIBUTE_INTENSITY] = c->intensities, [STP_ATTRIBUTE_TIME] = c->times},
        .origin = {3.0, 0.0, -2.0}};
    for (uint64_t i = 0; i < POINTS; ++i) {
        double x = 2.0 * unit(seed, 4 * i) - 1.0, y = 2.0 * unit(seed, 4 * i + 1) - 1.0;
        double z = 2.0 * unit(seed, 4 * i + 2) - 1.0;
        stp_vec3d p = {x, y, z};
        if (kind == BALL) {
            p = stp_normalized(p);
        } else if (kind == CUBE) {
            uint64_t face = stp_rng_hash(seed, 4 * i + 3) % 6;
            double* axes[3] = {&p.x, &p.y, &p.z};
            *axes[face / 2] = face % 2 == 0 ? 1.0 : -1.0;
        } else if (kind == SHEETS) {
            p.y = y > 0.0
                      ? 0.15
                      : -0.15; // closer than the width of leaves with the maximum number of points
        } else if (i % 4 != 0) {
            p = (stp_vec3d){x > 0.0 ? 0.5 : -0.5, 0.25, 0.0};
        }
        stp_vec3 f = stp_to_float(p);
        memcpy(c->positions + 3 * i, &f, sizeof(f));
        memcpy(c->normals + 3 * i, &(stp_vec3){0, 1, 0}, sizeof(f));
        c->colors[4 * i] = (uint8_t)i;
        c->colors[4 * i + 1] = (uint8_t)(i >> 8);
        c->colors[4 * i + 2] = 7;
        c->colors[4 * i + 3] = 255;
        c->materials[i] = 1;
        c->intensities[i] = (uint16_t)i;
        c->times[i] = 0.5 * (double)i;
    }
}

static const uint8_t shadings[2] = {0, 3};

static stp_result make_set(stp_context* context, cloud* c, uint32_t wanted, stp_splats* set)
{
    const stp_leaf_desc desc = {.budget = 300,
                                .minimum = 20,
                                .flatness = 0.005f,
                                .neighbours = 12,
                                .normal_neighbours = 20,
                                .sample = 400};
    const stp_stochastic_source source = {
        .candidates = &c->candidates, .shading_of_material = shadings, .wanted = wanted};
    return stp_stochastic_make_set(context, &source, &desc, set);
}

/// The point of a splat. @return POINTS if its attributes are those of another point
static uint32_t point_of(const stp_splats* s, uint32_t splat)
{
    uint32_t point = s->colors[3 * (size_t)splat] | (uint32_t)s->colors[3 * (size_t)splat + 1] << 8;
    const uint16_t* intensities = s->attributes[STP_ATTRIBUTE_INTENSITY];
    const double* times = s->attributes[STP_ATTRIBUTE_TIME];
    return intensities[splat] == point && times[splat] == 0.5 * (double)point ? point : POINTS;
}

/// Whether a cube with these points must be divided.
static bool is_divided(const uint16_t* at, const uint32_t* order, uint32_t begin, uint32_t end,
                       const stp_leaf_desc* desc)
{
    stp_scatter scatter = {0};
    for (uint32_t i = begin; i < end; ++i) {
        const uint16_t* p = at + 3 * (size_t)order[i];
        stp_scatter_add(&scatter, (double)p[0], (double)p[1], (double)p[2]);
    }
    double matrix[6];
    stp_scatter_matrix(&scatter, matrix);
    uint32_t count = end - begin;
    return count > desc->budget ||
           (count > desc->minimum && !stp_scatter_is_flat(matrix, (double)desc->flatness));
}

void test_leaf_octree_divides_what_it_should(test_state* test)
{
    static uint16_t at[3 * POINTS];
    static bool met[POINTS];
    stp_context* context = test_context(NULL, 1, NULL);
    CHECK(context != NULL);
    for (uint64_t seed = 0; seed < 6; ++seed) {
        for (uint64_t i = 0; i < 3 * POINTS; ++i) { // a bent sheet, a plane, all at a few places
            double x = unit(seed, i - i % 3), z = unit(seed, i - i % 3 + 1);
            double y = seed % 3 == 0 ? 0.2 * x * x + 0.1 * z : 0.3 * x + 0.2 * z;
            double v = i % 3 == 0 ? x : i % 3 == 1 ? y : z;
            at[i] = (uint16_t)(seed % 3 == 2 ? 1000.0 * floor(3.0 * v) : 60000.0 * v);
        }
        const stp_leaf_desc desc = {
            .budget = 200, .minimum = 12, .flatness = 0.002f, .sample = 200};
        stp_leaf_octree o;
        CHECK_EQUAL(STP_OK, stp_leaf_octree_make(context, at, POINTS, &desc, seed, &o));
        uint64_t next = 0;
        memset(met, 0, sizeof(met));
        for (uint32_t l = 0; l < o.leaf_count; ++l) {
            const stp_leaf_cell* leaf = &o.leaves[l];
            CHECK_EQUAL(l > 0 ? o.leaves[l - 1].end : 0, leaf->begin);
            CHECK(leaf->end > leaf->begin && stp_leaf_morton(leaf->corner) >= next);
            next = stp_leaf_morton(leaf->corner) + (UINT64_C(1) << 3 * (16 - leaf->depth));
            uint32_t width = stp_leaf_width(leaf->depth);
            for (uint32_t i = leaf->begin; i < leaf->end; ++i) {
                CHECK(!met[o.order[i]]);
                met[o.order[i]] = true;
                for (int k = 0; k < 3; ++k) {
                    uint32_t v = at[3 * (size_t)o.order[i] + (size_t)k];
                    CHECK(v >= leaf->corner[k] && v < leaf->corner[k] + width);
                }
            }
            CHECK(leaf->depth == 16 || !is_divided(at, o.order, leaf->begin, leaf->end, &desc));
            uint32_t first = l, last = l; // the leaves of the cube above
            for (; leaf->depth > 0 && first > 0 &&
                   stp_leaf_morton(o.leaves[first - 1].corner) >> 3 * (17 - leaf->depth) ==
                       stp_leaf_morton(leaf->corner) >> 3 * (17 - leaf->depth);
                 --first) {
            }
            for (; leaf->depth > 0 && last + 1 < o.leaf_count &&
                   stp_leaf_morton(o.leaves[last + 1].corner) >> 3 * (17 - leaf->depth) ==
                       stp_leaf_morton(leaf->corner) >> 3 * (17 - leaf->depth);
                 ++last) {
            }
            uint32_t all = o.leaves[last].end - o.leaves[first].begin;
            CHECK(leaf->depth == 0 || all > desc.sample || // where a sample of points decided
                  is_divided(at, o.order, o.leaves[first].begin, o.leaves[last].end, &desc));
        }
        CHECK_EQUAL(POINTS, o.leaves[o.leaf_count - 1].end);
        stp_leaf_octree_destroy(context, &o);
    }
    stp_context_destroy(context);
}

// Octaves and runs of leaves against the list of all splats, position by position.
void test_leaf_runs_are_those_of_the_row(test_state* test)
{
    for (uint32_t count = 1; count < 6000; count += 1 + count / 3) {
        uint32_t octaves = stp_leaf_octaves(count), next[16] = {0}, total = 0;
        CHECK(octaves == 1 ||
              (count >> 2 * (octaves - 1) >= 16 && count >> 2 * (octaves - 1) < 64));
        for (uint32_t k = 1; k < octaves; ++k) {
            next[k] = stp_leaf_until(count, k - 1, octaves);
        }
        for (uint32_t first = 0; first < count;) {
            uint32_t last = first + 1 + (uint32_t)(stp_rng_hash(count, first) % 90);
            last = last < count ? last : count;
            for (uint32_t k = 0; k < octaves; ++k) {
                uint32_t mine = 0;
                for (uint32_t i = first; i < last; ++i) {
                    mine += stp_leaf_octave_of(i + 1, octaves) == k ? 1 : 0;
                }
                stp_leaf_run run = stp_leaf_run_of(first, last, k, octaves, count);
                CHECK_EQUAL(next[k], run.begin);
                CHECK_EQUAL(next[k] + mine, run.end);
                next[k] = run.end;
                total += mine;
            }
            first = last;
        }
        CHECK_EQUAL(count, total);
        for (uint32_t k = 0; k < octaves; ++k) {
            CHECK_EQUAL(stp_leaf_until(count, k, octaves), next[k]);
        }
    }
}

void test_leaf_codes_keep_their_order(test_state* test)
{
    for (int i = 1; i < 4000; ++i) {
        float f = (float)i / 12000.0f;
        float back = stp_leaf_flatness(stp_leaf_flatness_code(f));
        CHECK(back <= f && back > 0.88f * f);
    }
    CHECK(stp_leaf_flatness(stp_leaf_flatness_code(0.0f)) == 0.0f);
    CHECK_EQUAL(64, stp_leaf_extent_code(1.0f));
    CHECK_EQUAL(1, stp_leaf_extent_code(0.0f));
}

/// Share of splats with an outward normal.
static double share_outwards(const stp_splats* s, cloud_kind kind)
{
    uint32_t right = 0;
    for (uint32_t i = 0; i < s->count; ++i) {
        float p[3];
        for (int k = 0; k < 3; ++k) {
            const float origin[3] = {s->origin.x - 3.0f, s->origin.y, s->origin.z + 2.0f};
            p[k] = origin[k] + s->step * (float)s->positions[3 * (size_t)i + (size_t)k];
        }
        stp_vec3 n =
            stp_octahedral_decode(s->normals[2 * (size_t)i], s->normals[2 * (size_t)i + 1]);
        right += stp_dot(n, outwards(kind, p)) > 0.0f ? 1 : 0;
    }
    return (double)right / (double)s->count;
}

// Orientation propagates from the highest leaf around balls and edges, but not between sheets that
// nearly touch.
void test_stochastic_normals_face_outwards(test_state* test)
{
    static cloud c;
    stp_context* context = test_context(NULL, 1, NULL);
    CHECK(context != NULL);
    for (uint64_t seed = 0; seed < 4; ++seed) {
        for (int kind = BALL; kind <= SHEETS; ++kind) {
            stp_splats set;
            make_cloud(&c, (cloud_kind)kind, seed);
            CHECK_EQUAL(STP_OK, make_set(context, &c, POINTS, &set));
            CHECK(share_outwards(&set, (cloud_kind)kind) > 0.99);
            stp_splats_destroy(context, &set);
        }
    }
    stp_context_destroy(context);
}

/// Points of a flat block with a slot in its top, half as wide as the slot is deep.
static void make_slotted_block(cloud* c, double height, uint64_t seed)
{
    // corner and sides of each face, and its normal
    const double h = height, deep = 0.5 * h, a = 0.25 * h;
    const struct {
        stp_vec3d corner, u, v;
        stp_vec3 normal;
    } faces[] = {
        {{-1, 0, -1}, {2, 0, 0}, {0, 0, 2}, {0, -1, 0}},
        {{-1, h, -1}, {1 - a, 0, 0}, {0, 0, 2}, {0, 1, 0}},
        {{a, h, -1}, {1 - a, 0, 0}, {0, 0, 2}, {0, 1, 0}},
        {{-a, h - deep, -1}, {2 * a, 0, 0}, {0, 0, 2}, {0, 1, 0}},
        {{-1, 0, -1}, {0, h, 0}, {0, 0, 2}, {-1, 0, 0}},
        {{1, 0, -1}, {0, h, 0}, {0, 0, 2}, {1, 0, 0}},
        {{-a, h - deep, -1}, {0, deep, 0}, {0, 0, 2}, {1, 0, 0}},
        {{a, h - deep, -1}, {0, deep, 0}, {0, 0, 2}, {-1, 0, 0}},
        {{-1, 0, -1}, {1 - a, 0, 0}, {0, h, 0}, {0, 0, -1}},
        {{a, 0, -1}, {1 - a, 0, 0}, {0, h, 0}, {0, 0, -1}},
        {{-a, 0, -1}, {2 * a, 0, 0}, {0, h - deep, 0}, {0, 0, -1}},
        {{-1, 0, 1}, {1 - a, 0, 0}, {0, h, 0}, {0, 0, 1}},
        {{a, 0, 1}, {1 - a, 0, 0}, {0, h, 0}, {0, 0, 1}},
        {{-a, 0, 1}, {2 * a, 0, 0}, {0, h - deep, 0}, {0, 0, 1}},
    };
    enum { FACES = sizeof(faces) / sizeof(faces[0]) };
    double areas[FACES], total = 0.0;
    make_cloud(c, BALL, seed);
    for (int f = 0; f < FACES; ++f) {
        areas[f] = stp_lengthd(stp_crossd(faces[f].u, faces[f].v));
        total += areas[f];
    }
    for (uint64_t i = 0; i < POINTS; ++i) {
        double at = total * unit(seed, 3 * i), s = unit(seed, 3 * i + 1), t = unit(seed, 3 * i + 2);
        int f = 0;
        for (; f < FACES - 1 && at >= areas[f]; ++f) {
            at -= areas[f];
        }
        stp_vec3 p = stp_to_float(stp_addd(
            faces[f].corner, stp_addd(stp_scaled(faces[f].u, s), stp_scaled(faces[f].v, t))));
        memcpy(c->positions + 3 * i, &p, sizeof(p));
        memcpy(c->truth + 3 * i, &faces[f].normal, sizeof(p));
    }
}

// The first oriented leaf may be as wide as the block is high.
void test_stochastic_normals_of_a_slotted_block_face_outwards(test_state* test)
{
    static cloud c;
    stp_context* context = test_context(NULL, 1, NULL);
    CHECK(context != NULL);
    for (uint64_t seed = 0; seed < 24; ++seed) {
        stp_splats set;
        make_slotted_block(&c, seed % 2 == 0 ? 1.0 : 0.6, seed);
        CHECK_EQUAL(STP_OK, make_set(context, &c, POINTS, &set));
        uint32_t right = 0;
        for (uint32_t i = 0; i < set.count; ++i) {
            const float* t = c.truth + 3 * (size_t)point_of(&set, i);
            stp_vec3 n =
                stp_octahedral_decode(set.normals[2 * (size_t)i], set.normals[2 * (size_t)i + 1]);
            right += stp_dot(n, (stp_vec3){t[0], t[1], t[2]}) > 0.0f ? 1 : 0;
        }
        CHECK(right > 0.99 * set.count);
        stp_splats_destroy(context, &set);
    }
    stp_context_destroy(context);
}

// An open cylinder has no surface that faces up.
void test_stochastic_normals_of_an_open_cylinder_face_outwards(test_state* test)
{
    static cloud c;
    stp_context* context = test_context(NULL, 1, NULL);
    CHECK(context != NULL);
    for (int axis = 0; axis < 3; ++axis) {
        stp_splats set;
        make_cloud(&c, BALL, 3);
        for (uint64_t i = 0; i < POINTS; ++i) {
            double turn = 6.2831853 * unit(7, 2 * i);
            float* p = c.positions + 3 * i;
            p[axis] = (float)(3.0 * unit(7, 2 * i + 1) - 1.5);
            p[(axis + 1) % 3] = (float)cos(turn);
            p[(axis + 2) % 3] = (float)sin(turn);
        }
        CHECK_EQUAL(STP_OK, make_set(context, &c, POINTS, &set));
        uint32_t right = 0;
        for (uint32_t i = 0; i < set.count; ++i) {
            const float* p = c.positions + 3 * (size_t)point_of(&set, i);
            stp_vec3 n =
                stp_octahedral_decode(set.normals[2 * (size_t)i], set.normals[2 * (size_t)i + 1]);
            const float normal[3] = {n.x, n.y, n.z};
            int u = (axis + 1) % 3, v = (axis + 2) % 3;
            right += normal[u] * p[u] + normal[v] * p[v] > 0.0f ? 1 : 0;
        }
        CHECK(right > 0.99 * set.count);
        stp_splats_destroy(context, &set);
    }
    stp_context_destroy(context);
}

void test_stochastic_sets_hold_every_point_once(test_state* test)
{
    static cloud c;
    static bool met[POINTS];
    stp_context* context = test_context(NULL, 1, NULL);
    CHECK(context != NULL);
    for (int kind = 0; kind < CLOUD_KINDS; ++kind) {
        stp_splats set;
        make_cloud(&c, (cloud_kind)kind, 5);
        CHECK_EQUAL(STP_OK, make_set(context, &c, POINTS, &set));
        CHECK_EQUAL(POINTS, set.count);
        CHECK(stp_splat_leaves_fault(&set, set.leaves, set.leaf_count) == NULL);
        memset(met, 0, sizeof(met));
        uint32_t place = 0;
        for (uint32_t l = 0; l < set.leaf_count; ++l) { // each run's splats lie in its leaf
            const stp_splat_leaf* leaf = &set.leaves[l];
            for (uint32_t k = 0; k < set.octave_count; ++k) {
                stp_leaf_run run =
                    stp_leaf_run_of(place, place + leaf->count, k, set.octave_count, set.count);
                for (uint32_t i = run.begin; i < run.end; ++i) {
                    uint32_t point = point_of(&set, i);
                    CHECK(point < POINTS && !met[point]);
                    met[point] = true;
                    CHECK_EQUAL(3, set.materials[i]);
                    for (int a = 0; a < 3; ++a) {
                        uint32_t v = set.positions[3 * i + (uint32_t)a];
                        uint32_t width = stp_leaf_width(stp_leaf_depth(leaf));
                        CHECK(v >= leaf->corner[a] && v < leaf->corner[a] + width);
                    }
                }
            }
            place += leaf->count;
        }
        stp_splats_destroy(context, &set);
    }
    stp_context_destroy(context);
}

// Edges are marked only near the edges of a cube. Flat leaves have about the area of their surface.
void test_stochastic_leaves_know_their_surface(test_state* test)
{
    static cloud c;
    stp_context* context = test_context(NULL, 1, NULL);
    CHECK(context != NULL);
    for (int kind = BALL; kind <= CUBE; ++kind) {
        stp_splats set;
        make_cloud(&c, (cloud_kind)kind, 9);
        CHECK_EQUAL(STP_OK, make_set(context, &c, POINTS, &set));
        double area = 0.0, edges = 0.0, wrong = 0.0;
        for (uint32_t l = 0; l < set.leaf_count; ++l) {
            const stp_splat_leaf* leaf = &set.leaves[l];
            double step = (double)set.step, width = step * stp_leaf_width(stp_leaf_depth(leaf));
            area += step * step * (double)stp_leaf_area(leaf);
            const double origin[3] = {(double)set.origin.x - 3.0, (double)set.origin.y,
                                      (double)set.origin.z + 2.0};
            int outer = 0; // axes along which the leaf touches a face
            for (int k = 0; k < 3; ++k) {
                double low = origin[k] + step * leaf->corner[k], high = low + width;
                outer += low < -0.9 || high > 0.9 ? 1 : 0;
            }
            bool edge = (leaf->place & STP_LEAF_EDGE) != 0;
            edges += edge ? 1.0 : 0.0;
            wrong += edge && outer < 2 ? 1.0 : 0.0;
        }
        double truth = kind == BALL ? 4.0 * 3.14159265 : 24.0;
        CHECK(area > 0.8 * truth && area < 1.3 * truth);
        CHECK(kind == BALL ? edges == 0.0 : edges > 10.0 && wrong == 0.0);
        stp_splats_destroy(context, &set);
    }
    stp_context_destroy(context);
}

/// Number of leaves marked as edges with a number of scales.
static uint32_t count_edges(stp_context* context, cloud* c, uint32_t scales, uint32_t* leaves)
{
    const stp_leaf_desc desc = {.budget = 300,
                                .minimum = 20,
                                .flatness = 0.005f,
                                .neighbours = 12,
                                .normal_neighbours = 20,
                                .sample = 400,
                                .scales = scales};
    const stp_stochastic_source source = {
        .candidates = &c->candidates, .shading_of_material = shadings, .wanted = POINTS};
    stp_splats set;
    uint32_t edges = 0;
    *leaves = 0;
    if (stp_stochastic_make_set(context, &source, &desc, &set) == STP_OK) {
        for (uint32_t l = 0; l < set.leaf_count; ++l) {
            edges += (set.leaves[l].place & STP_LEAF_EDGE) != 0 ? 1 : 0;
        }
        *leaves = set.leaf_count;
        stp_splats_destroy(context, &set);
    }
    return edges;
}

// At the finest scale, noise marks edges on a ball; most disappear at larger scales. Those of a
// cube stay.
void test_stochastic_features_last_over_scales(test_state* test)
{
    static cloud c;
    stp_context* context = test_context(NULL, 1, NULL);
    CHECK(context != NULL);
    uint32_t once = 0, twice = 0, sharp = 0, min_flatness = 0, leaves;
    for (uint64_t seed = 0; seed < 4; ++seed) {
        for (int kind = BALL; kind <= CUBE; ++kind) {
            make_cloud(&c, (cloud_kind)kind, seed);
            double noise = kind == BALL ? 0.06 : 0.0;
            for (uint64_t i = 0; i < 3 * POINTS; ++i) {
                c.positions[i] += (float)(noise * (unit(seed + 70, i) - 0.5));
            }
            cloud kept = c;
            uint32_t one = count_edges(context, &c, 1, &leaves);
            c = kept;
            c.candidates = kept.candidates;
            uint32_t two = count_edges(context, &c, 2, &leaves);
            CHECK(two <= one && leaves > 0);
            once += kind == BALL ? one : 0;
            twice += kind == BALL ? two : 0;
            sharp += kind == CUBE ? one : 0;
            min_flatness += kind == CUBE ? two : 0;
        }
    }
    CHECK(once > 100 && 3 * twice < once);
    CHECK(sharp > 40 && 10 * min_flatness >= 8 * sharp);
    stp_context_destroy(context);
}

/// Flatness of the points in the cube of a depth around a leaf, by testing all points.
static double flatness_around(const uint16_t* at, const stp_leaf_cell* leaf, uint32_t depth)
{
    uint32_t width = stp_leaf_width(depth);
    stp_scatter scatter = {0};
    for (uint32_t i = 0; i < POINTS; ++i) {
        const uint16_t* p = at + 3 * (size_t)i;
        bool inside = true;
        for (int k = 0; k < 3; ++k) {
            inside = inside && p[k] / width == leaf->corner[k] / width;
        }
        if (inside) {
            stp_scatter_add(&scatter, (double)p[0] - leaf->corner[0],
                            (double)p[1] - leaf->corner[1], (double)p[2] - leaf->corner[2]);
        }
    }
    double matrix[6];
    stp_scatter_matrix(&scatter, matrix);
    return stp_scatter_flatness(matrix);
}

void test_stochastic_scales_are_those_of_all_points(test_state* test)
{
    static uint16_t at[3 * POINTS];
    static float normals[3 * POINTS];
    stp_context* context = test_context(NULL, 1, NULL);
    CHECK(context != NULL);
    for (uint64_t i = 0; i < POINTS; ++i) { // a bent sheet, rough
        double x = unit(4, 3 * i), z = unit(4, 3 * i + 1),
               y = 0.3 * x * x + 0.02 * unit(4, 3 * i + 2);
        at[3 * i] = (uint16_t)(60000.0 * x);
        at[3 * i + 1] = (uint16_t)(60000.0 * y);
        at[3 * i + 2] = (uint16_t)(60000.0 * z);
    }
    const stp_leaf_desc desc = {.budget = 200, .minimum = 30, .flatness = 0.002f, .sample = 200};
    stp_leaf_octree o;
    CHECK_EQUAL(STP_OK, stp_leaf_octree_make(context, at, POINTS, &desc, 3, &o));
    static stp_leaf_properties own[POINTS], properties[POINTS];
    static stp_scatter scatters[POINTS];
    const stp_leaf_points points = {at, normals, true};
    stp_leaf_measure_planes(context, &o, &points, own, scatters);
    memcpy(properties, own, sizeof(*own) * o.leaf_count);
    stp_leaf_measure_scales(context, &o, scatters, 3, properties);
    uint32_t less = 0, ended = 0;
    for (uint32_t l = 0; l < o.leaf_count; ++l) {
        double min_flatness = (double)own[l].flatness, last = min_flatness;
        bool edge = own[l].edge;
        for (uint32_t up = 1; up < 3; ++up) {
            double next = flatness_around(at, &o.leaves[l], o.leaves[l].depth - up);
            min_flatness = fmin(min_flatness, next);
            edge = edge && next >= 0.5 * last;
            last = next;
        }
        CHECK(fabs((double)properties[l].min_flatness - min_flatness) <=
              1e-6 + 1e-4 * min_flatness);
        CHECK(properties[l].flatness == own[l].flatness && properties[l].edge == edge);
        less += properties[l].min_flatness < own[l].flatness ? 1 : 0;
        ended += own[l].edge && !edge ? 1 : 0;
    }
    CHECK(less > 10 && ended > 0);
    stp_leaf_octree_destroy(context, &o);
    stp_context_destroy(context);
}

static stp_hash hash_of(const stp_splats* s)
{
    stp_hash hash = stp_hash_bytes((stp_hash){0}, s->positions, 6 * (size_t)s->count);
    hash = stp_hash_bytes(hash, s->normals, 2 * (size_t)s->count);
    hash = stp_hash_bytes(hash, s->shapes, 4 * (size_t)s->count);
    hash = stp_hash_bytes(hash, s->colors, 3 * (size_t)s->count);
    return stp_hash_bytes(hash, s->leaves, sizeof(*s->leaves) * (size_t)s->leaf_count);
}

void test_stochastic_sets_do_not_depend_on_threads(test_state* test)
{
    static cloud c;
    for (int kind = 0; kind < CLOUD_KINDS; ++kind) {
        stp_hash first = {0};
        for (uint32_t threads = 1; threads <= 4; threads += 3) {
            stp_context* context = test_context(NULL, threads, NULL);
            CHECK(context != NULL);
            stp_splats set;
            make_cloud(&c, (cloud_kind)kind, 2);
            CHECK_EQUAL(STP_OK, make_set(context, &c, POINTS / 2, &set)); // a random half
            CHECK_EQUAL(POINTS / 2, set.count);
            for (uint32_t i = 0; i < set.count; ++i) {
                CHECK(point_of(&set, i) < POINTS);
            }
            first = threads == 1 ? hash_of(&set) : first;
            CHECK(stp_hash_equal(first, hash_of(&set)));
            stp_splats_destroy(context, &set);
            stp_context_destroy(context);
        }
    }
}

void test_stochastic_sets_survive_failing_allocator(test_state* test)
{
    static cloud c;
    bool made = false;
    for (int n = 1; !made && n < 500; ++n) {
        test_heap heap = TEST_HEAP(n);
        stp_context* context = test_context(&heap, 1, NULL);
        if (context != NULL) {
            stp_splats set;
            make_cloud(&c, CUBE, 1);
            made = make_set(context, &c, 500, &set) == STP_OK && heap.count <= n;
            stp_splats_destroy(context, &set);
        }
        stp_context_destroy(context);
        CHECK_EQUAL(0, heap.live_bytes);
    }
    CHECK(made);
}

// Sums of inner cubes, and the leaves they contain.
void test_leaf_tree_sums_up_its_leaves(test_state* test)
{
    static cloud c;
    static stp_leaf_node nodes[2 * POINTS];
    stp_context* context = test_context(NULL, 1, NULL);
    CHECK(context != NULL);
    for (int kind = 0; kind < CLOUD_KINDS; ++kind) {
        stp_splats set;
        make_cloud(&c, (cloud_kind)kind, 3);
        CHECK_EQUAL(STP_OK, make_set(context, &c, POINTS, &set));
        uint32_t count = stp_leaf_tree_make(set.leaves, set.leaf_count, nodes), leaves = 0;
        CHECK(count >= set.leaf_count && count <= stp_leaf_tree_max_nodes(set.leaf_count));
        CHECK(nodes[0].next == count && nodes[0].leaf_count == set.leaf_count);
        for (uint32_t i = 0; i < count; ++i) {
            const stp_leaf_node* node = &nodes[i];
            uint32_t width = stp_leaf_width(node->depth), splats = 0, before = 0;
            double area = 0.0, edges = 0.0, flatness = 0.0, bent_edges = 0.0, turn = 0.0;
            for (uint32_t l = 0; l < node->leaf; ++l) {
                before += set.leaves[l].count;
            }
            for (uint32_t l = node->leaf; l < node->leaf + node->leaf_count; ++l) {
                splats += set.leaves[l].count;
                double own = (double)stp_leaf_area(&set.leaves[l]);
                double edge = (set.leaves[l].place & STP_LEAF_EDGE) != 0 ? own : 0.0;
                double bent = fmin((double)stp_leaf_flatness(set.leaves[l].flatness), 0.005);
                area += own;
                edges += edge;
                flatness += own * bent;
                bent_edges += edge * bent;
                turn += own * set.leaves[l].spread / 255.0;
                for (int k = 0; k < 3; ++k) {
                    CHECK(set.leaves[l].corner[k] >= node->corner[k] &&
                          set.leaves[l].corner[k] - node->corner[k] < (int)width);
                }
            }
            CHECK_EQUAL(splats, node->count);
            CHECK_EQUAL(before, node->first);
            CHECK(node->next > i && node->next <= count);
            CHECK(fabs((double)node->area - area) < 1e-4 * area);
            CHECK(fabs((double)node->edge * area - edges) < 1e-4 * area);
            CHECK(fabs((double)node->flatness * area - flatness) < 1e-6 * area);
            CHECK(fabs((double)node->edge_flatness * edges - bent_edges) < 1e-6 * area ||
                  node->leaf_count == 1);
            CHECK(fabs((double)node->turn * area - turn) < 1e-4 * area);
            CHECK((node->leaf_count == 1) == (node->next == i + 1));
            leaves += node->leaf_count == 1 ? 1 : 0;
        }
        CHECK_EQUAL(set.leaf_count, leaves);
        stp_splats_destroy(context, &set);
    }
    stp_context_destroy(context);
}
