// SPDX-License-Identifier: MIT
// The worker threads of a context. One loop runs at a time; its pieces are claimed from an atomic counter.
#pragma once

#include "base/context.h"

typedef struct stp_jobs stp_jobs;

STP_MUST_USE stp_result stp_jobs_create(stp_jobs** jobs, stp_context* context,
                                        uint32_t thread_count);
void stp_jobs_destroy(stp_jobs* jobs, stp_context* context);
uint32_t stp_jobs_thread_count(const stp_jobs* jobs);
void stp_jobs_run(stp_jobs* jobs, size_t count, size_t grain, stp_job job, void* user);
/// Whether a loop is on that several threads share. Any thread.
bool stp_jobs_running(stp_jobs* jobs);
