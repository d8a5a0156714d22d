// SPDX-License-Identifier: MIT
// Reads the chunks of a LAS file into point sets, on all threads.
//
// Colours have 16 bits, but many writers store values up to 255. A sample of points decides; if a
// larger value appears although 8 bits were expected, everything is read again.
#include "base/core/atomic_limits.h"
#include "base/io/bytes.h"
#include "import/las/laz.h"
#include "import/reading/place_sample.h"

#include <assert.h>
#include <math.h>
#include <stdatomic.h>
#include <string.h>

enum {
    RECORDS_IN_CHUNK = 1 << 16,
    RELEASE_EVERY = 64, // chunks, after which spilled pages are released
    PROBES = 16,        // chunks whose first points say how wide colours are, and where most lie
    PLAUSIBLE = 32      // points per compressed byte; sets that claim more are decoded to prove it
};
#define MAX_IN_SET ((uint64_t)UINT32_MAX - 1)

typedef struct worker {
    stp_laz* laz; ///< NULL: not compressed
    stp_las_block* block;
} worker;

typedef struct reading {
    stp_las* las;
    worker* workers;
    uint32_t worker_count;
    stp_point_set* sets;
    size_t set_count;
    bool wide; ///< colours have 16 bits

    // one set
    stp_point_set* set; ///< NULL: points are decoded, but not stored
    const stp_las_chunk* chunks;
    atomic_uint_fast64_t bad_chunk; ///< index of the first that is damaged; SIZE_MAX: none
    atomic_bool no_memory;
    atomic_uint seen;
} reading;

static void destroy_workers(reading* r)
{
    stp_context* context = r->las->context;
    for (uint32_t i = 0; r->workers != NULL && i < r->worker_count; ++i) {
        stp_laz_destroy(r->las, r->workers[i].laz);
        stp_free(context, r->workers[i].block);
    }
    stp_free(context, r->workers);
}

// Per-thread state, created on first use.
static bool prepare(const stp_las* las, worker* w)
{
    if (w->block == NULL) {
        w->block = STP_NEW_ZEROED(las->context, stp_las_block, 1);
    }
    if (w->laz == NULL && las->items != STP_LAZ_RAW) {
        w->laz = stp_laz_create(las);
    }
    return w->block != NULL && (w->laz != NULL || las->items == STP_LAZ_RAW);
}

// Reads the next points of a chunk; `done` points are already read.
static bool next_block(const stp_las* las, worker* w, const stp_las_chunk* chunk, uint64_t done,
                       size_t count)
{
    assert(count > 0 && count <= STP_LAS_BLOCK && done + count <= chunk->count);
    if (w->laz != NULL) {
        return (done > 0 || stp_laz_begin(w->laz, chunk)) && stp_laz_next(w->laz, count, w->block);
    }
    const unsigned char* bytes = las->import->file.bytes + chunk->offset + done * las->record_size;
    stp_las_read_records(las, bytes, count, w->block, 0);
    return true;
}

static size_t block_size(uint64_t left)
{
    return left < STP_LAS_BLOCK ? (size_t)left : STP_LAS_BLOCK;
}

static void stop(reading* r)
{
    stp_parallel_stop(r->las->context);
}

static void read_chunk(reading* r, worker* w, size_t index)
{
    const stp_las_chunk* chunk = &r->chunks[index];
    uint64_t first = chunk->first - r->chunks[0].first;
    assert(chunk->read <= chunk->count);
    assert(r->set == NULL || first + chunk->read <= r->set->point_count);
    unsigned seen = 0;
    for (uint64_t done = 0; done < chunk->read;) {
        size_t count = block_size(chunk->read - done);
        if (!next_block(r->las, w, chunk, done, count)) {
            stp_atomic_min(&r->bad_chunk, index);
            stop(r);
            return;
        }
        if (r->set != NULL) {
            seen |= stp_las_store_block(r->las, w->block, count, r->wide, r->set,
                                        (size_t)(first + done));
        }
        done += count;
    }
    atomic_fetch_or(&r->seen, seen);
    stp_progress_add(r->las->context, chunk->read);
    if ((seen & STP_LAS_SEEN_WIDE) != 0 && !r->wide) {
        stop(r);
    }
}

