// SPDX-License-Identifier: MIT
// The viewer's tree of parts: rows that fold, search, selection, and hidden and
// isolated parts.
#include "support_boxes.h"
#include "tests.h"

#include "base/core/context.h"
#include "program/viewer/model/explorer.h"

#include <math.h>
#include <stdio.h>
#include <string.h>
#include <unistd.h>

/// Builds the boxes and opens them. @return NULL on failure
static explorer* open_boxes(char path[64])
{
    explorer* e = boxes_build("explorer", path) ? explorer_create(path) : NULL;
    while (e != NULL && explorer_works(e)) {
        (void)explorer_step(e);
    }
    return e;
}

static void close_boxes(explorer* e, const char* path)
{
    explorer_destroy(e);
    unlink(path);
}

void test_viewer_explorer_folds_and_unfolds(test_state* test)
{
    char path[64];
    explorer* e = open_boxes(path);
    CHECK(e != NULL && e->ready);
    size_t count = e->row_count; // a single root is expanded at once
    CHECK(count > 1 && e->rows[0].open && e->rows[0].item.depth == 1);
    for (size_t i = 1; i < count; ++i) {
        CHECK(e->rows[i].item.depth == 2 &&
              e->rows[i].item.objects[0] == e->rows[0].item.objects[0]);
    }
    explorer_fold(e, 0);
    CHECK(e->row_count == 1 && !e->rows[0].open);
    explorer_fold(e, 0);
    CHECK_EQUAL(count, e->row_count);
    close_boxes(e, path);
}

void test_viewer_explorer_finds_names(test_state* test)
{
    char path[64];
    explorer* e = open_boxes(path);
    CHECK(e != NULL);
    stp_outline_row row;
    char name[128];
    snprintf(name, sizeof(name), "%s", explorer_label(e, &e->rows[1].item, &row));
    explorer_search(e, name);
    while (explorer_works(e)) {
        (void)explorer_step(e);
    }
    CHECK(e->found_count >= 1);
    bool found = false;
    for (size_t i = 0; i < e->found_count; ++i) {
        found = found || explorer_is_same(&e->found[i].item, &e->rows[1].item);
    }
    CHECK(found);
    // a row of a search result: its own name first, its path beside it
    char above[128], top[128];
    snprintf(top, sizeof(top), "%s", explorer_label(e, &e->rows[0].item, &row));
    CHECK(strcmp(explorer_path_above(e, &e->found[0].item, above, sizeof(above)), top) == 0);
    CHECK(strcmp(explorer_path_above(e, &e->rows[0].item, above, sizeof(above)), "") == 0);
    explorer_search(e, "there is nothing of this name");
    while (explorer_works(e)) {
        (void)explorer_step(e);
    }
    CHECK_EQUAL(0, e->found_count);
    explorer_search(e, "");
    CHECK(!explorer_works(e));
    close_boxes(e, path);
}

void test_viewer_explorer_goes_on_after_a_failure(test_state* test)
{
    char path[64];
    explorer* e = open_boxes(path);
    CHECK(e != NULL);
    // a click on more content than a pick examines
    (void)!stp_fail(e->context, STP_ERROR_LIMIT, "pick: too much lies on the ray");
    CHECK(strcmp(e->message, "pick: too much lies on the ray") == 0);
    explorer_search(e, "box 15");
    CHECK(explorer_works(e));
    while (explorer_works(e)) {
        (void)explorer_step(e);
    }
    CHECK_EQUAL(1, e->found_count);
    close_boxes(e, path);
}

void test_viewer_explorer_marks_parts(test_state* test)
{
    char path[64];
    explorer* e = open_boxes(path);
    CHECK(e != NULL && e->row_count > 3);
    stp_outline_item whole = e->rows[0].item, first = e->rows[1].item, second = e->rows[2].item;
    shown_list list;
    explorer_mark_item(e, &first, EXPLORER_HIDDEN);
    CHECK(explorer_is_marked(e, &first, EXPLORER_HIDDEN));
    CHECK(!explorer_is_marked(e, &second, EXPLORER_HIDDEN));
    CHECK(explorer_list_shown(e, &list));
    CHECK(list.whole == STP_SHOW && list.count == 1 && list.objects[0].show == STP_SHOW_NOT);
    free(list.objects);
    explorer_mark_item(e, &first, EXPLORER_HIDDEN); // and back
    CHECK_EQUAL(0, e->mark_count);
    explorer_mark_item(e, &first, EXPLORER_ISOLATED);
    explorer_mark_item(e, &second, EXPLORER_ISOLATED); // only one at a time
    CHECK(e->mark_count == 1 && explorer_is_marked(e, &second, EXPLORER_ISOLATED));
    explorer_mark_item(e, &first, EXPLORER_GHOST);
    CHECK(explorer_list_shown(e, &list));
    CHECK(list.whole == STP_SHOW_NOT && list.count == 2); // isolate comes first: the order decides
    CHECK(list.objects[0].show == STP_SHOW && list.objects[1].show == STP_SHOW_GHOST);
    free(list.objects);
    uint64_t version = e->marks_version;
    explorer_show_all(e);
    CHECK(e->mark_count == 0 && e->marks_version != version);
    explorer_mark_item(e, &whole, EXPLORER_HIDDEN); // children are hidden with it
    CHECK(explorer_is_marked(e, &first, EXPLORER_HIDDEN));
    close_boxes(e, path);
}

