// SPDX-License-Identifier: MIT
#include "lab/decimate/contraction.h"

#include "base/core/jobs.h"

#include <assert.h>

#define ROUNDING 1e-14 ///< squared float precision, relative to the box's diagonal

enum { GRAIN = 512 };

/// Position of the contraction of two points.
static stp_vec3d place_of(const stp_contraction* c, const stp_quadric* both, uint32_t low,
                          uint32_t high, double length)
{
    double share = c->points->means[low].weight /
                   (c->points->means[low].weight + c->points->means[high].weight);
    stp_vec3d mean =
        stp_addd(stp_scaled(c->positions[low], share), stp_scaled(c->positions[high], 1.0 - share));
    return stp_quadric_minimum(both, mean, length);
}

static double length_of(const stp_contraction* c, uint32_t low, uint32_t high)
{
    stp_vec3d d = stp_subd(c->positions[high], c->positions[low]);
    return sqrt(stp_dotd(d, d));
}

static stp_contraction_pair measure(const stp_contraction* c, uint32_t point, uint32_t partner)
{
    assert(point != partner);
    uint32_t low = point < partner ? point : partner, high = point < partner ? partner : point;
    stp_quadric both = stp_quadric_sum(&c->quadrics[low], &c->quadrics[high]);
    double length = length_of(c, low, high);
    double error = stp_quadric_at(&both, place_of(c, &both, low, high, length));
    return (stp_contraction_pair){
        .error = error > c->minimum * stp_quadric_planes(&both) ? error : 0.0,
        .weight = length * length * (c->points->means[low].weight * c->points->means[high].weight),
        .partner = partner};
}

/// Whether a pair of one point comes before a pair of another. The order is total.
static bool is_before(stp_contraction_pair a, uint32_t of_a, stp_contraction_pair b, uint32_t of_b)
{
    if (a.error != b.error) {
        return a.error < b.error;
    }
    if (a.weight != b.weight) {
        return a.weight < b.weight;
    }
    uint32_t low_a = of_a < a.partner ? of_a : a.partner,
             low_b = of_b < b.partner ? of_b : b.partner;
    uint32_t high_a = of_a + (a.partner - low_a), high_b = of_b + (b.partner - low_b);
    if (low_a != low_b) {
        return low_a < low_b;
    }
    return high_a != high_b ? high_a < high_b : of_a < of_b;
}

static bool comes_first(const stp_contraction* c, uint32_t a, uint32_t b)
{
    return is_before(c->pairs[a], a, c->pairs[b], b);
}

static void put(stp_contraction* c, uint32_t place, uint32_t point)
{
    assert(place < c->heap_count);
    c->heap[place] = point;
    c->places[point] = place;
}

static void sift_down(stp_contraction* c, uint32_t place)
{
    uint32_t point = c->heap[place];
    for (uint32_t child; (child = 2 * place + 1) < c->heap_count; place = child) {
        bool second =
            child + 1 < c->heap_count && comes_first(c, c->heap[child + 1], c->heap[child]);
        child += second ? 1 : 0;
        if (!comes_first(c, c->heap[child], point)) {
            break;
        }
        put(c, place, c->heap[child]);
    }
    put(c, place, point);
}

static void sift_up(stp_contraction* c, uint32_t place)
{
    uint32_t point = c->heap[place];
    for (; place > 0 && comes_first(c, point, c->heap[(place - 1) / 2]); place = (place - 1) / 2) {
        put(c, place, c->heap[(place - 1) / 2]);
    }
    put(c, place, point);
}

static void remove_point(stp_contraction* c, uint32_t point)
{
    uint32_t place = c->places[point];
    if (place == UINT32_MAX) {
        return;
    }
    assert(place < c->heap_count && c->heap[place] == point);
    c->places[point] = UINT32_MAX;
    uint32_t moved = c->heap[--c->heap_count];
    if (moved != point) {
        put(c, place, moved);
        sift_up(c, place);
        sift_down(c, c->places[moved]);
    }
}

static void set_pair(stp_contraction* c, uint32_t point, stp_contraction_pair pair)
{
    c->pairs[point] = pair;
    if (pair.partner == UINT32_MAX) {
        remove_point(c, point);
        return;
    }
    assert(c->places[point] < c->heap_count && "points with partners stay in the heap");
    sift_up(c, c->places[point]);
    sift_down(c, c->places[point]);
}

static stp_contraction_pair best_of(const stp_contraction* c, uint32_t point, const uint32_t* near,
                                    uint32_t count)
{
    stp_contraction_pair best = {.partner = UINT32_MAX};
    for (uint32_t i = 0; i < count; ++i) {
        stp_contraction_pair pair = measure(c, point, near[i]);
        if (best.partner == UINT32_MAX || is_before(pair, point, best, point)) {
            best = pair;
        }
    }
    return best;
}

/// Updates the best pair of the moved point, and those of its neighbours.
static void update(stp_contraction* c, uint32_t kept, uint32_t gone)
{
    uint32_t count = stp_point_links_list(&c->links, kept, c->near);
    stp_contraction_pair best = {.partner = UINT32_MAX};
    for (uint32_t i = 0; i < count; ++i) {
        uint32_t other = c->near[i], partner = c->pairs[other].partner;
        stp_contraction_pair pair = measure(c, kept, other);
        if (best.partner == UINT32_MAX || is_before(pair, kept, best, kept)) {
            best = pair;
        }
        stp_contraction_pair back = pair;
        back.partner = kept;
        if (partner == kept || partner == gone) {
            uint32_t beside = stp_point_links_list(&c->links, other, c->near_near);
            set_pair(c, other, best_of(c, other, c->near_near, beside));
        } else if (is_before(back, other, c->pairs[other], other)) {
            set_pair(c, other, back);
        }
    }
    set_pair(c, kept, best);
}

