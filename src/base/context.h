// SPDX-License-Identifier: MIT
// What the rooms may ask of a context: memory, messages, progress, parallel loops.
#pragma once

#include <stipple/base.h>

#include <stdarg.h>
#include <stdbool.h>

/// 64-byte aligned, uninitialised; NULL where memory or the context's limit runs out. Any thread.
void* stp_alloc(stp_context* context, size_t size);
/// Room for `count` elements of `size` bytes; NULL also where their product overflows.
void* stp_alloc_array(stp_context* context, size_t count, size_t size);
/// The same, filled with zero bytes.
void* stp_alloc_zeroed(stp_context* context, size_t count, size_t size);
/// Gives memory back. NULL is allowed. Any thread.
void stp_free(stp_context* context, void* memory);

/// Counts bytes that a foreign library is about to allocate by itself, as far as can be told before; false where that
/// would pass the context's limit. Give back with stp_release. Any thread.
STP_MUST_USE bool stp_reserve(stp_context* context, uint64_t size);
void stp_release(stp_context* context, uint64_t size);
/// The most bytes that may be allocated; 0: no limit.
uint64_t stp_memory_limit(const stp_context* context);
/// What work may use that can spill the rest to files: the limit, or most of the machine's memory where it is 0.
uint64_t stp_usable_memory(uint64_t limit);
/// Gives what malloc holds free back to the system: after work with many small pieces.
void stp_trim_heap(void);

/// Room for at least `needed` elements of `size` bytes, grown by half each time; old elements are kept.
/// @return the array, perhaps moved; NULL where memory runs out, with the old one still valid
void* stp_grow_array(stp_context* context, void* array, size_t* capacity, size_t needed,
                     size_t size);

#define STP_NEW_ARRAY(context, type, count)                                                        \
    ((type*)stp_alloc_array((context), (count), sizeof(type)))
#define STP_NEW_ZEROED(context, type, count)                                                       \
    ((type*)stp_alloc_zeroed((context), (count), sizeof(type)))

/// Says why a call fails, once, where it was noticed; returns `result`. The sentence names the file and
/// the place, and what was expected: "plant.glb: accessor 7: bufferView 12 does not exist (the file has 3)".
stp_result stp_fail(stp_context* context, stp_result result, const char* format, ...)
    __attribute__((format(printf, 3, 4)));
stp_result stp_fail_memory(stp_context* context);
/// What the work that follows is thought to take in all, for the message of stp_fail_memory; 0: not known.
void stp_context_expect_bytes(stp_context* context, uint64_t bytes);
/// Errors are not logged from now on, but the first is kept: for work that is tried again where it fails. Called again,
/// what was kept is forgotten.
void stp_hold_errors(stp_context* context);
/// Errors are logged again. `log`: so is the one that was kept.
void stp_release_errors(stp_context* context, bool log);
void stp_warn(stp_context* context, const char* format, ...) __attribute__((format(printf, 2, 3)));
void stp_notice(stp_context* context, const char* format, ...)
    __attribute__((format(printf, 2, 3)));

/// Reports progress; @return STP_OK, or STP_ERROR_CANCELLED (already logged) when the caller wants to stop.
/// Inside a parallel loop it does nothing. Inside one that reports for itself it lets that one report, and tells
/// whether it was stopped: long pieces should ask now and then. Any thread.
STP_MUST_USE stp_result stp_progress(stp_context* context, const char* stage, double fraction);

/// A stage of a long call, and its share of the whole time in any unit.
typedef struct stp_stage {
    const char* name;
    double weight;
} stp_stage;

/// Names the stages to come, in order, so that reports know how far the whole is; 0 stages: that is not known.
/// `stages` must live until the next plan. A stage reported that is none of them leaves the whole as it was. What was
/// reached already is kept, so a better plan may replace a worse one; 0 stages in between begin anew.
void stp_progress_plan(stp_context* context, const stp_stage* stages, size_t count);

/// A piece of a loop: elements [begin, end). `worker` is below the thread count and is used by one piece
/// at a time, so it may index per-worker state. What a piece computes must not depend on `worker`.
typedef void (*stp_job)(size_t begin, size_t end, uint32_t worker, void* user);

/// Runs `job` over [0, count) in pieces of `grain` (the last may be shorter) on all threads, the caller's
/// included, and returns when all are done. Pieces are claimed in order. A call from inside a job runs
/// serially, on that job's thread, with `worker` 0 of its own.
void stp_parallel_for(stp_context* context, size_t count, size_t grain, stp_job job, void* user);

/// What a loop says of itself. `total` 0: elements are counted, `unit` is theirs.
typedef struct stp_loop_report {
    const char* stage; ///< static text
    const char* unit;  ///< static text
    uint64_t total;    ///< what its pieces hand to stp_progress_add in all
} stp_loop_report;

/// A parallel loop that reports how far it is: the calling thread does so between its pieces, and while it waits for
/// the others. Where the caller of the library or a piece (stp_parallel_stop) stops it, no further piece begins; those
/// that ran are the first ones without a gap. Inside another loop it runs serially and leaves reporting to that one.
/// @return STP_OK, STP_ERROR_CANCELLED (logged, except where a piece stopped it)
STP_MUST_USE stp_result stp_parallel_for_reported(stp_context* context, size_t count, size_t grain,
                                                  stp_job job, void* user,
                                                  const stp_loop_report* report);
/// Adds to what the loop that reports has done. From its pieces, any thread.
void stp_progress_add(stp_context* context, uint64_t amount);
/// Ends the loop that reports, from one of its pieces: one that failed, and said why.
void stp_parallel_stop(stp_context* context);
