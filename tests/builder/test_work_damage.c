// SPDX-License-Identifier: MIT
// The work folder after damage: kills, full disks, flipped bits, other versions.
#include "work_helpers.h"

#include "base/io/bytes.h"
#include "builder/work_segment.h"

#include <signal.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <time.h>

enum { FEW = 7, MAX_BYTES = 4096 };

// The single segment of results 0..FEW-1, and where each result ends in it.
static size_t make_segment(stp_context* context, const work_place* place,
                           unsigned char bytes[MAX_BYTES], size_t ends[FEW])
{
    stp_work* work = open_work(context, place);
    bool stored = work != NULL;
    size_t used = STP_WORK_HEAD_SIZE;
    for (uint32_t i = 0; stored && i < FEW; ++i) {
        stored = store_work(work, i, NULL) == STP_OK;
        ends[i] = used + STP_WORK_HEAD_SIZE + work_size(i);
        used += stp_work_record_bytes(work_size(i));
    }
    stp_work_close(work, false);
    return stored ? read_segment(place, 0, bytes, MAX_BYTES) : 0;
}

// Stores what is missing. @return 0 if all results are right now and were right or missing before
static int mend(stp_context* context, const work_place* place, unsigned* missing,
                stp_work_report* report)
{
    int bad = 0;
    *missing = 0;
    for (int round = 0; round < 2; ++round) {
        stp_work* work = open_work(context, place);
        if (work == NULL) {
            return 1;
        }
        for (uint32_t i = 0; i < FEW; ++i) {
            work_found found = find_work(work, i);
            bad += found == WORK_WRONG || (found == WORK_NONE && round == 1);
            if (found == WORK_NONE) {
                *missing |= 1U << i;
                bad += store_work(work, i, NULL) != STP_OK;
            }
        }
        if (round == 0) {
            stp_work_get_report(work, report);
        }
        stp_work_close(work, round == 1);
    }
    return bad;
}

void test_work_survives_truncation_at_every_byte(test_state* test)
{
    work_place place;
    test_log log = {0};
    stp_context* context = test_context(NULL, 1, &log);
    CHECK(context != NULL && make_work_place(&place));
    unsigned char bytes[MAX_BYTES];
    size_t ends[FEW];
    size_t size = make_segment(context, &place, bytes, ends);
    CHECK_EQUAL(ends[FEW - 1], size);
    for (size_t cut = 0; cut <= size; ++cut) {
        CHECK(write_segment(&place, 0, bytes, cut));
        unsigned missing, expected = 0;
        stp_work_report report;
        CHECK_EQUAL(0, mend(context, &place, &missing, &report));
        for (uint32_t i = 0; i < FEW; ++i) {
            expected |= cut < ends[i] ? 1U << i : 0;
        }
        CHECK_EQUAL(expected, missing);
        CHECK_EQUAL(0, report.damaged);
    }
    CHECK_EQUAL(0, log.errors);
    CHECK(remove_work_place(&place));
    stp_context_destroy(context);
}

void test_work_never_gives_flipped_bits(test_state* test)
{
    work_place place;
    test_log log = {0};
    stp_context* context = test_context(NULL, 1, &log);
    CHECK(context != NULL && make_work_place(&place));
    unsigned char bytes[MAX_BYTES];
    size_t ends[FEW];
    size_t size = make_segment(context, &place, bytes, ends);
    CHECK(size > 0);
    char path[128];
    snprintf(path, sizeof(path), "%s/segment-000000", place.folder);
    uint64_t damaged = 0;
    for (size_t at = 0; at < size; ++at) {
        bytes[at] ^= (unsigned char)(1U << at % 8);
        CHECK(write_segment(&place, 0, bytes, size));
        unsigned missing;
        stp_work_report report;
        CHECK_EQUAL(0, mend(context, &place, &missing, &report));
        damaged += report.damaged;
        CHECK(report.damaged <= 1);
        bytes[at] ^= (unsigned char)(1U << at % 8);
        if (at < 8) { // a file with another magic number is not ours, and stays
            CHECK(access(path, F_OK) == 0 && unlink(path) == 0 && rmdir(place.folder) == 0);
        }
    }
    CHECK_EQUAL(work_size(1) + work_size(2) + work_size(3) + work_size(4) + work_size(5) +
                    work_size(6),
                damaged); // each flipped byte of a result
    CHECK_EQUAL(0, log.errors);
    CHECK(remove_work_place(&place));
    stp_context_destroy(context);
}

