// SPDX-License-Identifier: MIT
#include "lod/spt/sequence.h"

#include "base/sort.h"

#include <string.h>

static double distance_between(stp_vec3d a, stp_vec3d b)
{
    stp_vec3d d = stp_subd(a, b);
    return sqrt(d.x * d.x + d.y * d.y + d.z * d.z);
}

// The least float that is not below a number.
static float round_up(double x)
{
    float nearest = (float)x;
    return (double)nearest < x ? nextafterf(nearest, HUGE_VALF) : nearest;
}

// The bits of a number that is not negative are ordered as it is.
static uint32_t bits_of(float x)
{
    uint32_t bits;
    memcpy(&bits, &x, sizeof(bits));
    return bits;
}

// The highest levels of all nodes: a parent is passed before its children.
static void find_highest(const stp_point_tree* tree, double most_allowed, float* highest)
{
    highest[0] = HUGE_VALF;
    for (uint32_t parent = 0; parent < tree->count; ++parent) {
        for (uint32_t c = parent + 1; c < tree->ends[parent]; c = tree->ends[c]) {
            double apart = distance_between(stp_to_double(tree->disks[c].center),
                                            stp_to_double(tree->disks[parent].center));
            // a little more, for what rounding takes of levels
            highest[c] =
                round_up(((double)tree->errors[parent] + apart * most_allowed) * (1.0 + 1e-9));
        }
    }
}

stp_result stp_point_sequence_make(stp_context* context, const stp_point_tree* tree,
                                   double most_allowed, stp_point_sequence* sequence)
{
    size_t count = tree->count;
    *sequence = (stp_point_sequence){
        .count = tree->count,
        .nodes = STP_NEW_ARRAY(context, uint32_t, count + 1),
        .centers = STP_NEW_ARRAY(context, stp_vec3, count + 1),
        .lowest = STP_NEW_ARRAY(context, float, count + 1),
        .highest = STP_NEW_ARRAY(context, float, count + 1),
    };
    float* highest = STP_NEW_ARRAY(context, float, count + 1);
    uint64_t* keys = STP_NEW_ARRAY(context, uint64_t, count + 1);
    uint64_t* scratch = STP_NEW_ARRAY(context, uint64_t, count + 1);
    bool made = sequence->nodes != NULL && sequence->centers != NULL && sequence->lowest != NULL &&
                sequence->highest != NULL && highest != NULL && keys != NULL && scratch != NULL;
    if (made) {
        find_highest(tree, most_allowed, highest);
        for (uint32_t i = 0; i < tree->count; ++i) {
            keys[i] = (uint64_t)~bits_of(highest[i]) << 32 | i;
        }
        const uint64_t* sorted = stp_sort_u64(keys, scratch, count, 32, 32);
        for (uint32_t i = 0; i < tree->count; ++i) {
            uint32_t node = (uint32_t)sorted[i];
            sequence->nodes[i] = node;
            sequence->centers[i] = tree->disks[node].center;
            sequence->lowest[i] = tree->errors[node];
            sequence->highest[i] = highest[node];
        }
    }
    stp_free(context, highest);
    stp_free(context, keys);
    stp_free(context, scratch);
    if (!made) {
        stp_point_sequence_destroy(context, sequence);
        return stp_fail_memory(context);
    }
    return STP_OK;
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
    uint32_t count = 0;
    for (uint32_t i = range.begin; i < range.end; ++i) {
        double distance = distance_between(view->eye, stp_to_double(sequence->centers[i]));
        double level = view->allowed * distance;
        nodes[count] = sequence->nodes[i]; // is written over by the next where it is not selected
        count += level >= (double)sequence->lowest[i] && level <= (double)sequence->highest[i];
    }
    return count;
}
