// SPDX-License-Identifier: MIT
// A subset of a context's threads.
#pragma once

#include "base/core/context.h"

#include <stdatomic.h>

typedef struct stp_team {
    stp_context* context;
    uint32_t threads; ///< at least 1, at most the context's
    /// Once true, no further piece of a loop begins. The caller owns it; NULL: never stops.
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
