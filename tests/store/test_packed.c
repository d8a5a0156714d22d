// SPDX-License-Identifier: MIT
// Sections in compressed pages.
#include "support_reseal.h"
#include "support_sample.h"
#include "tests.h"

#include "store/bytes/packed.h"
#include "store/file/content.h"
#include "store/file/store_state.h"

#include <string.h>
#include <unistd.h>

enum { OBJECTS = 3000 };

static void temporary_path(char path[256], const char* name)
{
    const char* folder = getenv("TMPDIR");
    snprintf(path, 256, "%s/stp_%s_%ld.stip", folder != NULL ? folder : "/tmp", name,
             (long)getpid());
}

// A scene of one node and many named objects: several pages of records and of texts.
static unsigned char* write_objects(stp_context* context, bool packed, size_t* size)
{
    char path[256];
    temporary_path(path, "packed");
    stp_arena arena = stp_arena_create(context, 1 << 16);
    stp_store_object* objects = STP_ARENA_ARRAY(&arena, stp_store_object, OBJECTS);
    char(*names)[48] = stp_arena_alloc(&arena, OBJECTS * sizeof(*names));
    stp_store_node node = {.set = STP_STORE_NONE};
    stp_store_content content = {
        .directory = {.node_count = 1,
                      .nodes = &node,
                      .object_count = OBJECTS,
                      .objects = objects,
                      .up = 'y'},
        .passing = !packed,
    };
    unsigned char* bytes = NULL;
    for (uint32_t i = 0; objects != NULL && names != NULL && i < OBJECTS; ++i) {
        snprintf(names[i], sizeof(names[i]), "part number %u, which is named at length", i);
        objects[i] = (stp_store_object){.name = names[i],
                                        .parent = i == 0 ? STP_STORE_NONE : i / 2,
                                        .transform = stp_affine_identity()};
        objects[i].transform.m[0][3] = i;
    }
    if (objects != NULL && names != NULL && stp_store_write(context, &content, path) == STP_OK) {
        bytes = sample_read_file(path, size);
    }
    unlink(path);
    stp_arena_destroy(&arena);
    return bytes;
}

static stp_store* open_bytes(stp_context* context, const unsigned char* bytes, size_t size,
                             bool defer)
{
    stp_store* store = NULL;
    stp_store_open_desc desc = {.defer_objects = defer};
    return stp_store_open_memory(context, "memory", bytes, size, &desc, &store) == STP_OK ? store
                                                                                          : NULL;
}

static bool is_object(const stp_store_object* object, uint32_t index)
{
    char name[48];
    snprintf(name, sizeof(name), "part number %u, which is named at length", index);
    return object->name != NULL && strcmp(object->name, name) == 0 &&
           !(object->transform.m[0][3] < index) && !(object->transform.m[0][3] > index);
}

void test_store_packed_round_trip(test_state* test)
{
    stp_context* context = test_context(NULL, 2, NULL);
    CHECK(context != NULL);
    size_t sizes[2] = {0};
    for (int packed = 0; packed < 2; ++packed) {
        unsigned char* bytes = write_objects(context, packed == 1, &sizes[packed]);
        CHECK(bytes != NULL);
        stp_store* all = open_bytes(context, bytes, sizes[packed], false);
        stp_store* some = open_bytes(context, bytes, sizes[packed], true);
        CHECK(all != NULL && some != NULL);
        for (uint32_t i = 0; i < OBJECTS; ++i) {
            uint32_t other = (i * 977) % OBJECTS; // out of order, one by one
            stp_store_object object;
            CHECK(is_object(&stp_store_get_directory(all)->objects[i], i));
            CHECK_EQUAL(STP_OK, stp_store_read_object(some, other, &object));
            CHECK(is_object(&object, other));
        }
        stp_store_check_report report;
        CHECK_EQUAL(STP_OK, stp_store_check_open(all, false, &report));
        stp_store_close(all);
        stp_store_close(some);
        free(bytes);
    }
    CHECK(4 * sizes[1] < sizes[0]);
    stp_context_destroy(context);
}

