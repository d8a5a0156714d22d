// SPDX-License-Identifier: MIT
//
// Inside the OBJ reader. The text is split into chunks of whole lines that are parsed in parallel
// (obj_parse.c, obj_lines.c); their content is put in order (obj_stitch.c); corners with the same
// position, texture coordinate and normal become one vertex (obj_mesh.c). Data that is large
// compared to the memory limit goes to a temporary file (obj_scratch.c).
#pragma once

#include "import/reading/import.h"
#include "import/reading/lookup.h"
#include "import/reading/text.h"

// How a corner refers to an element. A chunk does not know how many elements precede it, so
// backward indices ("-1") are kept relative to the start of the chunk until the chunks are put in
// order.
#define STP_OBJ_ABSENT UINT32_MAX
#define STP_OBJ_RELATIVE UINT32_C(0x80000000)      ///< set: relative to the start of the chunk
#define STP_OBJ_RELATIVE_ZERO UINT32_C(0xc0000000) ///< the chunk's first element
#define STP_OBJ_INDEX_LIMIT INT64_C(0x3fffffff)    ///< most elements of a kind

#define STP_OBJ_SMALL_MESH ((size_t)1 << 16) ///< corners; smaller meshes are built side by side
#define STP_OBJ_NO_COLOR (-1.0f) ///< marks a position without a colour among others that have one

typedef struct stp_obj_corner {
    uint32_t position, texcoord, normal; ///< from 0; STP_OBJ_ABSENT: none
} stp_obj_corner;

typedef enum stp_obj_event_kind {
    STP_OBJ_OBJECT,
    STP_OBJ_GROUP,
    STP_OBJ_MATERIAL,
    STP_OBJ_LIBRARY,
} stp_obj_event_kind;

/// An event that changes the owner of the following faces.
typedef struct stp_obj_event {
    stp_obj_event_kind kind;
    uint32_t length;
    stp_text text;  ///< the name, within the chunk's text
    size_t polygon; ///< the first polygon after it, within the chunk
} stp_obj_event;

/// A growable array.
typedef struct stp_obj_array {
    void* items;
    size_t count, capacity;
} stp_obj_array;

/// A run of whole lines, and its content.
typedef struct stp_obj_chunk {
    stp_text begin, end;
    stp_obj_array positions; ///< 3 floats, less the origin
    stp_obj_array colors;    ///< 3 floats per position; empty if the chunk has none
    stp_obj_array texcoords; ///< 2 floats
    stp_obj_array normals;   ///< 3 floats
    stp_obj_array corners;   ///< stp_obj_corner
    stp_obj_array polygons;  ///< uint32_t: where each ends among the corners
    stp_obj_array points;    ///< uint32_t: positions named by `p`
    stp_obj_array events;    ///< stp_obj_event
    size_t line_elements, small_faces, curves, bad_attributes; ///< left out, for the warnings
    float color_max;
    bool out_of_memory;
    bool in_scratch;   ///< its arrays are in the scratch file
    const char* error; ///< NULL, or the error in the line at error_at
    stp_text error_at;
} stp_obj_chunk;

/// A name that owns faces: an object, or a group within one.
typedef struct stp_obj_group {
    const char* name;
    uint32_t parent; ///< STP_NONE: below the root
    uint32_t object; ///< in the scene; STP_NONE until something is in it
} stp_obj_group;

/// Faces of one group and one material.
typedef struct stp_obj_mesh {
    uint32_t group, material;
    size_t first_corner, corner_count, first_polygon, polygon_count;
} stp_obj_mesh;

/// Consecutive polygons of a chunk that belong to one mesh.
typedef struct stp_obj_run {
    uint32_t chunk, mesh;
    size_t polygon, polygon_count, corner, corner_count; ///< within the chunk
    size_t target_polygon, target_corner;                ///< within the whole
} stp_obj_run;

