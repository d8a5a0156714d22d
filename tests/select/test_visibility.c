// SPDX-License-Identifier: MIT
#include "support_built.h"

#include "base/math/rng.h"
#include "select/select.h"
#include "select/visibility.h"

#include <stdlib.h>
#include <string.h>

/// The state of each use of a part, walked along the graph.
static bool walk_states(const stp_store* store, const stp_visibility* v, uint32_t node,
                        uint32_t state, uint32_t* count, stp_show* out)
{
    const stp_store_directory* d = stp_store_get_directory(store);
    const stp_store_node* n = &d->nodes[node];
    bool mixed = stp_show_of(state) == STP_SHOW_MIXED;
    for (uint32_t i = 0; i < n->part_count; ++i) {
        uint32_t own = mixed ? stp_visibility_below(v, state, n->edge_count + i) : state;
        if (*count == BUILT_PLACES || stp_show_of(own) == STP_SHOW_MIXED) {
            return false;
        }
        out[(*count)++] = stp_show_of(own);
    }
    for (uint32_t i = 0; i < n->edge_count; ++i) {
        uint32_t own = mixed ? stp_visibility_below(v, state, i) : state;
        if (!walk_states(store, v, d->edges[n->first_edge + i].node, own, count, out)) {
            return false;
        }
    }
    return true;
}

typedef struct shown {
    stp_context* context;
    stp_store* store;
    stp_outline* outline;
    stp_visibility* visibility;
    built_places *all, *own;
    stp_show expected[BUILT_PLACES], found[BUILT_PLACES];
    stp_draw_list list;
} shown;

static bool set_up(shown* s, uint64_t seed, bool splats)
{
    bool ready = false;
    stp_affine identity = stp_affine_identity();
    s->context = test_context(NULL, 2, NULL);
    s->store = s->context != NULL ? built_open(s->context, seed, splats) : NULL;
    s->all = calloc(1, sizeof(*s->all));
    s->own = calloc(1, sizeof(*s->own));
    if (s->store == NULL || s->all == NULL || s->own == NULL ||
        stp_outline_create(s->context, s->store, &s->outline) != STP_OK ||
        stp_outline_prepare(s->outline, 0, &ready) != STP_OK || !ready ||
        stp_visibility_create(s->context, s->store, &s->visibility) != STP_OK) {
        return false;
    }
    return built_unfold(s->store, stp_store_get_directory(s->store)->root, &identity, s->all);
}

static void tear_down(shown* s)
{
    stp_draw_list_destroy(s->context, &s->list);
    stp_visibility_destroy(s->visibility);
    stp_outline_destroy(s->outline);
    stp_store_close(s->store);
    stp_context_destroy(s->context);
    free(s->all);
    free(s->own);
    free(s);
}

/// Sets the state of an object, here and in the expected result. @return false on failure
static bool set_object(shown* s, uint32_t object, stp_show show, bool* placed)
{
    stp_outline_item item;
    if (stp_outline_item_of(s->outline, object, &item) != STP_OK) {
        return false;
    }
    *placed = item.node != STP_STORE_NONE;
    s->own->count = 0;
    if (!*placed) {
        return true;
    }
    stp_placed_node target = {item.node, item.transform};
    if (stp_visibility_set(s->visibility, &target, show) != STP_OK ||
        !built_unfold(s->store, item.node, &item.transform, s->own)) {
        return false;
    }
    for (uint32_t i = 0; i < s->all->count; ++i) {
        s->expected[i] = built_has(s->own, &s->all->places[i]) ? show : s->expected[i];
    }
    return true;
}

static bool agrees(shown* s)
{
    uint32_t count = 0;
    const stp_store_directory* d = stp_store_get_directory(s->store);
    if (!walk_states(s->store, s->visibility, d->root, stp_visibility_root(s->visibility), &count,
                     s->found) ||
        count != s->all->count) {
        return false;
    }
    for (uint32_t i = 0; i < count; ++i) {
        if (s->found[i] != s->expected[i]) {
            return false;
        }
    }
    return true;
}

void test_hidden_objects_are_found_wherever_partition_put_them(test_state* test)
{
    for (uint64_t seed = 0; seed < 4; ++seed) {
        shown* s = calloc(1, sizeof(*s));
        CHECK(s != NULL && set_up(s, seed, false));
        uint32_t objects = stp_outline_object_count(s->outline), seen = 0;
        for (uint32_t i = 0; i < objects; ++i) {
            bool placed;
            CHECK(set_object(s, i, STP_SHOW_NOT, &placed));
            CHECK(agrees(s));
            for (uint32_t k = 0; k < s->own->count; ++k) { // it has no effect any more
                CHECK(built_has(s->all, &s->own->places[k]));
            }
            seen += placed ? 1 : 0;
            CHECK(set_object(s, i, STP_SHOW, &placed));
            CHECK_EQUAL(STP_SHOW, stp_visibility_root(s->visibility));
        }
        CHECK(seen > 20);
        tear_down(s);
    }
}

void test_visibility_is_what_was_set_last(test_state* test)
{
    for (uint64_t seed = 10; seed < 13; ++seed) {
        shown* s = calloc(1, sizeof(*s));
        CHECK(s != NULL && set_up(s, seed, false));
        uint32_t objects = stp_outline_object_count(s->outline);
        uint64_t version = stp_visibility_version(s->visibility);
        for (uint32_t i = 0; i < 60; ++i) {
            bool placed;
            if (i % 20 == 10) { // isolate
                stp_visibility_reset(s->visibility, STP_SHOW_NOT);
                for (uint32_t k = 0; k < s->all->count; ++k) {
                    s->expected[k] = STP_SHOW_NOT;
                }
            }
            stp_show show = (stp_show)stp_rng_below(seed, 2 * i, 3);
            CHECK(set_object(s, stp_rng_below(seed, 2 * i + 1, objects), show, &placed));
            CHECK(agrees(s));
            CHECK(!placed || stp_visibility_version(s->visibility) != version);
            version = stp_visibility_version(s->visibility);
        }
        tear_down(s);
    }
}

