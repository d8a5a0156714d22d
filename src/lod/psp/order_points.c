// SPDX-License-Identifier: MIT
// Copies points into tree order. If they do not fit in memory, random disk access must be avoided,
// so they are copied window by window. A window's points are read in input order, and written to
// their positions within the window.
#include "base/core/sort.h"
#include "lod/psp/rounds.h"

#include <assert.h>
#include <string.h>

enum {
    WINDOW = 1 << 20, ///< points per window
    GRAIN = 1 << 14,
};

/// An array of point data.
typedef struct column {
    const uint8_t* from;
    uint8_t* to;
    size_t size; ///< bytes per point
} column;

enum { COLUMNS_MAX = 4 };

typedef struct copier {
    const stp_psp_rounds* rounds;
    uint64_t *items, *scratch; ///< index << 32 | place, for a window
    const uint64_t* sorted;
    uint32_t first; ///< first place of the window
    column columns[COLUMNS_MAX];
    uint32_t column_count;
} copier;

static void list_points(size_t begin, size_t end, uint32_t worker, void* user)
{
    const copier* c = user;
    (void)worker;
    for (size_t i = begin; i < end; ++i) {
        uint32_t place = c->first + (uint32_t)i;
        c->items[i] = (uint64_t)stp_kd_index(&c->rounds->tree, place) << 32 | place;
    }
}

static void copy_points(size_t begin, size_t end, uint32_t worker, void* user)
{
    const copier* c = user;
    (void)worker;
    for (size_t i = begin; i < end; ++i) {
        size_t from = (size_t)(c->sorted[i] >> 32), to = (uint32_t)c->sorted[i];
        assert(to >= c->first && to - c->first < WINDOW && "writes stay in the window");
        for (uint32_t k = 0; k < c->column_count; ++k) {
            size_t size = c->columns[k].size;
            memcpy(c->columns[k].to + to * size, c->columns[k].from + from * size, size);
        }
    }
}

/// @return the copy, to be filled; NULL if there is nothing to copy or no space
static void* add_column(copier* c, const void* from, size_t size)
{
    uint32_t count = c->rounds->shared.points->count;
    void* to = from != NULL
                   ? stp_psp_room_alloc(&c->rounds->rooms[STP_PSP_ROOM_POINTS], count, size)
                   : NULL;
    if (to != NULL) {
        assert(c->column_count < COLUMNS_MAX);
        c->columns[c->column_count++] = (column){from, to, size};
    }
    return to;
}

/// @return false if there is no space
static bool add_columns(copier* c, stp_psp_points* to)
{
    const stp_psp_points* from = c->rounds->shared.points;
    size_t color = from->color_bytes != 0 ? from->color_bytes : 3;
    // only this metric reads the points again
    bool again = c->rounds->shared.desc.metric == STP_PSP_DISTANCES;
    to->positions = again ? add_column(c, from->positions, 3 * sizeof(float)) : NULL;
    to->normals = add_column(c, from->normals, 3 * sizeof(float));
    to->colors = add_column(c, from->colors, color);
    to->areas = add_column(c, from->areas, sizeof(float));
    return (to->positions != NULL || !again) && (to->normals != NULL || from->normals == NULL) &&
           (to->colors != NULL || from->colors == NULL) &&
           (to->areas != NULL || from->areas == NULL);
}

static bool copy_windows(copier* c)
{
    const stp_psp_rounds* r = c->rounds;
    stp_context* context = r->shared.context;
    uint32_t count = r->tree.count;
    for (c->first = 0; c->column_count > 0 && c->first < count;) {
        uint32_t left = count - c->first, size = left < WINDOW ? left : WINDOW;
        stp_parallel_for(context, size, GRAIN, list_points, c);
        c->sorted = stp_parallel_sort_u64(context, c->items, c->scratch, size, 32, 32);
        if (c->sorted == NULL) {
            return false;
        }
        stp_parallel_for(context, size, GRAIN, copy_points, c);
        stp_psp_rounds_release(r, 0);
        c->first += size;
    }
    return true;
}

stp_result stp_psp_order_points(stp_psp_rounds* r)
{
    if (r->storage.beside == NULL || r->tree.count == 0) {
        return STP_OK;
    }
    stp_context* context = r->shared.context;
    copier c = {.rounds = r};
    size_t room = r->tree.count < WINDOW ? r->tree.count : WINDOW;
    c.items = STP_NEW_ARRAY(context, uint64_t, room);
    c.scratch = STP_NEW_ARRAY(context, uint64_t, room);
    r->points = *r->shared.points;
    bool made =
        c.items != NULL && c.scratch != NULL && add_columns(&c, &r->points) && copy_windows(&c);
    stp_free(context, c.items);
    stp_free(context, c.scratch);
    if (made) {
        r->shared.points = &r->points;
        r->in_tree_order = true;
    }
    return made ? STP_OK : stp_psp_storage_fail(&r->storage);
}
