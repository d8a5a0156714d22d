// SPDX-License-Identifier: MIT
// Growths of shadings: written if there are any, read back, and refused if invalid.
#include "tests.h"

#include "draw/support_store.h"
#include "store/bytes/format.h"
#include "store/file/store_state.h"

#include <math.h>

static const uint8_t white[3] = {255, 255, 255};

static void make_scene(stp_context* context, made_scene* scene, float growth)
{
    *scene = (made_scene){.material_count = 1, .shading_count = 2, .node_count = 1};
    scene->materials[0] = made_material();
    scene->shadings[0] = (stp_shading){.roughness = 1};
    scene->shadings[1] = (stp_shading){.roughness = 1, .growth = growth};
    scene->sets[scene->set_count++] = made_square_set(context, 2, white);
    scene->nodes[0] =
        (stp_store_node){.set = 0, .point_count = 16, .bounds = {{-1, -1, 0}, {1, 1, 0}}};
}

void test_growths_are_read_as_written(test_state* test)
{
    stp_context* context = test_context(NULL, 1, NULL);
    const float values[] = {0.0f, 3.0f, -0.5f};
    for (int i = 0; i < 3; ++i) {
        made_scene scene;
        make_scene(context, &scene, values[i]);
        stp_store* store = made_open(context, &scene);
        CHECK(store != NULL);
        const stp_store_directory* d = stp_store_get_directory(store);
        CHECK((store->known[STP_SECTION_GROWTHS] != NULL) == (i > 0));
        CHECK_EQUAL(i > 0 ? STP_STORE_MINOR_GROWTHS : STP_STORE_MINOR,
                    stp_store_format_minor(store));
        CHECK(d->shadings[0].growth == 0.0f && d->shadings[1].growth == values[i]);
        stp_store_close(store);
        made_free_set(context, &scene.sets[0]);
    }
    stp_context_destroy(context);
}

void test_invalid_growths_are_refused(test_state* test)
{
    const float values[] = {-1.0f, 64.0f};
    for (int i = 0; i < 2; ++i) {
        test_log log = {.errors = 0};
        stp_context* context = test_context(NULL, 1, &log);
        made_scene scene;
        make_scene(context, &scene, values[i]);
        CHECK(made_open(context, &scene) == NULL);
        CHECK(log.errors > 0);
        made_free_set(context, &scene.sets[0]);
        stp_context_destroy(context);
    }
}
