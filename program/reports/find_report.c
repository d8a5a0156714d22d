// SPDX-License-Identifier: MIT
#include "program/options/tool.h"
#include "program/reports/describe.h"
#include "program/reports/reports.h"
#include "store/outline/outline.h"

#include <stdio.h>

enum { PATH_ROOM = 4096, AT_ONCE = 64, SLICE = 100000 };

/// Prints an object, or adds it to the list.
static stp_result report_object(stp_outline* outline, uint32_t object, json_t* list)
{
    stp_outline_item item;
    stp_outline_row row;
    char path[PATH_ROOM];
    stp_result result = stp_outline_item_of(outline, object, &item);
    result = result == STP_OK ? stp_outline_describe(outline, &item, &row) : result;
    result = result == STP_OK ? stp_outline_path(outline, &item, path, sizeof(path)) : result;
    if (result != STP_OK) {
        return result;
    }
    if (list == NULL) {
        printf("#%u\t%llu triangles, %llu points\t", object, (unsigned long long)row.triangle_count,
               (unsigned long long)row.point_count);
        describe_text(path);
        printf("\n");
        return STP_OK;
    }
    json_t* json =
        json_pack("{s:I, s:o, s:o, s:o, s:I, s:I, s:I}", "index", (json_int_t)object, "name",
                  describe_json_text(row.name), "path", describe_json_text(path), "id",
                  describe_json_text(row.id), "children", (json_int_t)row.child_count, "triangles",
                  (json_int_t)row.triangle_count, "points", (json_int_t)row.point_count);
    return json_array_append_new(list, json) == 0 ? STP_OK : STP_ERROR_OUT_OF_MEMORY;
}

static stp_result find(stp_outline* outline, const char* text, json_t* list, bool* more)
{
    stp_outline_search search = stp_outline_search_begin(text);
    uint32_t all = stp_outline_object_count(outline), reported = 0;
    bool ready;
    stp_result result = stp_outline_prepare(outline, 0, &ready);
    while (result == STP_OK && search.next < all && !*more) {
        uint32_t objects[AT_ONCE], count;
        result = stp_outline_search_on(outline, &search, SLICE, AT_ONCE, objects, &count);
        for (uint32_t i = 0; i < count && result == STP_OK && !*more; ++i) {
            *more = reported == FIND_MAX;
            result = *more ? STP_OK : report_object(outline, objects[i], list);
            reported += 1;
        }
    }
    return result;
}

int find_print(stp_context* context, stp_store* store, const char* text, bool as_json)
{
    stp_outline* outline;
    json_t* list = as_json ? json_array() : NULL;
    bool more = false;
    stp_result result = stp_outline_create(context, store, &outline);
    if (result == STP_OK) {
        result = find(outline, text, list, &more);
    }
    stp_outline_destroy(outline);
    if (result != STP_OK) {
        json_decref(list);
        return 1;
    }
    if (as_json) {
        json_t* json = json_pack("{s:o, s:b}", "found", list, "more", more);
        return json != NULL ? tool_print_json(json) : tool_error("out of memory");
    }
    if (more) {
        stp_warn(context, "more than %d objects match; the others are not listed", FIND_MAX);
    }
    return tool_finish_output(0);
}
