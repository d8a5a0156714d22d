// SPDX-License-Identifier: MIT
#include "program/drawing/view_splats.h"

#include "base/splats/coverage.h"
#include "builder/shadings.h"
#include "capture/capture.h"
#include "lod/cloud_candidates.h"
#include "lod/psp/forest.h"
#include "lod/psp/kd_tree.h"
#include "program/files/splat_store.h"

#include <assert.h>
#include <stdlib.h>
#include <string.h>

#define MAX_PARTS ((size_t)1 << 22)
#define MAX_SAMPLES 4.0 // maximum samples per pixel of the picture, along either axis
#define CELL 1.2        // area per sample, in units of the squared coverage radius
#define GROWTH 1.1f     // ellipses overlap a little, because outlines of regions are not ellipses
#define MARGIN 0.38f    // coverage radius less that of a disk as large as a sample, in the former
#define SCATTERED 0.3f  // share of an ellipse that is surface, below which pixels are left out
#define MIN_COSINE 0.3  // minimum cosine to which splats turn towards the viewer, to close rims
#define FAR_NEIGHBOURS 4.0f // for clouds: maximum radius of a point, relative to the median
#define LARGEST_POINT 0.05  // maximum radius of a point, relative to the picture's height
#define PI 3.14159265358979323846

enum {
    MIN_PIXELS = 1 << 18,
    PIXELS_EACH = 128,
    CLOUD_NEIGHBOURS = 8,
    OUTLINE_SIDE = 4,
    FILL_PASSES = 4
};

typedef struct splat_maker {
    const stp_scene* scene;
    stp_context* context;
    stp_vec3d toward;
    stp_candidates candidates;
    stp_shading_set shadings;
    bool is_cloud, thinned;
    float largest;   ///< maximum radius of a point of a cloud
    float* areas;    ///< surface area that each candidate represents
    uint8_t* colors; ///< 3 bytes per candidate, sRGB
    stp_psp_splats left;
    // by splat
    uint32_t* indices;
    uint8_t *coverages, *materials;
} splat_maker;

/// The resolution that gives enough pixels to merge, and no more.
static double choose_pixel_size(const stp_view* view, uint32_t count)
{
    double pixels = (double)view->width * view->height;
    double wanted = fmax((double)MIN_PIXELS, (double)PIXELS_EACH * count);
    double samples = fmin(MAX_SAMPLES, sqrt(wanted / pixels));
    return view->ortho_height / view->height / samples;
}

static stp_result capture(splat_maker* m, double pixel_size)
{
    stp_placed_part* parts = NULL;
    size_t part_count = 0;
    stp_result result = stp_scene_flatten(m->scene, m->scene->root, MAX_PARTS, &parts, &part_count);
    if (result == STP_OK) {
        const stp_capture_desc desc = {
            .directions = &m->toward, .direction_count = 1, .pixel_size = pixel_size};
        result = stp_capture_parts(m->scene, parts, part_count, &desc, &m->candidates);
    }
    stp_free(m->context, parts);
    return result;
}

static void move_candidate(stp_candidates* c, size_t from, size_t to)
{
    memcpy(c->positions + 3 * to, c->positions + 3 * from, 3 * sizeof(float));
    memcpy(c->normals + 3 * to, c->normals + 3 * from, 3 * sizeof(float));
    memcpy(c->colors + 4 * to, c->colors + 4 * from, 4);
    c->materials[to] = c->materials[from];
}

/// Keeps every second pixel in a checkerboard: merging takes most of the time, and half the pixels
/// still define the outlines.
static void thin_out(splat_maker* m)
{
    stp_candidates* c = &m->candidates;
    const stp_silhouette* s = &c->silhouettes[0];
    uint32_t kept = 0;
    for (size_t i = 0; i < c->count; ++i) {
        const float* p = c->positions + 3 * i;
        stp_vec3d at = {(double)p[0], (double)p[1], (double)p[2]};
        double x = stp_dotd(s->right, at) + s->shift_x, y = stp_dotd(s->down, at) + s->shift_y;
        if ((((int64_t)floor(x) + (int64_t)floor(y)) & 1) == 0) {
            move_candidate(c, i, kept++);
        }
    }
    if (kept > 0) { // else it is a thin line along a diagonal
        c->count = kept;
        m->thinned = true;
    }
}

static bool lacks_normals(const stp_scene* scene)
{
    bool lacks = false;
    for (size_t i = 0; i < scene->point_set_count; ++i) {
        lacks = lacks || scene->point_sets[i].normals == NULL;
    }
    return lacks;
}

