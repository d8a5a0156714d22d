// SPDX-License-Identifier: MIT
//
// Inside the PLY reader: the header (ply_header.c), and the values after it (ply_rows.c).
#pragma once

#include "import/reading/import.h"
#include "import/reading/text.h"
#include "scene/bulk.h"

#include <stdatomic.h>

typedef enum stp_ply_type {
    STP_PLY_INT8,
    STP_PLY_UINT8,
    STP_PLY_INT16,
    STP_PLY_UINT16,
    STP_PLY_INT32,
    STP_PLY_UINT32,
    STP_PLY_FLOAT32,
    STP_PLY_FLOAT64,
} stp_ply_type;

typedef enum stp_ply_encoding { STP_PLY_ASCII, STP_PLY_LITTLE, STP_PLY_BIG } stp_ply_encoding;

typedef struct stp_ply_property {
    const char* name;
    stp_ply_type type; ///< type of the value, or of a list's items
    bool is_list;
    stp_ply_type count_type; ///< type of a list's length
    size_t offset;           ///< bytes from the start of a binary row without lists
} stp_ply_property;

typedef struct stp_ply_element {
    const char* name;
    uint64_t count;
    stp_ply_property* properties;
    size_t property_count, property_capacity;
    bool has_lists;
    size_t row_size; ///< bytes of a binary row, its lists empty
} stp_ply_element;

typedef struct stp_ply {
    stp_import* import;
    stp_context* context;
    stp_ply_encoding encoding;
    stp_ply_element* elements;
    size_t element_count, element_capacity;
    const char* texture; ///< from "comment TextureFile"; NULL: none
    size_t body;         ///< where the values start
} stp_ply;

/// Reads everything up to "end_header". Call stp_ply_destroy even after a failure.
STP_MUST_USE stp_result stp_ply_read_header(stp_ply* ply);
void stp_ply_destroy(stp_ply* ply);

size_t stp_ply_type_size(stp_ply_type type);
/// One binary value.
double stp_ply_value(const unsigned char* bytes, stp_ply_type type, stp_ply_encoding encoding);

/// Iterates over the values of one element after the other.
typedef struct stp_ply_cursor {
    const stp_ply* ply;
    const unsigned char* at;
    const unsigned char* end;
    unsigned char* text; ///< ascii: a copy of the values that ends with a line end
} stp_ply_cursor;

STP_MUST_USE stp_result stp_ply_cursor_open(stp_ply* ply, stp_ply_cursor* cursor);
void stp_ply_cursor_close(stp_ply_cursor* cursor);

/// Whether the file can hold so many rows; fails (logged) if it is too short.
STP_MUST_USE stp_result stp_ply_check_rows(const stp_ply_cursor* cursor,
                                           const stp_ply_element* element);

/// The next value. False if the file ends or does not contain a number there.
bool stp_ply_next(stp_ply_cursor* cursor, stp_ply_type type, double* value);
/// The length of the next list; also false if the rest of the file is too short for it.
bool stp_ply_next_list(stp_ply_cursor* cursor, const stp_ply_property* property, uint64_t* length);
/// Skips one property of a row.
bool stp_ply_skip(stp_ply_cursor* cursor, const stp_ply_property* property);
/// Reports that row `row` of `element` cannot be read, and why.
stp_result stp_ply_fail_row(const stp_ply_cursor* cursor, const stp_ply_element* element,
                            uint64_t row);

/// Whether `name` is one of the words, which are separated by single spaces.
bool stp_ply_is_one_of(const char* name, const char* words);

/// A growing list of triangles.
typedef struct stp_ply_faces {
    uint32_t* indices;
    size_t count, capacity; ///< numbers
    uint32_t* corners;      ///< corners of the face being read
    size_t corner_capacity;
    uint64_t small; ///< skipped faces with fewer than three corners
    bool any;       ///< the file has faces
} stp_ply_faces;

/// Reads an element of faces, or of triangle strips, over `vertex_count` positions.
STP_MUST_USE stp_result stp_ply_read_faces(stp_ply_cursor* cursor, const stp_ply_element* element,
                                           bool strips, const float* positions, size_t vertex_count,
                                           stp_ply_faces* f);

enum { STP_PLY_COLUMNS = 4 }; ///< positions, normals, texcoords, colours: floats

/// Location of columns.
typedef struct stp_ply_room {
    bool spilled;       ///< positions, normals and attributes are in the scene's spill file
    stp_spill* scratch; ///< then: texcoords and colours; to be destroyed; may be NULL
} stp_ply_room;

/// Allocates columns by their sizes; the first always. Free them even after a failure. @return
/// STP_OK, STP_ERROR_IO, STP_ERROR_OUT_OF_MEMORY (logged)
STP_MUST_USE stp_result stp_ply_alloc_columns(const stp_ply* ply, stp_ply_room* room,
                                              stp_bulk_array columns[STP_PLY_COLUMNS]);
/// Whether the header has faces, so that vertices belong to a mesh.
bool stp_ply_has_faces(const stp_ply* ply);
void stp_ply_free_column(const stp_ply* ply, const stp_ply_room* room, void* column);
/// Releases file content that was read and spilled data from memory. Any thread.
void stp_ply_release_columns(const stp_ply* ply, const stp_ply_room* room);

/// Attributes of points (stipple/attributes.h) during reading. Angles are degrees in the file.
/// Intensities are scaled to 65535 if they are bytes, or floats up to 1; other numbers are kept.
typedef struct stp_ply_attributes {
    const stp_ply_property* properties[STP_ATTRIBUTES]; ///< NULL: the file has none
    void* columns[STP_ATTRIBUTES];
    bool scaled_later[STP_ATTRIBUTES];  ///< a column of floats, until all are known
    atomic_bool strong[STP_ATTRIBUTES]; ///< a float is above 1
} stp_ply_attributes;

/// Finds the properties that are attributes. `a` is zero.
void stp_ply_find_attributes(const stp_ply_element* element, stp_ply_attributes* a);
/// Allocates columns, in the scene's spill file if the others are; free them like other columns,
/// even after a failure. @return STP_OK, STP_ERROR_IO, STP_ERROR_OUT_OF_MEMORY (logged)
STP_MUST_USE stp_result stp_ply_alloc_attributes(const stp_ply* ply, const stp_ply_room* room,
                                                 size_t count, stp_ply_attributes* a);
/// Stores a value of the file. Rows in any order, from any thread.
void stp_ply_store_attribute(stp_ply_attributes* a, int attribute, size_t row, double value);
/// Copies a row's values to an earlier one.
void stp_ply_move_attributes(stp_ply_attributes* a, size_t from, size_t to);
/// Moves the columns, converted to the scene's values, to the caller.
void stp_ply_hand_attributes(stp_ply_attributes* a, size_t count, void* columns[STP_ATTRIBUTES]);
