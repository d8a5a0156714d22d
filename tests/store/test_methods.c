// SPDX-License-Identifier: MIT
// Sets of several methods in one file: round trip; sets that no reader could draw are rejected.
#include "support_chunks.h"
#include "support_sample.h"
#include "tests.h"

#include "base/splats/splat_codes.h"
#include "store/file/content.h"
#include "store/file/store_state.h"

#include <math.h>
#include <string.h>
#include <unistd.h>

enum { NODES = 4 };

typedef struct fixture {
    stp_arena arena;
    chunk_sample made;
    stp_store_node nodes[NODES];
    stp_store_method methods[2];
    uint32_t sets[NODES];
} fixture;

// Four nodes. The first method has set 0 for node 0; the second has sets 1 and 2 for nodes 1 and 3.
static bool set_up(fixture* f, stp_context* context)
{
    f->arena = stp_arena_create(context, 1 << 20);
    if (!chunk_sample_make(&f->arena, 2, &f->made)) {
        return false;
    }
    for (uint32_t i = 0; i < NODES; ++i) {
        f->nodes[i] = (stp_store_node){.set = i == 0 ? 0 : STP_STORE_NONE};
        f->sets[i] = i == 1 ? 1 : i == 3 ? 2 : STP_STORE_NONE;
    }
    f->methods[0] = (stp_store_method){.name = "blue", .id = STP_METHOD_BLUE, .set_count = 1};
    f->methods[1] = (stp_store_method){
        .name = "spt", .id = STP_METHOD_SPT, .first_set = 1, .set_count = 2, .sets = f->sets};
    stp_store_directory* d = &f->made.content.directory;
    d->nodes = f->nodes;
    d->node_count = NODES;
    d->root = NODES - 1;
    d->methods = f->methods;
    d->method_count = 2;
    return true;
}

// Writes the content and opens it. @return the first failure
static stp_result write_and_open(stp_context* context, const stp_store_content* content,
                                 unsigned char** bytes, stp_store** store)
{
    char path[256];
    const char* folder = getenv("TMPDIR");
    size_t size = 0;
    snprintf(path, sizeof(path), "%s/stp_methods_%ld.stip", folder != NULL ? folder : "/tmp",
             (long)getpid());
    *bytes = NULL;
    *store = NULL;
    stp_result result = stp_store_write(context, content, path);
    if (result == STP_OK) {
        *bytes = sample_read_file(path, &size);
        result = stp_store_open_memory(context, "methods", *bytes, size, &(stp_store_open_desc){0},
                                       store);
    }
    unlink(path);
    return result;
}

void test_methods_of_a_file(test_state* test)
{
    stp_context* context = test_context(NULL, 1, NULL);
    CHECK(context != NULL);
    fixture f;
    unsigned char* bytes;
    stp_store* store;
    CHECK(set_up(&f, context));
    CHECK_EQUAL(STP_OK, write_and_open(context, &f.made.content, &bytes, &store));
    const stp_store_directory* d = stp_store_get_directory(store);
    CHECK_EQUAL(2, d->method_count);
    CHECK(strcmp(d->methods[1].name, "spt") == 0);
    uint32_t spt = stp_store_find_method(d, STP_METHOD_SPT);
    CHECK_EQUAL(1, spt);
    CHECK_EQUAL(0, stp_store_find_method(d, STP_METHOD_PSP)); // not in the file: the first one
    for (uint32_t i = 0; i < NODES; ++i) {
        CHECK_EQUAL(f.nodes[i].set, stp_store_set_of(d, 0, i));
        CHECK_EQUAL(f.sets[i], stp_store_set_of(d, spt, i));
    }
    stp_store_close(store);
    free(bytes);
    stp_arena_destroy(&f.arena);
    stp_context_destroy(context);
}

