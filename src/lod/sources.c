// SPDX-License-Identifier: MIT
#include "lod/sources.h"

#include "base/core/saturate.h"
#include "base/math/math.h"
#include "base/splats/prefix_table.h"

#include <assert.h>

typedef enum thinning { THIN_NOTHING, THIN_COUNT, THIN_LIST } thinning;

// A node during traversal.
typedef struct frame {
    uint32_t node, next_edge;
    stp_affine transform;
    uint32_t flags;
    bool in_group; ///< inside thinned content
} frame;

typedef struct walk {
    const stp_scene* scene;
    const stp_splats* const* sets;
    double pixel;
    size_t limit;
    stp_source_list* list;
    frame* stack;
    size_t depth, capacity;
    thinning mode;
    double small;   ///< instances with a smaller extent are thinned
    size_t kept;    ///< instances that are not thinned
    uint64_t* uses; ///< per node: instances of parts and sets below; NULL until thinned
    /// Count of thinned instances; one of `every` is kept; number of the next one
    uint64_t thin_uses, every, number;
    bool lacks_normals; ///< some point sets of the scene lack normals
} walk;

static stp_result push(walk* w, const frame* f)
{
    stp_context* context = w->scene->context;
    if (!STP_MAKE_ROOM(context, w->stack, w->capacity, w->depth + 1)) {
        return stp_fail_memory(context);
    }
    w->stack[w->depth++] = *f;
    return STP_OK;
}

static const stp_splats* set_of(const walk* w, uint32_t node)
{
    const stp_splats* set = w->sets != NULL ? w->sets[node] : NULL;
    return set != NULL && set->count != 0 && set->table.size != 0 ? set : NULL;
}

static double box_extent(stp_boxd box)
{
    stp_vec3d size = stp_subd(box.max, box.min);
    return stp_boxd_is_empty(box) ? 0.0 : sqrt(stp_dotd(size, size));
}

// Half the surface of a box: bound of its projected area, averaged over eight corners.
static double box_area(stp_boxd box)
{
    stp_vec3d size = stp_subd(box.max, box.min);
    return stp_boxd_is_empty(box) ? 0.0 : size.x * size.y + size.y * size.z + size.z * size.x;
}

static stp_result add_set(walk* w, const frame* f, const stp_splats* set, double scale,
                          uint32_t prefix)
{
    stp_context* context = w->scene->context;
    stp_source_list* list = w->list;
    if (!STP_MAKE_ROOM(context, list->sets, list->set_capacity, list->set_count + 1)) {
        return stp_fail_memory(context);
    }
    assert(prefix <= set->count);
    float radius = stp_prefix_table_radius(&set->table, prefix) + set->candidate_radius;
    const stp_node* node = &w->scene->nodes[f->node];
    list->sets[list->set_count++] =
        (stp_placed_set){.splats = set,
                         .prefix = prefix,
                         .radius = radius,
                         .transform = f->transform,
                         .unknown_signs = w->lacks_normals && node->triangle_count == 0};
    list->triangle_count += node->triangle_count;
    list->point_count += node->point_count;
    list->splats += (double)prefix;
    double needed = 2.0 * scale * (double)stp_prefix_table_radius(&set->table, set->count);
    list->coarsest = needed > list->coarsest ? needed : list->coarsest;
    return STP_OK;
}

// Approximate pixels covered by a node's own triangles in eight directions: a quarter of their area
// in each, from both sides.
static double own_pixels(const walk* w, const stp_node* node, double scale)
{
    double area = node->area;
    for (uint32_t i = 0; i < node->edge_count && area > 0.0; ++i) {
        const stp_edge* edge = &w->scene->edges[node->first_edge + i];
        double factor = stp_affine_stretch(&edge->transform);
        area -= w->scene->nodes[edge->node].area * factor * factor;
    }
    area = node->area > 0.0 ? area : box_area(node->bounds);
    return area > 0.0 ? 2.0 * area * scale * scale / (w->pixel * w->pixel) : 0.0;
}

