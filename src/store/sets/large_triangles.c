// SPDX-License-Identifier: MIT
#include "store/sets/large_triangles.h"

#include "base/core/sort.h"
#include "base/splats/triangle_level.h"
#include "store/clusters/clusters.h"
#include "store/sets/sets_internal.h"

#include <assert.h>
#include <string.h>

// A mesh's list. Shorter lists that callers may still use are chained behind it.
struct stp_store_large {
    stp_store_large* older;
    float minimum;
    uint32_t count;
    uint32_t* triangles;
    float* levels;
};

typedef struct found_triangles {
    uint64_t* keys; ///< band (inverted), then triangle
    float* levels;  ///< by triangle of the mesh; only those found are set
    size_t count;
} found_triangles;

/// Two bands per octave, numbered from large levels to small ones; 0 is infinity.
static uint32_t find_band(float level)
{
    assert(level >= 0.0f);
    uint32_t bits;
    memcpy(&bits, &level, sizeof(bits));
    return (0x7F800000u - bits) >> 22;
}

static void search_cluster(const stp_clusters* clusters, uint32_t index, float minimum,
                           found_triangles* found)
{
    float positions[3 * STP_CLUSTER_VERTICES];
    uint32_t indices[3 * STP_CLUSTER_TRIANGLES];
    stp_cluster cluster;
    stp_clusters_get(clusters, index, &cluster);
    stp_cluster_positions(clusters, &cluster, positions);
    stp_cluster_indices(&cluster, 0, indices);
    for (uint32_t i = 0; i < cluster.triangle_count; ++i) {
        stp_vec3 corners[3];
        for (size_t k = 0; k < 3; ++k) {
            memcpy(&corners[k], positions + 3 * (size_t)indices[3 * i + k], sizeof(corners[k]));
        }
        float level = stp_triangle_level(corners[0], corners[1], corners[2]);
        uint32_t triangle = cluster.first_triangle + i;
        // a file that changes while open may have more triangles
        if (level >= minimum && level < HUGE_VALF && triangle < clusters->triangle_count &&
            found->count < clusters->triangle_count) {
            found->keys[found->count++] = (uint64_t)find_band(level) << 32 | triangle;
            found->levels[triangle] = level;
        }
    }
}

static stp_result keep_found(stp_store* store, found_triangles* found, uint64_t* scratch,
                             stp_store_large* large)
{
    const uint64_t* sorted = stp_sort_u64(found->keys, scratch, found->count, 32, 10);
    large->triangles = STP_NEW_ARRAY(store->context, uint32_t, found->count + 1);
    large->levels = STP_NEW_ARRAY(store->context, float, found->count + 1);
    if (large->triangles == NULL || large->levels == NULL) {
        return stp_fail_memory(store->context);
    }
    for (size_t i = 0; i < found->count; ++i) {
        large->triangles[i] = (uint32_t)sorted[i];
        large->levels[i] = found->levels[(uint32_t)sorted[i]];
        assert(i == 0 || sorted[i - 1] >> 32 <= sorted[i] >> 32);
    }
    large->count = (uint32_t)found->count;
    return STP_OK;
}

static void free_large(stp_context* context, stp_store_large* large)
{
    while (large != NULL) {
        stp_store_large* older = large->older;
        stp_free(context, large->triangles);
        stp_free(context, large->levels);
        stp_free(context, large);
        large = older;
    }
}

// A power of four, at most the value and more than an eighth of it, so that a mesh used at many
// scales gets few lists.
static float round_to_power_of_four(float minimum)
{
    int power;
    (void)frexpf(minimum, &power);
    return minimum > 0.0f ? ldexpf(1.0f, (power - 1) / 2 * 2 - (power < 1 ? 2 : 0)) : 0.0f;
}

static stp_result make_list(stp_store* store, const stp_clusters* clusters, float minimum,
                            stp_store_large** lists)
{
    stp_context* context = store->context;
    size_t count = clusters->triangle_count;
    found_triangles found = {.keys = STP_NEW_ARRAY(context, uint64_t, count + 1),
                             .levels = STP_NEW_ARRAY(context, float, count + 1)};
    uint64_t* scratch = STP_NEW_ARRAY(context, uint64_t, count + 1);
    bool made = found.keys != NULL && found.levels != NULL && scratch != NULL;
    for (uint32_t i = 0; made && i < clusters->cluster_count; ++i) {
        search_cluster(clusters, i, minimum, &found);
    }
    stp_store_large* large = made ? STP_NEW_ZEROED(context, stp_store_large, 1) : NULL;
    stp_result result =
        large != NULL ? keep_found(store, &found, scratch, large) : stp_fail_memory(context);
    if (result == STP_OK) {
        large->minimum = minimum;
        large->older = *lists;
        *lists = large;
    } else {
        free_large(context, large);
    }
    stp_free(context, found.keys);
    stp_free(context, found.levels);
    stp_free(context, scratch);
    return result;
}

stp_result stp_store_get_large_triangles(stp_store* store, uint32_t mesh, float minimum,
                                         stp_large_triangles* list)
{
    stp_clusters clusters;
    stp_result result = stp_store_get_clusters(store, mesh, &clusters);
    *list = (stp_large_triangles){0};
    if (result != STP_OK) {
        return result;
    }
    if (store->large == NULL) {
        store->large =
            STP_NEW_ZEROED(store->context, stp_store_large*, store->directory.mesh_count);
        if (store->large == NULL) {
            return stp_fail_memory(store->context);
        }
    }
    stp_store_large** lists = &store->large[mesh];
    if (*lists == NULL || !((*lists)->minimum <= minimum)) {
        result = make_list(store, &clusters, round_to_power_of_four(minimum), lists);
    }
    if (result == STP_OK) {
        const stp_store_large* large = *lists;
        *list = (stp_large_triangles){large->count, large->triangles, large->levels};
    }
    return result;
}

void stp_store_free_large(stp_store* store)
{
    for (uint32_t i = 0; store->large != NULL && i < store->directory.mesh_count; ++i) {
        free_large(store->context, store->large[i]);
    }
    stp_free(store->context, store->large);
    store->large = NULL;
}

uint32_t stp_large_triangles_find(const stp_large_triangles* list, float level)
{
    uint32_t band = level > 0.0f ? find_band(level) : UINT32_MAX, low = 0, high = list->count;
    while (low < high) {
        uint32_t middle = low + (high - low) / 2;
        if (find_band(list->levels[middle]) <= band) {
            low = middle + 1;
        } else {
            high = middle;
        }
    }
    return low;
}
