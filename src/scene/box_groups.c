// SPDX-License-Identifier: MIT
//
// Top-down: splits a range of boxes where the surface area heuristic is smallest (MacDonald and
// Booth 1990; binned, Wald 2007), then its largest part again, until all parts can be groups or
// there are as many as a group may have children.
#include "scene/partition_steps.h"

#include <assert.h>
#include <string.h>

#define BIN_COUNT 16
// Deeper ranges are halved, which bounds the time on hostile input.
#define DEEPEST 48u

typedef struct range {
    uint32_t first, count, depth;
} range;

typedef struct bin {
    stp_boxd box;
    uint32_t count;
} bin;

// Splitting plane between two bins of an axis.
typedef struct plane {
    double cost;
    int axis, bin; ///< boxes in bins below `bin` are on its left
} plane;

static double component(stp_vec3d v, int axis)
{
    return axis == 0 ? v.x : axis == 1 ? v.y : v.z;
}

static stp_vec3d centre_of(const stp_boxd* box)
{
    return (stp_vec3d){0.5 * box->min.x + 0.5 * box->max.x, 0.5 * box->min.y + 0.5 * box->max.y,
                       0.5 * box->min.z + 0.5 * box->max.z};
}

static double half_area(const stp_boxd* box)
{
    if (stp_boxd_is_empty(*box)) {
        return 0.0;
    }
    stp_vec3d size = stp_subd(box->max, box->min);
    return size.x * size.y + size.y * size.z + size.z * size.x;
}

static void add_box(stp_boxd* sum, const stp_boxd* box)
{
    if (!stp_boxd_is_empty(*box)) {
        stp_boxd_add(sum, box->min);
        stp_boxd_add(sum, box->max);
    }
}

static int bin_of(double centre, double low, double size)
{
    double t = (centre - low) / size * BIN_COUNT;
    assert(size > 0.0);
    return !(t > 0.0) ? 0 : t < BIN_COUNT - 1 ? (int)t : BIN_COUNT - 1;
}

// The best plane of one axis.
static void try_axis(const stp_boxd* boxes, const uint32_t* order, const range* r,
                     const stp_boxd* centres, int axis, plane* best)
{
    double low = component(centres->min, axis);
    double size = component(centres->max, axis) - low;
    if (!(size > 0.0) || size > DBL_MAX) {
        return;
    }
    bin bins[BIN_COUNT];
    for (int i = 0; i < BIN_COUNT; ++i) {
        bins[i] = (bin){.box = stp_boxd_empty()};
    }
    for (uint32_t i = r->first; i < r->first + r->count; ++i) {
        const stp_boxd* box = &boxes[order[i]];
        bin* b = &bins[bin_of(component(centre_of(box), axis), low, size)];
        b->count += 1;
        add_box(&b->box, box);
    }
    double right_cost[BIN_COUNT];
    stp_boxd box = stp_boxd_empty();
    uint32_t count = 0;
    for (int i = BIN_COUNT - 1; i > 0; --i) {
        count += bins[i].count;
        add_box(&box, &bins[i].box);
        right_cost[i] = count == 0 ? -1.0 : half_area(&box) * (double)count;
    }
    box = stp_boxd_empty();
    count = 0;
    for (int i = 1; i < BIN_COUNT; ++i) {
        count += bins[i - 1].count;
        add_box(&box, &bins[i - 1].box);
        double cost = half_area(&box) * (double)count + right_cost[i];
        if (count > 0 && right_cost[i] >= 0.0 && cost < best->cost) {
            *best = (plane){.cost = cost, .axis = axis, .bin = i};
        }
    }
}

