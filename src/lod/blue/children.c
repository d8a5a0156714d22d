// SPDX-License-Identifier: MIT
#include "lod/blue/children.h"

#include <assert.h>

#define WANTED_EACH 5.0 // candidates per splat: already evenly spread, without duplicates
#define MIN_EACH 4.0
#define MIN_CANDIDATES 6000.0
#define MAX_CANDIDATES 1750000.0
#define PROBE_CANDIDATES 30000.0
#define COARSE_RESOLUTION 8.0
#define MAX_RESOLUTION 16384.0
#define VIEWS 8.0 // about
#define TOO_MANY_TRIANGLES UINT64_C(8000000)
#define MIN_SHARE 0.02 // share of candidates from sets below which only triangles are captured
#define NEAR_ENOUGH 1.1
#define TRIES 6

typedef struct children {
    const stp_scene* scene;
    uint32_t node;
    const stp_blue_desc* desc;
    double splat_count;
    double seen; ///< visible share of the estimate
    stp_source_list list;
    double pixel; ///< pixel size for which the list was made
} children;

double stp_coarse_pixel(const stp_scene* scene, uint32_t node)
{
    if (node == STP_NONE || stp_boxd_is_empty(scene->nodes[node].bounds)) {
        return 1.0;
    }
    stp_vec3d size = stp_subd(scene->nodes[node].bounds.max, scene->nodes[node].bounds.min);
    double pixel = sqrt(stp_dotd(size, size)) / COARSE_RESOLUTION;
    return pixel > 0.0 && pixel <= DBL_MAX ? pixel : 1.0;
}

static stp_result list_at(children* c, double pixel)
{
    stp_source_list_destroy(c->scene->context, &c->list);
    assert(pixel > 0.0);
    c->pixel = pixel;
    return stp_list_sources(c->scene, c->node, c->desc->sets, pixel, STP_SOURCE_LIMIT, &c->list);
}

static double estimate(const children* c)
{
    return c->list.splats + c->list.pixels;
}

// Number of wanted candidates, given a number per splat.
static double wanted(const children* c, double each)
{
    if (c->desc->capture.wanted_candidates != 0) {
        return (double)c->desc->capture.wanted_candidates;
    }
    double count = c->splat_count * each, maximum = c->splat_count * MIN_EACH;
    double minimum = MIN_CANDIDATES * each / WANTED_EACH;
    maximum = maximum > MAX_CANDIDATES ? maximum : MAX_CANDIDATES;
    count = count < minimum ? minimum : count;
    return count < maximum ? count : maximum;
}

// Smallest pixel size that keeps a picture's cost proportional to its candidates.
static double finest_pixel(double widest, double candidates)
{
    assert(candidates > 0.0);
    double affordable = sqrt(STP_CAPTURE_MAX_PIXELS_EACH / VIEWS * candidates);
    return widest / (affordable < MAX_RESOLUTION ? affordable : MAX_RESOLUTION);
}

// Searches the pixel size that yields this many candidates, and lists its sources. Candidates grow
// with the square of the resolution, or less if sets run out of splats.
static stp_result find_pixel(children* c, double goal)
{
    stp_result result = STP_OK;
    assert(goal > 0.0 && c->seen > 0.0);
    double finest = finest_pixel(stp_coarse_pixel(c->scene, c->node) * COARSE_RESOLUTION, goal);
    for (int i = 0; i < TRIES && result == STP_OK; ++i) {
        double ratio = estimate(c) * c->seen / goal;
        if (!(ratio > 0.0) || (ratio < NEAR_ENOUGH && ratio > 1.0 / NEAR_ENOUGH)) {
            break;
        }
        double factor = sqrt(ratio);
        factor = factor > 64.0 ? 64.0 : factor < 1.0 / 64.0 ? 1.0 / 64.0 : factor;
        if (factor < 1.0 && c->pixel <= finest) {
            break;
        }
        result = list_at(c, c->pixel * factor > finest ? c->pixel * factor : finest);
    }
    return result;
}

static stp_capture_sources sources_of(const children* c)
{
    return (stp_capture_sources){.parts = c->list.parts,
                                 .part_count = c->list.part_count,
                                 .sets = c->list.sets,
                                 .set_count = c->list.set_count};
}

