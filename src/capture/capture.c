// SPDX-License-Identifier: MIT
#include "capture/capture.h"

#include "base/clock.h"
#include "capture/capture_internal.h"
#include "capture/fill.h"

#define DEFAULT_CANDIDATES UINT64_C(1750000)
#define HALF_DIAGONAL 0.70710678118654752

enum {
    PROBE_RESOLUTION = 128,
    PROBE_VIEWS = 4,
    PROBE_VIEWS_LARGE = 2, ///< of a scene of more than PROBE_LARGE primitives
    PROBE_LARGE = 1000000,
    RESOLUTION_AUTO_MOST = 8192, ///< of a picture that is nearly empty
    RESOLUTION_OF_SETS = 1024,   ///< where the caller forgot to say
    ATTEMPTS = 3,
};

/// Whether a box has numbers that can be worked with; parts that have not are not drawn.
static bool is_usable(stp_boxd box)
{
    const double most = 1e30;
    return box.min.x <= box.max.x && box.min.y <= box.max.y && box.min.z <= box.max.z &&
           box.min.x > -most && box.min.y > -most && box.min.z > -most && box.max.x < most &&
           box.max.y < most && box.max.z < most;
}

static stp_result count_primitives(stp_capture_job* job, stp_boxd* box)
{
    const stp_scene* scene = job->scene;
    job->first_primitives = STP_NEW_ARRAY(scene->context, uint64_t, job->part_count + 1);
    if (job->first_primitives == NULL) {
        return stp_fail_memory(scene->context);
    }
    uint64_t sum = 0;

    for (size_t i = 0; i < job->part_count; ++i) {
        const stp_placed_part* placed = &job->parts[i];
        bool is_mesh = placed->part.kind == STP_PART_MESH;
        const stp_mesh* mesh = is_mesh ? &scene->meshes[placed->part.index] : NULL;
        const stp_point_set* points = is_mesh ? NULL : &scene->point_sets[placed->part.index];
        uint32_t count = is_mesh ? mesh->triangle_count : points->point_count;
        stp_box own = is_mesh ? mesh->bounds : points->bounds;
        job->first_primitives[i] = sum;
        sum += count;
        if (count != 0) {
            stp_boxd there = stp_affine_box(
                &placed->transform, (stp_boxd){stp_to_double(own.min), stp_to_double(own.max)});
            if (is_usable(there)) {
                stp_boxd_add(box, there.min);
                stp_boxd_add(box, there.max);
            }
        }
    }
    job->first_primitives[job->part_count] = sum;
    return stp_capture_prepare_sets(job, box);
}

/// How much of the views is covered, in pixels of 1 scene unit: from a few small pictures. Opposite
/// directions see the same outline, so only one of them is drawn.
static stp_result probe_area(stp_capture_job* job, const stp_vec3d* directions, uint32_t count,
                             double* area)
{
    stp_vec3d probes[PROBE_VIEWS];
    bool large = stp_capture_primitive_count(job) > PROBE_LARGE;
    uint32_t most = large ? PROBE_VIEWS_LARGE : PROBE_VIEWS, halves = 0, taken = 0;
    for (uint32_t i = 0; i < count; ++i) {
        const stp_vec3d* d = &directions[i];
        bool upper = d->z > 0.0 || (d->z == 0.0 && (d->y > 0.0 || (d->y == 0.0 && d->x > 0.0)));
        halves += upper ? 1 : 0;
        if (upper && taken < most) {
            probes[taken++] = *d;
        } else if (upper) { // an even pick of all, whatever their number
            uint32_t place = (uint32_t)((uint64_t)halves * 2 * most / count);
            probes[place < most ? place : most - 1] = *d;
        }
    }
    if (taken == 0) {
        probes[taken++] = directions[0];
    }
    double pixel_size = stp_capture_widest(job, probes, taken) / (double)PROBE_RESOLUTION;
    stp_capture_set_views(job, probes, taken, pixel_size);
    stp_result result = stp_capture_draw(job);
    if (result == STP_OK) {
        double mean = (double)job->covered_pixels / (double)taken;
        *area = mean * (double)count * pixel_size * pixel_size;
        stp_capture_drop_bands(job);
    }
    return result;
}

