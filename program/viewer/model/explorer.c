// SPDX-License-Identifier: MIT
#include "program/viewer/model/explorer.h"

#include <assert.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum {
    RECORDS_A_STEP = 100000, ///< objects to read per step: a few milliseconds
    CHILDREN_AT_ONCE = 256,
    UNFOLDED_AT_FIRST = 4,
};

static void on_log(stp_log_level level, const char* message, void* user)
{
    explorer* e = user;
    if (level == STP_LOG_ERROR) {
        snprintf(e->message, sizeof(e->message), "%s", message);
    }
}

explorer* explorer_create(const char* path)
{
    explorer* e = calloc(1, sizeof(*e));
    stp_context_desc desc = {.log = on_log, .log_user = e, .thread_count = 1};
    stp_store_open_desc opening = {.defer_objects = true, .accept_partial = true};
    if (e != NULL) {
        e->materials_of = STP_STORE_NONE;
    }
    bool made = e != NULL && stp_context_create(&e->context, &desc) == STP_OK &&
                stp_store_open_with(e->context, path, &opening, &e->store) == STP_OK &&
                stp_outline_create(e->context, e->store, &e->outline) == STP_OK &&
                stp_visibility_create(e->context, e->store, &e->visibility) == STP_OK;
    if (!made) {
        explorer_destroy(e);
        return NULL;
    }
    e->rounding = stp_bounds_rounding(e->context, e->store);
    return e;
}

void explorer_destroy(explorer* e)
{
    if (e == NULL) {
        return;
    }
    if (e->visibility != NULL) {
        stp_visibility_destroy(e->visibility);
    }
    if (e->outline != NULL) {
        stp_outline_destroy(e->outline);
    }
    if (e->store != NULL) {
        stp_store_close(e->store);
    }
    free(e->rows);
    free(e->former_rows);
    free(e->found);
    free(e->marks);
    if (e->context != NULL) {
        stp_context_destroy(e->context);
    }
    free(e);
}

bool explorer_is_same(const stp_outline_item* a, const stp_outline_item* b)
{
    return a->depth == b->depth &&
           memcmp(a->objects, b->objects, a->depth * sizeof(a->objects[0])) == 0;
}

/// Whether `a` is `b` or an ancestor of it.
static bool is_above(const stp_outline_item* a, const stp_outline_item* b)
{
    return a->depth <= b->depth &&
           memcmp(a->objects, b->objects, a->depth * sizeof(a->objects[0])) == 0;
}

static bool grow(void** array, size_t* capacity, size_t needed, size_t size)
{
    if (needed > *capacity) {
        size_t wanted = needed + needed / 2 + 16;
        void* larger = realloc(*array, wanted * size);
        if (larger == NULL) {
            return false;
        }
        *array = larger;
        *capacity = wanted;
    }
    return true;
}

/// Inserts the children of an item into the rows. @return their number
static size_t insert_children(explorer* e, const stp_outline_item* parent, size_t at)
{
    stp_outline_item children[CHILDREN_AT_ONCE];
    size_t inserted = 0;
    assert(at <= e->row_count);
    uint32_t count = CHILDREN_AT_ONCE;
    while (count == CHILDREN_AT_ONCE) {
        if (stp_outline_children(e->outline, parent, inserted, CHILDREN_AT_ONCE, children,
                                 &count) != STP_OK ||
            count == 0) {
            break;
        }
        if (e->row_count + count > EXPLORER_ROWS_MAX) {
            e->is_truncated = true;
            break;
        }
        void* rows = e->rows;
        bool room = grow(&rows, &e->row_capacity, e->row_count + count, sizeof(e->rows[0]));
        e->rows = rows;
        if (!room) {
            break;
        }
        explorer_row* place = e->rows + at + inserted;
        memmove(place + count, place, (e->row_count - at - inserted) * sizeof(*place));
        for (uint32_t i = 0; i < count; ++i) {
            place[i] = (explorer_row){.item = children[i]};
        }
        e->row_count += count;
        inserted += count;
    }
    return inserted;
}

void explorer_fold(explorer* e, size_t row)
{
    assert(row < e->row_count);
    explorer_row* r = &e->rows[row];
    if (!r->open) {
        r->open = true;
        stp_outline_item parent = r->item; // a copy, because rows move
        (void)insert_children(e, &parent, row + 1);
        return;
    }
    r->open = false;
    size_t end = row + 1;
    while (end < e->row_count && e->rows[end].item.depth > r->item.depth) {
        end += 1;
    }
    memmove(r + 1, e->rows + end, (e->row_count - end) * sizeof(*r));
    e->row_count -= end - row - 1;
    e->is_truncated = false;
}

static void begin_rows(explorer* e)
{
    stp_outline_item root = stp_outline_root(e->outline);
    (void)insert_children(e, &root, 0);
    for (size_t i = 0; i < UNFOLDED_AT_FIRST && e->row_count == i + 1; ++i) {
        explorer_fold(e, i); // an only child is expanded too
    }
}

