// SPDX-License-Identifier: MIT
#include "base/jobs.h"

#include <assert.h>
#include <pthread.h>
#include <stdatomic.h>

typedef struct worker_start {
    stp_jobs* jobs;
    uint32_t index;
} worker_start;

struct stp_jobs {
    pthread_mutex_t mutex;
    pthread_cond_t work;   ///< signalled when `generation` or `ending` changes
    pthread_cond_t done;   ///< signalled when the last busy worker finishes
    uint64_t generation;   ///< number of the loop the workers should join
    uint32_t busy;         ///< workers that have not finished the current loop
    uint32_t worker_count; ///< threads besides the caller's
    bool ending;
    bool running; ///< a loop is on: a nested one runs serially
    size_t count, grain;
    stp_job job;
    void* user;
    atomic_size_t next;
    pthread_t* threads;
    worker_start* starts;
};

static void claim_pieces(stp_jobs* jobs, uint32_t worker)
{
    for (;;) {
        size_t begin = atomic_fetch_add_explicit(&jobs->next, jobs->grain, memory_order_relaxed);
        if (begin >= jobs->count) {
            return;
        }
        size_t left = jobs->count - begin;
        jobs->job(begin, begin + (left < jobs->grain ? left : jobs->grain), worker, jobs->user);
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
        claim_pieces(jobs, start.index);
        pthread_mutex_lock(&jobs->mutex);
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
    pthread_cond_init(&made->done, NULL);
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

static void run_serially(size_t count, size_t grain, stp_job job, void* user)
{
    for (size_t begin = 0; begin < count; begin += grain) {
        job(begin, count - begin < grain ? count : begin + grain, 0, user);
    }
}

void stp_jobs_run(stp_jobs* jobs, size_t count, size_t grain, stp_job job, void* user)
{
    assert(grain > 0);
    if (jobs->worker_count == 0 || count <= grain) {
        run_serially(count, grain, job, user);
        return;
    }
    pthread_mutex_lock(&jobs->mutex);
    if (jobs->running) {
        pthread_mutex_unlock(&jobs->mutex);
        run_serially(count, grain, job, user);
        return;
    }
    jobs->running = true;
    jobs->count = count;
    jobs->grain = grain;
    jobs->job = job;
    jobs->user = user;
    atomic_store_explicit(&jobs->next, 0, memory_order_relaxed);
    jobs->busy = jobs->worker_count;
    jobs->generation += 1;
    pthread_cond_broadcast(&jobs->work);
    pthread_mutex_unlock(&jobs->mutex);

    claim_pieces(jobs, 0);

    pthread_mutex_lock(&jobs->mutex);
    while (jobs->busy != 0) {
        pthread_cond_wait(&jobs->done, &jobs->mutex);
    }
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
