// SPDX-License-Identifier: MIT
// Parts of decimators (lab/decimate) against brute force: quadrics, links, contractions, octree
// cells, cells of chosen points.
#include "decimate_helpers.h"

#include "lab/decimate/contraction.h"
#include "lab/decimate/octree_cells.h"
#include "lab/decimate/point_disks.h"

#include <stipple/order.h>

#include <stdlib.h>

static decimate_model model;

static stp_vec3d random_vector(uint64_t seed, uint64_t at)
{
    return (stp_vec3d){decimate_unit(seed, 3 * at) - 0.5, decimate_unit(seed, 3 * at + 1) - 0.5,
                       decimate_unit(seed, 3 * at + 2) - 0.5};
}

void test_decimate_quadrics_measure_planes(test_state* test)
{
    for (uint64_t seed = 0; seed < 200; ++seed) {
        enum { PLANES = 9 };
        stp_quadric parts[2] = {0};
        stp_vec3d through[PLANES], normals[PLANES], at = random_vector(seed, 50);
        double sum = 0.0;
        for (uint32_t i = 0; i < PLANES; ++i) {
            through[i] = random_vector(seed, 2 * i);
            normals[i] = stp_normalized(random_vector(seed, 2 * i + 1));
            stp_quadric_add_plane(&parts[i % 2], through[i], normals[i]);
            double away = stp_dotd(stp_subd(at, through[i]), normals[i]);
            sum += away * away;
        }
        stp_quadric all = stp_quadric_sum(&parts[0], &parts[1]);
        CHECK(fabs(stp_quadric_at(&all, at) - sum) < 1e-12);
        CHECK(fabs(stp_quadric_planes(&all) - PLANES) < 1e-12);
        // no point near the minimum is much better
        stp_vec3d minimum = stp_quadric_minimum(&all, at, 100.0);
        double value = stp_quadric_at(&all, minimum);
        for (uint64_t i = 0; i < 50; ++i) {
            stp_vec3d other = stp_addd(minimum, stp_scaled(random_vector(seed, 100 + i), 0.2));
            CHECK(stp_quadric_at(&all, other) >= value - 1e-3);
        }
        // out of reach: the start
        stp_vec3d start = stp_quadric_minimum(&all, at, 0.0);
        CHECK(start.x == at.x && start.y == at.y && start.z == at.z);
    }
    // for one plane, the projection of the start
    stp_quadric one = {0};
    stp_quadric_add_plane(&one, (stp_vec3d){0.0, 2.0, 0.0}, (stp_vec3d){0.0, 1.0, 0.0});
    stp_vec3d foot = stp_quadric_minimum(&one, (stp_vec3d){3.0, 5.0, 1.0}, 10.0);
    CHECK(fabs(foot.x - 3.0) < 1e-12 && fabs(foot.y - 2.0) < 0.01 && fabs(foot.z - 1.0) < 1e-12);
}

static int compare_numbers(const void* a, const void* b)
{
    uint32_t x = *(const uint32_t*)a, y = *(const uint32_t*)b;
    return x < y ? -1 : x > y ? 1 : 0;
}

// Neighbour lists match a matrix whose rows and columns are merged.
void test_decimate_links_follow_unions(test_state* test)
{
    enum { COUNT = 40, K = 3 };
    static uint8_t linked[COUNT][COUNT];
    uint32_t neighbours[COUNT * K], listed[COUNT];
    memset(linked, 0, sizeof(linked));
    for (uint32_t i = 0; i < COUNT; ++i) { // the last two points have fewer neighbours
        for (uint32_t k = 0; k < K; ++k) {
            uint32_t other = (i + 1 + k * k * 3 + i % 2) % COUNT;
            bool none = i >= COUNT - 2 && k > 0;
            neighbours[K * i + k] = none ? UINT32_MAX : other;
            if (!none) {
                linked[i][other] = linked[other][i] = 1;
            }
        }
    }
    stp_context* context = test_context(NULL, 1, NULL);
    stp_point_links links;
    CHECK_EQUAL(STP_OK, stp_point_links_make(context, neighbours, COUNT, K, &links));
    for (uint32_t step = 0; step < COUNT; ++step) {
        uint32_t kept = UINT32_MAX;
        for (uint32_t i = 0; i < COUNT; ++i) {
            if (links.kept[i] != i) {
                continue;
            }
            uint32_t count = stp_point_links_list(&links, i, listed), expected = 0;
            qsort(listed, count, sizeof(*listed), compare_numbers);
            for (uint32_t n = 0; n < COUNT; ++n) {
                if (linked[i][n] != 0) {
                    CHECK(expected < count && listed[expected] == n);
                    expected += 1;
                }
            }
            CHECK_EQUAL(expected, count);
            bool chosen = count > 0 && (kept == UINT32_MAX || stp_rng_below(7, step, 3) == 0);
            kept = chosen ? i : kept;
        }
        if (kept == UINT32_MAX) {
            break;
        }
        uint32_t count = stp_point_links_list(&links, kept, listed);
        uint32_t gone = listed[stp_rng_below(8, step, count)];
        stp_point_links_unite(&links, kept, gone);
        for (uint32_t n = 0; n < COUNT; ++n) {
            linked[kept][n] = linked[n][kept] = (uint8_t)(linked[kept][n] | linked[gone][n]);
            linked[gone][n] = linked[n][gone] = 0;
        }
        linked[kept][kept] = linked[gone][gone] = linked[kept][gone] = 0;
    }
    stp_point_links_destroy(&links);
    stp_context_destroy(context);
}

