// SPDX-License-Identifier: MIT
#include "lod/psp/forest.h"

#include "base/arena.h"
#include "base/color.h"
#include "lod/psp/initial.h"
#include "lod/psp/nearest_points.h"
#include "lod/psp/queue.h"
#include "lod/psp/region.h"

#include <string.h>

#define LINE 1e-4 ///< how little points spread across a line, of what they spread along it
#define UPRIGHT                                                                                    \
    0.7f ///< cosine to the mean normal of two splats, below which that of the points is not believed

enum { ARENA_BLOCK = 1 << 20, POINTS_MOST = 1 << 30 };

/// A splat that is beside another, and the merge of both.
typedef struct link {
    uint32_t splat, edge; ///< edge UINT32_MAX: they are not merged
} link;

/// What is kept of a splat while it may be merged.
typedef struct splat_state {
    link* links;
    uint32_t link_count;
    bool alive;
    float color[3]; ///< linear
} splat_state;

/// Of distances: the points that a splat stands for, and their moments about the middle of all.
typedef struct moments {
    double count, sum[3], squares[6]; ///< xx, xy, xz, yy, yz, zz
    uint32_t first, last;             ///< of a list
} moments;

typedef struct maker {
    stp_context* context;
    const stp_psp_points* points;
    stp_psp_desc desc;
    stp_psp_forest* forest;
    splat_state* splats;
    moments* moments;        ///< NULL: not of distances
    stp_psp_region* regions; ///< NULL: not of regions
    uint32_t* next;          ///< of a point, in the list of its splat; UINT32_MAX ends it
    stp_vec3* gathered;
    stp_arena arena;
    stp_psp_queue queue;
    stp_vec3 middle;
    float least; ///< of axes
} maker;

stp_psp_desc stp_psp_desc_default(void)
{
    return (stp_psp_desc){.metric = STP_PSP_NORMALS, .neighbours = 8, .eager = true};
}

static stp_vec3 vector_at(const float* values, size_t index)
{
    return (stp_vec3){values[3 * index], values[3 * index + 1], values[3 * index + 2]};
}

static moments add_moments(const moments* a, const moments* b)
{
    moments m = {.count = a->count + b->count, .first = a->first, .last = b->last};
    for (int i = 0; i < 3; ++i) {
        m.sum[i] = a->sum[i] + b->sum[i];
    }
    for (int i = 0; i < 6; ++i) {
        m.squares[i] = a->squares[i] + b->squares[i];
    }
    return m;
}

/// The plane nearest to the points of a splat. Its normal is zero where they lie along a line.
/// @return the sum of the squares of their distances from it
static double find_plane(const moments* m, stp_vec3d* normal)
{
    double scatter[6], sums[3];
    for (int a = 0, at = 0; a < 3; ++a) {
        for (int b = a; b < 3; ++b, ++at) {
            scatter[at] = m->squares[at] - m->sum[a] * m->sum[b] / m->count;
        }
    }
    *normal = stp_least_direction(scatter, sums);
    if (!(sums[1] > LINE * sums[2])) {
        *normal = (stp_vec3d){0};
    }
    return sums[0] > 0.0 ? sums[0] : 0.0;
}

static stp_ellipse find_region_ellipse(const maker* m, const stp_psp_region* region,
                                       stp_vec3 fallback)
{
    stp_ellipse e = stp_psp_region_ellipse(region, fallback);
    e.center = stp_add(e.center, m->middle);
    return e;
}

/// The error of a merge, before it is weighted by the distance of the two splats.
static double measure(const maker* m, uint32_t left, uint32_t right)
{
    if (m->regions != NULL) {
        stp_psp_region both = stp_psp_region_add(&m->regions[left], &m->regions[right]);
        stp_ellipse e = stp_psp_region_ellipse(&both, m->forest->ellipses[left].normal);
        return stp_psp_region_error(&both, &e);
    }
    if (m->moments != NULL) {
        stp_vec3d normal;
        moments both = add_moments(&m->moments[left], &m->moments[right]);
        return find_plane(&both, &normal);
    }
    stp_vec3 d = stp_sub(m->forest->ellipses[left].normal, m->forest->ellipses[right].normal);
    return (double)m->forest->areas[left] * (double)m->forest->areas[right] * (double)stp_dot(d, d);
}

