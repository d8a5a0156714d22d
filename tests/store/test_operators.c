// SPDX-License-Identifier: MIT
// Progressive sets coded as operators: lossless, any prefix decodes, forged bytes are harmless.
#include "support_expected.h"
#include "support_progressive.h"
#include "support_reader.h"
#include "support_reseal.h"
#include "support_sample.h"
#include "tests.h"

#include "base/math/rng.h"
#include "store/bytes/chunks.h"
#include "store/bytes/operators.h"
#include "store/bytes/range_coder.h"
#include "store/sets/sets_internal.h"

#include <string.h>
#include <unistd.h>

enum { RUN_BYTES = 1 << 17 };

static const progressive_desc samples[] = {
    {.seed = 1, .base = 1, .splits = 0},
    {.seed = 2, .base = 1, .splits = 1},
    {.seed = 3, .base = 5, .splits = 700},
    {.seed = 4, .base = 300, .splits = 400, .coarse = true},
    {.seed = 5, .base = 33, .splits = 500, .wild = true},
};
enum { SAMPLES = sizeof(samples) / sizeof(samples[0]) };

void test_range_coder_round_trip(test_state* test)
{
    static unsigned char bytes[1 << 15];
    for (uint64_t seed = 0; seed < 12; ++seed) {
        stp_range_coder coder;
        stp_bit_model models[4], again[4];
        for (int m = 0; m < 4; ++m) {
            models[m] = again[m] = (stp_bit_model){.zero = STP_BIT_EVEN};
        }
        stp_range_encode_begin(&coder, bytes, sizeof(bytes));
        for (uint64_t i = 0; i < 20000; ++i) { // some bits are rarely 1, some rarely 0
            uint64_t h = stp_rng_hash(seed, i);
            uint32_t bit = (h >> 8) % 1000 < (seed < 4 ? 1 : seed < 8 ? 999 : (h & 3) * 300);
            stp_range_code_bit(&coder, &models[h & 3], bit);
            if (h % 50 == 0) {
                stp_range_code_plain(&coder, 5, (uint32_t)(h >> 32) & 31u);
            }
        }
        size_t size = stp_range_encode_end(&coder);
        CHECK(size > 0 && size < 20000 / 8 + 1000);
        stp_range_decode_begin(&coder, bytes, size);
        for (uint64_t i = 0; i < 20000; ++i) {
            uint64_t h = stp_rng_hash(seed, i);
            uint32_t bit = (h >> 8) % 1000 < (seed < 4 ? 1 : seed < 8 ? 999 : (h & 3) * 300);
            CHECK_EQUAL(bit, stp_range_code_bit(&coder, &again[h & 3], 0));
            if (h % 50 == 0) {
                CHECK_EQUAL((h >> 32) & 31u, stp_range_code_plain(&coder, 5, 0));
            }
        }
        CHECK(stp_range_decode_ends_well(&coder) && coder.at == size);
        stp_range_encode_begin(&coder, bytes, 3); // no room
        CHECK_EQUAL(0, stp_range_encode_end(&coder));
    }
}

/// A set and its decoded part.
typedef struct fixture {
    stp_context* context;
    stp_arena arena;
    stp_splats set, found;
    uint32_t *order, *room, base;
    unsigned char* bytes;
} fixture;

static bool set_up(fixture* f, const progressive_desc* desc, uint32_t forest)
{
    f->context = test_context(NULL, 1, NULL);
    f->arena = stp_arena_create(f->context, 1 << 20);
    bool made = desc != NULL
                    ? progressive_sample_make(&f->arena, desc, &f->set)
                    : progressive_sample_of_forest(&f->arena, f->context, forest, 3, &f->set);
    made = made && progressive_sample_empty(&f->arena, &f->set, &f->found);
    f->order = STP_ARENA_ARRAY(&f->arena, uint32_t, f->set.count);
    f->room = STP_ARENA_ARRAY(&f->arena, uint32_t, f->set.count);
    f->bytes = STP_ARENA_ARRAY(&f->arena, unsigned char, RUN_BYTES);
    if (!made || f->order == NULL || f->room == NULL || f->bytes == NULL) {
        return false;
    }
    stp_progressive_order(f->set.ranges, f->set.count, f->order, f->room);
    f->base = stp_progressive_count(f->set.ranges, f->set.count).base;
    return stp_progressive_is_whole(f->set.ranges, f->set.count, f->order);
}

