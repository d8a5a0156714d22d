// SPDX-License-Identifier: MIT
#include "lod/blue/blue.h"

#include "base/core/clock.h"
#include "base/core/saturate.h"
#include "base/core/sort.h"
#include "lod/blue/children.h"
#include "lod/blue/finish.h"
#include "lod/cloud_candidates.h"

#include <assert.h>
#include <math.h>
#include <string.h>

// a quarter of Brandt 5.2: blue.h. More give pictures of the same SSIM
// (docs/notes/2026-11-candidates.md, 2026-11-proportion.md).
#define MAX_SPLATS 50000u
#define CANDIDATES_PER_SPLAT 12u
#define MIN_CANDIDATES 6000u    // small objects must keep their shape
#define MAX_CANDIDATES 1750000u // Brandt, Table 2
#define FINE_PIXEL 0x1p-7       // for triangles, in coarse pixels: a 1,024th of the diagonal
#define NORMAL_SPACINGS 2.5f    // radius for estimating a point's normal
#define SPARSE_PART 128u   // sparse parts of a cloud count if they have one in this many points
#define MIN_EXTENT 0x1p-60 // scene units; squared distances below it underflow

typedef struct blue {
    const stp_scene* scene;
    const stp_blue_desc* desc;
    stp_source_list list; ///< sources of the capture: parts and sets that do not move
    stp_candidates candidates;
    stp_order_desc order_desc;
    bool from_points;
    bool two_sided;
    uint32_t wanted;   ///< splats
    uint32_t distinct; ///< number of ordered candidates, without coincident points
    uint32_t* order;
    float* radii;
    stp_finish_input finish;
} blue;

// Lists and counts static content.
static stp_result list_sources(blue* b, uint32_t node, const stp_splats* const* sets)
{
    stp_source_list_destroy(b->scene->context, &b->list);
    double pixel = stp_coarse_pixel(b->scene, node);
    pixel = sets != NULL ? pixel : pixel * FINE_PIXEL;
    return stp_list_sources(b->scene, node, sets, pixel, STP_SOURCE_LIMIT, &b->list);
}

uint64_t stp_splat_rule_count(const stp_splat_rule* rule, uint64_t triangles, uint64_t points)
{
    assert(rule->ratio >= 0.0);
    double ratio = rule->ratio > 0.0 ? rule->ratio : STP_TRIANGLES_PER_SPLAT;
    double maximum = rule->maximum != 0 ? rule->maximum : MAX_SPLATS;
    double count = floor((double)stp_add_saturated(triangles, points) / ratio);
    return (uint64_t)fmin(fmax(count, 1.0), maximum);
}

// A point cloud keeps every point.
static uint64_t choose_count(const blue* b)
{
    if (b->desc->splat_count != 0) {
        return b->desc->splat_count;
    }
    if (b->from_points) {
        return b->list.point_count;
    }
    return stp_splat_rule_count(&(stp_splat_rule){0}, b->list.triangle_count, b->list.point_count);
}

static stp_result capture_parts(blue* b, uint64_t count)
{
    stp_capture_desc capture = b->desc->capture;
    if (capture.wanted_candidates == 0) {
        uint64_t wanted = count * CANDIDATES_PER_SPLAT;
        wanted = wanted < MIN_CANDIDATES ? MIN_CANDIDATES : wanted;
        capture.wanted_candidates = wanted > MAX_CANDIDATES ? MAX_CANDIDATES : wanted;
    }
    return stp_capture_parts(b->scene, b->list.parts, b->list.part_count, &capture, &b->candidates);
}

// Whether all static content below a node is points.
static bool is_cloud(const stp_scene* scene, uint32_t node)
{
    return node != STP_NONE && scene->nodes[node].triangle_count == 0 &&
           scene->nodes[node].point_count != 0;
}

// Whole octaves of a set without a pyramid are evenly spread; a part of one may not be.
static void round_prefixes(stp_source_list* list)
{
    for (size_t i = 0; i < list->set_count; ++i) {
        const stp_splats* set = list->sets[i].splats;
        uint32_t octave = 0;
        if ((set->columns & STP_SPLATS_FLAT_COLORS) != 0) {
            assert(list->sets[i].prefix <= set->count);
            while (set->octave_ends[octave] < list->sets[i].prefix) {
                octave += 1;
                assert(octave < set->octave_count);
            }
            list->sets[i].prefix = set->octave_ends[octave];
        }
    }
}

