// SPDX-License-Identifier: MIT
#include "work_helpers.h"

#include <stdatomic.h>

void test_work_keeps_results_for_the_next_build(test_state* test)
{
    enum { COUNT = 100 };
    work_place place;
    stp_context* context = test_context(NULL, 1, NULL);
    CHECK(context != NULL && make_work_place(&place));
    uint64_t bytes = 0;
    for (int round = 0; round < 3; ++round) {
        stp_work* work = open_work(context, &place);
        CHECK(work != NULL);
        for (uint32_t i = 0; i < COUNT; ++i) {
            CHECK_EQUAL(round == 0 ? WORK_NONE : WORK_RIGHT, find_work(work, i));
            const void* stored = NULL;
            CHECK_EQUAL(STP_OK, store_work(work, i, &stored)); // an existing result is returned
            CHECK(is_work(stored, work_size(i), i));
            CHECK_EQUAL(WORK_RIGHT, find_work(work, i));
            bytes += round == 0 ? work_size(i) : 0;
        }
        CHECK_EQUAL(WORK_NONE, find_work(work, COUNT));
        stp_work_report report;
        stp_work_get_report(work, &report);
        CHECK_EQUAL(round == 0 ? COUNT : 0, report.stored);
        CHECK_EQUAL(round == 0 ? bytes : 0, report.stored_bytes);
        CHECK_EQUAL(round == 0 ? 0 : COUNT, report.found);
        CHECK_EQUAL(round == 0 ? 0 : bytes, report.found_bytes);
        CHECK_EQUAL(0, report.damaged);
        stp_work_close(work, round == 2);
    }
    stp_work_close(NULL, true);
    CHECK(remove_work_place(&place));
    stp_context_destroy(context);
}

void test_work_keeps_the_first_content_of_a_key(test_state* test)
{
    work_place place;
    stp_context* context = test_context(NULL, 1, NULL);
    CHECK(context != NULL && make_work_place(&place));
    stp_work* work = open_work(context, &place);
    CHECK(work != NULL);
    const stp_bytes first = {"first", 5}, second = {"second", 6};
    const void *a = NULL, *b = NULL;
    CHECK_EQUAL(STP_OK, stp_work_store(work, work_key(1), &first, 1, &a));
    CHECK_EQUAL(STP_OK, stp_work_store(work, work_key(1), &second, 1, &b));
    CHECK(a == b && memcmp(a, "first", 5) == 0);
    CHECK_EQUAL(STP_OK,
                stp_work_store(work, work_key(2), NULL, 0, NULL)); // without parts, no bytes
    size_t size = 1;
    CHECK(stp_work_find(work, work_key(2), &size) != NULL);
    CHECK_EQUAL(0, size);
    stp_work_close(work, true);
    CHECK(remove_work_place(&place));
    stp_context_destroy(context);
}

void test_work_fresh_empties_and_remove_leaves_foreign_files(test_state* test)
{
    work_place place;
    test_log log = {0};
    stp_context* context = test_context(NULL, 1, &log);
    CHECK(context != NULL && make_work_place(&place));
    CHECK(write_segment(&place, 1, (const unsigned char*)"letters to a friend", 19));
    char notes[128], dear[128];
    snprintf(notes, sizeof(notes), "%s/segment-notes", place.folder);
    snprintf(dear, sizeof(dear), "%s/segment-000001", place.folder);
    FILE* file = fopen(notes, "w");
    CHECK(file != NULL && fclose(file) == 0);
    for (int round = 0; round < 2; ++round) {
        stp_work* work = NULL;
        CHECK_EQUAL(STP_OK,
                    stp_work_open_with(context, place.folder, round == 1, WORK_SEGMENT, &work));
        CHECK_EQUAL(WORK_NONE, find_work(work, 5));
        CHECK_EQUAL(STP_OK, store_work(work, 5, NULL));
        CHECK_EQUAL(WORK_RIGHT, find_work(work, 5));
        stp_work_close(work, false);
    }
    stp_work* work = open_work(context, &place);
    CHECK(work != NULL);
    CHECK_EQUAL(WORK_RIGHT, find_work(work, 5));
    stp_work_close(work, true);
    unsigned char text[32];
    CHECK_EQUAL(19, read_segment(&place, 1, text, sizeof(text)));
    CHECK(memcmp(text, "letters to a friend", 19) == 0);
    CHECK_EQUAL(0, unlink(notes));
    CHECK_EQUAL(0, unlink(dear));
    CHECK_EQUAL(0, rmdir(place.folder)); // nothing else was left
    CHECK_EQUAL(0, log.errors);
    CHECK(remove_work_place(&place));
    stp_context_destroy(context);
}

