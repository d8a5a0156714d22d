// SPDX-License-Identifier: MIT
#include "select/cues.h"

#include "base/splats/leaf_codes.h"
#include "base/splats/octahedral.h"

#include <assert.h>

// minimum share of a hidden region's samples: some of it may be visible beside its occluders
#define MIN_SEEN 0.25
// cubes of at most this many leaves share one ray (docs/notes/2026-11-stochastic-speed.md)
#define RAY_LEAVES 32
#define POLISHED 0.4f  // surfaces below this roughness have highlights small enough to miss
#define ALIKE 0.9f     // cosine between the normals of two parts of one surface
#define STRAIGHT 1e-12 // components of a unit direction are at least this: avoids division by 0

/// Solves 3 equations by Cramer's rule. False if there is no unique solution.
static bool solve(const double (*m)[4], stp_vec3d right, stp_vec3d* out)
{
    stp_vec3d a = {m[0][0], m[1][0], m[2][0]}, b = {m[0][1], m[1][1], m[2][1]},
              c = {m[0][2], m[1][2], m[2][2]};
    double det = stp_dotd(a, stp_crossd(b, c));
    if (!(fabs(det) > 0.0) || !isfinite(1.0 / det)) {
        return false;
    }
    *out = (stp_vec3d){stp_dotd(right, stp_crossd(b, c)) / det,
                       stp_dotd(a, stp_crossd(right, c)) / det,
                       stp_dotd(a, stp_crossd(b, right)) / det};
    return true;
}

/// Whether any material of the file may show highlights.
static bool is_polished(const stp_store_directory* d)
{
    bool polished = false;
    for (uint32_t i = 0; d != NULL && i < d->shading_count && !polished; ++i) {
        polished = d->shadings[i].roughness < POLISHED;
    }
    return polished;
}

stp_cue_view stp_cue_view_make(const stp_selection* s, const stp_select_entry* at,
                               const stp_splats* set, const stp_store_leaves* leaves,
                               const stp_box_visibility* sight)
{
    const stp_view_frame* frame = &s->frames[0];
    stp_cue_view view = {.s = s,
                         .at = at,
                         .set = set,
                         .leaves = leaves,
                         .sight = sight,
                         .cues = STP_CUES_ALL & ~s->quality->cues_off,
                         .scale = stp_affine_scale(&at->transform),
                         .flat_view = frame->parallel};
    const double(*m)[4] = at->transform.m;
    stp_vec3d to = {frame->eye.x - m[0][3], frame->eye.y - m[1][3], frame->eye.z - m[2][3]};
    if (frame->parallel) {
        to = stp_scaled(frame->forward, -1.0);
    }
    stp_vec3d eye;
    if (!solve(m, to, &eye)) { // flattened: occlusion is unknown
        view.cues &= ~(uint32_t)STP_CUE_OCCLUSION_BIT;
        eye = (stp_vec3d){0};
    }
    if (!frame->parallel) {
        eye = stp_scaled(stp_subd(eye, stp_to_double(set->origin)), 1.0 / (double)set->step);
    }
    view.eye = eye;
    stp_vec3d light = stp_view_frame_direction(frame, stp_key_light);
    view.polished = is_polished(s->directory) && solve(m, light, &view.light);
    view.light = stp_normalized(view.light);
    return view;
}

static stp_vec3d middle_of(const stp_leaf_node* node)
{
    double half = 0.5 * (double)stp_leaf_width(node->depth);
    return (stp_vec3d){(double)node->corner[0] + half, (double)node->corner[1] + half,
                       (double)node->corner[2] + half};
}

double stp_cue_overhang(const stp_cue_view* view, const stp_leaf_node* node, const stp_boxd* box)
{
    assert(node->count > 0);
    const stp_view_frame* frame = &view->s->frames[0];
    stp_vec3d far = stp_subd(box->max, frame->eye), other = stp_subd(box->min, frame->eye);
    double depth = fmax(frame->forward.x * far.x, frame->forward.x * other.x) +
                   fmax(frame->forward.y * far.y, frame->forward.y * other.y) +
                   fmax(frame->forward.z * far.z, frame->forward.z * other.z);
    double pixel = stp_view_frame_pixel_size(frame, fmax(depth, frame->near_distance));
    double wanted = 0.5 * view->sight->largest_size * pixel;
    double own = STP_CUE_RADIUS * sqrt((double)node->area / (double)node->count) *
                 (double)view->set->step * view->scale;
    return STP_CUE_LONGEST * fmax(wanted, own);
}

