// SPDX-License-Identifier: MIT
#include "select/select.h"

#include "base/prefix_table.h"
#include "select/view_frame.h"

/// A node still to be looked at.
typedef struct stp_select_stack {
    uint32_t node;
    bool moving_only; ///< an ancestor's surfels stand for all that does not move
    stp_affine transform;
} stp_select_stack;

typedef struct selection {
    stp_context* context;
    const stp_store* store;
    const stp_store_directory* directory;
    const stp_quality* quality;
    stp_draw_list* list;
    stp_view_frame frame;
    size_t stack_count;
    uint64_t visits;
} selection;

enum { NODE_MOVES = 1, MOVES_BELOW = 2 };

/// A graph of a few shared nodes can stand for more visits than anybody can wait for.
static const uint64_t visit_limit = UINT64_C(1) << 28;

static stp_result push(selection* s, uint32_t node, const stp_affine* transform, bool moving_only)
{
    stp_draw_list* list = s->list;
    if (s->stack_count == list->stack_capacity) {
        stp_select_stack* stack = stp_grow_array(s->context, list->stack, &list->stack_capacity,
                                                 s->stack_count + 1, sizeof(*stack));
        if (stack == NULL) {
            return stp_fail_memory(s->context);
        }
        list->stack = stack;
    }
    list->stack[s->stack_count++] =
        (stp_select_stack){.node = node, .moving_only = moving_only, .transform = *transform};
    return STP_OK;
}

static stp_result add_item(selection* s, stp_draw_item item, uint64_t id_count)
{
    stp_draw_list* list = s->list;
    uint64_t first = list->splat_count + list->triangle_count;
    if (id_count == 0) {
        return STP_OK;
    }
    if (first + id_count >= UINT32_MAX) {
        return stp_fail(s->context, STP_ERROR_LIMIT,
                        "view: more than 4294967294 splats and triangles would have to be drawn");
    }
    if (list->count == list->capacity) {
        stp_draw_item* items = stp_grow_array(s->context, list->items, &list->capacity,
                                              list->count + 1, sizeof(*items));
        if (items == NULL) {
            return stp_fail_memory(s->context);
        }
        list->items = items;
    }
    item.first_id = (uint32_t)first;
    list->items[list->count++] = item;
    *(item.kind == STP_DRAW_MESH ? &list->triangle_count : &list->splat_count) += id_count;
    return STP_OK;
}

static stp_boxd widen_box(stp_box box)
{
    return (stp_boxd){stp_to_double(box.min), stp_to_double(box.max)};
}

/// The longest that a unit vector becomes.
static double largest_scale(const stp_affine* a)
{
    // the largest column is exact for rotations and uniform scales, and the norm bounds it in between
    double column = 0.0, sum = 0.0;
    for (int c = 0; c < 3; ++c) {
        double square = a->m[0][c] * a->m[0][c] + a->m[1][c] * a->m[1][c] + a->m[2][c] * a->m[2][c];
        column = square > column ? square : column;
        sum += square;
    }
    bool uniform = sum <= 3.0 * column * (1.0 + 1e-9) && sum >= 3.0 * column * (1.0 - 1e-9);
    return sqrt(uniform ? column : sum);
}

static stp_result add_part(selection* s, stp_store_part part, const stp_affine* transform)
{
    stp_draw_item item = {.index = part.index, .transform = *transform};
    uint64_t count;
    stp_boxd box;
    if (part.kind == STP_STORE_PART_MESH) {
        const stp_store_mesh* mesh = stp_store_describe_mesh(s->store, part.index);
        item.kind = STP_DRAW_MESH;
        count = mesh->triangle_count;
        box = widen_box(mesh->bounds);
    } else {
        const stp_store_point_set* points = stp_store_describe_point_set(s->store, part.index);
        item.kind = STP_DRAW_POINTS;
        item.prefix = points->point_count;
        count = points->point_count;
        box = widen_box(points->bounds);
    }
    double depth;
    box = stp_affine_box(transform, box);
    return stp_view_frame_sees(&s->frame, &box, &depth) ? add_item(s, item, count) : STP_OK;
}

/// The shortest prefix that is said to cover to `radius`, and how large its splats must be.
/// @return false where the whole order does not cover
static bool choose_prefix(const stp_quality* quality, const stp_surfels* surfels, double radius,
                          uint32_t* prefix, double* draw_radius)
{
    if (quality->policy == STP_POLICY_PAPER) { // p(r) = p_m (r_m / r)^2, Brandt 4.1
        double ratio = (double)surfels->paper_radius / radius;
        double wanted = ceil((double)surfels->paper_count * ratio * ratio);
        *prefix = wanted < 1.0                      ? 1
                  : wanted < (double)surfels->count ? (uint32_t)wanted
                                                    : surfels->count;
        *draw_radius = radius;
        return wanted <= (double)surfels->count;
    }
    float whole = stp_prefix_table_radius(&surfels->table, surfels->count);
    *prefix = stp_prefix_table_count(&surfels->table, (float)radius);
    *draw_radius = (double)stp_prefix_table_radius(&surfels->table, *prefix) +
                   (double)surfels->candidate_radius;
    return (double)whole <= radius;
}

/// Whether the surfels are all that is in a node: points have no size but theirs.
static bool is_cloud(const stp_store_node* node, const stp_surfels* surfels)
{
    return node->triangle_count == 0 && surfels->count >= node->point_count;
}

