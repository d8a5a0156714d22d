// SPDX-License-Identifier: MIT
#define _DEFAULT_SOURCE // _SC_PHYS_PAGES
#include "base/core/context.h"

#include "base/core/atomic_limits.h"
#include "base/core/context_internal.h"
#include "base/core/desc.h"
#include "base/core/printable.h"
#include "base/core/processor.h"

#include <stipple/version.h>

#include <assert.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#if defined(__GLIBC__)
#include <malloc.h>
#endif

#define ALIGNMENT ((size_t)64)
// Blocks of at least this size bypass malloc. Sanitizers track malloc, so they find more errors
// without this.
#if defined(STP_SANITIZED)
#define LARGE_SIZE SIZE_MAX
#else
#define LARGE_SIZE ((size_t)256 << 10)
#endif
#define MAX_KEPT (UINT64_C(160) << 20)

const char* stp_result_string(stp_result result)
{
    switch (result) {
#define X(name, text)                                                                              \
    case STP_##name:                                                                               \
        return text;
        STP_RESULTS(X)
#undef X
    }
    return "unknown result";
}

// Limit on kept freed blocks: allocated and kept bytes together stay within the memory limit.
static size_t max_kept(const stp_context* context, size_t freed)
{
    uint64_t limit = context->desc.memory_limit_bytes;
    assert(atomic_load(&context->live_bytes) >= freed && "more is freed than allocated");
    uint64_t live = atomic_load(&context->live_bytes) - freed;
    uint64_t left = limit == 0 ? MAX_KEPT : limit > live ? limit - live : 0;
    return (size_t)(left < MAX_KEPT ? left : MAX_KEPT);
}

static void* default_alloc(size_t size, size_t alignment, void* user)
{
    stp_context* context = user;
    if (size < LARGE_SIZE) {
        return aligned_alloc(alignment, (size + alignment - 1) & ~(alignment - 1));
    }
    return stp_large_alloc(&context->large_blocks, size, max_kept(context, 0));
}

static void default_free(void* memory, size_t size, void* user)
{
    stp_context* context = user;
    if (size < LARGE_SIZE) {
        free(memory);
    } else {
        stp_large_free(&context->large_blocks, memory, size, max_kept(context, size));
    }
}

stp_result stp_context_create(stp_context** context, const stp_context_desc* given)
{
    stp_context_desc desc;
    if (context == NULL) {
        return STP_ERROR_ARGUMENT;
    }
    *context = NULL;
    if (!stp_desc_read(&desc, sizeof(desc), sizeof(desc), given)) {
        return STP_ERROR_UNSUPPORTED;
    }
    stp_allocator allocator = desc.allocator;
    if ((allocator.alloc == NULL) != (allocator.free == NULL)) {
        return STP_ERROR_ARGUMENT;
    }
    bool is_default = allocator.alloc == NULL;
    if (is_default) {
        allocator = (stp_allocator){.alloc = default_alloc, .free = default_free};
    }
    stp_context* made = allocator.alloc(sizeof(*made), ALIGNMENT, allocator.user);
    if (made == NULL) {
        return STP_ERROR_OUT_OF_MEMORY;
    }
    *made = (stp_context){.allocator = allocator, .desc = desc, .overall = -1.0};
    made->allocator.user = is_default ? made : allocator.user;
    stp_large_blocks_open(&made->large_blocks);
    atomic_init(&made->live_bytes, 0);
    atomic_init(&made->peak_bytes, 0);
    atomic_init(&made->needed_bytes, 0);
    atomic_init(&made->refused_bytes, 0);
    atomic_init(&made->held, STP_HELD_NOT);
    uint32_t threads = desc.thread_count != 0 ? desc.thread_count : stp_processor_count();
    stp_result result = stp_jobs_create(&made->jobs, made, threads);
    if (result != STP_OK) {
        stp_large_blocks_close(&made->large_blocks);
        allocator.free(made, sizeof(*made), allocator.user);
        return result;
    }
    *context = made;
    return STP_OK;
}

