// SPDX-License-Identifier: MIT
// The large arrays of meshes, point sets and textures: in memory, or in the scene's spill file.
#pragma once

#include "scene/scene.h"

typedef struct stp_bulk_array {
    void* bytes; ///< NULL: absent
    size_t size;
} stp_bulk_array;

/// Number of arrays per item. Points: positions, normals, colours, attributes.
enum {
    STP_MESH_ARRAYS = 6,
    STP_POINT_ATTRIBUTE_ARRAY = 3, ///< the first attribute's
    STP_POINT_ARRAYS = STP_POINT_ATTRIBUTE_ARRAY + STP_ATTRIBUTES,
    STP_TEXTURE_ARRAYS = 2,
};

// The arrays of an item in a fixed order, and back for meshes and points.
void stp_mesh_get_arrays(const stp_mesh* mesh, stp_bulk_array arrays[STP_MESH_ARRAYS]);
void stp_mesh_set_arrays(stp_mesh* mesh, const stp_bulk_array arrays[STP_MESH_ARRAYS]);
void stp_points_get_arrays(const stp_point_set* points, stp_bulk_array arrays[STP_POINT_ARRAYS]);
void stp_points_set_arrays(stp_point_set* points, const stp_bulk_array arrays[STP_POINT_ARRAYS]);
/// Texels first, then the encoded picture.
void stp_texture_get_arrays(const stp_texture* texture, stp_bulk_array arrays[STP_TEXTURE_ARRAYS]);

uint64_t stp_mesh_bytes(const stp_mesh* mesh);
uint64_t stp_points_bytes(const stp_point_set* points);
uint64_t stp_texture_bytes(const stp_texture* texture);

// Free arrays in memory and subtract them from the scene's count.
void stp_mesh_free_arrays(stp_scene* scene, stp_mesh* mesh);
void stp_points_free_arrays(stp_scene* scene, stp_point_set* points);
void stp_texture_free_arrays(stp_scene* scene, stp_texture* texture);

// Count a new item and move it to the spill if too much is in memory. Content already in the spill
// is not written again. @return STP_OK, STP_ERROR_IO, STP_ERROR_OUT_OF_MEMORY (logged); the item is
// valid in any case
STP_MUST_USE stp_result stp_mesh_account(stp_scene* scene, uint32_t index);
STP_MUST_USE stp_result stp_points_account(stp_scene* scene, uint32_t index);
STP_MUST_USE stp_result stp_texture_account(stp_scene* scene, uint32_t index);

/// Allocates all arrays in one block of the spill.
/// @return STP_OK or STP_ERROR_IO (logged; nothing changed). Any thread.
STP_MUST_USE stp_result stp_bulk_alloc_spilled(stp_spill* spill, stp_bulk_array* arrays,
                                               size_t count);