/// Queues the merge of two splats, if it is allowed.
static stp_result add_edge(maker* m, uint32_t left, uint32_t right, uint32_t* number)
{
    const stp_ellipse *l = &m->forest->ellipses[left], *r = &m->forest->ellipses[right];
    *number = UINT32_MAX;
    if (!(stp_dot(l->normal, r->normal) >= m->desc.least_cosine)) {
        return STP_OK;
    }
    double length = (double)stp_length(stp_sub(r->center, l->center));
    double areas = (double)m->forest->areas[left] * (double)m->forest->areas[right];
    double weight = m->regions != NULL ? 1.0 : length;
    return stp_psp_queue_add(&m->queue,
                             (stp_psp_edge){.error = weight * measure(m, left, right),
                                            .weight = length * areas,
                                            .left = left,
                                            .right = right},
                             number);
}

static bool is_linked(const splat_state* s, uint32_t to)
{
    for (uint32_t i = 0; i < s->link_count; ++i) {
        if (s->links[i].splat == to) {
            return true;
        }
    }
    return false;
}

/// Links splats that are neighbours, in either direction.
/// @param splats their numbers
/// @param neighbours k places in `splats` for each of them; UINT32_MAX ends them
static stp_result link_splats(maker* m, const uint32_t* splats, uint32_t count,
                              const uint32_t* neighbours)
{
    uint32_t k = m->desc.neighbours;
    uint32_t* degrees = STP_NEW_ZEROED(m->context, uint32_t, (size_t)count + 1);
    if (degrees == NULL) {
        return stp_fail_memory(m->context);
    }
    for (uint32_t i = 0; i < count; ++i) {
        for (uint32_t n = 0; n < k && neighbours[(size_t)k * i + n] != UINT32_MAX; ++n) {
            degrees[i] += 1;
            degrees[neighbours[(size_t)k * i + n]] += 1;
        }
    }
    bool made = true;
    for (uint32_t i = 0; i < count && made; ++i) {
        splat_state* s = &m->splats[splats[i]];
        s->links = STP_ARENA_ARRAY(&m->arena, link, (size_t)degrees[i] + 1);
        s->link_count = 0;
        made = s->links != NULL;
    }
    stp_free(m->context, degrees);
    stp_result result = made ? STP_OK : stp_fail_memory(m->context);
    for (uint32_t i = 0; i < count && result == STP_OK; ++i) {
        for (uint32_t n = 0; n < k && result == STP_OK; ++n) {
            uint32_t at = neighbours[(size_t)k * i + n], edge;
            if (at == UINT32_MAX || is_linked(&m->splats[splats[i]], splats[at])) {
                continue;
            }
            uint32_t a = splats[i < at ? i : at], b = splats[i < at ? at : i];
            result = add_edge(m, a, b, &edge);
            m->splats[a].links[m->splats[a].link_count++] = (link){b, edge};
            m->splats[b].links[m->splats[b].link_count++] = (link){a, edge};
        }
    }
    return result;
}

/// Points the links that neighbours have to two splats at the one that they became.
static void relink(maker* m, uint32_t neighbour, uint32_t left, uint32_t right, link to)
{
    splat_state* s = &m->splats[neighbour];
    uint32_t kept = 0;
    bool done = false;
    for (uint32_t i = 0; i < s->link_count; ++i) {
        bool old = s->links[i].splat == left || s->links[i].splat == right;
        if (old && done) {
            continue;
        }
        s->links[kept++] = old ? to : s->links[i];
        done = done || old;
    }
    s->link_count = kept;
}

/// Links a new splat with all that were beside the two it is made of.
static stp_result link_merged(maker* m, uint32_t left, uint32_t right, uint32_t merged)
{
    splat_state* s = &m->splats[merged];
    const uint32_t parts[2] = {left, right};
    size_t most = (size_t)m->splats[left].link_count + m->splats[right].link_count;
    s->links = STP_ARENA_ARRAY(&m->arena, link, most + 1);
    if (s->links == NULL) {
        return stp_fail_memory(m->context);
    }
    stp_result result = STP_OK;
    for (int p = 0; p < 2; ++p) {
        const splat_state* from = &m->splats[parts[p]];
        for (uint32_t i = 0; i < from->link_count && result == STP_OK; ++i) {
            link old = from->links[i];
            if (m->desc.eager && old.edge != UINT32_MAX) {
                stp_psp_queue_remove(&m->queue, old.edge);
            }
            if (old.splat == left || old.splat == right || is_linked(s, old.splat)) {
                continue;
            }
            uint32_t edge;
            result = add_edge(m, old.splat, merged, &edge);
            s->links[s->link_count++] = (link){old.splat, edge};
            relink(m, old.splat, left, right, (link){merged, edge});
        }
    }
    return result;
}

