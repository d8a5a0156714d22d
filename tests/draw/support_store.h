// SPDX-License-Identifier: MIT
// Small handmade scenes, written to a temporary file and opened.
#pragma once

#include "store/writer/writer.h"

enum { MADE_LIMIT = 16 };

/// Fill the arrays and counts (they become the directory's), then call made_open().
typedef struct made_scene {
    stp_store_node nodes[MADE_LIMIT];
    stp_store_edge edges[MADE_LIMIT];
    stp_store_part parts[MADE_LIMIT];
    stp_store_material materials[MADE_LIMIT];
    stp_shading shadings[MADE_LIMIT];
    stp_store_texture textures[MADE_LIMIT];
    stp_store_mesh meshes[MADE_LIMIT];
    stp_store_point_set point_sets[MADE_LIMIT];
    stp_splats sets[MADE_LIMIT];
    stp_store_view views[MADE_LIMIT];
    uint32_t node_count, edge_count, part_count, material_count, shading_count, texture_count,
        mesh_count, point_set_count, set_count, view_count;
    stp_store_method method;            ///< the method of all sets; id 0: blue
    const stp_coded_mesh* coded_meshes; ///< one per mesh; NULL: none
} made_scene;

/// A white, rough, opaque material without textures.
stp_store_material made_material(void);

/// A square of two triangles in the plane z = 0, from -1 to 1, with texture coordinates (v down),
/// facing +z. Memory is static.
stp_store_mesh made_square(uint32_t material);

/// Splats on the front of that square: a grid of 2^log_side on each side, ordered so that every
/// prefix of 4^k is evenly spread; with prefix table and colours (all `color`). The arrays come from
/// `context` (free them with made_free_set).
stp_splats made_square_set(stp_context* context, uint32_t log_side, const uint8_t color[3]);
void made_free_set(stp_context* context, stp_splats* splats);

/// Makes the scene one node over the square from -1 to 1 with a nominal million triangles: the
/// mesh, with a set of `spt`.
void made_one_node(made_scene* scene, const stp_store_mesh* mesh, const stp_splats* set);

/// Writes and opens the scene; the last node is the root. NULL on failure.
stp_store* made_open(stp_context* context, made_scene* scene);
/// The same; `file` receives a descriptor of the file, to read and write, which the caller closes.
stp_store* made_open_file(stp_context* context, made_scene* scene, int* file);
/// Bytes of the file of a scene; free them. NULL on failure.
unsigned char* made_file_bytes(stp_context* context, made_scene* scene, size_t* size);
