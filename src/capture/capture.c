// SPDX-License-Identifier: MIT
#include "capture/capture.h"

#include "base/core/clock.h"
#include "capture/capture_internal.h"
#include "capture/fill.h"

#include <assert.h>
#include <string.h>

#define DEFAULT_CANDIDATES UINT64_C(1750000)
#define HALF_DIAGONAL 0.70710678118654752

// Fraction of its box's outlines that an object usually covers.
#define PROBE_COVERED 0.5
// The probe view is kept if it promises between these multiples of the wanted candidates.
#define PROBE_MIN 0.75
#define PROBE_MAX 1.35

enum {
    RESOLUTION_AUTO_MAX = 8192, ///< limit for nearly empty pictures
    RESOLUTION_OF_SETS = 1024,  ///< default if a capture with sets gives none
    ATTEMPTS = 3,
    EMPTIEST = 100, ///< a share of covered pixels below 1 in 100 does not raise the resolution
    FILL_ROOM = 4,  ///< the fill gets spare room for 1 / FILL_ROOM of the candidates
};

/// Whether a box is valid. Parts with invalid boxes are not drawn.
static bool is_usable(stp_boxd box)
{
    const double maximum = 1e30;
    return box.min.x <= box.max.x && box.min.y <= box.max.y && box.min.z <= box.max.z &&
           box.min.x > -maximum && box.min.y > -maximum && box.min.z > -maximum &&
           box.max.x < maximum && box.max.y < maximum && box.max.z < maximum;
}