static void tear_down(fixture* f)
{
    stp_arena_destroy(&f->arena);
    stp_context_destroy(f->context);
}

static size_t encode(const fixture* f, uint32_t begin, uint32_t end, size_t room)
{
    uint32_t base = begin < f->base ? begin : f->base;
    stp_operator_run run = {.set = &f->set, .begin = begin, .end = end, .base = base};
    return stp_operators_encode(&run, f->order + (begin - base) / 2, f->bytes, room);
}

// In runs of any length, consecutively or after known splats.
void test_operators_lose_nothing(test_state* test)
{
    for (size_t n = 0; n <= SAMPLES; ++n) {
        fixture f;
        CHECK(set_up(&f, n < SAMPLES ? &samples[n] : NULL, 900));
        for (uint32_t length = 1; length < 4 * f.set.count; length = 3 * length + 2) {
            stp_operator_reader reader;
            memset(f.found.ranges, 0, 4 * (size_t)f.set.count);
            for (uint32_t begin = 0, end; begin < f.set.count; begin = end) {
                uint64_t h = stp_rng_hash(length, begin);
                end = begin + 1 + (uint32_t)(h % length);
                end = end < f.set.count ? end : f.set.count;
                if (begin == 0 || h >> 63 != 0) {
                    stp_operators_begin(&reader, f.found.ranges, begin, f.room);
                }
                size_t size = encode(&f, begin, end, RUN_BYTES);
                CHECK(size > 0);
                CHECK_EQUAL(0, encode(&f, begin, end, size - 1));
                CHECK_EQUAL(size, encode(&f, begin, end, RUN_BYTES));
                stp_operator_run run = {.set = &f.found, .begin = begin, .end = end};
                if ((h >> 62 & 1) != 0) {
                    CHECK(stp_operators_decode(&run, &reader, f.bytes, size));
                } else { // plain columns
                    memcpy(f.found.ranges + begin, f.set.ranges + begin, 4 * (size_t)(end - begin));
                    stp_operators_skip(&reader, begin, end);
                    stp_splats kept = f.found;
                    f.found = f.set;
                    f.found.ranges = kept.ranges;
                    CHECK(progressive_sample_is_same(&f.set, &f.found, end));
                    f.found = kept;
                    memcpy(f.found.positions, f.set.positions, 6 * (size_t)end);
                    memcpy(f.found.normals, f.set.normals, 2 * (size_t)end);
                    memcpy(f.found.materials, f.set.materials, end);
                    memcpy(f.found.colors, f.set.colors, 3 * (size_t)end);
                    memcpy(f.found.coverages, f.set.coverages, end);
                    memcpy(f.found.shapes, f.set.shapes, 4 * (size_t)end);
                }
                CHECK(progressive_sample_is_same(&f.set, &f.found, end));
            }
        }
        tear_down(&f);
    }
}

// Truncated, extended, or with a flipped bit: no access out of bounds, and accepted data is
// a valid prefix.
void test_damaged_operators_do_no_harm(test_state* test)
{
    fixture f;
    CHECK(set_up(&f, &(progressive_desc){.seed = 9, .base = 3, .splits = 25}, 0));
    size_t size = encode(&f, 0, f.set.count, RUN_BYTES);
    uint32_t refused = 0, tried = 0, same = 0;
    for (size_t at = 0; at < 9 * size; ++at) {
        size_t length = at < 8 * size ? size : at - 8 * size;
        unsigned char* copy =
            malloc(length + 1); // separate memory, so that sanitizers detect reads beyond it
        CHECK(copy != NULL);
        memcpy(copy, f.bytes, length);
        copy[length] = 0;
        if (at < 8 * size) {
            copy[at / 8] ^= (unsigned char)(1u << at % 8);
        }
        stp_operator_reader reader;
        stp_operator_run run = {.set = &f.found, .end = f.set.count};
        memset(f.found.ranges, 0, 4 * (size_t)f.set.count);
        stp_operators_begin(&reader, f.found.ranges, 0, f.room);
        bool taken = stp_operators_decode(&run, &reader, copy, length);
        if (taken && !progressive_sample_is_same(&f.set, &f.found, f.set.count)) {
            uint32_t* order = malloc(8 * (size_t)f.set.count);
            CHECK(order != NULL);
            stp_progressive_order(f.found.ranges, f.set.count, order, order + f.set.count);
            CHECK(stp_progressive_is_valid(f.found.ranges, f.set.count, order));
            free(order);
        } else if (taken) {
            same += 1;
        }
        tried += 1;
        refused += taken ? 0 : 1;
        free(copy);
    }
    CHECK(refused > tried - tried / 50 && same < 16);
    // zero bytes may follow, others must not
    CHECK_EQUAL(size, encode(&f, 0, f.set.count, RUN_BYTES));
    memset(f.bytes + size, 0, 8);
    for (int last = 0; last < 2; ++last) {
        stp_operator_reader reader;
        stp_operator_run run = {.set = &f.found, .end = f.set.count};
        memset(f.found.ranges, 0, 4 * (size_t)f.set.count);
        stp_operators_begin(&reader, f.found.ranges, 0, f.room);
        f.bytes[size + 7] = (unsigned char)last;
        CHECK(stp_operators_decode(&run, &reader, f.bytes, size + 8) == (last == 0));
    }
    tear_down(&f);
}