static int compare_floats(const void* a, const void* b)
{
    float x = *(const float*)a, y = *(const float*)b;
    return (x > y) - (x < y);
}

/// Finds the distance from each point of a cloud to the farthest of its nearest points, and half
/// its square, which is the area of a point on a grid. @return the median distance, or -1
static float measure_cloud(const splat_maker* m)
{
    const stp_candidates* c = &m->candidates;
    uint32_t* near = STP_NEW_ARRAY(m->context, uint32_t, CLOUD_NEIGHBOURS * (size_t)c->count);
    float* radii = STP_NEW_ARRAY(m->context, float, c->count);
    bool made = near != NULL && radii != NULL &&
                stp_find_nearest_points(m->context, c->positions, c->count, CLOUD_NEIGHBOURS,
                                        near) == STP_OK;
    for (size_t i = 0; made && i < c->count; ++i) {
        const float* p = c->positions + 3 * i;
        float maximum = 0.0f;
        for (size_t k = 0; k < CLOUD_NEIGHBOURS; ++k) {
            uint32_t other = near[CLOUD_NEIGHBOURS * i + k];
            if (other != UINT32_MAX) {
                const float* q = c->positions + 3 * (size_t)other;
                maximum =
                    stp_max(maximum, stp_length((stp_vec3){p[0] - q[0], p[1] - q[1], p[2] - q[2]}));
            }
        }
        m->areas[i] = radii[i] = stp_max(maximum, 0.5f * (float)c->pixel_size);
    }
    float median = -1.0f;
    if (made) {
        qsort(radii, c->count, sizeof(radii[0]), compare_floats);
        median = radii[c->count / 2];
        for (size_t i = 0; i < c->count; ++i) {
            float radius = stp_min(stp_min(m->areas[i], FAR_NEIGHBOURS * median), m->largest);
            m->areas[i] = 0.5f * radius * radius;
        }
    }
    stp_free(m->context, near);
    stp_free(m->context, radii);
    return median;
}

/// Turns a normal towards the viewer and away from grazing angles: a smooth normal may differ so
/// much from that of the surface that its disk would cover nothing. @return the cosine with the
/// view
static double face_viewer(const splat_maker* m, size_t i)
{
    float* n = m->candidates.normals + 3 * i;
    stp_vec3d normal = {(double)n[0], (double)n[1], (double)n[2]};
    double cosine = stp_dotd(normal, m->toward);
    if (cosine < 0.0 && m->is_cloud) {
        normal = stp_scaled(normal, -1.0);
        cosine = -cosine;
    }
    if (cosine < MIN_COSINE) {
        stp_vec3d across = stp_subd(normal, stp_scaled(m->toward, cosine));
        double length = sqrt(stp_dotd(across, across));
        double sine = sqrt(1.0 - MIN_COSINE * MIN_COSINE);
        cosine = MIN_COSINE;
        normal = length > 0.0
                     ? stp_addd(stp_scaled(m->toward, cosine), stp_scaled(across, sine / length))
                     : m->toward;
    }
    n[0] = (float)normal.x;
    n[1] = (float)normal.y;
    n[2] = (float)normal.z;
    return cosine;
}

/// Finds the area of each candidate: for a mesh the surface behind its pixel, for a cloud that
/// around its point.
static stp_result measure_candidates(splat_maker* m)
{
    const stp_candidates* c = &m->candidates;
    m->areas = STP_NEW_ARRAY(m->context, float, c->count);
    m->colors = STP_NEW_ARRAY(m->context, uint8_t, 3 * (size_t)c->count);
    if (m->areas == NULL || m->colors == NULL) {
        return stp_fail_memory(m->context);
    }
    if (m->is_cloud) {
        float radius = measure_cloud(m);
        if (radius < 0.0f) {
            return stp_fail_memory(m->context);
        }
        if (lacks_normals(m->scene)) {
            stp_result result = stp_estimate_point_normals(m->context, &m->candidates, radius);
            if (result != STP_OK) {
                return result;
            }
        }
    }
    for (size_t i = 0; i < c->count; ++i) {
        memcpy(m->colors + 3 * i, c->colors + 4 * i, 3);
        double cosine = face_viewer(m, i);
        if (m->is_cloud) {
            continue;
        }
        // only every second pixel of a blended surface is captured
        bool blended = m->scene->materials[c->materials[i]].alpha_mode == STP_ALPHA_BLEND;
        double hidden = (blended ? 2.0 : 1.0) * (m->thinned ? 2.0 : 1.0);
        m->areas[i] = (float)(hidden * c->pixel_size * c->pixel_size / cosine);
    }
    return STP_OK;
}

