// SPDX-License-Identifier: MIT
//
// A mesh is solid if its surface is closed (base/math/closed_surface.h), perhaps together with
// other pieces of it. A mesh that fails this test is tested for cracks (caps_internal.h).
#include "base/core/context.h"
#include "base/io/hash.h"
#include "base/math/closed_surface.h"
#include "base/math/math.h"
#include "base/math/rng.h"
#include "draw/caps_internal.h"
#include "store/clusters/clusters.h"

#include <assert.h>
#include <stdlib.h>
#include <string.h>

enum { NOT_ASKED = 2 };

/// A mesh. Meshes with the same key may be pieces of one solid.
typedef struct piece {
    uint64_t key; ///< hash of name and material
    uint32_t mesh;
} piece;

struct stp_cap_solids {
    stp_context* context;
    stp_store* store;
    uint32_t mesh_count;
    int8_t* sides; ///< NOT_ASKED: not known yet
    piece* pieces; ///< sorted by key
};

static int compare_pieces(const void* a, const void* b)
{
    const piece *x = a, *y = b;
    return x->key != y->key ? (x->key > y->key) - (x->key < y->key)
                            : (x->mesh > y->mesh) - (x->mesh < y->mesh);
}

static uint64_t key_of(const stp_store_mesh* mesh)
{
    uint64_t key = stp_rng_hash(7, mesh->material);
    for (const char* c = mesh->name; c != NULL && *c != '\0'; ++c) {
        key = stp_rng_hash(key, (uint64_t)(unsigned char)*c);
    }
    return key;
}

stp_result stp_cap_solids_create(stp_context* context, stp_store* store, stp_cap_solids** solids)
{
    uint32_t count = stp_store_first_level_mesh(stp_store_get_directory(store));
    stp_cap_solids* s = STP_NEW_ZEROED(context, stp_cap_solids, 1);
    *solids = NULL;
    if (s == NULL) {
        return stp_fail_memory(context);
    }
    *s = (stp_cap_solids){.context = context, .store = store, .mesh_count = count};
    s->sides = STP_NEW_ARRAY(context, int8_t, (size_t)count + 1);
    s->pieces = STP_NEW_ARRAY(context, piece, (size_t)count + 1);
    if (s->sides == NULL || s->pieces == NULL) {
        stp_cap_solids_destroy(s);
        return stp_fail_memory(context);
    }
    for (uint32_t i = 0; i < count; ++i) {
        s->sides[i] = NOT_ASKED;
        s->pieces[i] = (piece){key_of(stp_store_describe_mesh(store, i)), i};
    }
    qsort(s->pieces, count, sizeof(piece), compare_pieces);
    *solids = s;
    return STP_OK;
}

void stp_cap_solids_destroy(stp_cap_solids* solids)
{
    if (solids != NULL) {
        stp_free(solids->context, solids->sides);
        stp_free(solids->context, solids->pieces);
        stp_free(solids->context, solids);
    }
}

static stp_result visit_clusters(stp_store* store, uint32_t mesh, const stp_cap_visitor* visitor)
{
    stp_clusters clusters;
    stp_result result = stp_store_get_clusters(store, mesh, &clusters);
    float positions[3 * STP_CLUSTER_VERTICES];
    for (uint32_t i = 0; result == STP_OK && i < clusters.cluster_count; ++i) {
        stp_box box = stp_clusters_bounds(&clusters, i);
        if (visitor->wants != NULL && !visitor->wants(visitor->user, &box)) {
            continue;
        }
        stp_cluster cluster;
        stp_clusters_get(&clusters, i, &cluster);
        stp_cluster_positions(&clusters, &cluster, positions);
        for (uint32_t t = 0; t < cluster.triangle_count && result == STP_OK; ++t) {
            uint32_t c[3];
            stp_cluster_corners(&cluster, t, c);
            const float* const corners[3] = {positions + 3 * (size_t)c[0],
                                             positions + 3 * (size_t)c[1],
                                             positions + 3 * (size_t)c[2]};
            result = visitor->take(visitor->user, corners);
        }
    }
    return result;
}

static stp_result visit_columns(stp_store* store, uint32_t mesh, const stp_cap_visitor* visitor)
{
    stp_store_mesh columns;
    stp_result result = stp_store_get_mesh(store, mesh, &columns);
    for (size_t i = 0; result == STP_OK && i < columns.triangle_count; ++i) {
        const float* corners[3];
        for (size_t k = 0; k < 3; ++k) {
            corners[k] = columns.positions + 3 * (size_t)stp_store_mesh_corner(&columns, 3 * i + k);
        }
        result = visitor->take(visitor->user,
                               (const float* const[3]){corners[0], corners[1], corners[2]});
    }
    return result;
}

