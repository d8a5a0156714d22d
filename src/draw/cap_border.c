// SPDX-License-Identifier: MIT
#include "base/math/closed_surface.h"
#include "draw/caps_internal.h"

#include <assert.h>
#include <stdlib.h>
#include <string.h>

// maximum area enclosed by borders, relative to the surface: the ends of a pipe 200 radii long
#define LARGEST_GAP 0.005
enum {
    MIN_BUCKETS = 1 << 10,
    MAX_BUCKETS = 1 << 22,
    MAX_EDGES = 1 << 20, ///< edges of borders, and edges that share a bucket with one
};

typedef struct edge {
    uint64_t number; ///< equal in both directions
    uint64_t ends[2];
    float from[3], to[3];
} edge;

struct stp_cap_border {
    stp_context* context;
    uint64_t* buckets; ///< sums of edges, one direction less the other: zero if all cancel
    uint32_t mask;
    bool second, overflows;
    edge* edges;
    size_t count, capacity;
    double area, volume; ///< twice the area, and six times the signed volume
    double terms;        ///< the sum of the absolute values that volume is the sum of
};

stp_result stp_cap_border_create(stp_context* context, uint64_t triangles, stp_cap_border** border)
{
    uint32_t buckets = MIN_BUCKETS;
    while (buckets < MAX_BUCKETS && buckets < 2 * triangles) {
        buckets *= 2;
    }
    assert((buckets & (buckets - 1)) == 0 && buckets <= MAX_BUCKETS && "bits of a hash select one");
    stp_cap_border* b = STP_NEW_ZEROED(context, stp_cap_border, 1);
    *border = b;
    if (b != NULL) {
        *b = (stp_cap_border){.context = context, .mask = buckets - 1};
        b->buckets = STP_NEW_ZEROED(context, uint64_t, buckets);
    }
    if (b == NULL || b->buckets == NULL) {
        stp_free(context, b);
        *border = NULL;
        return stp_fail_memory(context);
    }
    return STP_OK;
}

void stp_cap_border_destroy(stp_cap_border* b)
{
    if (b != NULL) {
        stp_free(b->context, b->buckets);
        stp_free(b->context, b->edges);
        stp_free(b->context, b);
    }
}

static stp_result keep_edge(stp_cap_border* b, const edge* e)
{
    assert(b->second && "the first pass keeps no edges");
    if (b->overflows || b->count >= MAX_EDGES) {
        b->overflows = true;
        return STP_OK;
    }
    if (!STP_MAKE_ROOM(b->context, b->edges, b->capacity, b->count + 1)) {
        return stp_fail_memory(b->context);
    }
    assert(b->count < b->capacity && b->count < MAX_EDGES);
    b->edges[b->count++] = *e;
    return STP_OK;
}

static stp_result add_edge(stp_cap_border* b, const float* from, uint64_t from_hash,
                           const float* to, uint64_t to_hash)
{
    if (from_hash == to_hash) {
        return STP_OK;
    }
    edge e = {.number = stp_rng_hash(from_hash + to_hash, from_hash ^ to_hash),
              .ends = {from_hash, to_hash}};
    uint64_t* bucket = &b->buckets[e.number & b->mask];
    if (!b->second) {
        *bucket += from_hash < to_hash ? e.number : (uint64_t)0 - e.number;
        return STP_OK;
    }
    if (*bucket == 0) {
        return STP_OK;
    }
    memcpy(e.from, from, sizeof(e.from));
    memcpy(e.to, to, sizeof(e.to));
    return keep_edge(b, &e);
}

stp_result stp_cap_border_add(stp_cap_border* b, const float* const corners[3])
{
    uint64_t hash[3];
    stp_vec3d p[3];
    for (int k = 0; k < 3; ++k) {
        hash[k] = stp_corner_hash(corners[k]);
        p[k] = (stp_vec3d){(double)corners[k][0], (double)corners[k][1], (double)corners[k][2]};
    }
    if (!b->second) {
        stp_vec3d n = stp_crossd(stp_subd(p[1], p[0]), stp_subd(p[2], p[0]));
        b->area += sqrt(stp_dotd(n, n));
        double term = stp_dotd(p[0], stp_crossd(p[1], p[2]));
        b->volume += term;
        b->terms += fabs(term);
    }
    stp_result result = STP_OK;
    for (int k = 0; k < 3 && result == STP_OK; ++k) {
        int next = (k + 1) % 3;
        result = add_edge(b, corners[k], hash[k], corners[next], hash[next]);
    }
    return result;
}

void stp_cap_border_turn(stp_cap_border* b)
{
    b->second = true;
}

