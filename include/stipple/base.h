// SPDX-License-Identifier: MIT
//
// What every other header rests on: results, memory hooks, messages and the context.
//
// A *context* carries memory, messages and worker threads. Everything the library makes belongs to one
// context and must be destroyed before it. Nothing is global: two contexts never meet. A function that
// takes a context may be called from any one thread at a time per context, unless its text says more.
#pragma once

#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

#define STP_API __attribute__((visibility("default")))
#define STP_MUST_USE __attribute__((warn_unused_result))

/// Every result a function of this library can return, and its text. Add at the end only.
#define STP_RESULTS(X)                                                                             \
    X(OK, "ok")                                                                                    \
    X(ERROR_OUT_OF_MEMORY, "out of memory")                                                        \
    X(ERROR_IO, "file could not be read or written")                                               \
    X(ERROR_TRUNCATED, "file ends before its content does")                                        \
    X(ERROR_FORMAT, "file is not what its header says")                                            \
    X(ERROR_VERSION, "file is of a newer format version")                                          \
    X(ERROR_CANCELLED, "stopped by the caller")                                                    \
    X(ERROR_UNSUPPORTED, "file needs a feature this reader does not have")                         \
    X(ERROR_LIMIT, "a limit was exceeded")                                                         \
    X(ERROR_ARGUMENT, "an option's value is out of range")                                         \
    X(ERROR_BUSY, "somebody else is at work there")

typedef enum stp_result {
#define X(name, text) STP_##name,
    STP_RESULTS(X)
#undef X
} stp_result;

/// The text of a result; never NULL.
STP_API const char* stp_result_string(stp_result result);

/// Memory hooks. All zero means the C library's. Called from several threads at once; `alignment` is a
/// power of two, at most 64.
typedef struct stp_allocator {
    void* (*alloc)(size_t size, size_t alignment, void* user);
    void (*free)(void* memory, size_t size, void* user);
    void* user;
} stp_allocator;

typedef enum stp_log_level {
    STP_LOG_ERROR,   ///< the call that logs it fails; exactly one such message per failed call
    STP_LOG_WARNING, ///< something in the input was ignored or repaired
    STP_LOG_NOTICE,  ///< something worth knowing: an approximation, a default taken
} stp_log_level;

/// How far a long call is. What is counted has a unit; where nothing is, `total` is 0 and `unit` NULL.
typedef struct stp_progress_report {
    const char* stage;    ///< static text: "import", "capture", ...
    double fraction;      ///< of the stage, 0..1
    double overall;       ///< of the whole call, 0..1, never less than before; negative: not known
    uint64_t done, total; ///< of the stage; `done` is 0..`total`
    const char* unit;     ///< static text: "triangles", "nodes", ...
} stp_progress_report;

/// How to make a context. Zero means the default of each field.
typedef struct stp_context_desc {
    size_t struct_size; ///< sizeof(stp_context_desc), or 0: its first version
    stp_allocator allocator;
    /// Receives each message, one sentence without a line end. May be called from several threads at
    /// once and must not call the library. Default: messages are dropped.
    void (*log)(stp_log_level level, const char* message, void* user);
    void* log_user;
    /// Receives the progress of long work, often: a receiver that shows it should leave most reports out. Called
    /// only on the thread that made the call. Return non-zero to stop the work with STP_ERROR_CANCELLED.
    int (*progress)(const stp_progress_report* report, void* user);
    void* progress_user;
    uint32_t thread_count; ///< threads that work, the caller's included; default all processors
    uint64_t memory_limit_bytes; ///< an allocation beyond it fails; default no limit
} stp_context_desc;

typedef struct stp_context stp_context;

/// Starts the worker threads. `desc` may be NULL: all zero. @return STP_OK, STP_ERROR_OUT_OF_MEMORY, STP_ERROR_LIMIT where
/// threads cannot be started, STP_ERROR_ARGUMENT where one hook of the allocator is set without the other, or
/// STP_ERROR_UNSUPPORTED where `desc` sets fields that this library does not know
STP_API STP_MUST_USE stp_result stp_context_create(stp_context** context,
                                                   const stp_context_desc* desc);

/// Ends the worker threads. All objects made with the context must be gone: else this is a fault of the caller, which an
/// assertion reports.
STP_API void stp_context_destroy(stp_context* context);

/// Bytes allocated now, and the most there ever were, as the library counts them.
STP_API uint64_t stp_context_live_bytes(const stp_context* context);
STP_API uint64_t stp_context_peak_bytes(const stp_context* context);

/// Threads that work, the caller's included; at least 1.
STP_API uint32_t stp_context_thread_count(const stp_context* context);

#ifdef __cplusplus
}
#endif
