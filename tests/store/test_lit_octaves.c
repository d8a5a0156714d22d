// SPDX-License-Identifier: MIT
// Octaves with light normals: read as written, also in parts, and refused where they cannot be.
#include "support_chunks.h"
#include "support_reseal.h"
#include "tests.h"

#include "base/splats/light_normal.h"
#include "draw/support_store.h"
#include "store/bytes/chunks.h"
#include "store/file/store_state.h"
#include "store/sets/sets_internal.h"

#include <stdlib.h>
#include <string.h>
#include <unistd.h>

static const uint8_t white[3] = {255, 255, 255};

/// A square of 16 splats in one octave, with light normals if `lit`.
static void make_scene(stp_context* context, made_scene* scene, bool lit)
{
    *scene = (made_scene){.material_count = 1, .shading_count = 1, .node_count = 1};
    scene->materials[0] = made_material();
    scene->shadings[0] = (stp_shading){.roughness = 1};
    stp_splats* set = &scene->sets[scene->set_count++];
    *set = made_square_set(context, 2, white);
    scene->nodes[0] =
        (stp_store_node){.set = 0, .point_count = 16, .bounds = {{-1, -1, 0}, {1, 1, 0}}};
    if (lit) {
        set->turns = STP_NEW_ZEROED(context, int8_t, 2 * (size_t)set->count);
        set->spreads = STP_NEW_ZEROED(context, uint8_t, set->count);
        set->light_octaves = 1;
        for (uint32_t i = 0; i < set->count; ++i) {
            set->turns[2 * (size_t)i] = (int8_t)(3 * i);
            set->turns[2 * (size_t)i + 1] = (int8_t)(-5 * (int)i);
            set->spreads[i] = (uint8_t)(200 - i);
        }
    }
}

void test_light_normals_are_read_as_written(test_state* test)
{
    stp_context* context = test_context(NULL, 1, NULL);
    for (int lit = 0; lit < 2; ++lit) {
        made_scene scene;
        make_scene(context, &scene, lit != 0);
        stp_store* store = made_open(context, &scene);
        CHECK(store != NULL);
        CHECK_EQUAL(lit != 0 ? STP_STORE_MINOR_LIT : STP_STORE_MINOR,
                    stp_store_format_minor(store));
        stp_splats got;
        CHECK_EQUAL(STP_OK, stp_store_get_splat_set(store, 0, &got));
        CHECK_EQUAL(lit, got.light_octaves);
        CHECK((got.turns != NULL) == (lit != 0) && (got.spreads != NULL) == (lit != 0));
        CHECK(lit == 0 || memcmp(got.turns, scene.sets[0].turns, 2 * (size_t)got.count) == 0);
        CHECK(lit == 0 || memcmp(got.spreads, scene.sets[0].spreads, got.count) == 0);
        CHECK_EQUAL(lit != 0 ? STP_STORE_ENCODING_LIT : STP_STORE_ENCODING_CHUNKS,
                    stp_store_octave_block(store, 0, 0)->encoding);
        stp_store_close(store);
        made_free_set(context, &scene.sets[0]);
    }
    stp_context_destroy(context);
}

/// Finds the entry of the first block of splats.
static unsigned char* find_block(unsigned char* bytes)
{
    unsigned char* entry = find_section(bytes, STP_SECTION_BLOCKS);
    unsigned char* block = bytes + stp_read_u64(entry + 8);
    while (stp_read_u32(block) != STP_BLOCK_SPLATS) {
        block += 40;
    }
    return block;
}

static stp_result open_all(stp_context* context, const unsigned char* bytes, size_t size)
{
    stp_store* store = NULL;
    stp_splats got;
    stp_result result =
        stp_store_open_memory(context, "lit", bytes, size, &(stp_store_open_desc){0}, &store);
    result = result == STP_OK ? stp_store_get_splat_set(store, 0, &got) : result;
    stp_store_close(store);
    return result;
}

