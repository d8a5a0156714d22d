// SPDX-License-Identifier: MIT
// What a file is made of, before it is written.
#pragma once

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
