// SPDX-License-Identifier: MIT
//
// Shared by the targets that read untrusted text: a context that counts errors, and assertions.
#pragma once

#include "base/core/context.h"

#include <stdlib.h>

int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size);

static inline void require(bool holds)
{
    if (!holds) {
        abort();
    }
}

static void count_errors(stp_log_level level, const char* message, void* user)
{
    (void)message;
    int* errors = user;
    *errors += level == STP_LOG_ERROR;
}

/// One thread, 256 MiB, counts errors. @return NULL if out of memory
static inline stp_context* fuzz_context_create(int* errors)
{
    stp_context_desc desc = {.thread_count = 1,
                             .memory_limit_bytes = (uint64_t)1 << 28,
                             .log = count_errors,
                             .log_user = errors};
    stp_context* context;
    return stp_context_create(&context, &desc) == STP_OK ? context : NULL;
}
