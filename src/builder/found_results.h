// SPDX-License-Identifier: MIT
//
// Counts the results that a build found and made. Items with equal content share one result in the
// work directory: the first one makes it and the others find it, and with several threads it varies
// which is first. Only results from before the build count as found.
#pragma once

#include "base/io/hash.h"

#include <stdbool.h>
#include <stddef.h>

typedef struct stp_build_result {
    stp_hash key;
    bool made; ///< made by this build; else it existed when looked up
} stp_build_result;

/// Number of entries whose key no entry made. Sorts the entries.
size_t stp_build_count_found(stp_build_result* origins, size_t count);
