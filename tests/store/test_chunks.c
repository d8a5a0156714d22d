// SPDX-License-Identifier: MIT
// Octaves in chunks: where they are cut, that each decodes alone, and that forged ones are
// rejected.
#include "exhaustive.h"
#include "support_chunks.h"
#include "support_reseal.h"
#include "support_sample.h"
#include "tests.h"

#include "store/bytes/chunks.h"
#include "store/file/block_table.h"
#include "store/sets/sets_internal.h"

#include <string.h>
#include <unistd.h>

static uint64_t cost(uint32_t i, const stp_store_octave_span* span)
{
    uint64_t each = span->encoding == STP_STORE_ENCODING_LIT ? 7 : 4;
    return each * i + (i > span->first ? 9 * (uint64_t)(i - span->first) : 0);
}

/// Whether chunks follow each other, and no further splat fits into any.
static bool are_full(const stp_store_octave_span* span)
{
    uint32_t begin = 0, chunk = 0;
    for (; begin < span->end; ++chunk) {
        uint32_t end = stp_store_chunk_end(span, chunk);
        uint64_t size = cost(end, span) - cost(begin, span);
        stp_store_column columns[STP_STORE_COLUMN_LIMIT];
        if (end <= begin || end > span->end || size > STP_STORE_CHUNK_BYTES ||
            (end < span->end && cost(end + 1, span) - cost(begin, span) <= STP_STORE_CHUNK_BYTES) ||
            stp_store_chunk_columns(span, chunk, columns) != size) {
            return false;
        }
        begin = end;
    }
    return chunk == stp_store_chunk_count(span);
}

void test_chunks_hold_as_many_splats_as_64_kib_do(test_state* test)
{
    static const uint32_t firsts[] = {0,     1,     2,     700,   5041,  9362,  9363,   16383,
                                      16384, 16385, 20000, 32767, 32768, 60000, 100000, 131072};
    static const uint32_t counts[] = {1, 2, 5040, 5041, 5042, 10082, 10083, 40000};
    for (size_t i = 0; i < sizeof(firsts) / sizeof(firsts[0]); ++i) {
        for (size_t k = 0; k < sizeof(counts) / sizeof(counts[0]); ++k) {
            stp_store_octave_span span = {.first = firsts[i],
                                          .end = firsts[i] + counts[k],
                                          .encoding = STP_STORE_ENCODING_CHUNKS};
            CHECK(are_full(&span));
            span.encoding = STP_STORE_ENCODING_LIT;
            CHECK(are_full(&span));
        }
    }
}

static stp_result write_file(stp_context* context, const stp_store_content* content,
                             unsigned char** bytes, size_t* size)
{
    char path[256];
    const char* folder = getenv("TMPDIR");
    snprintf(path, sizeof(path), "%s/stp_chunks_%ld.stip", folder != NULL ? folder : "/tmp",
             (long)getpid());
    stp_result result = stp_store_write(context, content, path);
    *bytes = result == STP_OK ? sample_read_file(path, size) : NULL;
    unlink(path);
    return result;
}

static stp_result open_bytes(stp_context* context, const unsigned char* bytes, size_t size,
                             stp_store** store)
{
    return stp_store_open_memory(context, "chunks", bytes, size, &(stp_store_open_desc){0}, store);
}

static void bring_back(test_state* test, uint64_t seed, uint32_t minor)
{
    stp_context* context = test_context(NULL, 3, NULL);
    CHECK(context != NULL);
    stp_arena arena = stp_arena_create(context, 1 << 20);
    chunk_sample made;
    CHECK(chunk_sample_make(&arena, seed, &made));
    unsigned char* bytes = NULL;
    size_t size = 0;
    stp_store* store = NULL;
    CHECK_EQUAL(STP_OK, write_file(context, &made.content, &bytes, &size));
    CHECK_EQUAL(STP_OK, open_bytes(context, bytes, size, &store));
    for (uint32_t i = 0; i < made.content.directory.set_count; ++i) {
        stp_splats got;
        CHECK_EQUAL(STP_OK, stp_store_get_splat_set(store, i, &got));
        CHECK(chunk_sample_is_same(&made.sets[i], &got));
    }
    stp_store_check_report report;
    CHECK_EQUAL(STP_OK, stp_store_check_open(store, false, &report));
    CHECK_EQUAL(size, report.bytes_checked);
    CHECK_EQUAL(minor, stp_store_format_minor(store));
    stp_store_close(store);
    free(bytes);
    stp_arena_destroy(&arena);
    stp_context_destroy(context);
}