static void read_chunks(size_t begin, size_t end, uint32_t index, void* user)
{
    reading* r = user;
    worker* w = &r->workers[index];
    if (!prepare(r->las, w)) {
        atomic_store(&r->no_memory, true);
        stop(r);
        return;
    }
    for (size_t i = begin; i < end; ++i) {
        if (i % RELEASE_EVERY == 0 && r->set != NULL) {
            stp_point_columns_release(r->las->import, r->set);
        }
        read_chunk(r, w, i);
    }
}

static void drop_column(const stp_las* las, const stp_point_set* set, void** column)
{
    if (!set->spilled) {
        stp_free(las->context, *column);
    }
    *column = NULL;
}

// Values that are zero everywhere were not recorded, according to the specification of intensity
// and similar fields.
static void drop_unseen(reading* r)
{
    unsigned seen = atomic_load(&r->seen);
    for (size_t i = 0; i < r->set_count; ++i) {
        stp_point_set* set = &r->sets[i];
        if ((seen & STP_LAS_SEEN_COLOR) == 0) {
            void* colors = set->colors;
            drop_column(r->las, set, &colors);
            set->colors = NULL;
        }
        for (unsigned k = 0; k < STP_ATTRIBUTES; ++k) {
            if ((seen >> k & 1) == 0) {
                drop_column(r->las, set, &set->attributes[k]);
            }
        }
    }
}

static void free_sets(reading* r)
{
    for (size_t i = 0; i < r->set_count; ++i) {
        stp_point_columns_free(r->las->import, &r->sets[i]);
    }
    r->set_count = 0;
}

static stp_result add_sets(reading* r)
{
    stp_result result = STP_OK;
    for (size_t i = 0; i < r->set_count && result == STP_OK; ++i) {
        result = stp_point_columns_add(r->las->import, &r->sets[i]);
    }
    return result;
}

static bool needs_wide(const reading* r)
{
    return !r->wide && (atomic_load(&r->seen) & STP_LAS_SEEN_WIDE) != 0;
}

// Decodes `count` chunks, of which the first is chunk `first` of the file.
static stp_result run_chunks(reading* r, size_t first, size_t count, uint64_t point_count)
{
    const stp_las* las = r->las;
    stp_result result = STP_OK;
    stp_loop_report report = {.stage = "import", .unit = "points", .total = point_count};
    if (las->import->desc.sample_points == 0) {
        result = stp_parallel_for_reported(las->context, count, 1, read_chunks, r, &report);
    } else { // the next pass reports the same stage
        stp_parallel_for(las->context, count, 1, read_chunks, r);
    }
    if (atomic_load(&r->no_memory)) {
        return stp_fail_memory(las->context);
    }
    size_t bad = atomic_load(&r->bad_chunk);
    assert(bad == SIZE_MAX || bad < count);
    if (bad != SIZE_MAX) {
        const stp_las_chunk* chunk = &r->chunks[bad];
        return stp_fail(las->context, STP_ERROR_FORMAT,
                        "%s: chunk %zu of %zu, %llu points from byte %llu on, cannot be decoded",
                        las->import->path, first + bad, las->chunk_count,
                        (unsigned long long)chunk->count, (unsigned long long)chunk->offset);
    }
    return needs_wide(r) ? STP_OK : result;
}

// Whether the chunks claim so many points that they must be decoded before they get memory.
static bool is_implausible(const reading* r, size_t count, uint64_t point_count)
{
    uint64_t bytes = 0;
    for (size_t i = 0; i < count; ++i) {
        bytes += r->chunks[i].size;
    }
    return r->las->items != STP_LAZ_RAW && point_count / PLAUSIBLE > bytes;
}

