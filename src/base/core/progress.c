// SPDX-License-Identifier: MIT
// Progress of stages, of reported loops, and of the whole call.
#include "base/core/context_internal.h"
#include "base/math/math.h"

#include <assert.h>
#include <string.h>

void stp_progress_plan(stp_context* context, const stp_stage* stages, size_t count)
{
    context->stages = stages;
    context->stage_count = count;
    if (count == 0) {
        context->overall = -1.0;
    } else if (context->overall < 0.0) {
        context->overall = 0.0;
    }
}

// Overall progress. It never decreases, even under a new plan.
static double find_overall(stp_context* context, const char* stage, double fraction)
{
    double before = 0.0, here = 0.0, whole = 0.0;
    for (size_t i = 0; i < context->stage_count; ++i) {
        if (strcmp(context->stages[i].name, stage) == 0) {
            before = whole;
            here = context->stages[i].weight;
        }
        assert(context->stages[i].weight >= 0.0);
        whole += context->stages[i].weight;
    }
    double reached = whole > 0.0 ? stp_clampd((before + here * fraction) / whole, 0.0, 1.0) : 0.0;
    if (context->stage_count != 0 && reached > context->overall) {
        context->overall = reached;
    }
    return context->overall;
}

// @return false if the caller wants to stop
static bool send(stp_context* context, stp_progress_report* report)
{
    const stp_context_desc* desc = &context->desc;
    if (desc->progress == NULL) {
        return true;
    }
    report->fraction = stp_clampd(report->fraction, 0.0, 1.0);
    report->overall = find_overall(context, report->stage, report->fraction);
    return desc->progress(report, desc->progress_user) == 0;
}

static stp_result fail_cancelled(stp_context* context, const char* stage)
{
    return stp_fail(context, STP_ERROR_CANCELLED, "stopped while at: %s", stage);
}

// Reports the loop's progress. Call on the calling thread.
static void report_loop(stp_reported_loop* loop)
{
    assert(pthread_equal(pthread_self(), loop->caller) && "only the calling thread reports");
    uint64_t done = atomic_load(&loop->done), total = loop->report.total;
    done = done < total ? done : total;
    stp_progress_report report = {
        .stage = loop->report.stage,
        .fraction = total != 0 ? (double)done / (double)total : 0.0,
        .done = done,
        .total = total,
        .unit = loop->report.unit,
    };
    if (!atomic_load(&loop->stopped) && !send(loop->context, &report)) {
        (void)fail_cancelled(loop->context, report.stage);
        atomic_store(&loop->stopped, true);
    }
}

stp_result stp_progress(stp_context* context, const char* stage, double fraction)
{
    stp_reported_loop* loop = context->loop;
    if (loop != NULL) {
        if (pthread_equal(pthread_self(), loop->caller)) {
            report_loop(loop);
        }
        return atomic_load(&loop->stopped) ? STP_ERROR_CANCELLED : STP_OK;
    }
    if (stp_jobs_running(context->jobs)) {
        return STP_OK; // inside a parallel loop: only the calling thread reports
    }
    stp_progress_report report = {.stage = stage, .fraction = fraction};
    return send(context, &report) ? STP_OK : fail_cancelled(context, stage);
}

void stp_parallel_for(stp_context* context, size_t count, size_t grain, stp_job job, void* user)
{
    stp_jobs_loop loop = {.count = count, .grain = grain, .job = job, .user = user};
    stp_jobs_run(context->jobs, &loop);
}

static void run_reported_task(size_t begin, size_t end, uint32_t worker, void* user)
{
    stp_reported_loop* loop = user;
    loop->job(begin, end, worker, loop->user);
}

static void run_counted_task(size_t begin, size_t end, uint32_t worker, void* user)
{
    stp_reported_loop* loop = user;
    loop->job(begin, end, worker, loop->user);
    atomic_fetch_add(&loop->done, end - begin);
}

static void tick(void* user)
{
    report_loop(user);
}

stp_result stp_parallel_for_reported(stp_context* context, size_t count, size_t grain, stp_job job,
                                     void* user, const stp_loop_report* report)
{
    stp_reported_loop* outer = context->loop;
    if (outer != NULL || stp_jobs_running(context->jobs)) {
        stp_jobs_loop inner = {.count = count,
                               .grain = grain,
                               .job = job,
                               .user = user,
                               .stopped = outer != NULL ? &outer->stopped : NULL};
        stp_jobs_run(context->jobs, &inner);
        return outer != NULL && atomic_load(&outer->stopped) ? STP_ERROR_CANCELLED : STP_OK;
    }
    stp_reported_loop loop = {
        .context = context,
        .report = *report,
        .job = job,
        .user = user,
        .caller = pthread_self(),
    };
    bool counted = report->total == 0;
    assert(report->stage != NULL && grain > 0);
    loop.report.total = counted ? count : report->total;
    atomic_init(&loop.done, 0);
    atomic_init(&loop.stopped, false);
    context->loop = &loop;
    report_loop(&loop);
    stp_jobs_loop jobs_loop = {.count = count,
                               .grain = grain,
                               .job = counted ? run_counted_task : run_reported_task,
                               .user = &loop,
                               .tick = tick,
                               .stopped = &loop.stopped};
    stp_jobs_run(context->jobs, &jobs_loop);
    report_loop(&loop); // another thread may have run the last task
    assert(context->loop == &loop && "loops end in the reverse order");
    context->loop = NULL;
    return atomic_load(&loop.stopped) ? STP_ERROR_CANCELLED : STP_OK;
}

void stp_progress_add(stp_context* context, uint64_t amount)
{
    if (context->loop != NULL) {
        atomic_fetch_add(&context->loop->done, amount);
    }
}

void stp_parallel_stop(stp_context* context)
{
    if (context->loop != NULL) {
        atomic_store(&context->loop->stopped, true);
    }
}
