// SPDX-License-Identifier: MIT
// Loose parts: leaves, needles, twigs, cards. If a mesh has many, the triangles of a part stay
// together, and parts with equal counts follow each other, so that one cluster can store a pattern
// many times.
//
// Vertices join a part if they share triangles or round to the same position. Meshes that repeat
// vertices at each edge only seem loose: clusters weld them as usual, on the mesh's grid.
#include "base/core/context.h"
#include "store/clusters/clusters_encode.h"

#include <assert.h>

enum {
    MAX_TRIANGLES = 32, // per part
    MAX_VERTICES = 32,
    CLASSES = MAX_TRIANGLES * MAX_VERTICES,
    MIN_OF_CLASS = 64,   // smaller classes get no clusters of their own
    WINDOW = 32,         // consecutive triangles along the curve that a sample examines,
    WINDOW_EVERY = 2048, // one sample per this many triangles
    MIN_SHARE = 16,      // meshes with fewer loose triangles than one in this many stay unsorted
};

typedef struct part_finder {
    const stp_store_mesh* mesh;
    const cluster_place* places;
    uint32_t* parents;   ///< union-find forest of vertices; parents have lower indices
    uint32_t* triangles; ///< per root
    uint32_t* vertices;  ///< per root; more than MAX_VERTICES: not loose
    uint32_t* slots;     ///< vertices by position: index + 1; 0: none
    uint32_t slot_bits;
    uint32_t* next; ///< the next triangle of the same part, index + 1
    uint32_t* first;
} part_finder;

static uint32_t find_root(uint32_t* parents, uint32_t v)
{
    while (parents[v] != v) {
        assert(parents[v] < v && "parents have lower indices, so the loop ends");
        parents[v] = parents[parents[v]];
        v = parents[v];
    }
    return v;
}

static uint32_t min_u32(uint32_t a, uint32_t b)
{
    return a < b ? a : b;
}

static void join(uint32_t* parents, uint32_t a, uint32_t b)
{
    a = find_root(parents, a);
    b = find_root(parents, b);
    uint32_t minimum = min_u32(a, b);
    parents[a] = minimum;
    parents[b] = minimum;
}

/// Points every vertex at its root.
static void flatten(uint32_t* parents, uint32_t count)
{
    for (uint32_t v = 0; v < count; ++v) {
        parents[v] = parents[parents[v]];
        assert(parents[parents[v]] == parents[v] && "lower vertices are flat already");
    }
}

/// Flattens the forest and counts the triangles of each root. @return triangles in small parts
static uint32_t count_small(const part_finder* f)
{
    const stp_store_mesh* mesh = f->mesh;
    flatten(f->parents, mesh->vertex_count);
    memset(f->triangles, 0, mesh->vertex_count * sizeof(f->triangles[0]));
    for (uint32_t t = 0; t < mesh->triangle_count; ++t) {
        f->triangles[f->parents[mesh->indices[3 * (size_t)t]]] += 1;
    }
    uint32_t small = 0;
    for (uint32_t v = 0; v < mesh->vertex_count; ++v) {
        small += f->triangles[v] <= MAX_TRIANGLES ? f->triangles[v] : 0;
    }
    return small;
}

static void join_triangles(const part_finder* f)
{
    const stp_store_mesh* mesh = f->mesh;
    uint32_t* parents = f->parents;
    for (uint32_t v = 0; v < mesh->vertex_count; ++v) {
        parents[v] = v;
    }
    for (size_t t = 0; t < mesh->triangle_count; ++t) {
        const uint32_t* corner = mesh->indices + 3 * t;
        uint32_t a = parents[corner[0]], b = parents[corner[1]], c = parents[corner[2]];
        if (a != b || b != c) { // else already joined
            a = find_root(parents, a);
            b = find_root(parents, b);
            c = find_root(parents, c);
            uint32_t minimum = min_u32(a, min_u32(b, c));
            parents[a] = parents[b] = parents[c] = minimum;
            parents[corner[0]] = parents[corner[1]] = parents[corner[2]] = minimum;
        }
    }
}

