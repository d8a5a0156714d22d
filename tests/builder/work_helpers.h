// SPDX-License-Identifier: MIT
// A separate work folder for each test, and results that are distinguishable.
#pragma once

#include "tests.h"

#include "base/math/rng.h"
#include "builder/work.h"

#include <fcntl.h>
#include <stdio.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

enum { WORK_SEGMENT = 8192, WORK_LARGEST = 5000 };

typedef struct work_place {
    char outer[64];  ///< a folder that the test made
    char folder[80]; ///< the work folder inside it
} work_place;

static inline bool make_work_place(work_place* place)
{
    snprintf(place->outer, sizeof(place->outer), "stp_work_XXXXXX");
    bool made = mkdtemp(place->outer) != NULL;
    snprintf(place->folder, sizeof(place->folder), "%s/a.work", place->outer);
    return made;
}

static inline stp_hash work_key(uint32_t number)
{
    return stp_hash_bytes((stp_hash){0}, &number, sizeof(number));
}

/// The size of result `number`: 0, small, or more than a quarter of a segment.
static inline size_t work_size(uint32_t number)
{
    static const size_t sizes[] = {0, 1, 63, 64, 65, 200, 129, WORK_LARGEST, 7, 128};
    return sizes[number % 10];
}

static inline void fill_work_bytes(uint32_t number, unsigned char* bytes)
{
    for (size_t i = 0; i < work_size(number); ++i) {
        bytes[i] = (unsigned char)(number * 31 + i * 7 + (i >> 8));
    }
}

/// Stores result `number` in two parts.
static inline stp_result store_work(stp_work* work, uint32_t number, const void** stored)
{
    unsigned char bytes[WORK_LARGEST];
    fill_work_bytes(number, bytes);
    size_t size = work_size(number), cut = size / 3;
    const stp_bytes parts[] = {{bytes, cut}, {bytes + cut, size - cut}};
    return stp_work_store(work, work_key(number), parts, 2, stored);
}

static inline bool is_work(const void* bytes, size_t size, uint32_t number)
{
    unsigned char expected[WORK_LARGEST];
    fill_work_bytes(number, expected);
    return bytes != NULL && (uintptr_t)bytes % 64 == 0 && size == work_size(number) &&
           memcmp(bytes, expected, size) == 0;
}

typedef enum work_found { WORK_NONE, WORK_RIGHT, WORK_WRONG } work_found;

static inline work_found find_work(stp_work* work, uint32_t number)
{
    size_t size = 1;
    const void* bytes = stp_work_find(work, work_key(number), &size);
    if (bytes == NULL) {
        return size == 0 ? WORK_NONE : WORK_WRONG;
    }
    return is_work(bytes, size, number) ? WORK_RIGHT : WORK_WRONG;
}

static inline stp_work* open_work(stp_context* context, const work_place* place)
{
    stp_work* work = NULL;
    return stp_work_open_with(context, place->folder, false, WORK_SEGMENT, &work) == STP_OK ? work
                                                                                            : NULL;
}

static inline size_t read_segment(const work_place* place, uint32_t number, unsigned char* bytes,
                                  size_t capacity)
{
    char path[128];
    snprintf(path, sizeof(path), "%s/segment-%06u", place->folder, number);
    FILE* file = fopen(path, "rb");
    size_t size = file != NULL ? fread(bytes, 1, capacity, file) : 0;
    if (file != NULL) {
        fclose(file);
    }
    return size;
}

/// Creates the folder if there is none. @return whether the file was written
static inline bool write_segment(const work_place* place, uint32_t number,
                                 const unsigned char* bytes, size_t size)
{
    char path[128];
    (void)mkdir(place->folder, 0777);
    snprintf(path, sizeof(path), "%s/segment-%06u", place->folder, number);
    int file = open(path, O_WRONLY | O_CREAT | O_TRUNC, 0666);
    bool written = file >= 0 && write(file, bytes, size) == (ssize_t)size;
    if (file >= 0) {
        close(file);
    }
    return written;
}

/// Whether no file of the directory is left, and its outer folder could be removed.
static inline bool remove_work_place(const work_place* place)
{
    return access(place->folder, F_OK) != 0 && rmdir(place->outer) == 0;
}
