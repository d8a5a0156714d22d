// SPDX-License-Identifier: MIT
#include "support_sample.h"
#include "tests.h"

#include "store/bytes/format.h"

#include <string.h>
#include <unistd.h>

// A path of this process in the temporary folder.
static const char* scratch_path(char path[256], const char* name)
{
    const char* folder = getenv("TMPDIR");
    snprintf(path, 256, "%s/stp_%s_%ld.stip", folder != NULL ? folder : "/tmp", name,
             (long)getpid());
    return path;
}

void test_store_round_trip_of_random_scenes(test_state* test)
{
    char path[256];
    scratch_path(path, "round");
    stp_context* context = test_context(NULL, 1, NULL);
    CHECK(context != NULL);
    uint64_t live_before = stp_context_live_bytes(context);
    stp_arena arena = stp_arena_create(context, 1 << 16);
    uint64_t seed = 0;
    const char* difference = NULL;
    stp_result written = STP_OK, opened = STP_OK, checked = STP_OK;
    for (; seed < 120 && difference == NULL; ++seed) {
        stp_arena_mark mark = stp_arena_get_mark(&arena);
        sample made = sample_make(&arena, seed);
        stp_store* store = NULL;
        written = stp_store_write(context, &made.content, path);
        opened = written == STP_OK ? stp_store_open(context, path, &store) : STP_ERROR_IO;
        checked = opened == STP_OK ? stp_store_check(context, path, false) : STP_ERROR_IO;
        if (checked != STP_OK) {
            stp_store_close(store);
            break;
        }
        difference = sample_difference(&made.content, store);
        stp_store_close(store);
        stp_arena_rewind(&arena, mark);
    }
    unlink(path);
    stp_arena_destroy(&arena);
    CHECK_EQUAL(live_before, stp_context_live_bytes(context));
    stp_context_destroy(context);
    if (difference != NULL) {
        fprintf(stderr, "seed %llu: %s\n", (unsigned long long)seed - 1, difference);
    }
    CHECK_EQUAL(STP_OK, written);
    CHECK_EQUAL(STP_OK, opened);
    CHECK_EQUAL(STP_OK, checked);
    CHECK(difference == NULL);
}