// Takes candidates from the sets below, which have all points, at the wanted density; otherwise
// from the points themselves.
static stp_result make_cloud_candidates(blue* b, uint32_t node)
{
    stp_result result = list_sources(b, node, NULL);
    if (result != STP_OK) {
        return result;
    }
    b->from_points = true;
    b->two_sided = !stp_sources_have_normals(b->scene, &b->list);
    b->order_desc.metric = b->two_sided ? STP_METRIC_EUCLIDEAN : b->order_desc.metric;
    uint64_t count = choose_count(b), points = b->list.point_count;
    if (b->desc->sets != NULL && count < points) {
        result = stp_list_cloud(b->scene, node, b->desc, count, &b->list);
        round_prefixes(&b->list);
    }
    if (result == STP_OK) {
        result = stp_candidates_of_cloud(b->scene, &b->list, !b->two_sided, &b->candidates);
    }
    b->wanted = (uint32_t)(count < b->candidates.count ? count : b->candidates.count);
    return result;
}

// Takes candidates from the sets below the node if they are dense enough, otherwise from its parts.
static stp_result make_candidates(blue* b, uint32_t node)
{
    b->order_desc = b->desc->order;
    if (is_cloud(b->scene, node)) {
        return make_cloud_candidates(b, node);
    }
    stp_result result = list_sources(b, node, b->desc->sets);
    bool captured = false;
    uint64_t count = choose_count(b);
    if (result == STP_OK && b->list.set_count != 0) {
        result = stp_capture_children(b->scene, node, b->desc, count, &b->candidates, &captured);
        result = result == STP_OK && !captured ? list_sources(b, node, NULL) : result;
    }
    if (result == STP_OK && !captured && b->list.part_count != 0) {
        result = capture_parts(b, count);
    }
    b->wanted = (uint32_t)(count < b->candidates.count ? count : b->candidates.count);
    return result;
}

// If all points of a cloud are wanted, appends coincident points last, so that each point is kept
// once.
static stp_result append_coincident(blue* b)
{
    uint32_t count = b->candidates.count, next = b->finish.count;
    if (!b->from_points || b->wanted != count || next == count || next == 0) {
        return STP_OK;
    }
    uint8_t* chosen = STP_NEW_ZEROED(b->scene->context, uint8_t, count);
    if (chosen == NULL) {
        return stp_fail_memory(b->scene->context);
    }
    for (uint32_t i = 0; i < next; ++i) {
        chosen[b->order[i]] = 1;
    }
    float last = next > 1 ? b->radii[next - 1] : b->finish.final_radius; // they cover nothing more
    for (uint32_t i = 0; i < count; ++i) {
        if (chosen[i] == 0) {
            b->radii[next] = last;
            b->order[next++] = i;
        }
    }
    assert(next == count && "the order is a permutation");
    b->finish.count = next;
    stp_free(b->scene->context, chosen);
    return STP_OK;
}

static stp_result order_candidates(blue* b)
{
    stp_context* context = b->scene->context;
    const stp_candidates* c = &b->candidates;
    assert(b->wanted > 0 && b->wanted <= c->count);
    b->order = STP_NEW_ARRAY(context, uint32_t, b->wanted);
    b->radii = STP_NEW_ARRAY(context, float, b->wanted);
    if (b->order == NULL || b->radii == NULL) {
        return stp_fail_memory(context);
    }
    const float* normals = b->order_desc.metric == STP_METRIC_SIDE ? c->normals : NULL;
    stp_result result =
        stp_order_points(context, &b->order_desc, c->positions, normals, c->count, b->wanted,
                         b->order, b->radii, &b->finish.count, &b->finish.final_radius, NULL);
    assert(result != STP_OK || b->finish.count <= b->wanted);
    b->distinct = b->finish.count;
    return result == STP_OK ? append_coincident(b) : result;
}

// Sorts the insertion radii, the largest first. An exact order has them so; others do not.
static stp_result sort_radii(const blue* b, float* sorted)
{
    uint32_t count = b->distinct;
    if (b->order_desc.kind == STP_ORDER_EXACT) {
        memcpy(sorted, b->radii, count * sizeof(*sorted));
        return STP_OK;
    }
    uint64_t* items = STP_NEW_ARRAY(b->scene->context, uint64_t, 2 * (size_t)count);
    if (items == NULL) {
        return stp_fail_memory(b->scene->context);
    }
    for (uint32_t i = 0; i < count; ++i) {
        uint32_t bits; // of floats that are not negative: they sort alike
        memcpy(&bits, &b->radii[i], sizeof(bits));
        assert(bits <= 0x7FFFFFFFu && "radii are not negative");
        items[i] = (uint64_t)(0x7FFFFFFFu - bits) << 32 | bits;
    }
    const uint64_t* order = stp_sort_u64(items, items + count, count, 32, 31);
    for (uint32_t i = 0; i < count; ++i) {
        uint32_t bits = (uint32_t)order[i];
        memcpy(&sorted[i], &bits, sizeof(bits));
        assert(i == 0 || !(sorted[i] > sorted[i - 1]));
    }
    stp_free(b->scene->context, items);
    return STP_OK;
}

