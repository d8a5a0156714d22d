// SPDX-License-Identifier: MIT
// Point trees and their sequences (src/lod/spt), against hand-computed disks and against the
// recursive traversal.
#include "tests.h"

#include "base/math/rng.h"
#include "base/splats/octahedral.h"
#include "base/splats/splat_codes.h"
#include "lod/spt/sequence.h"
#include "lod/spt/split_errors.h"

#include <stdlib.h>
#include <string.h>

static float unit(uint64_t seed, uint64_t at)
{
    return (float)stp_rng_below(seed, at, 1 << 20) / (float)(1 << 20);
}

static bool is_near(float a, double b, double tolerance)
{
    return fabs((double)a - b) <= tolerance;
}

void test_spt_disks_have_the_errors_of_the_paper(test_state* test)
{
    static const float weights[] = {1, 1, 1, 1};
    const stp_vec3 up = {0, 0, 1}, right = {1, 0, 0};
    // two disks in one plane, 3 apart: enclosed by one of radius 2.5, whose diameter exceeds theirs
    // by 2 x 2.5 - 2 = 3 on one axis
    stp_tree_disk flat[] = {{{0, 0, 0}, up, 1}, {{3, 0, 0}, up, 1}};
    stp_tree_disk disk = stp_disk_enclose(flat, weights, 2);
    CHECK(is_near(disk.radius, 2.5, 1e-5) && is_near(disk.center.x, 1.5, 1e-5));
    stp_disk_error error = stp_disk_measure(&disk, flat, 2);
    CHECK(is_near(error.perpendicular, 0.0, 1e-6));
    CHECK(is_near(error.tangential, 3.0, 1e-4));
    CHECK(is_near(error.geometric, 3.0, 1e-4));
    // one of them half a unit higher: the enclosing planes are half a unit apart
    flat[1].center.z = 0.5f;
    disk = stp_disk_enclose(flat, weights, 2);
    error = stp_disk_measure(&disk, flat, 2);
    CHECK(is_near(disk.center.z, 0.25, 1e-6) && is_near(error.perpendicular, 0.5, 1e-6));
    CHECK(is_near(error.geometric, sqrt(0.25 + 9.0), 1e-4));
    // perpendicular disks: the normal is half way between theirs, and each extends r sin 45 degrees
    // to either side of the plane
    stp_tree_disk corner[] = {{{0, 0, 0}, up, 1}, {{0, 0, 0}, right, 1}};
    disk = stp_disk_enclose(corner, weights, 2);
    error = stp_disk_measure(&disk, corner, 2);
    CHECK(is_near(disk.normal.x, sqrt(0.5), 1e-6) && is_near(disk.normal.z, sqrt(0.5), 1e-6));
    CHECK(is_near(error.perpendicular, 2.0 * sqrt(0.5), 1e-5));
    // four around a square: the enclosing disk extends from the middle to their far sides
    stp_tree_disk square[] = {
        {{0, 0, 0}, up, 1}, {{2, 0, 0}, up, 1}, {{0, 2, 0}, up, 1}, {{2, 2, 0}, up, 1}};
    disk = stp_disk_enclose(square, weights, 4);
    CHECK(is_near(disk.radius, 1.0 + sqrt(2.0), 0.02));
    error = stp_disk_measure(&disk, square, 4);
    CHECK(is_near(error.tangential, 2.0 * (double)disk.radius - 4.0, 1e-3));
    // normals that cancel out, or no normals: a sphere, with its diameter as error
    stp_tree_disk apart[] = {{{0, 0, 0}, up, 1}, {{0, 0, 2}, {0, 0, -1}, 1}};
    disk = stp_disk_enclose(apart, weights, 2);
    error = stp_disk_measure(&disk, apart, 2);
    CHECK(stp_length(disk.normal) == 0.0f && is_near(disk.radius, 2.0, 1e-5));
    CHECK(is_near(error.geometric, 4.0, 1e-5) && error.perpendicular == error.tangential);
    // far from the origin, where floats are coarser than the disk
    stp_tree_disk far[] = {{{1000000.0f, 0, 0}, up, 0}, {{1000000.0625f, 0, 0}, up, 0}};
    disk = stp_disk_enclose(far, weights, 2);
    CHECK(disk.radius >=
          fmaxf(fabsf(disk.center.x - far[0].center.x), fabsf(disk.center.x - far[1].center.x)));
    // a child inside another
    stp_tree_disk inner[] = {{{0, 0, 0}, up, 3}, {{1, 0, 0}, up, 1}};
    disk = stp_disk_enclose(inner, weights, 2);
    CHECK(is_near(disk.radius, 3.0, 0.05));
}

