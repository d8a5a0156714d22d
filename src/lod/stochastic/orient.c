// SPDX-License-Identifier: MIT
#include "base/splats/leaf_codes.h"
#include "lod/psp/kd_tree.h"
#include "lod/stochastic/leaf_passes.h"

#include <assert.h>
#include <string.h>

enum {
    BRIDGE_LEAVES = 128, ///< leaves of a component from which a bridge across a gap is searched
    BRIDGES_MAX = 64,    ///< maximum number of components for which a bridge is searched
    WORDS = 64,          ///< words with a bit for each of 64 buckets
};
#define CERTAIN 0.7f    // a start that faces its way at least as much needs no other
#define ACROSS 0.5f     // weight of a step perpendicular to a surface
#define WEIGHT_MAX 3.5f // maximum weight of a step
#define GAP 4.0f        // maximum gap, relative to the sum of both leaves' sides

/// A step from an oriented leaf to another one.
typedef struct orient_step {
    uint32_t to, from;
    uint32_t next; ///< next step in the same bucket; UINT32_MAX: none
} orient_step;

/// Steps in buckets of about the same weight; the last one that was added to a bucket comes first.
typedef struct step_queue {
    orient_step* steps;
    uint32_t count;              ///< steps that were ever added
    uint64_t filled;             ///< one bit per word
    uint64_t words[WORDS];       ///< one bit per bucket that is not empty
    uint32_t firsts[64 * WORDS]; ///< first step of each bucket that is not empty
} step_queue;

typedef struct orienter {
    const stp_leaf_octree* octree;
    stp_leaf_properties* properties;
    uint32_t count, near;
    float* places;        ///< 3 per leaf
    uint32_t* neighbours; ///< `near` entries per leaf; UINT32_MAX: none
    uint32_t* begins;     ///< start of each leaf's links, count + 1
    uint32_t* links;      ///< neighbours in both directions
    uint32_t* components; ///< per leaf: first leaf of its component
    bool* done;
    uint16_t* waiting; ///< per leaf: lowest bucket with a step to it; UINT16_MAX: none
    step_queue queue;
} orienter;

static uint32_t bucket_of(float weight)
{
    float place = weight * ((float)(64 * WORDS) / WEIGHT_MAX);
    return place < (float)(64 * WORDS - 1) ? (uint32_t)place : 64 * WORDS - 1;
}

static void push(step_queue* q, uint32_t bucket, uint32_t to, uint32_t from)
{
    assert(bucket < 64 * WORDS);
    uint64_t bit = UINT64_C(1) << bucket % 64, word_bit = UINT64_C(1) << bucket / 64;
    uint32_t next = (q->words[bucket / 64] & bit) != 0 ? q->firsts[bucket] : UINT32_MAX;
    q->steps[q->count] = (orient_step){to, from, next};
    q->firsts[bucket] = q->count++;
    q->words[bucket / 64] |= bit;
    q->filled |= word_bit;
}

/// A step of the least weight. The queue must not be empty.
static orient_step pop(step_queue* q)
{
    assert(q->filled != 0);
    uint32_t word = (uint32_t)__builtin_ctzll(q->filled);
    assert(q->words[word] != 0 && "bits of words and of buckets agree");
    uint32_t bucket = 64 * word + (uint32_t)__builtin_ctzll(q->words[word]);
    orient_step step = q->steps[q->firsts[bucket]];
    q->firsts[bucket] = step.next;
    if (step.next != UINT32_MAX) {
        __builtin_prefetch(&q->steps[step.next]);
    } else {
        q->words[word] &= q->words[word] - 1;
        q->filled &= q->words[word] == 0 ? q->filled - 1 : UINT64_MAX;
    }
    return step;
}

static stp_vec3 place_of(const orienter* o, uint32_t leaf)
{
    const float* p = o->places + 3 * (size_t)leaf;
    return (stp_vec3){p[0], p[1], p[2]};
}

/// Predicts the normal at another leaf, if the surface bends evenly between the two.
static stp_vec3 predict_normal(const orienter* o, uint32_t from, uint32_t to, stp_vec3* way)
{
    *way = stp_normalize(stp_sub(place_of(o, to), place_of(o, from)));
    stp_vec3 n = o->properties[from].normal;
    return stp_sub(n, stp_scale(*way, 2.0f * stp_dot(*way, n)));
}

