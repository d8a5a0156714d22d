// SPDX-License-Identifier: MIT
#include "program/drawing/drawing.h"
#include "program/options/command.h"
#include "select/camera.h"

#include <assert.h>
#include <stdio.h>
#include <string.h>

enum { NAMES_MAX = 32 }; ///< maximum number of listed names; others are counted

typedef struct name_list {
    char text[2048];
    size_t used;
    uint32_t count, left_out;
} name_list;

static void add_name(name_list* list, const char* name)
{
    size_t room = sizeof(list->text) - list->used;
    if (list->count == NAMES_MAX || strlen(name) + 3 > room) {
        list->left_out += 1;
        return;
    }
    int length = snprintf(list->text + list->used, room, "%s%s", list->count > 0 ? ", " : "", name);
    list->used += (size_t)length;
    assert(list->used < sizeof(list->text) && "no name is truncated");
    list->count += 1;
}

int view_list_refuse(const char* name, const stp_store* store, const stp_viewpoints* viewpoints)
{
    name_list list = {.used = 0};
    const stp_store_directory* directory = stp_store_get_directory(store);
    for (uint32_t i = 0; i < directory->view_count; ++i) {
        if (directory->views[i].name != NULL) {
            add_name(&list, directory->views[i].name);
        }
    }
    for (size_t i = 0; i < viewpoints->count; ++i) {
        add_name(&list, viewpoints->views[i].name);
    }
    uint32_t left_out = list.left_out;
    name_list standard = {.used = 0};
    for (const char* const* s = stp_camera_names(); *s != NULL; ++s) {
        if ((*s)[0] != 'd') { // d0 to d25
            add_name(&standard, *s);
        }
    }
    char more[32] = "";
    if (left_out > 0) {
        snprintf(more, sizeof(more), " and %u more", left_out);
    }
    return tool_usage_error("there is no view named %.200s; there are %s, d0 to d25%s%s%s", name,
                            standard.text, list.used > 0 ? ", and of this scene: " : "", list.text,
                            more);
}
