// SPDX-License-Identifier: MIT
#include "base/core/clock.h"

#include <assert.h>
#include <time.h>

double stp_clock_ms(void)
{
    struct timespec now;
    clock_gettime(CLOCK_MONOTONIC, &now);
    return (double)now.tv_sec * 1e3 + (double)now.tv_nsec * 1e-6;
}

#define WAIT_NS 50000000L
#define SECOND_NS 1000000000L

void stp_condition_init(pthread_cond_t* condition)
{
    pthread_condattr_t steady;
    pthread_condattr_init(&steady);
    pthread_condattr_setclock(&steady, CLOCK_MONOTONIC);
    pthread_cond_init(condition, &steady);
    pthread_condattr_destroy(&steady);
}

bool stp_condition_wait(pthread_cond_t* condition, pthread_mutex_t* mutex)
{
    struct timespec until;
    (void)clock_gettime(CLOCK_MONOTONIC, &until);
    until.tv_nsec += WAIT_NS;
    if (until.tv_nsec >= SECOND_NS) {
        until.tv_nsec -= SECOND_NS;
        until.tv_sec += 1;
    }
    assert(until.tv_nsec >= 0 && until.tv_nsec < SECOND_NS);
    return pthread_cond_timedwait(condition, mutex, &until) == 0;
}

stp_result stp_condition_wait_reported(stp_context* context, pthread_cond_t* condition,
                                       pthread_mutex_t* mutex)
{
    (void)stp_condition_wait(condition, mutex);
    pthread_mutex_unlock(mutex);
    stp_result result = stp_progress(context, "wait", 0.0);
    pthread_mutex_lock(mutex);
    return result;
}
