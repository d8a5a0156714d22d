// SPDX-License-Identifier: MIT
#include "lod/spt/sequence.h"

#include "base/core/sort.h"
#include "lod/spt/split_errors.h"

#include <assert.h>
#include <string.h>

static double distance_between(stp_vec3d a, stp_vec3d b)
{
    stp_vec3d d = stp_subd(a, b);
    return sqrt(d.x * d.x + d.y * d.y + d.z * d.z);
}

// Smallest float that is not below a number.
static float round_up(double x)
{
    float nearest = (float)x;
    return (double)nearest < x ? nextafterf(nearest, HUGE_VALF) : nearest;
}

float stp_point_sequence_highest(const stp_point_tree* tree, uint32_t parent, uint32_t child,
                                 double max_allowed)
{
    assert(parent < child && child < tree->ends[parent]);
    double apart = distance_between(stp_to_double(tree->disks[child].center),
                                    stp_to_double(tree->disks[parent].center));
    // slightly more, to allow for the rounding of levels
    return round_up(((double)tree->errors[parent] + apart * max_allowed) * (1.0 + 1e-9));
}

// Bits of a nonnegative float, which sort like the float.
static uint32_t bits_of(float x)
{
    assert(!(x < 0.0f) && "bits of negative floats sort the other way");
    uint32_t bits;
    memcpy(&bits, &x, sizeof(bits));
    return bits;
}

enum { GRAIN = 8192 }; ///< nodes

typedef struct maker {
    const stp_point_tree* tree;
    double max_allowed;
    bool split;
    stp_point_sequence* sequence;
    float* highest;           ///< per node
    uint64_t *keys, *scratch; ///< per node
    const uint64_t* sorted;   ///< sorted keys: `keys` or `scratch`
} maker;

// Computes the highest levels of the children of some nodes.
static void find_highest(size_t begin, size_t end, uint32_t worker, void* user)
{
    const maker* m = user;
    const stp_point_tree* tree = m->tree;
    (void)worker;
    for (uint32_t parent = (uint32_t)begin; parent < end; ++parent) {
        double allowed = m->max_allowed * (m->split ? stp_split_overlap(tree, parent) : 1.0);
        for (uint32_t c = parent + 1; c < tree->ends[parent]; c = tree->ends[c]) {
            m->highest[c] = stp_point_sequence_highest(tree, parent, c, allowed);
            m->keys[c] = (uint64_t)~bits_of(m->highest[c]) << 32 | c;
        }
    }
}

static void fill_sequence(size_t begin, size_t end, uint32_t worker, void* user)
{
    const maker* m = user;
    stp_point_sequence* s = m->sequence;
    (void)worker;
    for (size_t i = begin; i < end; ++i) {
        uint32_t node = (uint32_t)m->sorted[i];
        s->nodes[i] = node;
        s->centers[i] = m->tree->disks[node].center;
        s->lowest[i] = m->tree->errors[node];
        s->highest[i] = m->highest[node];
        assert((i == begin || !(s->highest[i] > s->highest[i - 1])) && "descending");
    }
}

static stp_result fill(stp_context* context, maker* m)
{
    stp_point_sequence* s = m->sequence;
    if (s->nodes == NULL || s->centers == NULL || s->lowest == NULL || s->highest == NULL ||
        m->highest == NULL || m->keys == NULL || m->scratch == NULL) {
        return stp_fail_memory(context);
    }
    m->highest[0] = HUGE_VALF;
    m->keys[0] = (uint64_t)~bits_of(HUGE_VALF) << 32;
    stp_parallel_for(context, s->count, GRAIN, find_highest, m);
    m->sorted = stp_parallel_sort_u64(context, m->keys, m->scratch, s->count, 32, 32);
    if (m->sorted == NULL) {
        return stp_fail_memory(context);
    }
    assert((uint32_t)m->sorted[0] == 0 && "the root, for all high levels, comes first");
    stp_parallel_for(context, s->count, GRAIN, fill_sequence, m);
    return STP_OK;
}

stp_result stp_point_sequence_make(stp_context* context, const stp_point_tree* tree,
                                   double max_allowed, bool split, stp_point_sequence* sequence)
{
    assert(max_allowed >= 0.0);
    size_t count = tree->count;
    *sequence = (stp_point_sequence){
        .count = tree->count,
        .nodes = STP_NEW_ARRAY(context, uint32_t, count + 1),
        .centers = STP_NEW_ARRAY(context, stp_vec3, count + 1),
        .lowest = STP_NEW_ARRAY(context, float, count + 1),
        .highest = STP_NEW_ARRAY(context, float, count + 1),
    };
    maker m = {
        .tree = tree,
        .max_allowed = max_allowed,
        .split = split,
        .sequence = sequence,
        .highest = STP_NEW_ARRAY(context, float, count + 1),
        .keys = STP_NEW_ARRAY(context, uint64_t, count + 1),
        .scratch = STP_NEW_ARRAY(context, uint64_t, count + 1),
    };
    stp_result result = fill(context, &m);
    stp_free(context, m.highest);
    stp_free(context, m.keys);
    stp_free(context, m.scratch);
    if (result != STP_OK) {
        stp_point_sequence_destroy(context, sequence);
    }
    return result;
}

void stp_point_sequence_destroy(stp_context* context, stp_point_sequence* sequence)
{
    stp_free(context, sequence->nodes);
    stp_free(context, sequence->centers);
    stp_free(context, sequence->lowest);
    stp_free(context, sequence->highest);
    *sequence = (stp_point_sequence){0};
}

stp_sequence_range stp_point_sequence_range(const stp_point_sequence* sequence, double allowed,
                                            double nearest, double farthest)
{
    assert(!(farthest < nearest));
    uint32_t low = 0, high = sequence->count;
    while (low < high) {
        uint32_t middle = low + (high - low) / 2;
        if ((double)sequence->highest[middle] >= allowed * nearest) {
            low = middle + 1;
        } else {
            high = middle;
        }
    }
    stp_sequence_range range = {0, low};
    while (range.begin < range.end && (double)sequence->lowest[range.begin] > allowed * farthest) {
        range.begin += 1;
    }
    return range;
}

uint32_t stp_point_sequence_select(const stp_point_sequence* sequence, const stp_tree_view* view,
                                   stp_sequence_range range, uint32_t* nodes)
{
    assert(range.begin <= range.end && range.end <= sequence->count);
    uint32_t count = 0;
    for (uint32_t i = range.begin; i < range.end; ++i) {
        double distance = distance_between(view->eye, stp_to_double(sequence->centers[i]));
        double level = view->allowed * distance;
        nodes[count] = sequence->nodes[i]; // overwritten by the next node unless selected
        count += level >= (double)sequence->lowest[i] && level <= (double)sequence->highest[i];
    }
    return count;
}
