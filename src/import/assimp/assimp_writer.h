// SPDX-License-Identifier: MIT
//
// Functions by which the child process writes assimp's scene (assimp_stream.h).
#pragma once

#include "import/assimp/assimp_stream.h"

#include <assimp/scene.h>

#define STP_ASSIMP_BUFFER_SIZE ((size_t)1 << 16)

typedef struct stp_assimp_writer {
    int descriptor;
    int failed;
    size_t used;
    const struct aiScene* scene;
    int bumps; ///< whether assimp says "normals" for maps of heights, as for <bump> of Collada
    uint32_t heights; ///< maps of heights so far, which are left out
    unsigned char buffer[STP_ASSIMP_BUFFER_SIZE];
} stp_assimp_writer;

/// Appends bytes. After a failure, nothing more is written.
void stp_assimp_put(stp_assimp_writer* w, const void* bytes, size_t size);
void stp_assimp_put_u32(stp_assimp_writer* w, uint32_t value);
/// Longer texts are truncated.
void stp_assimp_put_text(stp_assimp_writer* w, const char* text, size_t length);
void stp_assimp_put_string(stp_assimp_writer* w, const struct aiString* string);

void stp_assimp_put_texture(stp_assimp_writer* w, const struct aiTexture* texture);
void stp_assimp_put_material(stp_assimp_writer* w, const struct aiMaterial* material);
/// All nodes below a root, parents first.
void stp_assimp_put_nodes(stp_assimp_writer* w);
/// A camera, in the space of the scene.
void stp_assimp_put_view(stp_assimp_writer* w, const struct aiCamera* camera);