static bool is_same_place(const cluster_place* a, const cluster_place* b)
{
    return a->at[0] == b->at[0] && a->at[1] == b->at[1] && a->at[2] == b->at[2];
}

/// In a run of neighbouring triangles, counts the corners that coincide with a corner of another
/// part.
static uint32_t count_shared(const part_finder* f, const uint64_t* order)
{
    cluster_place places[3 * WINDOW];
    uint32_t roots[3 * WINDOW], shared = 0;
    for (uint32_t i = 0; i < 3 * WINDOW; ++i) {
        uint32_t vertex = f->mesh->indices[3 * (size_t)(uint32_t)order[i / 3] + i % 3];
        places[i] = f->places[vertex];
        roots[i] = find_root(f->parents, vertex);
    }
    for (uint32_t i = 0; i < 3 * WINDOW; ++i) {
        bool met = false;
        for (uint32_t k = 0; k < 3 * WINDOW && !met; ++k) {
            met = is_same_place(&places[i], &places[k]) && roots[i] != roots[k];
        }
        shared += met ? 1 : 0;
    }
    return shared;
}

/// Samples whether parts that are loose by vertices coincide in position: then the mesh is triangle
/// soup and no part would stay loose.
static bool is_soup(const part_finder* f, const uint64_t* order)
{
    assert(f->mesh->triangle_count >= WINDOW);
    uint32_t windows = f->mesh->triangle_count / WINDOW_EVERY + 1, shared = 0;
    for (uint32_t i = 0; i < windows; ++i) {
        uint64_t last = f->mesh->triangle_count - WINDOW;
        shared += count_shared(f, order + last * i / windows);
    }
    return shared > 3 * WINDOW / 2 * windows;
}

/// Whether another vertex rounds to the same position: then the two are joined.
static bool is_joined(const part_finder* f, uint32_t vertex)
{
    const cluster_place* place = &f->places[vertex];
    const int32_t* p = place->at;
    uint64_t hash = (uint32_t)p[0] * 0x9e3779b97f4a7c15u ^ (uint32_t)p[1] * 0xc2b2ae3d27d4eb4fu ^
                    (uint32_t)p[2] * 0x165667b19e3779f9u;
    hash = (hash ^ hash >> 29) * 0xbf58476d1ce4e5b9u;
    uint32_t mask = ((uint32_t)1 << f->slot_bits) - 1;
    for (uint32_t slot = (uint32_t)(hash >> 32) & mask;; slot = (slot + 1) & mask) {
        if (f->slots[slot] == 0) {
            f->slots[slot] = vertex + 1;
            return false;
        }
        if (is_same_place(place, &f->places[f->slots[slot] - 1])) {
            join(f->parents, vertex, f->slots[slot] - 1);
            return true;
        }
    }
}

/// Joins coinciding vertices and counts the vertices of each part.
static void join_vertices(const part_finder* f)
{
    uint32_t count = f->mesh->vertex_count;
    // first mark used vertices, then those that coincide; both end up as sums of the root
    for (uint32_t v = 0; v < count; ++v) {
        bool used = f->triangles[find_root(f->parents, v)] != 0;
        f->vertices[v] = used ? (is_joined(f, v) ? MAX_VERTICES + 1 : 1) : 0;
    }
    for (uint32_t v = count;
         v-- > 0;) { // roots have the lowest indices of their trees, so children come first
        uint32_t parent = f->parents[v];
        if (parent != v) {
            uint32_t sum = f->vertices[parent] + f->vertices[v];
            f->vertices[parent] = sum <= MAX_VERTICES ? sum : MAX_VERTICES + 1;
        }
    }
}

/// The class of a triangle's part, from its counts (clusters_part_class); 0: not loose.
static uint32_t classify(const part_finder* f, uint32_t triangle, uint32_t* root)
{
    *root = find_root(f->parents, f->mesh->indices[3 * (size_t)triangle]);
    uint32_t triangles = f->triangles[*root], vertices = f->vertices[*root];
    bool loose = triangles <= MAX_TRIANGLES && vertices <= MAX_VERTICES;
    return loose ? clusters_part_class(triangles, vertices) : 0;
}

