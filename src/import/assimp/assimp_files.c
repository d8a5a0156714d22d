// SPDX-License-Identifier: MIT
#include "import/assimp/assimp_files.h"

#include "import/reading/path_rules.h"

#include <assert.h>
#include <errno.h>
#include <fcntl.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <unistd.h>

typedef struct open_file {
    struct aiFile calls;
    const unsigned char* bytes;
    size_t size, at;
    int descriptor; ///< -1: `bytes` are the file's
} open_file;

static open_file* file_of(struct aiFile* file)
{
    return (open_file*)(void*)file->UserData;
}

static size_t read_file(struct aiFile* file, char* out, size_t size, size_t count)
{
    open_file* f = file_of(file);
    size_t left = f->at < f->size ? f->size - f->at : 0;
    if (size == 0 || count == 0) {
        return 0;
    }
    size_t whole = left / size < count ? left / size : count, done = 0;
    while (f->descriptor >= 0 && done < whole * size) {
        ssize_t got = pread(f->descriptor, out + done, whole * size - done, (off_t)(f->at + done));
        if (got == 0 || (got < 0 && errno != EINTR)) {
            break; // the file was shortened
        }
        done += got > 0 ? (size_t)got : 0;
    }
    if (f->descriptor < 0) {
        done = whole * size;
        memcpy(out, f->bytes + f->at, done);
    }
    f->at += done;
    assert(done <= whole * size && f->at <= f->size);
    return done / size;
}

static size_t write_file(struct aiFile* file, const char* in, size_t size, size_t count)
{
    (void)file, (void)in, (void)size, (void)count;
    return 0;
}

static size_t tell(struct aiFile* file)
{
    return file_of(file)->at;
}

static size_t size_of(struct aiFile* file)
{
    return file_of(file)->size;
}

static enum aiReturn seek(struct aiFile* file, size_t offset, enum aiOrigin origin)
{
    open_file* f = file_of(file);
    size_t from = origin == aiOrigin_SET ? 0 : origin == aiOrigin_CUR ? f->at : f->size;
    size_t to = from + offset; // offsets from the end are negative, modulo 2^64
    if (to > f->size) {
        return aiReturn_FAILURE;
    }
    assert(f->at <= f->size);
    f->at = to;
    return aiReturn_SUCCESS;
}

static void flush_file(struct aiFile* file)
{
    (void)file;
}

static struct aiFile* make_file(const unsigned char* bytes, size_t size, int descriptor)
{
    open_file* f = calloc(1, sizeof(*f));
    if (f == NULL) {
        return NULL;
    }
    *f = (open_file){.calls = {.ReadProc = read_file,
                               .WriteProc = write_file,
                               .TellProc = tell,
                               .FileSizeProc = size_of,
                               .SeekProc = seek,
                               .FlushProc = flush_file,
                               .UserData = (aiUserData)(void*)f},
                     .bytes = bytes,
                     .size = size,
                     .descriptor = descriptor};
    return &f->calls;
}

static void note_refusal(stp_assimp_files* files, const char* reference, const char* reason)
{
    if (files->refused == 0) {
        snprintf(files->first, sizeof(files->first), "%s", reference);
        files->reason = reason;
        files->refused = 1;
    } else if (strncmp(files->first, reference, sizeof(files->first) - 1) != 0) {
        files->refused = 2; // readers open the same file repeatedly
    }
}

// Extends the time for a file, once. Holes of sparse files do not count.
static void extend_time(stp_assimp_files* files, const struct stat* status)
{
    uint64_t stored = (uint64_t)status->st_blocks * 512, size = (uint64_t)status->st_size;
    uint64_t which = (uint64_t)status->st_ino ^ (uint64_t)status->st_dev << 40;
    assert(files->opened_count <= STP_ASSIMP_OPENED);
    for (unsigned i = 0; i < files->opened_count; ++i) {
        if (files->opened[i] == which) {
            return;
        }
    }
    struct rlimit limits;
    if (files->opened_count < STP_ASSIMP_OPENED && getrlimit(RLIMIT_CPU, &limits) == 0) {
        files->opened[files->opened_count++] = which;
        rlim_t more =
            limits.rlim_cur + (rlim_t)stp_assimp_seconds_for(stored < size ? stored : size);
        limits.rlim_cur = more < limits.rlim_max ? more : limits.rlim_max;
        (void)setrlimit(RLIMIT_CPU, &limits);
    }
}

// Opens a regular file without blocking on pipes and the like.
static struct aiFile* open_regular(stp_assimp_files* files, const char* path)
{
    int descriptor = open(path, O_RDONLY | O_CLOEXEC | O_NONBLOCK | O_NOCTTY);
    struct stat status;
    if (descriptor < 0) {
        return NULL;
    }
    struct aiFile* file = NULL;
    if (fstat(descriptor, &status) == 0 && S_ISREG(status.st_mode)) {
        file = make_file(NULL, (size_t)status.st_size, descriptor);
        extend_time(files, &status);
    }
    if (file == NULL) {
        close(descriptor);
    }
    return file;
}

// Paths requested by assimp are mostly the model's folder joined with a reference.
static const char* strip_folder(const char* model, const char* path)
{
    const char* slash = strrchr(model, '/');
    size_t length = slash != NULL ? (size_t)(slash + 1 - model) : 0;
    if (strncmp(path, model, length) != 0) {
        return path;
    }
    path += length;
    while (length > 0 && (*path == '/' || *path == '\\')) {
        path += 1;
    }
    return path;
}

static struct aiFile* open_asked(struct aiFileIO* io, const char* path, const char* mode)
{
    stp_assimp_files* files = (stp_assimp_files*)(void*)io->UserData;
    if (mode[0] != 'r' || strchr(mode, '+') != NULL) {
        return NULL;
    }
    if (strcmp(path, files->path) == 0) {
        return make_file(files->bytes, files->size, -1);
    }
    const char* reference = strip_folder(files->path, path);
    char* resolved = malloc(strlen(files->path) + strlen(reference) + 2);
    if (resolved == NULL) {
        return NULL;
    }
    const char* reason = files->alone ? "the model was read from memory"
                                      : stp_path_resolve(files->path, reference, resolved);
    struct aiFile* file = reason == NULL ? open_regular(files, resolved) : NULL;
    struct stat status;
    if (reason != NULL && !files->alone && stat(path, &status) == 0) {
        note_refusal(files, reference, reason);
    }
    free(resolved);
    return file;
}

static void close_file(struct aiFileIO* io, struct aiFile* file)
{
    (void)io;
    open_file* f = file_of(file);
    if (f->descriptor >= 0) {
        close(f->descriptor);
    }
    free(f);
}

void stp_assimp_files_begin(stp_assimp_files* files, const char* path, const unsigned char* bytes,
                            size_t size, bool alone)
{
    *files = (stp_assimp_files){.io = {.OpenProc = open_asked,
                                       .CloseProc = close_file,
                                       .UserData = (aiUserData)(void*)files},
                                .path = path,
                                .bytes = bytes,
                                .size = size,
                                .alone = alone};
}
