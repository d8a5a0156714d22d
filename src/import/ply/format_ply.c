// SPDX-License-Identifier: MIT
//
// PLY, ascii and binary: meshes (faces of any size, triangle strips), or points if there are no
// faces. Gaussian splatting files become points with the colour of the first coefficient. The
// default up axis is y, as in the format's first models.
#include "import/ply/ply.h"
#include "import/reading/place_sample.h"
#include "import/reading/point_columns.h"
#include "import/reading/surface.h"

#include <assert.h>
#include <math.h>
#include <string.h>

#define GRAIN ((size_t)1 << 14)
#define STRIPE (64 * GRAIN)                      ///< pages are released after this many rows
#define SPHERICAL_HARMONIC_0 0.28209479177387814 ///< 1 / (2 sqrt(pi)): Kerbl et al. 2023

// Names of slots before the colours (ply_colors.c).
static const char* const slot_names[STP_PLY_RED] = {
    "x",
    "y",
    "z",
    "nx normal_x",
    "ny normal_y",
    "nz normal_z",
    "u s texture_u tex_u texcoord_u",
    "v t texture_v tex_v texcoord_v",
    "f_dc_0",
    "f_dc_1",
    "f_dc_2",
};

static void find_slots(stp_ply_vertices* v)
{
    for (size_t i = 0; i < v->element->property_count; ++i) {
        const stp_ply_property* property = &v->element->properties[i];
        for (int slot = 0; slot < STP_PLY_RED; ++slot) {
            if (!property->is_list && v->slots[slot] == NULL &&
                stp_ply_is_one_of(property->name, slot_names[slot])) {
                v->slots[slot] = property;
            }
        }
    }
    (void)stp_ply_find_colors(v->element, &v->color_range);
    memcpy(v->slots + STP_PLY_RED, v->color_range.slots, sizeof(v->color_range.slots));
}

static bool has(const stp_ply_vertices* v, int first, int last)
{
    for (int slot = first; slot <= last; ++slot) {
        if (v->slots[slot] == NULL) {
            return false;
        }
    }
    return true;
}

static stp_result alloc_columns(stp_ply_vertices* v)
{
    size_t floats = v->count * sizeof(float);
    bool colored = has(v, STP_PLY_RED, STP_PLY_BLUE) || has(v, STP_PLY_DC0, STP_PLY_DC2);
    stp_bulk_array columns[STP_PLY_COLUMNS] = {
        {.size = 3 * floats},
        {.size = has(v, STP_PLY_NX, STP_PLY_NZ) ? 3 * floats : 0},
        {.size = has(v, STP_PLY_U, STP_PLY_V) ? 2 * floats : 0},
        {.size = colored ? 4 * floats : 0}};
    stp_result result = stp_ply_alloc_columns(v->ply, &v->room, columns);
    v->positions = columns[0].bytes;
    v->normals = columns[1].bytes;
    v->texcoords = columns[2].bytes;
    v->colors = columns[3].bytes;
    return result == STP_OK ? stp_ply_alloc_attributes(v->ply, &v->room, v->count, &v->attributes)
                            : result;
}

static void store_row(stp_ply_vertices* v, size_t row, const double* n)
{
    assert(row < v->count);
    for (size_t i = 0; i < 3; ++i) {
        v->positions[3 * row + i] = (float)(n[STP_PLY_X + i] - v->origin[i]);
    }
    if (v->normals != NULL) {
        stp_vec3 normal = stp_normalize(
            (stp_vec3){(float)n[STP_PLY_NX], (float)n[STP_PLY_NY], (float)n[STP_PLY_NZ]});
        memcpy(v->normals + 3 * row, &normal, sizeof(normal));
    }
    if (v->texcoords != NULL) {
        // v starts at the bottom of the picture
        const float texcoord[2] = {(float)n[STP_PLY_U], (float)(1.0 - n[STP_PLY_V])};
        for (size_t i = 0; i < 2; ++i) {
            v->texcoords[2 * row + i] = isfinite(texcoord[i]) ? texcoord[i] : 0.0f;
        }
    }
    if (v->colors != NULL) {
        float* color = v->colors + 4 * row;
        bool plain = has(v, STP_PLY_RED, STP_PLY_BLUE);
        for (int i = 0; i < 3 && !plain; ++i) {
            color[i] = (float)(0.5 + SPHERICAL_HARMONIC_0 * n[STP_PLY_DC0 + i]);
        }
        color[3] = 1.0f;
        for (int i = 0; i < 4 && plain; ++i) {
            if (v->slots[STP_PLY_RED + i] != NULL) {
                color[i] = (float)n[STP_PLY_RED + i];
                stp_ply_note_color(&v->color_range, i, n[STP_PLY_RED + i]);
            }
        }
    }
}

