// SPDX-License-Identifier: MIT
// Residency: data arrives in order of need, is dropped again, and never exceeds its limit.
#include "support_reader.h"
#include "support_sample.h"
#include "tests.h"

#include "base/math/rng.h"
#include "store/file/block_table.h"
#include "store/sets/sets_internal.h"

#include <string.h>
#include <time.h>
#include <unistd.h>

enum { OCTAVES = 5, LEAST = 40, REQUESTS = 64 };

/// A random sample with long sets, written, read into memory and opened.
typedef struct fixture {
    stp_context* context;
    stp_arena arena;
    sample made;
    unsigned char* bytes;
    size_t size;
    stp_store* store;
    stp_residency* residency;
    slow_reader reader;
    stp_data_request requests[REQUESTS];
    size_t request_count;
} fixture;

static void lengthen(stp_arena* arena, stp_splats* s, uint64_t seed)
{
    uint64_t entries = 0;
    memset(s->octave_ends, 0, sizeof(s->octave_ends));
    memset(&s->table, 0, sizeof(s->table));
    s->octave_count = OCTAVES;
    for (uint32_t k = 0; k < OCTAVES; ++k) {
        s->octave_ends[k] = s->count = (uint32_t)LEAST << (2 * k);
        entries += s->count;
        s->table.count[k] = s->count;
        s->table.radius[k] = 8.0f / (float)(1u << k);
    }
    s->table.size = OCTAVES;
    s->paper_count = 0;
    s->paper_radius = 0.0f;
    size_t sizes[] = {6 * (size_t)s->count, 2 * (size_t)s->count, s->count, 3 * (size_t)entries,
                      (size_t)entries};
    unsigned char* columns[5];
    for (int c = 0; c < 5; ++c) {
        columns[c] = stp_arena_alloc(arena, sizes[c]);
        for (size_t i = 0; columns[c] != NULL && i < sizes[c]; ++i) {
            columns[c][i] = (unsigned char)(stp_rng_hash(seed, i + 7u * (unsigned)c) & 255);
        }
    }
    s->positions = (uint16_t*)(void*)columns[0];
    s->normals = (int8_t*)columns[1];
    s->materials = memset(columns[2], 0, s->count);
    s->colors = columns[3];
    s->coverages = columns[4];
    uint32_t* options = stp_arena_alloc_array(arena, 2 * (size_t)s->count, sizeof(*options));
    for (uint32_t i = 0; options != NULL && i < 2 * s->count; ++i) {
        uint32_t some = (uint32_t)stp_rng_hash(seed, i);
        options[i] = i < s->count ? some & 0xFFu : 0x40000000u | (some & 0x3FFFu);
    }
    s->shapes = (s->columns & STP_SPLATS_SHAPES) != 0 ? options : NULL;
    s->ranges = (s->columns & STP_SPLATS_RANGES) != 0 ? options + s->count : NULL;
}

static void want_all(fixture* f)
{
    const stp_store_directory* d = stp_store_get_directory(f->store);
    uint32_t counts[] = {d->set_count, d->mesh_count, d->point_set_count, d->texture_count};
    enum { KINDS = sizeof(counts) / sizeof(counts[0]) }; // leaves: test_leaves.c
    f->request_count = 0;
    for (uint32_t kind = 0; kind < KINDS; ++kind) {
        for (uint32_t i = 0; i < counts[kind] && f->request_count < REQUESTS; ++i) {
            f->requests[f->request_count++] =
                (stp_data_request){.kind = (stp_resident_kind)kind,
                                   .index = i,
                                   .octaves = STP_OCTAVE_LIMIT,
                                   .need = 10.0f + (float)i,
                                   .octave_need = 1.0f + 0.1f * (float)i};
        }
    }
}