void test_work_of_another_version_is_emptied(test_state* test)
{
    work_place place;
    stp_context* context = test_context(NULL, 1, NULL);
    CHECK(context != NULL && make_work_place(&place));
    unsigned char bytes[MAX_BYTES];
    size_t ends[FEW];
    for (uint32_t version = 0; version < 4; ++version) {
        size_t size = make_segment(context, &place, bytes, ends);
        CHECK(size > 0);
        stp_write_u32(bytes + 8, version);
        stp_work_seal_head(bytes);
        CHECK(write_segment(&place, 0, bytes, size));
        stp_work* work = open_work(context, &place);
        CHECK(work != NULL);
        for (uint32_t i = 0; i < FEW; ++i) {
            CHECK_EQUAL(version == STP_WORK_VERSION ? WORK_RIGHT : WORK_NONE, find_work(work, i));
        }
        CHECK_EQUAL(version == STP_WORK_VERSION ? size : 0,
                    read_segment(&place, 0, bytes, sizeof(bytes)));
        stp_work_close(work, true);
    }
    CHECK(remove_work_place(&place));
    stp_context_destroy(context);
}

void test_work_refuses_sizes_that_lie(test_state* test)
{
    static const uint64_t sizes[] = {
        5000, UINT64_MAX, UINT64_MAX - 63, UINT64_MAX - 64, (uint64_t)1 << 46, (uint64_t)1 << 63};
    work_place place;
    stp_context* context = test_context(NULL, 1, NULL);
    CHECK(context != NULL && make_work_place(&place));
    unsigned char bytes[MAX_BYTES];
    size_t ends[FEW];
    size_t size = make_segment(context, &place, bytes, ends);
    unsigned char* head = bytes + STP_WORK_HEAD_SIZE;
    for (size_t i = 0; i < sizeof(sizes) / sizeof(sizes[0]); ++i) {
        stp_write_u64(head + 24, sizes[i]);
        stp_work_seal_head(head);
        CHECK(write_segment(&place, 0, bytes, size));
        unsigned missing;
        stp_work_report report;
        CHECK_EQUAL(0, mend(context, &place, &missing, &report));
        CHECK_EQUAL((1U << FEW) - 1, missing);
    }
    CHECK(remove_work_place(&place));
    stp_context_destroy(context);
}

typedef struct writers {
    stp_work* work;
    uint32_t first;
} writers;

static void write_some(size_t begin, size_t end, uint32_t worker, void* user)
{
    (void)worker;
    writers* w = user;
    for (size_t i = begin; i < end; ++i) {
        (void)!store_work(w->work, w->first + (uint32_t)i, NULL);
    }
}

// Two jobs store results endlessly, until the process is killed.
static void store_for_ever(const work_place* place, int ready)
{
    stp_context* context = test_context(NULL, 2, NULL);
    writers w = {.work = context != NULL ? open_work(context, place) : NULL};
    if (w.work != NULL && write(ready, "r", 1) == 1) {
        for (;; w.first += 64) {
            stp_parallel_for(context, 64, 1, write_some, &w);
        }
    }
}

void test_work_survives_kills(test_state* test)
{
    work_place place;
    stp_context* context = test_context(NULL, 1, NULL);
    CHECK(context != NULL && make_work_place(&place));
    uint32_t minimum = 0;
    for (int round = 0; round < 8; ++round) {
        int ends[2];
        CHECK(pipe(ends) == 0);
        pid_t child = fork();
        CHECK(child >= 0);
        if (child == 0) {
            store_for_ever(&place, ends[1]);
            _exit(1);
        }
        close(ends[1]);
        char letter;
        CHECK(read(ends[0], &letter, 1) == 1);
        close(ends[0]);
        struct timespec pause = {.tv_nsec = 1000L * stp_rng_below(7, (uint64_t)round, 20000)};
        CHECK_EQUAL(0, nanosleep(&pause, NULL));
        CHECK(kill(child, SIGKILL) == 0 && waitpid(child, NULL, 0) == child);
        stp_work* work = open_work(context, &place);
        CHECK(work != NULL);
        uint32_t there = 0;
        for (uint32_t i = 0; i < 20000; ++i) {
            work_found found = find_work(work, i);
            CHECK(found != WORK_WRONG);
            there += found == WORK_RIGHT;
        }
        CHECK(there >= minimum); // no stored result is lost
        minimum = there;
        stp_work_close(work, round == 7);
    }
    CHECK(minimum > 0);
    CHECK(remove_work_place(&place));
    stp_context_destroy(context);
}