static stp_result count_primitives(stp_capture_job* job, stp_boxd* box)
{
    const stp_scene* scene = job->scene;
    job->first_primitives = STP_NEW_ARRAY(scene->context, uint64_t, job->part_count + 1);
    job->boxes = STP_NEW_ARRAY(scene->context, stp_box, job->part_count);
    if (job->first_primitives == NULL || job->boxes == NULL) {
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
        job->boxes[i] = own;
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

/// Area of the box's outline in a view: an upper bound on the area the view covers.
static double outline_area(const stp_capture_job* job, stp_vec3d toward)
{
    stp_vec3d h = job->half_extent;
    assert(!(h.x < 0.0) && !(h.y < 0.0) && !(h.z < 0.0));
    return 4.0 *
           (fabs(toward.x) * h.y * h.z + fabs(toward.y) * h.x * h.z + fabs(toward.z) * h.x * h.y);
}

static double clamp_resolution(double resolution, double maximum)
{
    return stp_clampd(resolution, (double)STP_CAPTURE_RESOLUTION_MIN, maximum);
}

/// Bounds for choosing the resolution.
typedef struct frame {
    double widest;   ///< longer side of the widest view, in scene units
    double maximum;  ///< highest resolution
    double outlines; ///< area of the box in all views: upper bound of the covered area
    uint64_t wanted; ///< candidates
} frame;

static frame make_frame(const stp_capture_job* job, const stp_vec3d* directions, uint32_t count,
                        uint64_t wanted)
{
    assert(wanted > 0 && count > 0);
    frame f = {.wanted = wanted};
    double area;
    f.widest = stp_capture_widest(job, directions, count, &area);
    double affordable =
        area > 0.0 ? f.widest * sqrt(STP_CAPTURE_MAX_PIXELS_EACH * (double)wanted / area) : 0.0;
    f.maximum = clamp_resolution(affordable, (double)RESOLUTION_AUTO_MAX);
    for (uint32_t i = 0; i < count; ++i) {
        f.outlines += outline_area(job, directions[i]);
    }
    return f;
}

/// Pixel size at which an area gives the wanted number of pixels. Resolutions are integers.
static double choose_pixel_size(const frame* f, double area, double* resolution)
{
    double finest = f->widest / f->maximum;
    double pixel_size = area > 0.0 ? sqrt(area / (double)f->wanted) : finest;
    *resolution = clamp_resolution(f->widest / pixel_size, f->maximum);
    *resolution = (double)(uint32_t)(*resolution + 0.5);
    assert(*resolution >= (double)STP_CAPTURE_RESOLUTION_MIN);
    return f->widest / *resolution;
}

static bool is_point(const stp_capture_job* job)
{
    stp_vec3d h = job->half_extent;
    return !(h.x > 0.0 || h.y > 0.0 || h.z > 0.0);
}

/// Draws the first view at a resolution guessed from the box, and estimates the covered area of all
/// views, in square units.
static stp_result probe_area(stp_capture_job* job, const stp_vec3d* directions, uint32_t count,
                             const frame* f, double* resolution, double* area)
{
    double pixel_size = choose_pixel_size(f, f->outlines * PROBE_COVERED, resolution);
    stp_capture_set_views(job, directions, count, pixel_size);
    stp_result result = stp_capture_draw(job, 0, 1);
    double first = outline_area(job, directions[0]);
    double share = first > 0.0 ? f->outlines / first : (double)count;
    *area = (double)job->covered_pixels * share * pixel_size * pixel_size;
    return result;
}

/// Draws the views at a resolution that gives about `wanted` candidates.
static stp_result draw_wanted(stp_capture_job* job, const stp_vec3d* directions, uint32_t count,
                              uint64_t wanted, double* resolution)
{
    frame f = make_frame(job, directions, count, wanted);
    double area = 0.0, before = 0.0;
    stp_result result = probe_area(job, directions, count, &f, resolution, &area);
    double probed = area * (*resolution / f.widest) * (*resolution / f.widest);
    uint32_t drawn = probed > PROBE_MIN * (double)wanted && probed < PROBE_MAX * (double)wanted;
    for (int attempt = 0; result == STP_OK && attempt < ATTEMPTS; ++attempt) {
        double pixel_size = f.widest / *resolution;
        bool sparse = area < f.outlines / EMPTIEST;
        assert(drawn <= count);
        if (drawn == 0) {
            area = sparse ? f.outlines / EMPTIEST : area;
            pixel_size = choose_pixel_size(&f, area, resolution);
            stp_capture_drop_bands(job);
            stp_capture_set_views(job, directions, count, pixel_size);
        }
        result = stp_capture_draw(job, drawn, count);
        drawn = 0;
        // the probe may have missed thin parts: then this drawing is the better probe
        double got = (double)job->covered_pixels;
        area = got * pixel_size * pixel_size;
        bool capped = (sparse || *resolution >= floor(f.maximum)) && got < (double)wanted;
        bool near_enough = got > 0.5 * (double)wanted && got < 2.0 * (double)wanted;
        bool no_more = attempt > 0 && got < (double)wanted && got < 1.5 * before; // no points left
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
    job->views = STP_NEW_ARRAY(context, stp_capture_view, count);
    if (directions == NULL || job->views == NULL) {
        stp_free(context, directions);
        return stp_fail_memory(context);
    }
    if (desc->directions != NULL && desc->direction_count != 0) {
        memcpy(directions, desc->directions, count * sizeof(directions[0]));
    } else {
        stp_capture_directions(count, directions);
    }
    double area, widest = stp_capture_widest(job, directions, count, &area), resolution = 1.0;
    stp_result result = STP_OK;
    if (!(widest > 0.0)) { // all points coincide
        stp_capture_set_views(job, directions, count, 1.0);
        result = stp_capture_draw(job, 0, count);
    } else if (desc->resolution != 0 || desc->pixel_size > 0.0 || job->set_count != 0) {
        resolution = desc->pixel_size > 0.0  ? widest / desc->pixel_size
                     : desc->resolution != 0 ? (double)desc->resolution
                                             : (double)RESOLUTION_OF_SETS;
        resolution = clamp_resolution(resolution, (double)STP_CAPTURE_RESOLUTION_MAX);
        stp_capture_set_views(job, directions, count, widest / resolution);
        result = stp_capture_draw(job, 0, count);
    } else {
        result = draw_wanted(job, directions, count, wanted, &resolution);
    }
    assert(resolution >= 1.0 && resolution <= (double)STP_CAPTURE_RESOLUTION_MAX);
    candidates->pixel_size = widest > 0.0 ? widest / resolution : 1.0;
    candidates->resolution = (uint32_t)resolution;
    candidates->direction_count = count;
    stp_free(context, directions);
    return result;
}

static stp_result find_view_starts(const stp_capture_job* job, stp_candidates* candidates)
{
    candidates->view_starts =
        STP_NEW_ZEROED(job->scene->context, uint32_t, candidates->direction_count + 1);
    if (candidates->view_starts == NULL) {
        return stp_fail_memory(job->scene->context);
    }
    for (size_t b = 0; b < job->band_count; ++b) {
        candidates->view_starts[job->bands[b].view + 1] += job->bands[b].count;
    }
    for (uint32_t view = 0; view < candidates->direction_count; ++view) {
        candidates->view_starts[view + 1] += candidates->view_starts[view];
    }
    assert(candidates->view_starts[candidates->direction_count] == (uint32_t)job->covered_pixels);
    return STP_OK;
}

static stp_result make_candidates(stp_capture_job* job, const stp_capture_desc* desc,
                                  stp_candidates* candidates)
{
    stp_context* context = job->scene->context;
    uint64_t first = job->covered_pixels;
    candidates->covered_pixels = first;
    if (first == 0 && job->set_count == 0) {
        return STP_OK;
    }
    bool fill = !desc->no_fill && desc->directions == NULL &&
                candidates->direction_count < STP_CAPTURE_FILL_DIRECTIONS && !is_point(job);
    stp_fill_map map = {0};
    stp_result result = find_view_starts(job, candidates);
    if (result == STP_OK && fill) {
        result = stp_fill_map_create(job, candidates, &map);
    }
    if (result == STP_OK) {
        result = stp_capture_append(job, fill ? first / FILL_ROOM : 0, candidates);
        assert(result != STP_OK || candidates->count == first);
    }
    if (result == STP_OK && fill) {
        stp_fill_map_set_surface(context, &map, candidates);
        result = stp_capture_fill(job, &map, candidates);
        assert(candidates->count >= first);
        candidates->filled = candidates->count - (uint32_t)first;
    }
    stp_fill_map_destroy(context, &map);
    candidates->surface_radius =
        candidates->count != 0 ? candidates->pixel_size * HALF_DIAGONAL : 0.0;
    if (result == STP_OK && job->set_count != 0) {
        result = stp_capture_make_room(job, stp_capture_seen_count(job), 0, candidates);
        result = result == STP_OK ? stp_capture_resolve_sets(job, candidates) : result;
        assert(result != STP_OK || candidates->set_count == stp_capture_seen_count(job));
    }
    return result;
}

/// Creates mip levels of the parts' textures if the caller gave none.
static stp_result find_textures(stp_capture_job* job, const stp_capture_desc* desc,
                                stp_capture_textures** own)
{
    if (desc->textures != NULL) {
        job->pyramids = desc->textures->pyramids;
        job->surfaces = desc->textures->surfaces;
        return STP_OK;
    }
    const stp_scene* scene = job->scene;
    stp_result result = stp_capture_textures_create_empty(scene, own);
    for (size_t i = 0; i < job->part_count && result == STP_OK; ++i) {
        stp_part part = job->parts[i].part;
        if (part.kind == STP_PART_MESH) {
            uint32_t material = scene->meshes[part.index].material;
            result = stp_capture_textures_add(*own, &scene->materials[material], false);
        }
    }
    job->pyramids = *own != NULL ? (*own)->pyramids : NULL;
    job->surfaces = *own != NULL ? (*own)->surfaces : NULL;
    return result;
}

static bool has_lights(const stp_capture_job* job)
{
    const stp_scene* scene = job->scene;
    bool any = false;
    for (size_t i = 0; i < job->set_count && !any; ++i) {
        any = job->sets[i].splats->light_octaves != 0;
    }
    for (size_t i = 0; i < job->part_count && scene->texture_count > 0 && !any; ++i) {
        stp_part part = job->parts[i].part;
        if (part.kind == STP_PART_MESH) {
            const stp_material* m = &scene->materials[scene->meshes[part.index].material];
            any = stp_scene_used_texture(scene, &m->normal_texture) != NULL;
        }
    }
    return any;
}

static void move_silhouettes(stp_capture_job* job, stp_candidates* candidates)
{
    for (uint32_t v = 0; v < job->view_count && v < STP_SILHOUETTES; ++v) {
        stp_capture_view* view = &job->views[v];
        assert(candidates->silhouette_count == v && "the first views have silhouettes, or none");
        if (view->silhouette == NULL) {
            break;
        }
        candidates->silhouettes[candidates->silhouette_count++] =
            (stp_silhouette){.toward = view->toward,
                             .right = view->right,
                             .down = view->down,
                             .shift_x = view->shift_x,
                             .shift_y = view->shift_y,
                             .width = view->width,
                             .height = view->height,
                             .words = view->silhouette};
        view->silhouette = NULL;
    }
    job->keeps_silhouettes = false; // fill views are drawn separately
}

// Numbers everything, and finds the box of all. Sets `empty` if there is nothing.
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
    stp_free(context, job->boxes);
    stp_free(context, job->first_primitives);
}

static stp_capture_job make_job(const stp_scene* scene, const stp_capture_sources* sources,
                                uint64_t ids_per_pass)
{
    assert(ids_per_pass > 0 && ids_per_pass < UINT32_MAX && "an id is left for empty pixels");
    return (stp_capture_job){
        .scene = scene,
        .parts = sources->parts,
        .part_count = sources->part_count,
        .sets = sources->sets,
        .set_count = sources->set_count,
        .ids_per_pass = ids_per_pass,
    };
}

stp_result stp_capture_all_in_passes(const stp_scene* scene, const stp_capture_sources* sources,
                                     const stp_capture_desc* desc, uint64_t ids_per_pass,
                                     stp_candidates* candidates)
{
    stp_context* context = scene->context;
    stp_capture_job job = make_job(scene, sources, ids_per_pass);
    *candidates = (stp_candidates){0};
    bool empty = true;
    stp_capture_textures* own = NULL;
    double started = stp_clock_ms(), drawn = started;
    stp_result result = stp_progress(context, "capture", 0.0);
    result = result == STP_OK ? begin_job(&job, &empty) : result;
    if (result == STP_OK && !empty) {
        candidates->origin = job.centre;
        job.keeps_silhouettes = true;
        result = draw_views(&job, desc, candidates);
        move_silhouettes(&job, candidates);
        drawn = stp_clock_ms();
        result = result == STP_OK ? stp_progress(context, "capture", 0.5) : result;
        result = result == STP_OK ? find_textures(&job, desc, &own) : result;
        job.has_lights = has_lights(&job);
        result = result == STP_OK ? make_candidates(&job, desc, candidates) : result;
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
        count->splats = stp_capture_seen_count(&job);
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
                                       uint64_t ids_per_pass, stp_candidates* candidates)
{
    stp_capture_sources sources = {.parts = parts, .part_count = part_count};
    return stp_capture_all_in_passes(scene, &sources, desc, ids_per_pass, candidates);
}

stp_result stp_capture_parts(const stp_scene* scene, const stp_placed_part* parts,
                             size_t part_count, const stp_capture_desc* desc,
                             stp_candidates* candidates)
{
    return stp_capture_parts_in_passes(scene, parts, part_count, desc, UINT32_MAX - 1, candidates);
}
