// SPDX-License-Identifier: MIT
// Services of a context: memory, messages, progress, parallel loops.
#pragma once

#include <stipple/base.h>

#include <stdarg.h>
#include <stdbool.h>

/// 64-byte aligned, uninitialised; NULL if memory or the context's limit is exhausted. Any thread.
void* stp_alloc(stp_context* context, size_t size);
/// Room for `count` elements of `size` bytes; NULL also if their product overflows.
void* stp_alloc_array(stp_context* context, size_t count, size_t size);
/// The same, filled with zero bytes.
void* stp_alloc_zeroed(stp_context* context, size_t count, size_t size);
/// Frees memory. NULL is allowed. Any thread.
void stp_free(stp_context* context, void* memory);

/// Reserves an estimate of the bytes that a foreign library is about to allocate; false if that
/// would exceed the context's limit. Undo with stp_release. Any thread.
STP_MUST_USE bool stp_reserve(stp_context* context, uint64_t size);
void stp_release(stp_context* context, uint64_t size);
/// Limit on allocated bytes; 0: unlimited.
uint64_t stp_memory_limit(const stp_context* context);
/// Memory that work which can spill to files may use: the limit, or most of the machine's memory if
/// `limit` is 0.
uint64_t stp_usable_memory(uint64_t limit);
/// Returns free malloc memory to the system. Call after work with many small allocations.
void stp_trim_heap(void);

/// Makes room for `needed` elements of `size` bytes in an array, which may move: grows it by half or
/// more and keeps its elements. `array_address` points to the array's pointer, of any type. @return
/// false if out of memory, not logged: the array is as before
STP_MUST_USE bool stp_make_room(stp_context* context, void* array_address, size_t* capacity,
                                size_t needed, size_t size);
/// stp_make_room where the pointer's type gives the size. `array` and `capacity` (size_t) are the
/// variables or members themselves.
#define STP_MAKE_ROOM(context, array, capacity, needed)                                            \
    stp_make_room((context), &(array), &(capacity), (needed), sizeof(*(array)))

#define STP_NEW_ARRAY(context, type, count)                                                        \
    ((type*)stp_alloc_array((context), (count), sizeof(type)))
#define STP_NEW_ZEROED(context, type, count)                                                       \
    ((type*)stp_alloc_zeroed((context), (count), sizeof(type)))

/// Logs why a call fails and returns `result`. Call once, where the failure is detected. The
/// sentence names the file, the place and what was expected: "plant.glb: accessor 7: bufferView 12
/// does not exist (the file has 3)".
stp_result stp_fail(stp_context* context, stp_result result, const char* format, ...)
    __attribute__((format(printf, 3, 4)));
stp_result stp_fail_memory(stp_context* context);
/// For functions of the headers: whether a pointer that they need is there. @return STP_OK or
/// STP_ERROR_ARGUMENT (logged)
#define STP_CHECK_POINTER(context, pointer)                                                        \
    ((pointer) != NULL                                                                             \
         ? STP_OK                                                                                  \
         : stp_fail((context), STP_ERROR_ARGUMENT, "%s: %s is NULL", __func__, #pointer))
/// Estimated bytes that the next work needs in all, for the message of stp_fail_memory; 0: unknown.
void stp_context_expect_bytes(stp_context* context, uint64_t bytes);
/// From now on, does not log errors but keeps the first: for work that is retried on failure.
/// Another call discards the kept error.
void stp_hold_errors(stp_context* context);
/// Logs errors again. `log`: also logs the kept one.
void stp_release_errors(stp_context* context, bool log);
void stp_warn(stp_context* context, const char* format, ...) __attribute__((format(printf, 2, 3)));
void stp_notice(stp_context* context, const char* format, ...)
    __attribute__((format(printf, 2, 3)));

/// Reports progress. Does nothing inside a parallel loop. Inside a reported loop, that loop
/// reports, and this tells whether it was stopped: long jobs should call it regularly. Any thread.
/// @return STP_OK, or STP_ERROR_CANCELLED (already logged) if the caller wants to stop
STP_MUST_USE stp_result stp_progress(stp_context* context, const char* stage, double fraction);

/// A stage of a long call. `weight`: its share of the total time, in any unit.
typedef struct stp_stage {
    const char* name;
    double weight;
} stp_stage;

/// Declares the coming stages in order, so that reports include the overall progress. 0 stages:
/// unknown.
/// `stages` must stay valid until the next plan. Unlisted stages do not change the overall
/// progress. Overall progress never decreases when a plan replaces another; a plan of 0 stages
/// resets it.
void stp_progress_plan(stp_context* context, const stp_stage* stages, size_t count);

/// A task of a loop: elements [begin, end). `worker` is below the thread count, and only one task
/// at a time uses it, so it may index per-worker state. Results must not depend on `worker`.
typedef void (*stp_job)(size_t begin, size_t end, uint32_t worker, void* user);

/// Runs `job` over [0, count) in tasks of `grain` (the last may be shorter) on all threads
/// including the caller's, and returns when all are done. Tasks are claimed in order. A nested
/// call runs serially on its job's thread, with `worker` 0.
void stp_parallel_for(stp_context* context, size_t count, size_t grain, stp_job job, void* user);

/// What a loop reports. `total` 0: it counts elements, and `unit` names them.
typedef struct stp_loop_report {
    const char* stage; ///< static text
    const char* unit;  ///< static text
    uint64_t total;    ///< sum of all stp_progress_add calls
} stp_loop_report;

/// A parallel loop that reports its progress. The calling thread reports between its tasks and
/// while it waits for the others. If the progress callback or a task (stp_parallel_stop) stops it,
/// no further task begins; the tasks that ran are the first ones, without a gap. Nested in
/// another loop, it runs serially and leaves reporting to the outer loop.
/// @return STP_OK, STP_ERROR_CANCELLED (logged, unless a task stopped it)
STP_MUST_USE stp_result stp_parallel_for_reported(stp_context* context, size_t count, size_t grain,
                                                  stp_job job, void* user,
                                                  const stp_loop_report* report);
/// Adds to the progress of the reported loop. Call from its tasks, any thread.
void stp_progress_add(stp_context* context, uint64_t amount);
/// Stops the reported loop from one of its tasks, which has failed and logged why.
void stp_parallel_stop(stp_context* context);