// Moves the boxes left of the plane to the front. @return how many
static uint32_t separate(const stp_boxd* boxes, uint32_t* order, const range* r,
                         const stp_boxd* centres, const plane* p)
{
    double low = component(centres->min, p->axis);
    double size = component(centres->max, p->axis) - low;
    uint32_t left = r->first, right = r->first + r->count;
    while (left < right) {
        double centre = component(centre_of(&boxes[order[left]]), p->axis);
        if (bin_of(centre, low, size) < p->bin) {
            left += 1;
        } else {
            uint32_t swap = order[left];
            order[left] = order[--right];
            order[right] = swap;
        }
    }
    return left - r->first;
}

// Splits a range of at least two boxes; neither side is empty.
static void split(const stp_boxd* boxes, uint32_t* order, range* r, range* other)
{
    uint32_t left = r->count / 2;
    if (r->depth < DEEPEST) {
        stp_boxd centres = stp_boxd_empty();
        for (uint32_t i = r->first; i < r->first + r->count; ++i) {
            stp_boxd_add(&centres, centre_of(&boxes[order[i]]));
        }
        plane best = {.cost = DBL_MAX, .axis = -1};
        for (int axis = 0; axis < 3; ++axis) {
            try_axis(boxes, order, r, &centres, axis, &best);
        }
        if (best.axis >= 0) {
            left = separate(boxes, order, r, &centres, &best);
        }
    }
    assert(left > 0 && left < r->count);
    *other = (range){r->first + left, r->count - left, r->depth + 1};
    *r = (range){r->first, left, r->depth + 1};
}

static stp_result add_group(stp_context* context, stp_grouping* grouping, const range* r)
{
    if (!STP_MAKE_ROOM(context, grouping->groups, grouping->group_capacity,
                       grouping->group_count + 1)) {
        return stp_fail_memory(context);
    }
    grouping->groups[grouping->group_count++] =
        (stp_group){.first = r->first, .count = r->count, .depth = r->depth};
    return STP_OK;
}

// Splits a group with too many boxes into children.
static stp_result open_group(stp_context* context, const stp_boxd* boxes, uint32_t maximum,
                             stp_grouping* grouping, size_t index)
{
    range parts[STP_GROUP_LIMIT];
    stp_group* group = &grouping->groups[index];
    parts[0] = (range){group->first, group->count, group->depth};
    uint32_t part_count = 1;
    while (part_count < maximum) {
        uint32_t largest = 0;
        for (uint32_t i = 1; i < part_count; ++i) {
            largest = parts[i].count > parts[largest].count ? i : largest;
        }
        if (parts[largest].count <= maximum) {
            break;
        }
        split(boxes, grouping->order, &parts[largest], &parts[part_count]);
        part_count += 1;
    }
    assert(part_count >= 2 && part_count <= maximum);
    group->first_child = (uint32_t)grouping->group_count;
    group->child_count = part_count;
    stp_result result = STP_OK;
    for (uint32_t i = 0; result == STP_OK && i < part_count; ++i) {
        result = add_group(context, grouping, &parts[i]);
    }
    return result;
}

stp_result stp_group_boxes(stp_context* context, const stp_boxd* boxes, uint32_t count,
                           uint32_t maximum, stp_grouping* grouping)
{
    assert(count > 0 && maximum >= 2 && maximum <= STP_GROUP_LIMIT);
    if (!STP_MAKE_ROOM(context, grouping->order, grouping->order_capacity, count)) {
        return stp_fail_memory(context);
    }
    grouping->group_count = 0;
    for (uint32_t i = 0; i < count; ++i) {
        grouping->order[i] = i;
    }
    stp_result result = add_group(context, grouping, &(range){.count = count});
    for (size_t i = 0; result == STP_OK && i < grouping->group_count; ++i) {
        if (grouping->groups[i].count > maximum) {
            result = open_group(context, boxes, maximum, grouping, i);
        }
    }
    return result;
}

void stp_grouping_destroy(stp_context* context, stp_grouping* grouping)
{
    stp_free(context, grouping->order);
    stp_free(context, grouping->groups);
    *grouping = (stp_grouping){0};
}
