// SPDX-License-Identifier: MIT
// Tests that damage files try some places; with STP_TEST_EXHAUSTIVE=1, as scripts/check_long sets
// it, they try more, most of them all.
#pragma once

#include <stddef.h>
#include <stdlib.h>

/// Distance between places to try: `usual`, or 1 if tests are exhaustive. An odd distance meets all
/// alignments, and all bits of `1u << place % 8`.
static inline size_t test_stride(size_t usual)
{
    const char* wanted = getenv("STP_TEST_EXHAUSTIVE");
    return wanted != NULL && wanted[0] == '1' ? 1 : usual;
}
