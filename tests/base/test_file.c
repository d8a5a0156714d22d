// SPDX-License-Identifier: MIT
#include "tests.h"

#include "base/io/file.h"

#include <fcntl.h>
#include <signal.h>
#include <stdio.h>
#include <string.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

typedef struct folder {
    char path[64];
} folder;

static bool make_folder(folder* f)
{
    snprintf(f->path, sizeof(f->path), "stp_file_XXXXXX");
    return mkdtemp(f->path) != NULL;
}

static void path_in(const folder* f, const char* name, char out[128])
{
    snprintf(out, 128, "%s/%s", f->path, name);
}

// Number of entries in a folder besides "." and "..". A link count does not count files, so this
// uses the shell's glob.
static int count_entries(const folder* f)
{
    char command[128];
    snprintf(command, sizeof(command), "ls -A %s | wc -l", f->path);
    FILE* pipe = popen(command, "r");
    int count = -1;
    if (pipe == NULL || fscanf(pipe, "%d", &count) != 1) {
        count = -1;
    }
    if (pipe != NULL) {
        pclose(pipe);
    }
    return count;
}

static bool write_text(stp_context* context, const char* path, const char* text)
{
    stp_file_writer* writer = NULL;
    if (stp_file_writer_open(context, path, &writer) != STP_OK) {
        return false;
    }
    if (stp_file_writer_append(writer, text, strlen(text)) != STP_OK) {
        stp_file_writer_abort(writer);
        return false;
    }
    return stp_file_writer_commit(writer) == STP_OK;
}

static bool holds_text(stp_context* context, const char* path, const char* text)
{
    stp_mapped_file file;
    if (stp_file_map(context, path, &file) != STP_OK) {
        return false;
    }
    bool same = file.size == strlen(text) && memcmp(file.bytes, text, file.size) == 0;
    stp_file_unmap(&file);
    return same;
}

void test_file_map_refuses_non_files(test_state* test)
{
    test_log log = {0};
    stp_context* context = test_context(NULL, 1, &log);
    folder f;
    CHECK(context != NULL && make_folder(&f));
    char path[128];
    stp_mapped_file file;
    path_in(&f, "missing", path);
    CHECK_EQUAL(STP_ERROR_IO, stp_file_map(context, path, &file));
    CHECK(strstr(log.text, path) == log.text); // the message begins with the path
    CHECK_EQUAL(STP_ERROR_IO, stp_file_map(context, f.path, &file));
    path_in(&f, "pipe", path);
    CHECK(mkfifo(path, 0600) == 0);
    CHECK_EQUAL(STP_ERROR_IO, stp_file_map(context, path, &file)); // and does not wait for a writer
    CHECK_EQUAL(STP_ERROR_IO, stp_file_map(context, "/dev/zero", &file));
    CHECK_EQUAL(4, log.errors);
    CHECK(file.bytes == NULL && file.size == 0);
    unlink(path);
    path_in(&f, "empty", path);
    CHECK(write_text(context, path, ""));
    CHECK_EQUAL(STP_OK, stp_file_map(context, path, &file));
    CHECK(file.bytes == NULL && file.size == 0);
    stp_file_unmap(&file);
    unlink(path);
    rmdir(f.path);
    stp_context_destroy(context);
}

/// Bytes of mapped files in this process's memory; 0 if the system does not report them.
static uint64_t resident_file_bytes(void)
{
    FILE* file = fopen("/proc/self/statm", "r");
    unsigned long long all = 0, resident = 0, shared = 0;
    bool found = file != NULL && fscanf(file, "%llu %llu %llu", &all, &resident, &shared) == 3;
    if (file != NULL) {
        fclose(file);
    }
    return found ? (uint64_t)shared * (uint64_t)sysconf(_SC_PAGESIZE) : 0;
}

static uint64_t sum_bytes(const stp_mapped_file* file)
{
    uint64_t sum = 0;
    for (size_t i = 0; i < file->size; ++i) {
        sum += file->bytes[i] * (uint64_t)(i + 1);
    }
    return sum;
}

