// SPDX-License-Identifier: MIT
// The monotonic clock, and waiting for other threads.
#pragma once

#include "base/core/context.h"

#include <pthread.h>

/// Milliseconds since an arbitrary start; monotonic. For reports only: no result may depend on it.
double stp_clock_ms(void);

// Condition variables that wake up regularly, so that the reporting thread can keep reporting
// progress while it waits.

/// Initialises a condition for the functions below. Uses the monotonic clock: the wall clock may be
/// set.
void stp_condition_init(pthread_cond_t* condition);

/// Waits for a signal, at most 50 ms. Call with the mutex held; it is held on return. @return
/// whether it was signalled
bool stp_condition_wait(pthread_cond_t* condition, pthread_mutex_t* mutex);

/// Waits inside a job. The reporting thread reports while the mutex is free.
/// @return STP_OK: check the condition again; STP_ERROR_CANCELLED: the loop was stopped
STP_MUST_USE stp_result stp_condition_wait_reported(stp_context* context, pthread_cond_t* condition,
                                                    pthread_mutex_t* mutex);