typedef struct stp_obj {
    stp_import* import;
    stp_context* context;
    double origin[3]; ///< subtracted from all positions: files in national grids keep their
                      /// precision
    stp_obj_chunk* chunks;
    size_t chunk_count, parsed; ///< chunks that went to the scratch file
    unsigned char* tail;        ///< a copy of an unfinished last line
    stp_spill* scratch;         ///< for parsed data; NULL: kept in memory
    bool scratch_full;          ///< the disk is full; already logged

    // the whole file's, in order
    float *positions, *colors, *texcoords, *normals;
    size_t position_count, texcoord_count, normal_count;
    stp_obj_corner* corners;
    uint32_t* polygons; ///< where each ends among its mesh's corners
    size_t corner_count, polygon_count;
    uint32_t* points;
    size_t point_count;
    float color_scale; ///< 1, or 1/255 if colours were written as bytes
    bool has_colors;
    const char* unknown_material; ///< the first name that no library defines
    size_t unknown_count;

    stp_obj_array groups, meshes, runs; ///< stp_obj_group, stp_obj_mesh, stp_obj_run
    stp_lookup group_names, mesh_keys, material_names, libraries;
} stp_obj;

/// One component of `obj->colors`, 0..1; white if the position has no colour.
static inline float stp_obj_color(const stp_obj* obj, size_t index)
{
    float value = obj->colors[index];
    return value < 0.0f ? 1.0f : value * obj->color_scale;
}

/// Whether the line continues: its last non-blank character is a backslash.
static inline bool stp_obj_is_continued(stp_text line, stp_text end)
{
    while (end > line && stp_is_blank(end[-1])) {
        --end;
    }
    return end > line && end[-1] == '\\';
}

/// Space for `count` more items; NULL if memory runs out. The caller adds to
/// `array->count`.
void* stp_obj_grow(stp_context* context, stp_obj_array* array, size_t count, size_t size);

/// Creates `scratch` if the file is large compared to the memory limit of the scene.
STP_MUST_USE stp_result stp_obj_open_scratch(stp_obj* obj);
/// Moves the content of a parsed chunk there. @return STP_OK or an error (logged; nothing changed)
STP_MUST_USE stp_result stp_obj_move_chunk(stp_obj* obj, stp_obj_chunk* chunk);
void stp_obj_free_chunk(const stp_obj* obj, stp_obj_chunk* chunk);
/// Allocates an array in the scratch file or in memory; NULL: call stp_obj_no_room. One thread at a
/// time.
void* stp_obj_alloc(stp_obj* obj, size_t count, size_t size);
/// The error after a failed allocation. @return STP_ERROR_IO or STP_ERROR_OUT_OF_MEMORY (logged)
STP_MUST_USE stp_result stp_obj_no_room(const stp_obj* obj);
void stp_obj_free(const stp_obj* obj, void* memory);

/// Parses a chunk, up to its first error. Positions are relative to `origin`.
void stp_obj_parse_chunk(stp_context* context, stp_obj_chunk* chunk, const double origin[3]);
/// Splits the file into chunks of about `chunk_size` bytes and parses them.
STP_MUST_USE stp_result stp_obj_parse(stp_obj* obj, size_t chunk_size);
/// Joins the chunks and sorts the faces by mesh. Material libraries were read before.
STP_MUST_USE stp_result stp_obj_stitch(stp_obj* obj);
/// Builds one mesh. @return STP_OK, STP_ERROR_OUT_OF_MEMORY (not logged) or STP_ERROR_IO (logged);
/// on failure `out` is empty
STP_MUST_USE stp_result stp_obj_build_mesh(stp_obj* obj, const stp_obj_mesh* in, stp_mesh* out);
void stp_obj_free_mesh(stp_context* context, const stp_mesh* mesh);
/// Adds meshes, point sets and objects to the scene.
STP_MUST_USE stp_result stp_obj_build(stp_obj* obj);

/// Reads a material library: adds its materials to the scene, and their names with the material's
/// index to `names` (the first definition of a name wins).
STP_MUST_USE stp_result stp_mtl_read(stp_import* import, const char* path, stp_lookup* names);

/// Same, from memory.
STP_MUST_USE stp_result stp_mtl_parse(stp_import* import, const unsigned char* bytes, size_t size,
                                      stp_lookup* names);

/// The complete reader, with chunks of about `chunk_size` bytes, which affect only the speed.
STP_MUST_USE stp_result stp_obj_read(stp_import* import, size_t chunk_size);