// Runs in a child process with limited file sizes, as on a full disk. @return 0 if it behaved as
// specified
static int fill_disk(const work_place* place)
{
    signal(SIGXFSZ, SIG_IGN);
    struct rlimit limit = {.rlim_cur = 3000, .rlim_max = 3000};
    test_log log = {0};
    stp_context* context = test_context(NULL, 2, &log);
    stp_work* work = context != NULL ? open_work(context, place) : NULL;
    if (work == NULL || setrlimit(RLIMIT_FSIZE, &limit) != 0) {
        return 2;
    }
    writers w = {.work = work};
    stp_parallel_for(context, 100, 1, write_some, &w);
    if (log.errors != 1 || strstr(log.text, place->folder) != log.text) {
        return 3; // reported once, by the first job that notices it
    }
    uint32_t there = 0;
    for (uint32_t i = 0; i < 100; ++i) {
        work_found found = find_work(work, i);
        if (found == WORK_WRONG) {
            return 4;
        }
        there += found == WORK_RIGHT;
    }
    stp_work_close(work, false);
    stp_context_destroy(context);
    return there > 3 && there < 50 ? 0 : 5;
}

void test_work_on_a_full_disk_keeps_what_it_has(test_state* test)
{
    work_place place;
    stp_context* context = test_context(NULL, 1, NULL);
    CHECK(context != NULL && make_work_place(&place));
    pid_t child = fork();
    CHECK(child >= 0);
    if (child == 0) {
        _exit(fill_disk(&place));
    }
    int status = 0;
    CHECK(waitpid(child, &status, 0) == child && WIFEXITED(status));
    CHECK_EQUAL(0, WEXITSTATUS(status));
    stp_work* work = open_work(context, &place);
    CHECK(work != NULL);
    uint32_t there = 0;
    for (uint32_t i = 0; i < 100; ++i) {
        work_found found = find_work(work, i);
        CHECK(found != WORK_WRONG);
        there += found == WORK_RIGHT;
        CHECK_EQUAL(STP_OK, store_work(work, i, NULL)); // the disk has room again
    }
    CHECK(there > 3);
    stp_work_close(work, true);
    CHECK(remove_work_place(&place));
    stp_context_destroy(context);
}

void test_work_survives_failing_allocator(test_state* test)
{
    bool whole = false;
    for (int n = 0; !whole && n < 60; ++n) {
        work_place place;
        CHECK(make_work_place(&place));
        test_heap heap = TEST_HEAP(n);
        test_log log = {0};
        stp_context* context = test_context(&heap, 1, &log);
        stp_work* work = context != NULL ? open_work(context, &place) : NULL;
        whole = work != NULL;
        for (uint32_t i = 0; work != NULL && i < 400; ++i) { // enough for all arrays to grow
            stp_result result = store_work(work, i, NULL);
            CHECK(result == STP_OK || result == STP_ERROR_OUT_OF_MEMORY);
            whole = whole && result == STP_OK;
            CHECK_EQUAL(result == STP_OK ? WORK_RIGHT : WORK_NONE, find_work(work, i));
        }
        CHECK(context == NULL || log.errors == !whole);
        stp_work_close(work, false);
        stp_context_destroy(context);
        CHECK_EQUAL(0, heap.live_bytes);
        // stored results are present, and the directory opens under the same conditions
        test_heap again = TEST_HEAP(n);
        context = test_context(&again, 1, NULL);
        stp_work_close(context != NULL ? open_work(context, &place) : NULL, false);
        stp_context_destroy(context);
        CHECK_EQUAL(0, again.live_bytes);
        context = test_context(NULL, 1, NULL);
        work = context != NULL ? open_work(context, &place) : NULL;
        CHECK(work != NULL);
        stp_work_close(work, true);
        stp_context_destroy(context);
        CHECK(remove_work_place(&place));
    }
    CHECK(whole);
}
