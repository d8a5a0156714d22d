// SPDX-License-Identifier: MIT
// glTF files: writing them, their layout before they are written, and their JSON.
#pragma once

#include "base/io/file.h"
#include "scene/scene.h"

// Writes a scene as glTF 2.0: meshes once, objects with their names as nodes, views as cameras.
// glTF cannot share nodes, so used objects are duplicated; instances of one mesh become
// EXT_mesh_gpu_instancing. Materials are plain, without textures. Points are not supported.

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

// The layout, made before anything is written.

/// A node of the file, in file order: parents come first, siblings are adjacent.
typedef struct gltf_node {
    uint32_t object;
    uint32_t instance;    ///< shows only this instance of its parts; STP_NONE: the object
    uint32_t content;     ///< object whose parts it shows; STP_NONE: none
    uint32_t first_child; ///< index of the node of its first child
    uint32_t child_count;
    bool part_only; ///< shows only parts of a used object, without a transform of its own
} gltf_node;

typedef enum gltf_region { GLTF_VERTICES, GLTF_COLORS, GLTF_INDICES, GLTF_REGIONS } gltf_region;

/// A mesh in the file. Offsets count from the start of the region in its buffer.
typedef struct gltf_mesh {
    uint32_t buffer, first_accessor;
    uint64_t offsets[GLTF_REGIONS];
    uint32_t index_bytes; ///< 2 or 4
} gltf_mesh;

typedef struct gltf_buffer {
    uint64_t sizes[GLTF_REGIONS]; ///< each a multiple of 4
    uint32_t first_view;
} gltf_buffer;

typedef struct gltf_plan {
    const stp_scene* scene;
    gltf_node* nodes;
    size_t node_count, node_capacity, root_count;
    uint32_t* first_child; ///< by object; STP_NONE ends a list, here and in next_sibling
    uint32_t* next_sibling;
    gltf_mesh* meshes;
    uint32_t* mesh_of_object; ///< by object: mesh in the file; STP_NONE: none
    uint32_t* lists;          ///< objects whose part lists become meshes after the scene's own
    size_t list_count;
    gltf_buffer* buffers;
    size_t buffer_count, buffer_capacity;
    uint32_t accessor_count, view_count;
    /// By object: the first of its three accessors; STP_NONE: the extension is not used
    uint32_t* instance_accessor;
    uint64_t instance_count; ///< in the last buffer, after its regions; 40 bytes each
} gltf_plan;

STP_MUST_USE stp_result gltf_plan_make(const stp_scene* scene, uint64_t most_buffer_bytes,
                                       const char* path, gltf_plan* plan);
void gltf_plan_destroy(gltf_plan* plan);

uint64_t gltf_buffer_bytes(const gltf_plan* plan, size_t buffer);

/// Decomposes into translation, rotation (x, y, z, w) and scale; false if not possible.
bool gltf_decompose(const stp_affine* affine, float translation[3], float rotation[4],
                    float scale[3]);

/// The instances' three views in the last buffer: translations, rotations, scales.
static inline uint32_t gltf_instance_view(const gltf_plan* plan)
{
    return plan->view_count - 3;
}

// The JSON of a glTF file.

/// Appends the JSON. `name`: prefix of the binary files ("plant.bin" is "plant"); NULL: the only
/// buffer is in the same file.
STP_MUST_USE stp_result gltf_json_write(const gltf_plan* plan, const char* name,
                                        stp_file_writer* file);

/// The name of a binary file: NAME.bin, NAME-2.bin, ...
void gltf_buffer_name(char* out, size_t size, const char* name, size_t buffer);
