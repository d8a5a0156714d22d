// SPDX-License-Identifier: MIT
#include "lod/levels/collapse.h"

#include "lod/levels/collapse_queue.h"
#include "lod/levels/mesh_edges.h"
#include "lod/levels/plane_quadric.h"

#include <assert.h>
#include <float.h>
#include <string.h>

#define NONE UINT32_MAX

enum { NOTE_BITS = 10, NOTES = 1 << NOTE_BITS, NOTE_SHIFT = 32 - NOTE_BITS };

#define FARTHEST 2.0     // a place farther from the middle of an edge, in its lengths, is not used
#define LOST_WEIGHT 0.25 // of the square of lost area, relative to the area around
#define CREASE 0.5 // cosine: edges at which surfaces turn more than that are kept like borders
#define TINY 1e-24 // squares of areas below this are zero

/// An edge that was offered again, and the stamps of its ends.
typedef struct offer_note {
    uint32_t a, b, stamp;
} offer_note;

typedef struct collapser {
    stp_context* context;
    stp_collapse_mesh* mesh;
    const stp_collapse_desc* desc;
    stp_vec3d origin; ///< positions are relative to it
    stp_vec3d* places;
    stp_plane_quadric* quadrics;
    // the corners around each vertex, as lists; those of triangles that are gone are skipped
    uint32_t *first, *last, *next;
    uint32_t* degrees; ///< triangles around each vertex
    uint32_t* stamps;  ///< collapses into each vertex
    uint32_t* corners; ///< 3 per triangle
    uint8_t* gone;     ///< per triangle
    uint32_t* merged;  ///< per vertex: the one into which it was collapsed, or itself
    offer_note* notes; ///< of edges that were offered again
    stp_collapse_queue queue;
    uint32_t triangles, vertices; ///< left
    double worst;
    float too_dear; ///< no edge of a higher cost is collapsed
} collapser;

static bool is_locked(const collapser* c, uint32_t vertex)
{
    return c->mesh->locked != NULL && c->mesh->locked[vertex] != 0;
}

static stp_vec3d cross_of(const stp_vec3d p[3])
{
    return stp_crossd(stp_subd(p[1], p[0]), stp_subd(p[2], p[0]));
}

static void get_places(const collapser* c, uint32_t triangle, stp_vec3d p[3])
{
    for (int k = 0; k < 3; ++k) {
        p[k] = c->places[c->corners[3 * (size_t)triangle + (size_t)k]];
    }
}

/// The place of the vertex that remains of edge a, b, of which `a` is not locked, and its error.
static double choose_place(const collapser* c, uint32_t a, uint32_t b, stp_vec3d* place)
{
    stp_plane_quadric sum = stp_plane_quadric_sum(&c->quadrics[a], &c->quadrics[b]);
    stp_vec3d pa = c->places[a], pb = c->places[b], best;
    double error = stp_plane_quadric_at(&sum, pb);
    *place = pb;
    assert(!is_locked(c, a));
    if (is_locked(c, b)) {
        return stp_plane_quadric_mean(&sum, error);
    }
    double other = stp_plane_quadric_at(&sum, pa);
    if (other < error) {
        error = other;
        *place = pa;
    }
    stp_vec3d middle = stp_scaled(stp_addd(pa, pb), 0.5), edge = stp_subd(pb, pa);
    if (stp_plane_quadric_minimum(&sum, middle, &best)) {
        stp_vec3d away = stp_subd(best, middle);
        double found = stp_plane_quadric_at(&sum, best);
        if (found < error && stp_dotd(away, away) < FARTHEST * FARTHEST * stp_dotd(edge, edge)) {
            error = found;
            *place = best;
        }
    }
    return stp_plane_quadric_mean(&sum, error);
}

/// Puts an edge into the queue, unless both ends are locked. @return false if memory runs out
static bool offer(collapser* c, uint32_t a, uint32_t b)
{
    stp_vec3d place;
    bool swap = is_locked(c, a) || (!is_locked(c, b) && b < a);
    uint32_t from = swap ? b : a, to = swap ? a : b;
    if (is_locked(c, from)) {
        return true;
    }
    float cost = (float)choose_place(c, from, to, &place);
    uint32_t stamp = c->stamps[from] + c->stamps[to];
    const stp_collapse_candidate item = {from, to, stamp};
    return !(cost <= c->too_dear) ? stp_collapse_queue_wait(&c->queue, item)
                                  : stp_collapse_queue_add(&c->queue, item, cost);
}