void stp_context_destroy(stp_context* context)
{
    if (context != NULL) {
        assert(context->loop == NULL && "destroyed inside a loop");
        stp_jobs_destroy(context->jobs, context);
        assert(atomic_load(&context->live_bytes) == 0 && "an object outlives its context");
        stp_large_blocks_close(&context->large_blocks);
        stp_allocator allocator = context->allocator;
        allocator.free(context, sizeof(*context), allocator.user);
    }
}

uint64_t stp_context_live_bytes(const stp_context* context)
{
    return context != NULL ? atomic_load(&context->live_bytes) : 0;
}

uint64_t stp_context_peak_bytes(const stp_context* context)
{
    return context != NULL ? atomic_load(&context->peak_bytes) : 0;
}

uint64_t stp_memory_limit(const stp_context* context)
{
    return context->desc.memory_limit_bytes;
}

uint32_t stp_context_thread_count(const stp_context* context)
{
    return context != NULL ? stp_jobs_thread_count(context->jobs) : 0;
}

// Adds to the count of live bytes; false if that would exceed the limit.
static bool count_bytes(stp_context* context, uint64_t size)
{
    uint64_t live = atomic_fetch_add(&context->live_bytes, size) + size;
    if (context->desc.memory_limit_bytes != 0 && live > context->desc.memory_limit_bytes) {
        atomic_fetch_sub(&context->live_bytes, size);
        stp_atomic_max(&context->refused_bytes, live);
        return false;
    }
    stp_atomic_max(&context->peak_bytes, live);
    return true;
}

bool stp_reserve(stp_context* context, uint64_t size)
{
    return size <= INT64_MAX && count_bytes(context, size);
}

void stp_release(stp_context* context, uint64_t size)
{
    uint64_t before = atomic_fetch_sub(&context->live_bytes, size);
    assert(before >= size && "more is released than reserved");
    (void)before;
}

uint64_t stp_usable_memory(uint64_t limit)
{
    long pages = sysconf(_SC_PHYS_PAGES), page_size = sysconf(_SC_PAGE_SIZE);
    uint64_t all = pages > 0 && page_size > 0 ? (uint64_t)pages * (uint64_t)page_size : 0;
    return limit != 0 ? limit : all / 4 * 3;
}

void stp_trim_heap(void)
{
#if defined(__GLIBC__)
    (void)malloc_trim(0);
#endif
}

void stp_context_expect_bytes(stp_context* context, uint64_t bytes)
{
    atomic_store(&context->needed_bytes, bytes);
}

// Each block is preceded by one line of 64 bytes that holds its size.
void* stp_alloc(stp_context* context, size_t size)
{
    if (size > SIZE_MAX / 2) {
        return NULL;
    }
    size_t whole = size + ALIGNMENT;
    if (!count_bytes(context, whole)) {
        return NULL;
    }
    unsigned char* block = context->allocator.alloc(whole, ALIGNMENT, context->allocator.user);
    if (block == NULL) {
        atomic_fetch_sub(&context->live_bytes, whole);
        return NULL;
    }
    assert((uintptr_t)block % ALIGNMENT == 0 && "the allocator keeps the alignment");
    memcpy(block, &whole, sizeof(whole));
    return block + ALIGNMENT;
}

void* stp_alloc_array(stp_context* context, size_t count, size_t size)
{
    return size != 0 && count > SIZE_MAX / size ? NULL : stp_alloc(context, count * size);
}

void* stp_alloc_zeroed(stp_context* context, size_t count, size_t size)
{
    void* memory = stp_alloc_array(context, count, size);
    return memory != NULL ? memset(memory, 0, count * size) : NULL;
}

void stp_free(stp_context* context, void* memory)
{
    if (memory != NULL) {
        unsigned char* block = (unsigned char*)memory - ALIGNMENT;
        size_t whole;
        memcpy(&whole, block, sizeof(whole));
        assert(whole >= ALIGNMENT && whole <= atomic_load(&context->live_bytes) &&
               "not a block of this context, or its size was overwritten");
        context->allocator.free(block, whole, context->allocator.user);
        atomic_fetch_sub(&context->live_bytes, whole);
    }
}

