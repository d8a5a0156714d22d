// SPDX-License-Identifier: MIT
// Worker threads of a context. One loop runs at a time; threads claim tasks from an atomic
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
    /// Called on the calling thread between its tasks and regularly while it waits. May be NULL.
    void (*tick)(void* user);
    /// Once true, no further task begins; the tasks that ran are the first ones, without a gap.
    /// May be NULL.
    const atomic_bool* stopped;
} stp_jobs_loop;

void stp_jobs_run(stp_jobs* jobs, const stp_jobs_loop* loop);
/// Whether a multi-threaded loop is running. Any thread.
bool stp_jobs_running(stp_jobs* jobs);

// A subset of a context's threads.

typedef struct stp_team {
    stp_context* context;
    uint32_t threads; ///< at least 1, at most the context's
    /// Once true, no further task of a loop begins. The caller owns it; NULL: never stops.
    const atomic_bool* stopped;
} stp_team;

/// `wanted` threads, at most all of the context's; 0: all.
stp_team stp_team_create(stp_context* context, uint32_t wanted);

/// The same for work that runs immediately. Returns one thread if the context already runs a loop:
/// nested loops run on the calling thread, so preparing for more threads would be wasted.
stp_team stp_team_create_immediate(stp_context* context, uint32_t wanted);

/// Caps the number of threads for memory-bound loops: all of the context's up to STP_TEAM_FEW, and
/// beyond that at most one per CPU.
stp_team stp_team_create_useful(stp_context* context);

enum { STP_TEAM_FEW = 4 };

/// stp_parallel_for on at most the team's threads. `worker` is below `threads`.
void stp_team_run(const stp_team* team, size_t count, size_t grain, stp_job job, void* user);