/// The splat that stands for two, by areas and samples of their boundaries (4.2).
static stp_ellipse merge_by_area(const maker* m, uint32_t left, uint32_t right)
{
    const stp_ellipse *l = &m->forest->ellipses[left], *r = &m->forest->ellipses[right];
    float share = m->forest->areas[left] / (m->forest->areas[left] + m->forest->areas[right]);
    stp_vec3 center = stp_add(stp_scale(l->center, share), stp_scale(r->center, 1.0f - share));
    stp_vec3 normal = stp_add(stp_scale(l->normal, share), stp_scale(r->normal, 1.0f - share));
    stp_vec3 samples[2 * STP_ELLIPSE_SAMPLES];
    float length = stp_length(normal);
    normal = length > 0.0f ? stp_scale(normal, 1.0f / length) : l->normal;
    stp_ellipse_sample(l, samples);
    stp_ellipse_sample(r, samples + STP_ELLIPSE_SAMPLES);
    return stp_ellipse_cover(center, normal, samples, 2 * STP_ELLIPSE_SAMPLES, m->least);
}

/// The same by the points of both (4.1).
static stp_ellipse merge_by_points(maker* m, uint32_t left, uint32_t right, uint32_t merged)
{
    stp_vec3d found;
    m->next[m->moments[left].last] = m->moments[right].first;
    m->moments[merged] = add_moments(&m->moments[left], &m->moments[right]);
    const moments* both = &m->moments[merged];
    (void)find_plane(both, &found);
    stp_vec3 normal = {(float)found.x, (float)found.y, (float)found.z};
    const stp_ellipse *l = &m->forest->ellipses[left], *r = &m->forest->ellipses[right];
    stp_vec3 side = stp_add(stp_scale(l->normal, m->forest->areas[left]),
                            stp_scale(r->normal, m->forest->areas[right]));
    // of few points, or along a line, the plane may stand across the surface: then as the two face
    if (!(fabsf(stp_dot(normal, side)) > UPRIGHT * stp_length(side))) {
        normal = stp_dot(side, side) > 0.0f ? side : l->normal;
    }
    normal = stp_normalize(stp_dot(normal, side) < 0.0f ? stp_scale(normal, -1.0f) : normal);
    stp_vec3 mean = {(float)(both->sum[0] / both->count), (float)(both->sum[1] / both->count),
                     (float)(both->sum[2] / both->count)};
    size_t count = 0;
    for (uint32_t p = both->first; p != UINT32_MAX; p = m->next[p]) {
        m->gathered[count++] = vector_at(m->points->positions, p);
    }
    return stp_ellipse_cover(stp_add(m->middle, mean), normal, m->gathered, count, m->least);
}

static void mix_colors(maker* m, uint32_t left, uint32_t right, uint32_t merged)
{
    const splat_state *l = &m->splats[left], *r = &m->splats[right];
    const float* areas = m->forest->areas;
    float share = areas[left] / (areas[left] + areas[right]);
    for (int k = 0; k < 3; ++k) {
        float mixed = share * l->color[k] + (1.0f - share) * r->color[k];
        m->splats[merged].color[k] = mixed;
        m->forest->colors[3 * (size_t)merged + (size_t)k] = stp_linear_to_srgb8(mixed);
    }
}

static stp_result merge(maker* m, const stp_psp_edge* edge)
{
    stp_psp_forest* f = m->forest;
    uint32_t left = edge->left, right = edge->right, merged = f->point_count + f->merge_count;
    if (m->regions != NULL) {
        m->regions[merged] = stp_psp_region_add(&m->regions[left], &m->regions[right]);
        f->ellipses[merged] = find_region_ellipse(m, &m->regions[merged], f->ellipses[left].normal);
        f->areas[merged] = (float)m->regions[merged].area;
    } else {
        f->ellipses[merged] = m->moments != NULL ? merge_by_points(m, left, right, merged)
                                                 : merge_by_area(m, left, right);
        f->areas[merged] = stp_ellipse_area(&f->ellipses[merged]);
    }
    f->parents[left] = f->parents[right] = f->merge_count;
    f->merges[f->merge_count++] = (stp_psp_merge){left, right, edge->error};
    m->splats[left].alive = m->splats[right].alive = false;
    m->splats[merged].alive = true;
    mix_colors(m, left, right, merged);
    return link_merged(m, left, right, merged);
}

