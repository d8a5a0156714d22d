// SPDX-License-Identifier: MIT
//
// Depth first, the child that reaches farthest first. A box is skipped if it reaches no farther than
// the farthest point so far, within the tolerance.
#include "select/farthest.h"

#include "select/box_clip.h"
#include "select/sections.h"

#include <assert.h>
#include <stdlib.h>

enum { STEPS = 1 << 14 }; ///< opened boxes; after these, the remaining boxes count as content
static const double tolerance = 1.0 / 2000.0;

/// A box that waits to be opened.
typedef struct waiting {
    double reach; ///< upper bound of its content
    uint32_t order;
    stp_farthest_item item;
} waiting;

typedef struct search {
    stp_context* context;
    const stp_farthest_graph* graph;
    const stp_sections* sections;
    stp_vec3d direction;
    double slack; ///< in units of the direction times scene units
    waiting* stack;
    size_t count, capacity;
    bool found;
    double farthest;
    stp_vec3d point;
} search;

/// A direction in the space of an item: its product with a point there is that in the scene, but for
/// a constant.
static stp_vec3d own_direction(const stp_affine* transform, stp_vec3d d)
{
    const double(*m)[4] = transform->m;
    return (stp_vec3d){m[0][0] * d.x + m[1][0] * d.y + m[2][0] * d.z,
                       m[0][1] * d.x + m[1][1] * d.y + m[2][1] * d.z,
                       m[0][2] * d.x + m[1][2] * d.y + m[2][2] * d.z};
}

/// The corner of an item's box that is farthest in the direction, in scene space.
static stp_vec3d farthest_corner(const search* s, const stp_farthest_item* item)
{
    stp_vec3d own = own_direction(&item->transform, s->direction);
    const stp_boxd* b = &item->bounds;
    stp_vec3d corner = {own.x > 0.0 ? b->max.x : b->min.x, own.y > 0.0 ? b->max.y : b->min.y,
                        own.z > 0.0 ? b->max.z : b->min.z};
    return stp_affine_point(&item->transform, corner);
}

static void add_point(search* s, stp_vec3d point)
{
    double reach = stp_dotd(s->direction, point);
    if (!s->found || reach > s->farthest) {
        s->found = true;
        s->farthest = reach;
        s->point = point;
    }
}

static bool matters(const search* s, double reach)
{
    return !s->found || reach > s->farthest + s->slack;
}

/// @return false if memory runs out
static bool push(search* s, const stp_farthest_item* item, uint32_t order)
{
    stp_boxd box = stp_affine_box(&item->transform, item->bounds);
    uint32_t mask = stp_sections_all(s->sections);
    double reach = stp_dotd(s->direction, farthest_corner(s, item));
    if (stp_boxd_is_empty(item->bounds) || !matters(s, reach) ||
        !stp_sections_test(s->sections, &box, 0.0, &mask)) {
        return true;
    }
    if (!STP_MAKE_ROOM(s->context, s->stack, s->capacity, s->count + 1)) {
        return false;
    }
    s->stack[s->count++] = (waiting){.reach = reach, .order = order, .item = *item};
    return true;
}

/// The farthest comes last; of equal ones, the first child.
static int compare_reaches(const void* a, const void* b)
{
    const waiting *x = a, *y = b;
    int reaches = (x->reach > y->reach) - (x->reach < y->reach);
    return reaches != 0 ? reaches : (x->order < y->order) - (x->order > y->order);
}

static bool open_node(search* s, const stp_farthest_item* node)
{
    size_t first = s->count;
    uint32_t children = s->graph->count(s->graph->user, node);
    bool good = true;
    for (uint32_t i = 0; i < children && good; ++i) {
        stp_farthest_item child;
        if (s->graph->get(s->graph->user, node, i, &child)) {
            good = push(s, &child, i);
        }
    }
    if (s->count > first + 1) {
        qsort(s->stack + first, s->count - first, sizeof(*s->stack), compare_reaches);
    }
    return good;
}

/// What the sections leave of the box of an item.
static void add_clipped(search* s, const stp_farthest_item* item)
{
    stp_sections own = *s->sections;
    const stp_affine* t = &item->transform;
    stp_vec3d shift = {t->m[0][3], t->m[1][3], t->m[2][3]};
    for (uint32_t i = 0; i < own.count; ++i) {
        stp_vec3d normal = own.planes[i].normal;
        own.planes[i].normal = own_direction(t, normal);
        own.planes[i].distance -= stp_dotd(normal, shift);
    }
    stp_vec3d corners[STP_BOX_CLIP_CORNERS];
    uint32_t count = stp_box_clip(&item->bounds, &own, corners);
    stp_vec3d center = stp_scaled(stp_addd(item->bounds.min, item->bounds.max), 0.5);
    for (uint32_t i = 0; i < count; ++i) {
        add_point(s, stp_affine_point(t, stp_addd(center, corners[i])));
    }
}

static void open_part(search* s, const stp_farthest_item* part)
{
    stp_boxd box = stp_affine_box(&part->transform, part->bounds);
    uint32_t mask = stp_sections_all(s->sections);
    stp_vec3d own = own_direction(&part->transform, s->direction), point;
    if (stp_sections_test(s->sections, &box, 0.0, &mask) && mask != 0) {
        add_clipped(s, part);
    } else if (s->graph->measure(s->graph->user, part, own, &point)) {
        add_point(s, stp_affine_point(&part->transform, point));
    } else {
        add_point(s, farthest_corner(s, part));
    }
}

/// @return false if memory runs out
static bool run(search* s)
{
    bool good = push(s, &s->graph->root, 0);
    for (int step = 0; good && s->count > 0; ++step) {
        waiting next = s->stack[--s->count];
        if (!matters(s, next.reach)) {
            continue;
        }
        if (step >= STEPS) {
            add_point(s, farthest_corner(s, &next.item));
        } else if (next.item.is_part) {
            open_part(s, &next.item);
        } else {
            good = open_node(s, &next.item);
        }
    }
    return good;
}

bool stp_farthest_find(stp_context* context, const stp_farthest_graph* graph,
                       const stp_sections* sections, const stp_vec3d* directions, uint32_t count,
                       stp_vec3d* points)
{
    search s = {.context = context, .graph = graph, .sections = sections};
    stp_boxd box = stp_affine_box(&graph->root.transform, graph->root.bounds);
    double size = stp_lengthd(stp_subd(box.max, box.min));
    bool good = true;
    assert(!graph->root.is_part && sections->count <= STP_SECTION_PLANES);
    for (uint32_t i = 0; i < count && good; ++i) {
        s.direction = directions[i];
        s.slack = tolerance * size * stp_lengthd(directions[i]);
        s.found = false;
        s.count = 0;
        good = run(&s) && s.found;
        points[i] = s.point;
    }
    stp_free(context, s.stack);
    return good;
}

void stp_farthest_vertex(const float* positions, size_t count, stp_vec3d direction,
                         double* farthest, stp_vec3d* point)
{
    for (size_t i = 0; i < count; ++i) {
        const float* p = positions + 3 * i;
        stp_vec3d place = {(double)p[0], (double)p[1], (double)p[2]};
        double reach = stp_dotd(direction, place);
        if (reach > *farthest) {
            *farthest = reach;
            *point = place;
        }
    }
}