void test_chunks_bring_back_what_was_written(test_state* test)
{
    bring_back(test, 1, STP_STORE_MINOR);
    bring_back(test, 2, STP_STORE_MINOR_LIT);
}

void test_chunks_are_the_same_bytes_for_any_number_of_threads(test_state* test)
{
    unsigned char* bytes[2] = {NULL, NULL};
    size_t sizes[2] = {0, 0};
    for (uint32_t i = 0; i < 2; ++i) {
        stp_context* context = test_context(NULL, i == 0 ? 1 : 4, NULL);
        CHECK(context != NULL);
        stp_arena arena = stp_arena_create(context, 1 << 20);
        chunk_sample made;
        CHECK(chunk_sample_make(&arena, 2, &made));
        CHECK_EQUAL(STP_OK, write_file(context, &made.content, &bytes[i], &sizes[i]));
        stp_arena_destroy(&arena);
        stp_context_destroy(context);
    }
    CHECK_EQUAL(sizes[0], sizes[1]);
    CHECK(memcmp(bytes[0], bytes[1], sizes[0]) == 0);
    free(bytes[0]);
    free(bytes[1]);
}

/// Reads each chunk of an octave alone, into separate columns, and joins them.
static bool read_one_by_one(stp_store* store, const stp_splats* wanted, uint32_t octave)
{
    const stp_store_block* block = stp_store_octave_block(store, 0, octave);
    stp_store_octave_span span = stp_store_span_of(wanted, octave, block->encoding);
    stp_store_block_source source = {.block = block, .read = stp_store_read_mapped, .user = store};
    stp_store_column columns[STP_STORE_COLUMN_LIMIT];
    stp_store_octave_columns(wanted, octave, columns);
    void *targets[STP_OCTAVE_COLUMNS], *truth[STP_OCTAVE_COLUMNS];
    stp_store_octave_targets(wanted, octave, truth);
    bool same = true;
    for (int i = 0; i < STP_OCTAVE_COLUMNS; ++i) {
        targets[i] = calloc(1, (size_t)columns[i].size + 1);
    }
    for (uint32_t chunk = stp_store_chunk_count(&span); chunk-- > 0;) {
        uint64_t read_bytes = 0;
        const char* fault =
            stp_store_read_chunks(&source, &span, chunk, chunk + 1, targets, &read_bytes);
        same = same && fault == NULL && read_bytes <= STP_STORE_CHUNK_BYTES + 4096;
    }
    for (int i = 0; i < STP_OCTAVE_COLUMNS; ++i) {
        same = same &&
               (columns[i].size == 0 || memcmp(targets[i], truth[i], (size_t)columns[i].size) == 0);
        free(targets[i]);
    }
    return same;
}

static void decode_alone(test_state* test, uint64_t seed)
{
    stp_context* context = test_context(NULL, 1, NULL);
    CHECK(context != NULL);
    stp_arena arena = stp_arena_create(context, 1 << 20);
    chunk_sample made;
    CHECK(chunk_sample_make(&arena, seed, &made));
    unsigned char* bytes = NULL;
    size_t size = 0;
    stp_store* store = NULL;
    CHECK_EQUAL(STP_OK, write_file(context, &made.content, &bytes, &size));
    CHECK_EQUAL(STP_OK, open_bytes(context, bytes, size, &store));
    for (uint32_t k = 0; k < made.sets[0].octave_count; ++k) {
        CHECK(read_one_by_one(store, &made.sets[0], k));
    }
    stp_store_close(store);
    free(bytes);
    stp_arena_destroy(&arena);
    stp_context_destroy(context);
}