stp_boxd stp_cue_box(const stp_cue_view* view, const stp_leaf_node* node)
{
    double step = (double)view->set->step, width = step * (double)stp_leaf_width(node->depth);
    stp_vec3d low = stp_to_double(view->set->origin);
    low = stp_addd(low, (stp_vec3d){step * (double)node->corner[0], step * (double)node->corner[1],
                                    step * (double)node->corner[2]});
    const stp_boxd box = {low, stp_addd(low, (stp_vec3d){width, width, width})};
    return stp_select_place_box(&view->at->transform, &box);
}

bool stp_cue_is_in_view(const stp_cue_view* view, const stp_leaf_node* node,
                        stp_box_visibility* sight)
{
    stp_boxd box = stp_cue_box(view, node);
    if (stp_select_is_in_view(view->s, &box, sight)) {
        return true;
    }
    double reach = stp_cue_overhang(view, node, &box);
    stp_vec3d margin = {reach, reach, reach};
    box = (stp_boxd){stp_subd(box.min, margin), stp_addd(box.max, margin)};
    return stp_select_is_in_view(view->s, &box, sight);
}

/// Pixels that a cube's surface covers if seen face-on: of a leaf at its nearest depth, of a cube
/// the mean over its depths. The mean of 1 / depth^2 from a to b is 1 / (a b).
static double pixels_of(const stp_cue_view* view, const stp_leaf_node* node,
                        const stp_box_visibility* sight)
{
    bool near = (view->cues & STP_CUE_COVERAGE_BIT) != 0;
    stp_depth_range range = near ? sight->range : view->sight->range;
    double depth = node->leaf_count > 1 ? sqrt(range.near * range.far) : range.near;
    double pixel = stp_view_frame_pixel_size(&view->s->frames[0], depth);
    double side = view->scale * (double)view->set->step / pixel;
    return (double)node->area * side * side;
}

static double size_of(const stp_cue_view* view, const stp_box_visibility* sight)
{
    bool near = (view->cues & STP_CUE_COVERAGE_BIT) != 0;
    return near ? sight->splat_size : view->sight->splat_size;
}

double stp_cue_nominal(const stp_cue_view* view, const stp_leaf_node* node,
                       const stp_box_visibility* sight)
{
    double size = size_of(view, sight);
    double covering = (view->cues & STP_CUE_ERROR_BIT) != 0 ? STP_CUE_COVERING : 1.0;
    return covering * pixels_of(view, node, sight) / (size * size);
}

/// Factor on samples for a silhouette, an edge or a highlight.
static double feature_of(const stp_cue_view* view)
{
    return (view->cues & STP_CUE_ERROR_BIT) != 0 ? STP_CUE_ERROR_FEATURE : STP_CUE_FEATURE;
}

static double bent_of(const stp_cue_view* view)
{
    bool bends = (view->cues & STP_CUE_FLATNESS_BIT) != 0;
    double bent = (view->cues & STP_CUE_ERROR_BIT) != 0 ? STP_CUE_ERROR_BENT : STP_CUE_BENT;
    return bends ? bent - 1.0 : 0.0;
}

static double factor_of_flatness(double bent, float flatness)
{
    return 1.0 + bent * fmin((double)flatness / (double)STP_LEAF_BENT, 1.0);
}

/// The factor on samples by flatness, feature by feature: of all, and of the part with edges.
typedef struct shape_factors {
    double all, edges;
} shape_factors;

static shape_factors shape_of(const stp_cue_view* view, const stp_leaf_node* node)
{
    double bent = bent_of(view);
    double edge = (view->cues & STP_CUE_EDGE_BIT) != 0 ? (double)node->edge : 0.0;
    return (shape_factors){factor_of_flatness(bent, node->flatness),
                           edge * factor_of_flatness(bent, node->edge_flatness)};
}

double stp_cue_shape(const stp_cue_view* view, const stp_leaf_node* node)
{
    shape_factors shape = shape_of(view, node);
    return shape.all + (feature_of(view) - 1.0) * shape.edges;
}

/// Unit vector from a cube's centre to the eye.
static stp_vec3d direction_to_eye(const stp_cue_view* view, const stp_leaf_node* node)
{
    return stp_normalized(view->flat_view ? view->eye : stp_subd(view->eye, middle_of(node)));
}

