// SPDX-License-Identifier: MIT
//
// Constants of the `.stip` format; docs/format.md defines them.
#pragma once

#include <assert.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

/// Detects other files, files stripped to 7 bits, and files with converted line ends (as PNG does).
#define STP_STORE_MAGIC "\x89STP\r\n\x1a\n"

enum {
    STP_STORE_MAJOR = 1,
    STP_STORE_MINOR = 2,             ///< of files without levels
    STP_STORE_MINOR_LEVELS = 3,      ///< of files with levels
    STP_STORE_MINOR_GROWTHS = 4,     ///< of files with growths
    STP_STORE_MINOR_NORMAL_MAPS = 5, ///< of files with normal maps
    STP_STORE_MINOR_LIT = 6,         ///< of files with light normals
    STP_STORE_MINOR_COVERAGES = 2,   ///< since then, coverages are codes (base/splats/coverage.h)
    STP_STORE_MAGIC_BYTES = 8,
    STP_STORE_HEADER_BYTES = 128,
    STP_STORE_SECTION_BYTES = 40,
    STP_STORE_SECTION_LIMIT = 256, ///< the root directory fits in the first 16 KiB
    STP_STORE_ALIGNMENT = 64,      ///< alignment of sections and blocks, in bytes
    STP_STORE_COLUMN_ALIGNMENT = 16,
    STP_STORE_RECORD_LIMIT = 256, ///< version 1 has no longer record
    STP_STORE_PAGE_BYTES = 16384, ///< size of a page: the part of a section with its own checksum
    STP_STORE_TEXT_LIMIT = 4095,  ///< bytes of a text that a record refers to
    STP_STORE_TEXTURE_LIMIT = 65536,
    STP_STORE_SHADING_LIMIT = 256,
    STP_STORE_LEAF_BYTES = 16,
};

/// Section types. 33 is reserved for bone weights; types from 0x80000000 on are private.
typedef enum stp_store_section_type {
    STP_SECTION_NODES = 1,
    STP_SECTION_EDGES,
    STP_SECTION_PARTS,
    STP_SECTION_MATERIALS,
    STP_SECTION_SHADINGS,
    STP_SECTION_TEXTURES,
    STP_SECTION_MESHES,
    STP_SECTION_POINT_SETS,
    STP_SECTION_SPLAT_SETS,
    STP_SECTION_OCTAVES,
    STP_SECTION_BREAKPOINTS,
    STP_SECTION_VIEWS,
    STP_SECTION_SOURCES,
    STP_SECTION_BLOCKS,
    STP_SECTION_TEXT,
    STP_SECTION_BUILD,
    STP_SECTION_OBJECTS,
    STP_SECTION_OBJECT_TEXT,
    STP_SECTION_SUMMARY,
    STP_SECTION_SCENE_PARTS,
    STP_SECTION_PAGES,
    STP_SECTION_KEYS,
    STP_SECTION_CLUSTERS = 32,    ///< which meshes are coded; critical
    STP_SECTION_ATTRIBUTES = 34,  ///< statistics of point attributes
    STP_SECTION_METHODS = 35,     ///< methods of the file's sets; critical
    STP_SECTION_METHOD_NODES,     ///< nodes of the sets of all methods but the first; critical
    STP_SECTION_ATTRIBUTE_VALUES, ///< number of points in each class
    STP_SECTION_ATTRIBUTE_BLOCKS, ///< contents of attribute blocks
    STP_SECTION_COORDINATES,      ///< coordinate systems of sources
    STP_SECTION_LEAVES,           ///< leaves of sets
    STP_SECTION_CERTAINTY,        ///< accuracy of the points in sets
    STP_SECTION_LEVELS,           ///< nodes of the meshes that are levels
    STP_SECTION_LEVEL_CLUSTERS,   ///< when each cluster of a level is drawn
    STP_SECTION_LEVEL_GROUPS,     ///< spheres and errors that decide it
    STP_SECTION_LEVEL_FIGURES,    ///< how much levels are, for those who read no more
    STP_SECTION_SIDES,            ///< materials and shadings whose backs are not drawn
    STP_SECTION_GROWTHS,          ///< by how much splats of each shading are larger
    STP_SECTION_NORMAL_MAPS,      ///< which materials have normal maps
    STP_SECTION_END               ///< one more than the last known type
} stp_store_section_type;

enum {
    STP_SECTION_CRITICAL = 1, /**< readers that do not know the section must refuse the file */
    STP_SECTION_PACKED = 2,   /**< stored in compressed pages: store/bytes/packed.h */
};

typedef enum stp_store_block_kind {
    STP_BLOCK_MESH = 1,
    STP_BLOCK_POINT_SET,
    STP_BLOCK_TEXTURE,
    STP_BLOCK_SPLATS,
    STP_BLOCK_CLUSTERS,         ///< a coded mesh
    STP_BLOCK_ATTRIBUTES = 7,   ///< attributes of an octave of a splat set
    STP_BLOCK_POINT_ATTRIBUTES, ///< attributes of a point set
    STP_BLOCK_LEAVES,           ///< leaves of a splat set
    STP_BLOCK_END
} stp_store_block_kind;

/// Whether each block of a kind belongs to a record that names it. Kind 6 is reserved; section 38
/// lists attribute blocks.
static inline bool stp_store_knows_block(uint32_t kind)
{
    return (kind >= STP_BLOCK_MESH && kind <= STP_BLOCK_CLUSTERS) || kind == STP_BLOCK_LEAVES;
}

/// Optional columns of a mesh or point set.
enum {
    STP_COLUMN_NORMALS = 1,
    STP_COLUMN_COLORS = 2,
    STP_COLUMN_TEXCOORDS_0 = 4,
    STP_COLUMN_TEXCOORDS_1 = 8,
};

/// An entry of the root directory.
typedef struct stp_store_section {
    uint32_t type, flags;
    uint64_t offset, size, count;
    uint32_t record_size, crc;
} stp_store_section;

/// An entry of the block table.
typedef struct stp_store_block {
    uint32_t kind, owner, octave, crc;
    uint64_t offset, size;
    /// splats: radius that the prefix up to this block covers, in scene space; else 0
    float radius;
    uint32_t encoding;
} stp_store_block;

static inline uint64_t stp_store_align(uint64_t offset, uint64_t alignment)
{
    assert(alignment != 0 && (alignment & (alignment - 1)) == 0);
    return (offset + alignment - 1) & ~(alignment - 1);
}
