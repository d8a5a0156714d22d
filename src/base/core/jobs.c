// SPDX-License-Identifier: MIT
#include "base/core/jobs.h"

#include "base/core/clock.h"
#include "base/core/context_internal.h"
#include "base/core/processor.h"

#include <assert.h>
#include <pthread.h>

typedef struct worker_start {
    stp_jobs* jobs;
    uint32_t index;
} worker_start;

struct stp_jobs {
    pthread_mutex_t mutex;
    pthread_cond_t work;   ///< signalled when `generation` or `ending` changes
    pthread_cond_t done;   ///< signalled when the last busy worker finishes
    uint64_t generation;   ///< number of the loop that workers should join
    uint32_t busy;         ///< workers that have not finished the current loop
    uint32_t worker_count; ///< threads besides the caller's
    bool ending;
    bool running; ///< a loop runs: nested loops run serially
    stp_jobs_loop loop;
    atomic_size_t next;
    pthread_t* threads;
    worker_start* starts;
};

static bool is_stopped(const stp_jobs_loop* loop)
{
    return loop->stopped != NULL && atomic_load(loop->stopped);
}

static void claim_tasks(stp_jobs* jobs, uint32_t worker)
{
    const stp_jobs_loop* loop = &jobs->loop;
    // a claimed task always runs, so the tasks that ran have no gap
    while (!is_stopped(loop)) {
        size_t begin = atomic_fetch_add_explicit(&jobs->next, loop->grain, memory_order_relaxed);
        if (begin >= loop->count) {
            return;
        }
        size_t left = loop->count - begin;
        loop->job(begin, begin + (left < loop->grain ? left : loop->grain), worker, loop->user);
        if (worker == 0 && loop->tick != NULL) {
            loop->tick(loop->user);
        }
    }
}

static void* run_worker(void* argument)
{
    worker_start start = *(worker_start*)argument;
    stp_jobs* jobs = start.jobs;
    uint64_t seen = 0;
    pthread_mutex_lock(&jobs->mutex);
    for (;;) {
        while (jobs->generation == seen && !jobs->ending) {
            pthread_cond_wait(&jobs->work, &jobs->mutex);
        }
        if (jobs->ending) {
            break;
        }
        seen = jobs->generation;
        pthread_mutex_unlock(&jobs->mutex);
        claim_tasks(jobs, start.index);
        pthread_mutex_lock(&jobs->mutex);
        assert(jobs->busy > 0 && seen == jobs->generation && "the loop waits for this worker");
        jobs->busy -= 1;
        if (jobs->busy == 0) {
            pthread_cond_signal(&jobs->done);
        }
    }
    pthread_mutex_unlock(&jobs->mutex);
    return NULL;
}

stp_result stp_jobs_create(stp_jobs** jobs, stp_context* context, uint32_t thread_count)
{
    assert(thread_count >= 1);
    stp_jobs* made = STP_NEW_ZEROED(context, stp_jobs, 1);
    if (made == NULL) {
        return STP_ERROR_OUT_OF_MEMORY;
    }
    pthread_mutex_init(&made->mutex, NULL);
    pthread_cond_init(&made->work, NULL);
    stp_condition_init(&made->done);
    atomic_init(&made->next, 0);
    made->threads = STP_NEW_ARRAY(context, pthread_t, thread_count);
    made->starts = STP_NEW_ARRAY(context, worker_start, thread_count);
    if (made->threads == NULL || made->starts == NULL) {
        stp_jobs_destroy(made, context);
        return STP_ERROR_OUT_OF_MEMORY;
    }
    while (made->worker_count + 1 < thread_count) {
        uint32_t index = made->worker_count;
        made->starts[index] = (worker_start){.jobs = made, .index = index + 1};
        if (pthread_create(&made->threads[index], NULL, run_worker, &made->starts[index]) != 0) {
            stp_jobs_destroy(made, context);
            return STP_ERROR_LIMIT;
        }
        made->worker_count += 1;
    }
    *jobs = made;
    return STP_OK;
}

void stp_jobs_destroy(stp_jobs* jobs, stp_context* context)
{
    pthread_mutex_lock(&jobs->mutex);
    assert(!jobs->running && "destroyed inside a loop");
    jobs->ending = true;
    pthread_cond_broadcast(&jobs->work);
    pthread_mutex_unlock(&jobs->mutex);
    for (uint32_t i = 0; i < jobs->worker_count; ++i) {
        pthread_join(jobs->threads[i], NULL);
    }
    pthread_cond_destroy(&jobs->done);
    pthread_cond_destroy(&jobs->work);
    pthread_mutex_destroy(&jobs->mutex);
    stp_free(context, jobs->starts);
    stp_free(context, jobs->threads);
    stp_free(context, jobs);
}

uint32_t stp_jobs_thread_count(const stp_jobs* jobs)
{
    return jobs->worker_count + 1;
}

static void run_serially(const stp_jobs_loop* loop)
{
    size_t left = loop->count;
    assert(loop->grain > 0 && "the loop ends");
    while (left > 0 && !is_stopped(loop)) {
        size_t begin = loop->count - left;
        size_t size = left < loop->grain ? left : loop->grain;
        loop->job(begin, begin + size, 0, loop->user);
        if (loop->tick != NULL) {
            loop->tick(loop->user);
        }
        left -= size;
    }
}

// Waits until the workers are done. Call with the mutex held.
static void wait_for_workers(stp_jobs* jobs)
{
    while (jobs->busy != 0) {
        if (jobs->loop.tick == NULL) {
            pthread_cond_wait(&jobs->done, &jobs->mutex);
            continue;
        }
        if (!stp_condition_wait(&jobs->done, &jobs->mutex)) {
            pthread_mutex_unlock(&jobs->mutex);
            jobs->loop.tick(jobs->loop.user);
            pthread_mutex_lock(&jobs->mutex);
        }
    }
}

void stp_jobs_run(stp_jobs* jobs, const stp_jobs_loop* loop)
{
    assert(loop->grain > 0);
    if (jobs->worker_count == 0 || loop->count <= loop->grain) {
        run_serially(loop);
        return;
    }
    pthread_mutex_lock(&jobs->mutex);
    if (jobs->running) {
        pthread_mutex_unlock(&jobs->mutex);
        run_serially(loop);
        return;
    }
    assert(jobs->busy == 0 && "the last loop has ended");
    jobs->running = true;
    jobs->loop = *loop;
    atomic_store_explicit(&jobs->next, 0, memory_order_relaxed);
    jobs->busy = jobs->worker_count;
    jobs->generation += 1;
    pthread_cond_broadcast(&jobs->work);
    pthread_mutex_unlock(&jobs->mutex);

    claim_tasks(jobs, 0);

    pthread_mutex_lock(&jobs->mutex);
    wait_for_workers(jobs);
    assert((is_stopped(loop) || atomic_load(&jobs->next) >= loop->count) && "all tasks ran");
    jobs->running = false;
    pthread_mutex_unlock(&jobs->mutex);
}

bool stp_jobs_running(stp_jobs* jobs)
{
    pthread_mutex_lock(&jobs->mutex);
    bool running = jobs->running;
    pthread_mutex_unlock(&jobs->mutex);
    return running;
}

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
