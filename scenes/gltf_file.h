// SPDX-License-Identifier: MIT
//
// A scene as a glTF 2.0 file: meshes once, objects with their names as nodes, views as cameras. glTF cannot share
// a node, so what objects use of others is written out; instances of one mesh become EXT_mesh_gpu_instancing.
// Materials are plain, without textures. Points are not written.
#pragma once

#include "scene/scene.h"

/// Most nodes of a file: what uses of uses expand to may be without bound.
#define GLTF_MOST_NODES 3000000u

typedef struct gltf_figures {
    uint64_t nodes, meshes, triangles, bytes;
    uint32_t files;
} gltf_figures;

/// Writes `path`: one file where the name ends in .glb, else JSON and the binary files PATH without its ending and
/// with .bin, -2.bin, ... beside it. Everything is written aside and renamed at the end. The scene need not be
/// finished. `figures` may be NULL.
/// @return STP_OK, STP_ERROR_LIMIT (too many nodes, or more than a .glb can hold), STP_ERROR_UNSUPPORTED (points,
/// or a mesh without triangles), STP_ERROR_IO, STP_ERROR_OUT_OF_MEMORY, STP_ERROR_CANCELLED; logged
STP_MUST_USE stp_result gltf_file_write(const stp_scene* scene, const char* path,
                                        gltf_figures* figures);
