// SPDX-License-Identifier: MIT
#include "hierarchy_helpers.h"
#include "tests.h"

#include "base/math/math.h"
#include "base/math/rng.h"
#include "base/splats/octahedral.h"
#include "base/splats/prefix_table.h"
#include "capture/capture_internal.h"
#include "capture/splat_disks.h"
#include "lod/sources.h"

static double random_between(uint64_t seed, uint64_t at, double low, double high)
{
    return low + (high - low) * (double)(stp_rng_hash(seed, at) >> 11) * 0x1p-53;
}

void test_stretch_is_the_largest_scale(test_state* test)
{
    for (uint64_t seed = 0; seed < 200; ++seed) {
        stp_affine a = stp_affine_identity();
        for (uint64_t i = 0; i < 9; ++i) {
            a.m[i / 3][i % 3] = random_between(seed, i, -1.0, 1.0) * (seed % 3 == 0 ? 1e-6 : 1e6);
        }
        double stretch = stp_affine_stretch(&a), largest = 0.0;
        for (uint64_t i = 0; i < 3000; ++i) {
            stp_vec3d d = {random_between(seed, 10 + 3 * i, -1.0, 1.0),
                           random_between(seed, 11 + 3 * i, -1.0, 1.0),
                           random_between(seed, 12 + 3 * i, -1.0, 1.0)};
            d = stp_normalized(d);
            stp_vec3d zero = {0};
            stp_vec3d moved = stp_subd(stp_affine_point(&a, d), stp_affine_point(&a, zero));
            double length = sqrt(stp_dotd(moved, moved));
            largest = length > largest ? length : largest;
        }
        CHECK(stretch >= largest && stretch < 1.03 * largest);
    }
    stp_affine turned = {{{0, -3, 0, 9}, {3, 0, 0, 9}, {0, 0, -3, 9}}};
    CHECK(fabs(stp_affine_stretch(&turned) - 3.0) < 1e-12);
    stp_affine flat = {{{0}}};
    CHECK(stp_affine_stretch(&flat) == 0.0);
}

// Spheres: one unchanged, one mirrored, one squeezed, one inside the first.
enum { SPHERES = 4, SPLATS = 2500 };

static bool make_spheres(stp_context* context, hierarchy* h, uint32_t* root)
{
    stp_affine copies[SPHERES] = {
        scale_and_move(1, 1, 1, 0, 0, 0),
        scale_and_move(-1, 1, 1, 2.5, 0, 0),
        {{{0.5, 0.2, 0, 0}, {-0.2, 1.2, 0, 2.5}, {0, 0, 0.8, 0}}},
        scale_and_move(0.6, 0.6, 0.6, 0.1, 0.1, 0),
    };
    return hierarchy_begin(context, h, true, 12) &&
           add_copies(h, h->shape, copies, SPHERES, false, root) && hierarchy_finish(h);
}

typedef struct captured {
    hierarchy h;
    uint32_t node, child;
    stp_source_list list;
    stp_candidates candidates;
} captured;

static stp_result capture_spheres(stp_context* context, double pixel, uint64_t ids_a_pass,
                                  captured* c)
{
    uint32_t root;
    *c = (captured){0};
    if (!make_spheres(context, &c->h, &root)) {
        return STP_ERROR_OUT_OF_MEMORY;
    }
    c->child = c->h.scene->objects[c->h.shape].node;
    c->node = c->h.scene->objects[root].node;
    stp_result result = hierarchy_make(&c->h, c->child, SPLATS, 30000, NULL);
    if (result == STP_OK) {
        result = stp_list_sources(c->h.scene, c->node, c->h.sets, pixel, 1000, &c->list);
    }
    if (result == STP_OK) {
        stp_capture_sources sources = {c->list.parts, c->list.part_count, c->list.sets,
                                       c->list.set_count};
        stp_capture_desc desc = {.pixel_size = pixel};
        result = stp_capture_all_in_passes(c->h.scene, &sources, &desc, ids_a_pass, &c->candidates);
    }
    return result;
}