/// The error of a pair, as defined in the paper.
static double error_of(const stp_contraction* c, uint32_t a, uint32_t b)
{
    stp_quadric both = stp_quadric_sum(&c->quadrics[a], &c->quadrics[b]);
    double wa = c->points->means[a].weight, wb = c->points->means[b].weight;
    stp_vec3d mean = stp_addd(stp_scaled(c->positions[a], wa / (wa + wb)),
                              stp_scaled(c->positions[b], wb / (wa + wb)));
    stp_vec3d d = stp_subd(c->positions[a], c->positions[b]);
    return stp_quadric_at(&both, stp_quadric_minimum(&both, mean, sqrt(stp_dotd(d, d))));
}

void test_decimate_contracts_the_best_pair(test_state* test)
{
    enum { COUNT = 200 };
    static uint32_t listed[COUNT];
    for (uint32_t i = 0; i < 3 * COUNT; ++i) {
        model.positions[i] = (float)decimate_unit(3, i);
        model.positions[i] *= i % 3 == 2 ? model.positions[i - 1] : 1.0f;
    }
    stp_decimate_input input = {.count = COUNT, .positions = model.positions};
    stp_context* context = test_context(NULL, 2, NULL);
    stp_distinct points;
    stp_ellipse* disks = NULL;
    uint32_t *neighbours = NULL, left = COUNT;
    CHECK_EQUAL(STP_OK, stp_distinct_make(context, &input, &points));
    input.positions = points.positions;
    CHECK_EQUAL(STP_OK, stp_decimate_make_disks(context, &input, &disks, &neighbours));
    stp_contraction c = {.context = context, .points = &points, .disks = disks};
    CHECK_EQUAL(STP_OK, stp_contraction_make(&c, neighbours, STP_DECIMATE_NEIGHBOURS));
    for (;; --left) {
        double minimum = HUGE_VAL;
        for (uint32_t i = 0; i < COUNT; ++i) {
            if (c.links.kept[i] != i) {
                continue;
            }
            uint32_t count = stp_point_links_list(&c.links, i, listed);
            for (uint32_t n = 0; n < count; ++n) {
                double error = error_of(&c, i, listed[n]);
                minimum = error < minimum ? error : minimum;
            }
        }
        CHECK_EQUAL(left, c.left);
        if (minimum == HUGE_VAL) {
            break;
        }
        double taken = c.pairs[c.heap[0]].error;
        CHECK(fabs(taken - minimum) <= 1e-9 * minimum + 1e-12);
        CHECK(stp_contraction_step(&c));
    }
    CHECK(!stp_contraction_step(&c) && left < 5);
    stp_contraction_destroy(&c);
    stp_distinct_destroy(context, &points);
    stp_free(context, disks);
    stp_free(context, neighbours);
    stp_context_destroy(context);
}

