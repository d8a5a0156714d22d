// SPDX-License-Identifier: MIT
//
// The records of the directory's tables. One function describes each kind of record and serves both
// ways, so that reader and writer cannot disagree.
#pragma once

#include "base/hash.h"
#include "store/attributes.h"
#include "store/clusters.h"
#include "store/format.h"
#include "store/leaves.h"
#include "store/store.h"

/// Texts one after the other, each ended by a zero byte; records refer to them by offset.
typedef struct stp_store_text {
    stp_context* context;
    char* bytes;        ///< while writing: grown as needed
    const char* stored; ///< while reading: straight from the file
    size_t size, capacity;
    bool checked;        ///< while reading: all bytes are there, and right
    uint64_t uses, used; ///< while reading: texts that records used, and their bytes in all
} stp_store_text;

/// Notes that a record uses the text at `at`, which lies in `text->stored`. A text of many bytes that many records
/// share would cost time and memory out of proportion to the file.
/// @return NULL, or what is wrong with it: it is too long, or all uses together are
const char* stp_store_use_text(stp_store_text* text, const char* at);

/// One record on its way from or to bytes.
typedef struct stp_store_codec {
    const unsigned char* input; ///< NULL while writing
    unsigned char* output;
    size_t offset;
    stp_store_text* text;
    const char* fault; ///< the first thing wrong with the record: "has a number that is not finite"
    stp_result result; ///< why a text could not be added
} stp_store_codec;

typedef struct stp_store_mesh_record {
    stp_store_mesh mesh; ///< its columns are NULL until they are checked
    uint32_t present, block;
    bool checked;
} stp_store_mesh_record;

/// Of each mesh, where any is coded.
typedef struct stp_store_clusters_record {
    uint32_t cluster_count; ///< STP_STORE_NONE: the mesh is not coded
    stp_clusters clusters;  ///< without bytes until they are checked
} stp_store_clusters_record;

typedef struct stp_store_point_record {
    stp_store_point_set points;
    uint32_t present, block; ///< block: STP_STORE_NONE where a set of splats holds the points
    bool checked;
    void* made; ///< owned: columns made of such a set; NULL: none
    uint8_t*
        colored; ///< owned: colours that are not the file's; NULL: they are. Of a residency, its memory's
} stp_store_point_record;

typedef struct stp_store_texture_record {
    stp_store_texture texture; ///< `texels` is NULL until it is checked; `encoding` is the block's
    uint32_t block;            ///< perhaps shared with earlier textures
    bool checked;
    uint8_t*
        decoded; ///< owned; of the first texture with this block: the picture's texels; NULL: not decoded
} stp_store_texture_record;

/// Memory of a set's columns; src/store/octaves.c.
typedef struct stp_store_joined stp_store_joined;

typedef struct stp_store_surfels_record {
    stp_splats surfels;
    uint32_t first_octave, first_breakpoint;
    uint32_t whole;           ///< octaves whose blocks the file holds whole: its first ones
    uint32_t ready;           ///< octaves checked and joined in the columns
    stp_store_joined* joined; ///< memory of the columns
} stp_store_surfels_record;

/// Under which a set or mesh was made.
typedef struct stp_store_key {
    stp_hash hash; ///< all zero: none
} stp_store_key;

/// A method as the file says it.
typedef struct stp_store_method_record {
    stp_store_method method; ///< `sets` is made by the reader
} stp_store_method_record;

/// The leaves of a set.
typedef struct stp_store_leaves_record {
    uint32_t leaf_count; ///< 0: it has none
    uint32_t block;
    stp_store_leaves leaves; ///< none until they are checked
    void* memory;            ///< of them; NULL: they are a residency's
} stp_store_leaves_record;

/// How certain what a set has of points is.
typedef struct stp_store_certainty {
    uint32_t flags;       ///< STP_CERTAINTY_*
    float position_error; ///< scene units; 0: not known
} stp_store_certainty;

enum { STP_CERTAINTY_UNKNOWN_SIGNS = 1 };

/// What a block of attributes holds.
typedef struct stp_store_attribute_block {
    uint32_t block;
    uint32_t attributes; ///< a bit each
} stp_store_attribute_block;

typedef struct stp_store_coordinates {
    const char* text; ///< NULL: not known
} stp_store_coordinates;

typedef struct stp_store_octave {
    uint32_t end, block;
} stp_store_octave;

typedef struct stp_store_breakpoint {
    uint32_t count;
    float radius;
} stp_store_breakpoint;

/// A kind of table: how its records look in the file and in memory.
typedef struct stp_store_table {
    const char* name; ///< of one record, for messages; NULL: not a table of records
    uint32_t record_size;
    size_t element_size;
    void (*code)(stp_store_codec* codec, void* element);
} stp_store_table;

/// Memory that holds one element of any table.
typedef union stp_store_element {
    stp_store_node node;
    stp_store_edge edge;
    stp_store_part part;
    stp_store_material material;
    stp_shading shading;
    stp_store_texture_record texture;
    stp_store_mesh_record mesh;
    stp_store_point_record points;
    stp_store_surfels_record surfels;
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
} stp_store_element;

/// By section type; of one that is none, or not known, everything is 0.
const stp_store_table* stp_store_table_of(uint32_t type);

/// The root directory's own entries.
void stp_store_code_section(stp_store_codec* codec, stp_store_section* section);