void test_spt_disks_enclose_their_children(test_state* test)
{
    for (uint64_t seed = 0; seed < 3000; ++seed) {
        stp_tree_disk children[STP_DISK_CHILDREN];
        float weights[STP_DISK_CHILDREN];
        uint32_t count = 1 + stp_rng_below(seed, 0, STP_DISK_CHILDREN);
        for (uint32_t i = 0; i < count; ++i) {
            uint64_t at = 10 * i + 1;
            stp_vec3 normal = {unit(seed, at) - 0.5f, unit(seed, at + 1) - 0.5f,
                               unit(seed, at + 2) + (seed % 3 == 0 ? -0.5f : 0.5f)};
            children[i] = (stp_tree_disk){
                .center = {unit(seed, at + 3), unit(seed, at + 4), unit(seed, at + 5) * 0.2f},
                .normal = stp_normalize(normal),
                .radius = 0.3f * unit(seed, at + 6)};
            weights[i] = 1.0f + unit(seed, at + 7);
        }
        stp_tree_disk disk = stp_disk_enclose(children, weights, count);
        stp_disk_error error = stp_disk_measure(&disk, children, count);
        stp_vec3d n = stp_to_double(disk.normal);
        for (uint32_t i = 0; i < count; ++i) {
            stp_vec3d d = stp_subd(stp_to_double(children[i].center), stp_to_double(disk.center));
            double high = d.x * n.x + d.y * n.y + d.z * n.z;
            stp_vec3d beside = stp_subd(d, stp_scaled(n, high));
            double flat = sqrt(beside.x * beside.x + beside.y * beside.y + beside.z * beside.z);
            CHECK(flat + (double)children[i].radius <= (double)disk.radius * (1.0 + 1e-5) + 1e-6);
        }
        CHECK(error.perpendicular >= 0.0f && error.tangential >= 0.0f);
        CHECK(error.geometric >= error.perpendicular && error.geometric >= error.tangential);
        CHECK(error.tangential <= 2.0f * disk.radius);
    }
}

enum { POINTS = 4000 };

typedef struct cloud {
    float positions[3 * POINTS], normals[3 * POINTS];
    uint8_t colors[3 * POINTS];
    stp_tree_points points;
} cloud;

/// Points on a wavy floor, on a ball above it, and some coincident ones.
static void fill(cloud* c, uint64_t seed, uint32_t count)
{
    for (uint32_t i = 0; i < count; ++i) {
        float *p = c->positions + 3 * (size_t)i, *n = c->normals + 3 * (size_t)i;
        stp_vec3 at = {4.0f * unit(seed, 5 * i) - 2.0f, 0.0f, 4.0f * unit(seed, 5 * i + 1) - 2.0f};
        stp_vec3 normal = {0, 1, 0};
        if (i % 3 == 0) {
            normal =
                stp_normalize((stp_vec3){unit(seed, 5 * i + 2) - 0.5f, unit(seed, 5 * i + 3) - 0.5f,
                                         unit(seed, 5 * i + 4) - 0.5f});
            at = stp_add((stp_vec3){0, 1, 0}, stp_scale(normal, 0.5f));
        } else {
            at.y = 0.02f * (float)(stp_rng_below(seed, 5 * i + 2, 3));
        }
        if (i % 97 == 0) {
            at = (stp_vec3){1, 1, 1};
        }
        memcpy(p, &at, sizeof(at));
        memcpy(n, &normal, sizeof(normal));
        c->colors[3 * (size_t)i] = at.x > 0.0f ? 200 : 190;
        c->colors[3 * (size_t)i + 1] = 100;
        c->colors[3 * (size_t)i + 2] = at.z > 1.0f ? 255 : 0;
    }
    c->points = (stp_tree_points){.count = count,
                                  .positions = c->positions,
                                  .normals = c->normals,
                                  .colors = c->colors,
                                  .radius = 0.03f};
}