static bool set_up(fixture* f, stp_context* context, uint64_t seed, bool open)
{
    char path[256];
    const char* folder = getenv("TMPDIR");
    snprintf(path, sizeof(path), "%s/stp_residency_%ld.stip", folder != NULL ? folder : "/tmp",
             (long)getpid());
    *f = (fixture){.context = context, .arena = stp_arena_create(context, 1 << 16)};
    f->made = sample_make(&f->arena, seed);
    stp_splats* sets = (stp_splats*)(uintptr_t)f->made.content.sets;
    for (uint32_t i = 0; f->made.complete && i < f->made.content.directory.set_count; ++i) {
        lengthen(&f->arena, &sets[i], seed + i);
    }
    bool good = f->made.complete && sample_code_meshes(&f->arena, &f->made, NULL) &&
                stp_store_write(context, &f->made.content, path) == STP_OK;
    f->bytes = good ? sample_read_file(path, &f->size) : NULL;
    unlink(path);
    good =
        f->bytes != NULL && stp_store_open_memory(context, "memory", f->bytes, f->size,
                                                  &(stp_store_open_desc){0}, &f->store) == STP_OK;
    slow_reader_create(&f->reader, f->bytes, f->size, open);
    if (good) {
        want_all(f);
    }
    return good;
}

static stp_result stream(fixture* f, uint64_t limit, uint32_t threads)
{
    stp_residency_desc desc = {.limit_bytes = limit,
                               .thread_count = threads,
                               .read = slow_reader_read,
                               .read_user = &f->reader};
    return stp_residency_create(f->store, &desc, &f->residency);
}

static void tear_down(fixture* f)
{
    stp_residency_destroy(f->residency);
    stp_store_close(f->store);
    slow_reader_destroy(&f->reader);
    free(f->bytes);
    stp_arena_destroy(&f->arena);
}

/// A seed whose sample has sets, meshes and textures.
static uint64_t rich_seed(stp_context* context, uint64_t from)
{
    for (uint64_t seed = from;; ++seed) {
        stp_arena arena = stp_arena_create(context, 1 << 16);
        sample made = sample_make(&arena, seed);
        const stp_store_directory* d = &made.content.directory;
        bool rich = made.complete && d->set_count > 1 && d->mesh_count > 1 &&
                    d->texture_count > 0 && d->point_set_count > 0 && d->root != STP_STORE_NONE &&
                    d->nodes[d->root].set != STP_STORE_NONE;
        stp_arena_destroy(&arena);
        if (rich) {
            return seed;
        }
    }
}

void test_residency_loads_what_the_file_holds(test_state* test)
{
    stp_context* context = test_context(NULL, 1, NULL);
    CHECK(context != NULL);
    uint64_t seed = 1;
    for (int round = 0; round < 4; ++round) {
        fixture f;
        seed = rich_seed(context, seed + 1);
        CHECK(set_up(&f, context, seed, true));
        CHECK_EQUAL(STP_OK, stream(&f, 0, 1 + (uint32_t)round));
        residency_settle(f.residency, f.requests, f.request_count);
        stp_residency_stats stats;
        stp_residency_get_stats(f.residency, &stats);
        const char* difference = sample_difference(&f.made.content, f.store);
        CHECK(difference == NULL);
        CHECK_EQUAL(0, stats.missing);
        CHECK_EQUAL(0, stats.damaged);
        CHECK(stats.resident_bytes >= stats.read_bytes / 2 && stats.read_bytes > 0);
        stp_residency_destroy(f.residency); // now from the mapped file
        f.residency = NULL;
        CHECK(sample_difference(&f.made.content, f.store) == NULL);
        tear_down(&f);
    }
    stp_context_destroy(context);
}

void test_residency_never_waits_for_the_disk(test_state* test)
{
    stp_context* context = test_context(NULL, 1, NULL);
    CHECK(context != NULL);
    fixture f;
    CHECK(set_up(&f, context, rich_seed(context, 5), false));
    CHECK_EQUAL(STP_OK, stream(&f, 0, 2));
    for (int i = 0; i < 3; ++i) { // returns though nothing was read
        stp_residency_update(f.residency, f.requests, f.request_count);
    }
    const stp_store_directory* d = stp_store_get_directory(f.store);
    stp_splats splats;
    CHECK_EQUAL(0, stp_store_resident_splats(f.store, 0));
    CHECK_EQUAL(STP_OK, stp_store_get_splat_set(f.store, 0, &splats));
    CHECK_EQUAL(0, splats.count);
    CHECK(!stp_store_is_mesh_resident(f.store, 0) && stp_store_streams(f.store));
    stp_residency_stats stats;
    stp_residency_get_stats(f.residency, &stats);
    CHECK(stats.missing >= d->set_count && stats.loading > 0);
    // loaded data becomes visible at the next update, not before
    slow_reader_let_go(&f.reader, UINT32_MAX);
    CHECK(stp_residency_wait(f.residency));
    CHECK_EQUAL(0, stp_store_resident_splats(f.store, 0));
    residency_settle(f.residency, f.requests, f.request_count);
    CHECK_EQUAL(stp_store_describe_splat_set(f.store, 0)->count,
                stp_store_resident_splats(f.store, 0));
    CHECK(sample_difference(&f.made.content, f.store) == NULL);
    tear_down(&f);
    stp_context_destroy(context);
}