/// Whether an item draws exactly the expected parts: no hidden part is below the node of a splat
/// set.
static bool item_is_right(const shown* s, const stp_draw_item* item)
{
    const stp_store_directory* d = stp_store_get_directory(s->store);
    built_places* below = s->own;
    below->count = 0;
    if (item->kind == STP_DRAW_SPLATS) {
        for (uint32_t i = 0; i < d->node_count; ++i) {
            if (d->nodes[i].set == item->index) {
                (void)built_unfold(s->store, i, &item->transform, below);
                break;
            }
        }
    } else {
        stp_store_part part = {STP_STORE_PART_MESH, item->index};
        below->places[below->count++] = stp_instance_of_part(s->store, part, &item->transform);
    }
    for (uint32_t i = 0; i < s->all->count; ++i) {
        bool shown_so = s->expected[i] == (item->ghost ? STP_SHOW_GHOST : STP_SHOW);
        if (!shown_so && built_has(below, &s->all->places[i])) {
            return false;
        }
    }
    return below->count > 0;
}

/// Whether a place may be a part that its node lists twice, which is drawn once.
static bool is_repeated(const built_places* all, uint32_t i)
{
    const stp_instance* b = &all->places[i];
    for (uint32_t k = 0; k < i; ++k) {
        const stp_instance* a = &all->places[k];
        if (a->part.kind == b->part.kind && a->part.index == b->part.index &&
            memcmp(&a->transform, &b->transform, sizeof(a->transform)) == 0) {
            return true;
        }
    }
    return false;
}

void test_selection_shows_what_is_visible_at_any_level(test_state* test)
{
    shown* s = calloc(1, sizeof(*s));
    CHECK(s != NULL && set_up(s, 21, true));
    const stp_store_directory* d = stp_store_get_directory(s->store);
    uint32_t objects = stp_outline_object_count(s->outline);
    for (uint32_t round = 0; round < 12; ++round) {
        bool placed;
        for (uint32_t k = 0; k < s->all->count; ++k) {
            s->expected[k] = round % 4 == 3 ? STP_SHOW_GHOST : STP_SHOW;
        }
        stp_visibility_reset(s->visibility, round % 4 == 3 ? STP_SHOW_GHOST : STP_SHOW);
        for (uint32_t i = 0; i < 3; ++i) {
            stp_show show = round % 4 == 3 ? STP_SHOW : i == 1 ? STP_SHOW_GHOST : STP_SHOW_NOT;
            CHECK(set_object(s, stp_rng_below(round, i, objects), show, &placed));
        }
        stp_vec3d middle =
            stp_scaled(stp_addd(d->nodes[d->root].bounds.min, d->nodes[d->root].bounds.max), 0.5);
        stp_view view = {.eye = {middle.x, middle.y, middle.z + (round % 2 == 0 ? 60.0 : 400.0)},
                         .target = middle,
                         .up = {0, 1, 0},
                         .fov_degrees = 60,
                         .width = 400,
                         .height = 400};
        for (int reference = 0; reference < 2; ++reference) {
            stp_quality quality = {
                .splat_size = 1, .reference = reference == 1, .visibility = s->visibility};
            CHECK_EQUAL(STP_OK, stp_select(s->context, s->store, &view, &quality, &s->list));
            uint32_t drawn = 0, expected = 0, repeated = 0;
            for (size_t i = 0; i < s->list.count; ++i) {
                CHECK(item_is_right(s, &s->list.items[i]));
                drawn += s->list.items[i].kind == STP_DRAW_MESH ? 1 : 0;
            }
            for (uint32_t i = 0; i < s->all->count; ++i) {
                expected += s->expected[i] != STP_SHOW_NOT ? 1 : 0;
                repeated += s->expected[i] != STP_SHOW_NOT && is_repeated(s->all, i);
            }
            CHECK(reference == 0 || (drawn <= expected && drawn >= expected - repeated));
            CHECK(expected == 0 || s->list.count > 0);
        }
    }
    tear_down(s);
}

void test_visibility_survives_any_allocation_failing(test_state* test)
{
    shown* s = calloc(1, sizeof(*s));
    CHECK(s != NULL && set_up(s, 2, false));
    bool failed = true;
    for (int n = 0; failed; ++n) {
        test_heap heap = TEST_HEAP(-1);
        test_log log = {0};
        stp_context* context = test_context(&heap, 1, &log);
        stp_visibility* v = NULL;
        CHECK(context != NULL);
        heap.count = 0;
        heap.fail_at = n;
        stp_result result = stp_visibility_create(context, s->store, &v);
        for (uint32_t i = 0; result == STP_OK && i < 12; ++i) {
            stp_outline_item item;
            CHECK_EQUAL(STP_OK, stp_outline_item_of(s->outline, 4 + i, &item));
            stp_placed_node placed = {item.node, item.transform};
            result = item.node != STP_STORE_NONE
                         ? stp_visibility_set(v, &placed, i % 3 == 2 ? STP_SHOW : STP_SHOW_NOT)
                         : STP_OK;
        }
        failed = result != STP_OK;
        CHECK(!failed || (result == STP_ERROR_OUT_OF_MEMORY && log.errors == 1));
        heap.fail_at = -1;
        if (v != NULL) {
            stp_visibility_reset(v, STP_SHOW);
            stp_visibility_destroy(v);
        }
        stp_context_destroy(context);
        CHECK_EQUAL(0, heap.live_bytes);
    }
    tear_down(s);
}