bool stp_contraction_step(stp_contraction* c)
{
    if (c->heap_count == 0) {
        return false;
    }
    uint32_t point = c->heap[0], partner = c->pairs[point].partner;
    uint32_t kept = point < partner ? point : partner, gone = point < partner ? partner : point;
    assert(c->links.kept[kept] == kept && c->links.kept[gone] == gone && c->left > 1);
    stp_quadric both = stp_quadric_sum(&c->quadrics[kept], &c->quadrics[gone]);
    c->positions[kept] = place_of(c, &both, kept, gone, length_of(c, kept, gone));
    c->quadrics[kept] = both;
    stp_color_mean *to = &c->points->means[kept], *from = &c->points->means[gone];
    to->weight += from->weight;
    for (size_t k = 0; k < 3; ++k) {
        to->sum[k] += from->sum[k];
        if (c->points->normals != NULL) {
            c->points->normals[3 * (size_t)kept + k] += c->points->normals[3 * (size_t)gone + k];
        }
    }
    remove_point(c, gone);
    stp_point_links_unite(&c->links, kept, gone);
    c->left -= 1;
    update(c, kept, gone);
    return true;
}

/// Adds the planes through a point and each neighbour that are closest to the point's own plane.
static void make_quadrics(size_t begin, size_t end, uint32_t worker, void* user)
{
    stp_contraction* c = user;
    (void)worker;
    for (size_t i = begin; i < end; ++i) {
        stp_vec3d n = stp_to_double(c->disks[i].normal);
        c->quadrics[i] = (stp_quadric){0};
        for (uint32_t e = c->links.first[i]; e != UINT32_MAX; e = c->links.next[e]) {
            stp_vec3d edge = stp_subd(c->positions[c->links.targets[e]], c->positions[i]);
            stp_vec3d across = stp_crossd(edge, stp_crossd(n, edge));
            stp_vec3d plane = stp_normalized(across);
            if (stp_dotd(plane, plane) > 0.0) {
                stp_quadric_add_plane(&c->quadrics[i], c->positions[i], plane);
            }
        }
    }
}

static void make_pairs(size_t begin, size_t end, uint32_t worker, void* user)
{
    stp_contraction* c = user;
    (void)worker;
    for (size_t i = begin; i < end; ++i) {
        // initially, a point's entries are consecutive and distinct
        uint32_t first = c->links.first[i];
        uint32_t count = first != UINT32_MAX ? c->links.last[i] - first + 1 : 0;
        const uint32_t* near = count > 0 ? c->links.targets + first : NULL;
        c->pairs[i] = best_of(c, (uint32_t)i, near, count);
    }
}

static void begin_positions(stp_contraction* c)
{
    const stp_decimate_input places = {.count = c->points->count,
                                       .positions = c->points->positions};
    stp_box box = stp_decimate_box(&places);
    stp_vec3d low = stp_to_double(box.min), size = stp_subd(stp_to_double(box.max), low);
    c->middle = stp_addd(low, stp_scaled(size, 0.5));
    c->minimum = ROUNDING * stp_dotd(size, size);
    for (uint32_t i = 0; i < places.count; ++i) {
        stp_vec3d p = stp_to_double(stp_decimate_vector(places.positions, i));
        c->positions[i] = stp_subd(p, c->middle);
        c->places[i] = UINT32_MAX;
    }
}

stp_result stp_contraction_make(stp_contraction* c, const uint32_t* neighbours, uint32_t k)
{
    uint32_t count = c->points->count;
    size_t room = (size_t)count + 1;
    stp_result result = stp_point_links_make(c->context, neighbours, count, k, &c->links);
    if (result != STP_OK) {
        return result;
    }
    c->positions = STP_NEW_ARRAY(c->context, stp_vec3d, room);
    c->quadrics = STP_NEW_ARRAY(c->context, stp_quadric, room);
    c->pairs = STP_NEW_ARRAY(c->context, stp_contraction_pair, room);
    c->heap = STP_NEW_ARRAY(c->context, uint32_t, room);
    c->places = STP_NEW_ARRAY(c->context, uint32_t, room);
    c->near = STP_NEW_ARRAY(c->context, uint32_t, room);
    c->near_near = STP_NEW_ARRAY(c->context, uint32_t, room);
    if (c->positions == NULL || c->quadrics == NULL || c->pairs == NULL || c->heap == NULL ||
        c->places == NULL || c->near == NULL || c->near_near == NULL) {
        return stp_fail_memory(c->context);
    }
    c->left = count;
    begin_positions(c);
    stp_parallel_for(c->context, count, GRAIN, make_quadrics, c);
    stp_parallel_for(c->context, count, GRAIN, make_pairs, c);
    for (uint32_t i = 0; i < count; ++i) {
        if (c->pairs[i].partner != UINT32_MAX) {
            put(c, c->heap_count++, i);
        }
    }
    for (uint32_t i = c->heap_count / 2; i > 0; --i) {
        sift_down(c, i - 1);
    }
    return STP_OK;
}

void stp_contraction_destroy(stp_contraction* c)
{
    if (c->links.context != NULL) {
        stp_point_links_destroy(&c->links);
    }
    stp_free(c->context, c->positions);
    stp_free(c->context, c->quadrics);
    stp_free(c->context, c->pairs);
    stp_free(c->context, c->heap);
    stp_free(c->context, c->places);
    stp_free(c->context, c->near);
    stp_free(c->context, c->near_near);
}
