// SPDX-License-Identifier: MIT
//
// PLY, ascii and binary: meshes (faces of any size, triangle strips), or points if there are no
// faces. Gaussian splatting files become points with the colour of the first coefficient. The
// default up axis is y, as in the format's first models.
#include "import/ply/ply.h"
#include "import/reading/point_columns.h"
#include "import/reading/surface.h"

#include <assert.h>
#include <math.h>
#include <stdatomic.h>
#include <string.h>

enum { X, Y, Z, NX, NY, NZ, R, G, B, A, U, V, DC0, DC1, DC2, SLOT_COUNT };

#define GRAIN ((size_t)1 << 14)
#define STRIPE (64 * GRAIN)                      ///< pages are released after this many rows
#define SPHERICAL_HARMONIC_0 0.28209479177387814 ///< 1 / (2 sqrt(pi)): Kerbl et al. 2023

// Arrays from the rows of the vertex element. Positions and normals have 3 floats, texcoords 2,
// colours 4.
typedef struct vertices {
    stp_ply* ply;
    const stp_ply_element* element;
    const stp_ply_property* slots[SLOT_COUNT]; ///< NULL: the file has none
    double scale[SLOT_COUNT];
    double origin[3];
    const unsigned char* rows; ///< binary rows without lists; NULL: the values come one by one
    size_t count;
    float *positions, *normals, *texcoords, *colors;
    stp_ply_attributes attributes; ///< only in files without faces
    atomic_bool bright;            ///< a colour written as float is above 1
    stp_ply_room room;
} vertices;

static const char* const slot_names[SLOT_COUNT] = {
    "x",
    "y",
    "z",
    "nx normal_x",
    "ny normal_y",
    "nz normal_z",
    "red r diffuse_red",
    "green g diffuse_green",
    "blue b diffuse_blue",
    "alpha a diffuse_alpha",
    "u s texture_u tex_u texcoord_u",
    "v t texture_v tex_v texcoord_v",
    "f_dc_0",
    "f_dc_1",
    "f_dc_2",
};

static void find_slots(vertices* v)
{
    for (size_t i = 0; i < v->element->property_count; ++i) {
        const stp_ply_property* property = &v->element->properties[i];
        for (int slot = 0; slot < SLOT_COUNT; ++slot) {
            if (!property->is_list && v->slots[slot] == NULL &&
                stp_ply_is_one_of(property->name, slot_names[slot])) {
                v->slots[slot] = property;
            }
        }
    }
    static const double byte_scale[] = {127.0,        255.0,        32767.0, 65535.0,
                                        2147483647.0, 4294967295.0, 1.0,     1.0};
    for (int slot = 0; slot < SLOT_COUNT; ++slot) {
        bool color = slot >= R && slot <= A && v->slots[slot] != NULL;
        v->scale[slot] = color ? byte_scale[v->slots[slot]->type] : 1.0;
    }
}

static bool has(const vertices* v, int first, int last)
{
    for (int slot = first; slot <= last; ++slot) {
        if (v->slots[slot] == NULL) {
            return false;
        }
    }
    return true;
}

static stp_result alloc_columns(vertices* v)
{
    size_t floats = v->count * sizeof(float);
    bool colored = has(v, R, B) || has(v, DC0, DC2);
    stp_bulk_array columns[STP_PLY_COLUMNS] = {{.size = 3 * floats},
                                               {.size = has(v, NX, NZ) ? 3 * floats : 0},
                                               {.size = has(v, U, V) ? 2 * floats : 0},
                                               {.size = colored ? 4 * floats : 0}};
    stp_result result = stp_ply_alloc_columns(v->ply, &v->room, columns);
    v->positions = columns[0].bytes;
    v->normals = columns[1].bytes;
    v->texcoords = columns[2].bytes;
    v->colors = columns[3].bytes;
    return result == STP_OK ? stp_ply_alloc_attributes(v->ply, &v->room, v->count, &v->attributes)
                            : result;
}