static void captured_destroy(captured* c)
{
    if (c->h.scene != NULL) {
        stp_context* context = c->h.scene->context;
        stp_candidates_destroy(context, &c->candidates);
        stp_source_list_destroy(context, &c->list);
        hierarchy_destroy(&c->h);
    }
}

// By brute force: each candidate is bit-identical to a splat in a listed prefix, and none occurs
// twice; the outer spheres' splats occur, as hardly anything hides them; the inner sphere's do
// not.
void test_candidates_of_sets_are_splats_once(test_state* test)
{
    stp_context* context = test_context(NULL, 2, NULL);
    captured c;
    CHECK(context != NULL);
    CHECK_EQUAL(STP_OK, capture_spheres(context, 0.2, UINT32_MAX - 1, &c));
    CHECK_EQUAL(SPHERES, c.list.set_count);
    CHECK_EQUAL(0, c.list.part_count);
    CHECK_EQUAL(c.candidates.count, c.candidates.set_count);
    uint32_t next = 0, taken[SPHERES] = {0};
    for (size_t set = 0; set < c.list.set_count; ++set) {
        const stp_placed_set* placed = &c.list.sets[set];
        stp_affine placement = placed->transform;
        placement.m[0][3] -= c.candidates.origin.x;
        placement.m[1][3] -= c.candidates.origin.y;
        placement.m[2][3] -= c.candidates.origin.z;
        stp_set_placing placing = stp_set_placing_make(placed->splats, &placement);
        stp_vec3d middle = {placement.m[0][3], placement.m[1][3], placement.m[2][3]};
        for (uint32_t i = 0; i < placed->prefix; ++i) { // candidates are in this order
            stp_vec3 at = stp_to_float(stp_set_position(&placing, i));
            const float* p = c.candidates.positions + 3 * (size_t)next;
            if (next < c.candidates.count && memcmp(p, &at, sizeof(at)) == 0) {
                const float* n = c.candidates.normals + 3 * (size_t)next;
                stp_vec3d out = stp_subd(stp_to_double(at), middle);
                CHECK((double)n[0] * out.x + (double)n[1] * out.y + (double)n[2] * out.z > 0.0);
                CHECK(fabsf(n[0] * n[0] + n[1] * n[1] + n[2] * n[2] - 1.0f) < 1e-4f);
                taken[set] += 1;
                next += 1;
            }
        }
    }
    CHECK_EQUAL(c.candidates.count, next);
    for (int set = 0; set < 3; ++set) {
        CHECK(taken[set] >= c.list.sets[set].prefix / 100 * 99);
    }
    CHECK_EQUAL(0, taken[3]);
    CHECK(c.candidates.surface_radius < 0.1 + 1.3 * (double)c.h.made[c.child].candidate_radius);
    captured_destroy(&c);
    stp_context_destroy(context);
}

// Normals of a squeezed sphere are perpendicular to its surface, not along its radius.
void test_normals_of_squeezed_sets(test_state* test)
{
    stp_context* context = test_context(NULL, 1, NULL);
    captured c;
    CHECK(context != NULL);
    CHECK_EQUAL(STP_OK, capture_spheres(context, 0.2, UINT32_MAX - 1, &c));
    stp_affine placement = c.list.sets[2].transform, own = stp_affine_identity();
    stp_vec3d zero = stp_affine_point(&placement, (stp_vec3d){0});
    stp_set_placing placing = stp_set_placing_make(c.list.sets[2].splats, &placement);
    stp_set_placing before = stp_set_placing_make(c.list.sets[2].splats, &own);
    for (uint32_t i = 0; i < c.list.sets[2].prefix; ++i) {
        stp_vec3d n = stp_set_normal(&before, i), turned = stp_set_normal(&placing, i);
        stp_vec3d aside = fabs(n.x) < 0.7 ? (stp_vec3d){1, 0, 0} : (stp_vec3d){0, 1, 0};
        stp_vec3d tangents[2] = {stp_crossd(n, aside)};
        tangents[1] = stp_crossd(n, tangents[0]);
        for (int k = 0; k < 2; ++k) {
            stp_vec3d moved = stp_subd(stp_affine_point(&placement, tangents[k]), zero);
            CHECK(fabs(stp_dotd(moved, turned)) < 1e-6);
        }
    }
    captured_destroy(&c);
    stp_context_destroy(context);
}