/// Uncertainty of a leaf's normal: 0 if it is flat, 1 if it has few points.
static float uncertainty(const stp_leaf_properties* f)
{
    return f->known ? 3.0f * f->flatness : 1.0f;
}

/// Weight of a step: small if the sign is certain, and along a surface rather than to another one.
static float weigh(const orienter* o, uint32_t a, uint32_t b)
{
    stp_vec3 way, carried = predict_normal(o, a, b, &way);
    stp_vec3 n = o->properties[a].normal, m = o->properties[b].normal;
    float across = stp_max(fabsf(stp_dot(way, n)), fabsf(stp_dot(way, m)));
    return 1.0f - fabsf(stp_dot(carried, m)) + ACROSS * across * across +
           uncertainty(&o->properties[a]) + uncertainty(&o->properties[b]);
}

/// Turns the normal of a leaf to match another one.
static void turn(orienter* o, uint32_t to, uint32_t from)
{
    stp_vec3 way, carried = predict_normal(o, from, to, &way);
    if (stp_dot(carried, o->properties[to].normal) < 0.0f) {
        o->properties[to].normal = stp_scale(o->properties[to].normal, -1.0f);
    }
}

static void reach(orienter* o, uint32_t leaf)
{
    assert(!o->done[leaf] && "each leaf is reached once: steps have room for each link");
    o->done[leaf] = true;
    for (uint32_t i = o->begins[leaf]; i < o->begins[leaf + 1]; ++i) {
        uint32_t to = o->links[i];
        if (o->done[to]) {
            continue;
        }
        uint32_t bucket = bucket_of(weigh(o, leaf, to));
        if (bucket <= o->waiting[to]) { // else the waiting step is taken before this one
            o->waiting[to] = (uint16_t)bucket;
            push(&o->queue, bucket, to, leaf);
        }
    }
}

static void spread_from(orienter* o, uint32_t leaf)
{
    reach(o, leaf);
    while (o->queue.filled != 0) {
        orient_step step = pop(&o->queue);
        if (!o->done[step.to]) {
            turn(o, step.to, step.from);
            reach(o, step.to);
        }
    }
}

static bool is_neighbour(const orienter* o, uint32_t leaf, uint32_t of)
{
    const uint32_t* near = o->neighbours + (size_t)of * o->near;
    for (uint32_t i = 0; i < o->near; ++i) {
        if (near[i] == leaf) {
            return true;
        }
    }
    return false;
}

/// Keeps each pair of mutual neighbours in the list of the later leaf only.
static void drop_mutual(orienter* o)
{
    for (uint32_t leaf = 0; leaf < o->count; ++leaf) {
        uint32_t* near = o->neighbours + (size_t)leaf * o->near;
        for (uint32_t i = 0; i < o->near; ++i) {
            if (near[i] != UINT32_MAX && near[i] > leaf && is_neighbour(o, leaf, near[i])) {
                near[i] = UINT32_MAX;
            }
        }
    }
}

/// Links each leaf with its neighbours, in both directions, once.
static stp_result link_leaves(stp_context* context, orienter* o)
{
    stp_result result =
        stp_find_nearest_points(context, o->places, o->count, o->near, o->neighbours);
    if (result != STP_OK) {
        return result;
    }
    drop_mutual(o);
    size_t all = (size_t)o->near * o->count;
    memset(o->begins, 0, ((size_t)o->count + 2) * sizeof(*o->begins));
    for (size_t i = 0; i < all; ++i) {
        if (o->neighbours[i] != UINT32_MAX) {
            assert(o->neighbours[i] < o->count && o->neighbours[i] != i / o->near);
            o->begins[i / o->near + 2] += 1;
            o->begins[o->neighbours[i] + 2] += 1;
        }
    }
    for (uint32_t i = 2; i < o->count + 2; ++i) {
        o->begins[i] += o->begins[i - 1];
    }
    for (size_t i = 0; i < all; ++i) {
        if (o->neighbours[i] != UINT32_MAX) {
            uint32_t a = (uint32_t)(i / o->near), b = o->neighbours[i];
            o->links[o->begins[a + 1]++] = b;
            o->links[o->begins[b + 1]++] = a;
        }
    }
    assert(o->begins[0] == 0 && o->begins[o->count] == o->begins[o->count + 1] &&
           "all ends became starts");
    return STP_OK;
}