void test_invalid_light_normals_are_refused(test_state* test)
{
    test_log log = {.errors = 0};
    stp_context* context = test_context(NULL, 1, &log);
    for (int lit = 0; lit < 2; ++lit) {
        made_scene scene;
        size_t size = 0;
        make_scene(context, &scene, lit != 0);
        unsigned char* bytes = made_file_bytes(context, &scene, &size);
        made_free_set(context, &scene.sets[0]);
        CHECK(bytes != NULL && open_all(context, bytes, size) == STP_OK);
        unsigned char* block = find_block(bytes);
        for (uint32_t encoding = 0; encoding < 6; ++encoding) {
            uint32_t own = lit != 0 ? STP_STORE_ENCODING_LIT : STP_STORE_ENCODING_CHUNKS;
            stp_write_u32(block + 36, encoding);
            reseal(bytes, size);
            bool unknown =
                encoding > STP_STORE_ENCODING_LIT || encoding == STP_STORE_ENCODING_OPERATORS;
            stp_result result = open_all(context, bytes, size);
            CHECK_EQUAL(encoding == own ? STP_OK
                        : unknown       ? STP_ERROR_UNSUPPORTED
                                        : STP_ERROR_FORMAT,
                        result);
            CHECK(!unknown || strstr(log.text, "unknown encoding") != NULL);
        }
        free(bytes);
    }
    stp_context_destroy(context);
}

void test_damaged_light_normals_are_refused(test_state* test)
{
    test_log log = {.errors = 0};
    stp_context* context = test_context(NULL, 1, &log);
    made_scene scene;
    size_t size = 0;
    make_scene(context, &scene, true);
    unsigned char* bytes = made_file_bytes(context, &scene, &size);
    made_free_set(context, &scene.sets[0]);
    CHECK(bytes != NULL);
    unsigned char* block = find_block(bytes);
    size_t first = (size_t)stp_read_u64(block + 16), stored = (size_t)stp_read_u64(block + 24);
    for (size_t i = first; i < first + stored; ++i) { // the checksum
        bytes[i] ^= 0x20;
        CHECK_EQUAL(STP_ERROR_FORMAT, open_all(context, bytes, size));
        bytes[i] ^= 0x20;
    }
    for (size_t cut = first; cut < first + stored;
         ++cut) { // it ends early: the octave is not there
        unsigned char* part = malloc(cut + 1);
        CHECK(part != NULL);
        memcpy(part, bytes, cut);
        CHECK(open_all(context, part, cut) != STP_OK);
        stp_store* store = NULL;
        stp_splats got;
        CHECK_EQUAL(STP_OK,
                    stp_store_open_memory(context, "part", part, cut,
                                          &(stp_store_open_desc){.accept_partial = true}, &store));
        CHECK_EQUAL(STP_OK, stp_store_get_splat_set(store, 0, &got));
        CHECK(got.count == 0 && got.light_octaves == 0);
        stp_store_close(store);
        free(part);
    }
    free(bytes);
    stp_context_destroy(context);
}

/// Octaves that are read one after the other keep the light normals of those before.
void test_light_normals_come_octave_by_octave(test_state* test)
{
    stp_context* context = test_context(NULL, 2, NULL);
    stp_arena arena = stp_arena_create(context, 1 << 20);
    chunk_sample made;
    CHECK(chunk_sample_make(&arena, 6, &made));
    char path[64] = "stipple-lit-XXXXXX";
    int file = mkstemp(path);
    CHECK(file >= 0);
    close(file);
    CHECK_EQUAL(STP_OK, stp_store_write(context, &made.content, path));
    stp_store* store = NULL;
    CHECK_EQUAL(STP_OK, stp_store_open(context, path, &store));
    unlink(path);
    for (uint32_t octaves = 1; octaves <= made.sets[0].octave_count; ++octaves) {
        stp_splats got, wanted = made.sets[0];
        CHECK_EQUAL(STP_OK, stp_store_get_splat_set_prefix(store, 0, octaves, &got));
        stp_store_truncate_splat_set(&wanted, octaves);
        wanted.paper_count = got.paper_count;
        size_t lights = (size_t)stp_light_normals_begin(&wanted, octaves);
        CHECK_EQUAL(wanted.light_octaves, got.light_octaves);
        CHECK(memcmp(got.turns, wanted.turns, 2 * lights) == 0);
        CHECK(memcmp(got.spreads, wanted.spreads, lights) == 0);
    }
    stp_store_close(store);
    stp_arena_destroy(&arena);
    stp_context_destroy(context);
}
