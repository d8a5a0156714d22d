// SPDX-License-Identifier: MIT
//
// What a build found and what it made. Things of one content have one result in the work directory: what the first of
// them has made is found by the others, and with several threads chance tells which. Only what was there before the
// build began counts as found.
#pragma once

#include "base/hash.h"

#include <stdbool.h>
#include <stddef.h>

typedef struct stp_build_result {
    stp_hash key;
    bool made; ///< by this build; else it was there when it was looked for
} stp_build_result;

/// How many have a key that none made. Sorts them.
size_t stp_build_count_found(stp_build_result* origins, size_t count);