/// Enlarges an ellipse so that splats close gaps, and computes its opacity.
static void finish_splat(const splat_maker* m, uint32_t i)
{
    stp_ellipse* e = &m->left.ellipses[i];
    uint32_t first = m->left.firsts[i];
    assert(first < m->candidates.count);
    float major = stp_length(e->major), side = (float)m->candidates.pixel_size;
    float share = m->left.areas[i] / (float)(PI * (double)major * (double)e->minor);
    bool scattered = share < SCATTERED;
    float cell = m->is_cloud ? m->areas[first] : (m->thinned ? 2.0f : 1.0f) * side * side;
    float margin = MARGIN * sqrtf(cell / (float)CELL), scale = scattered ? 1.0f : GROWTH;
    if (major > 0.0f) {
        e->major = stp_scale(e->major, (major * scale + margin) / major);
    }
    e->minor = stp_min(e->minor * scale + margin, stp_length(e->major));
    uint32_t material = m->candidates.materials[first];
    m->materials[i] = m->shadings.of_material[material];
    m->coverages[i] =
        m->scene->materials[material].alpha_mode == STP_ALPHA_BLEND
            ? stp_coverage_of_share((double)m->candidates.colors[4 * (size_t)first + 3] / 255.0)
        : scattered ? stp_coverage_of_share((double)share)
                    : STP_COVERAGE_WHOLE;
    m->indices[i] = i;
}

static stp_result merge(splat_maker* m, uint32_t count)
{
    const stp_candidates* c = &m->candidates;
    const stp_psp_points points = {.count = c->count,
                                   .positions = c->positions,
                                   .normals = c->normals,
                                   .colors = m->colors,
                                   .areas = m->areas};
    stp_psp_desc desc = stp_psp_desc_default();
    desc.metric = STP_PSP_REGIONS;
    desc.connect_components = true;
    stp_result result = stp_psp_decimate(m->context, &points, &desc, count, &m->left);
    if (result != STP_OK) {
        return result;
    }
    m->indices = STP_NEW_ARRAY(m->context, uint32_t, m->left.count);
    m->coverages = STP_NEW_ARRAY(m->context, uint8_t, m->left.count);
    m->materials = STP_NEW_ARRAY(m->context, uint8_t, m->left.count);
    if (m->indices == NULL || m->coverages == NULL || m->materials == NULL) {
        return stp_fail_memory(m->context);
    }
    for (uint32_t i = 0; i < m->left.count; ++i) {
        finish_splat(m, i);
    }
    return STP_OK;
}

static stp_result open_store(const splat_maker* m, stp_store** store)
{
    stp_vec3d origin = m->candidates.origin;
    const tool_splats splats = {.ellipses = m->left.ellipses,
                                .colors = m->left.colors,
                                .indices = m->indices,
                                .count = m->left.count,
                                .origin = {origin.x, origin.y, origin.z},
                                .coverages = m->coverages,
                                .materials = m->materials,
                                .shadings = m->shadings.shadings,
                                .shading_count = m->shadings.count};
    return tool_open_splat_store(m->context, &splats, 'y', store);
}

/// Blended surfaces and points do not cover all of their pixels.
static void take_outline(splat_maker* m, view_splats* made)
{
    stp_candidates* c = &m->candidates;
    bool whole = !m->is_cloud && c->silhouette_count > 0;
    for (size_t i = 0; i < c->count && whole; ++i) {
        whole = m->scene->materials[c->materials[i]].alpha_mode != STP_ALPHA_BLEND;
    }
    if (whole) {
        made->outline = c->silhouettes[0];
        made->origin = c->origin;
        made->has_outline = true;
    }
}

/// The share of a pixel inside the outline, of 255.
static uint8_t share_of_pixel(const view_splats* made, stp_vec3d corner, stp_vec3d right,
                              stp_vec3d down)
{
    uint32_t inside = 0;
    for (uint32_t k = 0; k < OUTLINE_SIDE * OUTLINE_SIDE; ++k) {
        double x = ((double)(k % OUTLINE_SIDE) + 0.5) / OUTLINE_SIDE;
        double y = ((double)(k / OUTLINE_SIDE) + 0.5) / OUTLINE_SIDE;
        stp_vec3d at = stp_addd(corner, stp_addd(stp_scaled(right, x), stp_scaled(down, y)));
        inside += stp_silhouette_holds(&made->outline, at) ? 1u : 0u;
    }
    return (uint8_t)(255u * inside / (OUTLINE_SIDE * OUTLINE_SIDE));
}