static void store_row(vertices* v, size_t row, const double* n)
{
    assert(row < v->count);
    for (size_t i = 0; i < 3; ++i) {
        v->positions[3 * row + i] = (float)(n[X + i] - v->origin[i]);
    }
    if (v->normals != NULL) {
        stp_vec3 normal = stp_normalize((stp_vec3){(float)n[NX], (float)n[NY], (float)n[NZ]});
        memcpy(v->normals + 3 * row, &normal, sizeof(normal));
    }
    if (v->texcoords != NULL) {
        // v starts at the bottom of the picture
        v->texcoords[2 * row] = isfinite(n[U]) ? (float)n[U] : 0.0f;
        v->texcoords[2 * row + 1] = isfinite(n[V]) ? (float)(1.0 - n[V]) : 0.0f;
    }
    if (v->colors != NULL) {
        float* color = v->colors + 4 * row;
        bool plain = has(v, R, B);
        for (size_t i = 0; i < 3; ++i) {
            double value =
                plain ? n[R + i] / v->scale[R + i] : 0.5 + SPHERICAL_HARMONIC_0 * n[DC0 + i];
            color[i] = (float)value;
            if (plain && v->scale[R + i] == 1.0 && value > 1.0) {
                atomic_store_explicit(&v->bright, true, memory_order_relaxed);
            }
        }
        color[3] = plain && v->slots[A] != NULL ? (float)(n[A] / v->scale[A]) : 1.0f;
    }
}

