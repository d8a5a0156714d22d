// SPDX-License-Identifier: MIT
//
// Public structs of any version. Each begins with `size_t struct_size`: the size of the struct as
// the caller knows it; 0: its first version. Structs only grow at their end.
#pragma once

#include <assert.h>
#include <stdbool.h>
#include <stddef.h>
#include <string.h>

/// Copies a caller's descriptor. Fields that the caller does not know become zero; NULL: all. When
/// a struct grows, struct_size 0 must stand for its first version: pass that version's size as
/// `first`.
/// @return false if the caller sets fields that this library does not know
static inline bool stp_desc_read(void* desc, size_t size, size_t first, const void* given)
{
    size_t known = 0;
    assert(first >= sizeof(known) && first <= size && "structs only grow");
    memset(desc, 0, size);
    if (given == NULL) {
        return true;
    }
    memcpy(&known, given, sizeof(known));
    known = known != 0 ? known : first;
    if (known < sizeof(known)) {
        return false;
    }
    for (size_t i = size; i < known; ++i) {
        if (((const unsigned char*)given)[i] != 0) {
            return false;
        }
    }
    memcpy(desc, given, known < size ? known : size);
    return true;
}

/// Fills a caller's struct up to its size; fields that this library does not know become zero.
static inline void stp_info_write(void* info, const void* made, size_t size, size_t first)
{
    const size_t head = sizeof(size_t);
    size_t known = 0;
    assert(first >= head && first <= size && "structs only grow");
    memcpy(&known, info, head);
    known = known != 0 ? known : first;
    if (known > head) {
        size_t filled = known < size ? known : size;
        memcpy((unsigned char*)info + head, (const unsigned char*)made + head, filled - head);
        memset((unsigned char*)info + filled, 0, known - filled);
    }
}