stp_result stp_cap_visit(stp_store* store, uint32_t mesh, const stp_cap_visitor* visitor)
{
    return stp_store_is_clustered(store, mesh) ? visit_clusters(store, mesh, visitor)
                                               : visit_columns(store, mesh, visitor);
}

static stp_result add_triangle(void* user, const float* const corners[3])
{
    stp_closed_surface_add(user, corners);
    return STP_OK;
}

/// Index of the first piece whose key is at least `key`; mesh_count: none.
static uint32_t find_pieces(const stp_cap_solids* s, uint64_t key)
{
    uint32_t low = 0, high = s->mesh_count;
    while (low < high) {
        uint32_t middle = low + (high - low) / 2;
        if (s->pieces[middle].key < key) {
            low = middle + 1;
        } else {
            high = middle;
        }
    }
    assert(low == s->mesh_count || s->pieces[low].key >= key);
    assert((low == 0 || s->pieces[low - 1].key < key) && "pieces are sorted by key");
    return low;
}

static stp_result add_to_border(void* user, const float* const corners[3])
{
    return stp_cap_border_add(user, corners);
}

/// Whether meshes together are closed, except for cracks.
static stp_result check_cracks(const stp_cap_solids* s, const piece* pieces, uint32_t count,
                               int* side)
{
    uint64_t triangles = 0;
    for (uint32_t i = 0; i < count; ++i) {
        triangles += stp_store_describe_mesh(s->store, pieces[i].mesh)->triangle_count;
    }
    stp_cap_border* cracks = NULL;
    stp_result result = stp_cap_border_create(s->context, triangles, &cracks);
    stp_cap_visitor visitor = {.take = add_to_border, .user = cracks};
    for (int round = 0; round < 2 && result == STP_OK; ++round) {
        for (uint32_t i = 0; i < count && result == STP_OK; ++i) {
            result = stp_cap_visit(s->store, pieces[i].mesh, &visitor);
        }
        if (result == STP_OK) {
            stp_cap_border_turn(cracks);
        }
    }
    if (result == STP_OK) {
        result = stp_cap_border_side(cracks, side);
    }
    stp_cap_border_destroy(cracks);
    return result;
}

/// Tests an open mesh together with all possible pieces of the same solid.
static stp_result check_pieces(stp_cap_solids* s, uint32_t mesh)
{
    uint64_t key = key_of(stp_store_describe_mesh(s->store, mesh));
    uint32_t first = find_pieces(s, key), count = 0;
    stp_closed_surface whole = {0};
    stp_cap_visitor visitor = {.take = add_triangle, .user = &whole};
    stp_result result = STP_OK;
    for (; first + count < s->mesh_count && s->pieces[first + count].key == key; ++count) {
        result = result == STP_OK ? stp_cap_visit(s->store, s->pieces[first + count].mesh, &visitor)
                                  : result;
    }
    assert(count > 0 && "a mesh is a piece of its own key");
    int side = stp_closed_surface_side(&whole);
    if (result == STP_OK && side == 0) {
        const piece own = {key, mesh};
        result = check_cracks(s, &own, 1, &side);
        if (result == STP_OK && side != 0) {
            s->sides[mesh] = (int8_t)side;
            return STP_OK;
        }
    }
    if (result == STP_OK && side == 0 && count > 1) {
        result = check_cracks(s, s->pieces + first, count, &side);
    }
    for (uint32_t i = first; i < first + count && result == STP_OK; ++i) {
        int8_t* known = &s->sides[s->pieces[i].mesh];
        *known = *known == 1 || *known == -1 ? *known : (int8_t)side;
    }
    return result;
}

stp_result stp_cap_solids_side(stp_cap_solids* s, uint32_t mesh, int* side)
{
    assert(mesh < s->mesh_count);
    stp_result result = STP_OK;
    if (s->sides[mesh] == NOT_ASKED) {
        stp_closed_surface own = {0};
        stp_cap_visitor visitor = {.take = add_triangle, .user = &own};
        result = stp_cap_visit(s->store, mesh, &visitor);
        if (result == STP_OK && stp_closed_surface_side(&own) != 0) {
            s->sides[mesh] = (int8_t)stp_closed_surface_side(&own);
        } else if (result == STP_OK) {
            result = check_pieces(s, mesh);
        }
    }
    assert((result != STP_OK || s->sides[mesh] != NOT_ASKED) && "the answer is kept");
    *side = result == STP_OK ? s->sides[mesh] : 0;
    return result;
}
