// SPDX-License-Identifier: MIT
// Comparison of built files.
#pragma once

#include "tests.h"

#include "base/io/file.h"

#include <string.h>

/// Whether two files have the same bytes; false if one cannot be read.
static inline bool same_files(const char* a, const char* b)
{
    stp_context* context = test_context(NULL, 1, NULL);
    stp_mapped_file first, second;
    bool same = false;
    if (stp_file_map(context, a, &first) == STP_OK) {
        if (stp_file_map(context, b, &second) == STP_OK) {
            same = first.size == second.size && memcmp(first.bytes, second.bytes, first.size) == 0;
            stp_file_unmap(&second);
        }
        stp_file_unmap(&first);
    }
    stp_context_destroy(context);
    return same;
}