// One object needs only its own page and those of its name.
void test_store_reads_one_object_from_a_few_pages(test_state* test)
{
    stp_context* context = test_context(NULL, 1, NULL);
    CHECK(context != NULL);
    size_t size = 0;
    unsigned char* bytes = write_objects(context, true, &size);
    CHECK(bytes != NULL);
    stp_store* store = open_bytes(context, bytes, size, true);
    CHECK(store != NULL);
    uint64_t before = store->bytes_checked;
    stp_store_object object;
    CHECK_EQUAL(STP_OK, stp_store_read_object(store, OBJECTS - 1, &object));
    CHECK(is_object(&object, OBJECTS - 1));
    const stp_store_section* section = store->known[STP_SECTION_OBJECTS];
    CHECK(stp_store_is_packed(section) && stp_store_packed_page_count(section) == 6);
    uint64_t read = store->bytes_checked - before;
    CHECK(read < section->size);
    CHECK_EQUAL(STP_OK, stp_store_read_object(store, OBJECTS - 2, &object)); // the same pages
    CHECK_EQUAL(before + read, store->bytes_checked);
    stp_store_close(store);
    free(bytes);
    stp_context_destroy(context);
}

// Valid checksums, wrong content: the offset, the value, and the expected message.
void test_store_refuses_forged_pages(test_state* test)
{
    test_log log = {.errors = 0};
    stp_context *writer = test_context(NULL, 1, NULL), *context = test_context(NULL, 1, &log);
    CHECK(writer != NULL && context != NULL);
    size_t size = 0;
    unsigned char* bytes = write_objects(writer, true, &size);
    stp_context_destroy(writer);
    CHECK(bytes != NULL);
    stp_store* store = open_bytes(context, bytes, size, true);
    CHECK(store != NULL);
    stp_store_section section = *store->known[STP_SECTION_OBJECTS];
    size_t entry =
        STP_STORE_HEADER_BYTES +
        STP_STORE_SECTION_BYTES * (size_t)(store->known[STP_SECTION_OBJECTS] - store->sections);
    stp_store_close(store);
    unsigned char* copy = malloc(size);
    CHECK(copy != NULL);
    const struct {
        size_t at;
        uint32_t value;
        const char* said;
    } forgeries[] = {
        {(size_t)section.offset, 1, "do not fill it"}, // the size of a page
        {(size_t)section.offset, UINT32_MAX, "do not fill it"},
        {(size_t)section.offset + 48, UINT32_MAX, "compression of page 0"}, // its stream
        {entry + 24, OBJECTS + 1, "of the section of type 17"},             // one object more
        {entry + 24, OBJECTS / 2, "do not fill it"},                        // half of the objects
        {entry + 24, 100 * OBJECTS, "wrong size for its records"},
        {entry + 32, 1 << 17, "wrong size for its records"}, // records longer than a page
        {entry + 4, 0, "wrong size for its records"},        // not packed
        {entry + 4, 4, "flags"},
    };
    for (size_t i = 0; i < sizeof(forgeries) / sizeof(forgeries[0]); ++i) {
        memcpy(copy, bytes, size);
        stp_write_u32(copy + forgeries[i].at, forgeries[i].value);
        reseal(copy, size);
        log.errors = 0;
        CHECK(open_bytes(context, copy, size, false) == NULL);
        CHECK_EQUAL(1, log.errors);
        if (strstr(log.text, forgeries[i].said) == NULL) {
            fprintf(stderr, "forgery %zu: %s\n", i, log.text);
        }
        CHECK(strstr(log.text, forgeries[i].said) != NULL);
    }
    CHECK(stp_context_peak_bytes(context) < 40 * size);
    free(copy);
    free(bytes);
    stp_context_destroy(context);
}

void test_store_packed_survives_failing_allocator(test_state* test)
{
    stp_context* plain = test_context(NULL, 1, NULL);
    CHECK(plain != NULL);
    size_t size = 0;
    unsigned char* bytes = write_objects(plain, true, &size);
    CHECK(bytes != NULL);
    bool done = false;
    for (int n = 0; !done && n < 200; ++n) {
        test_heap heap = TEST_HEAP(n);
        test_log log = {0};
        stp_context* context = test_context(&heap, 1, &log);
        if (context != NULL) {
            stp_store* store = NULL;
            stp_store_open_desc desc = {.defer_objects = true};
            stp_store_object object;
            stp_result result = stp_store_open_memory(context, "m", bytes, size, &desc, &store);
            result = result == STP_OK ? stp_store_read_object(store, 7, &object) : result;
            result = result == STP_OK ? stp_store_load_objects(store) : result;
            stp_store_close(store);
            CHECK(result == STP_OK || result == STP_ERROR_OUT_OF_MEMORY);
            CHECK_EQUAL(result != STP_OK, log.errors);
            done = result == STP_OK;
            stp_context_destroy(context);
        }
        CHECK_EQUAL(0, heap.live_bytes);
    }
    CHECK(done);
    free(bytes);
    stp_context_destroy(plain);
}
