// SPDX-License-Identifier: MIT
// Runs the tests whose names are the arguments, or all of them.
#include "tests.h"

#include <dirent.h>
#include <stdarg.h>
#include <string.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

static const struct {
    const char* name;
    test_function* run;
} tests[] = {
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

/// Removes a folder and its contents; mounted or linked content stays.
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
static _Noreturn void run_here(const char* name, test_function* run, const char* folder)
{
    test_state state = {0};
    setvbuf(stdout, NULL, _IOLBF, 0);      // a crash loses no lines
    const char* output = getenv("TMPDIR"); // for what outlives the test
    if (setenv("STP_TEST_OUTPUT", output != NULL ? output : "/tmp", 1) != 0 || chdir(folder) != 0 ||
        setenv("TMPDIR", folder, 1) != 0) {
        perror(folder);
        _exit(TEST_FAILED);
    }
    run(&state);
    if (state.skipped != NULL) {
        printf("skip %s: %s\n", name, state.skipped);
    }
    exit(state.skipped != NULL ? TEST_SKIPPED : TEST_PASSED);
}

int test_run(const char* name, test_function* run)
{
    const char* parent = getenv("TMPDIR");
    char folder[512];
    int status = 0;
    snprintf(folder, sizeof(folder), "%s/stp_test_XXXXXX", parent != NULL ? parent : "/tmp");
    if (mkdtemp(folder) == NULL) {
        perror(folder);
        return TEST_FAILED;
    }
    fflush(NULL);
    pid_t child = fork();
    if (child == 0) {
        run_here(name, run, folder);
    }
    if (child < 0 || waitpid(child, &status, 0) != child) {
        perror("fork");
        status = TEST_FAILED << 8;
    }
    remove_folder(folder);
    if (WIFSIGNALED(status)) {
        fprintf(stderr, "ended by signal %d: %s\n", WTERMSIG(status), strsignal(WTERMSIG(status)));
    }
    int code = WIFEXITED(status) ? WEXITSTATUS(status) : TEST_FAILED;
    code = code == TEST_PASSED || code == TEST_SKIPPED ? code : TEST_FAILED;
    if (code != TEST_SKIPPED) {
        printf("%s %s\n", code == TEST_PASSED ? "ok  " : "FAIL", name);
    }
    fflush(stdout);
    return code;
}

static int is_wanted(const char* name, int argc, char** argv)
{
    int wanted = argc < 2;
    for (int i = 1; i < argc; ++i) {
        wanted |= strcmp(argv[i], name) == 0;
    }
    return wanted;
}

int main(int argc, char** argv)
{
    int ran = 0, failed = 0, skipped = 0;
    for (size_t i = 0; i < sizeof(tests) / sizeof(tests[0]); ++i) {
        if (is_wanted(tests[i].name, argc, argv)) {
            int code = test_run(tests[i].name, tests[i].run);
            ran += 1;
            failed += code == TEST_FAILED;
            skipped += code == TEST_SKIPPED;
        }
    }
    if (ran < argc - 1 || ran == 0) {
        fprintf(stderr, "no test is named like one of the arguments\n");
        return TEST_FAILED;
    }
    if (failed == 0 && skipped == ran) {
        return TEST_SKIPPED;
    }
    return failed > 0 ? TEST_FAILED : TEST_PASSED;
}