static void read_rows(size_t begin, size_t end, uint32_t worker, void* user)
{
    (void)worker;
    vertices* v = user;
    if (begin % STRIPE == 0) {
        stp_ply_release_columns(v->ply, &v->room);
    }
    for (size_t row = begin; row < end; ++row) {
        const unsigned char* bytes = v->rows + row * v->element->row_size;
        double n[SLOT_COUNT] = {0};
        for (int slot = 0; slot < SLOT_COUNT; ++slot) {
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

// Far from the origin, as in national grids, floats would lose digits: the first position chooses
// the origin.
static void choose_origin(vertices* v, const double* n)
{
    for (int i = 0; i < 3; ++i) {
        bool far = fabs(n[i]) >= 4096.0 && fabs(n[i]) < 1e15;
        v->origin[i] = far ? (double)(int64_t)(n[i] / 1024.0) * 1024.0 : 0.0;
    }
}

static stp_result read_rows_one_by_one(vertices* v, stp_ply_cursor* cursor)
{
    const stp_ply_element* element = v->element;
    for (size_t row = 0; row < v->count; ++row) {
        double n[SLOT_COUNT] = {0};
        for (size_t i = 0; i < element->property_count; ++i) {
            const stp_ply_property* property = &element->properties[i];
            double value;
            bool good = property->is_list ? stp_ply_skip(cursor, property)
                                          : stp_ply_next(cursor, property->type, &value);
            if (!good) {
                return stp_ply_fail_row(cursor, element, row);
            }
            for (int slot = 0; slot < SLOT_COUNT && !property->is_list; ++slot) {
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
        if (row == 0) {
            choose_origin(v, n);
        }
        store_row(v, row, n);
    }
    return STP_OK;
}

static stp_result read_vertices(vertices* v, stp_ply_cursor* cursor)
{
    const stp_ply_element* element = v->element;
    const char* path = v->ply->import->path;
    find_slots(v);
    if (!stp_ply_has_faces(v->ply)) {
        stp_ply_find_attributes(element, &v->attributes);
    }
    if (!has(v, X, Z)) {
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
    for (int i = 0; i < 3 && v->count > 0; ++i) {
        v->origin[i] =
            stp_ply_value(v->rows + v->slots[i]->offset, v->slots[i]->type, v->ply->encoding);
    }
    choose_origin(v, (double[3]){v->origin[0], v->origin[1], v->origin[2]});
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
    }
    return STP_OK;
}

static stp_result read_elements(vertices* v, stp_ply_faces* f, stp_ply_cursor* cursor)
{
    stp_ply* ply = v->ply;
    for (size_t i = 0; i < ply->element_count; ++i) {
        const stp_ply_element* element = &ply->elements[i];
        stp_result result = stp_ply_check_rows(cursor, element);
        if (result != STP_OK) {
            return result;
        }
        bool strips = strcmp(element->name, "tristrips") == 0;
        if (v->element == NULL && stp_ply_is_one_of(element->name, "vertex vertices")) {
            v->element = element;
            result = read_vertices(v, cursor);
        } else if (v->element != NULL && element->property_count > 0 &&
                   (strips || strcmp(element->name, "face") == 0)) {
            result = stp_ply_read_faces(cursor, element, strips, v->positions, v->count, f);
        } else {
            result = skip_element(cursor, element);
        }
        if (result != STP_OK) {
            return result;
        }
    }
    return v->element != NULL ? STP_OK
                              : stp_fail(ply->context, STP_ERROR_FORMAT,
                                         "%s: has no vertex element", ply->import->path);
}

static void free_columns(vertices* v)
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
static void drop_zero_normals(vertices* v)
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
static void drop_bad_points(vertices* v)
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

static float color_scale(vertices* v)
{
    return atomic_load(&v->bright) ? 1.0f / 255.0f : 1.0f; // floats from 0 to 255
}

static stp_result add_points(vertices* v)
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
        float scale = color_scale(v);
        for (size_t i = 0; i < 4 * v->count; ++i) {
            colors[i] = stp_unorm8(v->colors[i] * (i % 4 < 3 ? scale : 1.0f));
        }
    }
    if (v->slots[DC0] != NULL) {
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

static stp_result check_positions(const vertices* v)
{
    for (size_t i = 0; i < v->count; ++i) {
        const float* p = v->positions + 3 * i;
        if (!stp_is_finite((stp_vec3){p[0], p[1], p[2]})) {
            return stp_fail(v->ply->context, STP_ERROR_FORMAT,
                            "%s: vertex %llu has a position that is not finite",
                            v->ply->import->path, (unsigned long long)i);
        }
    }
    return STP_OK;
}

static stp_result add_material(const vertices* v, uint32_t* index)
{
    stp_import* import = v->ply->import;
    stp_material material = stp_material_plain();
    stp_result result = STP_OK;
    if (v->ply->texture != NULL && v->texcoords != NULL) {
        stp_pictures pictures = stp_pictures_create(import);
        result = stp_pictures_read(&pictures, "TextureFile", v->ply->texture, STP_WRAP_REPEAT,
                                   &material.base_color_texture.texture);
        stp_pictures_destroy(&pictures);
    }
    return result == STP_OK ? stp_scene_add_material(import->scene, &material, index) : result;
}

static stp_result add_mesh(vertices* v, stp_ply_faces* f)
{
    stp_context* context = v->ply->context;
    stp_scene* scene = v->ply->import->scene;
    stp_mesh mesh = {.vertex_count = (uint32_t)v->count,
                     .triangle_count = (uint32_t)(f->count / 3)};
    assert(f->count % 3 == 0 && f->count / 3 < STP_NONE && v->count < STP_NONE);
    stp_result result = check_positions(v);
    if (result == STP_OK) {
        result = add_material(v, &mesh.material);
    }
    if (result != STP_OK) {
        return result;
    }
    if (v->colors != NULL) {
        mesh.colors = STP_NEW_ARRAY(context, uint16_t, 4 * v->count);
        if (mesh.colors == NULL) {
            return stp_fail_memory(context);
        }
        float scale = color_scale(v);
        for (size_t i = 0; i < 4 * v->count; ++i) {
            float value = v->colors[i];
            mesh.colors[i] = stp_unorm16(i % 4 < 3 ? stp_srgb_to_linear(value * scale) : value);
        }
    }
    mesh.positions = v->positions;
    mesh.normals = v->normals;
    mesh.texcoords[0] = v->texcoords;
    mesh.indices = f->indices;
    v->positions = v->normals = v->texcoords = NULL;
    f->indices = NULL;
    stp_part part = {.kind = STP_PART_MESH};
    result = stp_scene_add_mesh(scene, &mesh, &part.index);
    return result == STP_OK ? stp_scene_add_part(scene, part) : result;
}

static stp_result add_to_scene(vertices* v, stp_ply_faces* f)
{
    stp_import* import = v->ply->import;
    if (f->small != 0) {
        stp_warn(import->context, "%s: %llu faces with fewer than three corners are left out",
                 import->path, (unsigned long long)f->small);
    }
    stp_import_set_origin(import, v->origin);
    drop_zero_normals(v);
    return f->any ? add_mesh(v, f) : add_points(v);
}

static stp_result read_values(stp_ply* ply)
{
    stp_ply_cursor cursor;
    vertices v = {.ply = ply};
    stp_ply_faces f = {0};
    atomic_init(&v.bright, false);
    stp_result result = stp_ply_cursor_open(ply, &cursor);
    if (result == STP_OK) {
        result = read_elements(&v, &f, &cursor);
        stp_ply_cursor_close(&cursor);
    }
    if (result == STP_OK) {
        result = add_to_scene(&v, &f);
    }
    free_columns(&v);
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
