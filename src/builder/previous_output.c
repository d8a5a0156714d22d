// SPDX-License-Identifier: MIT
#include "builder/stored_results.h"
#include "store/file/point_attributes.h"

#include <string.h>
#include <sys/stat.h>

struct stp_previous_output {
    stp_context* quiet; ///< separate, without messages
    stp_store* store;
};

stp_previous_output* stp_previous_output_open(const char* path)
{
    struct stat status;
    stp_context* quiet = NULL;
    if (stat(path, &status) != 0 || !S_ISREG(status.st_mode) ||
        stp_context_create(&quiet, &(stp_context_desc){.thread_count = 1}) != STP_OK) {
        return NULL;
    }
    stp_previous_output* previous = STP_NEW_ZEROED(quiet, stp_previous_output, 1);
    stp_store_open_desc desc = {.defer_objects = true};
    if (previous == NULL || stp_store_open_with(quiet, path, &desc, &previous->store) != STP_OK) {
        stp_free(quiet, previous);
        stp_context_destroy(quiet);
        return NULL;
    }
    previous->quiet = quiet;
    return previous;
}

void stp_previous_output_close(stp_previous_output* previous)
{
    if (previous != NULL) {
        stp_context* quiet = previous->quiet;
        stp_store_close(previous->store);
        stp_free(quiet, previous);
        stp_context_destroy(quiet);
    }
}

// Reads the attributes of a set into separate memory.
static bool take_attributes(stp_previous_output* previous, uint32_t index, stp_splats* set)
{
    uint32_t mask = set->count != 0 ? stp_store_octave_attributes(previous->store, index, 0) : 0;
    for (uint32_t a = 0; a < STP_ATTRIBUTES; ++a) {
        if ((mask & stp_attribute_bit((stp_attribute)a)) == 0) {
            continue;
        }
        set->attributes[a] =
            stp_alloc_array(previous->quiet, set->count, stp_attribute_size((stp_attribute)a));
        if (set->attributes[a] == NULL ||
            stp_store_get_values(previous->store, index, (stp_attribute)a, 0, set->count,
                                 set->attributes[a]) != STP_OK) {
            return false;
        }
    }
    return true;
}

// Copies the leaves of a set. @return memory to free, even if it has none; NULL on failure
static stp_splat_leaf* take_leaves(stp_previous_output* previous, uint32_t index, stp_splats* set)
{
    stp_store_leaves leaves;
    if (stp_store_get_leaves(previous->store, index, &leaves) != STP_OK) {
        return NULL;
    }
    stp_splat_leaf* copied =
        stp_alloc_array(previous->quiet, (size_t)leaves.leaf_count + 1, sizeof(*copied));
    if (copied != NULL && leaves.leaf_count > 0) {
        memcpy(copied, leaves.leaves, leaves.leaf_count * sizeof(*copied));
    }
    set->leaf_count = leaves.leaf_count;
    set->leaves = copied;
    return copied;
}

bool stp_previous_output_take_splat_set(stp_previous_output* previous, stp_hash key,
                                        uint32_t shading_count, stp_work* work, stp_splats* splats)
{
    stp_store_stored_splat_set found;
    stp_splats columns;
    if (stp_store_find_splat_set_by_key(previous->store, key, &found) != STP_OK ||
        found.index == STP_STORE_NONE ||
        stp_store_get_splat_set(previous->store, found.index, &columns) != STP_OK) {
        return false;
    }
    uint32_t candidates;
    stp_splat_leaf* copied = NULL;
    bool taken = take_attributes(previous, found.index, &columns) &&
                 (copied = take_leaves(previous, found.index, &columns)) != NULL &&
                 stp_work_store_splat_set(work, key, &columns, 0, splats) == STP_OK &&
                 stp_work_find_splat_set(work, key, shading_count, splats, &candidates);
    for (int i = 0; i < STP_ATTRIBUTES; ++i) {
        stp_free(previous->quiet, columns.attributes[i]);
    }
    stp_store_release_splat_set(previous->store, found.index);
    stp_free(previous->quiet, copied);
    return taken;
}

bool stp_previous_output_take_mesh(stp_previous_output* previous, stp_hash key, stp_work* work,
                                   stp_coded_mesh* mesh)
{
    stp_store_stored_mesh found;
    stp_clusters clusters;
    if (stp_store_find_mesh_by_key(previous->store, key, &found) != STP_OK ||
        found.index == STP_STORE_NONE ||
        stp_clusters_open(found.block, found.size, &clusters) != NULL) {
        return false;
    }
    stp_coded_mesh coded = stp_clusters_describe(&clusters);
    return stp_work_store_mesh(work, key, &coded, mesh) == STP_OK;
}
