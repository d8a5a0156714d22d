// SPDX-License-Identifier: MIT
// Files of old versions, which must open forever, and files for scripts/read_store.py.
#include "support_chunks.h"
#include "support_expected.h"
#include "support_pictures.h"
#include "tests.h"

#include <string.h>
#include <unistd.h>

enum { GOLDEN_SEED = 175, METHODS_SEED = 181 };

// STP_STORE_SAMPLE=NAME writes NAME-SEED.stip and its content as NAME-SEED.json.
void test_store_writes_samples_for_another_reader(test_state* test)
{
    const char* name = getenv("STP_STORE_SAMPLE");
    if (name == NULL) {
        SKIP("STP_STORE_SAMPLE is not set");
    }
    stp_context* context = test_context(NULL, 1, NULL);
    CHECK(context != NULL);
    for (uint64_t seed = GOLDEN_SEED; seed < GOLDEN_SEED + 8; ++seed) {
        char path[512];
        stp_arena arena = stp_arena_create(context, 1 << 16);
        sample made = sample_make(&arena, seed);
        CHECK(seed % 2 == 0 || sample_code_meshes(&arena, &made, NULL));
        CHECK(seed % 4 != 2 || pictures_add(&arena, &made, 1));
        snprintf(path, sizeof(path), "%s-%llu.stip", name, (unsigned long long)seed);
        CHECK_EQUAL(STP_OK, stp_store_write(context, &made.content, path));
        stp_store* store = NULL; // gives the sizes of compressed data
        CHECK_EQUAL(STP_OK, stp_store_open(context, path, &store));
        json_t* expected = sample_expected_json(&made.content, stp_store_get_summary(store));
        stp_store_close(store);
        CHECK(expected != NULL);
        snprintf(path, sizeof(path), "%s-%llu.json", name, (unsigned long long)seed);
        CHECK_EQUAL(0, json_dump_file(expected, path, JSON_INDENT(1) | JSON_REAL_PRECISION(17)));
        json_decref(expected);
        stp_arena_destroy(&arena);
    }
    stp_context_destroy(context);
}

/// Writes a sample of chunks to NAME-KIND.stip, and what it holds to NAME-KIND.json.
static void write_chunks(test_state* test, uint64_t seed, const char* name, const char* kind)
{
    stp_context* context = test_context(NULL, 1, NULL);
    CHECK(context != NULL);
    char path[512];
    stp_arena arena = stp_arena_create(context, 1 << 20);
    chunk_sample made;
    stp_store* store = NULL;
    CHECK(chunk_sample_make(&arena, seed, &made));
    snprintf(path, sizeof(path), "%s-%s.stip", name, kind);
    CHECK_EQUAL(STP_OK, stp_store_write(context, &made.content, path));
    CHECK_EQUAL(STP_OK, stp_store_open(context, path, &store));
    json_t* expected = sample_expected_json(&made.content, stp_store_get_summary(store));
    stp_store_close(store);
    CHECK(expected != NULL);
    snprintf(path, sizeof(path), "%s-%s.json", name, kind);
    CHECK_EQUAL(0, json_dump_file(expected, path, JSON_INDENT(1) | JSON_REAL_PRECISION(17)));
    json_decref(expected);
    stp_arena_destroy(&arena);
    stp_context_destroy(context);
}

void test_store_writes_chunks_for_another_reader(test_state* test)
{
    const char* name = getenv("STP_STORE_SAMPLE");
    if (name == NULL) {
        SKIP("STP_STORE_SAMPLE is not set");
    }
    write_chunks(test, 5, name, "chunks");
    write_chunks(test, 6, name, "lit"); // with light normals
}

void test_store_still_opens_version_1(test_state* test)
{
    stp_context* context = test_context(NULL, 1, NULL);
    CHECK(context != NULL);
    const char* const paths[] = {STP_TEST_SOURCE_DIR "/tests/golden/store/v1/sample.stip",
                                 STP_TEST_SOURCE_DIR "/tests/golden/store/v1/sample-1.1.stip",
                                 STP_TEST_SOURCE_DIR "/tests/golden/store/v1/sample-1.2.stip",
                                 STP_TEST_SOURCE_DIR "/tests/golden/store/v1/packed-1.2.stip"};
    for (uint32_t i = 0; i < 4; ++i) {
        uint32_t minor = i < 2 ? i : 2;
        stp_arena arena = stp_arena_create(context, 1 << 16);
        sample made = sample_make(&arena, GOLDEN_SEED);
        if (minor == 0) { // version 1.0 had neither keys nor a summary
            made.content.set_keys = made.content.mesh_keys = NULL;
            made.content.census = NULL;
        }
        stp_store* store = NULL;
        CHECK_EQUAL(STP_OK, stp_store_open(context, paths[i], &store));
        CHECK_EQUAL(minor, stp_store_format_minor(store));
        CHECK_EQUAL(minor >= 1, stp_store_get_summary(store) != NULL);
        const char* difference = sample_difference(&made.content, store);
        stp_store_close(store);
        stp_arena_destroy(&arena);
        CHECK(difference == NULL);
        CHECK_EQUAL(STP_OK, stp_store_check(context, paths[i], false));
    }
    stp_context_destroy(context);
}

