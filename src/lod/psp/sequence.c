// SPDX-License-Identifier: MIT
#include "lod/psp/sequence.h"

#include "base/splat_codes.h"

#include <stipple/surfels.h>

#include <stdlib.h>

#define LEAST_CODE                                                                                 \
    0x100u ///< of the level of a merge: that of the least float that no processor takes for 0
#define PI 3.14159265358979323846

/// A splat that waits to be split. Splats are split by falling level, then by rising place.
typedef struct waiting {
    uint32_t low, place;
} waiting;

typedef struct splitter {
    const stp_psp_forest* forest;
    stp_psp_sequence* sequence;
    float* levels; ///< of merges
    waiting* heap; ///< a binary heap
    uint32_t heap_count;
} splitter;

static bool is_before(waiting a, waiting b)
{
    return a.low != b.low ? a.low > b.low : a.place < b.place;
}

static void push(splitter* s, waiting w)
{
    uint32_t at = s->heap_count++;
    while (at > 0 && is_before(w, s->heap[(at - 1) / 2])) {
        s->heap[at] = s->heap[(at - 1) / 2];
        at = (at - 1) / 2;
    }
    s->heap[at] = w;
}

static waiting pop(splitter* s)
{
    waiting first = s->heap[0], last = s->heap[--s->heap_count];
    uint32_t at = 0;
    for (uint32_t child = 1; child < s->heap_count; child = 2 * at + 1) {
        if (child + 1 < s->heap_count && is_before(s->heap[child + 1], s->heap[child])) {
            child += 1;
        }
        if (!is_before(s->heap[child], last)) {
            break;
        }
        s->heap[at] = s->heap[child];
        at = child;
    }
    s->heap[at] = last;
    return first;
}

/// The level of a merge is the radius of a disk as large as its error, and at least the levels of what was merged.
static void find_levels(splitter* s)
{
    const stp_psp_forest* f = s->forest;
    for (uint32_t i = 0; i < f->merge_count; ++i) {
        float level = (float)sqrt(f->merges[i].error / PI);
        const uint32_t parts[2] = {f->merges[i].left, f->merges[i].right};
        for (int p = 0; p < 2; ++p) {
            if (parts[p] >= f->point_count) {
                level = fmaxf(level, s->levels[parts[p] - f->point_count]);
            }
        }
        s->levels[i] = fminf(level, 1e30f);
    }
}

/// Appends a splat. @param highest level up to which it is drawn
static void append(splitter* s, uint32_t splat, float highest)
{
    const stp_psp_forest* f = s->forest;
    stp_psp_sequence* q = s->sequence;
    bool merged = splat >= f->point_count;
    uint32_t code = stp_range_code(merged ? s->levels[splat - f->point_count] : 0.0f, highest);
    if (merged && (code & 0xFFFFu) < LEAST_CODE) {
        code = (code & 0xFFFF0000u) | LEAST_CODE;
    }
    if (code >> 16 < LEAST_CODE) {
        code = (code & 0xFFFFu) | LEAST_CODE << 16;
    }
    q->splats[q->count] = splat;
    q->ranges[q->count] = code;
    q->highest_left[q->count] = highest;
    if (merged) {
        push(s, (waiting){code & 0xFFFFu, q->count});
    }
    q->count += 1;
}

static int compare_roots(const void* a, const void* b)
{
    const waiting *l = a, *r = b;
    return is_before(*l, *r) ? -1 : 1;
}

static void append_roots(splitter* s, waiting* roots)
{
    const stp_psp_forest* f = s->forest;
    uint32_t count = 0;
    for (uint32_t i = 0; i < f->point_count + f->merge_count; ++i) {
        if (f->parents[i] == UINT32_MAX) {
            float level = i >= f->point_count ? s->levels[i - f->point_count] : 0.0f;
            roots[count++] = (waiting){stp_bits_of_float(level), i};
        }
    }
    qsort(roots, count, sizeof(*roots), compare_roots);
    for (uint32_t i = 0; i < count; ++i) {
        append(s, roots[i].place, HUGE_VALF);
    }
}

/// The highest level of a part is the one below which its merge is not drawn, and more by how much levels may differ because
/// the two lie in different places.
static float find_highest(const splitter* s, uint32_t merge, uint32_t part)
{
    const stp_psp_forest* f = s->forest;
    stp_vec3 d = stp_sub(f->ellipses[part].center, f->ellipses[f->point_count + merge].center);
    return (s->levels[merge] + STP_LEVEL_SLOPE * stp_length(d)) * 1.000001f;
}

static void split(splitter* s)
{
    const stp_psp_forest* f = s->forest;
    while (s->heap_count > 0) {
        uint32_t merge = s->sequence->splats[pop(s).place] - f->point_count;
        uint32_t left = f->merges[merge].left, right = f->merges[merge].right;
        append(s, left, find_highest(s, merge, left));
        append(s, right, find_highest(s, merge, right));
    }
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
    splitter s = {.forest = forest,
                  .sequence = sequence,
                  .levels = STP_NEW_ARRAY(context, float, all),
                  .heap = STP_NEW_ARRAY(context, waiting, all)};
    waiting* roots = STP_NEW_ARRAY(context, waiting, all);
    bool made = sequence->splats != NULL && sequence->ranges != NULL &&
                sequence->highest_left != NULL && s.levels != NULL && s.heap != NULL &&
                roots != NULL;
    if (made) {
        find_levels(&s);
        append_roots(&s, roots);
        split(&s);
    }
    stp_free(context, s.levels);
    stp_free(context, s.heap);
    stp_free(context, roots);
    return made ? STP_OK : stp_fail_memory(context);
}

void stp_psp_sequence_destroy(stp_context* context, stp_psp_sequence* sequence)
{
    stp_free(context, sequence->splats);
    stp_free(context, sequence->ranges);
    stp_free(context, sequence->highest_left);
    *sequence = (stp_psp_sequence){.count = 0};
}
