// SPDX-License-Identifier: MIT
//
// The records of the directory's tables. One function per record kind serves reading and writing,
// so that the two cannot disagree.
#pragma once

#include "store/bytes/format.h"
#include "store/file/normal_maps.h"
#include "store/file/point_attributes.h"
#include "store/file/sides.h"

/// Zero-terminated texts, one after the other; records refer to them by offset.
typedef struct stp_store_text {
    stp_context* context;
    char* bytes;        ///< while writing: growing
    const char* stored; ///< while reading: the first text; the store owns the bytes
    size_t size, capacity;
    bool checked;        ///< while reading: all bytes are present and verified
    uint64_t uses, used; ///< while reading: number of uses by records, and their total bytes
} stp_store_text;

/// Counts the use of the text at `at` in `text->stored` by a record. Limits the total, because a
/// long text shared by many records would cost time and memory out of proportion to the file.
/// @return NULL, or the error: the text is too long, or all uses together are
const char* stp_store_use_text(stp_store_text* text, const char* at);

/// A record during conversion from or to bytes.
typedef struct stp_store_codec {
    const unsigned char* input; ///< NULL while writing
    unsigned char* output;
    size_t offset;
    stp_store_text* text;
    const char* fault; ///< the first fault of the record: "has a number that is not finite"
    stp_result result; ///< failure to add a text
} stp_store_codec;

typedef struct stp_store_mesh_record {
    stp_store_mesh mesh; ///< its columns are NULL until verified
    uint32_t present, block;
    bool checked;
} stp_store_mesh_record;

/// One per mesh, if any mesh is coded.
typedef struct stp_store_clusters_record {
    uint32_t cluster_count; ///< STP_STORE_NONE: the mesh is not coded
    stp_clusters clusters;  ///< without bytes until verified
} stp_store_clusters_record;

typedef struct stp_store_point_record {
    stp_store_point_set points;
    uint32_t present, block; ///< block: STP_STORE_NONE if a set of splats holds the points
    bool checked;
    void* made; ///< owned: columns made from such a set; NULL: none
    /// owned: replacement colours; NULL: the file's own. With a residency, part of its memory
    uint8_t* colored;
} stp_store_point_record;

typedef struct stp_store_texture_record {
    stp_store_texture texture; ///< `texels` is NULL until verified; `encoding` is the block's
    uint32_t block;            ///< can be shared with earlier textures
    bool checked;
    /// Owned by the first texture with this block: texels of its picture; NULL: not decoded.
    uint8_t* decoded;
} stp_store_texture_record;

/// Memory of a set's columns; src/store/sets/join_octaves.c.
typedef struct stp_store_joined stp_store_joined;

typedef struct stp_store_set_record {
    stp_splats splats;
    uint32_t first_octave, first_breakpoint;
    uint32_t whole;           ///< number of complete octaves in the file
    uint32_t ready;           ///< number of octaves verified and joined in the columns
    stp_store_joined* joined; ///< memory of the columns
} stp_store_set_record;

/// The content key of a set or mesh.
typedef struct stp_store_key {
    stp_hash hash; ///< all zero: none
} stp_store_key;

/// A method's record.
typedef struct stp_store_method_record {
    stp_store_method method; ///< `sets` is made by the reader
} stp_store_method_record;

/// The leaves of a set.
typedef struct stp_store_leaves_record {
    uint32_t leaf_count; ///< 0: it has none
    uint32_t block;
    stp_store_leaves leaves; ///< none until verified
    void* memory;            ///< owned; NULL: a residency owns them
} stp_store_leaves_record;

/// Accuracy of the points in a set.
typedef struct stp_store_certainty {
    uint32_t flags;       ///< STP_CERTAINTY_*
    float position_error; ///< scene units; 0: unknown
} stp_store_certainty;

enum { STP_CERTAINTY_UNKNOWN_SIGNS = 1 };

/// The contents of an attribute block.
typedef struct stp_store_attribute_block {
    uint32_t block;
    uint32_t attributes; ///< bit mask
} stp_store_attribute_block;

typedef struct stp_store_coordinates {
    const char* text; ///< NULL: unknown
} stp_store_coordinates;

typedef struct stp_store_octave {
    uint32_t end, block;
} stp_store_octave;

typedef struct stp_store_breakpoint {
    uint32_t count;
    float radius;
} stp_store_breakpoint;

/// A kind of table: the layout of its records in the file and in memory.
typedef struct stp_store_table {
    const char* name; ///< name of one record, for messages; NULL: not a table of records
    uint32_t record_size;
    size_t element_size;
    void (*code)(stp_store_codec* codec, void* element);
} stp_store_table;

/// Memory for one element of any table.
typedef union stp_store_element {
    stp_store_node node;
    stp_store_edge edge;
    stp_store_part part;
    stp_store_material material;
    stp_shading shading;
    stp_store_texture_record texture;
    stp_store_mesh_record mesh;
    stp_store_point_record points;
    stp_store_set_record set;
    stp_store_octave octave;
    stp_store_breakpoint breakpoint;
    stp_store_view view;
    stp_store_source source;
    stp_store_block block;
    stp_store_object object;
    stp_store_summary summary;
    stp_store_scene_part scene_part;
    stp_store_key key;
    uint32_t page; ///< checksum
    stp_store_clusters_record clusters;
    stp_store_method_record method;
    uint32_t method_node;
    stp_store_leaves_record leaves;
    stp_store_attribute attribute;
    stp_store_attribute_value attribute_value;
    stp_store_attribute_block attribute_block;
    stp_store_coordinates coordinates;
    stp_store_certainty certainty;
    float growth;
    stp_store_level level;
    stp_store_level_cluster level_cluster;
    stp_store_level_group level_group;
    stp_store_level_figures level_figures;
    stp_store_sides sides;
    stp_store_normal_map normal_map;
} stp_store_element;

/// By section type; all 0 for unknown types. Sections of texts have no name and no `code`.
const stp_store_table* stp_store_table_of(uint32_t type);

/// The entries of the root directory.
void stp_store_code_section(stp_store_codec* codec, stp_store_section* section);