/// Finds the component of each leaf; uses the queue's memory as a stack.
static void find_components(orienter* o)
{
    uint32_t* stack = (uint32_t*)(void*)o->queue.steps;
    for (uint32_t i = 0; i < o->count; ++i) {
        o->components[i] = UINT32_MAX;
    }
    for (uint32_t first = 0; first < o->count; ++first) {
        size_t height = 0;
        if (o->components[first] == UINT32_MAX) {
            o->components[first] = first;
            stack[height++] = first;
        }
        while (height > 0) {
            assert(height <= o->count && "each leaf is stacked once");
            uint32_t leaf = stack[--height];
            for (uint32_t i = o->begins[leaf]; i < o->begins[leaf + 1]; ++i) {
                if (o->components[o->links[i]] == UINT32_MAX) {
                    o->components[o->links[i]] = first;
                    stack[height++] = o->links[i];
                }
            }
        }
    }
}

/// A leaf whose outward side is known: at an end of its component along an axis.
typedef struct orient_start {
    uint32_t leaf; ///< UINT32_MAX: none is left
    int axis;
    float sign;      ///< 1 or -1: its normal points that way along the axis
    float certainty; ///< at most 1
} orient_start;

static float along(stp_vec3 v, int axis)
{
    return axis == 0 ? v.x : axis == 1 ? v.y : v.z;
}

/// The unoriented leaf that reaches farthest along an axis, of a component or of all (UINT32_MAX).
static uint32_t find_end(const orienter* o, uint32_t component, int axis, float sign)
{
    uint32_t end = UINT32_MAX;
    for (uint32_t i = 0; i < o->count; ++i) {
        bool counts = !o->done[i] && (component == UINT32_MAX || o->components[i] == component);
        if (counts && (end == UINT32_MAX ||
                       sign * o->properties[i].mean[axis] > sign * o->properties[end].mean[axis])) {
            end = i;
        }
    }
    return end;
}

/// Among the unoriented leaves about as far along an axis as the farthest, the one whose plane faces
/// that way most, because the direction is ambiguous at edges and corners. Leaves less far count
/// less: a leaf of few points may be as wide as the whole component is high.
static orient_start find_start_along(const orienter* o, uint32_t end, int axis, float sign)
{
    orient_start start = {.leaf = UINT32_MAX, .axis = axis, .sign = sign, .certainty = -HUGE_VALF};
    float width = (float)stp_leaf_width(o->octree->leaves[end].depth);
    for (uint32_t i = 0; i < o->count; ++i) {
        const stp_leaf_properties* p = &o->properties[i];
        float below = sign * (o->properties[end].mean[axis] - p->mean[axis]) / width;
        float certainty = fabsf(along(p->normal, axis)) - uncertainty(p) - below;
        if (!o->done[i] && below <= 1.0f && o->components[i] == o->components[end] &&
            certainty > start.certainty) {
            start.certainty = certainty;
            start.leaf = i;
        }
    }
    return start;
}

/// The start at the top of the component that is highest (Bhakar 2004, 3.2).
static orient_start find_highest(const orienter* o)
{
    uint32_t end = find_end(o, UINT32_MAX, 1, 1.0f);
    return end != UINT32_MAX ? find_start_along(o, end, 1, 1.0f)
                             : (orient_start){.leaf = UINT32_MAX};
}

/// Where no leaf at the top faces up, as on an open cylinder: the most certain of the six ends.
static orient_start find_most_certain(const orienter* o, orient_start highest)
{
    orient_start best = highest;
    for (int k = 0; k < 6 && best.certainty < CERTAIN; ++k) {
        float sign = k % 2 == 0 ? 1.0f : -1.0f;
        uint32_t end = find_end(o, o->components[highest.leaf], k / 2, sign);
        orient_start other = find_start_along(o, end, k / 2, sign);
        best = other.certainty > best.certainty ? other : best;
    }
    return best;
}

