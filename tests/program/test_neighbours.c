// SPDX-License-Identifier: MIT
// Files beside a model that its text names, against a search for each name.
#include "tests.h"

#include "base/math/rng.h"
#include "program/files/scene_file.h"

#include <limits.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

enum { FILES = 24, TEXTS = 40, TEXT_SIZE = 90 };

// Names of few letters: many are prefixes of others, and occur in texts of the same letters.
static void make_name(uint32_t number, char name[16])
{
    size_t length = 1 + stp_rng_below(7, number, 6);
    for (size_t i = 0; i < length; ++i) {
        name[i] = "ab."[stp_rng_below(8, number * 16 + i, 3)];
    }
    name[length] = 'a'; // a name of dots alone is a folder's
    name[length + 1] = '\0';
}

static bool write_file(const char* folder, const char* name, size_t size)
{
    char path[PATH_MAX];
    snprintf(path, sizeof(path), "%s/%s", folder, name);
    FILE* file = fopen(path, "wb");
    bool good = file != NULL;
    for (size_t i = 0; good && i < size; ++i) {
        good = fputc('x', file) != EOF;
    }
    return file != NULL && fclose(file) == 0 && good;
}

static stp_hash hash_of(const char* folder, const char* text)
{
    char path[PATH_MAX];
    snprintf(path, sizeof(path), "%s/model.obj", folder);
    stp_mapped_file file = {.bytes = (const unsigned char*)text, .size = strlen(text)};
    stp_hash hash = {0};
    neighbours_hash(path, &file, &hash);
    return hash;
}

static bool is_same(stp_hash a, stp_hash b)
{
    return a.low == b.low && a.high == b.high;
}

void test_neighbours_are_those_that_a_text_names(test_state* test)
{
    char folder[] = "stipple-test-XXXXXX", names[FILES][16], path[PATH_MAX];
    CHECK(mkdtemp(folder) != NULL);
    for (uint32_t i = 0; i < FILES; ++i) {
        make_name(i, names[i]);
        CHECK(write_file(folder, names[i], 1));
    }
    size_t named = 0, passed = 0;
    for (uint32_t t = 0; t < TEXTS; ++t) {
        char text[TEXT_SIZE + 1];
        uint32_t size = stp_rng_below(9, t, TEXT_SIZE);
        for (uint32_t i = 0; i < size; ++i) {
            text[i] = "aab./"[stp_rng_below(10, t * TEXT_SIZE + i, 5)];
        }
        text[size] = '\0';
        for (uint32_t i = 0; i < FILES; ++i) {
            stp_hash before = hash_of(folder, text);
            CHECK(write_file(folder, names[i], 2)); // its size changes
            bool changes = !is_same(before, hash_of(folder, text));
            CHECK(write_file(folder, names[i], 1));
            bool expected = strlen(names[i]) >= 3 && strstr(text, names[i]) != NULL;
            CHECK_EQUAL(expected, changes);
            *(expected ? &named : &passed) += 1;
        }
    }
    CHECK(named > 100 && passed > 100);
    for (uint32_t i = 0; i < FILES; ++i) {
        snprintf(path, sizeof(path), "%s/%s", folder, names[i]);
        (void)unlink(path);
    }
    CHECK(rmdir(folder) == 0);
}
