// SPDX-License-Identifier: MIT
#include "lod/children.h"

#define WANTED_OF_SETS 9.0 // candidates a surfel: evenly spread already, each once
#define LEAST_OF_SETS 4.0  // what will do where more would open up to a great many triangles
#define MANY_TRIANGLES UINT64_C(8000000)
#define WANTED_OF_PARTS 17.0 // as where there are only triangles (blue.c)
#define LEAST_CANDIDATES 20000.0
#define MOST_CANDIDATES 1750000.0
#define PROBE_CANDIDATES 30000.0
#define COARSE_RESOLUTION 8.0
#define MOST_RESOLUTION 16384.0
#define LEAST_SHARE 0.02 // of candidates from sets, below which triangles are captured as ever
#define NEAR_ENOUGH 1.1
#define TRIES 6

typedef struct children {
    const stp_scene* scene;
    uint32_t node;
    const stp_blue_desc* desc;
    double surfel_count;
    double seen; ///< of what is estimated, the part that is visible
    stp_source_list list;
    double pixel; ///< of the list
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
    c->pixel = pixel;
    return stp_list_sources(c->scene, c->node, c->desc->sets, pixel, STP_SOURCE_LIMIT, &c->list);
}

static double estimate(const children* c)
{
    return c->list.surfels + c->list.pixels;
}

static double share_of_parts(const children* c)
{
    double all = estimate(c);
    return all > 0.0 ? c->list.pixels / all : 1.0;
}

// How many candidates are wanted of a list, where sets are to give `of_sets` a surfel.
static double wanted(const children* c, double of_sets)
{
    if (c->desc->capture.wanted_candidates != 0) {
        return (double)c->desc->capture.wanted_candidates;
    }
    double parts = share_of_parts(c);
    double count = c->surfel_count * (of_sets + (WANTED_OF_PARTS - of_sets) * parts);
    double least = LEAST_CANDIDATES * of_sets / WANTED_OF_SETS;
    count = count < least ? least : count;
    double most = LEAST_OF_SETS * c->surfel_count;
    most = most > MOST_CANDIDATES ? most : MOST_CANDIDATES;
    return count < most ? count : most;
}

// Looks for the pixel at which so many candidates come out, and lists its sources. Candidates grow with the square of
// the resolution, or less where sets have no more surfels.
static stp_result find_pixel(children* c, double of_sets, double fixed_count)
{
    stp_result result = STP_OK;
    for (int i = 0; i < TRIES && result == STP_OK; ++i) {
        double goal = fixed_count > 0.0 ? fixed_count : wanted(c, of_sets);
        double ratio = estimate(c) * c->seen / goal;
        if (!(ratio > 0.0) || (ratio < NEAR_ENOUGH && ratio > 1.0 / NEAR_ENOUGH)) {
            break;
        }
        double factor = sqrt(ratio);
        factor = factor > 64.0 ? 64.0 : factor < 1.0 / 64.0 ? 1.0 / 64.0 : factor;
        result = list_at(c, c->pixel * factor);
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

// A small capture tells how much of what is there can be seen.
static stp_result probe(children* c, double* widest)
{
    stp_result result = find_pixel(c, 0.0, PROBE_CANDIDATES);
    stp_capture_desc desc = c->desc->capture;
    desc.pixel_size = c->pixel;
    stp_capture_sources sources = sources_of(c);
    stp_capture_count count;
    if (result == STP_OK) {
        result = stp_capture_count_all(c->scene, &sources, &desc, &count);
    }
    if (result == STP_OK) {
        double found = (double)count.pixels + (double)count.surfels, all = estimate(c);
        double seen = all > 0.0 ? found / all : 1.0;
        c->seen = seen < 0.01 ? 0.01 : seen > 4.0 ? 4.0 : seen;
        *widest = count.widest;
    }
    return result;
}

// Leaves the list of the pixel to be used. Finer pixels open more sets, down to sets that are dense enough; but
// below the last of them are triangles. Where these are too many, sets that are a little too coarse are used all the
// same.
static stp_result choose_pixel(children* c)
{
    stp_result result = find_pixel(c, WANTED_OF_SETS, 0.0);
    if (result != STP_OK || c->list.part_triangles <= MANY_TRIANGLES) {
        return result;
    }
    double finest = c->pixel;
    result = find_pixel(c, LEAST_OF_SETS, 0.0);
    double needed = c->list.coarsest * (1.0 + 1e-6);
    needed = needed > finest ? needed : finest;
    return result == STP_OK && needed < c->pixel ? list_at(c, needed) : result;
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
    return c->list.surfels > LEAST_SHARE * estimate(c) ||
           (c->list.set_count != 0 && c->list.triangle_count > MANY_TRIANGLES);
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
    double finest = widest / MOST_RESOLUTION;
    if (resolution != 0) {
        result = list_at(c, widest / (double)resolution);
    } else {
        result = choose_pixel(c);
        if (result == STP_OK && c->pixel < finest) {
            result = list_at(c, finest);
        }
    }
    if (result == STP_OK && uses_sets(c)) {
        *captured = true;
        result = capture_once(c, candidates);
    }
    return result;
}

stp_result stp_capture_children(const stp_scene* scene, uint32_t node, const stp_blue_desc* desc,
                                uint64_t surfel_count, stp_candidates* candidates, bool* captured)
{
    children c = {.scene = scene,
                  .node = node,
                  .desc = desc,
                  .surfel_count = (double)surfel_count,
                  .seen = 1.0};
    *captured = false;
    stp_result result = capture(&c, candidates, captured);
    stp_source_list_destroy(scene->context, &c.list);
    return result;
}