/// Fills a pixel with the mean of its coloured neighbours. @return whether there are any
static bool fill_pixel(const stp_image* image, uint32_t x, uint32_t y)
{
    uint32_t sums[3] = {0}, count = 0;
    for (uint32_t v = y > 0 ? y - 1 : 0; v <= y + 1 && v < image->height; ++v) {
        for (uint32_t u = x > 0 ? x - 1 : 0; u <= x + 1 && u < image->width; ++u) {
            const uint8_t* beside = image->pixels + 4 * ((size_t)v * image->width + u);
            for (size_t k = 0; k < 3 && beside[3] > 0; ++k) {
                sums[k] += beside[k];
            }
            count += beside[3] > 0 ? 1 : 0;
        }
    }
    uint8_t* pixel = image->pixels + 4 * ((size_t)y * image->width + x);
    for (size_t k = 0; k < 3 && count > 0; ++k) {
        pixel[k] = (uint8_t)(sums[k] / count);
    }
    return count > 0;
}

stp_result view_splats_trim(stp_context* context, const view_splats* made, const stp_view* view,
                            stp_image* image)
{
    size_t count = (size_t)image->width * image->height;
    uint8_t* shares = made->has_outline ? STP_NEW_ARRAY(context, uint8_t, count) : NULL;
    if (shares == NULL) {
        return made->has_outline ? stp_fail_memory(context) : STP_OK;
    }
    assert(image->width == view->width && image->height == view->height);
    stp_vec3d gaze = stp_normalized(stp_subd(view->target, view->eye));
    double side = view->ortho_height / view->height;
    stp_vec3d right = stp_scaled(stp_normalized(stp_crossd(gaze, view->up)), side);
    stp_vec3d down = stp_crossd(gaze, right), middle = stp_subd(view->target, made->origin);
    for (size_t i = 0; i < count; ++i) {
        double x = (double)(i % image->width) - 0.5 * image->width;
        double y = (double)(i / image->width) - 0.5 * image->height;
        stp_vec3d corner = stp_addd(middle, stp_addd(stp_scaled(right, x), stp_scaled(down, y)));
        shares[i] = share_of_pixel(made, corner, right, down);
    }
    for (int pass = 0; pass < FILL_PASSES; ++pass) {
        for (size_t i = 0; i < count; ++i) {
            uint32_t x = (uint32_t)(i % image->width), y = (uint32_t)(i / image->width);
            if (shares[i] > 0 && image->pixels[4 * i + 3] == 0 && fill_pixel(image, x, y)) {
                image->pixels[4 * i + 3] = shares[i];
            }
        }
    }
    for (size_t i = 0; i < count; ++i) {
        uint8_t* pixel = image->pixels + 4 * i;
        pixel[3] = pixel[3] > 0 ? shares[i] : 0;
        memset(pixel, 0, pixel[3] == 0 ? 3 : 0);
    }
    stp_free(context, shares);
    return STP_OK;
}

void view_splats_destroy(stp_context* context, view_splats* made)
{
    if (made->store != NULL) {
        stp_store_close(made->store);
    }
    stp_free(context, made->outline.words);
    *made = (view_splats){0};
}

stp_result view_splats_make(const stp_scene* scene, const stp_view* view, uint32_t count,
                            view_splats* made)
{
    *made = (view_splats){0};
    splat_maker m = {.scene = scene,
                     .context = scene->context,
                     .toward = stp_normalized(stp_subd(view->eye, view->target)),
                     .largest = (float)(LARGEST_POINT * view->ortho_height),
                     .is_cloud = scene->nodes[scene->root].point_count > 0};
    stp_result result = capture(&m, choose_pixel_size(view, count));
    if (result == STP_OK && m.candidates.count > 0) {
        take_outline(&m, made);
        if (!m.is_cloud && m.candidates.silhouette_count > 0) {
            thin_out(&m);
        }
        result = stp_make_shadings(scene, false, &m.shadings);
        result = result == STP_OK ? measure_candidates(&m) : result;
        result = result == STP_OK ? merge(&m, count) : result;
        result = result == STP_OK ? open_store(&m, &made->store) : result;
        made->candidates = m.candidates.count;
        made->splats = m.left.count;
    }
    if (made->has_outline) { // the caller's now
        m.candidates.silhouettes[0].words = NULL;
    }
    if (result != STP_OK) {
        view_splats_destroy(m.context, made);
    }
    stp_candidates_destroy(m.context, &m.candidates);
    stp_psp_splats_destroy(m.context, &m.left);
    void* arrays[] = {
        m.shadings.of_material, m.areas, m.colors, m.indices, m.coverages, m.materials};
    for (size_t i = 0; i < sizeof(arrays) / sizeof(arrays[0]); ++i) {
        stp_free(m.context, arrays[i]);
    }
    return result;
}
