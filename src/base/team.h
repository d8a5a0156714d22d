// SPDX-License-Identifier: MIT
// Some of a context's threads, for callers that ask for fewer than there are.
#pragma once

#include "base/context.h"

#include <stdatomic.h>

typedef struct stp_team {
    stp_context* context;
    uint32_t threads; ///< at least 1, at most the context's
    /// Once true, no further piece of a loop begins. Belongs to the caller; NULL: never.
    const atomic_bool* stopped;
} stp_team;

/// `wanted` threads of the context, at most all; 0: all.
stp_team stp_team_create(stp_context* context, uint32_t wanted);

/// The same for work that begins and ends now. One thread where the context runs a loop already: loops inside it run on
/// the calling thread, and what prepares work for several would be lost.
stp_team stp_team_create_now(stp_context* context, uint32_t wanted);

/// As many threads as make anything faster, for loops whose members need much memory each: all of the context's, but
/// of those beyond STP_TEAM_FEW no more than there are processors.
stp_team stp_team_create_useful(stp_context* context);

enum { STP_TEAM_FEW = 4 };

/// stp_parallel_for on at most the team's threads. `worker` is below `threads`.
void stp_team_run(const stp_team* team, size_t count, size_t grain, stp_job job, void* user);
