// SPDX-License-Identifier: MIT
//
// Writes a `.stip`: the directory first, then data from coarse to fine, so that any prefix of the
// file shows the whole scene. Writes a temporary file, syncs and renames it.
#pragma once

#include "store/clusters/clusters.h"
#include "store/file/store.h"

/// The input of the writer. Counts of meshes etc. are those of `directory`.
struct stp_store_content {
    stp_store_directory directory;
    const stp_store_mesh* meshes;
    /// One per mesh; NULL or entries without bytes: the mesh is written as floats. If there are
    /// bytes, only name, material and area of the mesh are read, and its columns may be NULL.
    const stp_coded_mesh* coded_meshes;
    const stp_store_point_set* point_sets;
    const stp_store_texture* textures;
    const stp_splats* sets;
    const stp_store_census* census; ///< NULL: guessed from nodes and objects
    // content keys (all zero: none); NULL: no keys at all
    const stp_hash* set_keys;
    const stp_hash* mesh_keys;
    /// Called occasionally while attributes are measured and blocks are written, so that memory that
    /// can be read again may be released. NULL: there is none.
    void (*release_pages)(void* user);
    /// Optional. Called after writing and before the rename. Returns false if the source data has
    /// changed; then the file is discarded.
    bool (*is_intact)(void* user);
    void* release_user; ///< passed to both callbacks
    bool passing;       ///< a temporary file that need not survive a power loss: no syncing
};

/// Whether the file must list its methods: it has others than `blue`.
bool stp_store_lists_methods(const stp_store_directory* directory);

/// @return STP_OK, STP_ERROR_IO, STP_ERROR_OUT_OF_MEMORY, STP_ERROR_ARGUMENT (invalid content),
/// STP_ERROR_LIMIT (too many blocks or breakpoints) (logged; an existing file stays unchanged)
STP_MUST_USE stp_result stp_store_write(stp_context* context, const stp_store_content* content,
                                        const char* path);