void test_chunks_decode_alone(test_state* test)
{
    decode_alone(test, 3);
    decode_alone(test, 2);
}

// Uniform content could compress a thousandfold. It is stored in at least 1/32 of its size, so that
// a small file cannot demand much memory.
void test_chunks_never_stand_for_much_more_than_they_take(test_state* test)
{
    static unsigned char zeros[STP_STORE_CHUNK_BYTES], stored[STP_STORE_CHUNK_BYTES];
    stp_store_packer* packer = stp_store_packer_create();
    CHECK(packer != NULL);
    for (size_t size = 13; size <= sizeof(zeros); size += 991) {
        size_t packed = stp_store_pack(packer, zeros, size, stored);
        CHECK(packed >= size / STP_STORE_CHUNK_RATIO && packed <= size);
        CHECK_EQUAL(size, stp_store_pack(NULL, zeros, size, stored));
    }
    stp_store_packer_destroy(packer);
    stp_context* context = test_context(NULL, 1, NULL);
    CHECK(context != NULL);
    stp_arena arena = stp_arena_create(context, 1 << 20);
    chunk_sample made;
    CHECK(chunk_sample_make(&arena, 0, &made)); // uniform
    unsigned char* bytes = NULL;
    size_t size = 0;
    stp_store* store = NULL;
    CHECK_EQUAL(STP_OK, write_file(context, &made.content, &bytes, &size));
    CHECK_EQUAL(STP_OK, open_bytes(context, bytes, size, &store));
    stp_splats got;
    CHECK_EQUAL(STP_OK, stp_store_get_splat_set(store, 0, &got));
    CHECK(chunk_sample_is_same(&made.sets[0], &got));
    CHECK(stp_store_columns_bytes(&made.sets[0], made.sets[0].octave_count) <
          (STP_STORE_CHUNK_RATIO + 1) * (uint64_t)size);
    stp_store_close(store);
    free(bytes);
    stp_arena_destroy(&arena);
    stp_context_destroy(context);
}

// Changes bytes of blocks and reseals the checksums. In all cases nothing is accessed out
// of bounds, and no content of another size is accepted.
void test_forged_chunks_are_refused(test_state* test)
{
    test_log log = {.errors = 0};
    stp_context* context = test_context(NULL, 1, &log);
    CHECK(context != NULL);
    stp_arena arena = stp_arena_create(context, 1 << 20);
    chunk_sample made;
    CHECK(chunk_sample_make(&arena, 4, &made));
    unsigned char* bytes = NULL;
    size_t size = 0;
    CHECK_EQUAL(STP_OK, write_file(context, &made.content, &bytes, &size));
    size_t data = (size_t)stp_read_u64(bytes + 24);
    uint32_t refused = 0, tried = 0;
    unsigned char* copy = NULL;
    CHECK(posix_memalign((void**)&copy, 64, size) == 0);
    for (size_t at = data; at < size; at += at < data + 4096 ? 11 : 1 + size / 97) {
        size_t stride = test_stride(8);
        for (size_t bit = stride == 1 ? 0 : tried % 8; bit < 8; bit += stride) {
            memcpy(copy, bytes, size);
            copy[at] ^= (unsigned char)(1u << bit);
            reseal(copy, size);
            stp_store* store = NULL;
            stp_splats got;
            stp_result result = open_bytes(context, copy, size, &store);
            for (uint32_t i = 0; result == STP_OK && i < made.content.directory.set_count; ++i) {
                result = stp_store_get_splat_set(store, i, &got);
            }
            tried += 1;
            refused += result != STP_OK ? 1 : 0;
            CHECK(result == STP_OK || result == STP_ERROR_FORMAT);
            stp_store_close(store);
        }
    }
    CHECK(tried > 100 && refused > tried / 20);
    free(copy);
    free(bytes);
    stp_arena_destroy(&arena);
    stp_context_destroy(context);
}
