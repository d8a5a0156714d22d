// SPDX-License-Identifier: MIT
// Arbitrary bytes as a segment of a work folder: entries found can be read, and stored entries
// are found again.
//
// build/fuzz/fuzz/fuzz_work -max_total_time=60 -max_len=4096 build/corpus/fuzz_work
//
// Checksums of headers and results are corrected first, so that mutations get past them.
#include "base/core/context.h"
#include "base/io/bytes.h"
#include "builder/stored_results.h"
#include "builder/work_segment.h"

#include <fcntl.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

enum { HEAD = STP_WORK_HEAD_SIZE, MAX_KEYS = 64, MAX_BYTES = 1 << 16, SEGMENT = 1 << 16 };

int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size);

static const char magic[] = "STPwork\n", mark[] = "STPmade\n";

// Turns bytes into a segment and records its keys. An odd first byte leaves the bytes unchanged.
static size_t forge(unsigned char* bytes, size_t size, stp_hash keys[MAX_KEYS])
{
    size_t key_count = 0;
    if (size < HEAD || bytes[0] % 2 == 1) {
        return 0;
    }
    memcpy(bytes, magic, 8);
    stp_write_u32(bytes + 8, bytes[8] % 8 == 0 ? 2 : STP_WORK_VERSION);
    stp_work_seal_head(bytes);
    for (size_t at = HEAD; at + HEAD <= size && key_count < MAX_KEYS;) {
        unsigned char* head = bytes + at;
        memcpy(head, mark, 8);
        uint64_t wanted = stp_read_u64(head + 24);
        size_t left = size - at - HEAD;
        uint64_t length = head[63] % 8 == 0 ? wanted : wanted % 1024;
        stp_write_u64(head + 24, length);
        if (length <= left && head[62] % 4 != 0) {
            stp_bytes result = {head + HEAD, (size_t)length};
            stp_write_u64(head + 32, stp_checksum(&result, 1));
        }
        keys[key_count++] =
            (stp_hash){.low = stp_read_u64(head + 8), .high = stp_read_u64(head + 16)};
        stp_work_seal_head(head);
        at += HEAD + (length <= left ? ((size_t)length + 63) / 64 * 64 : left);
    }
    return key_count;
}

static uint64_t sum(const void* bytes, size_t size)
{
    return stp_checksum(&(stp_bytes){bytes, size}, 1);
}

static uint64_t use(stp_work* work, stp_hash key)
{
    size_t size;
    const void* bytes = stp_work_find(work, key, &size);
    uint64_t total = bytes != NULL ? sum(bytes, size) : 0;
    stp_splats s;
    stp_coded_mesh mesh;
    uint32_t candidates;
    if (stp_work_find_splat_set(work, key, 5, &s, &candidates)) {
        size_t entries = 0;
        for (uint32_t i = 0; i < s.octave_count; ++i) {
            entries += s.octave_ends[i];
        }
        total += sum(s.positions, 6 * (size_t)s.count) + sum(s.normals, 2 * (size_t)s.count) +
                 sum(s.colors, 3 * entries) + sum(s.coverages, entries);
    } else if (stp_work_find_mesh(work, key, &mesh)) {
        total += sum(mesh.bytes, mesh.size);
    }
    const stp_bytes part = {"anew", 4};
    if (stp_work_store(work, key, &part, 1, &bytes) != STP_OK ||
        stp_work_find(work, key, &size) != bytes || bytes == NULL) {
        abort();
    }
    return total + sum(bytes, size);
}

int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size)
{
    static unsigned char bytes[MAX_BYTES];
    static char folder[64];
    stp_hash keys[MAX_KEYS];
    if (size > MAX_BYTES) {
        return 0;
    }
    memcpy(bytes, data, size);
    size_t key_count = forge(bytes, size, keys);
    snprintf(folder, sizeof(folder), "/dev/shm/stp_fuzz_work_%ld", (long)getpid());
    char path[96];
    snprintf(path, sizeof(path), "%s/segment-000000", folder);
    (void)mkdir(folder, 0777);
    int file = open(path, O_WRONLY | O_CREAT | O_TRUNC, 0666);
    if (file < 0 || write(file, bytes, size) != (ssize_t)size || close(file) != 0) {
        abort();
    }
    stp_context* context;
    stp_context_desc desc = {.thread_count = 1, .memory_limit_bytes = (uint64_t)1 << 26};
    if (stp_context_create(&context, &desc) != STP_OK) {
        abort();
    }
    static volatile uint64_t sink;
    for (int round = 0; round < 2; ++round) {
        stp_work* work = NULL;
        if (stp_work_open_with(context, folder, false, SEGMENT, &work) != STP_OK) {
            abort();
        }
        for (size_t i = 0; i < key_count; ++i) {
            sink = sink + use(work, keys[i]);
        }
        stp_work_close(work, round == 1);
    }
    (void)unlink(path); // if it was taken for another program's
    (void)rmdir(folder);
    stp_context_destroy(context);
    return 0;
}
