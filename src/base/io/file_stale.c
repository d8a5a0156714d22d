// SPDX-License-Identifier: MIT
#define _XOPEN_SOURCE 700 // realpath
#include "base/io/file.h"

#include <dirent.h>
#include <errno.h>
#include <fcntl.h>
#include <signal.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

// Process number in "NAME.tmp-<process>-<number>"; 0 if the name has another form.
static pid_t process_of(const char* entry, const char* name)
{
    static const char infix[] = ".tmp-";
    size_t length = strlen(name);
    if (strncmp(entry, name, length) != 0 ||
        strncmp(entry + length, infix, sizeof(infix) - 1) != 0) {
        return 0;
    }
    const char* number = entry + length + sizeof(infix) - 1;
    char* end = NULL;
    errno = 0;
    long process = strtol(number, &end, 10);
    size_t digits = *end == '-' ? strspn(end + 1, "0123456789") : 0;
    bool named = *number >= '1' && *number <= '9' && digits != 0 && end[1 + digits] == 0;
    return named && errno == 0 && process <= INT32_MAX ? (pid_t)process : 0;
}

static bool is_alive(pid_t process)
{
    return kill(process, 0) == 0 || errno != ESRCH;
}

static void remove_in(int folder, const char* name)
{
    DIR* entries = fdopendir(folder);
    if (entries == NULL) {
        close(folder);
        return;
    }
    for (struct dirent* entry; (entry = readdir(entries)) != NULL;) {
        pid_t process = process_of(entry->d_name, name);
        if (process != 0 && !is_alive(process)) {
            (void)unlinkat(dirfd(entries), entry->d_name, 0);
        }
    }
    closedir(entries);
}

void stp_file_remove_stale(stp_context* context, const char* path)
{
    char* target = realpath(path, NULL); // writers write to the target of a link
    const char* whole = target != NULL ? target : path;
    char* copy = stp_alloc(context, strlen(whole) + 2);
    if (copy != NULL) {
        const char* slash = strrchr(whole, '/');
        size_t length = slash != NULL ? (size_t)(slash - whole) + 1 : 0;
        memcpy(copy, whole, length);
        memcpy(copy + length, ".", 2);
        int folder = open(copy, O_RDONLY | O_DIRECTORY | O_CLOEXEC);
        const char* name = slash != NULL ? slash + 1 : whole;
        if (folder >= 0 && *name != 0) {
            remove_in(folder, name);
        } else if (folder >= 0) {
            close(folder);
        }
        stp_free(context, copy);
    }
    free(target);
}