// Reads chunks [first, first + count) into a set.
static stp_result read_set(reading* r, size_t first, size_t count, uint64_t point_count)
{
    stp_las* las = r->las;
    assert(count > 0 && first + count <= las->chunk_count && point_count <= MAX_IN_SET);
    assert(r->set_count < las->chunk_count && "a set holds at least one chunk");
    stp_point_columns_desc desc = stp_las_columns(las, (uint32_t)point_count);
    stp_result result = STP_OK;
    r->chunks = las->chunks + first;
    r->set = NULL;
    if (is_implausible(r, count, point_count)) {
        result = run_chunks(r, first, count, point_count);
    }
    if (result == STP_OK) {
        r->set = &r->sets[r->set_count];
        result = stp_point_columns_create(las->import, &desc, r->set);
    }
    if (result != STP_OK) {
        return result;
    }
    r->set_count += 1;
    return run_chunks(r, first, count, point_count);
}

size_t stp_las_chunks_of_set(const stp_las* las, size_t first, uint64_t points_in_set,
                             uint64_t* point_count)
{
    assert(first < las->chunk_count);
    size_t count = 1;
    *point_count = las->chunks[first].read;
    while (first + count < las->chunk_count &&
           *point_count + las->chunks[first + count].read <= points_in_set) {
        *point_count += las->chunks[first + count].read;
        count += 1;
    }
    assert(first + count <= las->chunk_count && (count == 1 || *point_count <= points_in_set));
    return count;
}

static stp_result read_sets(reading* r, uint64_t points_in_set)
{
    stp_las* las = r->las;
    stp_result result = STP_OK;
    atomic_store(&r->seen, 0);
    for (size_t first = 0; first < las->chunk_count && result == STP_OK && !needs_wide(r);) {
        uint64_t points;
        size_t count = stp_las_chunks_of_set(las, first, points_in_set, &points);
        if (points > MAX_IN_SET) {
            return stp_fail(las->context, STP_ERROR_LIMIT,
                            "%s: chunk %zu has %llu points; at most 2^32 - 2 are supported",
                            las->import->path, first, (unsigned long long)points);
        }
        result = read_set(r, first, count, points);
        first += count;
    }
    return result;
}

// Sets r->wide if the first points of some chunks have colours of more than 8 bits.
static stp_result probe_colors(reading* r)
{
    const stp_las* las = r->las;
    worker* w = &r->workers[0];
    size_t probes = las->chunk_count < PROBES ? las->chunk_count : PROBES;
    if (las->layout.rgb == STP_LAS_NO_FIELD) {
        return STP_OK;
    }
    if (!prepare(las, w)) {
        return stp_fail_memory(las->context);
    }
    for (size_t i = 0; i < probes; ++i) {
        const stp_las_chunk* chunk = &las->chunks[i * las->chunk_count / probes];
        size_t count = block_size(chunk->read);
        unsigned all = 0;
        bool good = count > 0 && next_block(las, w, chunk, 0, count);
        for (size_t k = 0; k < 3 * count && good; ++k) {
            all |= w->block->rgb[k / count][k % count];
        }
        r->wide = r->wide || all > UINT8_MAX;
    }
    return STP_OK;
}

// Positions from the first points of some chunks, in steps of the scale.
static stp_result sample_places(const stp_las* las, stp_place_sample* places)
{
    size_t probes = las->chunk_count < PROBES ? las->chunk_count : PROBES;
    worker w = {0};
    bool good = prepare(las, &w);
    for (size_t i = 0; i < probes && good; ++i) {
        const stp_las_chunk* chunk = &las->chunks[i * las->chunk_count / probes];
        size_t count = block_size(chunk->count), each = STP_PLACE_SAMPLES / probes;
        if (count == 0 || !next_block(las, &w, chunk, 0, count)) {
            continue;
        }
        for (size_t k = 0; k < each; ++k) {
            const stp_las_block* block = w.block;
            size_t p = k * count / each;
            stp_place_sample_add(places, (double[3]){block->position[0][p], block->position[1][p],
                                                     block->position[2][p]});
        }
    }
    stp_laz_destroy(las, w.laz);
    stp_free(las->context, w.block);
    return good ? STP_OK : stp_fail_memory(las->context);
}