double stp_cue_highlight(const stp_cue_view* view, const stp_leaf_node* node)
{
    stp_vec3d half = stp_normalized(stp_addd(view->light, direction_to_eye(view, node)));
    stp_vec3 n = stp_octahedral_decode(node->normal[0], node->normal[1]);
    double cosine = fabs(stp_dotd(stp_to_double(n), half));
    double sine = sqrt(fmax(1.0 - cosine * cosine, 0.0)), spread = (double)node->spread / 255.0;
    if (!view->polished || (node->spread != 255 && sine >= spread + STP_CUE_HIGHLIGHT)) {
        return 0.0;
    }
    // normals of a cube that face any way: the share of the sphere around the mirror direction
    double own = fmin((double)node->turn + STP_CUE_HIGHLIGHT, 1.0);
    bool all = node->leaf_count == 1 || (node->spread != 255 && sine + spread < own);
    return all ? 1.0 : 1.0 - sqrt(1.0 - own * own);
}

double stp_cue_silhouette(const stp_cue_view* view, const stp_leaf_node* node)
{
    stp_vec3 n = stp_octahedral_decode(node->normal[0], node->normal[1]);
    stp_vec3d way = view->flat_view ? view->eye : stp_subd(view->eye, middle_of(node));
    // dot products of normals and directions are the same in set space, except for non-uniform
    // scales
    double length = sqrt(stp_dotd(way, way));
    double cosine = length > 0.0 ? stp_dotd(stp_to_double(n), way) / length : 0.0;
    bool may = node->spread == 255 || fabs(cosine) * 255.0 < (double)node->spread;
    if (!may || node->leaf_count == 1) {
        return may ? 1.0 : 0.0;
    }
    // cosines of the leaves lie anywhere between two limits; silhouettes are those below the
    // leaves' own spread
    double spread = node->spread == 255 ? 2.0 : (double)node->spread / 255.0;
    double low = fmax(cosine - spread, -1.0), high = fmin(cosine + spread, 1.0);
    double own = (double)node->turn;
    assert(high > low);
    return fmax(fmin(high, own) - fmax(low, -own), 0.0) / (high - low);
}

/// A ray from a cube's centre: parameters from 0 to `end`.
typedef struct ray {
    double from[3], per[3], end;
} ray;

static ray ray_of(const stp_cue_view* view, const stp_leaf_node* node)
{
    stp_vec3d middle = middle_of(node);
    stp_vec3d way = view->flat_view ? view->eye : stp_subd(view->eye, middle);
    double length = sqrt(stp_dotd(way, way));
    way = length > 0.0 ? stp_scaled(way, 1.0 / length) : way;
    ray r = {.from = {middle.x, middle.y, middle.z}, .end = view->flat_view ? HUGE_VAL : length};
    const double along[3] = {way.x, way.y, way.z};
    for (int k = 0; k < 3; ++k) { // planes along the ray are met only far away
        double step =
            fabs(along[k]) > STRAIGHT ? along[k] : (along[k] < 0.0 ? -STRAIGHT : STRAIGHT);
        r.per[k] = 1.0 / step;
    }
    return r;
}

/// Whether a ray enters a cube (Revelles, Urena, Lastra 2000: parameters of the planes of an
/// octree's cube). Comparisons instead of fmin and fmax, which are calls.
static bool enters(const ray* r, const stp_leaf_node* node)
{
    double in = 0.0, out = r->end, width = (double)stp_leaf_width(node->depth);
    for (int k = 0; k < 3; ++k) {
        double a = ((double)node->corner[k] - r->from[k]) * r->per[k];
        double b = a + width * r->per[k];
        double first = a < b ? a : b, last = a < b ? b : a;
        in = first > in ? first : in;
        out = last < out ? last : out;
    }
    return in < out;
}

/// Whether two cubes touch or overlap.
static bool touches(const stp_leaf_node* a, const stp_leaf_node* b)
{
    bool near = true;
    for (int k = 0; k < 3; ++k) {
        uint32_t a_low = a->corner[k], b_low = b->corner[k];
        near = near && a_low <= b_low + stp_leaf_width(b->depth) &&
               b_low <= a_low + stp_leaf_width(a->depth);
    }
    return near;
}

/// Whether another cube may hold more of the surface in this one: its plane passes through both,
/// and they face alike. A surface does not hide itself, however flat the ray lies along it.
static bool continues(const stp_leaf_node* a, stp_vec3 normal, const stp_leaf_node* b,
                      stp_vec3 other)
{
    stp_vec3 to = stp_to_float(stp_subd(middle_of(b), middle_of(a)));
    float half = 0.5f * (float)(stp_leaf_width(a->depth) + stp_leaf_width(b->depth));
    float reach = half * (fabsf(normal.x) + fabsf(normal.y) + fabsf(normal.z));
    return fabsf(stp_dot(to, normal)) <= reach && fabsf(stp_dot(normal, other)) >= ALIKE;
}

