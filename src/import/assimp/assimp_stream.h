// SPDX-License-Identifier: MIT
//
// A private stream from the child process that runs assimp (assimp_child.c) to its parent
// (assimp_reader.c), in the machine's byte order. Untrusted input may make assimp write anything,
// so the stream is checked like a file.
//
//   stream    magic, refusals, then either  FAILED, text
//             or  SCENE, up, unit, textures, materials, meshes, nodes, views, losses, END
//   refusals  u32: 0, 1 or 2 (several) files that the model must not name; if any: text of the
//             first, text why
//   a list    u32 count, then its items; a text: u32 length (at most STP_ASSIMP_TEXT_LIMIT), bytes
//   texture   text name, u32 width, u32 height, bytes: RGBA; height 0: a picture file of `width`
//             bytes
//   material  text name, stp_assimp_material, three uses (base colour, emissive, normals)
//   a use     u32 source, u32 index (of an embedded texture), text path, stp_assimp_use
//   mesh      text name, stp_assimp_mesh, positions, normals, texcoords, colours, indices as its
//             flags say
//   node      text name, u32 parent, u32 flags, f64 transform[3][4], list of u32 meshes
//   view      text name, f64 eye[3], target[3], up[3], fov
//   losses    u32 animations, skins, morph targets, line meshes, lights, maps of heights
//             (stp_assimp_losses)
#pragma once

#include "import/reading/import.h"

#define STP_ASSIMP_MAGIC UINT32_C(0x53545031)
#define STP_ASSIMP_SCENE UINT32_C(0x4e454353)
#define STP_ASSIMP_FAILED UINT32_C(0x4c494146)
#define STP_ASSIMP_END UINT32_C(0x21444e45)
/// Instead of an axis: assimp has turned the file's z up to y
#define STP_ASSIMP_TURNED_Z UINT32_C(0x5a)
#define STP_ASSIMP_TEXT_LIMIT UINT32_C(4096)

typedef enum stp_assimp_source {
    STP_ASSIMP_NO_TEXTURE,
    STP_ASSIMP_EMBEDDED,
    STP_ASSIMP_PATH,
} stp_assimp_source;

typedef struct stp_assimp_material {
    float base_color[4], metallic, roughness, emissive[3];
    uint32_t masked; ///< the base colour's alpha cuts out
} stp_assimp_material;

typedef struct stp_assimp_use {
    uint32_t texcoord, wrap_u, wrap_v;
    float scale[2], offset[2];
} stp_assimp_use;

enum {
    STP_ASSIMP_NORMALS = 1,
    STP_ASSIMP_TEXCOORDS_0 = 2,
    STP_ASSIMP_TEXCOORDS_1 = 4,
    STP_ASSIMP_COLORS = 8, ///< 4 floats, sRGB
    STP_ASSIMP_POINTS = 16,
};

typedef struct stp_assimp_mesh {
    uint32_t material, flags, vertex_count, triangle_count;
} stp_assimp_mesh;

/// Content of the scene that is not kept.
typedef struct stp_assimp_losses {
    uint32_t animations, skins, morphs, lines, lights, heights;
} stp_assimp_losses;

/// Adds the content of a stream to the scene. @return STP_OK; STP_ERROR_FORMAT if assimp failed or
/// the stream is invalid; STP_ERROR_OUT_OF_MEMORY, also if assimp ran out of memory (each logged)
STP_MUST_USE stp_result stp_assimp_read_stream(stp_import* import, const unsigned char* bytes,
                                               size_t size);

/// Address space that the child may use in addition to what it inherits.
static inline uint64_t stp_assimp_memory_limit(const stp_import* import)
{
    uint64_t asked = import->desc.helper_memory_bytes;
    return asked != 0 ? asked : (uint64_t)4 << 30;
}

/// Reports that this is not enough. @return STP_ERROR_OUT_OF_MEMORY (logged)
stp_result stp_assimp_fail_memory(const stp_import* import);

/// The child's work: imports a model from memory and writes the stream to `descriptor`. Reads other
/// files only as path_rules.h allows, and none if `alone`. Uses no context, because in a forked
/// process locks of other threads may be held forever. @return the child's exit code
int stp_assimp_run_child(const char* path, const unsigned char* bytes, size_t size, bool alone,
                         int descriptor);
