// SPDX-License-Identifier: MIT
// Definition of a context, shared by the files of this room that implement it.
#pragma once

#include "base/core/jobs.h"
#include "base/core/large_blocks.h"

#include <pthread.h>
#include <stdatomic.h>

/// State of a reported loop while it runs.
typedef struct stp_reported_loop {
    stp_context* context;
    stp_loop_report report;
    stp_job job;
    void* user;
    pthread_t caller; ///< the only thread that reports
    atomic_uint_fast64_t done;
    atomic_bool stopped;
} stp_reported_loop;

enum {
    STP_MESSAGE_SIZE = 1024,
    // errors are logged; the next one is kept; one is kept
    STP_HELD_NOT = 0,
    STP_HELD_NEXT = 1,
    STP_HELD_ONE = 2,
};

struct stp_context {
    stp_allocator allocator;
    stp_large_blocks large_blocks; ///< blocks of the default allocator; else unused
    stp_context_desc desc;
    stp_jobs* jobs;
    atomic_uint_fast64_t live_bytes;
    atomic_uint_fast64_t peak_bytes;
    atomic_uint_fast64_t refused_bytes; ///< largest request refused by the limit
    atomic_uint_fast64_t needed_bytes;  ///< estimated need of the caller's work; 0: unknown
    atomic_int held;                    ///< STP_HELD_*
    char held_error[STP_MESSAGE_SIZE];
    // owned by the calling thread; workers read `loop` while it runs
    stp_reported_loop* loop;
    const stp_stage* stages;
    size_t stage_count;
    double overall; ///< overall progress so far; negative: unknown
};