/// Number of occupied cells at a level, by sorting.
static uint32_t count_cells(const stp_decimate_input* input, uint32_t level)
{
    static uint64_t cells[DECIMATE_POINTS];
    stp_box box = stp_decimate_box(input);
    double low[3] = {(double)box.min.x, (double)box.min.y, (double)box.min.z};
    double high[3] = {(double)box.max.x, (double)box.max.y, (double)box.max.z}, wide = 0.0;
    for (int k = 0; k < 3; ++k) {
        wide = high[k] - low[k] > wide ? high[k] - low[k] : wide;
    }
    uint64_t side = 1u << level;
    uint32_t count = 0;
    for (uint32_t i = 0; i < input->count; ++i) {
        cells[i] = 0;
        for (size_t k = 0; k < 3; ++k) {
            double at = ((double)input->positions[3 * i + k] - low[k]) / wide * (double)side;
            uint64_t cell = (uint64_t)at < side ? (uint64_t)at : side - 1;
            cells[i] = cells[i] * side + cell;
        }
        bool known = false;
        for (uint32_t n = 0; n < i && !known; ++n) {
            known = cells[n] == cells[i];
        }
        count += known ? 0 : 1;
    }
    return count;
}

static bool is_partition(const stp_octree_cells* tree)
{
    static uint8_t seen[DECIMATE_POINTS];
    memset(seen, 0, sizeof(seen));
    for (uint32_t c = 0; c < tree->count; ++c) {
        for (uint32_t i = tree->cells[c].begin; i < tree->cells[c].end; ++i) {
            uint32_t bits = 3 * (STP_OCTREE_LEVELS - tree->cells[c].level);
            if (tree->codes[i] >> bits != tree->codes[tree->cells[c].begin] >> bits) {
                return false;
            }
            seen[tree->order[i]] += 1;
        }
    }
    for (uint32_t i = 0; i < tree->input->count; ++i) {
        if (seen[i] != 1) {
            return false;
        }
    }
    return true;
}

void test_decimate_octree_chooses_cells(test_state* test)
{
    stp_decimate_input input = decimate_torus(&model);
    stp_context* context = test_context(NULL, 2, NULL);
    stp_ellipse* disks = NULL;
    CHECK_EQUAL(STP_OK, stp_decimate_make_disks(context, &input, &disks, NULL));
    uint32_t counts[12];
    for (uint32_t level = 0; level < 12; ++level) {
        counts[level] = count_cells(&input, level);
    }
    for (uint32_t target = 1; target < 3000; target += 1 + target / 2) {
        stp_octree_cells tree = {.context = context, .input = &input, .disks = disks};
        CHECK_EQUAL(STP_OK, stp_octree_cells_make(&tree));
        CHECK_EQUAL(STP_OK, stp_octree_cells_open(&tree, target));
        CHECK(is_partition(&tree));
        uint32_t maximum = target < DECIMATE_POINTS ? target : DECIMATE_POINTS;
        CHECK(tree.count <= maximum && tree.count + 6 >= maximum);
        stp_octree_cells_destroy(&tree);
        CHECK_EQUAL(STP_OK, stp_octree_cells_make(&tree));
        CHECK_EQUAL(STP_OK, stp_octree_cells_take_level(&tree, target));
        CHECK(is_partition(&tree));
        bool found = false;
        for (uint32_t level = 0; level < 12; ++level) {
            int64_t away = llabs((int64_t)counts[level] - (int64_t)target);
            CHECK(llabs((int64_t)tree.count - (int64_t)target) <= away);
            found = found || counts[level] == tree.count;
        }
        CHECK(found);
        stp_octree_cells_destroy(&tree);
    }
    stp_free(context, disks);
    stp_context_destroy(context);
}

