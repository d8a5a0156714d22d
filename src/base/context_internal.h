// SPDX-License-Identifier: MIT
// What a context is, for the files of this room that make it up.
#pragma once

#include "base/jobs.h"
#include "base/large_blocks.h"

#include <pthread.h>
#include <stdatomic.h>

/// A loop that reports how far it is, while it runs.
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
    // errors are logged; the next is kept; one was
    STP_HELD_NOT = 0,
    STP_HELD_NEXT = 1,
    STP_HELD_ONE = 2,
};

struct stp_context {
    stp_allocator allocator;
    stp_large_blocks large_blocks; ///< of the allocator that is used where the caller has none
    stp_context_desc desc;
    stp_jobs* jobs;
    atomic_uint_fast64_t live_bytes;
    atomic_uint_fast64_t peak_bytes;
    atomic_uint_fast64_t refused_bytes; ///< the most that was asked for beyond the limit
    atomic_uint_fast64_t needed_bytes;  ///< what the caller's work is thought to take; 0: not known
    atomic_int held;                    ///< STP_HELD_*
    char held_error[STP_MESSAGE_SIZE];
    // of the thread that calls; workers read `loop` while it is on
    stp_reported_loop* loop;
    const stp_stage* stages;
    size_t stage_count;
    double overall; ///< reached so far; negative: not known
};