static void read_rows(size_t begin, size_t end, uint32_t worker, void* user)
{
    (void)worker;
    stp_ply_vertices* v = user;
    if (begin % STRIPE == 0) {
        stp_ply_release_columns(v->ply, &v->room);
    }
    for (size_t row = begin; row < end; ++row) {
        const unsigned char* bytes = v->rows + row * v->element->row_size;
        double n[STP_PLY_SLOTS] = {0};
        for (int slot = 0; slot < STP_PLY_SLOTS; ++slot) {
            const stp_ply_property* property = v->slots[slot];
            if (property != NULL) {
                n[slot] = stp_ply_value(bytes + property->offset, property->type, v->ply->encoding);
            }
        }
        store_row(v, row, n);
        for (int i = 0; i < STP_ATTRIBUTES; ++i) {
            const stp_ply_property* property = v->attributes.properties[i];
            if (property != NULL) {
                double value =
                    stp_ply_value(bytes + property->offset, property->type, v->ply->encoding);
                stp_ply_store_attribute(&v->attributes, i, row, value);
            }
        }
    }
}

// Positions of the first rows, in full: the origin is their middle.
typedef struct first_rows {
    stp_place_sample sample;
    double places[STP_PLACE_SAMPLES][3];
    size_t wanted;
} first_rows;

// Chooses the origin with the last of the first rows, and moves their positions to it.
static void note_first_row(stp_ply_vertices* v, size_t row, const double* n, first_rows* first)
{
    memcpy(first->places[row], n + STP_PLY_X, sizeof(first->places[row]));
    stp_place_sample_add(&first->sample, first->places[row]);
    if (row + 1 == first->wanted) {
        double middle[3];
        stp_place_sample_choose(&first->sample, middle);
        stp_import_choose_origin(middle, v->origin);
        for (size_t i = 0; i < 3 * first->wanted; ++i) {
            v->positions[i] = (float)(first->places[i / 3][i % 3] - v->origin[i % 3]);
        }
    }
}

static stp_result read_rows_one_by_one(stp_ply_vertices* v, stp_ply_cursor* cursor)
{
    const stp_ply_element* element = v->element;
    first_rows first = {.wanted = v->count < STP_PLACE_SAMPLES ? v->count : STP_PLACE_SAMPLES};
    for (size_t row = 0; row < v->count; ++row) {
        double n[STP_PLY_SLOTS] = {0};
        for (size_t i = 0; i < element->property_count; ++i) {
            const stp_ply_property* property = &element->properties[i];
            double value;
            bool good = property->is_list ? stp_ply_skip(cursor, property)
                                          : stp_ply_next(cursor, property->type, &value);
            if (!good) {
                return stp_ply_fail_row(cursor, element, row);
            }
            for (int slot = 0; slot < STP_PLY_SLOTS && !property->is_list; ++slot) {
                if (v->slots[slot] == property) {
                    n[slot] = value;
                }
            }
            for (int k = 0; k < STP_ATTRIBUTES && !property->is_list; ++k) {
                if (v->attributes.properties[k] == property) {
                    stp_ply_store_attribute(&v->attributes, k, row, value);
                }
            }
        }
        store_row(v, row, n);
        if (row < first.wanted) {
            note_first_row(v, row, n, &first);
        }
        stp_ply_end_row(cursor);
    }
    return STP_OK;
}

// Positions from all over the file choose the origin; where none of those is finite, others.
static void sample_rows(stp_ply_vertices* v)
{
    stp_place_sample sample = {0};
    double place[3];
    for (size_t i = 0; i < v->count && (i < STP_PLACE_SAMPLES || sample.count == 0); ++i) {
        size_t row = i < STP_PLACE_SAMPLES ? stp_place_sample_index((uint32_t)i, v->count) : i;
        const unsigned char* bytes = v->rows + row * v->element->row_size;
        for (int k = 0; k < 3; ++k) {
            place[k] =
                stp_ply_value(bytes + v->slots[k]->offset, v->slots[k]->type, v->ply->encoding);
        }
        stp_place_sample_add(&sample, place);
    }
    stp_place_sample_choose(&sample, place);
    stp_import_choose_origin(place, v->origin);
}