static bool tree_is_sound(const stp_point_tree* t, const stp_tree_points* points)
{
    uint32_t leaves = 0;
    uint8_t* seen = calloc(points->count, 1);
    bool sound = seen != NULL && t->count > 0 && t->ends[0] == t->count;
    for (uint32_t node = 0; node < t->count && sound; ++node) {
        if (t->ends[node] == node + 1) {
            sound = t->points[node] < points->count && seen[t->points[node]]++ == 0 &&
                    t->errors[node] == 0.0f;
            leaves += 1;
            continue;
        }
        uint32_t children = 0;
        for (uint32_t c = node + 1; c < t->ends[node] && sound; c = t->ends[c]) {
            sound = t->ends[c] <= t->ends[node] && t->errors[c] <= t->errors[node] &&
                    t->disks[c].radius <= t->disks[node].radius * 1.0001f;
            children += 1;
        }
        sound = sound && children >= 2 && children <= 8 && t->points[node] == UINT32_MAX;
    }
    free(seen);
    return sound && leaves == points->count && leaves == t->leaf_count;
}

void test_spt_trees_are_sound(test_state* test)
{
    static cloud c;
    stp_context* context = test_context(NULL, 1, NULL);
    static const uint32_t counts[] = {1, 2, 3, 100, POINTS};
    for (size_t i = 0; i < sizeof(counts) / sizeof(counts[0]); ++i) {
        for (int mode = 0; mode < 3; ++mode) {
            stp_tree_desc desc = {.error = mode == 1 ? STP_TREE_DIAMETER : STP_TREE_GEOMETRIC,
                                  .color_threshold = mode == 2 ? 20 : 255};
            stp_point_tree tree, again;
            fill(&c, i, counts[i]);
            CHECK_EQUAL(STP_OK, stp_point_tree_make(context, &c.points, &desc, &tree));
            CHECK(tree_is_sound(&tree, &c.points));
            CHECK_EQUAL(STP_OK, stp_point_tree_make(context, &c.points, &desc, &again));
            CHECK(memcmp(tree.errors, again.errors, tree.count * sizeof(float)) == 0);
            stp_point_tree_destroy(context, &again);
            stp_point_tree_destroy(context, &tree);
        }
    }
    stp_point_tree tree;
    stp_tree_points none = {.count = 0};
    CHECK_EQUAL(STP_ERROR_ARGUMENT,
                stp_point_tree_make(context, &none, &(stp_tree_desc){0}, &tree));
    stp_context_destroy(context);
}

// A fine checker of black and white, seen from far away, is as bright as half of the light.
void test_spt_averages_light(test_state* test)
{
    enum { SIDE = 32 };
    static float positions[3 * SIDE * SIDE];
    static uint8_t colors[3 * SIDE * SIDE];
    for (int i = 0; i < SIDE * SIDE; ++i) {
        positions[3 * i] = (float)(i % SIDE);
        positions[3 * i + 1] = (float)(i / SIDE);
        memset(colors + 3 * (size_t)i, (i % SIDE + i / SIDE) % 2 == 0 ? 255 : 0, 3);
    }
    stp_context* context = test_context(NULL, 1, NULL);
    const stp_tree_points points = {
        .count = SIDE * SIDE, .positions = positions, .colors = colors, .radius = 0.5f};
    stp_point_tree tree;
    CHECK_EQUAL(STP_OK, stp_point_tree_make(context, &points,
                                            &(stp_tree_desc){.color_threshold = 255}, &tree));
    CHECK_EQUAL(188, tree.colors[0]); // half of the light; half of the codes would be 128
    stp_point_tree_destroy(context, &tree);
    stp_context_destroy(context);
}