void test_methods_that_are_not_known(test_state* test)
{
    test_log log = {.errors = 0};
    stp_context* context = test_context(NULL, 1, &log);
    CHECK(context != NULL);
    fixture f;
    unsigned char* bytes;
    stp_store* store;
    CHECK(set_up(&f, context));
    f.methods[0].name = "zebra";
    f.methods[0].id = 99;
    CHECK_EQUAL(STP_OK, write_and_open(context, &f.made.content, &bytes, &store));
    const stp_store_directory* d = stp_store_get_directory(store);
    CHECK_EQUAL(1, d->method_count); // the other one takes the nodes
    CHECK_EQUAL(STP_METHOD_SPT, d->methods[0].id);
    for (uint32_t i = 0; i < NODES; ++i) {
        CHECK_EQUAL(f.sets[i], d->nodes[i].set);
    }
    stp_store_close(store);
    free(bytes);
    f.methods[1].name = "yak";
    f.methods[1].id = 98;
    CHECK_EQUAL(STP_ERROR_UNSUPPORTED, write_and_open(context, &f.made.content, &bytes, &store));
    CHECK(strstr(log.text, "zebra") != NULL);
    free(bytes);
    stp_arena_destroy(&f.arena);
    stp_context_destroy(context);
}

// Coarse ellipses are read as the last of several methods, and not offered. Elsewhere they are
// ignored, as unknown methods are.
void test_coarse_ellipses_follow_other_methods(test_state* test)
{
    test_log log = {.errors = 0};
    stp_context* context = test_context(NULL, 1, &log);
    CHECK(context != NULL);
    for (uint32_t place = 0; place < 2; ++place) {
        fixture f;
        unsigned char* bytes;
        stp_store* store;
        CHECK(set_up(&f, context));
        f.methods[place].name = "coarse";
        f.methods[place].id = STP_METHOD_COARSE;
        CHECK_EQUAL(STP_OK, write_and_open(context, &f.made.content, &bytes, &store));
        const stp_store_directory* d = stp_store_get_directory(store);
        CHECK_EQUAL(1 + place, d->method_count);
        CHECK_EQUAL(1, stp_store_offered_methods(d));
        CHECK_EQUAL(place == 0 ? STP_METHOD_SPT : STP_METHOD_BLUE, d->methods[0].id);
        CHECK_EQUAL(place, stp_store_find_method(d, STP_METHOD_COARSE));
        for (uint32_t i = 0; i < NODES; ++i) {
            CHECK_EQUAL(f.sets[i], stp_store_set_of(d, place, i));
        }
        stp_store_close(store);
        free(bytes);
        stp_arena_destroy(&f.arena);
    }
    CHECK_EQUAL(0, log.errors);
    stp_context_destroy(context);
}

// Each breaks one property of a valid file.
static void break_field(fixture* f, int field)
{
    stp_splats* set = &f->made.sets[1];
    switch (field) {
    case 0: // two methods with one id
        f->methods[1].id = STP_METHOD_BLUE;
        break;
    case 1: // a set without a node
        f->sets[3] = STP_STORE_NONE;
        break;
    case 2: // a set with two nodes
        f->sets[2] = 1;
        break;
    case 3: // a set without a method
        f->methods[1].set_count = 1;
        break;
    case 4: // a node with a set of another method
        f->nodes[2].set = 2;
        break;
    case 5: // columns that the method does not have
        set->columns = STP_SPLATS_RANGES;
        break;
    case 6: // undefined columns
        f->methods[1].columns = STP_SPLATS_COLUMNS + 1;
        break;
    case 7: // a missing column
        set->columns = f->methods[1].columns = f->made.sets[2].columns = STP_SPLATS_SHAPES;
        break;
    case 8: // a set with two nodes, and one without
        f->sets[3] = 1;
        break;
    case 9: // errors without ranges
        f->methods[1].columns = STP_SPLATS_ERRORS;
        break;
    default: // no name
        f->methods[0].name = "";
        break;
    }
}

void test_invalid_methods_are_refused(test_state* test)
{
    test_log log = {.errors = 0};
    stp_context* context = test_context(NULL, 1, &log);
    CHECK(context != NULL);
    for (int field = 0; field <= 10; ++field) {
        fixture f;
        unsigned char* bytes;
        stp_store* store;
        CHECK(set_up(&f, context));
        break_field(&f, field);
        CHECK_EQUAL(STP_ERROR_ARGUMENT, write_and_open(context, &f.made.content, &bytes, &store));
        CHECK_EQUAL(field + 1, log.errors);
        stp_arena_destroy(&f.arena);
    }
    stp_context_destroy(context);
}

