// SPDX-License-Identifier: MIT
//
// Writes a scene as glTF 2.0: meshes once, objects with their names as nodes, views as cameras.
// glTF cannot share nodes, so used objects are duplicated; instances of one mesh become
// EXT_mesh_gpu_instancing. Materials are plain, without textures. Points are not supported.
#pragma once

#include "scene/scene.h"

/// Maximum nodes of a file: nested uses can expand without bound.
#define GLTF_MOST_NODES 3000000u

typedef struct gltf_figures {
    uint64_t nodes, meshes, triangles, bytes;
    uint32_t files;
} gltf_figures;

/// Writes `path`: a single file if the name ends in .glb, else JSON with binary files beside it,
/// named after PATH without its suffix: .bin, -2.bin, ... All files are temporary until the end,
/// then renamed. The scene need not be finished. `figures` may be NULL.
/// @return STP_OK, STP_ERROR_LIMIT (too many nodes, or too large for .glb), STP_ERROR_UNSUPPORTED
/// (points, or a mesh without triangles), STP_ERROR_IO, STP_ERROR_OUT_OF_MEMORY,
/// STP_ERROR_CANCELLED; logged
STP_MUST_USE stp_result gltf_file_write(const stp_scene* scene, const char* path,
                                        gltf_figures* figures);