void test_prefixes_are_the_shortest_dense_enough(test_state* test)
{
    stp_context* context = test_context(NULL, 1, NULL);
    captured c;
    CHECK(context != NULL);
    CHECK_EQUAL(STP_OK, capture_spheres(context, 0.3, UINT32_MAX - 1, &c));
    for (size_t set = 0; set < c.list.set_count; ++set) {
        const stp_placed_set* placed = &c.list.sets[set];
        double scale = stp_affine_stretch(&placed->transform);
        const stp_prefix_table* table = &placed->splats->table;
        CHECK((double)stp_prefix_table_radius(table, placed->prefix) * scale <= 0.15000001);
        CHECK((double)stp_prefix_table_radius(table, placed->prefix - 1) * scale > 0.1499999);
    }
    stp_source_list fine;
    CHECK_EQUAL(STP_OK, stp_list_sources(c.h.scene, c.node, c.h.sets, 1e-3, 1000, &fine));
    CHECK_EQUAL(0, fine.set_count); // none is dense enough: triangles
    CHECK_EQUAL(SPHERES, fine.part_count);
    CHECK_EQUAL(c.list.triangle_count, fine.triangle_count);
    stp_source_list_destroy(context, &fine);
    captured_destroy(&c);
    stp_context_destroy(context);
}

static bool same_candidates(const stp_candidates* a, const stp_candidates* b)
{
    size_t n = a->count;
    return a->count == b->count && a->set_count == b->set_count &&
           memcmp(a->positions, b->positions, 12 * n) == 0 &&
           memcmp(a->normals, b->normals, 12 * n) == 0 &&
           memcmp(a->colors, b->colors, 4 * n) == 0 &&
           memcmp(a->materials, b->materials, 4 * n) == 0;
}

void test_sets_are_captured_alike_in_passes(test_state* test)
{
    stp_context* context = test_context(NULL, 2, NULL);
    captured once, passes;
    CHECK(context != NULL);
    CHECK_EQUAL(STP_OK, capture_spheres(context, 0.15, UINT32_MAX - 1, &once));
    CHECK_EQUAL(STP_OK, capture_spheres(context, 0.15, 900, &passes));
    CHECK(once.candidates.count > 1000);
    CHECK(same_candidates(&once.candidates, &passes.candidates));
    captured_destroy(&once);
    captured_destroy(&passes);
    stp_context_destroy(context);
}

static void capture_in_job(size_t begin, size_t end, uint32_t worker, void* user)
{
    (void)worker;
    captured* all = user;
    for (size_t i = begin; i < end; ++i) {
        stp_context* context = all[i].h.scene->context;
        stp_capture_sources sources = {all[i].list.parts, all[i].list.part_count, all[i].list.sets,
                                       all[i].list.set_count};
        stp_capture_desc desc = {.pixel_size = 0.2};
        stp_candidates_destroy(context, &all[i].candidates);
        if (stp_capture_all(all[i].h.scene, &sources, &desc, &all[i].candidates) != STP_OK) {
            all[i].candidates.count = 0;
        }
    }
}

void test_captures_of_sets_do_not_depend_on_threads(test_state* test)
{
    enum { THREADS = 3 };
    stp_context* contexts[THREADS];
    captured c[THREADS];
    for (uint32_t i = 0; i < THREADS; ++i) {
        contexts[i] = test_context(NULL, i + 1, NULL);
        CHECK(contexts[i] != NULL);
        CHECK_EQUAL(STP_OK, capture_spheres(contexts[i], 0.2, UINT32_MAX - 1, &c[i]));
        CHECK(same_candidates(&c[0].candidates, &c[i].candidates));
    }
    stp_parallel_for(contexts[1], 2, 1, capture_in_job, &c[1]);
    CHECK(same_candidates(&c[0].candidates, &c[1].candidates));
    CHECK(same_candidates(&c[0].candidates, &c[2].candidates));
    for (uint32_t i = 0; i < THREADS; ++i) {
        captured_destroy(&c[i]);
        stp_context_destroy(contexts[i]);
    }
}