/// All points at one place, and unknown normals.
void test_spt_trees_of_coincident_points(test_state* test)
{
    static const float positions[3 * 50] = {0};
    stp_context* context = test_context(NULL, 1, NULL);
    stp_tree_points points = {.count = 50, .positions = positions, .radius = 0.5f};
    stp_point_tree tree;
    CHECK_EQUAL(STP_OK, stp_point_tree_make(context, &points,
                                            &(stp_tree_desc){.color_threshold = 255}, &tree));
    CHECK(tree_is_sound(&tree, &points));
    CHECK(is_near(tree.disks[0].radius, 0.5, 1e-4) && is_near(tree.errors[0], 1.0, 1e-4));
    stp_point_tree_destroy(context, &tree);
    stp_context_destroy(context);
}

/// The nearest and farthest depth of a tree's nodes, by their centres.
static void find_distances(const stp_point_tree* tree, stp_vec3d eye, double* nearest,
                           double* farthest)
{
    *nearest = HUGE_VAL;
    *farthest = 0.0;
    for (uint32_t i = 0; i < tree->count; ++i) {
        stp_vec3d d = stp_subd(stp_to_double(tree->disks[i].center), eye);
        double distance = sqrt(d.x * d.x + d.y * d.y + d.z * d.z);
        *nearest = fmin(*nearest, distance);
        *farthest = fmax(*farthest, distance);
    }
}

/// The sequence selects the nodes of the traversal, plus only nodes whose parent or child is
/// selected too.
void test_spt_sequences_select_what_the_traversal_does(test_state* test)
{
    static cloud c;
    static uint32_t nodes[2 * POINTS], sequential[2 * POINTS];
    static uint8_t taken[2 * POINTS];
    const double max_allowed = 1.0 / 64;
    stp_context* context = test_context(NULL, 1, NULL);
    stp_point_tree tree;
    stp_point_sequence sequence;
    stp_tree_desc desc = {.color_threshold = 255};
    fill(&c, 7, POINTS);
    CHECK_EQUAL(STP_OK, stp_point_tree_make(context, &c.points, &desc, &tree));
    CHECK_EQUAL(STP_OK, stp_point_sequence_make(context, &tree, max_allowed, false, &sequence));
    for (uint32_t i = 1; i < sequence.count; ++i) {
        CHECK(sequence.highest[i] <= sequence.highest[i - 1]);
    }
    uint64_t more = 0, all = 0;
    for (uint64_t view_seed = 0; view_seed < 1500; ++view_seed) {
        float away = powf(10.0f, 3.0f * unit(view_seed, 0) - 1.0f);
        stp_tree_view view = {.eye = {(double)(away * (unit(view_seed, 1) - 0.5f)),
                                      (double)(away * (unit(view_seed, 2) - 0.5f)),
                                      (double)(away * (unit(view_seed, 3) - 0.5f))},
                              .allowed =
                                  max_allowed * (double)(0.01f + 0.99f * unit(view_seed, 4))};
        double nearest, farthest;
        find_distances(&tree, view.eye, &nearest, &farthest);
        uint32_t count = stp_point_tree_traverse(&tree, &view, nodes);
        stp_sequence_range range =
            stp_point_sequence_range(&sequence, view.allowed, nearest, farthest);
        uint32_t found = stp_point_sequence_select(&sequence, &view, range, sequential);
        stp_sequence_range whole = {0, sequence.count};
        CHECK_EQUAL(found, stp_point_sequence_select(&sequence, &view, whole, sequential));
        memset(taken, 0, tree.count);
        for (uint32_t i = 0; i < found; ++i) {
            taken[sequential[i]] = 1;
        }
        for (uint32_t i = 0; i < count; ++i) {
            CHECK(taken[nodes[i]] == 1);
            taken[nodes[i]] = 2;
        }
        // additional nodes lie below a node of the traversal: the two overlap
        for (uint32_t i = 0, end = 0; i < tree.count; ++i) {
            end = taken[i] == 2 ? tree.ends[i] : end;
            CHECK(taken[i] != 1 || i < end);
        }
        more += found - count;
        all += count;
    }
    CHECK(more * 2 < all); // and there are few
    stp_point_sequence_destroy(context, &sequence);
    stp_point_tree_destroy(context, &tree);
    stp_context_destroy(context);
}

