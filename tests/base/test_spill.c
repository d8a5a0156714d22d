// SPDX-License-Identifier: MIT
#define _XOPEN_SOURCE 700 // mkdtemp
#include "tests.h"

#include "base/core/context.h"
#include "base/io/hash.h"
#include "base/io/spill.h"

#include <dirent.h>
#include <signal.h>
#include <string.h>
#include <sys/resource.h>
#include <unistd.h>

static bool make_folder(char* path, size_t size)
{
    const char* base = getenv("TMPDIR");
    snprintf(path, size, "%s/stp_spill_XXXXXX", base != NULL ? base : "/tmp");
    return mkdtemp(path) != NULL;
}

static int count_entries(const char* path)
{
    DIR* folder = opendir(path);
    int count = 0;
    while (folder != NULL && readdir(folder) != NULL) {
        count += 1;
    }
    if (folder != NULL) {
        closedir(folder);
    }
    return count - 2; // itself and its parent
}

void test_spill_gives_zeroed_aligned_memory(test_state* test)
{
    char folder[256];
    stp_context* context = test_context(NULL, 1, NULL);
    stp_spill* spill = NULL;
    enum { COUNT = 300 };
    unsigned char* blocks[COUNT];
    CHECK(context != NULL && make_folder(folder, sizeof(folder)));
    CHECK_EQUAL(STP_OK, stp_spill_create(context, folder, &spill));
    CHECK_EQUAL(0, count_entries(folder)); // anonymous: nothing is left, however the process ends
    uint64_t live = stp_context_live_bytes(context);
    for (size_t i = 0; i < COUNT;
         ++i) { // sizes from 0 to 6 MB: small ones share chunks, large ones have their own
        size_t size = i % 50 == 49 ? 20000 * i : i * i;
        blocks[i] = stp_spill_alloc(spill, size);
        CHECK(blocks[i] != NULL && (uintptr_t)blocks[i] % 64 == 0);
        for (size_t k = 0; k < size; k += 1 + size / 64) {
            CHECK_EQUAL(0, blocks[i][k]);
        }
        memset(blocks[i], (int)(i % 256), size);
    }
    unsigned char* small = stp_spill_alloc(spill, 1);
    unsigned char* next = stp_spill_alloc(spill, 100);
    CHECK(small != NULL && next == small + 64); // no room is wasted between blocks
    CHECK(stp_spill_alloc(spill, 1) == next + 128);
    CHECK_EQUAL(live, stp_context_live_bytes(context)); // not counted as the context's memory
    for (size_t i = 0; i < COUNT; ++i) {
        size_t size = i % 50 == 49 ? 20000 * i : i * i;
        CHECK(size == 0 || (blocks[i][0] == i % 256 && blocks[i][size - 1] == i % 256));
    }
    stp_spill_destroy(spill);
    stp_context_destroy(context);
    CHECK_EQUAL(0, rmdir(folder));
}

typedef struct spill_work {
    stp_spill* spill;
    unsigned char* blocks[256];
} spill_work;

static void fill_blocks(size_t begin, size_t end, uint32_t worker, void* user)
{
    (void)worker;
    spill_work* work = user;
    for (size_t i = begin; i < end; ++i) {
        work->blocks[i] = stp_spill_alloc(work->spill, 100 * i + 1);
        if (work->blocks[i] != NULL) {
            memset(work->blocks[i], (int)i, 100 * i + 1);
        }
    }
}

void test_spill_serves_several_threads(test_state* test)
{
    char folder[256];
    stp_context* context = test_context(NULL, 4, NULL);
    spill_work work = {0};
    CHECK(context != NULL && make_folder(folder, sizeof(folder)));
    CHECK_EQUAL(STP_OK, stp_spill_create(context, folder, &work.spill));
    stp_parallel_for(context, 256, 1, fill_blocks, &work);
    for (size_t i = 0; i < 256; ++i) {
        CHECK(work.blocks[i] != NULL);
        CHECK(work.blocks[i][0] == i && work.blocks[i][100 * i] == i);
    }
    stp_spill_destroy(work.spill);
    stp_context_destroy(context);
    CHECK_EQUAL(0, rmdir(folder));
}

void test_spill_names_the_folder_that_fails(test_state* test)
{
    test_log log = {0};
    stp_context* context = test_context(NULL, 1, &log);
    stp_spill* spill = NULL;
    CHECK(context != NULL);
    CHECK_EQUAL(STP_ERROR_IO, stp_spill_create(context, "/nonexistent/folder", &spill));
    CHECK_EQUAL(1, log.errors);
    CHECK(strstr(log.text, "/nonexistent/folder") != NULL);
    stp_context_destroy(context);
    for (int n = 0; n < 3; ++n) {
        test_heap heap = TEST_HEAP(-1);
        context = test_context(&heap, 1, &log);
        CHECK(context != NULL);
        heap.fail_at = heap.count + n;
        CHECK_EQUAL(STP_ERROR_OUT_OF_MEMORY, stp_spill_create(context, ".", &spill));
        stp_context_destroy(context);
        CHECK_EQUAL(0, heap.live_bytes);
    }
}

