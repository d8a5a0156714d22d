// SPDX-License-Identifier: MIT
// usage: stp_tests [--jobs N] [NAME...]
//        stp_tests --jobs N --without FILE
// Runs the named tests, or all of them (except those that FILE lists as unit.NAME, one a line),
// N at a time (default 1, at most 64). All tests start from this process: under sanitizers,
// starting the program takes longer than most tests.
#include "tests.h"

#include <assert.h>
#include <dirent.h>
#include <errno.h>
#include <signal.h>
#include <stdarg.h>
#include <string.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <time.h>
#include <unistd.h>

enum { SECONDS_MAX = 1500 }; // after them, a test with its output in a file is killed, as by ctest

/// A test that runs in a process and a folder of its own.
typedef struct running_test {
    named_test test;
    pid_t child;
    char folder[512];
    FILE* output; ///< receives both output streams; NULL: they go where this process's go
    struct timespec start;
} running_test;

static const named_test tests[] = {
#define TEST(name) {#name, test_##name},
#include "test_list.h"
#undef TEST
};

void test_fail(const char* file, int line, const char* format, ...)
{
    va_list arguments;
    fflush(stdout);
    fprintf(stderr, "%s:%d: ", file, line);
    va_start(arguments, format);
    vfprintf(stderr, format, arguments);
    va_end(arguments);
    fputc('\n', stderr);
    fflush(stderr);
    _exit(TEST_FAILED); // without exit handlers: the sanitizer looks for leaks in one of them
}

/// Removes a folder and its contents. Links are removed, not followed; mounts are not looked for.
static void remove_folder(const char* path)
{
    DIR* folder = opendir(path);
    char inner[4096];
    for (struct dirent* entry; folder != NULL && (entry = readdir(folder)) != NULL;) {
        struct stat status;
        if (strcmp(entry->d_name, ".") == 0 || strcmp(entry->d_name, "..") == 0) {
            continue;
        }
        snprintf(inner, sizeof(inner), "%s/%s", path, entry->d_name);
        if (lstat(inner, &status) == 0 && S_ISDIR(status.st_mode)) {
            remove_folder(inner);
        } else {
            unlink(inner);
        }
    }
    if (folder != NULL) {
        closedir(folder);
    }
    rmdir(path);
}

/// The process of a test. It ends through exit, which reports leaks, unless a check fails.
static _Noreturn void run_here(const running_test* running)
{
    test_state state = {0};
    const char* folder = running->folder;
    if (running->output != NULL) {
        int file = fileno(running->output);
        alarm(SECONDS_MAX);
        if (dup2(file, STDOUT_FILENO) < 0 || dup2(file, STDERR_FILENO) < 0) {
            _exit(TEST_FAILED);
        }
    }
    setvbuf(stdout, NULL, _IOLBF, 0);      // a crash loses no lines
    const char* output = getenv("TMPDIR"); // for what outlives the test
    if (setenv("STP_TEST_OUTPUT", output != NULL ? output : "/tmp", 1) != 0 || chdir(folder) != 0 ||
        setenv("TMPDIR", folder, 1) != 0) {
        perror(folder);
        _exit(TEST_FAILED);
    }
    running->test.run(&state);
    if (state.skipped != NULL) {
        printf("skip %s: %s\n", running->test.name, state.skipped);
    }
    exit(state.skipped != NULL ? TEST_SKIPPED : TEST_PASSED);
}

/// Starts a test. @return whether it runs; if not, a message has been printed
static int start_test(running_test* running, const named_test* test, FILE* output)
{
    const char* parent = getenv("TMPDIR");
    *running = (running_test){.test = *test, .output = output};
    snprintf(running->folder, sizeof(running->folder), "%s/stp_test_XXXXXX",
             parent != NULL ? parent : "/tmp");
    if (mkdtemp(running->folder) == NULL) {
        perror(running->folder);
        return 0;
    }
    clock_gettime(CLOCK_MONOTONIC, &running->start);
    fflush(NULL);
    running->child = fork();
    if (running->child == 0) {
        run_here(running);
    }
    if (running->child < 0) {
        perror("fork");
        remove_folder(running->folder);
    }
    return running->child > 0;
}

static void copy_output(FILE* output)
{
    char text[4096];
    rewind(output);
    for (size_t size; (size = fread(text, 1, sizeof(text), output)) > 0;) {
        fwrite(text, 1, size, stdout);
    }
}

/// Reports a test that has ended, and removes its folder. @return its code
static int finish_test(const running_test* running, int status)
{
    int code = WIFEXITED(status) ? WEXITSTATUS(status) : TEST_FAILED;
    code = code == TEST_PASSED || code == TEST_SKIPPED ? code : TEST_FAILED;
    assert(strstr(running->folder, "/stp_test_") != NULL && "only a test's own folder is removed");
    remove_folder(running->folder);
    if (running->output != NULL && code != TEST_PASSED) {
        copy_output(running->output);
        fflush(stdout);
    }
    if (WIFSIGNALED(status)) {
        fprintf(stderr, "ended by signal %d: %s\n", WTERMSIG(status), strsignal(WTERMSIG(status)));
    }
    if (code != TEST_SKIPPED) {
        printf("%s %s", code == TEST_PASSED ? "ok  " : "FAIL", running->test.name);
        if (running->output != NULL) {
            struct timespec end;
            clock_gettime(CLOCK_MONOTONIC, &end);
            printf(", %.2f s", (double)(end.tv_sec - running->start.tv_sec) +
                                   1e-9 * (double)(end.tv_nsec - running->start.tv_nsec));
        }
        putchar('\n');
    }
    fflush(stdout);
    return code;
}