static double clamp_resolution(double resolution, double most)
{
    resolution = resolution > (double)STP_CAPTURE_RESOLUTION_LEAST
                     ? resolution
                     : (double)STP_CAPTURE_RESOLUTION_LEAST;
    return resolution < most ? resolution : most;
}

/// Draws the views at a resolution at which about `wanted` candidates come out.
static stp_result draw_wanted(stp_capture_job* job, const stp_vec3d* directions, uint32_t count,
                              uint64_t wanted, double* resolution)
{
    double area = 0.0, before = 0.0, widest = stp_capture_widest(job, directions, count);
    stp_result result = probe_area(job, directions, count, &area);
    for (int attempt = 0; result == STP_OK && attempt < ATTEMPTS; ++attempt) {
        double finest = widest / (double)RESOLUTION_AUTO_MOST;
        double pixel_size = area > 0.0 ? sqrt(area / (double)wanted) : finest;
        *resolution = clamp_resolution(widest / pixel_size, (double)RESOLUTION_AUTO_MOST);
        *resolution = (double)(uint32_t)(*resolution + 0.5);
        pixel_size = widest / *resolution;
        stp_capture_drop_bands(job);
        stp_capture_set_views(job, directions, count, pixel_size);
        result = stp_capture_draw(job);
        // thin parts may have slipped through the probe: then what was drawn is the better probe
        double got = (double)job->covered_pixels;
        area = got * pixel_size * pixel_size;
        bool capped = *resolution >= (double)RESOLUTION_AUTO_MOST && got < (double)wanted;
        bool near_enough = got > 0.5 * (double)wanted && got < 2.0 * (double)wanted;
        bool no_more = attempt > 0 && got < (double)wanted && got < 1.5 * before; // points run out
        if (capped || near_enough || no_more || got < 16.0) {
            break;
        }
        before = got;
    }
    return result;
}

static stp_result draw_views(stp_capture_job* job, const stp_capture_desc* desc,
                             stp_candidates* candidates)
{
    stp_context* context = job->scene->context;
    uint32_t count = desc->direction_count != 0 ? desc->direction_count : STP_CAPTURE_DIRECTIONS;
    uint64_t wanted = desc->wanted_candidates != 0 ? desc->wanted_candidates : DEFAULT_CANDIDATES;
    stp_vec3d* directions = STP_NEW_ARRAY(context, stp_vec3d, count);
    uint32_t view_room = (count > PROBE_VIEWS ? count : PROBE_VIEWS) + STP_CAPTURE_FILL_DIRECTIONS;
    job->views = STP_NEW_ARRAY(context, stp_capture_view, view_room);
    if (directions == NULL || job->views == NULL) {
        stp_free(context, directions);
        return stp_fail_memory(context);
    }
    stp_capture_directions(count, directions);
    double widest = stp_capture_widest(job, directions, count), resolution = 1.0;
    stp_result result = STP_OK;
    if (!(widest > 0.0)) { // everything in one point
        stp_capture_set_views(job, directions, count, 1.0);
        result = stp_capture_draw(job);
    } else if (desc->resolution != 0 || desc->pixel_size > 0.0 || job->set_count != 0) {
        resolution = desc->pixel_size > 0.0  ? widest / desc->pixel_size
                     : desc->resolution != 0 ? (double)desc->resolution
                                             : (double)RESOLUTION_OF_SETS;
        resolution = clamp_resolution(resolution, (double)STP_CAPTURE_RESOLUTION_MOST);
        stp_capture_set_views(job, directions, count, widest / resolution);
        result = stp_capture_draw(job);
    } else {
        result = draw_wanted(job, directions, count, wanted, &resolution);
    }
    candidates->pixel_size = widest > 0.0 ? widest / resolution : 1.0;
    candidates->resolution = (uint32_t)resolution;
    candidates->direction_count = count;
    stp_free(context, directions);
    job->first_pixels = job->covered_pixels;
    bool fill = !desc->no_fill && widest > 0.0 && count < STP_CAPTURE_FILL_DIRECTIONS;
    if (result == STP_OK && fill) {
        result = stp_capture_draw_fill(job, count, candidates->pixel_size);
    }
    return result;
}