/// Adds the planes of all triangles to their corners' quadrics.
static void add_triangles(collapser* c)
{
    for (uint32_t t = 0; t < c->mesh->triangle_count; ++t) {
        stp_vec3d p[3], normal;
        get_places(c, t, p);
        normal = cross_of(p);
        double twice = sqrt(stp_dotd(normal, normal));
        if (twice > 0.0) {
            normal = stp_scaled(normal, 1.0 / twice);
            for (size_t k = 0; k < 3; ++k) {
                stp_plane_quadric_add(&c->quadrics[c->corners[3 * (size_t)t + k]], normal,
                                      -stp_dotd(normal, p[0]), 0.5 * twice, 0.5 * twice);
            }
        }
    }
}

/// Adds a plane through an edge of a border, perpendicular to its triangle. It counts in the sum
/// alone, so that borders are kept more strictly than their error says.
static void add_border(collapser* c, uint32_t corner)
{
    size_t triangle = corner / 3, k = corner % 3;
    uint32_t a = c->corners[corner], b = c->corners[3 * triangle + (k + 1) % 3];
    stp_vec3d p[3];
    get_places(c, (uint32_t)triangle, p);
    stp_vec3d edge = stp_subd(c->places[b], c->places[a]);
    stp_vec3d cross = cross_of(p), side = stp_crossd(edge, cross);
    double length = sqrt(stp_dotd(side, side));
    if (length > 0.0) {
        side = stp_scaled(side, 1.0 / length);
        double offset = -stp_dotd(side, c->places[a]);
        // a finely divided border around long triangles counts as much as they do
        double size = stp_maxd(stp_dotd(edge, edge), sqrt(stp_dotd(cross, cross)));
        double weight = c->desc->border_weight * size;
        stp_plane_quadric_add(&c->quadrics[a], side, offset, weight, 0.0);
        stp_plane_quadric_add(&c->quadrics[b], side, offset, weight, 0.0);
    }
}

/// Whether the triangles at an edge, which begins at these corners, end there, turn sharply, change
/// material, or are more than two.
static bool is_border(const collapser* c, const uint32_t* corners, uint32_t count)
{
    const uint32_t* materials = c->mesh->materials;
    stp_vec3d p[3], q[3];
    if (count != 2 ||
        (materials != NULL && materials[corners[0] / 3] != materials[corners[1] / 3])) {
        return true;
    }
    get_places(c, corners[0] / 3, p);
    get_places(c, corners[1] / 3, q);
    stp_vec3d a = cross_of(p), b = cross_of(q);
    return stp_dotd(a, b) < CREASE * sqrt(stp_dotd(a, a)) * sqrt(stp_dotd(b, b));
}

/// Adds the borders, then offers every edge once. @return false if memory runs out
static bool offer_edges(collapser* c)
{
    uint32_t ends[2];
    stp_mesh_edges edges;
    bool good = stp_mesh_edges_make(c->context, c->corners, c->mesh->triangle_count,
                                    c->mesh->vertex_count, &edges);
    bool holds_borders = good && c->desc->border_weight > 0.0;
    for (uint32_t e = 0, i = 0; e < edges.count && holds_borders; ++e) {
        bool border = is_border(c, edges.corners + i, edges.ends[e] - i);
        for (; i < edges.ends[e]; ++i) {
            if (border) {
                add_border(c, edges.corners[i]);
            }
        }
    }
    good = good && stp_collapse_queue_reserve(&c->queue, 2 * (size_t)edges.count);
    for (uint32_t e = 0; e < edges.count && good; ++e) {
        stp_edge_ends(c->corners, edges.corners[edges.ends[e] - 1], ends);
        good = offer(c, ends[0], ends[1]);
    }
    stp_mesh_edges_destroy(c->context, &edges);
    return good;
}