// Sorts by edge, then by direction.
static int compare_edges(const void* a, const void* b)
{
    const edge *x = a, *y = b;
    if (x->number != y->number) {
        return x->number < y->number ? -1 : 1;
    }
    return (x->ends[0] > x->ends[1]) - (y->ends[0] > y->ends[1]);
}

// Keeps edges that are used more often in one direction than in the other.
static void cancel_edges(stp_cap_border* b)
{
    size_t left = 0;
    qsort(b->edges, b->count, sizeof(edge), compare_edges);
    for (size_t i = 0, end; i < b->count; i = end) {
        size_t middle = i;
        for (end = i; end < b->count && b->edges[end].number == b->edges[i].number; ++end) {
            middle += b->edges[end].ends[0] < b->edges[end].ends[1];
        }
        size_t forth = middle - i, back = end - middle;
        size_t more = forth > back ? forth - back : back - forth;
        size_t first = forth > back ? i : middle; // those of the more frequent direction
        assert(left <= first && i <= middle && middle <= end && "edges only move down");
        assert(first + more <= end && "the kept edges have one direction");
        memmove(b->edges + left, b->edges + first, more * sizeof(edge));
        left += more;
    }
    b->count = left;
}

typedef struct edge_end {
    uint64_t place;
    uint32_t edge;
} edge_end;

static int compare_ends(const void* a, const void* b)
{
    const edge_end *x = a, *y = b;
    return x->place != y->place ? (x->place > y->place) - (x->place < y->place)
                                : (x->edge > y->edge) - (x->edge < y->edge);
}

static uint32_t find_root(uint32_t* parents, uint32_t i)
{
    while (parents[i] != i) {
        assert(parents[i] < i && "a root is the first edge of its border");
        parents[i] = parents[parents[i]];
        i = parents[i];
    }
    return i;
}

// Joins connected edges: each group is a separate border.
static void join_edges(const stp_cap_border* b, edge_end* ends, uint32_t* parents)
{
    assert(b->count <= MAX_EDGES && "their numbers have 32 bits");
    for (uint32_t i = 0; i < b->count; ++i) {
        parents[i] = i;
        ends[2 * i] = (edge_end){b->edges[i].ends[0], i};
        ends[2 * i + 1] = (edge_end){b->edges[i].ends[1], i};
    }
    qsort(ends, 2 * b->count, sizeof(edge_end), compare_ends);
    for (size_t i = 1; i < 2 * b->count; ++i) {
        if (ends[i].place == ends[i - 1].place) {
            uint32_t x = find_root(parents, ends[i].edge), y = find_root(parents, ends[i - 1].edge);
            parents[x > y ? x : y] = x > y ? y : x;
        }
    }
}

// Twice the area that the borders enclose. A border is a sum of closed loops, so its area vector
// does not depend on how it is split into loops.
static double enclosed_area(const stp_cap_border* b, uint32_t* parents, stp_vec3d* areas)
{
    double sum = 0.0;
    memset(areas, 0, b->count * sizeof(*areas));
    for (uint32_t i = 0; i < b->count; ++i) {
        uint32_t root = find_root(parents, i);
        stp_vec3d at = {(double)b->edges[root].from[0], (double)b->edges[root].from[1],
                        (double)b->edges[root].from[2]};
        assert(root <= i && parents[root] == root);
        const float *from = b->edges[i].from, *to = b->edges[i].to;
        stp_vec3d p = {(double)from[0], (double)from[1], (double)from[2]};
        stp_vec3d q = {(double)to[0], (double)to[1], (double)to[2]};
        areas[root] = stp_addd(areas[root], stp_crossd(stp_subd(p, at), stp_subd(q, at)));
    }
    for (uint32_t i = 0; i < b->count; ++i) {
        sum += sqrt(stp_dotd(areas[i], areas[i]));
    }
    return sum;
}

stp_result stp_cap_border_side(stp_cap_border* b, int* side)
{
    assert(b->second && "all triangles are added twice");
    *side = 0;
    int sign = stp_volume_sign(b->volume, b->terms);
    if (b->overflows || sign == 0) {
        return STP_OK;
    }
    cancel_edges(b);
    edge_end* ends = STP_NEW_ARRAY(b->context, edge_end, 2 * b->count + 1);
    uint32_t* parents = STP_NEW_ARRAY(b->context, uint32_t, b->count + 1);
    stp_vec3d* areas = STP_NEW_ARRAY(b->context, stp_vec3d, b->count + 1);
    bool made = ends != NULL && parents != NULL && areas != NULL;
    if (made) {
        join_edges(b, ends, parents);
        if (enclosed_area(b, parents, areas) <= LARGEST_GAP * b->area) {
            *side = sign;
        }
    }
    stp_free(b->context, ends);
    stp_free(b->context, parents);
    stp_free(b->context, areas);
    return made ? STP_OK : stp_fail_memory(b->context);
}