// The paper's operators take 48 bytes (5). With few splats the models have learned less: 16.3 bytes
// each for 6,000 points, 15.7 for 12,000.
void test_operators_take_less_than_a_third_of_the_papers(test_state* test)
{
    fixture f;
    CHECK(set_up(&f, NULL, 24000));
    size_t bytes = 0;
    uint32_t maximum = STP_STORE_CHUNK_BYTES / 21;
    for (uint32_t begin = 0; begin < f.set.count; begin += maximum) {
        uint32_t end = begin + maximum < f.set.count ? begin + maximum : f.set.count;
        size_t size = encode(&f, begin, end, RUN_BYTES);
        CHECK(size > 0);
        bytes += size;
    }
    uint32_t splits = (f.set.count - f.base) / 2;
    printf("%u operators, %.2f bytes each\n", splits, (double)bytes / (double)splits);
    CHECK(bytes <= 16 * (size_t)splits);
    tear_down(&f);
}

enum { SETS = 3 };

/// A file of progressive sets and its bytes.
typedef struct file_fixture {
    stp_context* context;
    stp_arena arena;
    stp_splats sets[SETS];
    stp_shading shading;
    stp_store_method method;
    stp_store_content content;
    unsigned char* bytes;
    size_t size;
} file_fixture;

static stp_result write_file(stp_context* context, const stp_store_content* content,
                             unsigned char** bytes, size_t* size)
{
    char path[256];
    const char* folder = getenv("TMPDIR");
    snprintf(path, sizeof(path), "%s/stp_operators_%ld.stip", folder != NULL ? folder : "/tmp",
             (long)getpid());
    stp_result result = stp_store_write(context, content, path);
    *bytes = result == STP_OK ? sample_read_file(path, size) : NULL;
    unlink(path);
    return result;
}

static bool make_content(file_fixture* f, stp_context* context, bool small)
{
    static const progressive_desc descs[SETS] = {
        {.seed = 20, .base = 3, .splits = 3000},
        {.seed = 21, .base = 150, .splits = 100, .coarse = true},
        {.seed = 22, .base = 10, .splits = 400, .wild = true},
    };
    static const uint32_t firsts[SETS] = {7, 9, 100};
    *f = (file_fixture){.context = context, .arena = stp_arena_create(context, 1 << 20)};
    for (uint32_t i = 0; i < SETS; ++i) {
        progressive_desc desc = descs[i];
        desc.splits = small ? desc.splits / 20 : desc.splits;
        if (!progressive_sample_make(&f->arena, &desc, &f->sets[i])) {
            return false;
        }
        progressive_sample_octaves(&f->sets[i], firsts[i]);
    }
    f->method = (stp_store_method){
        .name = "psp", .id = STP_METHOD_PSP, .columns = STP_OPERATOR_COLUMNS, .set_count = SETS};
    f->content = (stp_store_content){
        .directory = {.root = STP_STORE_NONE,
                      .shading_count = 1,
                      .shadings = &f->shading,
                      .set_count = SETS,
                      .methods = &f->method,
                      .method_count = 1,
                      .up = 'y'},
        .sets = f->sets,
    };
    return true;
}