/// A sequence with split errors: what a set stores of each node.
typedef struct split_sequence {
    stp_node_splat splats[2 * POINTS]; ///< only their normals
    uint32_t errors[2 * POINTS], ranges[2 * POINTS];
} split_sequence;

static void make_split(stp_context* context, const stp_point_tree* tree, double max_allowed,
                       split_sequence* s)
{
    for (uint32_t i = 0; i < tree->count; ++i) {
        stp_octahedral_encode(tree->disks[i].normal, s->splats[i].normal);
    }
    s->ranges[0] = stp_range_code(tree->errors[0], HUGE_VALF);
    for (uint32_t i = 0; i < tree->count; ++i) {
        for (uint32_t k = i + 1; k < tree->ends[i]; k = tree->ends[k]) {
            float highest =
                stp_point_sequence_highest(tree, i, k, stp_split_overlap(tree, i) * max_allowed);
            s->ranges[k] = stp_range_code(tree->errors[k], highest);
        }
    }
    stp_split_errors_make(context, tree, s->splats, max_allowed, s->errors);
}

/// Whether a node's own errors are small enough in a view, and its parent's too large.
typedef struct split_tests {
    bool own, parent;
} split_tests;

static split_tests test_node(const split_sequence* s, const stp_point_tree* tree, uint32_t node,
                             const stp_tree_view* view)
{
    stp_vec3d d = stp_subd(view->eye, stp_to_double(tree->disks[node].center));
    stp_vec3 sight = {(float)d.x, (float)d.y, (float)d.z};
    float level = (float)(view->allowed * sqrt(d.x * d.x + d.y * d.y + d.z * d.z));
    uint32_t code = s->errors[node];
    const int8_t* own = s->splats[node].normal;
    float lowest =
        stp_error_share(code & 15u, code >> 4 & 15u, stp_octahedral_decode(own[0], own[1]), sight);
    float highest =
        stp_error_share(code >> 8 & 15u, code >> 12 & 15u,
                        stp_octahedral_decode((int8_t)(code >> 16), (int8_t)(code >> 24)), sight);
    return (split_tests){level >= lowest * stp_range_level(s->ranges[node] & 0xFFFFu),
                         level <= highest * stp_range_level(s->ranges[node] >> 16)};
}

// With split errors, each node tests its own errors and its parent's alone. On each way from the
// root, the topmost node whose own errors are small enough passes, from any place: there are no
// holes.
void test_spt_split_sequences_select_what_the_traversal_does(test_state* test)
{
    static cloud c;
    static split_sequence s;
    static uint32_t nodes[2 * POINTS];
    const double max_allowed = 1.0 / 64;
    stp_context* context = test_context(NULL, 1, NULL);
    stp_point_tree tree;
    stp_tree_desc desc = {.color_threshold = 255};
    fill(&c, 7, POINTS);
    CHECK_EQUAL(STP_OK, stp_point_tree_make(context, &c.points, &desc, &tree));
    make_split(context, &tree, max_allowed, &s);
    uint64_t topmost = 0, more = 0, split = 0, unified = 0;
    for (uint64_t seed = 0; seed < 400; ++seed) {
        float away = powf(10.0f, 3.0f * unit(seed, 0) - 1.0f);
        stp_tree_view view = {.eye = {(double)(away * (unit(seed, 1) - 0.5f)),
                                      (double)(away * (unit(seed, 2) - 0.5f)),
                                      (double)(away * (unit(seed, 3) - 0.5f))},
                              .allowed = max_allowed * (double)(0.01f + 0.99f * unit(seed, 4))};
        for (uint32_t i = 0, end = 0; i < tree.count; ++i) {
            split_tests tests = test_node(&s, &tree, i, &view);
            if (i >= end && tests.own) {
                CHECK(tests.parent);
                end = tree.ends[i];
                topmost += 1;
            } else if (tests.own && tests.parent) { // below another
                CHECK(i < end);
                more += 1;
            }
        }
        unified += stp_point_tree_traverse(&tree, &view, nodes);
        view.split = true;
        split += stp_point_tree_traverse(&tree, &view, nodes);
    }
    CHECK(topmost < split + split / 20 && topmost + more < unified);
    stp_point_tree_destroy(context, &tree);
    stp_context_destroy(context);
}