void test_splat_codes_never_shrink(test_state* test)
{
    for (float radius = 0.01f; radius < 1e8f; radius *= 1.0137f) {
        float coded = stp_shape_radius(stp_shape_code(radius));
        CHECK(coded >= radius && (radius <= 0.25f || coded <= radius * (1.0f + 1.0f / 127.0f)));
        CHECK(stp_shape_is_valid(stp_shape_disk(radius, 0, false)));
        uint32_t range = stp_range_code(radius, 3.0f * radius);
        float low = stp_range_level(range & 0xFFFFu), high = stp_range_level(range >> 16);
        CHECK(low <= radius && low >= radius * (1.0f - 1.0f / 255.0f));
        CHECK(high >= 3.0f * radius && high <= 3.0f * radius * (1.0f + 1.0f / 255.0f));
        CHECK(stp_range_is_valid(range));
    }
    CHECK(isinf(stp_range_level(stp_range_code(0.0f, INFINITY) >> 16)));
    CHECK(isinf(stp_range_level(stp_range_code(0.0f, 3.4e38f) >> 16)));
    CHECK(!stp_range_is_valid(0x00010002u)); // lowest above highest
    CHECK(!stp_range_is_valid(0xFF010000u)); // not a number
    CHECK(!stp_shape_is_valid(0x00FFFu));    // not finite
    CHECK(!stp_shape_is_valid(0x00002001u)); // smaller radius above the larger
}

// A set's errors are joined octave by octave, like its other columns.
void test_errors_of_splats_are_stored(test_state* test)
{
    stp_context* context = test_context(NULL, 2, NULL);
    CHECK(context != NULL);
    stp_arena arena = stp_arena_create(context, 1 << 20);
    chunk_sample made;
    unsigned char* bytes = NULL;
    stp_store* store = NULL;
    CHECK(chunk_sample_make(&arena, 3, &made));
    CHECK((made.method.columns & STP_SPLATS_ERRORS) != 0);
    CHECK_EQUAL(STP_OK, write_and_open(context, &made.content, &bytes, &store));
    for (uint32_t i = 0; i < CHUNK_SAMPLE_SETS; ++i) {
        for (uint32_t octaves = 1; octaves <= made.sets[i].octave_count; ++octaves) {
            stp_splats got;
            CHECK_EQUAL(STP_OK, stp_store_get_splat_set_prefix(store, i, octaves, &got));
            CHECK(got.count == made.sets[i].octave_ends[octaves - 1] && got.errors != NULL);
            CHECK(memcmp(got.errors, made.sets[i].errors, 4 * (size_t)got.count) == 0);
        }
    }
    stp_store_check_report report;
    CHECK_EQUAL(STP_OK, stp_store_check_open(store, false, &report));
    stp_store_close(store);
    free(bytes);
    stp_arena_destroy(&arena);
    stp_context_destroy(context);
}

// Invalid shapes and ranges are rejected by the writer, and by a reader of a changed file.
void test_splat_columns_are_validated(test_state* test)
{
    test_log log = {.errors = 0};
    stp_context* context = test_context(NULL, 1, &log);
    CHECK(context != NULL);
    static const uint32_t wrong[][2] = {{0x00FFFu, 0x40000000u}, {0x001u, 0x00010002u}};
    for (int i = 0; i < 2; ++i) {
        stp_arena arena = stp_arena_create(context, 1 << 20);
        chunk_sample made;
        unsigned char* bytes;
        stp_store* store;
        CHECK(chunk_sample_make(&arena, 1, &made));
        made.sets[1].shapes[2] = wrong[i][0];
        made.sets[1].ranges[2] = wrong[i][1];
        CHECK_EQUAL(STP_ERROR_ARGUMENT, write_and_open(context, &made.content, &bytes, &store));
        stp_store_validator validator = {
            .context = context, .path = "x", .failure = STP_ERROR_FORMAT};
        stp_store_splat_data data = {made.sets[1].count, made.sets[1].materials,
                                     made.sets[1].shapes, made.sets[1].ranges};
        CHECK_EQUAL(STP_ERROR_FORMAT, stp_store_validate_splat_data(&validator, 1, &data, 1));
        stp_arena_destroy(&arena);
    }
    CHECK_EQUAL(4, log.errors);
    stp_context_destroy(context);
}
