// SPDX-License-Identifier: MIT
#include "scene/content_table.h"
#include "scene/finish_steps.h"

#include <assert.h>
#include <stdio.h>
#include <string.h>

#define DIGITS 12 // a number with its hyphen and the final zero

typedef struct naming {
    stp_scene* scene;
    stp_content_table names; ///< maps names to views
    uint32_t* holders;       ///< per view: the first one with its name
    uint32_t* next_numbers;  ///< per view: the smallest number that may be free for its name
    char* text;              ///< room for the longest name with a number
    size_t text_size;
} naming;

static stp_result find_holder(naming* n, const char* name, uint32_t view, uint32_t* holder)
{
    stp_hash hash = stp_hash_bytes((stp_hash){0}, name, strlen(name));
    return stp_content_table_find(n->scene->context, &n->names, hash, view, holder);
}

static stp_result find_holders(naming* n)
{
    const stp_scene* scene = n->scene;
    stp_result result = STP_OK;
    for (uint32_t i = 0; result == STP_OK && i < scene->view_count; ++i) {
        n->holders[i] = i;
        n->next_numbers[i] = 2;
        if (scene->views[i].name != NULL) {
            result = find_holder(n, scene->views[i].name, i, &n->holders[i]);
        }
    }
    return result;
}

// Used numbers are skipped once, so many views of one name cost no more than distinct ones.
static stp_result number_view(naming* n, uint32_t view)
{
    stp_scene* scene = n->scene;
    const char** name = &scene->views[view].name;
    assert(n->holders[view] < view && "an earlier view has the name");
    uint32_t* number = &n->next_numbers[n->holders[view]];
    uint32_t holder;
    stp_result result;
    do {
        snprintf(n->text, n->text_size, "%s-%u", *name, *number);
        *number += 1;
        result = find_holder(n, n->text, view, &holder);
    } while (result == STP_OK && holder != view);
    if (result != STP_OK) {
        return result;
    }
    *name = stp_arena_copy_text(&scene->text, n->text, strlen(n->text));
    return *name != NULL ? STP_OK : stp_fail_memory(scene->context);
}

stp_result stp_scene_distinguish_views(stp_scene* scene)
{
    stp_context* context = scene->context;
    naming n = {.scene = scene};
    if (scene->view_count < 2) {
        return STP_OK;
    }
    for (size_t i = 0; i < scene->view_count; ++i) {
        size_t size = scene->views[i].name != NULL ? strlen(scene->views[i].name) + DIGITS : 0;
        n.text_size = size > n.text_size ? size : n.text_size;
    }
    n.holders = STP_NEW_ARRAY(context, uint32_t, scene->view_count);
    n.next_numbers = STP_NEW_ARRAY(context, uint32_t, scene->view_count);
    n.text = STP_NEW_ARRAY(context, char, n.text_size + 1);
    stp_result result = n.holders != NULL && n.next_numbers != NULL && n.text != NULL
                            ? find_holders(&n)
                            : stp_fail_memory(context);
    for (uint32_t i = 0; result == STP_OK && i < scene->view_count; ++i) {
        result = n.holders[i] != i ? number_view(&n, i) : STP_OK;
    }
    stp_content_table_destroy(context, &n.names);
    stp_free(context, n.text);
    stp_free(context, n.next_numbers);
    stp_free(context, n.holders);
    return result;
}
