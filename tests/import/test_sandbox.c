// SPDX-License-Identifier: MIT
#define _GNU_SOURCE // syscall
// What a sandboxed process can still do.
#include "tests.h"

#include "import/assimp/sandbox.h"

#include <fcntl.h>
#include <signal.h>
#include <stdbool.h>
#include <stdlib.h>
#include <string.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <unistd.h>

/// The actions that failed in the sandbox, as bits; 0: everything is as expected.
enum {
    READS_OUTSIDE = 1,
    WRITES = 2,
    CONNECTS = 4,
    FORKS = 8,
    SIGNALS = 16,
    IS_STUCK = 32, ///< it cannot read its folder, or allocate memory
};

static bool has_landlock(void)
{
#ifdef SYS_landlock_create_ruleset
    return syscall(SYS_landlock_create_ruleset, NULL, (size_t)0, 1) > 0; // the version
#else
    return false;
#endif
}

static bool can_open(const char* path, int flags)
{
    int file = open(path, flags, 0600);
    if (file >= 0) {
        close(file);
    }
    return file >= 0;
}

static int try_all(const char* inside, const char* outside, bool files_are_restricted)
{
    int found = 0;
    if (files_are_restricted && can_open(outside, O_RDONLY)) {
        found |= READS_OUTSIDE;
    }
    if (can_open(inside, O_WRONLY) || can_open(inside, O_RDWR | O_CREAT)) {
        found |= WRITES;
    }
    if (socket(AF_INET, SOCK_STREAM, 0) >= 0 || socket(AF_UNIX, SOCK_STREAM, 0) >= 0) {
        found |= CONNECTS;
    }
    pid_t child = fork();
    if (child == 0) {
        _exit(0);
    }
    found |= child > 0 ? FORKS : 0;
    found |= kill(getppid(), 0) == 0 ? SIGNALS : 0;
    char* memory = malloc(64 << 20);
    if (memory != NULL) {
        memset(memory, 1, 64 << 20);
    }
    if (memory == NULL || memory[12345] != 1 || !can_open(inside, O_RDONLY)) {
        found |= IS_STUCK;
    }
    free(memory);
    return found;
}

void test_sandboxes_take_rights_away(test_state* test)
{
    char folder[] = "stp_sandbox_XXXXXX", inside[64];
    char outside[] = "stp_outside_XXXXXX";
    int file = mkstemp(outside);
    CHECK(mkdtemp(folder) != NULL && file >= 0 && close(file) == 0);
    snprintf(inside, sizeof(inside), "%s/part", folder);
    CHECK(can_open(inside, O_WRONLY | O_CREAT) && can_open(outside, O_RDONLY));
    bool restricted = has_landlock();
    pid_t child = fork();
    CHECK(child >= 0);
    if (child == 0) {
        int kept = open("/dev/null", O_RDWR), lost = open(outside, O_RDWR);
        stp_sandbox_enter(folder, kept);
        int found = try_all(inside, outside, restricted);
        found |= kept < 3 || write(kept, "", 1) != 1 ? IS_STUCK : 0;
        found |= lost >= 0 && write(lost, "", 1) >= 0 ? WRITES : 0;
        found |= fcntl(kept, F_SETOWN, getppid()) == 0 ? SIGNALS : 0;
        _exit(found);
    }
    int status = 0;
    CHECK_EQUAL(child, waitpid(child, &status, 0));
    CHECK(WIFEXITED(status));
    CHECK_EQUAL(0, WEXITSTATUS(status));
    unlink(inside);
    unlink(outside);
    CHECK_EQUAL(0, rmdir(folder));
}
