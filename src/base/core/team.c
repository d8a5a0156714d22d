// SPDX-License-Identifier: MIT
#include "base/core/team.h"

#include "base/core/context_internal.h"
#include "base/core/processor.h"

#include <assert.h>

stp_team stp_team_create(stp_context* context, uint32_t wanted)
{
    uint32_t all = stp_context_thread_count(context);
    assert(all >= 1);
    return (stp_team){.context = context, .threads = wanted == 0 || wanted > all ? all : wanted};
}

stp_team stp_team_create_immediate(stp_context* context, uint32_t wanted)
{
    return stp_team_create(context, stp_jobs_running(context->jobs) ? 1 : wanted);
}

stp_team stp_team_create_useful(stp_context* context)
{
    uint32_t processors = stp_processor_count();
    return stp_team_create(context, processors > STP_TEAM_FEW ? processors : STP_TEAM_FEW);
}

typedef struct shared_loop {
    atomic_size_t next;
    size_t count, grain;
    stp_job job;
    void* user;
    const atomic_bool* stopped;
} shared_loop;

// Runs one member. `begin` is the member's number, whichever thread runs it.
static void run_member(size_t begin, size_t end, uint32_t worker, void* user)
{
    (void)end, (void)worker;
    shared_loop* loop = user;
    for (;;) {
        size_t first = atomic_fetch_add_explicit(&loop->next, loop->grain, memory_order_relaxed);
        bool stopped =
            loop->stopped != NULL && atomic_load_explicit(loop->stopped, memory_order_relaxed);
        if (first >= loop->count || stopped) {
            return;
        }
        size_t left = loop->count - first;
        loop->job(first, first + (left < loop->grain ? left : loop->grain), (uint32_t)begin,
                  loop->user);
    }
}

void stp_team_run(const stp_team* team, size_t count, size_t grain, stp_job job, void* user)
{
    assert(grain > 0 && "the loop ends");
    assert(team->threads >= 1 && team->threads <= stp_context_thread_count(team->context));
    if (team->threads == stp_context_thread_count(team->context) && team->threads > 1) {
        stp_jobs_loop all = {
            .count = count, .grain = grain, .job = job, .user = user, .stopped = team->stopped};
        stp_jobs_run(team->context->jobs, &all);
        return;
    }
    shared_loop loop = {
        .count = count, .grain = grain, .job = job, .user = user, .stopped = team->stopped};
    atomic_init(&loop.next, 0);
    if (team->threads == 1 || count <= grain) {
        run_member(0, 1, 0, &loop);
        return;
    }
    stp_parallel_for(team->context, team->threads, 1, run_member, &loop);
}