/// Links the corners of each vertex, and counts triangles and used vertices.
static void link_corners(collapser* c)
{
    const stp_collapse_mesh* m = c->mesh;
    memset(c->first, 0xff, m->vertex_count * sizeof(*c->first));
    for (uint32_t i = 0; i < 3 * m->triangle_count; ++i) {
        uint32_t v = m->indices[i];
        assert(v < m->vertex_count);
        c->corners[i] = v;
        c->next[i] = NONE;
        if (c->first[v] == NONE) {
            c->first[v] = i;
            c->vertices += 1;
        } else {
            c->next[c->last[v]] = i;
        }
        c->last[v] = i;
        c->degrees[v] += 1;
    }
    c->triangles = m->triangle_count;
}

/// Positions relative to the first vertex.
static void place_vertices(collapser* c)
{
    const float* p = c->mesh->positions;
    c->origin = (stp_vec3d){(double)p[0], (double)p[1], (double)p[2]};
    for (size_t i = 0; i < c->mesh->vertex_count; ++i) {
        c->places[i] = stp_subd(
            (stp_vec3d){(double)p[3 * i], (double)p[3 * i + 1], (double)p[3 * i + 2]}, c->origin);
    }
}

static bool has_corner(const collapser* c, uint32_t triangle, uint32_t vertex)
{
    const uint32_t* t = c->corners + 3 * (size_t)triangle;
    return t[0] == vertex || t[1] == vertex || t[2] == vertex;
}

/// Drops the corners of triangles that are gone from the list of a vertex.
static void clean_list(collapser* c, uint32_t vertex)
{
    uint32_t last = NONE;
    for (uint32_t i = c->first[vertex]; i != NONE; i = c->next[i]) {
        if (c->gone[i / 3] != 0) {
            continue;
        }
        if (last == NONE) {
            c->first[vertex] = i;
        } else {
            c->next[last] = i;
        }
        last = i;
    }
    if (last == NONE) {
        c->first[vertex] = NONE;
    } else {
        c->next[last] = NONE;
    }
    c->last[vertex] = last;
}

/// Whether triangles around `vertex` without `other` keep their direction if it moves. `lost`:
/// grows by the area that they lose, and by that of triangles with both.
static bool keeps_directions(const collapser* c, uint32_t vertex, uint32_t other, stp_vec3d place,
                             bool counts_common, double* lost)
{
    for (uint32_t i = c->first[vertex]; i != NONE; i = c->next[i]) {
        stp_vec3d p[3];
        bool common = has_corner(c, i / 3, other);
        if (c->gone[i / 3] != 0 || (common && !counts_common)) {
            continue;
        }
        get_places(c, i / 3, p);
        stp_vec3d before = cross_of(p);
        double was = stp_dotd(before, before);
        *lost += 0.5 * sqrt(was);
        if (common) {
            continue;
        }
        p[i % 3] = place;
        stp_vec3d after = cross_of(p);
        double is = stp_dotd(after, after);
        *lost -= 0.5 * sqrt(is);
        if (!(is > TINY * was) ||
            stp_dotd(before, after) < c->desc->least_cosine * sqrt(was) * sqrt(is)) {
            return false;
        }
    }
    return true;
}

/// Number of triangles that have both vertices. Takes as long as the smaller of their fans.
static uint32_t count_common(const collapser* c, uint32_t a, uint32_t b)
{
    uint32_t common = 0, few = c->degrees[a] < c->degrees[b] ? a : b, many = few == a ? b : a;
    for (uint32_t i = c->first[few]; i != NONE; i = c->next[i]) {
        common += c->gone[i / 3] == 0 && has_corner(c, i / 3, many) ? 1 : 0;
    }
    return common;
}

static void lose_triangle(collapser* c, uint32_t triangle)
{
    c->gone[triangle] = 1;
    c->triangles -= 1;
    for (size_t k = 0; k < 3; ++k) {
        uint32_t v = c->corners[3 * (size_t)triangle + k];
        assert(c->degrees[v] > 0);
        c->degrees[v] -= 1;
        c->vertices -= c->degrees[v] == 0 ? 1 : 0;
    }
}