static stp_result add_part(walk* w, const frame* f, stp_part part)
{
    stp_context* context = w->scene->context;
    stp_source_list* list = w->list;
    if (!STP_MAKE_ROOM(context, list->parts, list->part_capacity, list->part_count + 1)) {
        return stp_fail_memory(context);
    }
    list->parts[list->part_count++] =
        (stp_placed_part){.part = part, .transform = f->transform, .flags = f->flags};
    bool mesh = part.kind == STP_PART_MESH;
    uint32_t triangles = mesh ? w->scene->meshes[part.index].triangle_count : 0;
    list->triangle_count += triangles;
    list->part_triangles += triangles;
    list->point_count += mesh ? 0 : w->scene->point_sets[part.index].point_count;
    return STP_OK;
}

// Stays far enough below the largest number that one more fits.
static uint64_t add_uses(uint64_t a, uint64_t b)
{
    uint64_t sum = stp_add_saturated(a, b);
    return sum < UINT64_MAX / 2 ? sum : UINT64_MAX / 2;
}

// Number of instances below each node: a set is one.
static stp_result count_uses(walk* w, uint32_t top)
{
    stp_context* context = w->scene->context;
    w->uses = STP_NEW_ARRAY(context, uint64_t, (size_t)top + 1);
    if (w->uses == NULL) {
        return stp_fail_memory(context);
    }
    for (uint32_t i = 0; i <= top; ++i) {
        const stp_node* node = &w->scene->nodes[i];
        uint64_t sum = node->part_count;
        for (uint32_t k = 0; k < node->edge_count; ++k) {
            uint32_t child = w->scene->edges[node->first_edge + k].node;
            assert(child < i && "children have lower indices");
            bool moving = (w->scene->nodes[child].flags & STP_OBJECT_MOVING) != 0;
            sum = add_uses(sum, moving ? 0 : w->uses[child]);
        }
        w->uses[i] = set_of(w, i) != NULL ? 1 : sum;
    }
    return STP_OK;
}

// Whether the next `count` thinned instances include a kept one.
static bool holds_kept(const walk* w, uint64_t count)
{
    assert(w->every > 0 && "instances were counted");
    uint64_t rest = w->number % w->every;
    return count > 0 && (rest == 0 || count > w->every - rest);
}

// Counts a thinned instance. @return whether it is kept
static bool take_number(walk* w)
{
    bool kept = w->number % w->every == 0;
    w->number += 1;
    w->list->thinned += kept ? 0 : 1;
    return kept;
}

static stp_result enter_parts(walk* w, const frame* f, double scale)
{
    const stp_node* node = &w->scene->nodes[f->node];
    stp_result result = STP_OK;
    bool any = false;
    for (uint32_t i = 0; result == STP_OK && i < node->part_count; ++i) {
        if (!f->in_group || take_number(w)) {
            any = true;
            w->kept += 1;
            if (w->mode != THIN_COUNT) {
                result = add_part(w, f, w->scene->node_parts[node->first_part + i]);
            }
        }
    }
    if (any && result == STP_OK && w->mode != THIN_COUNT) {
        w->list->pixels += own_pixels(w, node, scale);
    }
    return result;
}

// Visits a node: lists its set; or lists its parts and pushes the node, so that its children follow.
static stp_result enter(walk* w, frame f, bool first)
{
    const stp_node* node = &w->scene->nodes[f.node];
    const stp_splats* set = first ? NULL : set_of(w, f.node);
    double scale = stp_affine_stretch(&f.transform);
    bool small = !first && !f.in_group && w->mode != THIN_NOTHING &&
                 box_extent(node->bounds) * scale < w->small;
    if (small && w->mode == THIN_COUNT) {
        w->thin_uses = add_uses(w->thin_uses, w->uses[f.node]);
        return STP_OK;
    }
    f.in_group = f.in_group || small;
    if (f.in_group && !holds_kept(w, w->uses[f.node])) {
        w->number += w->uses[f.node];
        w->list->thinned += w->uses[f.node];
        return STP_OK;
    }
    if (set != NULL) {
        float wanted = (float)(0.5 * w->pixel / scale);
        uint32_t prefix = scale > 0.0 ? stp_prefix_table_count(&set->table, wanted) : 1;
        bool dense = !(scale > 0.0) || stp_prefix_table_radius(&set->table, prefix) <= wanted;
        if (dense || f.in_group) {
            bool kept = !f.in_group || take_number(w);
            w->kept += kept ? 1 : 0;
            return kept && w->mode != THIN_COUNT ? add_set(w, &f, set, scale, prefix) : STP_OK;
        }
    }
    stp_result result = enter_parts(w, &f, scale);
    return result == STP_OK ? push(w, &f) : result;
}

