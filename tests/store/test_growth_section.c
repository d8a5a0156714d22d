// SPDX-License-Identifier: MIT
// Growths of shadings: written if there are any, read back, and refused if invalid.
#include "support_reseal.h"
#include "tests.h"

#include "draw/support_store.h"
#include "store/bytes/format.h"
#include "store/file/store_state.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

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

/// Bytes of a file of two shadings, whose growths are 0 and 3; free them.
static unsigned char* make_file(stp_context* context, size_t* size)
{
    made_scene scene;
    make_scene(context, &scene, 3.0f);
    unsigned char* bytes = made_file_bytes(context, &scene, size);
    made_free_set(context, &scene.sets[0]);
    return bytes;
}

void test_invalid_growths_are_refused(test_state* test)
{
    // then a valid one, and one record of two growths
    const float values[] = {-1.0f, 64.0f, NAN, INFINITY, -INFINITY, 2.0f, 2.0f};
    for (int i = 0; i < 7; ++i) {
        test_log log = {.errors = 0};
        stp_context* context = test_context(NULL, 1, &log);
        size_t size = 0;
        unsigned char* bytes = make_file(context, &size);
        CHECK(bytes != NULL);
        unsigned char* entry = find_section(bytes, STP_SECTION_GROWTHS);
        CHECK(entry != NULL && stp_read_u64(entry + 16) == 8); // not packed
        uint32_t bits;
        memcpy(&bits, &values[i], sizeof(bits));
        stp_write_u32(bytes + stp_read_u64(entry + 8) + 4, bits);
        if (i == 6) {
            stp_write_u64(entry + 24, 1);
            stp_write_u32(entry + 32, 8);
        }
        reseal(bytes, size);
        stp_store* store = NULL;
        CHECK_EQUAL(i == 5 ? STP_OK : STP_ERROR_FORMAT,
                    stp_store_open_memory(context, "growths", bytes, size,
                                          &(stp_store_open_desc){0}, &store));
        CHECK_EQUAL(i == 5 ? 0 : 1, log.errors);
        CHECK(i == 5 || strstr(log.text, i == 6 ? "lists the growths of 1" : "growth") != NULL);
        stp_store_close(store);
        free(bytes);
        stp_context_destroy(context);
    }
}