bool stp_make_room(stp_context* context, void* array_address, size_t* capacity, size_t needed,
                   size_t size)
{
    void* array;
    memcpy(&array, array_address, sizeof(array)); // whatever it points to
    if (array != NULL && needed <= *capacity) {
        return true;
    }
    assert(size > 0);
    size_t grown = *capacity + *capacity / 2;
    grown = grown < needed ? needed : grown;
    grown = grown < 16 ? 16 : grown;
    void* moved = stp_alloc_array(context, grown, size);
    if (moved == NULL) {
        return false;
    }
    if (array != NULL) {
        memcpy(moved, array, *capacity * size);
        stp_free(context, array);
    }
    memcpy(array_address, &moved, sizeof(moved));
    *capacity = grown;
    return true;
}

static void log_message(stp_context* context, stp_log_level level, const char* format, va_list list)
    __attribute__((format(printf, 3, 0)));

static void log_message(stp_context* context, stp_log_level level, const char* format, va_list list)
{
    if (context->desc.log == NULL) {
        return;
    }
    char message[STP_MESSAGE_SIZE], shown[STP_MESSAGE_SIZE];
    vsnprintf(message, sizeof(message), format, list);
    stp_make_printable(message, shown, sizeof(shown)); // messages contain names from files
    if (level == STP_LOG_ERROR && atomic_load(&context->held) != STP_HELD_NOT) {
        int next = STP_HELD_NEXT;
        if (atomic_compare_exchange_strong(&context->held, &next, STP_HELD_ONE)) {
            memcpy(context->held_error, shown, sizeof(shown));
        }
        return;
    }
    context->desc.log(level, shown, context->desc.log_user);
}

void stp_hold_errors(stp_context* context)
{
    atomic_store(&context->held, STP_HELD_NEXT);
}

void stp_release_errors(stp_context* context, bool log)
{
    int held = atomic_exchange(&context->held, STP_HELD_NOT);
    if (log && held == STP_HELD_ONE && context->desc.log != NULL) {
        context->desc.log(STP_LOG_ERROR, context->held_error, context->desc.log_user);
    }
}

stp_result stp_fail(stp_context* context, stp_result result, const char* format, ...)
{
    va_list list;
    va_start(list, format);
    log_message(context, STP_LOG_ERROR, format, list);
    va_end(list);
    return result;
}

stp_result stp_fail_memory(stp_context* context)
{
    uint64_t limit = context->desc.memory_limit_bytes;
    if (limit != 0) {
        uint64_t needed = atomic_load(&context->needed_bytes);
        if (needed > limit) {
            return stp_fail(
                context, STP_ERROR_OUT_OF_MEMORY,
                "out of memory: the limit of %llu bytes (memory_limit_bytes) is used up; "
                "this needs about %llu MB",
                (unsigned long long)limit, (unsigned long long)(needed / 1000000 + 1));
        }
        uint64_t refused = atomic_load(&context->refused_bytes);
        if (refused == 0) { // the system itself is out of memory
            return stp_fail(context, STP_ERROR_OUT_OF_MEMORY, "out of memory");
        }
        return stp_fail(
            context, STP_ERROR_OUT_OF_MEMORY,
            "out of memory: the limit of %llu bytes (memory_limit_bytes) is used up; at "
            "least %llu MB are needed",
            (unsigned long long)limit, (unsigned long long)(refused / 1000000 + 1));
    }
    return stp_fail(context, STP_ERROR_OUT_OF_MEMORY, "out of memory");
}

void stp_warn(stp_context* context, const char* format, ...)
{
    va_list list;
    va_start(list, format);
    log_message(context, STP_LOG_WARNING, format, list);
    va_end(list);
}

void stp_notice(stp_context* context, const char* format, ...)
{
    va_list list;
    va_start(list, format);
    log_message(context, STP_LOG_NOTICE, format, list);
    va_end(list);
}

uint32_t stp_version(void)
{
    return STP_VERSION_MAJOR * 10000u + STP_VERSION_MINOR * 100u + STP_VERSION_PATCH;
}
