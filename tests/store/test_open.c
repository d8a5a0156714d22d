// SPDX-License-Identifier: MIT
// The cost of opening, and what is deferred.
#include "support_reseal.h"
#include "support_sample.h"
#include "tests.h"

#include <string.h>
#include <unistd.h>

// KB of a mapped file that are resident in this process, from /proc/self/smaps; -1 without it.
static long resident_kb(const char* path)
{
    FILE* maps = fopen("/proc/self/smaps", "r");
    char line[600];
    long total = maps != NULL ? 0 : -1, value = 0;
    bool ours = false;
    while (maps != NULL && fgets(line, sizeof(line), maps) != NULL) {
        if (strstr(line, path) != NULL) {
            ours = true;
        } else if (ours && sscanf(line, "Rss: %ld kB", &value) == 1) {
            total += value;
            ours = false;
        }
    }
    if (maps != NULL) {
        fclose(maps);
    }
    return total;
}

void test_store_open_leaves_bulk_data_alone(test_state* test)
{
    char path[256];
    const char* folder = getenv("TMPDIR");
    snprintf(path, sizeof(path), "%s/stp_open_%ld.stip", folder != NULL ? folder : "/tmp",
             (long)getpid());
    stp_context* context = test_context(NULL, 1, NULL);
    CHECK(context != NULL);
    stp_store_texture texture = {.width = 2048, .height = 2048};
    uint8_t* texels = calloc((size_t)texture.width * texture.height, 4);
    CHECK(texels != NULL);
    texture.texels = texels;
    stp_store_content content = {
        .directory = {.root = STP_STORE_NONE, .texture_count = 1, .up = 'y'},
        .textures = &texture,
    };
    stp_store* store = NULL;
    stp_result written = stp_store_write(context, &content, path);
    free(texels);
    CHECK_EQUAL(STP_OK, written);
    CHECK_EQUAL(STP_OK, stp_store_open(context, path, &store));
    long opened = resident_kb(path);
    stp_store_texture got;
    CHECK_EQUAL(STP_OK, stp_store_get_texture(store, 0, &got));
    long used = resident_kb(path);
    bool straight = got.texels != NULL && (uintptr_t)got.texels % 64 == 0;
    stp_store_close(store);
    unlink(path);
    stp_context_destroy(context);
    CHECK(straight);
    if (opened < 0) {
        SKIP("/proc/self/smaps is not there");
    }
    CHECK(opened < 1024);
    CHECK(used >= 4 * 2048 * 2048 / 1024); // checks the measurement itself
}

void test_store_objects_can_wait(test_state* test)
{
    stp_context* context = test_context(NULL, 1, NULL);
    CHECK(context != NULL);
    const char* path = STP_TEST_SOURCE_DIR "/tests/golden/store/v1/sample.stip";
    stp_store *eager = NULL, *store = NULL;
    CHECK_EQUAL(STP_OK, stp_store_open(context, path, &eager));
    CHECK_EQUAL(STP_OK, stp_store_open_with(context, path,
                                            &(stp_store_open_desc){.defer_objects = true}, &store));
    const stp_store_directory* directory = stp_store_get_directory(store);
    uint32_t count = stp_store_get_directory(eager)->object_count;
    CHECK(count > 0 && directory->object_count == count && directory->objects == NULL);
    CHECK_EQUAL(STP_OK, stp_store_load_objects(store));
    CHECK(directory->objects != NULL);
    for (uint32_t i = 0; i < count; ++i) {
        const stp_store_object* a = &stp_store_get_directory(eager)->objects[i];
        CHECK_EQUAL(a->parent, directory->objects[i].parent);
        CHECK_EQUAL(a->node, directory->objects[i].node);
    }
    const stp_store_object* objects = directory->objects;
    CHECK_EQUAL(STP_OK, stp_store_load_objects(store));
    CHECK(directory->objects == objects);
    stp_store_close(store);
    stp_store_close(eager);
    stp_context_destroy(context);
}