void test_residency_coarse_comes_first(test_state* test)
{
    stp_context* context = test_context(NULL, 1, NULL);
    CHECK(context != NULL);
    fixture f;
    CHECK(set_up(&f, context, rich_seed(context, 9), true));
    stp_residency_desc desc = {.limit_bytes = 1500000,
                               .batch_bytes = 1,
                               .read = slow_reader_read,
                               .read_user = &f.reader,
                               .thread_count = 1};
    CHECK_EQUAL(STP_OK, stp_residency_create(f.store, &desc, &f.residency));
    residency_settle(f.residency, NULL, 0); // the pinned data
    const stp_store_directory* d = stp_store_get_directory(f.store);
    // one at a time: the coarsest octaves of all sets come before the finest of any
    bool finest = false;
    for (int i = 0; i < 1000; ++i) {
        stp_residency_update(f.residency, f.requests, f.request_count);
        uint32_t minimum = OCTAVES, maximum = 0;
        for (uint32_t set = 0; set < d->set_count; ++set) {
            uint32_t level = stp_store_octaves_for(stp_store_describe_splat_set(f.store, set),
                                                   stp_store_resident_splats(f.store, set));
            minimum = level < minimum ? level : minimum;
            maximum = level > maximum ? level : maximum;
        }
        CHECK(maximum < OCTAVES || minimum > 0);
        finest = finest || maximum == OCTAVES;
        if (!stp_residency_wait(f.residency)) {
            break;
        }
    }
    CHECK(finest && sample_difference(&f.made.content, f.store) == NULL);
    tear_down(&f);
    stp_context_destroy(context);
}

/// A hash of the resident data.
static uint64_t fingerprint(const fixture* f)
{
    const stp_store_directory* d = stp_store_get_directory(f->store);
    uint64_t hash = 0;
    for (uint32_t i = 0; i < d->set_count; ++i) {
        hash = stp_rng_hash(hash, stp_store_resident_splats(f->store, i));
    }
    for (uint32_t i = 0; i < d->mesh_count; ++i) {
        hash = stp_rng_hash(hash, stp_store_is_mesh_resident(f->store, i));
    }
    for (uint32_t i = 0; i < d->point_set_count; ++i) {
        hash = stp_rng_hash(hash, stp_store_are_points_resident(f->store, i));
    }
    return hash;
}

/// The requests of a round: some resources, some octaves.
static size_t choose_requests(const fixture* f, uint64_t round, stp_data_request* requests)
{
    size_t count = 0;
    for (size_t i = 0; i < f->request_count; ++i) {
        uint64_t h = stp_rng_hash(round, i);
        if (h % 3 == 0) {
            requests[count] = f->requests[i];
            requests[count].octaves = (uint32_t)(h >> 8) % (OCTAVES + 1);
            requests[count].need = (float)((h >> 16) % 100);
            requests[count++].octave_need = (float)((h >> 32) % 100);
        }
    }
    return count;
}