/// Draws a node as splats where that is good enough.
static stp_result try_surfels(selection* s, const stp_select_stack* at, double depth,
                              bool is_inside, bool* drawn)
{
    const stp_store_node* node = &s->directory->nodes[at->node];
    uint32_t index = node->surfels;
    const stp_surfels* surfels = stp_store_describe_surfels(s->store, index);
    *drawn = false;
    if (surfels->count == 0) {
        return STP_OK;
    }
    double scale = largest_scale(&at->transform), draw_radius;
    uint32_t prefix;
    uint64_t wanted = s->quality->splat_count, made = s->list->splat_count;
    if (wanted > 0 && made >= wanted) {
        return STP_OK; // what moves has a set of its own: together they are as many as was asked for
    }
    wanted -= wanted > 0 ? made : 0;
    if (wanted > 0 || (is_inside && is_cloud(node, surfels))) {
        prefix = wanted > 0 && wanted < surfels->count ? (uint32_t)wanted : surfels->count;
        draw_radius = (double)stp_prefix_table_radius(&surfels->table, prefix) +
                      (double)surfels->candidate_radius;
    } else {
        double pixel = stp_view_frame_pixel_size(&s->frame, depth);
        double radius = 0.5 * (double)s->list->splat_size * pixel / scale; // r = s d_p / 2
        if (is_inside || !(radius > 0.0) ||
            !choose_prefix(s->quality, surfels, radius, &prefix, &draw_radius)) {
            return STP_OK;
        }
    }
    *drawn = true;
    stp_draw_item item = {.kind = STP_DRAW_SURFELS,
                          .index = index,
                          .prefix = prefix,
                          .radius = (float)draw_radius,
                          .transform = at->transform};
    return add_item(s, item, prefix);
}

static stp_result open_node(selection* s, const stp_select_stack* at, bool moving_only)
{
    const stp_store_directory* directory = s->directory;
    const stp_store_node* node = &directory->nodes[at->node];
    stp_result result = STP_OK;
    for (uint32_t i = 0; i < node->part_count && !moving_only && result == STP_OK; ++i) {
        result = add_part(s, directory->parts[node->first_part + i], &at->transform);
    }
    for (uint32_t i = node->edge_count; i-- > 0 && result == STP_OK;) {
        const stp_store_edge* edge = &directory->edges[node->first_edge + i];
        if (moving_only && s->list->moving[edge->node] == 0) {
            continue;
        }
        stp_affine transform = stp_affine_multiply(at->transform, edge->transform);
        result = push(s, edge->node, &transform, moving_only);
    }
    return result;
}

static stp_result visit(selection* s, const stp_select_stack* at)
{
    const stp_store_node* node = &s->directory->nodes[at->node];
    uint8_t moving = s->list->moving[at->node];
    bool moving_only = at->moving_only && (moving & NODE_MOVES) == 0;
    if (++s->visits > visit_limit) {
        return stp_fail(s->context, STP_ERROR_LIMIT,
                        "view: the scene's graph unfolds to too many nodes");
    }
    s->list->node_count += 1;
    double depth;
    stp_boxd box = stp_affine_box(&at->transform, node->bounds);
    if (!stp_view_frame_sees(&s->frame, &box, &depth)) {
        return STP_OK;
    }
    bool drawn = false;
    bool offered = !s->quality->reference && !moving_only && node->surfels != STP_STORE_NONE;
    if (offered) {
        bool inside = stp_view_frame_is_inside(&s->frame, &box);
        stp_result result = try_surfels(s, at, depth, inside, &drawn);
        if (result != STP_OK) {
            return result;
        }
    }
    if (drawn && (moving & MOVES_BELOW) == 0) {
        return STP_OK;
    }
    return open_node(s, at, drawn || moving_only);
}

/// Marks what moves; children come before their parents.
static stp_result mark_moving(selection* s)
{
    const stp_store_directory* directory = s->directory;
    stp_draw_list* list = s->list;
    if (list->moving_capacity < directory->node_count) {
        uint8_t* moving = stp_grow_array(s->context, list->moving, &list->moving_capacity,
                                         directory->node_count, 1);
        if (moving == NULL) {
            return stp_fail_memory(s->context);
        }
        list->moving = moving;
    }
    for (uint32_t i = 0; i < directory->node_count; ++i) {
        const stp_store_node* node = &directory->nodes[i];
        uint8_t bits = (node->flags & 1u) != 0 ? NODE_MOVES : 0;
        for (uint32_t k = 0; k < node->edge_count; ++k) {
            uint32_t child = directory->edges[node->first_edge + k].node;
            bits = list->moving[child] != 0 ? bits | MOVES_BELOW : bits;
        }
        list->moving[i] = bits;
    }
    return STP_OK;
}

stp_result stp_select(stp_context* context, const stp_store* store, const stp_view* view,
                      const stp_quality* quality, stp_draw_list* list)
{
    selection s = {.context = context,
                   .store = store,
                   .directory = stp_store_get_directory(store),
                   .quality = quality,
                   .list = list};
    list->count = 0;
    list->splat_count = list->triangle_count = 0;
    list->node_count = 0;
    list->splat_size = quality->splat_size >= 1.0f ? quality->splat_size : 1.0f;
    if (!stp_view_frame_make(view, &s.frame)) {
        return stp_fail(context, STP_ERROR_ARGUMENT,
                        "view: eye, target, angle and size do not make a picture");
    }
    if (s.directory->root == STP_STORE_NONE) {
        return STP_OK;
    }
    stp_affine identity = stp_affine_identity();
    stp_result result = mark_moving(&s);
    result = result != STP_OK ? result : push(&s, s.directory->root, &identity, false);
    while (result == STP_OK && s.stack_count > 0) {
        stp_select_stack at = list->stack[--s.stack_count];
        result = visit(&s, &at);
    }
    return result;
}

void stp_draw_list_destroy(stp_context* context, stp_draw_list* list)
{
    stp_free(context, list->items);
    stp_free(context, list->stack);
    stp_free(context, list->moving);
    *list = (stp_draw_list){0};
}