void test_store_objects_stay_damaged(test_state* test)
{
    size_t size = 0;
    unsigned char* bytes = // without checksums of pages
        sample_read_file(STP_TEST_SOURCE_DIR "/tests/golden/store/v1/sample.stip", &size);
    stp_context* context = test_context(NULL, 1, &(test_log){0});
    CHECK(bytes != NULL && context != NULL);
    bytes[stp_read_u64(find_section(bytes, STP_SECTION_OBJECTS) + 8)] ^= 1;
    stp_store* store = NULL;
    stp_store_open_desc desc = {.defer_objects = true};
    CHECK_EQUAL(STP_OK, stp_store_open_memory(context, "m", bytes, size, &desc, &store));
    for (int i = 0; i < 2; ++i) {
        stp_store_object object;
        CHECK_EQUAL(STP_ERROR_FORMAT, stp_store_read_object(store, 0, &object));
    }
    stp_store_close(store);
    free(bytes);
    stp_context_destroy(context);
}

// Whether the columns of `a` begin with those of `b`.
static bool begins_with(const stp_splats* a, const stp_splats* b)
{
    size_t n = b->count, entries = 0;
    for (uint32_t k = 0; k < b->octave_count; ++k) {
        entries += b->octave_ends[k];
    }
    return n == 0 || (memcmp(a->positions, b->positions, 6 * n) == 0 &&
                      memcmp(a->normals, b->normals, 2 * n) == 0 &&
                      memcmp(a->materials, b->materials, n) == 0 &&
                      memcmp(a->colors, b->colors, 3 * entries) == 0 &&
                      memcmp(a->coverages, b->coverages, entries) == 0);
}

void test_store_splats_come_octave_by_octave(test_state* test)
{
    stp_context* context = test_context(NULL, 1, NULL);
    CHECK(context != NULL);
    stp_store *store = NULL, *other = NULL;
    const char* path = STP_TEST_SOURCE_DIR "/tests/golden/store/v1/sample.stip";
    CHECK_EQUAL(STP_OK, stp_store_open(context, path, &store));
    CHECK_EQUAL(STP_OK, stp_store_open(context, path, &other));
    uint32_t sets = stp_store_get_directory(store)->set_count, tried = 0;
    for (uint32_t i = 0; i < sets; ++i) {
        const stp_splats* known = stp_store_describe_splat_set(store, i);
        stp_splats got[STP_OCTAVE_LIMIT + 2], at_once;
        CHECK_EQUAL(STP_OK, stp_store_get_splat_set(other, i, &at_once));
        for (uint32_t k = 0; k <= known->octave_count + 1; ++k) {
            CHECK_EQUAL(STP_OK, stp_store_get_splat_set_prefix(store, i, k, &got[k]));
            uint32_t octaves = k < known->octave_count ? k : known->octave_count;
            CHECK_EQUAL(octaves, got[k].octave_count);
            CHECK_EQUAL(octaves == 0 ? 0 : known->octave_ends[octaves - 1], got[k].count);
            CHECK_EQUAL(octaves, stp_store_octaves_for(known, got[k].count));
            for (uint32_t j = 0; j <= k; ++j) { // earlier results stay valid
                CHECK(begins_with(&at_once, &got[j]));
            }
            tried += 1;
        }
    }
    CHECK(tried > 4);
    stp_store_close(store);
    stp_store_close(other);
    stp_context_destroy(context);
}

void test_store_takes_memory_for_what_is_asked(test_state* test)
{
    stp_context* context = test_context(NULL, 1, NULL);
    CHECK(context != NULL);
    stp_store* store = NULL;
    CHECK_EQUAL(
        STP_OK,
        stp_store_open(context, STP_TEST_SOURCE_DIR "/tests/golden/store/v1/sample.stip", &store));
    uint64_t open_bytes = stp_context_live_bytes(context);
    uint32_t sets = stp_store_get_directory(store)->set_count, tried = 0;
    for (uint32_t i = 0; i < sets; ++i) {
        stp_splats coarse, fine;
        CHECK_EQUAL(STP_OK, stp_store_get_splat_set_prefix(store, i, 1, &coarse));
        uint64_t coarse_bytes = stp_context_live_bytes(context) - open_bytes;
        stp_store_release_splat_set(store, i);
        CHECK_EQUAL(open_bytes, stp_context_live_bytes(context));
        CHECK_EQUAL(STP_OK, stp_store_get_splat_set(store, i, &fine));
        uint64_t fine_bytes = stp_context_live_bytes(context) - open_bytes;
        if (fine.octave_count > 2) {
            CHECK(coarse_bytes < fine_bytes);
            tried += 1;
        }
        stp_store_release_splat_set(store, i);
    }
    CHECK(tried > 0);
    CHECK_EQUAL(open_bytes, stp_context_live_bytes(context));
    stp_store_close(store);
    stp_context_destroy(context);
}