static uint32_t bucket_of(uint32_t class)
{
    assert(class == 0 || (clusters_part_triangles(class) - 1 < MAX_TRIANGLES &&
                          clusters_part_vertices(class) - 1 < MAX_VERTICES));
    return class == 0 ? 0
                      : (clusters_part_triangles(class) - 1) * MAX_VERTICES +
                            clusters_part_vertices(class);
}

static void sort_parts(const part_finder* f, const uint64_t* order, uint64_t* out)
{
    uint32_t count = f->mesh->triangle_count, root, sizes[CLASSES + 1] = {0};
    memset(f->first, 0, f->mesh->vertex_count * sizeof(f->first[0]));
    for (uint32_t t = count; t-- > 0;) {
        sizes[bucket_of(classify(f, t, &root))] += 1;
        f->next[t] = f->first[root];
        f->first[root] = t + 1;
    }
    uint32_t begin = sizes[0], places[CLASSES + 1] = {0};
    for (uint32_t i = 1; i <= CLASSES; ++i) {
        begin += sizes[i] < MIN_OF_CLASS ? sizes[i] : 0;
    }
    for (uint32_t i = 1; i <= CLASSES; ++i) {
        places[i] = begin;
        begin += sizes[i] < MIN_OF_CLASS ? 0 : sizes[i];
    }
    assert(begin == count && "every triangle has a place");
    for (uint32_t i = 0; i < count; ++i) {
        uint32_t t = (uint32_t)order[i], class = classify(f, t, &root), bucket = bucket_of(class);
        if (bucket == 0 || sizes[bucket] < MIN_OF_CLASS) {
            out[places[0]++] = t;
            continue;
        }
        for (uint32_t link = f->first[root]; link != 0; link = f->next[link - 1]) {
            out[places[bucket]++] = (uint64_t) class << 32 | (link - 1);
        }
        f->first[root] = 0; // the part's other triangles are done
    }
}

static bool allocate(stp_context* context, part_finder* f)
{
    uint32_t count = f->mesh->vertex_count;
    for (f->slot_bits = 4;
         f->slot_bits < 31 && (uint64_t)1 << f->slot_bits < 2 * (uint64_t)count;) {
        f->slot_bits += 1;
    }
    f->vertices = STP_NEW_ARRAY(context, uint32_t, count);
    f->first = STP_NEW_ARRAY(context, uint32_t, count);
    f->next = STP_NEW_ARRAY(context, uint32_t, f->mesh->triangle_count);
    f->slots = STP_NEW_ZEROED(context, uint32_t, (size_t)1 << f->slot_bits);
    return f->vertices != NULL && f->first != NULL && f->next != NULL && f->slots != NULL;
}

stp_result stp_clusters_sort_parts(stp_context* context, const stp_store_mesh* mesh,
                                   const cluster_place* places, uint64_t** order,
                                   uint64_t** scratch)
{
    part_finder f = {.mesh = mesh, .places = places};
    f.parents = STP_NEW_ARRAY(context, uint32_t, mesh->vertex_count);
    f.triangles = STP_NEW_ARRAY(context, uint32_t, mesh->vertex_count);
    bool made = f.parents != NULL && f.triangles != NULL;
    for (uint32_t i = 0; i < mesh->triangle_count; ++i) {
        (*order)[i] &= UINT32_MAX;
    }
    if (made) {
        join_triangles(&f);
        if (count_small(&f) >= mesh->triangle_count / MIN_SHARE && !is_soup(&f, *order)) {
            made = allocate(context, &f);
            if (made) {
                join_vertices(&f);
                (void)count_small(&f);
                sort_parts(&f, *order, *scratch);
                uint64_t* sorted = *scratch;
                *scratch = *order;
                *order = sorted;
            }
        }
    }
    stp_free(context, f.parents);
    stp_free(context, f.triangles);
    stp_free(context, f.vertices);
    stp_free(context, f.first);
    stp_free(context, f.next);
    stp_free(context, f.slots);
    return made ? STP_OK : stp_fail_memory(context);
}