/// Moves all of vertex `a` to `b`, which gets a new place.
static void merge(collapser* c, uint32_t a, uint32_t b, stp_vec3d place)
{
    for (uint32_t i = c->first[a]; i != NONE; i = c->next[i]) {
        if (c->gone[i / 3] == 0 && has_corner(c, i / 3, b)) {
            lose_triangle(c, i / 3);
        }
    }
    clean_list(c, a);
    clean_list(c, b);
    for (uint32_t i = c->first[a]; i != NONE; i = c->next[i]) {
        c->corners[i] = b;
    }
    // `a` is used no more; `b` is, if it was not, and takes triangles over
    c->vertices -= c->degrees[a] != 0 && c->degrees[b] != 0 ? 1 : 0;
    c->degrees[b] += c->degrees[a];
    c->degrees[a] = 0;
    if (c->first[a] != NONE) {
        if (c->first[b] == NONE) {
            c->first[b] = c->first[a];
        } else {
            c->next[c->last[b]] = c->first[a];
        }
        c->last[b] = c->last[a];
        c->first[a] = NONE;
    }
    c->quadrics[b] = stp_plane_quadric_sum(&c->quadrics[a], &c->quadrics[b]);
    c->places[b] = place;
    c->merged[a] = b;
    c->stamps[a] += 1;
    c->stamps[b] += 1;
}

/// The vertex that stands for another one.
static uint32_t find_end(uint32_t* merged, uint32_t vertex)
{
    while (merged[vertex] != vertex) {
        merged[vertex] = merged[merged[vertex]];
        vertex = merged[vertex];
    }
    return vertex;
}

/// Offers an edge of which an end has changed, if it is still there. Where two edges have become
/// one, both come here; the second is dropped. @return false if memory runs out
static bool offer_again(collapser* c, uint32_t a, uint32_t b)
{
    if (a == b || c->degrees[a] == 0 || c->degrees[b] == 0 || count_common(c, a, b) == 0) {
        return true;
    }
    const offer_note made = {a < b ? a : b, a < b ? b : a, c->stamps[a] + c->stamps[b]};
    offer_note* note = &c->notes[(made.a * 0x9E3779B1u ^ made.b * 0x85EBCA77u) >> NOTE_SHIFT];
    if (note->a == made.a && note->b == made.b && note->stamp == made.stamp) {
        return true;
    }
    *note = made;
    return offer(c, a, b);
}

static bool is_done(const collapser* c)
{
    return (c->desc->triangle_target > 0 && c->triangles <= c->desc->triangle_target) ||
           (c->desc->vertex_target > 0 && c->vertices <= c->desc->vertex_target);
}

/// Collapses an edge unless that costs too much. @return whether it did
static bool collapse_edge(collapser* c, uint32_t a, uint32_t b)
{
    double limit = c->desc->error_limit * c->desc->error_limit, lost = 0.0;
    stp_vec3d place;
    uint32_t common = count_common(c, a, b);
    if (common == 0 || c->degrees[a] + c->degrees[b] - 2 * common > STP_COLLAPSE_FAN) {
        return false;
    }
    double error = choose_place(c, a, b, &place);
    if (error > limit || !keeps_directions(c, a, b, place, true, &lost) ||
        !keeps_directions(c, b, a, place, false, &lost)) {
        return false;
    }
    // what is thinner than the error would vanish at no cost: its area is lost
    double area = c->quadrics[a].weight + c->quadrics[b].weight;
    error += lost > 0.0 && area > 0.0 ? LOST_WEIGHT * lost * lost / area : 0.0;
    if (error > limit) {
        return false;
    }
    c->worst = stp_maxd(c->worst, error);
    merge(c, a, b, place);
    return true;
}

/// Costs are found anew only when their edge is about to be collapsed. Edges that may not be wait
/// for a change of their ends. @return false if memory runs out
static bool collapse_edges(collapser* c)
{
    stp_collapse_candidate best;
    bool waited, good = true;
    while (good && !is_done(c) && stp_collapse_queue_take(&c->queue, &best, &waited)) {
        uint32_t a = find_end(c->merged, best.a), b = find_end(c->merged, best.b);
        if (a != best.a || b != best.b || best.stamp != c->stamps[a] + c->stamps[b]) {
            good = offer_again(c, a, b);
        } else if (!waited && c->degrees[a] > 0 && c->degrees[b] > 0 && !collapse_edge(c, a, b)) {
            good = stp_collapse_queue_wait(&c->queue, best);
        }
    }
    return good;
}