void test_file_forgotten_can_be_read_again(test_state* test)
{
    enum { SIZE = 8 << 20 };
    stp_context* context = test_context(NULL, 1, NULL);
    folder f;
    CHECK(context != NULL && make_folder(&f));
    char path[128];
    path_in(&f, "large", path);
    unsigned char* bytes = malloc(SIZE);
    CHECK(bytes != NULL);
    for (uint32_t i = 0; i < SIZE; ++i) {
        bytes[i] = (unsigned char)(i * 2654435761u >> 24);
    }
    stp_file_writer* writer = NULL;
    CHECK_EQUAL(STP_OK, stp_file_writer_open(context, path, &writer));
    CHECK_EQUAL(STP_OK, stp_file_writer_append(writer, bytes, SIZE));
    CHECK_EQUAL(STP_OK, stp_file_writer_commit(writer));
    stp_mapped_file whole = {.bytes = bytes, .size = SIZE}, file, none = {0};
    uint64_t wanted = sum_bytes(&whole);
    CHECK_EQUAL(STP_OK, stp_file_map(context, path, &file));
    CHECK_EQUAL(wanted, sum_bytes(&file));
    uint64_t before = resident_file_bytes();
    stp_file_evict(&file);
    stp_file_evict(&none);
    uint64_t after = resident_file_bytes();
    CHECK(before == 0 || after + SIZE / 2 < before);
    CHECK_EQUAL(wanted, sum_bytes(&file));
    stp_file_unmap(&file);
    free(bytes);
    unlink(path);
    rmdir(f.path);
    stp_context_destroy(context);
}

void test_file_writer_appends_and_patches(test_state* test)
{
    stp_context* context = test_context(NULL, 1, NULL);
    folder f;
    CHECK(context != NULL && make_folder(&f));
    char path[128];
    path_in(&f, "out.bin", path);
    enum { SIZE = 3500000 }; // exceeds the buffer; writes are smaller and larger
    unsigned char* expected = malloc(SIZE);
    CHECK(expected != NULL);
    for (size_t i = 0; i < SIZE; ++i) {
        expected[i] = (unsigned char)(i * 31 >> 3);
    }
    stp_file_writer* writer = NULL;
    CHECK_EQUAL(STP_OK, stp_file_writer_open(context, path, &writer));
    static const size_t sizes[] = {1, 0, 1000, 1048576, 1, 1048577, 300000, 1048575};
    size_t at = 0;
    for (size_t i = 0; at < SIZE; ++i) {
        size_t size = sizes[i % 8] < SIZE - at ? sizes[i % 8] : SIZE - at;
        CHECK_EQUAL(STP_OK, stp_file_writer_append(writer, expected + at, size));
        at += size;
        CHECK_EQUAL(at, stp_file_writer_size(writer));
    }
    memset(expected + 5, 0xab, 20);
    memset(expected + SIZE - 7, 0xcd, 7);
    CHECK_EQUAL(STP_OK, stp_file_writer_patch(writer, 5, expected + 5, 20));
    CHECK_EQUAL(STP_OK, stp_file_writer_patch(writer, SIZE - 7, expected + SIZE - 7, 7));
    CHECK(access(path, F_OK) != 0); // nothing has the final name yet
    CHECK_EQUAL(STP_OK, stp_file_writer_commit(writer));
    CHECK_EQUAL(1, count_entries(&f));
    stp_mapped_file file;
    CHECK_EQUAL(STP_OK, stp_file_map(context, path, &file));
    CHECK_EQUAL(SIZE, file.size);
    CHECK(memcmp(file.bytes, expected, SIZE) == 0);
    stp_file_unmap(&file);
    free(expected);
    unlink(path);
    rmdir(f.path);
    stp_context_destroy(context);
}

void test_file_writer_abort_keeps_the_previous_file(test_state* test)
{
    stp_context* context = test_context(NULL, 1, NULL);
    folder f;
    CHECK(context != NULL && make_folder(&f));
    char path[128];
    path_in(&f, "out.bin", path);
    CHECK(write_text(context, path, "previous"));
    stp_file_writer* writer = NULL;
    CHECK_EQUAL(STP_OK, stp_file_writer_open(context, path, &writer));
    CHECK_EQUAL(STP_OK, stp_file_writer_append(writer, "new", 3));
    stp_file_writer_abort(writer);
    stp_file_writer_abort(NULL);
    CHECK(holds_text(context, path, "previous"));
    CHECK_EQUAL(1, count_entries(&f));
    CHECK(write_text(context, path, "newer"));
    CHECK(holds_text(context, path, "newer"));
    unlink(path);
    rmdir(f.path);
    stp_context_destroy(context);
}