/// Links the splats that are left by their nearest centres. @param left how many there are
static stp_result join_all(maker* m, uint32_t left)
{
    const stp_psp_forest* f = m->forest;
    uint32_t k = m->desc.neighbours, count = 0;
    uint32_t* splats = STP_NEW_ARRAY(m->context, uint32_t, (size_t)left + 1);
    float* centers = STP_NEW_ARRAY(m->context, float, 3 * (size_t)left + 1);
    uint32_t* neighbours = STP_NEW_ARRAY(m->context, uint32_t, (size_t)left * k + 1);
    stp_result result = STP_OK;
    if (splats == NULL || centers == NULL || neighbours == NULL) {
        result = stp_fail_memory(m->context);
    }
    for (uint32_t i = 0; i < f->point_count + f->merge_count && result == STP_OK; ++i) {
        if (m->splats[i].alive) {
            memcpy(centers + 3 * (size_t)count, &f->ellipses[i].center, sizeof(stp_vec3));
            splats[count++] = i;
        }
    }
    if (result == STP_OK) {
        result = stp_find_nearest_points(m->context, centers, count, k, neighbours);
    }
    if (result == STP_OK) {
        m->desc.least_cosine = -2.0f;
        result = link_splats(m, splats, count, neighbours);
    }
    stp_free(m->context, splats);
    stp_free(m->context, centers);
    stp_free(m->context, neighbours);
    return result;
}

static stp_result merge_all(maker* m, uint32_t target)
{
    stp_result result = STP_OK;
    uint32_t left = m->points->count;
    while (left > target && result == STP_OK) {
        uint32_t number = stp_psp_queue_take(&m->queue);
        if (number == UINT32_MAX && m->desc.joins_all && left > 1) {
            result = join_all(m, left);
            continue;
        }
        if (number == UINT32_MAX) {
            break;
        }
        stp_psp_edge edge = m->queue.edges[number];
        if (m->splats[edge.left].alive && m->splats[edge.right].alive) {
            result = merge(m, &edge);
            left -= 1;
        }
    }
    return result;
}

static void begin_moments(const maker* m, uint32_t point)
{
    stp_vec3 d = stp_sub(vector_at(m->points->positions, point), m->middle);
    const double at[3] = {(double)d.x, (double)d.y, (double)d.z};
    moments* own = &m->moments[point];
    *own = (moments){.count = 1.0, .first = point, .last = point};
    for (int a = 0, place = 0; a < 3; ++a) {
        own->sum[a] = at[a];
        for (int b = a; b < 3; ++b) {
            own->squares[place++] = at[a] * at[b];
        }
    }
    m->next[point] = UINT32_MAX;
}

static void begin_region(const maker* m, uint32_t point)
{
    const stp_psp_points* p = m->points;
    stp_psp_forest* f = m->forest;
    stp_psp_sample sample = {.position = stp_sub(vector_at(p->positions, point), m->middle),
                             .normal = f->ellipses[point].normal,
                             .area = p->areas[point]};
    if (p->normals != NULL) {
        stp_vec3 given = vector_at(p->normals, point);
        sample.normal = stp_dot(given, given) > 0.0f ? given : sample.normal;
    }
    memcpy(sample.color, f->colors + 3 * (size_t)point, 3);
    m->regions[point] = stp_psp_region_of(&sample);
    f->ellipses[point] = find_region_ellipse(m, &m->regions[point], sample.normal);
    f->areas[point] = sample.area;
}

static void begin_splats(const maker* m)
{
    const stp_psp_points* p = m->points;
    stp_psp_forest* f = m->forest;
    for (uint32_t i = 0; i < p->count; ++i) {
        splat_state* s = &m->splats[i];
        s->alive = true;
        f->areas[i] = stp_ellipse_area(&f->ellipses[i]);
        for (size_t k = 0; k < 3; ++k) {
            uint8_t color = p->colors != NULL ? p->colors[3 * (size_t)i + k] : 255;
            s->color[k] = stp_srgb8_to_linear(color);
            f->colors[3 * (size_t)i + k] = color;
        }
        if (m->moments != NULL) {
            begin_moments(m, i);
        } else if (m->regions != NULL) {
            begin_region(m, i);
        }
    }
}

