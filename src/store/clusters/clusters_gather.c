// SPDX-License-Identifier: MIT
// Fills one cluster, triangle by triangle. Rounds and welds vertices; gives them normals only if
// the plane of the rounded triangle is not good enough.
#include "base/splats/octahedral.h"
#include "store/clusters/clusters_encode.h"

#include <assert.h>

// Squared cosine of a third of a degree: closer directions shade alike in 8 bits.
#define ALIKE 0.999964

enum {
    PART_BITS = 5,    // short edges of loose parts keep at least 2^PART_BITS steps,
    SHORT_PARTS = 16, // except in one part of this many
};

/// A triangle's corner before it becomes a vertex.
typedef struct corner {
    cluster_place place; ///< normal as in the mesh
    uint32_t slot;
    int32_t extra[STP_CLUSTER_CHANNELS]; ///< channels in use only
} corner;

typedef struct direction {
    double x, y, z;
} direction;

static int32_t round_normal(int32_t code)
{
    int32_t scaled = 2 * STP_CLUSTER_NORMAL_LIMIT * code;
    return (scaled + (scaled < 0 ? -32767 : 32767)) / (2 * 32767);
}

/// From 16 bits to the precision of clusters.
static uint32_t store_normal(uint32_t normal)
{
    return clusters_join_normal(round_normal(clusters_normal_u(normal)),
                                round_normal(clusters_normal_v(normal)));
}

static int32_t round_color(uint16_t linear)
{
    return (int32_t)(sqrtf((float)linear * (1.0f / 65535.0f)) * STP_CLUSTER_COLOR_LIMIT + 0.5f);
}

/// Channels of a vertex other than position and normal.
static int32_t read_extra(const stp_cluster_maker* m, uint32_t vertex, uint32_t channel)
{
    const stp_store_mesh* mesh = m->mesh;
    if (channel >= STP_CLUSTER_COLORS) {
        uint16_t color = mesh->colors[4 * (size_t)vertex + (channel - STP_CLUSTER_COLORS)];
        return channel < STP_CLUSTER_COLORS + 3 ? round_color(color) : (color + 128) / 257;
    }
    uint32_t set = (channel - STP_CLUSTER_TEXCOORDS) / 2, k = (channel - STP_CLUSTER_TEXCOORDS) % 2;
    return stp_clusters_round((double)mesh->texcoords[set][2 * (size_t)vertex + k] *
                              m->texcoord_inverses[set]);
}

static void read_corner(const stp_cluster_maker* m, uint32_t vertex, corner* c)
{
    c->place = m->places[vertex];
    if (m->shift != 0) {
        const int32_t unit = 1 << m->shift;
        const double scale = m->inverse_step / unit; // exact: both are powers of two
        for (size_t k = 0; k < 3; ++k) {
            c->place.at[k] =
                stp_clusters_round((double)m->mesh->positions[3 * (size_t)vertex + k] * scale) *
                unit;
        }
    }
    uint32_t hash = (uint32_t)c->place.at[0] * 0x9e3779b1u ^
                    (uint32_t)c->place.at[1] * 0x85ebca77u ^ (uint32_t)c->place.at[2] * 0xc2b2ae3du;
    for (uint32_t i = 0; i < m->extra_count; ++i) {
        c->extra[i] = read_extra(m, vertex, m->extra_channels[i]);
        hash = (hash ^ (uint32_t)c->extra[i]) * 0x9e3779b1u;
        hash ^= hash >> 15;
    }
    c->slot = (hash ^ hash >> 15) * 0x85ebca77u >> 22;
    assert(c->slot < CLUSTER_SLOTS);
}

