// SPDX-License-Identifier: MIT
#include "base/splats/progressive.h"
#include "base/splats/splat_codes.h"
#include "base/splats/splat_columns.h"
#include "lod/psp/forest.h"

#include <assert.h>
#include <stdlib.h>

/// Minimum level of a merge: the smallest normal float
#define MIN_CODE 0x100u
#define PI 3.14159265358979323846
#define LEVEL_MAX 1e30f ///< maximum level of a merge: finite

/// A remaining splat.
typedef struct root {
    float level;
    uint32_t splat;
    uint32_t order; ///< of equal levels, the lower one comes first
} root;

typedef struct splitter {
    const stp_psp_forest* forest;
    stp_psp_sequence* sequence;
    stp_progressive_queue queue; ///< places in the sequence
} splitter;

/// Level of a splat: radius of a disk with the area of the largest error among its merge and all
/// merges below it. 0 for samples.
static float level_of(const stp_psp_forest* f, uint32_t splat)
{
    if (splat < f->point_count) {
        return 0.0f;
    }
    return fminf((float)sqrt(f->merges[splat - f->point_count].level / PI), LEVEL_MAX);
}

/// Appends a splat.
/// @param highest maximum level at which it is drawn
static void append(splitter* s, uint32_t splat, float highest)
{
    const stp_psp_forest* f = s->forest;
    stp_psp_sequence* q = s->sequence;
    bool merged = splat >= f->point_count;
    assert(q->count < (size_t)f->point_count + f->merge_count && "each splat once");
    assert(highest >= level_of(f, splat) && "levels of parts are at most that of their merge");
    uint32_t code = stp_range_code(level_of(f, splat), highest);
    if (merged && (code & 0xFFFFu) < MIN_CODE) {
        code = (code & 0xFFFF0000u) | MIN_CODE;
    }
    if (code >> 16 < MIN_CODE) {
        code = (code & 0xFFFFu) | MIN_CODE << 16;
    }
    q->splats[q->count] = splat;
    q->ranges[q->count] = code;
    q->highest_left[q->count] = highest;
    stp_progressive_queue_add(&s->queue, q->count);
    q->count += 1;
}

static int compare_roots(const void* a, const void* b)
{
    const root *l = a, *r = b;
    if (l->level != r->level) {
        return l->level > r->level ? -1 : 1;
    }
    return l->order < r->order ? -1 : 1;
}

static void append_roots(splitter* s, root* roots)
{
    const stp_psp_forest* f = s->forest;
    uint32_t count = 0;
    for (uint32_t i = 0; i < f->point_count + f->merge_count; ++i) {
        if (f->parents[i] == UINT32_MAX) {
            roots[count++] = (root){level_of(f, i), i, f->ranked ? UINT32_MAX - i : i};
        }
    }
    qsort(roots, count, sizeof(*roots), compare_roots);
    for (uint32_t i = 0; i < count; ++i) {
        append(s, roots[i].splat, HUGE_VALF);
    }
}

/// Highest level of a part: the lowest level of its merge, plus the maximum difference of levels
/// between their positions. Ranks are the same everywhere.
static float find_highest(const splitter* s, uint32_t merge, uint32_t part)
{
    const stp_psp_forest* f = s->forest;
    if (f->ranked) {
        return level_of(f, f->point_count + merge);
    }
    stp_vec3 d = stp_sub(f->ellipses[part].center, f->ellipses[f->point_count + merge].center);
    return (level_of(f, f->point_count + merge) + STP_LEVEL_SLOPE * stp_length(d)) * 1.000001f;
}

static void split(splitter* s)
{
    const stp_psp_forest* f = s->forest;
    for (uint32_t place = stp_progressive_queue_take(&s->queue); place != UINT32_MAX;
         place = stp_progressive_queue_take(&s->queue)) {
        assert(s->sequence->splats[place] >= f->point_count && "points are never split");
        uint32_t merge = s->sequence->splats[place] - f->point_count;
        uint32_t left = f->merges[merge].left, right = f->merges[merge].right;
        append(s, left, find_highest(s, merge, left));
        append(s, right, find_highest(s, merge, right));
    }
    assert(s->sequence->count == f->point_count + f->merge_count);
    float highest = 0.0f;
    for (uint32_t i = s->sequence->count; i-- > 0;) {
        highest = fmaxf(highest, s->sequence->highest_left[i]);
        s->sequence->highest_left[i] = highest;
    }
}

stp_result stp_psp_sequence_make(stp_context* context, const stp_psp_forest* forest,
                                 stp_psp_sequence* sequence)
{
    size_t all = (size_t)forest->point_count + forest->merge_count + 1;
    *sequence = (stp_psp_sequence){.splats = STP_NEW_ARRAY(context, uint32_t, all),
                                   .ranges = STP_NEW_ARRAY(context, uint32_t, all),
                                   .highest_left = STP_NEW_ARRAY(context, float, all)};
    uint32_t* heap = STP_NEW_ARRAY(context, uint32_t, all);
    root* roots = STP_NEW_ARRAY(context, root, all);
    bool made = sequence->splats != NULL && sequence->ranges != NULL &&
                sequence->highest_left != NULL && heap != NULL && roots != NULL;
    if (made) {
        splitter s = {.forest = forest,
                      .sequence = sequence,
                      .queue = stp_progressive_queue_begin(sequence->ranges, 0, 0, heap)};
        append_roots(&s, roots);
        split(&s);
    }
    stp_free(context, heap);
    stp_free(context, roots);
    return made ? STP_OK : stp_fail_memory(context);
}

stp_result stp_psp_sequence_shorten(stp_context* context, stp_psp_sequence* sequence,
                                    uint32_t limit, float* left_out)
{
    uint32_t base = stp_progressive_count(sequence->ranges, sequence->count).base;
    uint64_t kept = limit > base ? 2 * (uint64_t)limit - base : base;
    *left_out = 0.0f;
    if (kept >= sequence->count) {
        return STP_OK;
    }
    uint32_t* heap = STP_NEW_ARRAY(context, uint32_t, (size_t)kept + 1);
    if (heap == NULL) {
        return stp_fail_memory(context);
    }
    uint32_t splits = ((uint32_t)kept - base) / 2;
    stp_progressive_queue waiting =
        stp_progressive_queue_begin(sequence->ranges, (uint32_t)kept, splits, heap);
    for (uint32_t i = 0; i < waiting.count; ++i) {
        sequence->ranges[waiting.heap[i]] &= 0xFFFF0000u;
    }
    *left_out = stp_range_level(stp_range_code(0.0f, sequence->highest_left[kept]) >> 16);
    sequence->count = (uint32_t)kept;
    stp_free(context, heap);
    return STP_OK;
}

void stp_psp_sequence_destroy(stp_context* context, stp_psp_sequence* sequence)
{
    stp_free(context, sequence->splats);
    stp_free(context, sequence->ranges);
    stp_free(context, sequence->highest_left);
    *sequence = (stp_psp_sequence){.count = 0};
}