static void store(collapser* c)
{
    stp_collapse_mesh* m = c->mesh;
    uint32_t kept = 0;
    for (uint32_t t = 0; t < m->triangle_count; ++t) {
        if (c->gone[t] == 0) {
            memcpy(m->indices + 3 * (size_t)kept, c->corners + 3 * (size_t)t,
                   3 * sizeof(*m->indices));
            if (m->tags != NULL) {
                m->tags[kept] = m->tags[t];
            }
            kept += 1;
        }
    }
    assert(kept == c->triangles);
    m->triangle_count = kept;
    for (size_t i = 0; i < m->vertex_count; ++i) {
        if (c->stamps[i] > 0 && c->degrees[i] > 0 && !is_locked(c, (uint32_t)i)) {
            stp_vec3d p = stp_addd(c->places[i], c->origin);
            m->positions[3 * i] = (float)p.x;
            m->positions[3 * i + 1] = (float)p.y;
            m->positions[3 * i + 2] = (float)p.z;
        }
    }
}

static bool allocate(collapser* c)
{
    size_t vertices = (size_t)c->mesh->vertex_count + 1;
    size_t corners = 3 * (size_t)c->mesh->triangle_count + 1;
    c->places = STP_NEW_ARRAY(c->context, stp_vec3d, vertices);
    c->quadrics = STP_NEW_ZEROED(c->context, stp_plane_quadric, vertices);
    c->first = STP_NEW_ARRAY(c->context, uint32_t, vertices);
    c->last = STP_NEW_ARRAY(c->context, uint32_t, vertices);
    c->degrees = STP_NEW_ZEROED(c->context, uint32_t, vertices);
    c->stamps = STP_NEW_ZEROED(c->context, uint32_t, vertices);
    c->merged =
        c->mesh->merged != NULL ? c->mesh->merged : STP_NEW_ARRAY(c->context, uint32_t, vertices);
    c->notes = STP_NEW_ZEROED(c->context, offer_note, NOTES);
    c->next = STP_NEW_ARRAY(c->context, uint32_t, corners);
    c->corners = STP_NEW_ARRAY(c->context, uint32_t, corners);
    c->gone = STP_NEW_ZEROED(c->context, uint8_t, corners);
    return c->places != NULL && c->quadrics != NULL && c->first != NULL && c->last != NULL &&
           c->degrees != NULL && c->stamps != NULL && c->merged != NULL && c->notes != NULL &&
           c->next != NULL && c->corners != NULL && c->gone != NULL;
}

static void release(collapser* c)
{
    void* arrays[] = {c->places,           c->quadrics,  c->first, c->last,    c->degrees,
                      c->stamps,           c->notes,     c->next,  c->corners, c->gone,
                      c->queue.candidates, c->queue.heap};
    for (size_t i = 0; i < sizeof(arrays) / sizeof(arrays[0]); ++i) {
        stp_free(c->context, arrays[i]);
    }
    if (c->mesh->merged == NULL) {
        stp_free(c->context, c->merged);
    }
}

stp_result stp_collapse(stp_context* context, stp_collapse_mesh* mesh,
                        const stp_collapse_desc* desc, double* error)
{
    collapser c = {.context = context, .mesh = mesh, .desc = desc, .queue.context = context};
    assert(desc->border_weight >= 0.0 && desc->least_cosine <= 1.0 && desc->error_limit >= 0.0);
    assert(mesh->triangle_count <= UINT32_MAX / 3);
    *error = 0.0;
    c.too_dear = (float)fmin(desc->error_limit * desc->error_limit * (1.0 + 1e-5), (double)FLT_MAX);
    for (uint32_t i = 0; mesh->merged != NULL && i < mesh->vertex_count; ++i) {
        mesh->merged[i] = i; // even if no memory can be had
    }
    if (mesh->triangle_count == 0) {
        return STP_OK;
    }
    bool good = allocate(&c);
    if (good) {
        for (uint32_t i = 0; i < mesh->vertex_count; ++i) {
            c.merged[i] = i;
        }
        place_vertices(&c);
        link_corners(&c);
        add_triangles(&c);
        good = offer_edges(&c) && collapse_edges(&c);
    }
    if (good) {
        store(&c);
        for (uint32_t i = 0; mesh->merged != NULL && i < mesh->vertex_count; ++i) {
            mesh->merged[i] = find_end(mesh->merged, i);
        }
        *error = sqrt(c.worst);
    }
    release(&c);
    return good ? STP_OK : stp_fail_memory(context);
}
