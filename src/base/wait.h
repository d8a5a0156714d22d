// SPDX-License-Identifier: MIT
// Waiting for other threads without falling silent: conditions that wake up now and then, so that the thread that
// reports progress can do so.
#pragma once

#include "base/context.h"

#include <pthread.h>

/// A condition for the functions below: on the steady clock, for that of the wall may be set.
void stp_condition_init(pthread_cond_t* condition);

/// Waits for a signal, 50 ms at most. The mutex is held before and after. @return whether it was signalled
bool stp_condition_wait(pthread_cond_t* condition, pthread_mutex_t* mutex);

/// The same from within a job: lets the loop that reports go on reporting while the mutex is free.
/// @return STP_OK: look again; STP_ERROR_CANCELLED: the loop was stopped
STP_MUST_USE stp_result stp_condition_wait_reported(stp_context* context, pthread_cond_t* condition,
                                                    pthread_mutex_t* mutex);