void test_two_writers_of_one_path_do_not_mix(test_state* test)
{
    stp_context* context = test_context(NULL, 1, NULL);
    folder f;
    CHECK(context != NULL && make_folder(&f));
    char path[128];
    path_in(&f, "out.bin", path);
    stp_file_writer *first = NULL, *second = NULL;
    CHECK_EQUAL(STP_OK, stp_file_writer_open(context, path, &first));
    CHECK_EQUAL(STP_OK, stp_file_writer_open(context, path, &second));
    CHECK_EQUAL(STP_OK, stp_file_writer_append(first, "first, and longer", 17));
    CHECK_EQUAL(STP_OK, stp_file_writer_append(second, "second", 6));
    CHECK_EQUAL(STP_OK, stp_file_writer_commit(first));
    CHECK(holds_text(context, path, "first, and longer"));
    CHECK_EQUAL(STP_OK, stp_file_writer_commit(second));
    CHECK(holds_text(context, path, "second"));
    CHECK_EQUAL(1, count_entries(&f));
    unlink(path);
    rmdir(f.path);
    stp_context_destroy(context);
}

void test_file_writer_refuses_bad_targets(test_state* test)
{
    test_log log = {0};
    stp_context* context = test_context(NULL, 1, &log);
    folder f;
    CHECK(context != NULL && make_folder(&f));
    char path[128];
    stp_file_writer* writer = NULL;
    path_in(&f, "no/such/folder.bin", path);
    CHECK_EQUAL(STP_ERROR_IO, stp_file_writer_open(context, path, &writer));
    CHECK_EQUAL(1, log.errors);
    // a folder or a device is refused before any work is done, and never replaced
    CHECK_EQUAL(STP_ERROR_IO, stp_file_writer_open(context, f.path, &writer));
    CHECK_EQUAL(STP_ERROR_IO, stp_file_writer_open(context, "/dev/null", &writer));
    CHECK_EQUAL(3, log.errors);
    CHECK_EQUAL(STP_ERROR_IO, stp_file_writer_open(context, "", &writer));
    CHECK_EQUAL(4, log.errors);
    path_in(&f, "link", path);
    CHECK_EQUAL(0, symlink("nothing", path));
    CHECK_EQUAL(STP_ERROR_IO, stp_file_writer_open(context, path, &writer));
    CHECK_EQUAL(5, log.errors);
    CHECK_EQUAL(1, count_entries(&f));
    unlink(path);
    rmdir(f.path);
    stp_context_destroy(context);
}

// Like /dev/stdout: the link stays, and its target is written.
void test_file_writer_follows_links(test_state* test)
{
    stp_context* context = test_context(NULL, 1, NULL);
    folder f;
    CHECK(context != NULL && make_folder(&f));
    char path[128], link[128];
    path_in(&f, "file", path);
    path_in(&f, "link", link);
    CHECK(write_text(context, path, "before"));
    CHECK_EQUAL(0, symlink("file", link));
    CHECK(write_text(context, link, "after"));
    struct stat status;
    CHECK(lstat(link, &status) == 0 && S_ISLNK(status.st_mode));
    CHECK(holds_text(context, path, "after"));
    CHECK_EQUAL(2, count_entries(&f));
    unlink(link);
    unlink(path);
    rmdir(f.path);
    stp_context_destroy(context);
}

