// SPDX-License-Identifier: MIT
#include "tests.h"

#include <string.h>

static const struct {
    const char* name;
    void (*run)(test_state* test);
} tests[] = {
#define TEST(name) {#name, test_##name},
#include "test_list.h"
#undef TEST
};

int main(int argc, char** argv)
{
    int ran = 0, failed = 0, skipped = 0;
    for (size_t i = 0; i < sizeof(tests) / sizeof(tests[0]); ++i) {
        if (argc > 1 && strcmp(argv[1], tests[i].name) != 0) {
            continue;
        }
        test_state state = {0};
        tests[i].run(&state);
        if (state.skipped != NULL) {
            printf("skip %s: %s\n", tests[i].name, state.skipped);
            skipped += 1;
        } else {
            printf("%s %s\n", state.failed ? "FAIL" : "ok  ", tests[i].name);
        }
        ran += 1;
        failed += state.failed;
    }
    if (ran == 0) {
        fprintf(stderr, "no test is named %s\n", argc > 1 ? argv[1] : "");
    }
    if (ran == 1 && skipped == 1) {
        return 77; // ctest: skipped
    }
    return ran == 0 || failed != 0;
}
