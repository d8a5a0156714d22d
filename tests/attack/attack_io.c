// SPDX-License-Identifier: MIT
// Preloaded by scripts/attack: the n-th call of one kind fails on regular files and folders.
//
//   STP_IO_KIND   read, write, short (a write of half the bytes), open, map, sync, rename, size,
//                 folder, remove or close
//   STP_IO_NTH    number of the first call that fails, from 1
//   STP_IO_ERROR  errno; default EIO
//   STP_IO_ALL    set: all later ones fail, too
#define _GNU_SOURCE
#include <dlfcn.h>
#include <errno.h>
#include <fcntl.h>
#include <stdarg.h>
#include <stdatomic.h>
#include <stdbool.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <sys/uio.h>
#include <unistd.h>

static atomic_long calls;

/// Whether this call fails; sets errno then.
static bool fails(const char* kind)
{
    const char* wanted = getenv("STP_IO_KIND");
    const char* nth = getenv("STP_IO_NTH");
    const char* error = getenv("STP_IO_ERROR");
    if (wanted == NULL || nth == NULL || strcmp(wanted, kind) != 0) {
        return false;
    }
    long n = atomic_fetch_add(&calls, 1) + 1, first = atol(nth);
    bool failing = n == first || (n > first && getenv("STP_IO_ALL") != NULL);
    errno = failing ? (error != NULL ? atoi(error) : EIO) : errno;
    return failing;
}

static bool is_file(int descriptor)
{
    struct stat status;
    int before = errno;
    bool file = descriptor > 2 && fstat(descriptor, &status) == 0 &&
                (S_ISREG(status.st_mode) || S_ISDIR(status.st_mode));
    errno = before;
    return file;
}

/// Calls the function that this library replaces.
#define NEXT(name) ((__typeof__(&name))dlsym(RTLD_NEXT, #name))

ssize_t read(int file, void* bytes, size_t size)
{
    return is_file(file) && fails("read") ? -1 : NEXT(read)(file, bytes, size);
}

ssize_t pread(int file, void* bytes, size_t size, off_t offset)
{
    return is_file(file) && fails("read") ? -1 : NEXT(pread)(file, bytes, size, offset);
}

ssize_t write(int file, const void* bytes, size_t size)
{
    if (is_file(file) && fails("write")) {
        return -1;
    }
    size_t half = size > 1 && is_file(file) && fails("short") ? size / 2 : size;
    return NEXT(write)(file, bytes, half);
}

ssize_t pwrite(int file, const void* bytes, size_t size, off_t offset)
{
    if (is_file(file) && fails("write")) {
        return -1;
    }
    size_t half = size > 1 && is_file(file) && fails("short") ? size / 2 : size;
    return NEXT(pwrite)(file, bytes, half, offset);
}

ssize_t writev(int file, const struct iovec* parts, int count)
{
    return is_file(file) && fails("write") ? -1 : NEXT(writev)(file, parts, count);
}

static int mode_of(int flags, va_list arguments)
{
    return (flags & O_CREAT) != 0 || (flags & O_TMPFILE) == O_TMPFILE ? va_arg(arguments, int) : 0;
}

int open(const char* path, int flags, ...)
{
    va_list arguments;
    va_start(arguments, flags);
    int mode = mode_of(flags, arguments);
    va_end(arguments);
    bool ours = strncmp(path, "/usr", 4) != 0 && strncmp(path, "/proc", 5) != 0;
    return ours && fails("open") ? -1 : NEXT(open)(path, flags, mode);
}

int openat(int folder, const char* path, int flags, ...)
{
    va_list arguments;
    va_start(arguments, flags);
    int mode = mode_of(flags, arguments);
    va_end(arguments);
    return fails("open") ? -1 : NEXT(openat)(folder, path, flags, mode);
}

void* mmap(void* at, size_t size, int protection, int flags, int file, off_t offset)
{
    return file > 2 && fails("map") ? MAP_FAILED
                                    : NEXT(mmap)(at, size, protection, flags, file, offset);
}

int fsync(int file)
{
    return fails("sync") ? -1 : NEXT(fsync)(file);
}

int fdatasync(int file)
{
    return fails("sync") ? -1 : NEXT(fdatasync)(file);
}

int rename(const char* from, const char* to)
{
    return fails("rename") ? -1 : NEXT(rename)(from, to);
}

int ftruncate(int file, off_t size)
{
    return fails("size") ? -1 : NEXT(ftruncate)(file, size);
}

int posix_fallocate(int file, off_t offset, off_t size)
{
    return fails("size") ? errno : NEXT(posix_fallocate)(file, offset, size);
}

int mkdir(const char* path, mode_t mode)
{
    return fails("folder") ? -1 : NEXT(mkdir)(path, mode);
}

int unlink(const char* path)
{
    return fails("remove") ? -1 : NEXT(unlink)(path);
}

int unlinkat(int folder, const char* path, int flags)
{
    return fails("remove") ? -1 : NEXT(unlinkat)(folder, path, flags);
}

int close(int file)
{
    if (is_file(file) && fails("close")) {
        int error = errno;
        (void)NEXT(close)(file); // closed, and yet an error
        errno = error;
        return -1;
    }
    return NEXT(close)(file);
}

// Programs with 64-bit offsets call these.
#define ALIAS(name) __attribute__((alias(name)))
ssize_t pread64(int file, void* bytes, size_t size, off64_t offset) ALIAS("pread");
ssize_t pwrite64(int file, const void* bytes, size_t size, off64_t offset) ALIAS("pwrite");
int open64(const char* path, int flags, ...) ALIAS("open");
int openat64(int folder, const char* path, int flags, ...) ALIAS("openat");
void* mmap64(void* at, size_t size, int protection, int flags, int file, off64_t offset)
    ALIAS("mmap");
int ftruncate64(int file, off64_t size) ALIAS("ftruncate");
int posix_fallocate64(int file, off64_t offset, off64_t size) ALIAS("posix_fallocate");