static direction cross(direction a, direction b)
{
    return (direction){a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}

static double dot(direction a, direction b)
{
    return a.x * b.x + a.y * b.y + a.z * b.z;
}

static bool are_alike(direction a, direction b)
{
    double agreement = dot(a, b);
    bool near = agreement * agreement >= ALIKE * (dot(a, a) * dot(b, b));
    return (agreement > 0.0) & near; // branch-free: the outcome is unpredictable
}

/// Decodes a 16-bit octahedral normal; not of unit length.
static direction unfold_normal(uint32_t normal)
{
    double x = clusters_normal_u(normal), y = clusters_normal_v(normal);
    double z = 32767.0 - fabs(x) - fabs(y);
    double fold = z < 0.0 ? -z : 0.0;
    x += x >= 0.0 ? -fold : fold;
    y += y >= 0.0 ? -fold : fold;
    return (direction){x, y, z};
}

/// Normal of the rounded triangle; not of unit length.
static direction rounded_plane(const corner c[3])
{
    direction edge[2];
    for (int k = 0; k < 2; ++k) {
        const int32_t *a = c[0].place.at, *b = c[k + 1].place.at; // below 2^30
        edge[k] = (direction){b[0] - a[0], b[1] - a[1], b[2] - a[2]};
    }
    return cross(edge[0], edge[1]);
}

static direction true_plane(const stp_store_mesh* mesh, const uint32_t* vertex)
{
    direction edge[2];
    const float* a = mesh->positions + 3 * (size_t)vertex[0];
    for (int k = 0; k < 2; ++k) {
        const float* b = mesh->positions + 3 * (size_t)vertex[k + 1];
        edge[k] = (direction){(double)b[0] - (double)a[0], (double)b[1] - (double)a[1],
                              (double)b[2] - (double)a[2]};
    }
    return cross(edge[0], edge[1]);
}

/// Chooses a triangle's group, and sets the normal of its first corner if the mesh has none.
static cluster_group choose_group(const stp_cluster_maker* m, const uint32_t* vertex, corner c[3])
{
    if (m->all_plain) {
        return GROUP_PLAIN;
    }
    direction rounded = rounded_plane(c);
    if (!(dot(rounded, rounded) > 0.0)) {
        return GROUP_PLAIN; // degenerate: invisible
    }
    if (m->mesh->normals == NULL) {
        direction plane = true_plane(m->mesh, vertex);
        double square = dot(plane, plane);
        if (!(square > 0.0) || are_alike(rounded, plane)) {
            return GROUP_PLAIN;
        }
        double scale = 1.0 / sqrt(square);
        int16_t code[2];
        stp_octahedral_encode16((stp_vec3){(float)(plane.x * scale), (float)(plane.y * scale),
                                           (float)(plane.z * scale)},
                                code);
        c[0].place.normal = clusters_join_normal(code[0], code[1]);
        return GROUP_FACE;
    }
    uint32_t code[3] = {c[0].place.normal, c[1].place.normal, c[2].place.normal};
    direction normal = unfold_normal(code[0]);
    if (code[0] == code[1] && code[0] == code[2]) {
        return are_alike(normal, rounded) ? GROUP_PLAIN : GROUP_FACE;
    }
    direction second = unfold_normal(code[1]), third = unfold_normal(code[2]);
    if (!are_alike(normal, second) || !are_alike(normal, third)) {
        return GROUP_SMOOTH;
    }
    bool plain =
        are_alike(normal, rounded) && are_alike(second, rounded) && are_alike(third, rounded);
    return plain ? GROUP_PLAIN : GROUP_FACE;
}

static bool is_same(const stp_cluster_maker* m, uint32_t vertex, const corner* c)
{
    bool same = memcmp(m->vertices[vertex].at, c->place.at, sizeof(c->place.at)) == 0;
    for (uint32_t i = 0; i < m->extra_count; ++i) {
        same = same && m->values[m->extra_channels[i]][vertex] == c->extra[i];
    }
    return same;
}

typedef enum wanted { WANT_ANY, WANT_NORMAL, WANT_NONE } wanted;

/// Finds a vertex at the corner's position with the given normal, without one, or with any. @return
/// STP_CLUSTER_VERTICES if there is none
static uint32_t find_vertex(const stp_cluster_maker* m, const corner* c, wanted want,
                            uint32_t normal)
{
    for (uint32_t link = m->slots[c->slot]; link != 0; link = m->next[link - 1]) {
        uint32_t v = link - 1;
        bool fits = want == WANT_ANY || (want == WANT_NONE && !m->has_normal[v]) ||
                    (want == WANT_NORMAL && m->has_normal[v] && m->vertices[v].normal == normal);
        if (fits && is_same(m, v, c)) {
            return v;
        }
    }
    return STP_CLUSTER_VERTICES;
}

static uint32_t add_vertex(stp_cluster_maker* m, const corner* c)
{
    assert(m->vertex_count < STP_CLUSTER_VERTICES);
    uint32_t v = m->vertex_count++;
    m->vertices[v] = c->place;
    for (uint32_t i = 0; i < m->extra_count; ++i) {
        m->values[m->extra_channels[i]][v] = c->extra[i];
    }
    m->has_normal[v] = false;
    m->next[v] = m->slots[c->slot];
    m->slots[c->slot] = (uint16_t)(v + 1);
    return v;
}

static uint32_t set_normal(stp_cluster_maker* m, uint32_t vertex, uint32_t normal)
{
    m->vertices[vertex].normal = normal;
    m->has_normal[vertex] = true;
    return vertex;
}

static uint32_t any_vertex(stp_cluster_maker* m, const corner* c)
{
    uint32_t v = find_vertex(m, c, WANT_ANY, 0);
    return v < STP_CLUSTER_VERTICES ? v : add_vertex(m, c);
}

static uint32_t smooth_vertex(stp_cluster_maker* m, const corner* c)
{
    uint32_t normal = store_normal(c->place.normal);
    uint32_t v = find_vertex(m, c, WANT_NORMAL, normal);
    if (v < STP_CLUSTER_VERTICES) {
        return v;
    }
    v = find_vertex(m, c, WANT_NONE, 0);
    return set_normal(m, v < STP_CLUSTER_VERTICES ? v : add_vertex(m, c), normal);
}

/// Rotates the triangle so that its first corner is a vertex with the triangle's normal: one that
/// has it, one without a normal, or a new one.
static void face_vertices(stp_cluster_maker* m, const corner c[3], uint8_t out[3])
{
    uint32_t normal = store_normal(c[0].place.normal);
    uint32_t first = STP_CLUSTER_VERTICES, turn = 0;
    for (uint32_t k = 0; k < 6 && first == STP_CLUSTER_VERTICES; ++k) {
        first = find_vertex(m, &c[k % 3], k < 3 ? WANT_NORMAL : WANT_NONE, normal);
        turn = first < STP_CLUSTER_VERTICES ? k % 3 : 0;
    }
    if (first == STP_CLUSTER_VERTICES) {
        first = add_vertex(m, &c[0]);
    }
    if (!m->has_normal[first]) {
        set_normal(m, first, normal);
    }
    out[0] = (uint8_t)first;
    out[1] = (uint8_t)any_vertex(m, &c[(turn + 1) % 3]);
    out[2] = (uint8_t)any_vertex(m, &c[(turn + 2) % 3]);
}

void stp_cluster_maker_begin(stp_cluster_maker* m)
{
    m->triangle_count = 0;
    m->vertex_count = 0;
    m->shift = 0;
    m->group = 0;
    memset(m->slots, 0, sizeof(m->slots));
}

/// Whether there is room for a triangle's vertices.
static bool has_room(const stp_cluster_maker* m, const corner c[3])
{
    uint32_t room = STP_CLUSTER_VERTICES - m->vertex_count, added = 0;
    if (room >= 3 || !m->all_plain) {
        return room >= 3;
    }
    for (int k = 0; k < 3; ++k) {
        added += find_vertex(m, &c[k], WANT_ANY, 0) == STP_CLUSTER_VERTICES ? 1 : 0;
    }
    return added <= room;
}

bool stp_cluster_maker_add(stp_cluster_maker* m, uint32_t triangle)
{
    if (m->triangle_count == STP_CLUSTER_TRIANGLES) {
        return false;
    }
    const uint32_t* vertex = m->mesh->indices + 3 * (size_t)triangle;
    corner c[3];
    for (int k = 0; k < 3; ++k) {
        read_corner(m, vertex[k], &c[k]);
    }
    if (!has_room(m, c)) {
        return false;
    }
    cluster_group group = choose_group(m, vertex, c);
    uint8_t* out = m->corners[m->triangle_count];
    if (group == GROUP_FACE) {
        face_vertices(m, c, out);
    } else {
        for (int k = 0; k < 3; ++k) {
            out[k] =
                (uint8_t)(group == GROUP_SMOOTH ? smooth_vertex(m, &c[k]) : any_vertex(m, &c[k]));
        }
    }
    m->groups[m->triangle_count++] = (uint8_t)group;
    return true;
}

/// Exponent of the squared length, in steps, of the shortest edge of one part; INT32_MAX: it has
/// none.
static int32_t shortest_octave(const stp_cluster_maker* m, const uint64_t* triangles,
                               uint32_t count)
{
    double minimum = DBL_MAX;
    for (uint32_t i = 0; i < count; ++i) {
        const uint32_t* vertex = m->mesh->indices + 3 * (size_t)(uint32_t)triangles[i];
        for (int k = 0; k < 3; ++k) {
            const float* a = m->mesh->positions + 3 * (size_t)vertex[k];
            const float* b = m->mesh->positions + 3 * (size_t)vertex[(k + 1) % 3];
            direction d = {((double)b[0] - (double)a[0]) * m->inverse_step,
                           ((double)b[1] - (double)a[1]) * m->inverse_step,
                           ((double)b[2] - (double)a[2]) * m->inverse_step};
            double square = dot(d, d);
            minimum = square > 0.0 && square < minimum ? square : minimum;
        }
    }
    uint64_t bits;
    memcpy(&bits, &minimum, sizeof(bits));
    return minimum < DBL_MAX ? (int32_t)(bits >> 52) - 1023 : INT32_MAX;
}

/// Number of low bits that positions of loose parts can drop: short edges keep 2^PART_BITS steps.
/// Loose parts touch nothing else, so no cracks appear.
static uint32_t choose_shift(const stp_cluster_maker* m, const uint64_t* triangles, uint32_t count,
                             uint32_t part)
{
    int32_t octaves[STP_CLUSTER_TRIANGLES] = {0};
    uint32_t sorted = 0;
    for (uint32_t i = 0; i < count; i += part) {
        int32_t octave = shortest_octave(m, triangles + i, part);
        uint32_t at = sorted++;
        for (; at > 0 && octaves[at - 1] > octave; --at) {
            octaves[at] = octaves[at - 1];
        }
        octaves[at] = octave;
    }
    int32_t low = octaves[sorted / SHORT_PARTS];
    int32_t shift = low == INT32_MAX ? 0 : low / 2 - PART_BITS;
    shift = shift < CLUSTERS_MAX_SHIFT ? shift : CLUSTERS_MAX_SHIFT;
    return shift > 0 ? (uint32_t)shift : 0;
}

/// Index of a source vertex within its part, which has `known` vertices so far.
static uint32_t find_in_part(const uint32_t* sources, uint32_t known, uint32_t vertex)
{
    uint32_t i = 0;
    while (i < known && sources[i] != vertex) {
        i += 1;
    }
    return i;
}

/// Vertices used by the triangles of a part, by their input indices; at most STP_CLUSTER_VERTICES +
/// 1.
static uint32_t count_sources(const stp_cluster_maker* m, const uint64_t* triangles, uint32_t count)
{
    uint32_t sources[STP_CLUSTER_VERTICES], known = 0;
    for (uint32_t i = 0; i < 3 * count; ++i) {
        uint32_t vertex = m->mesh->indices[3 * (size_t)(uint32_t)triangles[i / 3] + i % 3];
        if (find_in_part(sources, known, vertex) == known) {
            if (known == STP_CLUSTER_VERTICES) {
                return known + 1;
            }
            sources[known++] = vertex;
        }
    }
    return known;
}

/// @return whether the triangle's own plane lights it
static bool add_part_triangle(stp_cluster_maker* m, uint32_t triangle, uint32_t first,
                              uint32_t* sources)
{
    const uint32_t* vertex = m->mesh->indices + 3 * (size_t)triangle;
    corner c[3];
    for (uint32_t k = 0; k < 3; ++k) {
        read_corner(m, vertex[k], &c[k]);
        uint32_t known = m->vertex_count - first;
        uint32_t at = find_in_part(sources, known, vertex[k]);
        if (at == known) {
            sources[known] = vertex[k];
            uint32_t v = add_vertex(m, &c[k]);
            if (m->mesh->normals != NULL) {
                set_normal(m, v, store_normal(c[k].place.normal));
            }
        }
        m->corners[m->triangle_count][k] = (uint8_t)(first + at);
    }
    m->groups[m->triangle_count++] = GROUP_SMOOTH;
    return choose_group(m, vertex, c) == GROUP_PLAIN;
}

bool stp_cluster_maker_take_parts(stp_cluster_maker* m, const uint64_t* triangles, uint32_t count,
                                  uint32_t part_class)
{
    uint32_t part = clusters_part_triangles(part_class);
    assert(part_class != 0 && count >= 1 && count <= STP_CLUSTER_TRIANGLES && count % part == 0);
    stp_cluster_maker_begin(m);
    m->group = clusters_part_vertices(part_class);
    // without normals, planes alone light the faces, so they must not turn
    bool coarse = m->mesh->normals != NULL && !m->mesh->is_piece;
    m->shift = coarse ? choose_shift(m, triangles, count, part) : 0;
    bool plain = true;
    for (uint32_t i = 0; i < count;) {
        uint32_t sources[STP_CLUSTER_VERTICES], first = m->vertex_count, end = i + part;
        // two parts in one place may be interleaved along the curve
        if (count_sources(m, triangles + i, part) != m->group) {
            return false;
        }
        for (; i < end; ++i) {
            plain = add_part_triangle(m, (uint32_t)triangles[i], first, sources) && plain;
        }
    }
    for (uint32_t i = 0; plain && i < count; ++i) {
        m->groups[i] = GROUP_PLAIN;
    }
    for (uint32_t v = 0; plain && v < m->vertex_count; ++v) {
        m->has_normal[v] = false;
    }
    return plain || m->mesh->normals != NULL;
}

/// Moves vertices with normals to the front and splits vertices into channels. @return how many
/// have normals
static uint32_t order_vertices(stp_cluster_maker* m)
{
    uint8_t place[STP_CLUSTER_VERTICES];
    uint32_t normals = 0, count = m->vertex_count;
    for (uint32_t v = 0; v < count; ++v) {
        normals += m->has_normal[v] ? 1 : 0;
    }
    for (uint32_t v = 0, with = 0, without = normals; v < count; ++v) {
        uint32_t at = m->has_normal[v] ? with++ : without++;
        assert(at < (m->has_normal[v] ? normals : count) && "a permutation, normals first");
        const cluster_place* vertex = &m->vertices[v];
        place[v] = (uint8_t)at;
        m->values[STP_CLUSTER_X][at] = vertex->at[0];
        m->values[STP_CLUSTER_Y][at] = vertex->at[1];
        m->values[STP_CLUSTER_Z][at] = vertex->at[2];
        m->values[STP_CLUSTER_NORMAL_U][at] = clusters_normal_u(vertex->normal);
        m->values[STP_CLUSTER_NORMAL_V][at] = clusters_normal_v(vertex->normal);
    }
    if (normals == 0 || normals == count) {
        return normals; // order unchanged
    }
    for (uint32_t i = 0; i < m->extra_count; ++i) {
        int32_t* values = m->values[m->extra_channels[i]];
        int32_t moved[STP_CLUSTER_VERTICES];
        for (uint32_t v = 0; v < count; ++v) {
            moved[place[v]] = values[v];
        }
        memcpy(values, moved, count * sizeof(moved[0]));
    }
    for (uint32_t t = 0; t < m->triangle_count; ++t) {
        for (int k = 0; k < 3; ++k) {
            m->corners[t][k] = place[m->corners[t][k]];
        }
    }
    return normals;
}

void stp_cluster_maker_finish(stp_cluster_maker* m, clusters_entry* entry)
{
    assert(m->triangle_count >= 1 && m->vertex_count >= 1 && "clusters are never empty");
    uint8_t sorted[STP_CLUSTER_TRIANGLES][3];
    uint32_t counts[GROUP_COUNT] = {0}, at[GROUP_COUNT];
    for (uint32_t t = 0; t < m->triangle_count; ++t) {
        counts[m->groups[t]] += 1;
    }
    at[GROUP_SMOOTH] = 0;
    at[GROUP_FACE] = counts[GROUP_SMOOTH];
    at[GROUP_PLAIN] = counts[GROUP_SMOOTH] + counts[GROUP_FACE];
    for (uint32_t t = 0; t < m->triangle_count; ++t) {
        memcpy(sorted[at[m->groups[t]]++], m->corners[t], sizeof(sorted[0]));
    }
    assert(at[GROUP_SMOOTH] == counts[GROUP_SMOOTH] && at[GROUP_PLAIN] == m->triangle_count);
    memcpy(m->corners, sorted, m->triangle_count * sizeof(sorted[0]));
    entry->triangle_count = (uint8_t)m->triangle_count;
    entry->last_vertex = (uint8_t)(m->vertex_count - 1);
    entry->smooth_count = (uint8_t)counts[GROUP_SMOOTH];
    entry->face_count = (uint8_t)counts[GROUP_FACE];
    entry->normal_count = (uint16_t)order_vertices(m);
}