static bool make_room(maker* m)
{
    stp_context* context = m->context;
    stp_psp_forest* f = m->forest;
    size_t count = m->points->count;
    f->ellipses = STP_NEW_ARRAY(context, stp_ellipse, 2 * count + 1);
    f->colors = STP_NEW_ARRAY(context, uint8_t, 6 * count + 1);
    f->merges = STP_NEW_ARRAY(context, stp_psp_merge, count + 1);
    f->parents = STP_NEW_ARRAY(context, uint32_t, 2 * count + 1);
    f->areas = STP_NEW_ARRAY(context, float, 2 * count + 1);
    m->splats = STP_NEW_ZEROED(context, splat_state, 2 * count + 1);
    bool made = f->ellipses != NULL && f->colors != NULL && f->merges != NULL &&
                f->parents != NULL && f->areas != NULL && m->splats != NULL;
    for (size_t i = 0; made && i < 2 * count + 1; ++i) {
        f->parents[i] = UINT32_MAX;
    }
    if (made && m->desc.metric == STP_PSP_DISTANCES) {
        m->moments = STP_NEW_ARRAY(context, moments, 2 * count + 1);
        m->next = STP_NEW_ARRAY(context, uint32_t, count + 1);
        m->gathered = STP_NEW_ARRAY(context, stp_vec3, count + 1);
        made = m->moments != NULL && m->next != NULL && m->gathered != NULL;
    }
    if (made && m->desc.metric == STP_PSP_REGIONS) {
        m->regions = STP_NEW_ARRAY(context, stp_psp_region, 2 * count + 1);
        made = m->regions != NULL;
    }
    return made;
}

/// Links the splats of points.
static stp_result link_points(maker* m, const uint32_t* neighbours)
{
    uint32_t count = m->points->count;
    uint32_t* splats = STP_NEW_ARRAY(m->context, uint32_t, (size_t)count + 1);
    stp_result result = STP_OK;
    if (splats == NULL) {
        return stp_fail_memory(m->context);
    }
    for (uint32_t i = 0; i < count; ++i) {
        splats[i] = i;
    }
    result = link_splats(m, splats, count, neighbours);
    stp_free(m->context, splats);
    return result;
}

static stp_result make(maker* m, uint32_t target)
{
    const stp_psp_points* p = m->points;
    size_t links = (size_t)p->count * m->desc.neighbours;
    uint32_t* neighbours = STP_NEW_ARRAY(m->context, uint32_t, links + 1);
    stp_result result = neighbours != NULL && make_room(m) ? STP_OK : stp_fail_memory(m->context);
    if (result == STP_OK) {
        result = stp_psp_make_initial(m->context, p, m->desc.neighbours, m->forest->ellipses,
                                      neighbours);
    }
    if (result == STP_OK) {
        stp_box box = stp_box_empty();
        for (uint32_t i = 0; i < p->count; ++i) {
            stp_box_add(&box, vector_at(p->positions, i));
        }
        stp_vec3 size = p->count > 0 ? stp_sub(box.max, box.min) : (stp_vec3){0};
        m->middle = p->count > 0 ? stp_add(box.min, stp_scale(size, 0.5f)) : size;
        m->least = fmaxf(1e-9f * stp_length(size), FLT_MIN);
        m->forest->point_count = p->count;
        begin_splats(m);
        result = link_points(m, neighbours);
    }
    stp_free(m->context, neighbours);
    return result == STP_OK ? merge_all(m, target) : result;
}

stp_result stp_psp_forest_make(stp_context* context, const stp_psp_points* points,
                               const stp_psp_desc* desc, uint32_t target, stp_psp_forest* forest)
{
    *forest = (stp_psp_forest){0};
    if (points->count > POINTS_MOST) {
        return stp_fail(context, STP_ERROR_LIMIT, "progressive splats: %u points, at most %d",
                        points->count, POINTS_MOST);
    }
    maker m = {.context = context,
               .points = points,
               .desc = *desc,
               .forest = forest,
               .arena = stp_arena_create(context, ARENA_BLOCK),
               .queue = {.context = context}};
    stp_result result = make(&m, target);
    stp_psp_queue_destroy(&m.queue);
    stp_arena_destroy(&m.arena);
    stp_free(context, m.splats);
    stp_free(context, m.moments);
    stp_free(context, m.next);
    stp_free(context, m.regions);
    stp_free(context, m.gathered);
    if (result != STP_OK) {
        stp_psp_forest_destroy(context, forest);
    }
    return result;
}

void stp_psp_forest_destroy(stp_context* context, stp_psp_forest* forest)
{
    stp_free(context, forest->ellipses);
    stp_free(context, forest->colors);
    stp_free(context, forest->merges);
    stp_free(context, forest->parents);
    stp_free(context, forest->areas);
    *forest = (stp_psp_forest){0};
}

uint32_t stp_psp_forest_cut(const stp_psp_forest* forest, uint32_t count, uint32_t* splats)
{
    uint32_t points = forest->point_count, merges = forest->merge_count, found = 0;
    uint32_t done = count < points ? points - count : 0;
    done = done < merges ? done : merges;
    for (uint32_t i = 0; i < points + done; ++i) {
        if (forest->parents[i] >= done) {
            splats[found++] = i;
        }
    }
    return found;
}
