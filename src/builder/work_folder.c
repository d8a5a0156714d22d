// SPDX-License-Identifier: MIT
#define _DEFAULT_SOURCE // flock
#include "builder/work_internal.h"

#include <assert.h>
#include <dirent.h>
#include <errno.h>
#include <fcntl.h>
#include <stdlib.h>
#include <string.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <time.h>
#include <unistd.h>

// A killed build's helper process, forked to read a file, lives on for a moment and keeps the lock.
enum { LOCK_ATTEMPTS = 20, LOCK_WAIT_MS = 25 };

static const char lock_name[] = "lock";

static stp_result fail_folder(const stp_work_place* place, const char* what)
{
    return stp_fail(place->context, STP_ERROR_IO, "%s: %s: %s", place->path, what, strerror(errno));
}

static stp_result open_folder(stp_work_place* place)
{
    if (mkdir(place->path, 0777) != 0 && errno != EEXIST) {
        return fail_folder(place, "cannot create the folder for the build's results");
    }
    place->folder = open(place->path, O_RDONLY | O_DIRECTORY | O_CLOEXEC);
    if (place->folder < 0 && errno == ENOTDIR) {
        return stp_fail(place->context, STP_ERROR_IO,
                        "%s: is not a folder, but the build needs it for its results", place->path);
    }
    return place->folder >= 0 ? STP_OK : fail_folder(place, "cannot open the folder");
}

static bool try_lock(int file)
{
    const struct timespec pause = {.tv_nsec = LOCK_WAIT_MS * 1000000L};
    for (int attempt = 0; attempt < LOCK_ATTEMPTS; ++attempt) {
        if (flock(file, LOCK_EX | LOCK_NB) == 0) {
            return true;
        }
        if (errno != EWOULDBLOCK && errno != EINTR) {
            return false;
        }
        (void)nanosleep(&pause, NULL);
    }
    errno = EWOULDBLOCK;
    return false;
}

// Whether the locked file is still at its path: the previous owner may have removed it.
static bool is_current(const stp_work_folder* folder)
{
    struct stat locked, named;
    return fstat(folder->lock, &locked) == 0 &&
           fstatat(folder->place.folder, lock_name, &named, AT_SYMLINK_NOFOLLOW) == 0 &&
           locked.st_dev == named.st_dev && locked.st_ino == named.st_ino;
}

static stp_result lock_folder(stp_work_folder* folder, bool* again)
{
    stp_work_place* place = &folder->place;
    *again = false;
    folder->lock = openat(place->folder, lock_name,
                          O_RDWR | O_CREAT | O_CLOEXEC | O_NOFOLLOW | O_NONBLOCK, 0666);
    if (folder->lock < 0) {
        if (errno == ENOENT) { // another build removed the folder just now
            *again = true;
            return STP_OK;
        }
        return fail_folder(place, "cannot create the file 'lock' in it");
    }
    if (!try_lock(folder->lock)) {
        return errno == EWOULDBLOCK ? stp_fail(place->context, STP_ERROR_BUSY,
                                               "%s: another build is using it", place->path)
                                    : fail_folder(place, "cannot lock it");
    }
    *again = !is_current(folder);
    return STP_OK;
}

static void close_descriptors(stp_work_folder* folder)
{
    if (folder->lock >= 0) {
        close(folder->lock);
    }
    if (folder->place.folder >= 0) {
        close(folder->place.folder);
    }
    folder->lock = folder->place.folder = -1;
}

stp_result stp_work_folder_open(stp_context* context, const char* path, stp_work_folder* folder)
{
    *folder = (stp_work_folder){
        .place = {.context = context, .path = path, .folder = -1},
        .lock = -1,
    };
    bool again = true;
    for (int attempt = 0; attempt < LOCK_ATTEMPTS && again; ++attempt) {
        stp_result result = open_folder(&folder->place);
        result = result == STP_OK ? lock_folder(folder, &again) : result;
        if (result != STP_OK) {
            close_descriptors(folder);
            return result;
        }
        if (again) {
            close_descriptors(folder);
        }
    }
    return !again ? STP_OK
                  : stp_fail(context, STP_ERROR_BUSY, "%s: another build is using it", path);
}

void stp_work_folder_close(stp_work_folder* folder, bool remove)
{
    assert(folder->lock >= 0 && folder->place.folder >= 0 && "closed twice, or never opened");
    struct stat status;
    if (remove && fstat(folder->lock, &status) == 0 && S_ISREG(status.st_mode) &&
        status.st_size == 0) {
        (void)unlinkat(folder->place.folder, lock_name, 0);
    }
    if (remove && rmdir(folder->place.path) != 0) {
        stp_notice(folder->place.context, "%s: not removed: %s", folder->place.path,
                   strerror(errno));
    }
    close_descriptors(folder);
}

static int compare_numbers(const void* a, const void* b)
{
    uint32_t x = *(const uint32_t*)a, y = *(const uint32_t*)b;
    return (x > y) - (x < y);
}

stp_result stp_work_folder_list(const stp_work_folder* folder, uint32_t** numbers, size_t* count)
{
    *numbers = NULL;
    *count = 0;
    const stp_work_place* place = &folder->place;
    assert(folder->lock >= 0 && "another build may change the list");
    int copy = openat(place->folder, ".", O_RDONLY | O_DIRECTORY | O_CLOEXEC);
    DIR* entries = copy >= 0 ? fdopendir(copy) : NULL;
    if (entries == NULL) {
        stp_result result = fail_folder(place, "cannot list the folder");
        if (copy >= 0) {
            close(copy);
        }
        return result;
    }
    size_t capacity = 0;
    stp_result result = STP_OK;
    for (struct dirent* entry; result == STP_OK && (entry = readdir(entries)) != NULL;) {
        uint32_t number = stp_work_segment_number(entry->d_name);
        if (number != UINT32_MAX) {
            if (STP_MAKE_ROOM(place->context, *numbers, capacity, *count + 1)) {
                (*numbers)[(*count)++] = number;
            } else {
                result = stp_fail_memory(place->context);
            }
        }
    }
    closedir(entries);
    if (result == STP_OK && *count != 0) {
        qsort(*numbers, *count, sizeof(**numbers), compare_numbers);
    }
    return result;
}
