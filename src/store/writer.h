// SPDX-License-Identifier: MIT
//
// Writes a `.stip`: the directory first, then data coarse to fine, so that any prefix of the file
// is the whole scene. Written aside, synced, renamed.
#pragma once

#include "store/clusters.h"
#include "store/store.h"

/// Everything to be written. Counts of meshes etc. are those of `directory`.
struct stp_store_content {
    stp_store_directory directory;
    const stp_store_mesh* meshes;
    /// One a mesh; NULL, or entries without bytes: the mesh is written as floats. Where there are bytes, only
    /// name and material of the mesh are read, and its columns may be NULL.
    const stp_coded_mesh* coded_meshes;
    const stp_store_point_set* point_sets;
    const stp_store_texture* textures;
    const stp_splats* surfels;
    const stp_store_census* census; ///< NULL: guessed from nodes and objects
    // under which content keys they were made (all zero: none); NULL: none at all
    const stp_hash* surfel_keys;
    const stp_hash* mesh_keys;
    /// Called now and then while blocks are written: what they were read from may leave memory, if it can be read
    /// again. NULL: nothing can.
    void (*release_pages)(void* user);
    /// Optional. Called after writing and before the rename: false if the source data has changed, and
    /// the file is discarded.
    bool (*is_intact)(void* user);
    void* release_user; ///< of both
    bool passing;       ///< the file need not outlast a loss of power: nothing waits for the disk
};

/// Whether its methods must be told: there are others than `blue`.
bool stp_store_tells_methods(const stp_store_directory* directory);

/// @return STP_OK, STP_ERROR_IO, STP_ERROR_OUT_OF_MEMORY, STP_ERROR_ARGUMENT (content that no reader would
/// take) (logged; nothing of a former file is lost)
STP_MUST_USE stp_result stp_store_write(stp_context* context, const stp_store_content* content,
                                        const char* path);