/// NULL if a set's resident part equals the file's.
static const char* compare_prefixes(const fixture* f, stp_store* other)
{
    const stp_store_directory* d = stp_store_get_directory(f->store);
    for (uint32_t i = 0; i < d->set_count; ++i) {
        stp_splats a, b;
        if (stp_store_get_splat_set(f->store, i, &a) != STP_OK ||
            stp_store_get_splat_set_prefix(other, i, a.octave_count, &b) != STP_OK ||
            a.count != b.count || a.count != stp_store_resident_splats(f->store, i)) {
            return "a set has other counts";
        }
        uint64_t entries = stp_store_pyramid_begin(&a, a.octave_count);
        if (a.count > 0 &&
            (memcmp(a.positions, b.positions, 6 * (size_t)a.count) != 0 ||
             memcmp(a.normals, b.normals, 2 * (size_t)a.count) != 0 ||
             memcmp(a.materials, b.materials, a.count) != 0 ||
             memcmp(a.colors, b.colors, 3 * (size_t)entries) != 0 ||
             memcmp(a.coverages, b.coverages, (size_t)entries) != 0 ||
             (a.shapes != NULL && memcmp(a.shapes, b.shapes, 4 * (size_t)a.count) != 0) ||
             (a.ranges != NULL && memcmp(a.ranges, b.ranges, 4 * (size_t)a.count) != 0))) {
            return "a set has other columns";
        }
    }
    return NULL;
}

void test_residency_keeps_to_its_limit(test_state* test)
{
    enum { ROUNDS = 60 };
    uint64_t prints[ROUNDS];
    for (uint32_t threads = 1; threads <= 3; ++threads) {
        stp_context* context = test_context(NULL, 1, NULL);
        CHECK(context != NULL);
        fixture f;
        stp_store* other = NULL;
        CHECK(set_up(&f, context, rich_seed(context, 21), true));
        CHECK_EQUAL(STP_OK, stp_store_open_memory(context, "other", f.bytes, f.size,
                                                  &(stp_store_open_desc){0}, &other));
        uint64_t limit = f.size / 3, before = stp_context_live_bytes(context);
        CHECK_EQUAL(STP_OK, stream(&f, limit, threads));
        uint64_t tables = stp_context_live_bytes(context) - before;
        stp_residency_stats stats;
        bool dropped = false, full = false;
        for (uint64_t round = 0; round < ROUNDS; ++round) {
            stp_data_request requests[REQUESTS];
            size_t count = choose_requests(&f, round, requests);
            residency_settle(f.residency, requests, count);
            stp_residency_get_stats(f.residency, &stats);
            prints[round] = threads == 1 ? fingerprint(&f) : prints[round];
            CHECK_EQUAL(prints[round], fingerprint(&f)); // for any assignment of reads to threads
            CHECK(compare_prefixes(&f, other) == NULL);
            dropped = dropped || stats.dropped > 0;
            full = full || stats.missing > 0;
            CHECK(stats.resident_bytes <= limit && stats.peak_bytes <= limit);
            for (uint32_t i = 0; i < other->directory.set_count; ++i) {
                stp_store_release_splat_set(other, i);
            }
            CHECK(stp_context_live_bytes(context) <= before + tables + limit);
        }
        CHECK(dropped && full && f.size > limit);
        stp_store_close(other);
        tear_down(&f);
        stp_context_destroy(context);
    }
}

void test_residency_needed_most_stays(test_state* test)
{
    stp_context* context = test_context(NULL, 1, NULL);
    CHECK(context != NULL);
    fixture f;
    CHECK(set_up(&f, context, rich_seed(context, 33), true));
    uint64_t one = stp_store_columns_bytes(stp_store_describe_splat_set(f.store, 0), OCTAVES);
    CHECK_EQUAL(STP_OK, stream(&f, 2 * one, 2));
    stp_data_request a = {STP_RESIDENT_SPLATS, 0, OCTAVES, 10.0f, 10.0f, 0};
    stp_data_request b = {STP_RESIDENT_SPLATS, 1, OCTAVES, 1.0f, 1.0f, 0};
    residency_settle(f.residency, &a, 1);
    uint32_t all = stp_store_describe_splat_set(f.store, 0)->count;
    CHECK_EQUAL(all, stp_store_resident_splats(f.store, 0));
    // both do not fit: the more needed one stays whole, and they do not replace each other in turns
    stp_data_request both[] = {b, a};
    residency_settle(f.residency, both, 2);
    CHECK_EQUAL(all, stp_store_resident_splats(f.store, 0));
    uint32_t rest = stp_store_resident_splats(f.store, 1);
    CHECK(rest > 0 && rest < all);
    uint32_t updates = residency_settle(f.residency, both, 2);
    CHECK_EQUAL(1, updates);
    CHECK_EQUAL(rest, stp_store_resident_splats(f.store, 1));
    // needs change: now the other one is resident, and the first has the rest
    both[0].need = both[0].octave_need = 1000.0f;
    residency_settle(f.residency, both, 2);
    CHECK_EQUAL(all, stp_store_resident_splats(f.store, 1));
    CHECK(stp_store_resident_splats(f.store, 0) < all && stp_store_resident_splats(f.store, 0) > 0);
    tear_down(&f);
    stp_context_destroy(context);
}