// Two sheets, back to back: each point is assigned to the nearest chosen one on its own side.
void test_decimate_cells_know_sides(test_state* test)
{
    enum { SIDE = 30, COUNT = 2 * SIDE * SIDE, CHOSEN = 150 };
    static uint32_t chosen[CHOSEN];
    for (uint32_t i = 0; i < COUNT; ++i) {
        float up = i < COUNT / 2 ? 1.0f : -1.0f;
        const float p[3] = {(float)(i % SIDE) + 0.1f * (float)decimate_unit(5, i), 0.01f * up,
                            (float)(i / SIDE % SIDE)};
        const float n[3] = {0.0f, up, 0.0f};
        memcpy(model.positions + 3 * i, p, sizeof(p));
        memcpy(model.normals + 3 * i, n, sizeof(n));
    }
    stp_decimate_input input = {COUNT, model.positions, model.normals, NULL, NULL, 0};
    stp_context* context = test_context(NULL, 2, NULL);
    for (int sides = 0; sides < 2; ++sides) {
        const stp_order_desc desc = {.kind = STP_ORDER_EXACT};
        stp_decimate_cells cells;
        uint32_t count;
        float radius;
        input.normals = sides != 0 ? model.normals : NULL;
        CHECK_EQUAL(STP_OK, stp_order_points(context, &desc, input.positions, input.normals, COUNT,
                                             CHOSEN, chosen, NULL, &count, &radius, NULL));
        CHECK_EQUAL(STP_OK,
                    stp_decimate_cells_make(context, &input, chosen, count, radius, &cells));
        for (uint32_t i = 0; i < COUNT; ++i) {
            float minimum = HUGE_VALF, own = HUGE_VALF;
            for (uint32_t c = 0; c < count; ++c) {
                bool same = sides == 0 || (i < COUNT / 2) == (chosen[c] < COUNT / 2);
                stp_vec3 d = stp_sub(stp_decimate_vector(input.positions, i),
                                     stp_decimate_vector(input.positions, chosen[c]));
                float away = stp_length(d);
                minimum = same && away < minimum ? away : minimum;
                own = same && cells.owners[i] == c ? away : own;
            }
            CHECK(own <= minimum * 1.00001f);
        }
        uint32_t listed = 0;
        for (uint32_t c = 0; c < count; ++c) {
            for (uint32_t at = cells.starts[c]; at < cells.starts[c + 1]; ++at, ++listed) {
                CHECK_EQUAL(c, cells.owners[cells.members[at]]);
                CHECK(at == cells.starts[c] || cells.members[at] > cells.members[at - 1]);
            }
        }
        CHECK_EQUAL(COUNT, listed);
        stp_decimate_cells_destroy(context, &cells);
    }
    stp_context_destroy(context);
}

// Points at one place share a disk, whose neighbours are at other places; each point faces along
// its own normal.
void test_decimate_disks_of_shared_places(test_state* test)
{
    enum { PLACES = 200, COUNT = 3 * PLACES };
    for (uint32_t i = 0; i < COUNT; ++i) {
        for (uint32_t k = 0; k < 3; ++k) {
            double at = decimate_unit(11, 3 * (i % PLACES) + k);
            model.positions[3 * i + k] = k == 1 ? 0.01f * (float)at : (float)at;
            model.normals[3 * i + k] = k != 1 ? 0.0f : i < PLACES ? -1.0f : 1.0f;
        }
    }
    // two points of a place face up, one down
    stp_decimate_input input = {COUNT, model.positions, model.normals, NULL, NULL, 0};
    stp_context* context = test_context(NULL, 2, NULL);
    stp_distinct distinct;
    CHECK_EQUAL(STP_OK, stp_distinct_make(context, &input, &distinct));
    CHECK_EQUAL(PLACES, distinct.count);
    for (uint32_t i = 0; i < COUNT; ++i) {
        uint32_t place = distinct.places[i];
        CHECK(place < PLACES && distinct.points[place] % PLACES == i % PLACES);
        CHECK(memcmp(distinct.positions + 3 * place, model.positions + 3 * i, 12) == 0);
        CHECK(distinct.normals[3 * place + 1] == 1.0f && distinct.means[place].weight == 3.0);
    }
    stp_distinct_destroy(context, &distinct);
    stp_ellipse *disks = NULL, *alone = NULL;
    uint32_t *near = NULL, *near_alone = NULL;
    CHECK_EQUAL(STP_OK, stp_decimate_make_disks(context, &input, &disks, &near));
    input.count = PLACES;
    CHECK_EQUAL(STP_OK, stp_decimate_make_distinct_disks(context, &input, &alone, &near_alone));
    for (uint32_t i = 0; i < COUNT; ++i) {
        const stp_ellipse* expected = &alone[i % PLACES];
        CHECK(disks[i].minor == expected->minor && disks[i].center.x == expected->center.x);
        CHECK((disks[i].normal.y > 0.0f) == (i >= PLACES));
        for (uint32_t n = 0; n < STP_DECIMATE_NEIGHBOURS; ++n) {
            CHECK_EQUAL(near_alone[STP_DECIMATE_NEIGHBOURS * (i % PLACES) + n],
                        near[STP_DECIMATE_NEIGHBOURS * i + n] % PLACES);
        }
    }
    stp_free(context, disks);
    stp_free(context, alone);
    stp_free(context, near);
    stp_free(context, near_alone);
    stp_context_destroy(context);
}