/// Expands the rows that were expanded before; the same objects are in the same order.
static void follow_rows(explorer* e)
{
    size_t next = 0;
    for (size_t i = 0; i < e->former_count; ++i) {
        const explorer_row* former = &e->former_rows[i];
        size_t row = next;
        while (row < e->row_count && !explorer_is_same(&e->rows[row].item, &former->item)) {
            row += 1;
        }
        if (row < e->row_count) {
            if (e->rows[row].open != former->open) {
                explorer_fold(e, row);
            }
            next = row + 1;
        }
    }
}

static void follow(explorer* e)
{
    follow_rows(e);
    for (size_t i = 0; i < e->row_count && e->former_chosen.depth > 0; ++i) {
        if (explorer_is_same(&e->rows[i].item, &e->former_chosen)) {
            e->chosen = e->rows[i].item; // its node may have changed
        }
    }
    free(e->former_rows);
    e->former_rows = NULL;
    e->former_count = 0;
}

void explorer_follow(explorer* e, explorer* before)
{
    bool waits =
        !before->ready && before->former_rows != NULL; // it was replaced before it was ready
    e->former_rows = waits ? before->former_rows : before->rows;
    e->former_count = waits ? before->former_count : before->row_count;
    e->former_chosen = waits ? before->former_chosen : before->chosen;
    if (waits) {
        before->former_rows = NULL;
        before->former_count = 0;
    } else {
        before->rows = NULL;
        before->row_count = before->row_capacity = 0;
    }
    explorer_search(e, before->search.text);
}

bool explorer_works(const explorer* e)
{
    return !e->failed && (!e->ready || e->searches);
}

static bool search_on(explorer* e)
{
    uint32_t objects[64], count = 0;
    if (stp_outline_search_on(e->outline, &e->search, RECORDS_A_STEP, 64, objects, &count) !=
        STP_OK) {
        e->searches = false;
        return true;
    }
    for (uint32_t i = 0; i < count && e->found_count < EXPLORER_FOUND_MAX; ++i) {
        stp_outline_item item;
        void* found = e->found;
        bool room = grow(&found, &e->found_capacity, e->found_count + 1, sizeof(e->found[0]));
        e->found = found;
        if (room && stp_outline_item_of(e->outline, objects[i], &item) == STP_OK) {
            e->found[e->found_count++] = (explorer_row){.item = item};
        }
    }
    e->searches = e->search.next < stp_outline_object_count(e->outline) &&
                  e->found_count < EXPLORER_FOUND_MAX;
    return count > 0 || !e->searches;
}

bool explorer_step(explorer* e)
{
    if (!explorer_works(e)) {
        return false;
    }
    if (!e->ready) {
        e->failed = stp_outline_prepare(e->outline, RECORDS_A_STEP, &e->ready) != STP_OK;
        if (!e->failed && e->ready) {
            begin_rows(e);
            follow(e);
        }
        return e->ready || e->failed;
    }
    return search_on(e);
}

void explorer_search(explorer* e, const char* text)
{
    e->search = stp_outline_search_begin(text);
    e->found_count = 0;
    e->searches = text[0] != 0;
}

const char* explorer_label(explorer* e, const stp_outline_item* item, stp_outline_row* row)
{
    static char text[32]; // used by the window thread only
    *row = (stp_outline_row){0};
    if (stp_outline_describe(e->outline, item, row) != STP_OK) {
        return "?";
    }
    if (row->name != NULL && row->name[0] != 0) {
        return row->name;
    }
    snprintf(text, sizeof(text), "#%u", item->depth > 0 ? item->objects[item->depth - 1] : 0);
    return text;
}

const char* explorer_path_above(explorer* e, const stp_outline_item* item, char* text, size_t size)
{
    stp_outline_item above = *item;
    text[0] = 0;
    if (item->depth > 1) {
        above.depth -= 1;
        if (stp_outline_path(e->outline, &above, text, size) != STP_OK) {
            text[0] = 0;
        }
    }
    return text;
}

bool explorer_pick(explorer* e, const stp_view* view, bool back_faces, double x, double y,
                   stp_pick* pick)
{
    stp_pick_desc desc = {
        .sections = &view->sections, .visibility = e->visibility, .back_faces = back_faces};
    pick->hit = false;
    if (!stp_ray_of_pixel(view, x, y, &desc.ray)) {
        return false;
    }
    // a point can be picked within a few pixels
    stp_pixel_width(view, &desc.point_base, &desc.point_slope);
    desc.point_base *= 2.0;
    desc.point_slope *= 2.0;
    stp_result result = stp_pick_ray(e->context, e->store, &desc, pick);
    return result == STP_OK && pick->hit;
}