static bool file_set_up(file_fixture* f, uint32_t threads, bool small)
{
    stp_context* context = test_context(NULL, threads, NULL);
    return context != NULL && make_content(f, context, small) &&
           write_file(context, &f->content, &f->bytes, &f->size) == STP_OK;
}

static void file_tear_down(file_fixture* f)
{
    free(f->bytes);
    stp_arena_destroy(&f->arena);
    stp_context_destroy(f->context);
}

static stp_result open_bytes(const file_fixture* f, const unsigned char* bytes, size_t size,
                             bool prefix, stp_store** store)
{
    stp_store_open_desc desc = {.accept_partial = prefix};
    return stp_store_open_memory(f->context, "operators", bytes, size, &desc, store);
}

void test_operators_are_read_as_written(test_state* test)
{
    unsigned char* first = NULL;
    for (uint32_t threads = 1; threads <= 3; ++threads) {
        file_fixture f;
        stp_store* store = NULL;
        CHECK(file_set_up(&f, threads, false));
        CHECK_EQUAL(STP_OK, open_bytes(&f, f.bytes, f.size, false, &store));
        for (uint32_t i = 0; i < SETS; ++i) {
            stp_splats got;
            for (uint32_t k = 1; k <= f.sets[i].octave_count;
                 k += 2) { // additional octaves step by step
                CHECK_EQUAL(STP_OK, stp_store_get_splat_set_prefix(store, i, k, &got));
                CHECK_EQUAL(f.sets[i].octave_ends[k - 1], got.count);
                CHECK(progressive_sample_is_same(&f.sets[i], &got, got.count));
            }
            CHECK_EQUAL(STP_OK, stp_store_get_splat_set(store, i, &got));
            CHECK_EQUAL(f.sets[i].count, got.count);
            CHECK(progressive_sample_is_same(&f.sets[i], &got, got.count));
            for (uint32_t k = 0; k < f.sets[i].octave_count; ++k) {
                CHECK_EQUAL(STP_STORE_ENCODING_OPERATORS,
                            stp_store_octave_block(store, i, k)->encoding);
            }
        }
        stp_store_check_report report;
        CHECK_EQUAL(STP_OK, stp_store_check_open(store, false, &report));
        CHECK_EQUAL(f.size, report.bytes_checked);
        stp_store_close(store);
        if (first == NULL) {
            first = malloc(f.size);
            CHECK(first != NULL);
            memcpy(first, f.bytes, f.size);
        }
        CHECK(memcmp(first, f.bytes, f.size) == 0);
        file_tear_down(&f);
    }
    free(first);
}

void test_store_writes_operators_for_another_reader(test_state* test)
{
    const char* name = getenv("STP_STORE_SAMPLE");
    if (name == NULL) {
        SKIP("STP_STORE_SAMPLE is not set");
    }
    stp_context* context = test_context(NULL, 1, NULL);
    char path[512];
    file_fixture f;
    stp_store* store = NULL;
    CHECK(make_content(&f, context, false));
    CHECK(progressive_sample_of_forest(&f.arena, context, 700, 20, &f.sets[0]));
    progressive_sample_octaves(&f.sets[0], 16);
    snprintf(path, sizeof(path), "%s-operators.stip", name);
    CHECK_EQUAL(STP_OK, stp_store_write(context, &f.content, path));
    CHECK_EQUAL(STP_OK, stp_store_open(context, path, &store));
    json_t* expected = sample_expected_json(&f.content, stp_store_get_summary(store));
    stp_store_close(store);
    CHECK(expected != NULL);
    snprintf(path, sizeof(path), "%s-operators.json", name);
    CHECK_EQUAL(0, json_dump_file(expected, path, JSON_INDENT(1) | JSON_REAL_PRECISION(17)));
    json_decref(expected);
    file_tear_down(&f);
}