void test_work_is_for_one_build_at_a_time(test_state* test)
{
    work_place place;
    test_log log = {0};
    stp_context* context = test_context(NULL, 1, &log);
    CHECK(context != NULL && make_work_place(&place));
    stp_work *first = open_work(context, &place), *second = NULL;
    CHECK(first != NULL);
    CHECK_EQUAL(STP_ERROR_BUSY, stp_work_open(context, place.folder, true, &second));
    CHECK(second == NULL);
    CHECK_EQUAL(1, log.errors);
    CHECK(strstr(log.text, place.folder) == log.text && strstr(log.text, "another build") != NULL);
    CHECK_EQUAL(STP_OK, store_work(first, 3, NULL));
    stp_work_close(first, false);
    second = open_work(context, &place);
    CHECK(second != NULL);
    CHECK_EQUAL(WORK_RIGHT, find_work(second, 3)); // the rejected one emptied nothing
    stp_work_close(second, true);
    CHECK(remove_work_place(&place));
    stp_context_destroy(context);
}

void test_work_refuses_places_it_cannot_use(test_state* test)
{
    work_place place;
    test_log log = {0};
    stp_context* context = test_context(NULL, 1, &log);
    CHECK(context != NULL && make_work_place(&place));
    stp_work* work = NULL;
    FILE* file = fopen(place.folder, "w");
    CHECK(file != NULL && fclose(file) == 0);
    CHECK_EQUAL(STP_ERROR_IO, stp_work_open(context, place.folder, true, &work));
    CHECK_EQUAL(1, log.errors);
    CHECK(strstr(log.text, place.folder) == log.text && strstr(log.text, "not a folder") != NULL);
    CHECK_EQUAL(0, unlink(place.folder));
    static const char* const bad[] = {"/proc/a.work", "stp_no_such_folder/a.work", ""};
    for (int i = 0; i < 3; ++i) {
        CHECK_EQUAL(STP_ERROR_IO, stp_work_open(context, bad[i], false, &work));
        CHECK_EQUAL(2 + i, log.errors);
        CHECK(strstr(log.text, bad[i]) == log.text);
    }
    // a folder in place of the lock file
    char lock[128];
    snprintf(lock, sizeof(lock), "%s/lock", place.folder);
    CHECK(mkdir(place.folder, 0777) == 0 && mkdir(lock, 0777) == 0);
    CHECK_EQUAL(STP_ERROR_IO, stp_work_open(context, place.folder, false, &work));
    CHECK_EQUAL(5, log.errors);
    CHECK(work == NULL && rmdir(lock) == 0);
    if (geteuid() != 0) { // root may do everything
        CHECK_EQUAL(0, chmod(place.folder, 0555));
        CHECK_EQUAL(STP_ERROR_IO, stp_work_open(context, place.folder, false, &work));
        CHECK_EQUAL(6, log.errors);
        CHECK(strstr(log.text, "Permission denied") != NULL);
    }
    CHECK_EQUAL(0, rmdir(place.folder));
    CHECK(remove_work_place(&place));
    stp_context_destroy(context);
}

typedef struct crowd {
    stp_work* work;
    atomic_uint bad;
} crowd;

enum { CROWD_RESULTS = 300, CROWD_LOOKS = 1500 };

// Several jobs request each result at once; each stores it if it is missing.
static void store_and_find(size_t begin, size_t end, uint32_t worker, void* user)
{
    (void)worker;
    crowd* c = user;
    for (size_t i = begin; i < end; ++i) {
        uint32_t number = (uint32_t)(i / 3 * 7 % CROWD_RESULTS);
        work_found found = find_work(c->work, number);
        const void* stored = NULL;
        if (found == WORK_NONE) {
            bool right = store_work(c->work, number, &stored) == STP_OK &&
                         is_work(stored, work_size(number), number);
            found = right ? WORK_RIGHT : WORK_WRONG;
        }
        atomic_fetch_add(&c->bad, found != WORK_RIGHT);
    }
}

void test_work_is_shared_by_jobs(test_state* test)
{
    for (uint32_t threads = 1; threads <= 4; ++threads) {
        work_place place;
        stp_context* context = test_context(NULL, threads, NULL);
        CHECK(context != NULL && make_work_place(&place));
        for (int round = 0; round < 2; ++round) {
            crowd c = {.work = open_work(context, &place)};
            CHECK(c.work != NULL);
            stp_parallel_for(context, CROWD_LOOKS, 1, store_and_find, &c);
            CHECK_EQUAL(0, c.bad);
            stp_work_report report;
            stp_work_get_report(c.work, &report);
            CHECK_EQUAL(round == 0 ? CROWD_RESULTS : 0, report.stored); // none is stored twice
            CHECK_EQUAL(round == 0 ? 0 : CROWD_RESULTS, report.found);
            stp_work_close(c.work, round == 1);
        }
        CHECK(remove_work_place(&place));
        stp_context_destroy(context);
    }
}