void test_residency_reports_a_damaged_block_once(test_state* test)
{
    test_log log = {.errors = 0};
    stp_context* context = test_context(NULL, 1, &log);
    CHECK(context != NULL);
    fixture f;
    CHECK(set_up(&f, context, rich_seed(context, 41), true));
    const stp_store_set_record* sets = f.store->tables[STP_SECTION_SPLAT_SETS];
    const stp_store_octave* octaves = f.store->tables[STP_SECTION_OCTAVES];
    const stp_store_block* block =
        stp_store_block_at(f.store, octaves[sets[0].first_octave + 3].block);
    f.reader.wrong_at = block->offset + block->size / 2;
    CHECK_EQUAL(STP_OK, stream(&f, 0, 2));
    for (int i = 0; i < 3; ++i) {
        residency_settle(f.residency, f.requests, f.request_count);
    }
    stp_residency_stats stats;
    stp_residency_get_stats(f.residency, &stats);
    CHECK_EQUAL(1, log.warnings);
    CHECK_EQUAL(0, log.errors);
    CHECK(strstr(log.warning, "checksum") != NULL);
    CHECK_EQUAL(1, stats.damaged);
    CHECK_EQUAL(0, stats.missing); // data that cannot be loaded does not count as missing
    CHECK_EQUAL(stp_store_describe_splat_set(f.store, 0)->octave_ends[2],
                stp_store_resident_splats(f.store, 0));
    CHECK_EQUAL(stp_store_describe_splat_set(f.store, 1)->count,
                stp_store_resident_splats(f.store, 1));
    tear_down(&f);
    stp_context_destroy(context);
}

void test_residency_of_a_partial_file(test_state* test)
{
    test_log log = {.errors = 0};
    stp_context* context = test_context(NULL, 1, &log);
    CHECK(context != NULL);
    fixture f;
    CHECK(set_up(&f, context, rich_seed(context, 50), true));
    uint64_t begin = f.store->data_offset;
    for (uint64_t part = 0; part <= 8; ++part) {
        f.reader.size = begin + (f.size - begin) * part / 8;
        log.warnings = log.errors = 0;
        CHECK_EQUAL(STP_OK, stream(&f, 0, 1));
        residency_settle(f.residency, f.requests, f.request_count);
        residency_settle(f.residency, f.requests, f.request_count);
        stp_residency_stats stats;
        stp_residency_get_stats(f.residency, &stats);
        CHECK_EQUAL(stats.damaged, (uint64_t)log.warnings);
        CHECK_EQUAL(0, log.errors);
        CHECK((stats.damaged == 0) == (part == 8));
        stp_residency_destroy(f.residency);
        f.residency = NULL;
    }
    tear_down(&f);
    stp_context_destroy(context);
}

void test_residency_without_memory_is_coarser(test_state* test)
{
    bool complete = false;
    for (int fail_at = 0; !complete && fail_at < 200; ++fail_at) {
        test_heap heap = TEST_HEAP(-1);
        test_log log = {.errors = 0};
        stp_context* context = test_context(&heap, 1, &log);
        CHECK(context != NULL);
        fixture f;
        CHECK(set_up(&f, context, rich_seed(context, 61), true));
        heap.count = 0;
        heap.fail_at = fail_at;
        stp_result result = stream(&f, 400000, 2);
        CHECK(result == STP_OK || result == STP_ERROR_OUT_OF_MEMORY);
        if (result == STP_OK) {
            for (uint64_t round = 0; round < 4; ++round) {
                stp_data_request requests[REQUESTS];
                size_t count = choose_requests(&f, round, requests);
                residency_settle(f.residency, requests, count);
            }
            CHECK_EQUAL(0, log.errors);
        } else {
            CHECK_EQUAL(1, log.errors);
        }
        complete = heap.count <= fail_at;
        heap.fail_at = -1;
        if (result == STP_OK) { // with memory available again, everything works
            stp_residency_destroy(f.residency);
            CHECK_EQUAL(STP_OK, stream(&f, 0, 2));
            residency_settle(f.residency, f.requests, f.request_count);
            CHECK(sample_difference(&f.made.content, f.store) == NULL);
        }
        tear_down(&f);
        stp_context_destroy(context);
        CHECK_EQUAL(0, heap.live_bytes);
    }
    CHECK(complete);
}