// The centre of the header's bounds, or the first point if that is outside them; a place among most
// points if that is far away. In steps of the scale.
static void choose_origin(stp_las* las, stp_place_sample* places)
{
    assert(las->chunk_count > 0 && las->chunks[0].size >= las->record_size);
    const unsigned char* first = las->import->file.bytes + las->chunks[0].offset;
    double sampled[3];
    stp_place_sample_choose(places, sampled);
    for (int i = 0; i < 3; ++i) {
        int32_t step = (int32_t)stp_read_u32(first + 4 * i);
        double scale = las->scale[i], at = step * scale + las->offset[i];
        double middle = ((las->low[i] + las->high[i]) / 2.0 - las->offset[i]) / scale;
        double slack = fabs(scale);
        bool within = at >= las->low[i] - slack && at <= las->high[i] + slack;
        double place = within && fabs(middle) < 2147483647.0 ? middle : step;
        bool near = places->count == 0 || fabs((place - sampled[i]) * scale) < STP_PLACE_NEAR;
        las->origin[i] = (int32_t)(near ? place : sampled[i]);
    }
    double origin[3];
    for (int i = 0; i < 3; ++i) {
        origin[i] = las->origin[i] * las->scale[i] + las->offset[i];
    }
    stp_import_set_origin(las->import, origin);
}

stp_result stp_las_list_records(stp_las* las)
{
    uint64_t count = (las->point_count + RECORDS_IN_CHUNK - 1) / RECORDS_IN_CHUNK;
    las->chunks = STP_NEW_ARRAY(las->context, stp_las_chunk, (size_t)count + 1);
    if (las->chunks == NULL) {
        return stp_fail_memory(las->context);
    }
    las->chunk_count = (size_t)count;
    for (size_t i = 0; i < las->chunk_count; ++i) {
        uint64_t first = (uint64_t)i * RECORDS_IN_CHUNK, left = las->point_count - first;
        uint64_t points = left < RECORDS_IN_CHUNK ? left : RECORDS_IN_CHUNK;
        las->chunks[i] = (stp_las_chunk){.offset = las->points + first * las->record_size,
                                         .size = points * las->record_size,
                                         .first = first,
                                         .count = points,
                                         .read = points};
        assert(las->chunks[i].offset + las->chunks[i].size <= las->import->file.size);
    }
    return STP_OK;
}

static stp_result read_all(reading* r, uint64_t points_in_set)
{
    stp_las* las = r->las;
    size_t max_sets = las->chunk_count;
    r->worker_count = stp_context_thread_count(las->context);
    r->workers = STP_NEW_ZEROED(las->context, worker, r->worker_count);
    r->sets = STP_NEW_ZEROED(las->context, stp_point_set, max_sets);
    if (r->workers == NULL || r->sets == NULL) {
        return stp_fail_memory(las->context);
    }
    stp_result result = probe_colors(r);
    result = result == STP_OK ? read_sets(r, points_in_set) : result;
    if (result == STP_OK && needs_wide(r)) {
        free_sets(r);
        r->wide = true;
        result = read_sets(r, points_in_set);
    }
    if (result == STP_OK) {
        drop_unseen(r);
        result = add_sets(r);
    }
    return result;
}

stp_result stp_las_read_points(stp_las* las, uint64_t points_in_set)
{
    stp_result result = las->compressed ? stp_laz_read_table(las) : stp_las_list_records(las);
    uint64_t maximum = las->import->desc.sample_points;
    stp_place_sample places = {0};
    if (result == STP_OK && las->chunk_count > 0) { // before a sample is taken: for both alike
        result = sample_places(las, &places);
    }
    if (result == STP_OK && maximum != 0) {
        result = stp_las_sample(las, maximum);
        if (result == STP_OK && las->chunk_count == 0) {
            return STP_OK;
        }
    }
    if (result != STP_OK) {
        return result;
    }
    if (las->chunk_count == 0 || las->point_count == 0) {
        return STP_OK;
    }
    if (las->chunks[0].size < las->record_size) {
        return stp_fail(las->context, STP_ERROR_FORMAT, "%s: chunk 0 is too small for its points",
                        las->import->path);
    }
    reading r = {.las = las};
    atomic_init(&r.bad_chunk, SIZE_MAX);
    atomic_init(&r.no_memory, false);
    atomic_init(&r.seen, 0);
    choose_origin(las, &places);
    result = read_all(&r, points_in_set);
    destroy_workers(&r);
    free_sets(&r);
    stp_free(las->context, r.sets);
    return result;
}