// Traverses once. Stops early, with more `kept` than the limit, if that many instances are not
// thinned.
static stp_result walk_once(walk* w, uint32_t node)
{
    w->kept = 0;
    w->depth = 0;
    w->number = 0;
    frame top = {.node = node, .transform = stp_affine_identity()};
    stp_result result = enter(w, top, true);
    while (result == STP_OK && w->depth > 0 && w->kept <= w->limit) {
        frame* f = &w->stack[w->depth - 1];
        const stp_node* at = &w->scene->nodes[f->node];
        assert(f->next_edge <= at->edge_count);
        if (f->next_edge == at->edge_count) {
            w->depth -= 1;
            continue;
        }
        const stp_edge* edge = &w->scene->edges[at->first_edge + f->next_edge++];
        uint32_t flags = w->scene->nodes[edge->node].flags;
        if ((flags & STP_OBJECT_MOVING) != 0) {
            continue;
        }
        frame child = {.node = edge->node,
                       .transform = stp_affine_multiply(f->transform, edge->transform),
                       .flags = f->flags | flags,
                       .in_group = f->in_group};
        result = enter(w, child, false);
    }
    return result;
}

static void clear_list(stp_source_list* list)
{
    list->part_count = list->set_count = 0;
    list->triangle_count = list->point_count = list->part_triangles = list->thinned = 0;
    list->splats = list->pixels = list->coarsest = 0.0;
}

// Thins instances smaller than a pixel; if that is not enough, smaller than two, four, ... pixels
static stp_result walk_thinned(walk* w, uint32_t node)
{
    stp_result result = count_uses(w, node);
    size_t limit = w->limit;
    assert(limit > 0 && w->kept > limit && "otherwise nothing needs thinning");
    w->small = w->pixel;
    w->mode = THIN_COUNT;
    w->limit = limit / 2;
    do {
        w->thin_uses = 0;
        result = result == STP_OK ? walk_once(w, node) : result;
        w->small *= 2.0;
    } while (result == STP_OK && w->kept > w->limit && w->small < 1e300);
    w->small *= 0.5;
    w->every = w->thin_uses / (limit - limit / 2) + 1;
    w->mode = THIN_LIST;
    w->limit = SIZE_MAX;
    clear_list(w->list);
    result = result == STP_OK ? walk_once(w, node) : result;
    assert((result != STP_OK || w->thin_uses >= UINT64_MAX / 2 || w->small >= 1e299 ||
            w->list->part_count + w->list->set_count <= limit) &&
           "what is left fits");
    stp_free(w->scene->context, w->uses);
    return result;
}

stp_result stp_list_sources(const stp_scene* scene, uint32_t node, const stp_splats* const* sets,
                            double pixel_size, size_t limit, stp_source_list* list)
{
    *list = (stp_source_list){0};
    if (node == STP_NONE) {
        return STP_OK;
    }
    walk w = {.scene = scene,
              .sets = sets,
              .pixel = pixel_size > 0.0 ? pixel_size : 1e-30,
              .limit = limit,
              .list = list};
    for (size_t i = 0; i < scene->point_set_count && sets != NULL; ++i) {
        w.lacks_normals = w.lacks_normals || scene->point_sets[i].normals == NULL;
    }
    stp_result result = walk_once(&w, node);
    if (result == STP_OK && w.kept > w.limit) {
        result = walk_thinned(&w, node);
    }
    stp_free(scene->context, w.stack);
    if (result != STP_OK) {
        stp_source_list_destroy(scene->context, list);
    }
    return result;
}

void stp_source_list_destroy(stp_context* context, stp_source_list* list)
{
    stp_free(context, list->parts);
    stp_free(context, list->sets);
    *list = (stp_source_list){0};
}