/// Finds the shortest bridge from oriented leaves to a component. @return whether it is short
/// enough
static bool find_bridge(const orienter* o, uint32_t component, uint32_t* to, uint32_t* from)
{
    uint32_t size = 0, met = 0;
    float minimum = HUGE_VALF;
    for (uint32_t i = 0; i < o->count; ++i) {
        size += o->components[i] == component;
    }
    uint32_t stride = size / BRIDGE_LEAVES + 1;
    for (uint32_t i = 0; i < o->count; ++i) {
        if (o->components[i] != component || met++ % stride != 0) {
            continue;
        }
        for (uint32_t k = 0; k < o->count; ++k) {
            stp_vec3 d = stp_sub(place_of(o, i), place_of(o, k));
            float squared = stp_dot(d, d);
            if (o->done[k] && squared < minimum) {
                minimum = squared;
                *to = i;
                *from = k;
            }
        }
    }
    if (!(minimum < HUGE_VALF)) {
        return false;
    }
    float sides = (float)stp_leaf_width(o->octree->leaves[*to].depth) +
                  (float)stp_leaf_width(o->octree->leaves[*from].depth);
    return sqrtf(minimum) <= GAP * sides;
}

static void orient_all(orienter* o)
{
    find_components(o);
    uint32_t bridges = 0;
    for (orient_start start = find_highest(o); start.leaf != UINT32_MAX; start = find_highest(o)) {
        uint32_t to = start.leaf, from = 0;
        bool across = bridges > 0 && bridges <= BRIDGES_MAX &&
                      find_bridge(o, o->components[start.leaf], &to, &from);
        start = across || bridges > BRIDGES_MAX ? start : find_most_certain(o, start);
        stp_vec3* normal = &o->properties[start.leaf].normal;
        bridges += 1;
        if (across) {
            turn(o, to, from);
        } else if (start.sign * along(*normal, start.axis) < 0.0f) {
            *normal = stp_scale(*normal, -1.0f);
        }
        spread_from(o, across ? to : start.leaf);
        assert(o->queue.count <= o->begins[o->count] && "a step for each link, at most");
    }
}

stp_result stp_orient_leaves(stp_context* context, const stp_leaf_octree* octree,
                             stp_leaf_properties* properties, uint32_t neighbours)
{
    assert(neighbours > 0 && neighbours <= STP_LEAF_NEIGHBOURS_MAX);
    size_t count = octree->leaf_count, links = 2 * (size_t)neighbours * count;
    orienter o = {.octree = octree,
                  .properties = properties,
                  .count = octree->leaf_count,
                  .near = neighbours,
                  .places = STP_NEW_ARRAY(context, float, 3 * count + 1),
                  .neighbours = STP_NEW_ARRAY(context, uint32_t, neighbours * count + 1),
                  .begins = STP_NEW_ARRAY(context, uint32_t, count + 2),
                  .links = STP_NEW_ARRAY(context, uint32_t, links + 1),
                  .components = STP_NEW_ARRAY(context, uint32_t, count + 1),
                  .done = STP_NEW_ZEROED(context, bool, count + 1),
                  .waiting = STP_NEW_ARRAY(context, uint16_t, count + 1),
                  .queue = {.steps = STP_NEW_ARRAY(context, orient_step, links + 1)}};
    stp_result result = STP_OK;
    if (o.places == NULL || o.neighbours == NULL || o.begins == NULL || o.links == NULL ||
        o.components == NULL || o.done == NULL || o.waiting == NULL || o.queue.steps == NULL) {
        result = stp_fail_memory(context);
    }
    for (size_t i = 0; i < count && result == STP_OK; ++i) {
        memcpy(o.places + 3 * i, properties[i].mean, sizeof(properties[i].mean));
        o.waiting[i] = UINT16_MAX;
    }
    result = result == STP_OK && count > 0 ? link_leaves(context, &o) : result;
    if (result == STP_OK) {
        orient_all(&o);
    }
    stp_free(context, o.queue.steps);
    stp_free(context, o.waiting);
    stp_free(context, o.done);
    stp_free(context, o.components);
    stp_free(context, o.links);
    stp_free(context, o.begins);
    stp_free(context, o.neighbours);
    stp_free(context, o.places);
    return result;
}