// Shares are rounded up, and the root has all of them.
void test_spt_shares_of_errors_never_shrink(test_state* test)
{
    const stp_vec3 up = {0, 0, 127}, along = {3, 4, 0}, above = {0, 0, -2}, none = {0, 0, 0};
    for (uint32_t code = 0; code <= STP_ERROR_SHARE_WHOLE; ++code) {
        double share = (double)(code + STP_ERROR_SHARE_FIRST) / STP_ERROR_STEPS;
        CHECK_EQUAL(code, stp_error_share_code(STP_ERROR_STEPS * share - 0.01));
        CHECK(is_near(stp_error_share(code, 0, up, along), share, 1e-6));
        CHECK(is_near(stp_error_share(0, code, up, above), share, 1e-6));
        CHECK(is_near(stp_error_share(0, code, up, none), share, 1e-6)); // the eye is there
    }
    CHECK_EQUAL(0, stp_error_share_code(0.0));
    CHECK_EQUAL(STP_ERROR_SHARE_WHOLE, stp_error_share_code(1.5 * STP_ERROR_STEPS));
    for (int i = 0; i <= 90; ++i) { // two whole shares are the whole error in all views
        double angle = 3.14159265358979 / 180.0 * i;
        stp_vec3 sight = {(float)cos(angle), 0.0f, (float)sin(angle)};
        CHECK(stp_error_share(STP_ERROR_SHARE_WHOLE, STP_ERROR_SHARE_WHOLE, up, sight) == 1.0f);
        CHECK(stp_error_share(0, 0, up, sight) >= 0.2499f);
    }
}

void test_spt_split_errors_take_fewer_nodes(test_state* test)
{
    static cloud c;
    static uint32_t nodes[2 * POINTS];
    stp_context* context = test_context(NULL, 1, NULL);
    stp_point_tree tree, by_diameter;
    fill(&c, 3, POINTS);
    CHECK_EQUAL(STP_OK, stp_point_tree_make(context, &c.points,
                                            &(stp_tree_desc){.color_threshold = 255}, &tree));
    CHECK_EQUAL(STP_OK,
                stp_point_tree_make(context, &c.points, &(stp_tree_desc){STP_TREE_DIAMETER, 255},
                                    &by_diameter));
    for (int i = 1; i < 30; ++i) {
        stp_tree_view view = {.eye = {0, 3.0 * i, 1}, .allowed = 0.002};
        uint32_t unified = stp_point_tree_traverse(&tree, &view, nodes);
        uint32_t qsplat = stp_point_tree_traverse(&by_diameter, &view, nodes);
        view.split = true;
        uint32_t split = stp_point_tree_traverse(&tree, &view, nodes);
        CHECK(split <= unified && unified <= qsplat);
    }
    stp_point_tree_destroy(context, &tree);
    stp_point_tree_destroy(context, &by_diameter);
    stp_context_destroy(context);
}

void test_spt_survives_failing_allocator(test_state* test)
{
    static cloud c;
    fill(&c, 1, 200);
    int failures = 0;
    for (int n = 0;; ++n) {
        test_heap heap = TEST_HEAP(n);
        test_log log = {0};
        stp_context* context = test_context(&heap, 1, &log);
        stp_point_tree tree = {0};
        stp_point_sequence sequence = {0};
        stp_result result = context == NULL ? STP_ERROR_OUT_OF_MEMORY : STP_OK;
        if (result == STP_OK) {
            result = stp_point_tree_make(context, &c.points, &(stp_tree_desc){0}, &tree);
        }
        if (result == STP_OK) {
            result = stp_point_sequence_make(context, &tree, 0.01, false, &sequence);
            stp_point_sequence_destroy(context, &sequence);
            stp_point_tree_destroy(context, &tree);
        }
        if (context != NULL) {
            stp_context_destroy(context);
        }
        CHECK_EQUAL(0, heap.live_bytes);
        if (result == STP_OK) {
            break;
        }
        CHECK_EQUAL(STP_ERROR_OUT_OF_MEMORY, result);
        failures += 1;
    }
    CHECK(failures > 10);
}