static stp_result read_vertices(stp_ply_vertices* v, stp_ply_cursor* cursor)
{
    const stp_ply_element* element = v->element;
    const char* path = v->ply->import->path;
    find_slots(v);
    if (!stp_ply_has_faces(v->ply)) {
        stp_ply_find_attributes(element, &v->attributes);
    }
    if (!has(v, STP_PLY_X, STP_PLY_Z)) {
        return stp_fail(v->ply->context, STP_ERROR_FORMAT, "%s: its vertices have no x, y and z",
                        path);
    }
    if (element->count >= STP_NONE) {
        return stp_fail(v->ply->context, STP_ERROR_LIMIT, "%s: has more than 2^32 vertices", path);
    }
    v->count = (size_t)element->count;
    stp_result result = alloc_columns(v);
    if (result != STP_OK) {
        return result;
    }
    if (cursor->text != NULL || element->has_lists) {
        return read_rows_one_by_one(v, cursor);
    }
    assert(v->count * element->row_size <= (size_t)(cursor->end - cursor->at) && "was checked");
    v->rows = cursor->at;
    sample_rows(v);
    stp_parallel_for(v->ply->context, v->count, GRAIN, read_rows, v);
    cursor->at += v->count * element->row_size;
    return STP_OK;
}

static stp_result skip_element(stp_ply_cursor* cursor, const stp_ply_element* element)
{
    if (!element->has_lists && cursor->text == NULL) {
        cursor->at += element->count * element->row_size; // was checked
        assert(cursor->at <= cursor->end);
        return STP_OK;
    }
    for (uint64_t row = 0; element->property_count > 0 && row < element->count; ++row) {
        for (size_t i = 0; i < element->property_count; ++i) {
            if (!stp_ply_skip(cursor, &element->properties[i])) {
                return stp_ply_fail_row(cursor, element, row);
            }
        }
        stp_ply_end_row(cursor);
    }
    return STP_OK;
}

static stp_result read_faces(const stp_ply_vertices* v, stp_ply_faces* f, stp_ply_cursor* cursor,
                             const stp_ply_element* element)
{
    bool strips = strcmp(element->name, "tristrips") == 0;
    bool faces = strips || strcmp(element->name, "face") == 0;
    return faces && element->property_count > 0
               ? stp_ply_read_faces(cursor, element, strips, v->positions, v->count, f)
               : skip_element(cursor, element);
}

// Elements before the vertices are skipped at first, because faces need those.
static stp_result read_elements(stp_ply_vertices* v, stp_ply_faces* f, stp_ply_cursor* cursor)
{
    stp_ply* ply = v->ply;
    stp_ply_cursor start = *cursor;
    stp_result result = STP_OK;
    for (size_t i = 0; i < ply->element_count && result == STP_OK; ++i) {
        const stp_ply_element* element = &ply->elements[i];
        result = stp_ply_check_rows(cursor, element);
        if (result != STP_OK) {
            return result;
        }
        if (v->element == NULL && stp_ply_is_one_of(element->name, "vertex vertices")) {
            v->element = element;
            result = read_vertices(v, cursor);
            result = result == STP_OK ? stp_ply_wedges_begin(&f->wedges, ply, v->colors != NULL)
                                      : result;
        } else {
            result = v->element != NULL ? read_faces(v, f, cursor, element)
                                        : skip_element(cursor, element);
        }
    }
    if (result == STP_OK && v->element == NULL) {
        return stp_fail(ply->context, STP_ERROR_FORMAT, "%s: has no vertex element",
                        ply->import->path);
    }
    for (const stp_ply_element* e = ply->elements; result == STP_OK && e < v->element; ++e) {
        result = read_faces(v, f, &start, e);
    }
    return result;
}

static void free_columns(stp_ply_vertices* v)
{
    stp_ply_free_column(v->ply, &v->room, v->positions);
    stp_ply_free_column(v->ply, &v->room, v->normals);
    stp_ply_free_column(v->ply, &v->room, v->texcoords);
    stp_ply_free_column(v->ply, &v->room, v->colors);
    for (int i = 0; i < STP_ATTRIBUTES; ++i) {
        stp_ply_free_column(v->ply, &v->room, v->attributes.columns[i]);
    }
    stp_spill_destroy(v->room.scratch);
}

// Splat files and some exporters write all-zero normals, which count as none.
static void drop_zero_normals(stp_ply_vertices* v)
{
    size_t i = 0;
    while (v->normals != NULL && i < 3 * v->count && v->normals[i] == 0.0f) {
        i += 1;
    }
    if (i == 3 * v->count) {
        stp_ply_free_column(v->ply, &v->room, v->normals);
        v->normals = NULL;
    }
}