double stp_cue_before(const stp_cue_view* view, const stp_leaf_node* node, double enough)
{
    const stp_leaf_node* nodes = view->leaves->nodes;
    ray r = ray_of(view, node);
    stp_vec3 way = stp_to_float((stp_vec3d){1.0 / r.per[0], 1.0 / r.per[1], 1.0 / r.per[2]});
    stp_vec3 own = stp_octahedral_decode(node->normal[0], node->normal[1]);
    double before = 0.0;
    assert(!(enough < 0.0));
    for (uint32_t i = 0; i < view->leaves->node_count && before < enough;) {
        const stp_leaf_node* other = &nodes[i];
        assert(other->next > i && other->next <= view->leaves->node_count);
        bool entered = enters(&r, other);
        // smaller cubes than the node count as a whole
        bool whole = other->leaf_count == 1 || other->depth > node->depth;
        if (entered && whole && !touches(node, other)) {
            stp_vec3 n = stp_octahedral_decode(other->normal[0], other->normal[1]);
            bool hides = !continues(node, own, other, n);
            before += hides ? (double)other->count * (double)fabsf(stp_dot(n, way)) : 0.0;
        }
        i = entered && !whole ? i + 1 : other->next;
    }
    return before;
}

void stp_cue_trace(stp_cue_ray* last, const stp_cue_view* view, uint32_t index, bool whole,
                   const stp_box_visibility* sight)
{
    const stp_leaf_node* node = &view->leaves->nodes[index];
    if (index >= last->until && (whole || node->leaf_count <= RAY_LEAVES)) {
        last->before = stp_cue_before(view, node, stp_cue_occlusion_limit(view, node, sight));
        last->until = node->next;
    }
}

static double occlusion_of(double before, double pixels)
{
    return pixels > 0.0 ? fmin(STP_CUE_OCCLUSION * before / pixels, 1.0) : 0.0;
}

double stp_cue_occlusion_limit(const stp_cue_view* view, const stp_leaf_node* node,
                               const stp_box_visibility* sight)
{
    bool asks = (view->cues & STP_CUE_OCCLUSION_BIT) != 0;
    return asks ? (1.0 - MIN_SEEN) * pixels_of(view, node, sight) / STP_CUE_OCCLUSION : 0.0;
}

/// Factor on the samples of a cube by flatness, edges, silhouettes and highlights.
static double features_of(const stp_cue_view* view, const stp_leaf_node* node)
{
    bool asks_outline = (view->cues & STP_CUE_SILHOUETTE_BIT) != 0;
    bool asks_shine = (view->cues & STP_CUE_SPECULAR_BIT) != 0;
    double outline = asks_outline ? stp_cue_silhouette(view, node) : 0.0;
    double shine = asks_shine ? stp_cue_highlight(view, node) : 0.0;
    double either = 1.0 - (1.0 - outline) * (1.0 - shine); // of the part without edges
    shape_factors shape = shape_of(view, node);
    double marked = shape.edges + either * (shape.all - shape.edges);
    return shape.all + (feature_of(view) - 1.0) * marked;
}

/// Factor on samples for what lies before a cube.
static double seen_of(const stp_cue_view* view, const stp_leaf_node* node,
                      const stp_box_visibility* sight, double before)
{
    bool asks = (view->cues & STP_CUE_OCCLUSION_BIT) != 0;
    return asks ? fmax(1.0 - occlusion_of(before, pixels_of(view, node, sight)), MIN_SEEN) : 1.0;
}

double stp_cue_importance(const stp_cue_view* view, const stp_leaf_node* node,
                          const stp_box_visibility* sight, double before)
{
    return features_of(view, node) * stp_cue_nominal(view, node, sight) *
           seen_of(view, node, sight, before);
}

double stp_cue_samples(const stp_cue_view* view, const stp_leaf_node* node,
                       const stp_box_visibility* sight, double before)
{
    double all = (double)node->count;
    double samples = fmin(features_of(view, node) * stp_cue_nominal(view, node, sight), all) *
                     seen_of(view, node, sight, before);
    assert(!(samples > all) && "no cue asks for more splats than there are");
    return samples;
}