// A version 1.2 file with operators must open forever. STP_WRITE_GOLDEN writes it and its content.
void test_operators_of_version_1_2_are_still_read(test_state* test)
{
    static const char golden[] = STP_TEST_SOURCE_DIR "/tests/golden/store/v1/operators-1.2";
    stp_context* context = test_context(NULL, 1, NULL);
    file_fixture f;
    stp_store* store = NULL;
    char path[512];
    CHECK(context != NULL && make_content(&f, context, true));
    snprintf(path, sizeof(path), "%s.stip", golden);
    if (getenv("STP_WRITE_GOLDEN") != NULL) {
        CHECK_EQUAL(STP_OK, stp_store_write(context, &f.content, path));
    }
    CHECK_EQUAL(STP_OK, stp_store_open(context, path, &store));
    CHECK_EQUAL(2, stp_store_format_minor(store));
    for (uint32_t i = 0; i < SETS; ++i) {
        stp_splats got;
        CHECK_EQUAL(STP_OK, stp_store_get_splat_set(store, i, &got));
        CHECK_EQUAL(f.sets[i].count, got.count);
        CHECK(progressive_sample_is_same(&f.sets[i], &got, got.count));
        CHECK_EQUAL(STP_STORE_ENCODING_OPERATORS, stp_store_octave_block(store, i, 0)->encoding);
    }
    if (getenv("STP_WRITE_GOLDEN") != NULL) {
        json_t* expected = sample_expected_json(&f.content, stp_store_get_summary(store));
        snprintf(path, sizeof(path), "%s.json", golden);
        CHECK(expected != NULL);
        CHECK_EQUAL(0, json_dump_file(expected, path, JSON_INDENT(1) | JSON_REAL_PRECISION(17)));
        json_decref(expected);
    }
    stp_store_close(store);
    f.bytes = NULL;
    file_tear_down(&f);
}

// A partial file has the first octaves of each set.
void test_operators_of_partial_files_are_prefixes(test_state* test)
{
    file_fixture f;
    CHECK(file_set_up(&f, 1, false));
    size_t data = (size_t)stp_read_u64(f.bytes + 24);
    uint64_t maximum = 0;
    for (size_t size = data; size < f.size; size += 1 + (f.size - data) / 23) {
        stp_store* store = NULL;
        uint64_t splats = 0;
        CHECK_EQUAL(STP_OK, open_bytes(&f, f.bytes, size, true, &store));
        for (uint32_t i = 0; i < SETS; ++i) {
            stp_splats got;
            CHECK_EQUAL(STP_OK, stp_store_get_splat_set(store, i, &got));
            CHECK(got.count == 0 || progressive_sample_is_same(&f.sets[i], &got, got.count));
            splats += got.count;
        }
        CHECK(splats >= maximum);
        maximum = splats;
        stp_store_close(store);
    }
    CHECK(maximum > 0);
    file_tear_down(&f);
}

// Columns that are not a progressive set are written without operators.
void test_operators_are_for_progressive_sets_alone(test_state* test)
{
    stp_context* context = test_context(NULL, 1, NULL);
    file_fixture f;
    CHECK(make_content(&f, context, false));
    f.sets[1].ranges[f.sets[1].count - 1] |= 1; // a parent that nothing replaces
    f.sets[2].ranges[0] = 0x7F007E00;           // no base set
    stp_store* store = NULL;
    CHECK_EQUAL(STP_OK, write_file(context, &f.content, &f.bytes, &f.size));
    CHECK_EQUAL(STP_OK, open_bytes(&f, f.bytes, f.size, false, &store));
    for (uint32_t i = 0; i < SETS; ++i) {
        stp_splats got;
        CHECK_EQUAL(STP_OK, stp_store_get_splat_set(store, i, &got));
        CHECK(progressive_sample_is_same(&f.sets[i], &got, got.count));
        CHECK_EQUAL(i == 0 ? 2 : 1, stp_store_octave_block(store, i, 1)->encoding);
    }
    stp_store_close(store);
    file_tear_down(&f);
}

