// SPDX-License-Identifier: MIT
//
// Inside the PLY reader: the header (ply_header.c), the values after it (ply_rows.c), and the mesh
// (ply_mesh.c).
#pragma once

#include "import/reading/import.h"
#include "import/reading/lookup.h"
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
    const char** textures; ///< from "comment TextureFile"
    size_t texture_count, texture_capacity;
    size_t body; ///< where the values start
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
    bool row_is_line;    ///< ascii: there are as many lines as rows
    uint64_t long_rows;  ///< rows with more values than the header says
} stp_ply_cursor;

/// Starts at the first value. A cloud that lacks up to a hundredth of its points gets as many as
/// there are, with a warning. @return STP_OK or STP_ERROR_OUT_OF_MEMORY (logged)
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
/// Ends a row: if rows are lines, skips the rest of its line.
void stp_ply_end_row(stp_ply_cursor* cursor);
/// Reports that row `row` of `element` cannot be read, and why.
stp_result stp_ply_fail_row(const stp_ply_cursor* cursor, const stp_ply_element* element,
                            uint64_t row);

/// Whether `name` is one of the words, which are separated by single spaces.
bool stp_ply_is_one_of(const char* name, const char* words);

/// Colours of an element's rows.
typedef struct stp_ply_colors {
    const stp_ply_property* slots[4]; ///< red, green, blue, alpha; NULL: none
    bool wide;                        ///< a type has more than 8 bits
    atomic_uint seen, seen_alpha;     ///< which limits a value exceeds
} stp_ply_colors;

/// From values as written to fractions of white, for each channel: value * factor / divisor.
typedef struct stp_ply_color_scale {
    float factor[4], divisor[4];
} stp_ply_color_scale;

/// Finds the properties that are colours. @return whether red, green and blue are there
bool stp_ply_find_colors(const stp_ply_element* element, stp_ply_colors* colors);
/// Notes a value above 1 of a file with wide colours. Any thread.
void stp_ply_note_wide_color(stp_ply_colors* colors, int channel, double value);
/// The scale, once all values were noted.
stp_ply_color_scale stp_ply_find_color_scale(const stp_ply_colors* colors);

/// Notes a value of the file, for the scale. Any thread.
static inline void stp_ply_note_color(stp_ply_colors* colors, int channel, double value)
{
    if (colors->wide && value > 1.0) {
        stp_ply_note_wide_color(colors, channel, value);
    }
}

static inline float stp_ply_scaled_color(const stp_ply_color_scale* scale, size_t channel,
                                         float value)
{
    return value * scale->factor[channel] / scale->divisor[channel];
}

/// A vertex with what its faces add.
typedef struct stp_ply_wedge {
    uint32_t vertex;
    float texcoord[2]; ///< as in the scene: v starts at the top
    float color[4];    ///< as written until its element ends, then fractions of white
} stp_ply_wedge;

/// Triangles with the same picture.
typedef struct stp_ply_group {
    stp_lookup known;
    stp_ply_wedge* wedges;
    size_t count, capacity, scaled; ///< wedges; `scaled`: those of elements that ended
    uint32_t* indices;              ///< of wedges
    size_t index_count, index_capacity;
} stp_ply_group;

/// Faces with colours or texture coordinates of their own.
typedef struct stp_ply_wedges {
    const stp_ply* ply;
    bool active; ///< the file has such faces
    bool wants_colors;
    bool any_colors, any_texcoords; ///< an element has them
    stp_ply_group* groups;          ///< a picture each, and one without
    size_t group_count;
    // properties of the element being read:
    stp_ply_colors colors;
    bool has_colors;
    const stp_ply_property *texcoord, *texnumber; ///< NULL: none
    // the face being read:
    float* texcoords;
    size_t texcoord_count, texcoord_capacity;
    double texture; ///< number of its picture
    float color[4];
    // its corners:
    float* places;
    uint32_t *numbers, *vertices;
    size_t place_capacity, number_capacity, vertex_capacity;
} stp_ply_wedges;

/// Looks for such faces in the header; colours count only if vertices have none. Call
/// stp_ply_wedges_end even after a failure. @return STP_OK, STP_ERROR_OUT_OF_MEMORY (logged)
STP_MUST_USE stp_result stp_ply_wedges_begin(stp_ply_wedges* w, const stp_ply* ply,
                                             bool vertices_have_colors);
void stp_ply_wedges_end(stp_ply_wedges* w);
/// Starts an element of faces: finds its properties.
void stp_ply_wedges_begin_element(stp_ply_wedges* w, const stp_ply_element* element);
/// Ends it: scales its colours.
void stp_ply_wedges_end_element(stp_ply_wedges* w);
/// Starts a face.
void stp_ply_wedges_begin_face(stp_ply_wedges* w);
/// Reads or skips a property of a face; *good is false if it cannot be read. @return STP_OK,
/// STP_ERROR_OUT_OF_MEMORY (logged)
STP_MUST_USE stp_result stp_ply_wedges_read(stp_ply_wedges* w, stp_ply_cursor* cursor,
                                            const stp_ply_property* property, bool* good);
/// Adds the triangles of the face. @return STP_OK, STP_ERROR_LIMIT, STP_ERROR_OUT_OF_MEMORY
/// (logged)
STP_MUST_USE stp_result stp_ply_wedges_add(stp_ply_wedges* w, const float* positions,
                                           const uint32_t* corners, size_t count);

/// A growing list of triangles.
typedef struct stp_ply_faces {
    uint32_t* indices;
    size_t count, capacity; ///< numbers
    uint32_t* corners;      ///< corners of the face being read
    size_t corner_capacity;
    uint64_t small;        ///< skipped faces with fewer than three corners
    bool any;              ///< the file has faces
    stp_ply_wedges wedges; ///< if active, they have the triangles of faces
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

/// Values of a vertex.
typedef enum stp_ply_slot {
    STP_PLY_X,
    STP_PLY_Y,
    STP_PLY_Z,
    STP_PLY_NX,
    STP_PLY_NY,
    STP_PLY_NZ,
    STP_PLY_U,
    STP_PLY_V,
    STP_PLY_DC0, ///< first coefficients of a splat's colour
    STP_PLY_DC1,
    STP_PLY_DC2,
    STP_PLY_RED,
    STP_PLY_GREEN,
    STP_PLY_BLUE,
    STP_PLY_ALPHA,
    STP_PLY_SLOTS,
} stp_ply_slot;

/// Arrays from the rows of the vertex element. Positions and normals have 3 floats, texcoords 2,
/// colours 4.
typedef struct stp_ply_vertices {
    stp_ply* ply;
    const stp_ply_element* element;
    const stp_ply_property* slots[STP_PLY_SLOTS]; ///< NULL: the file has none
    stp_ply_colors color_range;
    double origin[3];
    const unsigned char* rows; ///< binary rows without lists; NULL: the values come one by one
    size_t count;
    float *positions, *normals, *texcoords;
    float* colors;                 ///< as written, or linear from the coefficients of splats
    stp_ply_attributes attributes; ///< only in files without faces
    stp_ply_room room;
} stp_ply_vertices;

/// Adds the triangles to the scene, and takes arrays from `v` and `f`. @return STP_OK, or a
/// failure, logged
STP_MUST_USE stp_result stp_ply_add_mesh(stp_ply_vertices* v, stp_ply_faces* f);