// A file size limit simulates a full disk.
void test_spill_without_room_is_an_error(test_state* test)
{
    char folder[256];
    test_log log = {0};
    stp_context* context = test_context(NULL, 1, &log);
    stp_spill* spill = NULL;
    struct rlimit old, limit;
    CHECK(context != NULL && make_folder(folder, sizeof(folder)));
    CHECK(getrlimit(RLIMIT_FSIZE, &old) == 0);
    CHECK_EQUAL(STP_OK, stp_spill_create(context, folder, &spill));
    unsigned char* before = stp_spill_alloc(spill, 1000);
    void (*handler)(int) = signal(SIGXFSZ, SIG_IGN);
    limit = (struct rlimit){.rlim_cur = 32u << 20, .rlim_max = old.rlim_max};
    CHECK(setrlimit(RLIMIT_FSIZE, &limit) == 0);
    void* fits = stp_spill_alloc(spill, (size_t)16 << 20);
    void* too_much = stp_spill_alloc(spill, (size_t)64 << 20);
    int errors = log.errors;
    void* absurd = stp_spill_alloc(spill, SIZE_MAX);
    void* small = stp_spill_alloc(spill, 5000);
    CHECK(setrlimit(RLIMIT_FSIZE, &old) == 0);
    (void)signal(SIGXFSZ, handler);
    CHECK(before != NULL && fits != NULL && too_much == NULL && absurd == NULL && small != NULL);
    CHECK_EQUAL(1, errors);
    CHECK_EQUAL(2, log.errors);
    CHECK(strstr(log.text, folder) != NULL);
    memset(fits, 1, (size_t)16 << 20);
    stp_spill_destroy(spill);
    stp_context_destroy(context);
    CHECK_EQUAL(0, rmdir(folder));
}

// Written bytes stay unchanged at any offset, and their hash equals that of the same bytes in
// memory.
void test_spill_forgets_pages_alone(test_state* test)
{
    enum { SIZE = (17 << 20) + 12345 }; // more than one step
    stp_context* context = test_context(NULL, 1, NULL);
    stp_spill* spill = NULL;
    CHECK(context != NULL && stp_spill_create(context, "/tmp", &spill) == STP_OK);
    unsigned char* bytes = stp_spill_alloc(spill, SIZE);
    CHECK(bytes != NULL);
    for (size_t i = 0; i < SIZE; ++i) {
        bytes[i] = (unsigned char)(i * i >> 3);
    }
    stp_hash chain = {3, 4};
    for (size_t begin = 0; begin < 10000; begin += 4097) {
        stp_spill_forget(bytes + begin, SIZE - 2 * begin);
        stp_spill_forget(bytes + begin, begin);
        stp_hash all = stp_hash_bytes(chain, bytes + begin, SIZE - begin);
        CHECK(stp_hash_equal(all,
                             stp_hash_steps(chain, bytes + begin, SIZE - begin, stp_spill_forget)));
    }
    stp_hash none = stp_hash_bytes(chain, bytes, 0);
    CHECK(stp_hash_equal(none, stp_hash_steps(chain, bytes, 0, stp_spill_forget)));
    for (size_t i = 0; i < SIZE; ++i) {
        CHECK(bytes[i] == (unsigned char)(i * i >> 3));
    }
    stp_spill_destroy(spill);
    stp_context_destroy(context);
}

// Overwrites part of the stack frames of earlier calls.
static __attribute__((noinline)) void scribble(size_t begin, size_t size)
{
    unsigned char frame[4096];
    volatile unsigned char* bytes = frame;
    for (size_t i = begin; i < begin + size; ++i) {
        bytes[i] = (unsigned char)(7 * i);
    }
}

static void ignore(const void* bytes, size_t size)
{
    (void)bytes, (void)size;
}

// Stale stack contents of an earlier call with the same chain have no effect.
void test_hash_in_steps_does_not_depend_on_the_stack(test_state* test)
{
    static unsigned char bytes[1000];
    const stp_hash chain = {3, 4}, all = stp_hash_bytes(chain, bytes, sizeof(bytes));
    for (size_t begin = 0; begin + 64 <= 4096; begin += 32) {
        bool before = stp_hash_equal(all, stp_hash_steps(chain, bytes, sizeof(bytes), ignore));
        scribble(begin, 64);
        bool after = stp_hash_equal(all, stp_hash_steps(chain, bytes, sizeof(bytes), ignore));
        CHECK(before && after);
    }
}