// A small capture measures the visible share.
static stp_result probe(children* c, double* widest)
{
    stp_result result = find_pixel(c, PROBE_CANDIDATES);
    stp_capture_desc desc = c->desc->capture;
    desc.pixel_size = c->pixel;
    stp_capture_sources sources = sources_of(c);
    stp_capture_count count;
    if (result == STP_OK) {
        result = stp_capture_count_all(c->scene, &sources, &desc, &count);
    }
    if (result == STP_OK) {
        double found = (double)count.pixels + (double)count.splats, all = estimate(c);
        double seen = all > 0.0 ? found / all : 1.0;
        c->seen = seen < 0.01 ? 0.01 : seen > 4.0 ? 4.0 : seen;
        *widest = count.widest;
    }
    return result;
}

// Reduced candidates per splat, used if finer pixels would open sets down to more than this many
// triangles, or draw more than this many splats (most leaves of a forest are hidden by others).
typedef struct density {
    double each;
    uint64_t triangles;
    double splats;
} density;

// Leaves the list of the chosen pixel size. Finer pixels open more sets, down to sets that are
// dense enough; below the last ones are triangles. The more triangles, the coarser are the sets
// that are still used.
static stp_result choose_pixel(children* c)
{
    static const density tries[] = {
        {WANTED_EACH, 2000000, 1.5e6}, {4.5, 2000000, 1.5e6}, {MIN_EACH, UINT64_MAX, HUGE_VAL}};
    stp_result result = STP_OK;
    double finest = 0.0;
    for (int i = 0; result == STP_OK; ++i) {
        assert((size_t)i < sizeof(tries) / sizeof(tries[0]) && "the last one is affordable");
        result = find_pixel(c, wanted(c, tries[i].each));
        bool affordable =
            c->list.part_triangles <= tries[i].triangles && c->list.splats <= tries[i].splats;
        if (result != STP_OK || affordable) {
            break;
        }
        finest = c->pixel;
    }
    double needed = c->list.coarsest * (1.0 + 1e-6); // finer, as long as no more sets are opened
    needed = needed > finest ? needed : finest;
    return result == STP_OK && finest > 0.0 && needed < c->pixel ? list_at(c, needed) : result;
}

static stp_result capture_once(children* c, stp_candidates* candidates)
{
    stp_capture_desc desc = c->desc->capture;
    desc.pixel_size = c->pixel;
    stp_capture_sources sources = sources_of(c);
    return stp_capture_all(c->scene, &sources, &desc, candidates);
}

static bool uses_sets(const children* c)
{
    return c->list.splats > MIN_SHARE * estimate(c) ||
           (c->list.set_count != 0 && c->list.triangle_count > TOO_MANY_TRIANGLES);
}

static stp_result capture(children* c, stp_candidates* candidates, bool* captured)
{
    double widest = 0.0;
    stp_result result = list_at(c, stp_coarse_pixel(c->scene, c->node));
    if (result != STP_OK || c->list.set_count == 0) {
        return result;
    }
    result = probe(c, &widest);
    if (result != STP_OK) {
        return result;
    }
    uint32_t resolution = c->desc->capture.resolution;
    double finest = finest_pixel(widest, wanted(c, WANTED_EACH));
    if (resolution != 0) {
        result = list_at(c, widest / (double)resolution);
    } else {
        result = choose_pixel(c);
        if (result == STP_OK && c->pixel < finest) {
            result = list_at(c, finest);
        }
    }
    assert(result != STP_OK || c->pixel > 0.0);
    if (result == STP_OK && uses_sets(c)) {
        *captured = true;
        result = capture_once(c, candidates);
    }
    return result;
}

stp_result stp_capture_children(const stp_scene* scene, uint32_t node, const stp_blue_desc* desc,
                                uint64_t splat_count, stp_candidates* candidates, bool* captured)
{
    children c = {.scene = scene,
                  .node = node,
                  .desc = desc,
                  .splat_count = (double)splat_count,
                  .seen = 1.0};
    *captured = false;
    stp_result result = capture(&c, candidates, captured);
    stp_source_list_destroy(scene->context, &c.list);
    return result;
}

// A cloud's own points do not depend on the pixel: once sets are opened down to them, finer pixels
// add none.
stp_result stp_list_cloud(const stp_scene* scene, uint32_t node, const stp_blue_desc* desc,
                          uint64_t splat_count, stp_source_list* list)
{
    children c = {.scene = scene,
                  .node = node,
                  .desc = desc,
                  .splat_count = (double)splat_count,
                  .seen = 1.0};
    stp_result result = list_at(&c, stp_coarse_pixel(scene, node));
    if (result == STP_OK && c.list.set_count != 0) {
        result = find_pixel(&c, wanted(&c, WANTED_EACH));
    }
    stp_source_list_destroy(scene->context, list);
    *list = c.list;
    return result;
}