void test_file_remove_stale_removes_files_of_dead_writers(test_state* test)
{
    stp_context* context = test_context(NULL, 1, NULL);
    folder f;
    CHECK(context != NULL && make_folder(&f));
    char path[128], name[128], text[64];
    path_in(&f, "out.bin", path);
    pid_t child = fork();
    CHECK(child >= 0);
    if (child == 0) {
        stp_file_writer* writer = NULL;
        stp_result result = stp_file_writer_open(context, path, &writer);
        raise(SIGKILL);
        _exit(result == STP_OK);
    }
    CHECK(waitpid(child, NULL, 0) == child);
    CHECK_EQUAL(1, count_entries(&f));
    snprintf(text, sizeof(text), "out.bin.tmp-%ld-0", (long)child);
    path_in(&f, text, name);
    CHECK(access(name, F_OK) == 0);
    static const char* const others[] = {"%s/out.bin.tmp-%ld-", "%s/out.bin.tmp-%ld-0x",
                                         "%s/other.bin.tmp-%ld-0", "%s/out.bin.tmp-%ld",
                                         "%s/out.bin.tmp-0%ld-0"};
    for (int i = 0; i < 5; ++i) {
        snprintf(name, sizeof(name), others[i], f.path, (long)child);
        CHECK(write_text(context, name, "another file"));
    }
    stp_file_writer* writer = NULL; // its temporary file belongs to a living process
    CHECK_EQUAL(STP_OK, stp_file_writer_open(context, path, &writer));
    CHECK_EQUAL(7, count_entries(&f));
    stp_file_remove_stale(context, path);
    CHECK_EQUAL(6, count_entries(&f));
    CHECK_EQUAL(STP_OK, stp_file_writer_commit(writer));
    for (int i = 0; i < 5; ++i) {
        snprintf(name, sizeof(name), others[i], f.path, (long)child);
        CHECK_EQUAL(0, unlink(name));
    }
    unlink(path);
    CHECK_EQUAL(0, rmdir(f.path));
    stp_context_destroy(context);
}

// Runs in a child whose files are limited to 2 MB, like a full disk. Exit code 0: as specified.
static int write_beyond_limit(const char* path)
{
    signal(SIGXFSZ, SIG_IGN);
    struct rlimit limit = {.rlim_cur = 2000000, .rlim_max = 2000000};
    test_log log = {0};
    stp_context* context = test_context(NULL, 1, &log);
    if (context == NULL || setrlimit(RLIMIT_FSIZE, &limit) != 0) {
        return 2;
    }
    static unsigned char bytes[700000];
    stp_file_writer* writer = NULL;
    if (stp_file_writer_open(context, path, &writer) != STP_OK) {
        return 3;
    }
    stp_result result = STP_OK;
    for (int i = 0; result == STP_OK && i < 6; ++i) {
        result = stp_file_writer_append(writer, bytes, sizeof(bytes));
    }
    if (result != STP_ERROR_IO || log.errors != 1) {
        return 4;
    }
    stp_file_writer_abort(writer);
    // same if only the last flush, at commit, hits the limit
    if (stp_file_writer_open(context, path, &writer) != STP_OK ||
        stp_file_writer_append(writer, bytes, sizeof(bytes)) != STP_OK ||
        stp_file_writer_append(writer, bytes, sizeof(bytes)) != STP_OK ||
        stp_file_writer_append(writer, bytes, sizeof(bytes)) != STP_OK) {
        return 5;
    }
    if (stp_file_writer_commit(writer) != STP_ERROR_IO || log.errors != 2) {
        return 6;
    }
    stp_context_destroy(context);
    return 0;
}

void test_full_disk_leaves_the_previous_file(test_state* test)
{
    stp_context* context = test_context(NULL, 1, NULL);
    folder f;
    CHECK(context != NULL && make_folder(&f));
    char path[128];
    path_in(&f, "out.bin", path);
    CHECK(write_text(context, path, "previous"));
    pid_t child = fork();
    CHECK(child >= 0);
    if (child == 0) {
        _exit(write_beyond_limit(path));
    }
    int status = 0;
    CHECK(waitpid(child, &status, 0) == child);
    CHECK(WIFEXITED(status));
    CHECK_EQUAL(0, WEXITSTATUS(status));
    CHECK(holds_text(context, path, "previous"));
    CHECK_EQUAL(1, count_entries(&f));
    unlink(path);
    rmdir(f.path);
    stp_context_destroy(context);
}

void test_file_writer_survives_failing_allocator(test_state* test)
{
    folder f;
    CHECK(make_folder(&f));
    char path[128];
    path_in(&f, "out.bin", path);
    bool written = false;
    for (int n = 0; !written && n < 40; ++n) {
        test_heap heap = TEST_HEAP(n);
        stp_context* context = test_context(&heap, 1, NULL);
        if (context != NULL) {
            written = write_text(context, path, "text");
        }
        stp_context_destroy(context);
        CHECK_EQUAL(0, heap.live_bytes);
        CHECK_EQUAL(written, count_entries(&f));
    }
    CHECK(written);
    unlink(path);
    rmdir(f.path);
}
