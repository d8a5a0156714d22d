// SPDX-License-Identifier: MIT
//
// Names are sorted. At each position of the text, a search finds the last name that does not sort
// after the text there: every name that starts there is that name or a prefix of it. A table of the
// names' first bytes rules out most positions.
#include "program/files/scene_file.h"

#include <assert.h>
#include <dirent.h>
#include <limits.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

enum {
    SEARCHED_BYTES = 1 << 24,
    MIN_NAME = 3,
    NONE = -1,
};

typedef struct neighbour {
    char* name;
    size_t length;
    long prefix; ///< index of the longest other name that begins this one; or NONE
    bool is_named;
} neighbour;

typedef struct folder {
    neighbour* files;
    size_t count, capacity;
    unsigned char starts[1 << 16]; ///< whether a name begins with two bytes
} folder;

static bool add_file(folder* f, const char* name)
{
    if (f->count == f->capacity) {
        size_t capacity = f->capacity != 0 ? 2 * f->capacity : 64;
        neighbour* files = realloc(f->files, capacity * sizeof(*files));
        if (files == NULL) {
            return false;
        }
        f->files = files;
        f->capacity = capacity;
    }
    char* copy = strdup(name);
    if (copy == NULL) {
        return false;
    }
    f->files[f->count++] = (neighbour){.name = copy, .length = strlen(copy), .prefix = NONE};
    return true;
}

static int compare_names(const void* a, const void* b)
{
    return strcmp(((const neighbour*)a)->name, ((const neighbour*)b)->name);
}

static bool begins(const neighbour* file, const unsigned char* text, size_t size)
{
    return file->length <= size && memcmp(file->name, text, file->length) == 0;
}

static size_t start_of(const unsigned char* text)
{
    return (size_t)text[0] << 8 | text[1];
}

// Sorts the names and links each to the longest other name that is its prefix: the previous name,
// or a prefix of that.
static void link_names(folder* f)
{
    if (f->count != 0) {
        qsort(f->files, f->count, sizeof(*f->files), compare_names);
    }
    for (size_t i = 0; i < f->count; ++i) {
        neighbour* file = &f->files[i];
        const unsigned char* name = (const unsigned char*)file->name;
        f->starts[start_of(name)] = 1;
        long other = (long)i - 1;
        while (other != NONE && !begins(&f->files[other], name, file->length)) {
            other = f->files[other].prefix;
        }
        assert(other < (long)i && "following the links ends");
        file->prefix = other;
    }
}

// Marks the names at the beginning of a text.
static void mark_names(folder* f, const unsigned char* text, size_t size)
{
    assert(size >= MIN_NAME && "or the first two bytes were not there");
    size_t low = 0, high = f->count; // names from `high` on come after the text
    while (low < high) {
        size_t middle = low + (high - low) / 2;
        const neighbour* file = &f->files[middle];
        size_t length = file->length < size ? file->length : size;
        int order = memcmp(file->name, text, length);
        if (order < 0 || (order == 0 && file->length <= size)) {
            low = middle + 1;
        } else {
            high = middle;
        }
    }
    long at = (long)low - 1;
    while (at != NONE && !begins(&f->files[at], text, size)) {
        at = f->files[at].prefix;
    }
    for (; at != NONE && !f->files[at].is_named; at = f->files[at].prefix) {
        f->files[at].is_named = true;
    }
}

static bool list_folder(const char* path, folder* f)
{
    DIR* listing = opendir(path);
    bool good = true;
    for (struct dirent* entry; good && listing != NULL && (entry = readdir(listing)) != NULL;) {
        good = strlen(entry->d_name) < MIN_NAME || add_file(f, entry->d_name);
    }
    if (listing != NULL) {
        closedir(listing);
    }
    return good;
}

static void add_named(const folder* f, const char* path, stp_hash* hash)
{
    stp_hash sum = {0};
    for (size_t i = 0; i < f->count; ++i) {
        char full[PATH_MAX + 260];
        struct stat status;
        const neighbour* file = &f->files[i];
        snprintf(full, sizeof(full), "%s/%s", path, file->name);
        if (file->is_named && stat(full, &status) == 0) {
            int64_t numbers[3] = {(int64_t)status.st_size, (int64_t)status.st_mtim.tv_sec,
                                  (int64_t)status.st_mtim.tv_nsec};
            stp_hash one = stp_hash_bytes((stp_hash){0}, file->name, file->length);
            one = stp_hash_bytes(one, numbers, sizeof(numbers));
            sum.low += one.low;
            sum.high += one.high;
        }
    }
    *hash = stp_hash_bytes(*hash, &sum, sizeof(sum));
}

void neighbours_hash(const char* path, const stp_mapped_file* file, stp_hash* hash)
{
    char name[PATH_MAX];
    const char* slash = strrchr(path, '/');
    snprintf(name, sizeof(name), "%.*s", slash != NULL ? (int)(slash - path) : 1,
             slash != NULL ? path : ".");
    folder* f = calloc(1, sizeof(*f));
    if (f != NULL && list_folder(*name != '\0' ? name : "/", f)) {
        link_names(f);
        size_t size = file->size < SEARCHED_BYTES ? file->size : SEARCHED_BYTES;
        for (size_t i = 0; i + MIN_NAME <= size; ++i) {
            if (f->starts[start_of(file->bytes + i)] != 0) {
                mark_names(f, file->bytes + i, size - i);
            }
        }
        add_named(f, name, hash);
    }
    for (size_t i = 0; f != NULL && i < f->count; ++i) {
        free(f->files[i].name);
    }
    free(f != NULL ? f->files : NULL);
    free(f);
}
