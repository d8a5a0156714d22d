// SPDX-License-Identifier: MIT
// Normal maps of materials: written if there are any, read back, and refused if invalid.
#include "support_reseal.h"
#include "tests.h"

#include "draw/support_store.h"
#include "store/bytes/format.h"
#include "store/file/normal_maps.h"
#include "store/file/store_state.h"
#include "store/file/tables.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

static uint8_t texel[4] = {128, 128, 255, 255};

static void make_scene(made_scene* scene, bool mapped)
{
    *scene = (made_scene){
        .material_count = 3, .texture_count = 2, .mesh_count = 1, .part_count = 1, .node_count = 1};
    for (uint32_t i = 0; i < 3; ++i) {
        scene->materials[i] = made_material();
        scene->textures[i] = (stp_store_texture){.width = 1, .height = 1, .texels = texel};
    }
    for (uint32_t i = 1; i < 3 && mapped; ++i) {
        scene->materials[i].normal_scale = i == 1 ? -0.5f : 2.0f;
        scene->materials[i].normal_texture = (stp_store_texture_use){
            .texture = 2 - i, .texcoord = i - 1, .transform = {{1, 0, 0.25f}, {0, 2, 0}}};
    }
    scene->meshes[0] = made_square(1);
    scene->parts[0] = (stp_store_part){STP_STORE_PART_MESH, 0};
    scene->nodes[0] = (stp_store_node){.part_count = 1,
                                       .set = STP_STORE_NONE,
                                       .triangle_count = 2,
                                       .bounds = {{-1, -1, 0}, {1, 1, 0}}};
}

void test_normal_maps_are_read_as_written(test_state* test)
{
    stp_context* context = test_context(NULL, 1, NULL);
    static made_scene scene;
    make_scene(&scene, false);
    stp_store* store = made_open(context, &scene);
    CHECK(store != NULL && store->known[STP_SECTION_NORMAL_MAPS] == NULL);
    CHECK_EQUAL(STP_STORE_MINOR, stp_store_format_minor(store));
    stp_store_close(store);
    make_scene(&scene, true);
    store = made_open(context, &scene);
    CHECK(store != NULL && store->known[STP_SECTION_NORMAL_MAPS] != NULL);
    CHECK((store->known[STP_SECTION_NORMAL_MAPS]->flags & STP_SECTION_CRITICAL) == 0); // to skip
    CHECK_EQUAL(STP_STORE_MINOR_NORMAL_MAPS, stp_store_format_minor(store));
    const stp_store_directory* d = stp_store_get_directory(store);
    CHECK(d->materials[0].normal_scale == 0.0f);
    for (uint32_t i = 1; i < 3; ++i) {
        const stp_store_texture_use* use = &d->materials[i].normal_texture;
        CHECK(d->materials[i].normal_scale == scene.materials[i].normal_scale);
        CHECK_EQUAL(2 - i, use->texture);
        CHECK_EQUAL(i - 1, use->texcoord);
        CHECK(use->transform[0][2] == 0.25f && use->transform[1][1] == 2.0f);
    }
    stp_store_close(store);
    stp_context_destroy(context);
}

void test_invalid_normal_maps_are_refused(test_state* test)
{
    for (int way = 0; way < 9; ++way) {
        test_log log = {.errors = 0};
        stp_context* context = test_context(NULL, 1, &log);
        static made_scene scene;
        make_scene(&scene, true);
        stp_store* store = made_open(context, &scene);
        CHECK(store != NULL);
        CHECK_EQUAL(2, store->counts[STP_SECTION_NORMAL_MAPS]);
        stp_store_normal_map* r = store->tables[STP_SECTION_NORMAL_MAPS];
        r[1].material = way == 0 ? 3 : way == 1 ? 1 : 2;
        r[0].material = way == 2 ? 2 : 1;
        r[0].use.texture = way == 3 ? STP_STORE_NONE : way == 4 ? 2 : 1;
        r[0].use.texcoord = way == 5 ? 2 : 0;
        r[0].scale = way == 6 ? 0.0f : way == 7 ? NAN : 1.0f;
        stp_result result = stp_store_link_normal_maps(store);
        stp_store_validator validator = stp_store_own_validator(store);
        result =
            result == STP_OK ? stp_store_validate_graph(&validator, &store->directory) : result;
        CHECK_EQUAL(way < 8 ? STP_ERROR_FORMAT : STP_OK, result);
        CHECK_EQUAL(way < 8 ? 1 : 0, log.errors);
        stp_store_close(store);
        // the writer refuses what readers do
        scene.materials[2].normal_texture.texture = way == 8 ? 2 : 0;
        scene.materials[2].normal_scale = way == 7 ? INFINITY : 1.0f;
        store = made_open(context, &scene);
        CHECK((store == NULL) == (way >= 7));
        stp_store_close(store);
        stp_context_destroy(context);
    }
}

/// Bytes of the file of a scene with normal maps; free them. NULL on failure.
static unsigned char* make_file(stp_context* context, size_t* size)
{
    static made_scene scene;
    make_scene(&scene, true);
    return made_file_bytes(context, &scene, size);
}

static stp_result open_bytes(stp_context* context, const unsigned char* bytes, size_t size)
{
    stp_store* store = NULL;
    stp_result result =
        stp_store_open_memory(context, "maps", bytes, size, &(stp_store_open_desc){0}, &store);
    stp_store_close(store);
    return result;
}

void test_damaged_normal_maps_are_refused(test_state* test)
{
    stp_context* context = test_context(NULL, 1, NULL);
    size_t size = 0;
    unsigned char* bytes = make_file(context, &size);
    CHECK(bytes != NULL && open_bytes(context, bytes, size) == STP_OK);
    unsigned char* entry = find_section(bytes, STP_SECTION_NORMAL_MAPS);
    CHECK(entry != NULL && stp_read_u64(entry + 16) == 80); // not packed
    size_t first = (size_t)stp_read_u64(entry + 8);
    for (size_t i = first; i < first + 80; ++i) { // checksums
        bytes[i] ^= 0x10;
        CHECK(open_bytes(context, bytes, size) != STP_OK);
        bytes[i] ^= 0x10;
    }
    for (size_t cut = 0; cut < first + 81; ++cut) { // it ends early
        unsigned char* part = malloc(cut + 1);
        CHECK(part != NULL);
        memcpy(part, bytes, cut);
        CHECK(open_bytes(context, part, cut) != STP_OK);
        free(part);
    }
    free(bytes);
    stp_context_destroy(context);
}