// Scanners write unmeasured points as NaN; these are skipped.
static void drop_bad_points(stp_ply_vertices* v)
{
    size_t kept = 0;
    for (size_t i = 0; i < v->count; ++i) {
        const float* p = v->positions + 3 * i;
        if (!stp_is_finite((stp_vec3){p[0], p[1], p[2]})) {
            continue;
        }
        if (kept != i) {
            memcpy(v->positions + 3 * kept, p, 3 * sizeof(float));
            if (v->normals != NULL) {
                memcpy(v->normals + 3 * kept, v->normals + 3 * i, 3 * sizeof(float));
            }
            if (v->colors != NULL) {
                memcpy(v->colors + 4 * kept, v->colors + 4 * i, 4 * sizeof(float));
            }
            stp_ply_move_attributes(&v->attributes, i, kept);
        }
        kept += 1;
    }
    assert(kept <= v->count);
    if (kept < v->count) {
        stp_warn(v->ply->context, "%s: %llu points without a finite position are left out",
                 v->ply->import->path, (unsigned long long)(v->count - kept));
        v->count = kept;
    }
}

static stp_result add_points(stp_ply_vertices* v)
{
    stp_context* context = v->ply->context;
    stp_scene* scene = v->ply->import->scene;
    drop_bad_points(v);
    uint8_t* colors = NULL;
    if (v->colors != NULL) {
        colors = v->room.spilled ? stp_spill_alloc(scene->spill, 4 * v->count)
                                 : STP_NEW_ARRAY(context, uint8_t, 4 * v->count);
        if (colors == NULL) {
            return v->room.spilled ? STP_ERROR_IO : stp_fail_memory(context);
        }
        stp_ply_color_scale scale = stp_ply_find_color_scale(&v->color_range);
        for (size_t i = 0; i < 4 * v->count; ++i) {
            colors[i] = stp_unorm8(stp_ply_scaled_color(&scale, i % 4, v->colors[i]));
        }
    }
    if (v->slots[STP_PLY_DC0] != NULL) {
        stp_notice(context,
                   "%s: splats are read as points, with the colour of their first coefficient",
                   v->ply->import->path);
    }
    stp_point_set set = {.point_count = (uint32_t)v->count,
                         .positions = v->positions,
                         .normals = v->normals,
                         .colors = colors,
                         .spilled = v->room.spilled};
    v->positions = v->normals = NULL;
    stp_ply_hand_attributes(&v->attributes, v->count, set.attributes);
    stp_ply_release_columns(v->ply, &v->room);
    return stp_point_columns_add(v->ply->import, &set);
}

static stp_result add_to_scene(stp_ply_vertices* v, stp_ply_faces* f)
{
    stp_import* import = v->ply->import;
    if (f->small != 0) {
        stp_warn(import->context, "%s: %llu faces with fewer than three corners are left out",
                 import->path, (unsigned long long)f->small);
    }
    stp_import_set_origin(import, v->origin);
    drop_zero_normals(v);
    return f->any ? stp_ply_add_mesh(v, f) : add_points(v);
}

static stp_result read_values(stp_ply* ply)
{
    stp_ply_cursor cursor;
    stp_ply_vertices v = {.ply = ply};
    stp_ply_faces f = {0};
    stp_result result = stp_ply_cursor_open(ply, &cursor);
    if (result == STP_OK) {
        result = read_elements(&v, &f, &cursor);
        if (result == STP_OK && cursor.long_rows > 0) {
            stp_warn(ply->context,
                     "%s: %llu rows have more values than the header says: the rest "
                     "of their lines is left out",
                     ply->import->path, (unsigned long long)cursor.long_rows);
        }
        stp_ply_cursor_close(&cursor);
    }
    if (result == STP_OK) {
        result = add_to_scene(&v, &f);
    }
    free_columns(&v);
    stp_ply_wedges_end(&f.wedges);
    stp_free(ply->context, f.indices);
    stp_free(ply->context, f.corners);
    return result;
}

static bool detect(const unsigned char* bytes, size_t size)
{
    return size >= 4 && memcmp(bytes, "ply", 3) == 0 && (bytes[3] == '\n' || bytes[3] == '\r');
}

static stp_result read(stp_import* import)
{
    stp_ply ply = {.import = import, .context = import->context};
    stp_import_default_axes(import, 'y');
    stp_result result =
        import->file.size != 0 && detect(import->file.bytes, import->file.size)
            ? stp_ply_read_header(&ply)
            : stp_fail(import->context, STP_ERROR_FORMAT, "%s: has no PLY signature", import->path);
    if (result == STP_OK) {
        result = read_values(&ply);
    }
    stp_ply_destroy(&ply);
    return result;
}

const stp_importer stp_importer_ply = {
    .name = "ply", .title = "PLY", .extensions = "ply", .detect = detect, .read = read};