void test_viewer_explorer_picks_what_is_shown(test_state* test)
{
    char path[64];
    explorer* e = open_boxes(path);
    CHECK(e != NULL);
    stp_pick pick, behind;
    stp_view view = {
        .eye = {0.1, 0.1, 20}, .up = {0, 1, 0}, .fov_degrees = 40, .width = 100, .height = 100};
    CHECK(explorer_pick(e, &view, false, 50.5, 50.5, &pick));
    explorer_choose_picked(e, &pick);
    stp_boxd box;
    CHECK(e->chosen.depth > 0 && explorer_chosen_box(e, &box));
    CHECK(pick.position.z <= box.max.z + 1e-4 && pick.position.z >= box.min.z - 1e-4);
    stp_outline_item chosen = e->chosen;
    explorer_mark_item(e, &chosen, EXPLORER_HIDDEN);
    CHECK(explorer_pick(e, &view, false, 50.5, 50.5, &behind)); // through hidden parts
    CHECK(behind.distance > pick.distance + 0.1);
    explorer_choose_picked(e, &behind);
    CHECK(!explorer_is_same(&e->chosen, &chosen));
    CHECK(!explorer_pick(e, &view, false, 0.5, 0.5, &pick));
    explorer_choose_picked(e, NULL);
    CHECK(e->chosen.depth == 0 && !explorer_chosen_box(e, &box));
    close_boxes(e, path);
}

void test_viewer_explorer_refuses_invalid_scenes(test_state* test)
{
    CHECK(explorer_create("/nowhere/there.stip") == NULL);
}

void test_viewer_explorer_follows_a_scene_that_grows(test_state* test)
{
    char path[64];
    explorer* e = open_boxes(path);
    CHECK(e != NULL && e->row_count > 3);
    stp_outline_item chosen = e->rows[2].item;
    size_t count = e->row_count;
    explorer_choose(e, &chosen, false);
    explorer_search(e, "box 1");
    while (explorer_works(e)) {
        (void)explorer_step(e);
    }
    size_t found = e->found_count;
    explorer *second = explorer_create(path), *third = explorer_create(path);
    CHECK(second != NULL && third != NULL && found > 1);
    explorer_follow(second, e);
    explorer_destroy(e);
    explorer_follow(third, second); // before the second is ready
    explorer_destroy(second);
    while (explorer_works(third)) {
        (void)explorer_step(third);
    }
    CHECK(third->ready && explorer_is_same(&third->chosen, &chosen));
    CHECK_EQUAL(count, third->row_count);
    CHECK_EQUAL(found, third->found_count);
    explorer_fold(third, 0); // collapsed rows stay collapsed
    e = explorer_create(path);
    CHECK(e != NULL);
    explorer_follow(e, third);
    explorer_destroy(third);
    while (explorer_works(e)) {
        (void)explorer_step(e);
    }
    CHECK(e->row_count == 1 && !e->rows[0].open);
    close_boxes(e, path);
}

void test_viewer_part_materials_are_found(test_state* test)
{
    char path[64];
    explorer* e = open_boxes(path);
    CHECK(e != NULL && e->row_count > 1);
    const stp_store_directory* d = stp_store_get_directory(e->store);
    part_materials one = part_materials_find(e->store, e->rows[1].item.node);
    CHECK(one.count == 1 && !one.more && one.materials[0] < d->material_count);
    part_materials all = part_materials_find(e->store, d->root);
    CHECK(all.count >= one.count && all.count <= PART_MATERIALS_MAX);
    CHECK(all.more == (d->material_count > PART_MATERIALS_MAX));
    for (uint32_t i = 0; i < all.count; ++i) {
        for (uint32_t k = 0; k < i; ++k) {
            CHECK(all.materials[i] != all.materials[k]);
        }
    }
    CHECK_EQUAL(0, part_materials_find(e->store, STP_STORE_NONE).count);
    close_boxes(e, path);
}