void test_operators_are_streamed(test_state* test)
{
    file_fixture f;
    CHECK(file_set_up(&f, 1, false));
    for (uint64_t limit = 0; limit < 3; ++limit) {
        stp_store* store = NULL;
        stp_residency* residency;
        stp_residency_stats stats;
        stp_data_request wants[SETS];
        // none, enough for all, and not enough
        stp_residency_desc desc = {.limit_bytes = limit == 0   ? 0
                                                  : limit == 1 ? (uint64_t)4 << 20
                                                               : (uint64_t)100 << 10};
        CHECK_EQUAL(STP_OK, open_bytes(&f, f.bytes, f.size, false, &store));
        CHECK_EQUAL(STP_OK, stp_residency_create(store, &desc, &residency));
        for (uint32_t i = 0; i < SETS; ++i) {
            wants[i] = (stp_data_request){.kind = STP_RESIDENT_SPLATS,
                                          .index = i,
                                          .octaves = STP_OCTAVE_LIMIT,
                                          .need = 10.0f,
                                          .octave_need = 1.0f};
        }
        residency_settle(residency, wants, SETS);
        for (uint32_t i = 0; i < SETS; ++i) {
            stp_splats got;
            CHECK_EQUAL(STP_OK, stp_store_get_splat_set(store, i, &got));
            CHECK(limit == 2 || got.count == f.sets[i].count);
            CHECK(got.count == 0 || progressive_sample_is_same(&f.sets[i], &got, got.count));
        }
        stp_residency_get_stats(residency, &stats);
        CHECK(stats.damaged == 0 && (limit == 0 || stats.peak_bytes <= desc.limit_bytes));
        stp_residency_destroy(residency);
        stp_store_close(store);
    }
    file_tear_down(&f);
}

// Changes bytes and reseals the checksums. All splats read afterwards are valid.
void test_forged_operators_are_refused(test_state* test)
{
    test_log log = {.errors = 0};
    file_fixture f;
    CHECK(file_set_up(&f, 1, true));
    stp_context* quiet = test_context(NULL, 1, &log);
    size_t data = (size_t)stp_read_u64(f.bytes + 24);
    uint32_t refused = 0, tried = 0;
    unsigned char* copy = NULL;
    CHECK(posix_memalign((void**)&copy, 64, f.size) == 0);
    for (size_t at = data; at < f.size; at += at < data + 1024 ? 5 : 1 + f.size / 61) {
        memcpy(copy, f.bytes, f.size);
        copy[at] ^= (unsigned char)(1u << at % 8);
        reseal(copy, f.size);
        stp_store* store = NULL;
        stp_splats got;
        stp_result result = stp_store_open_memory(quiet, "operators", copy, f.size,
                                                  &(stp_store_open_desc){0}, &store);
        for (uint32_t i = 0; result == STP_OK && i < SETS; ++i) {
            result = stp_store_get_splat_set(store, i, &got);
        }
        stp_store_check_report report;
        if (store != NULL) {
            stp_result checked = stp_store_check_open(store, false, &report);
            CHECK(result == STP_OK || checked != STP_OK);
        }
        tried += 1;
        refused += result != STP_OK ? 1 : 0;
        CHECK(result == STP_OK || result == STP_ERROR_FORMAT);
        stp_store_close(store);
    }
    CHECK(tried > 100 && refused > tried / 2);
    free(copy);
    stp_context_destroy(quiet);
    file_tear_down(&f);
}

void test_operators_survive_failing_allocator(test_state* test)
{
    file_fixture f;
    CHECK(file_set_up(&f, 1, true));
    bool made = false;
    for (int n = 1; !made && n < 400; ++n) {
        test_heap heap = TEST_HEAP(n);
        stp_context* context = test_context(&heap, 1, NULL);
        if (context != NULL) {
            unsigned char* bytes = NULL;
            size_t size = 0;
            stp_store* store = NULL;
            stp_splats got;
            stp_result result = write_file(context, &f.content, &bytes, &size);
            CHECK(result == STP_OK || result == STP_ERROR_OUT_OF_MEMORY);
            if (result == STP_OK) {
                result = stp_store_open_memory(context, "operators", bytes, size,
                                               &(stp_store_open_desc){0}, &store);
            }
            stp_store_check_report report;
            if (result == STP_OK) {
                result = stp_store_check_open(store, false, &report);
            }
            for (uint32_t i = 0; result == STP_OK && i < SETS; ++i) {
                result = stp_store_get_splat_set(store, i, &got);
            }
            CHECK(result == STP_OK || result == STP_ERROR_OUT_OF_MEMORY);
            made = result == STP_OK && heap.count <= n;
            stp_store_close(store);
            free(bytes);
        }
        stp_context_destroy(context);
        CHECK_EQUAL(0, heap.live_bytes);
    }
    CHECK(made);
    file_tear_down(&f);
}
