// SPDX-License-Identifier: MIT
// A stored scene of one set of method `stochastic`, for tests of what views take from its leaves.
#pragma once

#include "tests.h"

#include "draw/support_store.h"
#include "lod/set_columns.h"
#include "lod/stochastic/set.h"
#include "select/select.h"

typedef struct stochastic_scene {
    stp_context* context;
    made_scene made;
    stp_store* store;
    stp_store_leaves leaves;
    stp_draw_list list;
} stochastic_scene;

/// Makes the set of `count` points with normals. @return false after a failure; close it in any case
static inline bool stochastic_scene_open(stochastic_scene* s, const stp_leaf_desc* desc,
                                         float* positions, float* normals, uint32_t count,
                                         stp_boxd bounds)
{
    static const uint8_t shadings[1] = {0};
    *s = (stochastic_scene){.context = test_context(NULL, 1, NULL)};
    uint8_t* colors = calloc(count, 4);
    uint32_t* materials = calloc(count, sizeof(*materials));
    stp_candidates candidates = {.count = count,
                                 .positions = positions,
                                 .normals = normals,
                                 .colors = colors,
                                 .materials = materials};
    const stp_stochastic_source source = {.candidates = &candidates,
                                          .shading_of_material = shadings,
                                          .wanted = count,
                                          .has_normals = true};
    made_scene* m = &s->made;
    bool made = s->context != NULL && colors != NULL && materials != NULL &&
                stp_stochastic_make_set(s->context, &source, desc, &m->sets[0]) == STP_OK;
    free(colors);
    free(materials);
    m->node_count = m->shading_count = m->set_count = 1;
    m->nodes[0] = (stp_store_node){.point_count = count, .bounds = bounds};
    m->method = (stp_store_method){
        .name = "stochastic", .id = STP_METHOD_STOCHASTIC, .columns = STP_STOCHASTIC_COLUMNS};
    s->store = made ? made_open(s->context, m) : NULL;
    return s->store != NULL && stp_store_get_leaves(s->store, 0, &s->leaves) == STP_OK;
}

static inline void stochastic_scene_close(stochastic_scene* s)
{
    stp_draw_list_destroy(s->context, &s->list);
    stp_store_close(s->store);
    stp_splats_destroy(s->context, &s->made.sets[0]);
    stp_context_destroy(s->context);
}
