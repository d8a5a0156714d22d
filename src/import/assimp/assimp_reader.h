// SPDX-License-Identifier: MIT
//
// The parent's side of the stream (assimp_stream.h).
#pragma once

#include "import/assimp/assimp_stream.h"
#include "import/reading/surface.h"

typedef struct stp_assimp_reader {
    stp_import* import;
    stp_context* context;
    const unsigned char* at;
    const unsigned char* end;
    stp_pictures pictures;
    uint32_t* textures; ///< embedded textures, as indices in the scene; STP_NONE: not readable
    uint32_t texture_count;
    uint32_t* materials;
    uint32_t material_count;
    stp_part* parts; ///< part of each mesh; index STP_NONE: nothing
    uint32_t mesh_count;
    uint32_t* objects;  ///< object of each node
    double coarse_step; ///< largest step of the coordinates of meshes far from the origin; 0: none
} stp_assimp_reader;

/// Logs that `what` is invalid. @return STP_ERROR_FORMAT
stp_result stp_assimp_fail_stream(const stp_assimp_reader* r, const char* what);
/// The next `count` items of `size` bytes; NULL if the stream is too short.
const unsigned char* stp_assimp_take(stp_assimp_reader* r, size_t count, size_t size);
bool stp_assimp_take_value(stp_assimp_reader* r, void* value, size_t size);
/// A text in the scene's arena; *text is NULL if it is empty.
STP_MUST_USE stp_result stp_assimp_take_text(stp_assimp_reader* r, const char** text);
/// The count of a list whose items take at least `minimum` bytes each, limited by the rest of the
/// stream.
bool stp_assimp_take_count(stp_assimp_reader* r, size_t minimum, uint32_t* count);
/// A copy of `count` items owned by the caller; NULL with *result set on failure.
void* stp_assimp_take_copy(stp_assimp_reader* r, size_t count, size_t size, stp_result* result);

STP_MUST_USE stp_result stp_assimp_read_textures(stp_assimp_reader* r);
STP_MUST_USE stp_result stp_assimp_read_materials(stp_assimp_reader* r);
STP_MUST_USE stp_result stp_assimp_read_meshes(stp_assimp_reader* r);
