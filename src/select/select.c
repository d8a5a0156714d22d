// SPDX-License-Identifier: MIT
// Both passes of a selection.
#include "select/rule.h"
#include "select/select_internal.h"

#include <assert.h>

bool stp_quality_is_same(const stp_quality* a, const stp_quality* b)
{
    return a->splat_size == b->splat_size && a->splat_count == b->splat_count &&
           a->policy == b->policy && a->method == b->method && a->reference == b->reference &&
           a->splats_only == b->splats_only && a->nodes_only == b->nodes_only &&
           a->all_sides == b->all_sides && a->points_apart == b->points_apart &&
           a->cues_off == b->cues_off && a->early_switch == b->early_switch &&
           stp_fovea_is_same(&a->fovea, &b->fovea);
}

static stp_result begin(stp_selection* s, stp_context* context, stp_store* store,
                        const stp_view* view, const stp_quality* quality, stp_draw_list* list,
                        bool second_pass)
{
    *s = (stp_selection){.context = context,
                         .store = store,
                         .directory = stp_store_get_directory(store),
                         .quality = quality,
                         .sections = &view->sections,
                         .list = list,
                         .second_pass = second_pass};
    s->method = stp_store_find_method(s->directory, quality->method);
    bool has_methods = s->directory->method_count != 0;
    s->rule = stp_select_rule_of(has_methods ? s->directory->methods[s->method].id : 0);
    s->coarse_method = stp_select_coarse_method(s->directory, quality);
    s->draws_levels = stp_select_draws_levels(s);
    list->hidden_count = 0;
    list->mixes =
        s->directory->point_set_count > 0 || (s->directory->set_count > 0 && !quality->reference);
    list->splat_size = quality->splat_size >= 1.0f ? quality->splat_size : 1.0f;
    s->eye_count = stp_view_eye_count(view);
    assert(s->eye_count <= STP_EYES_MAX);
    stp_result result = stp_view_check(context, view);
    if (result != STP_OK) {
        return result;
    }
    for (uint32_t i = 0; i < s->eye_count; ++i) {
        stp_view one = stp_view_of_eye(view, i);
        (void)stp_view_frame_make(&one, &s->frames[i]); // was checked
    }
    if (!stp_fovea_is_valid(&quality->fovea)) {
        return stp_fail(context, STP_ERROR_ARGUMENT,
                        "quality: radii of the fovea's zones must ascend and factors be above 0");
    }
    result = stp_select_begin_requests(s);
    return result == STP_OK && s->directory->root != STP_STORE_NONE ? stp_select_find_graph(s)
                                                                    : result;
}

stp_result stp_select(stp_context* context, stp_store* store, const stp_view* view,
                      const stp_quality* quality, stp_draw_list* list)
{
    stp_selection s;
    list->count = list->run_count = list->first_pass_count = list->rejected_count = 0;
    list->splat_count = list->triangle_count = list->id_count = 0;
    list->extra_splats = list->extra_triangles = 0;
    list->node_count = 0;
    stp_result result = begin(&s, context, store, view, quality, list, false);
    if (result != STP_OK || s.directory->root == STP_STORE_NONE) {
        return result;
    }
    stp_select_entry root = {
        .node = s.directory->root,
        .sections = stp_sections_all(&view->sections),
        .shown = quality->visibility != NULL ? stp_visibility_root(quality->visibility) : STP_SHOW,
        .ancestor_switch_depth = HUGE_VAL,
        .level_depth = HUGE_VAL,
        .covered = HUGE_VAL,
        .eager = 1.0,
        .transform = stp_affine_identity()};
    result = stp_select_push(&s, &root);
    result = result == STP_OK ? stp_select_traverse(&s) : result;
    result = result == STP_OK ? stp_select_add_count(&s) : result;
    list->first_pass_count = list->count;
    return result;
}

stp_result stp_select_rejected(stp_context* context, stp_store* store, const stp_view* view,
                               const stp_quality* quality, stp_draw_list* list)
{
    stp_selection s;
    stp_result result = begin(&s, context, store, view, quality, list, true);
    assert(list->first_pass_count <= list->count && "the first pass filled the list");
    for (size_t i = 0; i < list->rejected_count && result == STP_OK; ++i) {
        result = stp_select_push(&s, &list->rejected[i]);
        result = result == STP_OK ? stp_select_traverse(&s) : result;
    }
    list->rejected_count = 0;
    return result;
}

void stp_draw_list_destroy(stp_context* context, stp_draw_list* list)
{
    stp_free(context, list->items);
    stp_free(context, list->runs);
    stp_free(context, list->stack);
    stp_free(context, list->rejected);
    stp_free(context, list->requests);
    stp_free(context, list->request_slots);
    stp_free(context, list->cuts);
    stp_free(context, list->shares);
    stp_free(context, list->cells);
    stp_free(context, list->parts);
    stp_select_destroy_graph(context, list->graph);
    *list = (stp_draw_list){0};
}