/// Expands the rows down to an item.
static void reveal(explorer* e, const stp_outline_item* item)
{
    for (size_t i = 0; i < e->row_count; ++i) {
        explorer_row* r = &e->rows[i];
        if (is_above(&r->item, item) && r->item.depth < item->depth && !r->open) {
            explorer_fold(e, i);
        }
    }
    e->scrolls = true;
}

void explorer_choose(explorer* e, const stp_outline_item* item, bool reveals)
{
    e->chosen = item != NULL ? *item : (stp_outline_item){0};
    if (item != NULL && reveals && e->ready) {
        reveal(e, item);
    }
}

void explorer_choose_picked(explorer* e, const stp_pick* pick)
{
    stp_outline_item item = {0};
    if (pick != NULL && e->ready &&
        stp_outline_find(e->outline, pick->part, &pick->holder.transform, &item) != STP_OK) {
        item.depth = 0;
    }
    explorer_choose(e, item.depth > 0 ? &item : NULL, true);
}

bool explorer_item_box(explorer* e, const stp_outline_item* item, stp_boxd* box)
{
    stp_outline_row row;
    bool any = item->depth > 0 && item->node != STP_STORE_NONE && e->ready &&
               stp_outline_describe(e->outline, item, &row) == STP_OK &&
               !stp_boxd_is_empty(row.bounds);
    *box = any ? row.bounds : *box;
    return any;
}

bool explorer_chosen_box(explorer* e, stp_boxd* box)
{
    *box = stp_boxd_empty();
    return explorer_item_box(e, &e->chosen, box);
}

static void apply_marks(explorer* e)
{
    shown_list list;
    e->marks_version += 1;
    if (explorer_list_shown(e, &list)) {
        (void)shown_list_apply(&list, e->visibility);
        free(list.objects);
    }
}

/// Whether a mark changes all other parts.
static bool is_alone(explorer_how how)
{
    return how == EXPLORER_ISOLATED || how == EXPLORER_FOCUSED;
}

void explorer_mark_item(explorer* e, const stp_outline_item* item, explorer_how how)
{
    if (item->depth == 0 || item->node == STP_STORE_NONE) {
        return;
    }
    bool was = false;
    size_t kept = 0;
    for (size_t i = 0; i < e->mark_count; ++i) {
        bool same = explorer_is_same(&e->marks[i].item, item);
        was = was || (same && e->marks[i].how == how);
        bool goes = same || (is_alone(how) && is_alone(e->marks[i].how));
        if (!goes) {
            e->marks[kept++] = e->marks[i];
        }
    }
    e->mark_count = kept;
    void* marks = e->marks;
    if (!was && grow(&marks, &e->mark_capacity, kept + 1, sizeof(e->marks[0]))) {
        e->marks = marks;
        e->marks[e->mark_count++] = (explorer_mark){*item, how};
    }
    apply_marks(e);
}

bool explorer_is_marked(const explorer* e, const stp_outline_item* item, explorer_how how)
{
    for (size_t i = 0; i < e->mark_count; ++i) {
        if (e->marks[i].how == how && is_above(&e->marks[i].item, item)) {
            return true;
        }
    }
    return false;
}

void explorer_show_all(explorer* e)
{
    e->mark_count = 0;
    apply_marks(e);
}

bool explorer_list_shown(const explorer* e, shown_list* list)
{
    static const stp_show shows[] = {[EXPLORER_ISOLATED] = STP_SHOW,
                                     [EXPLORER_FOCUSED] = STP_SHOW,
                                     [EXPLORER_GHOST] = STP_SHOW_GHOST,
                                     [EXPLORER_HIDDEN] = STP_SHOW_NOT};
    static const explorer_how order[] = {EXPLORER_ISOLATED, EXPLORER_FOCUSED, EXPLORER_GHOST,
                                         EXPLORER_HIDDEN};
    *list = (shown_list){.whole = STP_SHOW};
    list->objects = malloc((e->mark_count + 1) * sizeof(*list->objects));
    for (size_t k = 0; list->objects != NULL && k < 4; ++k) {
        for (size_t i = 0; i < e->mark_count; ++i) {
            const explorer_mark* m = &e->marks[i];
            if (m->how == order[k]) {
                list->objects[list->count++] =
                    (shown_object){{m->item.node, m->item.transform}, shows[m->how]};
                list->whole = m->how == EXPLORER_ISOLATED  ? STP_SHOW_NOT
                              : m->how == EXPLORER_FOCUSED ? STP_SHOW_GHOST
                                                           : list->whole;
            }
        }
    }
    assert((list->objects == NULL || list->count == e->mark_count) && "every mark is listed");
    return list->objects != NULL;
}

stp_result shown_list_apply(const shown_list* list, stp_visibility* visibility)
{
    stp_visibility_reset(visibility, list->whole);
    stp_result result = STP_OK;
    for (size_t i = 0; result == STP_OK && i < list->count; ++i) {
        result = stp_visibility_set(visibility, &list->objects[i].placed, list->objects[i].show);
    }
    return result;
}