static void* let_go_later(void* user)
{
    struct timespec pause = {.tv_nsec = 5000000};
    nanosleep(&pause, NULL);
    slow_reader_let_go(user, UINT32_MAX);
    return NULL;
}

void test_residency_ends_while_it_loads(test_state* test)
{
    stp_context* context = test_context(NULL, 1, NULL);
    CHECK(context != NULL);
    fixture f;
    CHECK(set_up(&f, context, rich_seed(context, 71), false));
    for (uint32_t round = 0; round < 3; ++round) {
        pthread_t helper;
        f.reader.open = false;
        CHECK_EQUAL(STP_OK, stream(&f, 0, 2));
        stp_residency_update(f.residency, f.requests, f.request_count);
        slow_reader_await(&f.reader, 2);
        slow_reader_let_go(&f.reader, round); // during a read
        CHECK_EQUAL(0, pthread_create(&helper, NULL, let_go_later, &f.reader));
        stp_residency_destroy(f.residency);
        f.residency = NULL;
        pthread_join(helper, NULL);
        CHECK(sample_difference(&f.made.content, f.store) == NULL);
    }
    tear_down(&f);
    stp_context_destroy(context);
}

void test_residency_pins_what_is_uppermost(test_state* test)
{
    stp_context* context = test_context(NULL, 1, NULL);
    CHECK(context != NULL);
    fixture f;
    CHECK(set_up(&f, context, rich_seed(context, 81), true));
    const stp_store_directory* d = stp_store_get_directory(f.store);
    CHECK_EQUAL(STP_OK, stream(&f, 0, 2));
    residency_settle(f.residency, NULL, 0);
    CHECK(stp_store_resident_splats(f.store, d->nodes[d->root].set) > 0);
    stp_residency_destroy(f.residency);
    // one residency at a time
    stp_residency* second = NULL;
    CHECK_EQUAL(STP_OK, stream(&f, 0, 1));
    CHECK_EQUAL(STP_ERROR_ARGUMENT,
                stp_residency_create(f.store, &(stp_residency_desc){0}, &second));
    CHECK(second == NULL);
    tear_down(&f);
    stp_context_destroy(context);
}

void test_residency_yields_to_others(test_state* test)
{
    stp_context_desc desc = {.thread_count = 1, .memory_limit_bytes = 16 << 20};
    stp_context* context = NULL;
    CHECK_EQUAL(STP_OK, stp_context_create(&context, &desc));
    fixture f;
    CHECK(set_up(&f, context, rich_seed(context, 91), true));
    CHECK_EQUAL(STP_OK, stream(&f, 0, 2)); // under the context's limit
    residency_settle(f.residency, f.requests, f.request_count);
    stp_residency_stats stats;
    stp_residency_get_stats(f.residency, &stats);
    uint64_t limit = stats.limit_bytes, loaded = stats.resident_bytes;
    CHECK(stats.missing == 0 && limit < desc.memory_limit_bytes);
    uint64_t others = desc.memory_limit_bytes - stp_context_live_bytes(context) - (3 << 20);
    void* block = stp_alloc(context, (size_t)others); // another user takes nearly all of the rest
    CHECK(block != NULL && stp_alloc(context, 3 << 20) == NULL);
    bool yielded = false;
    for (int i = 0; i < 4; ++i) {
        yielded = stp_residency_yield(f.residency) || yielded;
    }
    stp_residency_get_stats(f.residency, &stats);
    CHECK(yielded && stats.resident_bytes < loaded && stats.limit_bytes < limit);
    CHECK(stats.resident_bytes <= stats.limit_bytes + (1 << 20)); // pinned data stays
    stp_free(context, block);
    residency_settle(f.residency, f.requests, f.request_count);
    CHECK(sample_difference(&f.made.content, f.store) == NULL); // there is room again
    tear_down(&f);
    stp_context_destroy(context);
}
