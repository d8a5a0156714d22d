// SPDX-License-Identifier: MIT
// Worker threads of a context. One loop runs at a time; threads claim pieces from an atomic
// counter.
#pragma once

#include "base/core/context.h"

#include <stdatomic.h>

typedef struct stp_jobs stp_jobs;

STP_MUST_USE stp_result stp_jobs_create(stp_jobs** jobs, stp_context* context,
                                        uint32_t thread_count);
void stp_jobs_destroy(stp_jobs* jobs, stp_context* context);
uint32_t stp_jobs_thread_count(const stp_jobs* jobs);

/// A loop; see stp_parallel_for.
typedef struct stp_jobs_loop {
    size_t count, grain;
    stp_job job;
    void* user;
    /// Called on the calling thread between its pieces and regularly while it waits. May be NULL.
    void (*tick)(void* user);
    /// Once true, no further piece begins; the pieces that ran are the first ones, without a gap.
    /// May be NULL.
    const atomic_bool* stopped;
} stp_jobs_loop;

void stp_jobs_run(stp_jobs* jobs, const stp_jobs_loop* loop);
/// Whether a multi-threaded loop is running. Any thread.
bool stp_jobs_running(stp_jobs* jobs);