static stp_result make_candidates(stp_capture_job* job, stp_candidates* candidates)
{
    stp_context* context = job->scene->context;
    uint64_t total = job->covered_pixels + stp_capture_seen_count(job);
    if (total >= UINT32_MAX) {
        return stp_fail(context, STP_ERROR_LIMIT,
                        "capture: %llu candidates are too many: choose a lower resolution",
                        (unsigned long long)total);
    }
    size_t count = (size_t)total;
    candidates->count = (uint32_t)job->covered_pixels;
    candidates->covered_pixels = job->first_pixels;
    if (count == 0) {
        return STP_OK;
    }
    candidates->positions = STP_NEW_ARRAY(context, float, 3 * count);
    candidates->normals = STP_NEW_ARRAY(context, float, 3 * count);
    candidates->colors = STP_NEW_ARRAY(context, uint8_t, 4 * count);
    candidates->materials = STP_NEW_ARRAY(context, uint32_t, count);
    candidates->view_starts = STP_NEW_ZEROED(context, uint32_t, candidates->direction_count + 1);
    if (candidates->positions == NULL || candidates->normals == NULL ||
        candidates->colors == NULL || candidates->materials == NULL ||
        candidates->view_starts == NULL) {
        return stp_fail_memory(context);
    }
    for (size_t b = 0; b < job->band_count; ++b) {
        uint32_t view = job->bands[b].view;
        if (view < candidates->direction_count) {
            candidates->view_starts[view + 1] += job->bands[b].count;
        }
    }
    for (uint32_t view = 0; view < candidates->direction_count; ++view) {
        candidates->view_starts[view + 1] += candidates->view_starts[view];
    }
    stp_capture_resolve(job, candidates);
    uint32_t first = (uint32_t)job->first_pixels;
    stp_result result = stp_capture_keep_missing(context, candidates, first);
    candidates->filled = candidates->count - first;
    candidates->surface_radius =
        candidates->count != 0 ? candidates->pixel_size * HALF_DIAGONAL : 0.0;
    return result == STP_OK ? stp_capture_resolve_sets(job, candidates) : result;
}

/// Mip levels of what the parts use, where the caller has none.
static stp_result find_textures(stp_capture_job* job, const stp_capture_desc* desc,
                                stp_capture_textures** own)
{
    if (desc->textures != NULL) {
        job->pyramids = desc->textures->pyramids;
        return STP_OK;
    }
    const stp_scene* scene = job->scene;
    stp_result result = stp_capture_textures_create_empty(scene, own);
    for (size_t i = 0; i < job->part_count && result == STP_OK; ++i) {
        stp_part part = job->parts[i].part;
        if (part.kind == STP_PART_MESH) {
            uint32_t material = scene->meshes[part.index].material;
            result = stp_capture_textures_add(*own, &scene->materials[material]);
        }
    }
    job->pyramids = *own != NULL ? (*own)->pyramids : NULL;
    return result;
}

// Numbers everything, and finds the box of all. @return whether there is anything, through `empty`
static stp_result begin_job(stp_capture_job* job, bool* empty)
{
    stp_boxd box = stp_boxd_empty();
    stp_result result = count_primitives(job, &box);
    *empty = stp_boxd_is_empty(box);
    if (result == STP_OK && !*empty) {
        job->centre = stp_scaled(stp_addd(box.min, box.max), 0.5);
        job->half_extent = stp_scaled(stp_subd(box.max, box.min), 0.5);
    }
    return result;
}

static void end_job(stp_capture_job* job)
{
    stp_context* context = job->scene->context;
    stp_capture_drop_bands(job);
    stp_capture_drop_sets(job);
    stp_free(context, job->views);
    stp_free(context, job->first_primitives);
}