void test_store_still_opens_clusters_of_version_1(test_state* test)
{
    stp_context* context = test_context(NULL, 1, NULL);
    CHECK(context != NULL);
    const char* path = STP_TEST_SOURCE_DIR "/tests/golden/store/v1/clusters-1.1.stip";
    stp_arena arena = stp_arena_create(context, 1 << 16);
    sample made = sample_make(&arena, GOLDEN_SEED);
    const double steps[] = {0.25, 1.0}; // the steps of that time
    CHECK_EQUAL(4, (made.content.directory.mesh_count + 1) & ~1u);
    CHECK(sample_code_meshes(&arena, &made, steps)); // the coding must not change either
    stp_store* store = NULL;
    CHECK_EQUAL(STP_OK, stp_store_open(context, path, &store));
    const char* difference = sample_difference(&made.content, store);
    stp_store_close(store);
    stp_arena_destroy(&arena);
    CHECK(difference == NULL);
    CHECK_EQUAL(STP_OK, stp_store_check(context, path, false));
    stp_context_destroy(context);
}

void test_store_still_opens_methods_of_version_1_2(test_state* test)
{
    stp_context* context = test_context(NULL, 1, NULL);
    CHECK(context != NULL);
    const char* path = STP_TEST_SOURCE_DIR "/tests/golden/store/v1/methods-1.2.stip";
    stp_arena arena = stp_arena_create(context, 1 << 16);
    sample made = sample_make(&arena, METHODS_SEED);
    stp_store* store = NULL;
    CHECK(sample_code_meshes(&arena, &made, NULL));
    CHECK_EQUAL(STP_OK, stp_store_open(context, path, &store));
    CHECK_EQUAL(3, stp_store_get_directory(store)->method_count);
    const char* difference = sample_difference(&made.content, store);
    stp_store_close(store);
    stp_arena_destroy(&arena);
    CHECK(difference == NULL);
    CHECK_EQUAL(STP_OK, stp_store_check(context, path, false));
    stp_context_destroy(context);
}

void test_store_still_opens_pictures_of_version_1_2(test_state* test)
{
    stp_context* context = test_context(NULL, 1, NULL);
    CHECK(context != NULL);
    const char* path = STP_TEST_SOURCE_DIR "/tests/golden/store/v1/pictures-1.2.stip";
    stp_store* store = NULL;
    CHECK_EQUAL(STP_OK, stp_store_open(context, path, &store));
    CHECK_EQUAL(2, stp_store_format_minor(store));
    CHECK_EQUAL(PICTURE_TEXTURES, stp_store_get_directory(store)->texture_count);
    for (uint32_t i = 0; i < PICTURE_TEXTURES; ++i) {
        stp_store_texture texture;
        CHECK_EQUAL(STP_OK, stp_store_get_texture(store, i, &texture));
        CHECK(pictures_error(&texture) <= (i == PICTURE_JPEG ? 8 : 0));
    }
    stp_store_close(store);
    CHECK_EQUAL(STP_OK, stp_store_check(context, path, false));
    stp_context_destroy(context);
}

// Valid while the writer writes version 1.2. After that, add a new golden beside the old one.
// STP_WRITE_GOLDEN writes it.
void test_store_writes_the_same_bytes_as_before(test_state* test)
{
    char path[256];
    const char* folder = getenv("TMPDIR");
    snprintf(path, sizeof(path), "%s/stp_golden_%ld.stip", folder != NULL ? folder : "/tmp",
             (long)getpid());
    stp_context* context = test_context(NULL, 1, NULL);
    CHECK(context != NULL);
    stp_arena arena = stp_arena_create(context, 1 << 16);
    sample made = sample_make(&arena, GOLDEN_SEED);
    stp_result written = stp_store_write(context, &made.content, path);
    size_t golden_size = 0, size = 0;
    const char* golden_path = STP_TEST_SOURCE_DIR "/tests/golden/store/v1/packed-1.2.stip";
    if (getenv("STP_WRITE_GOLDEN") != NULL) {
        written = stp_store_write(context, &made.content, golden_path);
    }
    unsigned char* golden = sample_read_file(golden_path, &golden_size);
    unsigned char* bytes = sample_read_file(path, &size);
    bool same =
        golden != NULL && bytes != NULL && size == golden_size && memcmp(golden, bytes, size) == 0;
    free(golden);
    free(bytes);
    unlink(path);
    stp_arena_destroy(&arena);
    stp_context_destroy(context);
    CHECK_EQUAL(STP_OK, written);
    CHECK(same);
}
