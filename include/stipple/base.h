// SPDX-License-Identifier: MIT
//
// Foundation of all other headers: results, memory hooks, messages and the context.
//
// A *context* holds the allocator, the log and the worker threads. Every object belongs to one
// context and must be destroyed before it. There is no global state: contexts are independent.
// Calls on one context may come from any thread, but only one at a time unless documented
// otherwise.
#pragma once

#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

#define STP_API __attribute__((visibility("default")))
#define STP_MUST_USE __attribute__((warn_unused_result))

/// All result codes and their texts. Add at the end only.
#define STP_RESULTS(X)                                                                             \
    X(OK, "ok")                                                                                    \
    X(ERROR_OUT_OF_MEMORY, "out of memory")                                                        \
    X(ERROR_IO, "file could not be read or written")                                               \
    X(ERROR_TRUNCATED, "file is truncated")                                                        \
    X(ERROR_FORMAT, "file is invalid or damaged")                                                  \
    X(ERROR_VERSION, "file has a newer format version")                                            \
    X(ERROR_CANCELLED, "stopped by the caller")                                                    \
    X(ERROR_UNSUPPORTED, "a required feature is not supported")                                    \
    X(ERROR_LIMIT, "a limit was exceeded")                                                         \
    X(ERROR_ARGUMENT, "an option's value is out of range")                                         \
    X(ERROR_BUSY, "in use by another program")

typedef enum stp_result {
#define X(name, text) STP_##name,
    STP_RESULTS(X)
#undef X
} stp_result;

/// Text of a result; never NULL.
STP_API const char* stp_result_string(stp_result result);

/// Memory hooks. All zero: the C library's allocator. Called from several threads at once;
/// `alignment` is a power of two, at most 64.
typedef struct stp_allocator {
    void* (*alloc)(size_t size, size_t alignment, void* user);
    void (*free)(void* memory, size_t size, void* user);
    void* user;
} stp_allocator;

typedef enum stp_log_level {
    STP_LOG_ERROR,   ///< the call fails; exactly one such message per failed call
    STP_LOG_WARNING, ///< something in the input was ignored or repaired
    STP_LOG_NOTICE,  ///< for information: an approximation, a default that was used
} stp_log_level;

/// Progress of a long call. If nothing is counted, `total` is 0 and `unit` is NULL.
typedef struct stp_progress_report {
    const char* stage; ///< static text: "import", "capture", ...
    double fraction;   ///< completed part of the stage, 0..1
    double overall; ///< completed part of the whole call, 0..1, never decreases; negative: unknown
    uint64_t done, total; ///< units of the stage; `done` is 0..`total`
    const char* unit;     ///< static text: "triangles", "nodes", ...
} stp_progress_report;

/// Options of a context. Zero selects the default of each field.
typedef struct stp_context_desc {
    size_t struct_size; ///< sizeof(stp_context_desc), or 0: its first version
    stp_allocator allocator;
    /// Receives each message, one sentence without a line end. May be called from several threads
    /// at once and must not call the library. Default: messages are dropped.
    void (*log)(stp_log_level level, const char* message, void* user);
    void* log_user;
    /// Receives progress of long work. Called often: a display should skip most reports. Called
    /// only on the thread that made the call. Return non-zero to stop the work with
    /// STP_ERROR_CANCELLED.
    int (*progress)(const stp_progress_report* report, void* user);
    void* progress_user;
    uint32_t thread_count;       ///< worker threads, including the caller's; default: all CPUs
    uint64_t memory_limit_bytes; ///< allocations beyond it fail; default: no limit
} stp_context_desc;

typedef struct stp_context stp_context;

/// Creates a context and starts its worker threads; the caller destroys it. `desc` may be NULL:
/// all zero. @return STP_OK, STP_ERROR_OUT_OF_MEMORY, STP_ERROR_LIMIT if threads cannot be started,
/// STP_ERROR_ARGUMENT if only one of the allocator's hooks is set, or STP_ERROR_UNSUPPORTED if
/// `desc` sets fields that this library does not know
STP_API STP_MUST_USE stp_result stp_context_create(stp_context** context,
                                                   const stp_context_desc* desc);

/// Stops the worker threads. All objects of the context must have been destroyed; an assertion
/// checks this.
STP_API void stp_context_destroy(stp_context* context);

/// Bytes allocated now and at the peak, as counted by the library.
STP_API uint64_t stp_context_live_bytes(const stp_context* context);
STP_API uint64_t stp_context_peak_bytes(const stp_context* context);

/// Number of worker threads, including the caller's; at least 1.
STP_API uint32_t stp_context_thread_count(const stp_context* context);

#ifdef __cplusplus
}
#endif
