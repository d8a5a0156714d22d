// SPDX-License-Identifier: MIT
// Selects a few points all over a LAS file for a first picture.
#include "import/las/las.h"

#include <assert.h>
#include <string.h>

enum {
    RUN = 64,      // uncompressed records that follow one another
    MIN_SAVING = 4 // a file with fewer times the points is soon read as a whole
};

// Uncompressed files: runs at even distances.
static stp_result sample_records(stp_las* las, uint64_t maximum)
{
    assert(maximum > 0);
    uint64_t runs = (maximum + RUN - 1) / RUN, step = las->point_count / runs;
    stp_las_chunk* chunks = STP_NEW_ARRAY(las->context, stp_las_chunk, (size_t)runs);
    if (chunks == NULL) {
        return stp_fail_memory(las->context);
    }
    assert(runs == 1 || step >= RUN);
    stp_free(las->context, las->chunks);
    las->chunks = chunks;
    las->chunk_count = (size_t)runs;
    // several runs do not overlap: there are at least four times as many points as `maximum`
    for (uint64_t i = 0; i < runs; ++i) {
        uint64_t first = i * step;
        uint64_t left = las->point_count - first, count = left < RUN ? left : RUN;
        assert(first < las->point_count && count > 0);
        chunks[i] = (stp_las_chunk){.offset = las->points + first * las->record_size,
                                    .size = count * las->record_size,
                                    .count = count,
                                    .read = count};
    }
    return STP_OK;
}

// The first points of each chunk; if there are many small chunks, of evenly spaced ones.
static void sample_chunks(stp_las* las, uint64_t maximum)
{
    uint64_t each = (maximum + las->chunk_count - 1) / las->chunk_count;
    each = each < RUN ? RUN : each;
    assert(maximum > 0 && las->chunk_count > 0 && each > 0);
    uint64_t wanted = (maximum + each - 1) / each;
    size_t step = (size_t)(las->chunk_count / wanted);
    step = step > 0 ? step : 1;
    for (size_t i = 0; i < las->chunk_count; ++i) {
        stp_las_chunk* c = &las->chunks[i];
        uint64_t share = i % step == 0 ? each : 0;
        c->read = share < c->count ? share : c->count;
    }
}

// Removes chunks that are not read, and assigns consecutive positions in the set.
static void compact_chunks(stp_las* las)
{
    size_t kept = 0;
    uint64_t first = 0;
    for (size_t i = 0; i < las->chunk_count; ++i) {
        stp_las_chunk c = las->chunks[i];
        if (c.read > 0) {
            c.first = first;
            first += c.read;
            las->chunks[kept++] = c;
        }
    }
    assert(kept <= las->chunk_count && first <= las->point_count);
    las->chunk_count = kept;
}

stp_result stp_las_sample(stp_las* las, uint64_t maximum)
{
    assert(maximum > 0);
    stp_result result = STP_OK;
    if (las->point_count / MIN_SAVING < maximum || las->chunk_count == 0) {
        las->chunk_count = 0;
        return STP_OK;
    }
    if (!las->compressed) {
        result = sample_records(las, maximum);
    } else if (!stp_las_sample_copc(las, maximum)) {
        sample_chunks(las, maximum);
    }
    if (result == STP_OK) {
        compact_chunks(las);
    }
    return result;
}
