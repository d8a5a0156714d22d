// SPDX-License-Identifier: MIT
#define _GNU_SOURCE // O_PATH, syscall
#include "import/assimp/sandbox.h"

#include <assert.h>

#ifdef __linux__

#include <errno.h>
#include <fcntl.h>
#include <linux/landlock.h>
#include <seccomp.h>
#include <stddef.h>
#include <stdint.h>
#include <sys/prctl.h>
#include <sys/syscall.h>
#include <unistd.h>

// Access rights of the first Landlock version: older kernels reject later ones.
#define ALL_RIGHTS ((UINT64_C(1) << 13) - 1)

static void allow_folder(int rules, const char* folder)
{
    struct landlock_path_beneath_attr rule = {
        .allowed_access = LANDLOCK_ACCESS_FS_READ_FILE,
        .parent_fd = open(folder, O_PATH | O_CLOEXEC | O_DIRECTORY),
    };
    if (rule.parent_fd >= 0) {
        (void)syscall(SYS_landlock_add_rule, rules, LANDLOCK_RULE_PATH_BENEATH, &rule, 0);
        close(rule.parent_fd);
    }
}

static void restrict_files(const char* folder)
{
    struct landlock_ruleset_attr handled = {.handled_access_fs = ALL_RIGHTS};
    int rules = (int)syscall(SYS_landlock_create_ruleset, &handled, sizeof(handled), 0);
    if (rules < 0) {
        return; // this kernel does not support Landlock
    }
    if (folder != NULL) {
        allow_folder(rules, folder);
    }
    (void)syscall(SYS_landlock_restrict_self, rules, 0);
    close(rules);
}

// Allows memory, time, the open files, opening files for reading, and exit.
static const int allowed_calls[] = {
    SCMP_SYS(read),
    SCMP_SYS(readv),
    SCMP_SYS(pread64),
    SCMP_SYS(write),
    SCMP_SYS(writev),
    SCMP_SYS(lseek),
    SCMP_SYS(_llseek),
    SCMP_SYS(close),
    SCMP_SYS(fstat),
    SCMP_SYS(fstat64),
    SCMP_SYS(newfstatat),
    SCMP_SYS(fstatat64),
    SCMP_SYS(stat),
    SCMP_SYS(stat64),
    SCMP_SYS(lstat),
    SCMP_SYS(lstat64),
    SCMP_SYS(statx),
    SCMP_SYS(access),
    SCMP_SYS(faccessat),
    SCMP_SYS(faccessat2),
    SCMP_SYS(readlink),
    SCMP_SYS(readlinkat),
    SCMP_SYS(getcwd),
    SCMP_SYS(mmap),
    SCMP_SYS(mmap2),
    SCMP_SYS(munmap),
    SCMP_SYS(mremap),
    SCMP_SYS(mprotect),
    SCMP_SYS(madvise),
    SCMP_SYS(brk),
    SCMP_SYS(futex),
    SCMP_SYS(futex_time64),
    SCMP_SYS(sched_yield),
    SCMP_SYS(rt_sigaction),
    SCMP_SYS(rt_sigprocmask),
    SCMP_SYS(rt_sigreturn),
    SCMP_SYS(sigaltstack),
    SCMP_SYS(getpid),
    SCMP_SYS(gettid),
    SCMP_SYS(getrandom),
    SCMP_SYS(clock_gettime),
    SCMP_SYS(gettimeofday),
    SCMP_SYS(time),
    SCMP_SYS(clock_gettime64),
    SCMP_SYS(uname),
    SCMP_SYS(sysinfo),
    SCMP_SYS(restart_syscall),
    SCMP_SYS(exit),
    SCMP_SYS(exit_group),
    SCMP_SYS(sched_getaffinity),
};

static void restrict_calls(void)
{
    scmp_filter_ctx filter = seccomp_init(SCMP_ACT_ERRNO(EPERM));
    if (filter == NULL) {
        return;
    }
    int failed = 0;
    for (size_t i = 0; i < sizeof(allowed_calls) / sizeof(allowed_calls[0]); ++i) {
        failed |= seccomp_rule_add(filter, SCMP_ACT_ALLOW, allowed_calls[i], 0);
    }
    const uint64_t writing = O_WRONLY | O_RDWR | O_CREAT | O_TRUNC;
    // not those that choose who gets a signal when the pipe is written
    static const int file_calls[] = {F_GETFD, F_SETFD, F_GETFL, F_DUPFD_CLOEXEC};
    for (size_t i = 0; i < sizeof(file_calls) / sizeof(file_calls[0]); ++i) {
        const struct scmp_arg_cmp is_call = {1, SCMP_CMP_EQ, (uint64_t)file_calls[i], 0};
        failed |= seccomp_rule_add(filter, SCMP_ACT_ALLOW, SCMP_SYS(fcntl), 1, is_call);
    }
    const struct scmp_arg_cmp open_reads = {1, SCMP_CMP_MASKED_EQ, writing, 0};
    const struct scmp_arg_cmp openat_reads = {2, SCMP_CMP_MASKED_EQ, writing, 0};
    const struct scmp_arg_cmp own_process = {0, SCMP_CMP_EQ, (uint64_t)getpid(), 0}; // abort()
    const struct scmp_arg_cmp itself = {0, SCMP_CMP_EQ, 0,
                                        0}; // soft limits may be raised to hard ones
    failed |= seccomp_rule_add(filter, SCMP_ACT_ALLOW, SCMP_SYS(prlimit64), 1, itself);
    failed |= seccomp_rule_add(filter, SCMP_ACT_ALLOW, SCMP_SYS(open), 1, open_reads);
    failed |= seccomp_rule_add(filter, SCMP_ACT_ALLOW, SCMP_SYS(openat), 1, openat_reads);
    failed |= seccomp_rule_add(filter, SCMP_ACT_ALLOW, SCMP_SYS(tgkill), 1, own_process);
    if (failed == 0) {
        (void)seccomp_load(filter);
    }
    seccomp_release(filter);
}

static void close_range_of(unsigned first, unsigned last)
{
    if (first > last || syscall(SYS_close_range, first, last, 0) == 0) {
        return;
    }
    long maximum = sysconf(_SC_OPEN_MAX);
    for (unsigned i = first; i <= last && (long)i < maximum; ++i) { // a kernel before 5.9
        close((int)i);
    }
}

void stp_sandbox_enter(const char* folder, int kept)
{
    assert(kept > 2 && "the standard streams stay open in any case");
    close_range_of(3, (unsigned)kept - 1);
    close_range_of((unsigned)kept + 1, ~0u);
    if (prctl(PR_SET_NO_NEW_PRIVS, 1, 0, 0, 0) != 0) {
        return; // neither would be allowed
    }
    restrict_files(folder);
    restrict_calls();
}

#else

void stp_sandbox_enter(const char* folder, int kept)
{
    (void)folder, (void)kept;
}

#endif