static stp_capture_job make_job(const stp_scene* scene, const stp_capture_sources* sources,
                                uint64_t ids_a_pass)
{
    return (stp_capture_job){
        .scene = scene,
        .parts = sources->parts,
        .part_count = sources->part_count,
        .sets = sources->sets,
        .set_count = sources->set_count,
        .ids_a_pass = ids_a_pass,
    };
}

stp_result stp_capture_all_in_passes(const stp_scene* scene, const stp_capture_sources* sources,
                                     const stp_capture_desc* desc, uint64_t ids_a_pass,
                                     stp_candidates* candidates)
{
    stp_context* context = scene->context;
    stp_capture_job job = make_job(scene, sources, ids_a_pass);
    *candidates = (stp_candidates){0};
    bool empty = true;
    stp_capture_textures* own = NULL;
    double started = stp_clock_ms(), drawn = started;
    stp_result result = stp_progress(context, "capture", 0.0);
    result = result == STP_OK ? begin_job(&job, &empty) : result;
    if (result == STP_OK && !empty) {
        candidates->origin = job.centre;
        result = draw_views(&job, desc, candidates);
        drawn = stp_clock_ms();
        result = result == STP_OK ? stp_progress(context, "capture", 0.5) : result;
        result = result == STP_OK ? find_textures(&job, desc, &own) : result;
        result = result == STP_OK ? make_candidates(&job, candidates) : result;
        candidates->triangle_views =
            stp_capture_part_primitives(&job) * candidates->direction_count;
    }
    candidates->raster_ms = drawn - started;
    candidates->resolve_ms = stp_clock_ms() - drawn;
    stp_capture_textures_destroy(own);
    end_job(&job);
    if (result != STP_OK) {
        stp_candidates_destroy(context, candidates);
    }
    return result;
}

stp_result stp_capture_count_all(const stp_scene* scene, const stp_capture_sources* sources,
                                 const stp_capture_desc* desc, stp_capture_count* count)
{
    stp_capture_job job = make_job(scene, sources, UINT32_MAX - 1);
    stp_capture_desc quick = *desc;
    quick.no_fill = true;
    stp_candidates none = {0};
    bool empty = true;
    *count = (stp_capture_count){0};
    stp_result result = begin_job(&job, &empty);
    if (result == STP_OK && !empty) {
        result = draw_views(&job, &quick, &none);
    }
    if (result == STP_OK && !empty) {
        count->pixels = job.covered_pixels;
        count->surfels = stp_capture_seen_count(&job);
        count->widest = none.pixel_size * (double)none.resolution;
    }
    end_job(&job);
    return result;
}

stp_result stp_capture_all(const stp_scene* scene, const stp_capture_sources* sources,
                           const stp_capture_desc* desc, stp_candidates* candidates)
{
    return stp_capture_all_in_passes(scene, sources, desc, UINT32_MAX - 1, candidates);
}

stp_result stp_capture_parts_in_passes(const stp_scene* scene, const stp_placed_part* parts,
                                       size_t part_count, const stp_capture_desc* desc,
                                       uint64_t ids_a_pass, stp_candidates* candidates)
{
    stp_capture_sources sources = {.parts = parts, .part_count = part_count};
    return stp_capture_all_in_passes(scene, &sources, desc, ids_a_pass, candidates);
}

stp_result stp_capture_parts(const stp_scene* scene, const stp_placed_part* parts,
                             size_t part_count, const stp_capture_desc* desc,
                             stp_candidates* candidates)
{
    return stp_capture_parts_in_passes(scene, parts, part_count, desc, UINT32_MAX - 1, candidates);
}

void stp_candidates_destroy(stp_context* context, stp_candidates* candidates)
{
    stp_free(context, candidates->positions);
    stp_free(context, candidates->normals);
    stp_free(context, candidates->colors);
    stp_free(context, candidates->materials);
    stp_free(context, candidates->view_starts);
    *candidates = (stp_candidates){0};
}