// For a point cloud, the point spacing replaces the capture's pixel. On a surface of even density,
// half the points, farthest first, have about the spacing of all; an eighth of them has 2.9 times
// the spacing, and each further quarter doubles it. Where that gives more, half the points are near
// duplicates, or density varies, and the value narrows the gaps of sparse parts
// (docs/notes/2026-11-scan-spacing.md).
static stp_result measure_spacing(blue* b)
{
    uint32_t count = b->distinct;
    float* sorted = STP_NEW_ARRAY(b->scene->context, float, count + 1);
    if (sorted == NULL) {
        return stp_fail_memory(b->scene->context);
    }
    stp_result result = sort_radii(b, sorted);
    float spacing = result == STP_OK && count > 1 ? sorted[(count + 1) / 2] : 0.0f, share = 0.35f;
    for (uint32_t part = 8; result == STP_OK && part <= SPARSE_PART && part < count; part *= 4) {
        spacing = stp_max(spacing, sorted[(count + part - 1) / part] * share);
        share *= 0.5f;
    }
    stp_free(b->scene->context, sorted);
    // All points are covered: the remaining candidates are duplicates.
    bool all = !(b->finish.final_radius > 0.0f);
    assert(count <= b->candidates.count);
    double part = all ? 1.0 : (double)count / (double)b->candidates.count;
    b->candidates.pixel_size = (double)spacing * sqrt(part);
    return result;
}

static stp_result finish(blue* b, const uint8_t* shading_of_material, stp_splats* surfels)
{
    if (b->from_points) {
        stp_result result = measure_spacing(b);
        float radius = (float)b->candidates.pixel_size * NORMAL_SPACINGS;
        if (result == STP_OK && b->two_sided) {
            result = stp_estimate_point_normals(b->scene->context, &b->candidates, radius);
        }
        if (result != STP_OK) {
            return result;
        }
    }
    b->finish.candidates = &b->candidates;
    b->finish.order = b->order;
    b->finish.radii = b->radii;
    b->finish.shading_of_material = shading_of_material;
    b->finish.growths = b->desc->growths;
    b->finish.spacing = b->from_points ? (float)b->candidates.pixel_size : 0.0f;
    b->finish.exact = b->order_desc.kind == STP_ORDER_EXACT;
    b->finish.two_sided = b->two_sided;
    b->finish.by_side = b->order_desc.metric == STP_METRIC_SIDE;
    return b->finish.count != 0 ? stp_finish_surfels(b->scene->context, &b->finish, surfels)
                                : STP_OK;
}

static bool is_measurable(const stp_scene* scene, uint32_t node)
{
    stp_boxd box = scene->nodes[node].bounds;
    stp_vec3d size = stp_subd(box.max, box.min);
    return size.x >= MIN_EXTENT || size.y >= MIN_EXTENT || size.z >= MIN_EXTENT;
}

static stp_result make(blue* b, uint32_t node, const uint8_t* shading_of_material,
                       stp_splats* surfels, stp_blue_report* report)
{
    double start = stp_clock_ms();
    stp_result result = make_candidates(b, node);
    double captured = stp_clock_ms();
    report->capture_ms = captured - start;
    report->candidate_count = b->candidates.count;
    report->source_sets = b->list.set_count;
    if (result != STP_OK || b->wanted == 0) {
        return result;
    }
    result = order_candidates(b);
    double ordered = stp_clock_ms();
    report->order_ms = ordered - captured;
    if (result != STP_OK) {
        return result;
    }
    result = finish(b, shading_of_material, surfels);
    report->finish_ms = stp_clock_ms() - ordered;
    return result;
}

stp_result stp_blue_find_candidates(const stp_scene* scene, uint32_t node,
                                    const stp_blue_desc* desc, stp_blue_candidates* found)
{
    *found = (stp_blue_candidates){0};
    if (!is_cloud(scene, node) && !is_measurable(scene, node)) {
        return STP_OK;
    }
    blue b = {.scene = scene, .desc = desc};
    stp_result result = make_candidates(&b, node);
    stp_source_list_destroy(scene->context, &b.list);
    assert(result != STP_OK || b.wanted <= b.candidates.count);
    *found = (stp_blue_candidates){.candidates = b.candidates,
                                   .wanted = b.wanted,
                                   .from_points = b.from_points,
                                   .two_sided = b.two_sided};
    return result;
}

stp_result stp_blue_make(const stp_scene* scene, uint32_t node, const uint8_t* shading_of_material,
                         const stp_blue_desc* desc, stp_splats* surfels, stp_blue_report* report)
{
    stp_blue_report unwanted;
    report = report != NULL ? report : &unwanted;
    *report = (stp_blue_report){0};
    *surfels = (stp_splats){0};
    if (!is_cloud(scene, node) && !is_measurable(scene, node)) {
        return STP_OK;
    }
    blue b = {.scene = scene, .desc = desc};
    stp_result result = make(&b, node, shading_of_material, surfels, report);
    stp_free(scene->context, b.radii);
    stp_free(scene->context, b.order);
    stp_candidates_destroy(scene->context, &b.candidates);
    stp_source_list_destroy(scene->context, &b.list);
    return result;
}