int test_run(const char* name, test_function* run)
{
    running_test running;
    int status = 0;
    if (!start_test(&running, &(named_test){name, run}, NULL)) {
        return TEST_FAILED;
    }
    if (waitpid(running.child, &status, 0) != running.child) {
        perror(name);
        status = TEST_FAILED << 8;
    }
    return finish_test(&running, status);
}

static void count_test(test_counts* counts, int code)
{
    counts->passed += code == TEST_PASSED;
    counts->failed += code == TEST_FAILED;
    counts->skipped += code == TEST_SKIPPED;
}

static void free_slot(running_test running[], int* count, int slot, test_counts* counts, int code)
{
    assert(slot >= 0 && slot < *count && "the slot holds a running test");
    count_test(counts, code);
    fclose(running[slot].output);
    running[slot] = running[--*count];
}

/// Waits until a child ends; if it is a test, reports it and frees its slot. Other children may be
/// inherited. If waiting fails, all running tests have failed.
static void await_child(running_test running[], int* count, test_counts* counts)
{
    int status = 0, slot = 0;
    pid_t child = wait(&status);
    if (child < 0 && errno != EINTR) {
        perror("wait");
        while (*count > 0) {
            kill(running[0].child, SIGKILL);
            free_slot(running, count, 0, counts, finish_test(&running[0], TEST_FAILED << 8));
        }
    }
    while (slot < *count && running[slot].child != child) {
        slot += 1;
    }
    if (slot < *count) {
        free_slot(running, count, slot, counts, finish_test(&running[slot], status));
    }
}

void test_run_jobs(const named_test wanted[], size_t count, int jobs, test_counts* counts)
{
    running_test running[TEST_JOBS_MAX];
    int busy = 0;
    assert(jobs >= 1 && jobs <= TEST_JOBS_MAX && "there is a slot per job");
    for (size_t i = 0; i < count; ++i) {
        FILE* output = tmpfile();
        if (output == NULL || !start_test(&running[busy], &wanted[i], output)) {
            printf("%s: it cannot be started\nFAIL %s\n", wanted[i].name, wanted[i].name);
            counts->failed += 1;
            if (output != NULL) {
                fclose(output);
            }
            continue;
        }
        busy += 1;
        while (busy == jobs) {
            await_child(running, &busy, counts);
        }
    }
    while (busy > 0) {
        await_child(running, &busy, counts);
    }
}

static int is_wanted(const char* name, int argc, char** argv)
{
    int wanted = argc == 0;
    for (int i = 0; i < argc; ++i) {
        wanted |= strcmp(argv[i], name) == 0;
    }
    return wanted;
}

/// Reads names to leave out. @return the text, in which each name is between line feeds; NULL if it cannot be read
static char* read_names(const char* path)
{
    enum { SIZE_MAX_TEXT = 1 << 16 };
    FILE* file = fopen(path, "rb");
    char* text = file != NULL ? calloc(1, SIZE_MAX_TEXT + 2) : NULL;
    size_t size = text != NULL ? fread(text + 1, 1, SIZE_MAX_TEXT, file) : 0;
    if (file == NULL || text == NULL || size == SIZE_MAX_TEXT) {
        fprintf(stderr, "%s: cannot be read, or is too long\n", path);
        free(text);
        text = NULL;
    } else {
        text[0] = '\n';
    }
    if (file != NULL) {
        fclose(file);
    }
    return text;
}

static int is_listed(const char* names, const char* name)
{
    char line[256];
    snprintf(line, sizeof(line), "\nunit.%s\n", name);
    return names != NULL && strstr(names, line) != NULL;
}

int main(int argc, char** argv)
{
    static named_test wanted[sizeof(tests) / sizeof(tests[0])];
    size_t count = 0;
    int jobs = 1, first = 1;
    if (argc > 2 && strcmp(argv[1], "--jobs") == 0) {
        jobs = atoi(argv[2]);
        first = 3;
    }
    char* without = NULL;
    if (argc == first + 2 && strcmp(argv[first], "--without") == 0) {
        without = read_names(argv[first + 1]);
        if (without == NULL) {
            return TEST_FAILED;
        }
        argc = first;
    }
    if (jobs < 1) {
        fprintf(stderr, "--jobs: expected a number from 1\n");
        return TEST_FAILED;
    }
    jobs = jobs < TEST_JOBS_MAX ? jobs : TEST_JOBS_MAX;
    for (size_t i = 0; i < sizeof(tests) / sizeof(tests[0]); ++i) {
        if (is_wanted(tests[i].name, argc - first, argv + first) &&
            !is_listed(without, tests[i].name)) {
            wanted[count++] = tests[i];
        }
    }
    free(without);
    if (count == 0 || count + (size_t)first < (size_t)argc) {
        fprintf(stderr, "no test is named like one of the arguments\n");
        return TEST_FAILED;
    }
    test_counts counts = {0};
    if (first > 1) {
        test_run_jobs(wanted, count, jobs, &counts);
        printf("%d passed, %d failed, %d skipped\n", counts.passed, counts.failed, counts.skipped);
    } else {
        for (size_t i = 0; i < count; ++i) {
            count_test(&counts, test_run(wanted[i].name, wanted[i].run));
        }
    }
    if (counts.failed == 0 && counts.passed == 0) {
        return TEST_SKIPPED;
    }
    return counts.failed > 0 ? TEST_FAILED : TEST_PASSED;
}
