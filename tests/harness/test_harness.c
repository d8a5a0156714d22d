// SPDX-License-Identifier: MIT
// The test framework itself: messages of failing, leaking, crashing and skipped tests, and what
// they leave behind.
#include "tests.h"

#include <dirent.h>
#include <fcntl.h>
#include <signal.h>
#include <stdbool.h>
#include <string.h>
#include <sys/wait.h>
#include <unistd.h>

#if defined(__SANITIZE_ADDRESS__)
#define HAS_LEAK_CHECK
#elif defined(__has_feature)
#if __has_feature(address_sanitizer)
#define HAS_LEAK_CHECK
#endif
#endif

static void passes(test_state* test)
{
    CHECK_EQUAL(2, 1 + 1);
}

static void is_skipped(test_state* test)
{
    SKIP("there is no reason");
}

static void* volatile lost; // the last pointer to a block, until it is overwritten

static void leak(void)
{
    lost = malloc(1000);
    lost = malloc(2000);
    lost = NULL;
}

static void leaks(test_state* test)
{
    CHECK(test != NULL);
    leak();
}

static void fails_in_helper(test_state* test, int value)
{
    CHECK_EQUAL(3, value);
}

/// Has memory, a context, a file and a folder that nothing frees after the failed check.
static void fails(test_state* test)
{
    stp_context* context = test_context(NULL, 3, NULL);
    FILE* file = fopen("left", "w");
    CHECK(context != NULL && file != NULL && fputs("behind", file) >= 0);
    leak();
    puts("what was printed before");
    fails_in_helper(test, 4);
    puts("a statement after the failed check ran");
}

static void* fail_in_thread(void* user)
{
    test_state* test = user;
    CHECK(test == NULL);
    return NULL;
}

static void fails_in_thread(test_state* test)
{
    pthread_t thread;
    CHECK(pthread_create(&thread, NULL, fail_in_thread, test) == 0);
    pthread_join(thread, NULL);
    puts("a statement after the failed check ran");
}

static void crashes(test_state* test)
{
    CHECK(raise(SIGKILL) != 0);
}

/// Runs a test as `main` does. @return its code; `text`: its output on both streams
static int run(test_function* function, char text[], size_t size)
{
    FILE* file = tmpfile();
    pid_t child = file != NULL ? fork() : -1;
    int status = 0;
    if (child == 0) {
        bool good = dup2(fileno(file), 1) == 1 && dup2(fileno(file), 2) == 2;
        _exit(good ? test_run("example", function) : 99);
    }
    bool ended = child > 0 && waitpid(child, &status, 0) == child && WIFEXITED(status);
    if (file != NULL) {
        rewind(file);
        text[fread(text, 1, size - 1, file)] = '\0';
        fclose(file);
    }
    return ended ? WEXITSTATUS(status) : 98;
}

static int count_files(void)
{
    DIR* folder = opendir(".");
    int count = 0;
    for (struct dirent* entry; folder != NULL && (entry = readdir(folder)) != NULL;) {
        count += entry->d_name[0] != '.';
    }
    if (folder != NULL) {
        closedir(folder);
    }
    return count;
}

void test_harness_reports_passed_and_skipped_tests(test_state* test)
{
    char text[4096];
    CHECK_EQUAL(TEST_PASSED, run(passes, text, sizeof(text)));
    CHECK(strcmp(text, "ok   example\n") == 0);
    CHECK_EQUAL(TEST_SKIPPED, run(is_skipped, text, sizeof(text)));
    CHECK(strcmp(text, "skip example: there is no reason\n") == 0);
}

void test_harness_shows_failed_check_last(test_state* test)
{
    test_function* const functions[] = {fails, fails_in_thread};
    const char* const messages[] = {": value: expected 3 (0x3), got 4 (0x4)\nFAIL example\n",
                                    ": failed: test == NULL\nFAIL example\n"};
    for (int i = 0; i < 2; ++i) {
        char text[4096];
        CHECK_EQUAL(TEST_FAILED, run(functions[i], text, sizeof(text)));
        const char* message = strstr(text, messages[i]);
        CHECK(message != NULL && strlen(message) == strlen(messages[i])); // nothing follows
        CHECK(strstr(text, __FILE__) != NULL);
        CHECK(strstr(text, "leak") == NULL && strstr(text, "Sanitizer") == NULL);
        CHECK(strstr(text, "a statement after") == NULL);
        CHECK((i == 0) == (strstr(text, "what was printed before\n") == text));
        CHECK_EQUAL(0, count_files()); // its folder is removed
    }
}

static void prints_and_passes(test_state* test)
{
    CHECK(puts("output of a test that passes") >= 0);
}

static void run_five(test_state* test)
{
    const named_test tests[] = {{"one", prints_and_passes},
                                {"two", fails},
                                {"three", is_skipped},
                                {"four", crashes},
                                {"five", passes}};
    test_counts counts = {0};
    test_run_jobs(tests, 5, 2, &counts);
    CHECK_EQUAL(2, counts.passed);
    CHECK_EQUAL(2, counts.failed);
    CHECK_EQUAL(1, counts.skipped);
}

void test_harness_runs_tests_side_by_side(test_state* test)
{
    char text[4096];
    CHECK_EQUAL(TEST_PASSED, run(run_five, text, sizeof(text)));
    CHECK(strstr(text, "ok   one, ") != NULL && strstr(text, "ok   five, ") != NULL);
    CHECK(strstr(text, "output of a test that passes") == NULL);
    CHECK(strstr(text, "expected 3 (0x3), got 4 (0x4)\nFAIL two, ") != NULL);
    CHECK(strstr(text, "skip three: there is no reason\n") != NULL);
    CHECK(strstr(text, "ended by signal 9: Killed\nFAIL four, ") != NULL);
    CHECK_EQUAL(0, count_files()); // their folders are removed
}

void test_harness_reports_signals(test_state* test)
{
    char text[4096];
    CHECK_EQUAL(TEST_FAILED, run(crashes, text, sizeof(text)));
    CHECK(strcmp(text, "ended by signal 9: Killed\nFAIL example\n") == 0);
}

void test_harness_fails_tests_that_leak(test_state* test)
{
#ifdef HAS_LEAK_CHECK
    char text[4096];
    const char* options = getenv("ASAN_OPTIONS");
    if (options != NULL && strstr(options, "detect_leaks=0") != NULL) {
        SKIP("ASAN_OPTIONS turns leak reports off");
    }
    CHECK_EQUAL(TEST_FAILED, run(leaks, text, sizeof(text)));
    CHECK(strstr(text, "LeakSanitizer: detected memory leaks") != NULL);
#else
    (void)leaks;
    SKIP("only the address sanitizer finds leaks");
#endif
}
