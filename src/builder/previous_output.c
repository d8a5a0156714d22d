// SPDX-License-Identifier: MIT
#include "builder/stored_levels.h"
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

/// Finds the mesh of a level of a node by its key, which tells the shading.
static bool find_level(stp_previous_output* previous, stp_hash key, uint32_t index,
                       uint32_t shading_count, stp_store_stored_mesh* found, uint8_t* shading)
{
    for (uint32_t s = 0; s < shading_count; ++s) {
        *shading = (uint8_t)s;
        if (stp_store_find_mesh_by_key(previous->store, stp_level_key(key, index, *shading),
                                       found) != STP_OK) {
            return false;
        }
        if (found->index != STP_STORE_NONE) {
            return true;
        }
    }
    return false;
}

/// Reads a level. @return false unless it is level `mesh` of the file, and intact
static bool take_level(stp_previous_output* previous, stp_hash key, uint32_t index, uint32_t mesh,
                       uint32_t shading_count, stp_node_levels* levels, stp_coded_mesh* coded)
{
    const stp_store_directory* d = stp_store_get_directory(previous->store);
    const stp_store_level* from = &d->levels[mesh - stp_store_first_level_mesh(d)];
    stp_node_level* to = &levels->levels[index];
    stp_store_stored_mesh found;
    stp_clusters clusters;
    if (!find_level(previous, key, index, shading_count, &found, &to->shading) ||
        found.index != mesh || stp_clusters_open(found.block, found.size, &clusters) != NULL ||
        clusters.cluster_count != from->cluster_count) {
        return false;
    }
    to->clusters =
        STP_NEW_ARRAY(previous->quiet, stp_node_level_cluster, (size_t)from->cluster_count + 1);
    to->cluster_count = from->cluster_count;
    for (uint32_t i = 0; i < from->cluster_count && to->clusters != NULL; ++i) {
        const stp_store_level_cluster* c = &d->level_clusters[from->first_cluster + i];
        to->clusters[i] = (stp_node_level_cluster){
            .made_by = c->made_by, .used_by = c->used_by, .one_sided = c->one_sided};
    }
    *coded = stp_clusters_describe(&clusters);
    levels->from_outside = (from->flags & STP_LEVEL_FROM_OUTSIDE) != 0;
    return to->clusters != NULL;
}

/// Reads the groups that the clusters name, and numbers them from 0: the writer keeps those of a
/// node together, and no others. @return false if the file's are not so, or memory runs out
static bool take_groups(stp_previous_output* previous, stp_node_levels* levels)
{
    const stp_store_directory* d = stp_store_get_directory(previous->store);
    uint32_t first = STP_STORE_NONE, end = 0;
    uint64_t clusters = 0;
    for (int pass = 0; pass < 2; ++pass) {
        for (uint32_t i = 0; i < levels->level_count; ++i) {
            clusters += pass == 0 ? levels->levels[i].cluster_count : 0;
            for (uint32_t k = 0; k < levels->levels[i].cluster_count; ++k) {
                stp_node_level_cluster* c = &levels->levels[i].clusters[k];
                uint32_t* groups[2] = {&c->made_by, &c->used_by};
                for (int g = 0; g < 2; ++g) {
                    uint32_t group = *groups[g];
                    if (group == STP_STORE_NONE) {
                        continue;
                    }
                    first = pass == 0 && group < first ? group : first;
                    end = pass == 0 && group >= end ? group + 1 : end;
                    *groups[g] = pass == 1 ? group - first : group;
                }
            }
        }
    }
    levels->group_count = first < end ? end - first : 0;
    if (levels->group_count > 2 * clusters) {
        levels->group_count = 0;
        return false;
    }
    levels->groups =
        STP_NEW_ARRAY(previous->quiet, stp_level_group, (size_t)levels->group_count + 1);
    for (uint32_t i = 0; i < levels->group_count && levels->groups != NULL; ++i) {
        const stp_store_level_group* g = &d->level_groups[first + i];
        levels->groups[i] = (stp_level_group){
            .center = {(double)g->center[0], (double)g->center[1], (double)g->center[2]},
            .radius = (double)g->radius,
            .error = (double)g->error};
    }
    return levels->groups != NULL;
}

bool stp_previous_output_take_levels(stp_previous_output* previous, stp_hash key,
                                     uint32_t shading_count, stp_work* work)
{
    const stp_store_directory* d = stp_store_get_directory(previous->store);
    stp_store_stored_mesh found;
    uint8_t shading;
    if (d->level_count == 0 || !find_level(previous, key, 0, shading_count, &found, &shading) ||
        found.index < stp_store_first_level_mesh(d)) {
        return false;
    }
    uint32_t first = found.index - stp_store_first_level_mesh(d), node = d->levels[first].node;
    if (first != d->level_starts[node]) {
        return false;
    }
    stp_node_levels levels = {.level_count = d->level_starts[node + 1] - d->level_starts[node]};
    levels.levels = STP_NEW_ZEROED(previous->quiet, stp_node_level, levels.level_count);
    stp_coded_mesh* coded = STP_NEW_ARRAY(previous->quiet, stp_coded_mesh, levels.level_count);
    bool good = levels.levels != NULL && coded != NULL;
    for (uint32_t i = 0; i < levels.level_count && good; ++i) {
        good = take_level(previous, key, i, found.index + i, shading_count, &levels, &coded[i]);
    }
    good = good && take_groups(previous, &levels) &&
           stp_work_store_coded_levels(previous->quiet, work, key, &levels, coded) == STP_OK;
    levels.level_count = levels.levels != NULL ? levels.level_count : 0;
    stp_node_levels_destroy(previous->quiet, &levels);
    stp_free(previous->quiet, coded);
    return good;
}
