// SPDX-License-Identifier: MIT
// Texts that are too long or shared by too many records.
#include "support_reseal.h"
#include "support_sample.h"
#include "tests.h"

#include "base/math/rng.h"
#include "store/file/records.h"
#include "store/writer/writer.h"

#include <malloc.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

enum { LONGEST = STP_STORE_TEXT_LIMIT };

// A text that does not compress, so that it is stored unchanged.
static void fill(char* text, size_t length, uint64_t seed)
{
    for (size_t i = 0; i < length; ++i) {
        text[i] = (char)(1 + stp_rng_below(seed, i, 255));
    }
    text[length] = '\0';
}

static stp_result write_named(stp_context* context, const char* first, const char* second,
                              const char* path)
{
    stp_store_object objects[] = {
        {.name = first, .parent = STP_STORE_NONE, .node = STP_STORE_NONE},
        {.name = second, .parent = STP_STORE_NONE, .node = STP_STORE_NONE},
    };
    objects[0].transform = objects[1].transform = stp_affine_identity();
    stp_store_content content = {.directory = {.object_count = 2,
                                               .objects = objects,
                                               .root = STP_STORE_NONE,
                                               .up = 'y',
                                               .build_json = "{}"}};
    return stp_store_write(context, &content, path);
}

static stp_result read_first(stp_context* context, const void* bytes, size_t size, bool deferred,
                             size_t* length)
{
    stp_store_open_desc desc = {.defer_objects = deferred};
    stp_store* store = NULL;
    stp_store_object object = {.name = NULL};
    stp_result result = stp_store_open_memory(context, "m", bytes, size, &desc, &store);
    if (result == STP_OK) {
        result = stp_store_read_object(store, 0, &object);
    }
    *length = result == STP_OK ? strlen(object.name) : 0;
    stp_store_close(store);
    return result;
}

void test_store_refuses_texts_that_are_too_long(test_state* test)
{
    static char first[LONGEST + 2], second[LONGEST + 2];
    char path[] = "stp_texts_XXXXXX";
    int file = mkstemp(path);
    test_log log = {0};
    stp_context* context = test_context(NULL, 1, &log);
    CHECK(file >= 0 && close(file) == 0 && context != NULL);
    fill(first, LONGEST + 1, 1);
    fill(second, LONGEST, 2);
    CHECK_EQUAL(STP_ERROR_ARGUMENT, write_named(context, first, second, path));
    CHECK(strstr(log.text, "object 0 has a text of more than 4095 bytes") != NULL);
    first[LONGEST] = '\0';
    CHECK_EQUAL(STP_OK, write_named(context, first, second, path));
    size_t size = 0, length = 0;
    unsigned char* bytes = sample_read_file(path, &size);
    CHECK(bytes != NULL);
    for (int deferred = 0; deferred < 2; ++deferred) {
        CHECK_EQUAL(STP_OK, read_first(context, bytes, size, deferred != 0, &length));
        CHECK_EQUAL(LONGEST, length);
    }
    size_t at = 0;
    while (at + LONGEST < size && memcmp(bytes + at, first, LONGEST) != 0) {
        at += 1;
    }
    CHECK(at + LONGEST < size && bytes[at + LONGEST] == 0);
    bytes[at + LONGEST] = 'x'; // joins both texts
    reseal(bytes, size);
    for (int deferred = 0; deferred < 2; ++deferred) {
        CHECK_EQUAL(STP_ERROR_FORMAT, read_first(context, bytes, size, deferred != 0, &length));
        CHECK(strstr(log.text, "has a text of more than 4095 bytes") != NULL);
    }
    free(bytes);
    unlink(path);
    stp_context_destroy(context);
}

// How often a text of a length can be used, up to a limit, if it is the whole section.
static uint64_t count_uses(size_t length, uint64_t maximum)
{
    static char bytes[LONGEST + 1];
    memset(bytes, 'a', length);
    bytes[length] = '\0';
    stp_store_text text = {.stored = bytes, .size = length + 1, .checked = true};
    uint64_t uses = 0;
    while (uses < maximum && stp_store_use_text(&text, bytes) == NULL) {
        uses += 1;
    }
    return uses;
}

void test_store_bounds_the_use_of_texts(test_state* test)
{
    CHECK_EQUAL(10000000,
                count_uses(200, 10000000)); // names like "bolt", for any number of objects
    uint64_t uses = count_uses(LONGEST, 10000000);
    CHECK(uses * LONGEST >= UINT64_C(1) << 24 && uses * LONGEST < UINT64_C(1) << 25);
}

/// Names in packed pages, read one by one: earlier content of the memory does not matter.
void test_store_reads_packed_texts_one_by_one(test_state* test)
{
    enum { OBJECTS = 9000 };
    static stp_store_object objects[OBJECTS];
    static char names[OBJECTS][24];
    char path[] = "stp_texts_XXXXXX";
    int file = mkstemp(path);
    stp_context* context = test_context(NULL, 1, NULL);
    CHECK(file >= 0 && close(file) == 0 && context != NULL);
    for (uint32_t i = 0; i < OBJECTS; ++i) {
        snprintf(names[i], sizeof(names[i]), "object number %u", i);
        objects[i] = (stp_store_object){.name = names[i],
                                        .parent = STP_STORE_NONE,
                                        .node = STP_STORE_NONE,
                                        .transform = stp_affine_identity()};
    }
    stp_store_content content = {.directory = {.object_count = OBJECTS,
                                               .objects = objects,
                                               .root = STP_STORE_NONE,
                                               .up = 'y',
                                               .build_json = "{}"}};
    CHECK_EQUAL(STP_OK, stp_store_write(context, &content, path));
    (void)mallopt(M_PERTURB, 0xA5); // fills memory with non-zero bytes
    stp_store_open_desc desc = {.defer_objects = true};
    stp_store* store = NULL;
    CHECK_EQUAL(STP_OK, stp_store_open_with(context, path, &desc, &store));
    for (uint32_t i = OBJECTS; i-- > 0;) {
        stp_store_object object;
        CHECK_EQUAL(STP_OK, stp_store_read_object(store, i, &object));
        CHECK(strcmp(object.name, names[i]) == 0);
    }
    (void)mallopt(M_PERTURB, 0);
    stp_store_close(store);
    unlink(path);
    stp_context_destroy(context);
}