// A thousand small spheres around a large one, without sets: small ones are left out evenly to meet
// the limit; the large one stays.
void test_uses_smaller_than_a_pixel_are_thinned(test_state* test)
{
    enum { MANY = 1000, LIMIT = 200 };
    stp_context* context = test_context(NULL, 1, NULL);
    hierarchy h;
    stp_affine copies[MANY + 1];
    copies[0] = scale_and_move(10, 10, 10, 0, 0, 0);
    for (int i = 1; i <= MANY; ++i) {
        copies[i] = scale_and_move(0.01, 0.01, 0.01, i, 50, 0);
    }
    uint32_t root;
    CHECK(context != NULL && hierarchy_begin(context, &h, true, 1));
    CHECK(add_copies(&h, h.shape, copies, MANY + 1, false, &root) && hierarchy_finish(&h));
    stp_source_list list;
    CHECK_EQUAL(STP_OK, stp_list_sources(h.scene, h.scene->root, NULL, 0.1, MANY + 1, &list));
    CHECK_EQUAL(MANY + 1, list.part_count);
    CHECK_EQUAL(0, list.thinned);
    stp_source_list_destroy(context, &list);
    CHECK_EQUAL(STP_OK, stp_list_sources(h.scene, h.scene->root, NULL, 0.1, LIMIT, &list));
    CHECK(list.part_count > LIMIT / 3 && list.part_count <= LIMIT);
    CHECK_EQUAL(MANY + 1, list.part_count + list.thinned);
    CHECK(list.parts[0].transform.m[0][0] == 10.0);
    for (size_t i = 2; i < list.part_count; ++i) {
        double step = list.parts[i].transform.m[0][3] - list.parts[i - 1].transform.m[0][3];
        CHECK(step == list.parts[2].transform.m[0][3] - list.parts[1].transform.m[0][3]);
    }
    stp_source_list_destroy(context, &list);
    // all larger than a pixel: the size below which spheres are thinned grows
    CHECK_EQUAL(STP_OK, stp_list_sources(h.scene, h.scene->root, NULL, 1e-4, LIMIT, &list));
    CHECK(list.part_count > LIMIT / 3 && list.part_count <= LIMIT);
    CHECK(list.parts[0].transform.m[0][0] == 10.0);
    stp_source_list_destroy(context, &list);
    hierarchy_destroy(&h);
    stp_context_destroy(context);
}

void test_moving_children_are_no_sources(test_state* test)
{
    stp_context* context = test_context(NULL, 1, NULL);
    hierarchy h;
    uint32_t root, copy;
    CHECK(context != NULL && hierarchy_begin(context, &h, true, 6));
    CHECK(add_copies(&h, h.shape, &(stp_affine){{{1}, {0, 1}, {0, 0, 1}}}, 1, false, &root));
    stp_object moving = {
        .parent = root, .transform = scale_and_move(1, 1, 1, 5, 0, 0), .flags = STP_OBJECT_MOVING};
    CHECK_EQUAL(STP_OK, stp_scene_add_object(h.scene, &moving, &copy));
    CHECK_EQUAL(STP_OK, stp_scene_add_use(h.scene, h.shape));
    CHECK(hierarchy_finish(&h));
    uint32_t child = h.scene->objects[h.shape].node;
    CHECK_EQUAL(STP_OK, hierarchy_make(&h, child, 500, 8000, NULL));
    stp_source_list list;
    for (int with_sets = 0; with_sets < 2; ++with_sets) {
        CHECK_EQUAL(STP_OK, stp_list_sources(h.scene, h.scene->root, with_sets ? h.sets : NULL, 1.0,
                                             1000, &list));
        CHECK_EQUAL(1, list.part_count + list.set_count);
        CHECK_EQUAL(with_sets, list.set_count);
        CHECK_EQUAL(864 / 2, list.triangle_count);
        stp_source_list_destroy(context, &list);
    }
    hierarchy_destroy(&h);
    stp_context_destroy(context);
}
