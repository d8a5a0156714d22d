// SPDX-License-Identifier: MIT
#include "store/file/content_sizes.h"

#include <assert.h>
#include <string.h>

// Computes the statistics with the given census, or with a guessed one.
static stp_result count_figures(stp_context* context, const stp_store_sizes* sizes,
                                const stp_store_census* census, stp_store_summary* summary)
{
    stp_store_census guessed = {0};
    stp_result result = STP_OK;
    if (census == NULL) {
        result = stp_store_guess_census(context, sizes->directory, &guessed);
    }
    if (result == STP_OK) {
        const stp_store_census* used = census != NULL ? census : &guessed;
        result = stp_store_count_figures(context, sizes, used, census != NULL, summary);
    }
    // the names of its parts are the objects', but for "others", which is static
    stp_store_census_destroy(context, &guessed);
    return result;
}

stp_result stp_store_summarise_planned(stp_context* context, const stp_store_content* content,
                                       const stp_store_plan* plan, stp_store_summary* summary)
{
    stp_store_sizes sizes;
    *summary = (stp_store_summary){0};
    stp_result result = stp_store_sizes_of_plan(context, content, plan, &sizes);
    if (result == STP_OK) {
        result = count_figures(context, &sizes, content->census, summary);
        stp_store_sizes_destroy(context, &sizes);
    }
    return result;
}

stp_result stp_store_summarise_content(stp_context* context, const stp_store_content* content,
                                       stp_store_summary* summary)
{
    stp_store_plan plan;
    *summary = (stp_store_summary){0};
    stp_result result = stp_store_plan_make(context, content, 0, &plan);
    if (result == STP_OK) {
        result = stp_store_summarise_planned(context, content, &plan, summary);
        stp_store_plan_destroy(context, &plan);
    }
    return result;
}

stp_result stp_store_summarise(stp_store* store, stp_store_summary* summary)
{
    stp_store_sizes sizes;
    *summary = (stp_store_summary){0};
    stp_result result = stp_store_load_objects(store);
    if (result == STP_OK) {
        result = stp_store_sizes_of_file(store, &sizes);
    }
    if (result == STP_OK) {
        result = count_figures(store->context, &sizes, NULL, summary);
        stp_store_sizes_destroy(store->context, &sizes);
    }
    return result;
}

void stp_store_summary_destroy(stp_context* context, stp_store_summary* summary)
{
    stp_free(context, summary->parts);
    *summary = (stp_store_summary){0};
}

// Whether the statistics derived from the graph match the stored ones. The input's own object
// counts are not in the graph.
static bool are_figures_right(const stp_store_figures* stored, const stp_store_figures* found)
{
    stp_store_figures known = *found;
    known.objects = stored->objects;
    known.unique_objects = stored->unique_objects;
    known.instances = stored->instances;
    return memcmp(stored, &known, sizeof(known)) == 0;
}

static bool is_box_equal(const stp_boxd* a, const stp_boxd* b)
{
    return a->min.x <= b->min.x && a->min.x >= b->min.x && a->min.y <= b->min.y &&
           a->min.y >= b->min.y && a->min.z <= b->min.z && a->min.z >= b->min.z &&
           a->max.x <= b->max.x && a->max.x >= b->max.x && a->max.y <= b->max.y &&
           a->max.y >= b->max.y && a->max.z <= b->max.z && a->max.z >= b->max.z;
}

// Some files count all stored nodes instead of those below the root.
static bool is_whole_right(const stp_store_summary* stored, const stp_store_summary* found,
                           uint32_t node_count)
{
    stp_store_figures figures = found->figures;
    if (stored->figures.unique_nodes == node_count) {
        figures.unique_nodes = node_count;
    }
    return are_figures_right(&stored->figures, &figures) &&
           is_box_equal(&stored->bounds, &found->bounds) &&
           stored->material_count == found->material_count &&
           stored->texture_count == found->texture_count &&
           stored->mesh_count == found->mesh_count &&
           stored->point_set_count == found->point_set_count;
}

stp_result stp_store_check_summary(stp_store* store)
{
    const stp_store_summary* stored = stp_store_get_summary(store);
    if (stored == NULL) {
        return STP_OK;
    }
    stp_context* context = store->context;
    stp_store_summary found = {0};
    stp_store_sizes sizes = {0};
    stp_store_census census = {.part_count = stored->part_count};
    census.parts = STP_NEW_ZEROED(context, stp_store_census_part, (size_t)stored->part_count + 1);
    stp_result result =
        census.parts != NULL ? stp_store_load_objects(store) : stp_fail_memory(context);
    for (uint32_t i = 0; result == STP_OK && i < stored->part_count; ++i) {
        census.parts[i].members = &stored->parts[i].object;
        census.parts[i].member_count = stored->parts[i].object != STP_STORE_NONE;
    }
    if (result == STP_OK) {
        result = stp_store_sizes_of_file(store, &sizes);
    }
    if (result == STP_OK) {
        result = stp_store_count_figures(context, &sizes, &census, true, &found);
        stp_store_sizes_destroy(context, &sizes);
    }
    stp_free(context, census.parts);
    if (result != STP_OK) {
        return result;
    }
    assert(found.part_count == stored->part_count);
    const char* wrong =
        is_whole_right(stored, &found, store->directory.node_count) ? NULL : "whole scene";
    for (uint32_t i = 0; i < stored->part_count; ++i) {
        if (stored->parts[i].object != STP_STORE_NONE &&
            !are_figures_right(&stored->parts[i].figures, &found.parts[i].figures)) {
            wrong = "scene part";
        }
    }
    stp_store_summary_destroy(context, &found);
    return wrong == NULL ? STP_OK
                         : stp_fail(context, STP_ERROR_FORMAT,
                                    "%s: the summary of a %s does not match the file's content",
                                    store->path, wrong);
}
