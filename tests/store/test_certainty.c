// SPDX-License-Identifier: MIT
// Accuracy of sets: written if there is something to store, read back, and rejected if invalid.
#include "tests.h"

#include "draw/support_store.h"
#include "store/sets/sets_internal.h"

static const uint8_t white[3] = {255, 255, 255};

static void make_scene(stp_context* context, made_scene* scene)
{
    *scene =
        (made_scene){.material_count = 1, .shading_count = 1, .node_count = 2, .edge_count = 1};
    scene->materials[0] = made_material();
    scene->shadings[0] = (stp_shading){.roughness = 1};
    for (uint32_t i = 0; i < 2; ++i) {
        scene->sets[scene->set_count++] = made_square_set(context, 2, white);
        scene->nodes[i] =
            (stp_store_node){.set = i, .point_count = 16, .bounds = {{-1, -1, 0}, {1, 1, 0}}};
    }
    scene->nodes[1].edge_count = 1;
    scene->edges[0] = (stp_store_edge){0, stp_affine_identity()};
}

static void free_scene(stp_context* context, made_scene* scene)
{
    made_free_set(context, &scene->sets[0]);
    made_free_set(context, &scene->sets[1]);
}

void test_certainty_is_read_as_written(test_state* test)
{
    stp_context* context = test_context(NULL, 1, NULL);
    made_scene scene;
    make_scene(context, &scene);
    scene.sets[1].unknown_signs = true;
    scene.sets[0].position_error = 0.25f;
    stp_store* store = made_open(context, &scene);
    CHECK(store != NULL && store->known[STP_SECTION_CERTAINTY] != NULL);
    const stp_splats* first = stp_store_describe_splat_set(store, 0);
    const stp_splats* second = stp_store_describe_splat_set(store, 1);
    CHECK(!first->unknown_signs && first->position_error == 0.25f);
    CHECK(second->unknown_signs && second->position_error == 0.0f);
    CHECK(stp_store_position_error(store) == 0.25);
    stp_splats got; // the drawn set has it, too
    CHECK_EQUAL(STP_OK, stp_store_get_splat_set(store, 1, &got));
    CHECK(got.unknown_signs);
    stp_store_close(store);
    scene.sets[1].unknown_signs = false;
    scene.sets[0].position_error = 0.0f;
    store = made_open(context, &scene); // nothing to store: no section
    CHECK(store != NULL && store->known[STP_SECTION_CERTAINTY] == NULL);
    CHECK(stp_store_position_error(store) == 0.0);
    stp_store_close(store);
    free_scene(context, &scene);
    stp_context_destroy(context);
}

void test_invalid_certainty_is_refused(test_state* test)
{
    for (int way = 0; way < 3; ++way) {
        test_log log = {.errors = 0};
        stp_context* context = test_context(NULL, 1, &log);
        made_scene scene;
        make_scene(context, &scene);
        scene.sets[1].unknown_signs = true;
        stp_store* store = made_open(context, &scene);
        CHECK(store != NULL);
        stp_store_certainty* records = store->tables[STP_SECTION_CERTAINTY];
        records[0].flags = way == 0 ? 2 : 0;
        records[1].position_error = way == 1 ? -1.0f : 0.0f;
        store->counts[STP_SECTION_CERTAINTY] = way == 2 ? 1 : 2;
        CHECK_EQUAL(STP_ERROR_FORMAT, stp_store_link_certainty(store));
        CHECK_EQUAL(1, log.errors);
        stp_store_close(store);
        free_scene(context, &scene);
        stp_context_destroy(context);
    }
}
