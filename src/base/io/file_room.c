// SPDX-License-Identifier: MIT
#include "base/io/file.h"

#include <limits.h>
#include <stdio.h>
#include <string.h>
#include <sys/statvfs.h>

uint64_t stp_file_room(const char* path)
{
    char folder[PATH_MAX];
    const char* slash = strrchr(path, '/');
    size_t length =
        slash != NULL ? (size_t)(slash - path) + 1 : 0; // includes the slash: it may be the root
    if (length >= sizeof(folder)) {
        return UINT64_MAX;
    }
    snprintf(folder, sizeof(folder), "%.*s", length > 0 ? (int)length : 1, length > 0 ? path : ".");
    struct statvfs status;
    if (statvfs(folder, &status) != 0) {
        return UINT64_MAX;
    }
    uint64_t blocks = status.f_bavail, size = status.f_frsize;
    return size > 0 && blocks > UINT64_MAX / size ? UINT64_MAX : blocks * size;
}
