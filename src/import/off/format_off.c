// SPDX-License-Identifier: MIT
//
// OFF, the Object File Format of Geomview, as text: positions, and normals, colours and texture
// coordinates of vertices in the variants NOFF, COFF and STOFF. Positions are read as doubles, so
// national grids keep their precision. A vertex or face ends with its line; colours of faces are
// not kept. The default up axis is y.
#include "import/reading/point_columns.h"
#include "import/reading/smooth.h"
#include "import/reading/surface.h"
#include "import/reading/text.h"
#include "import/reading/triangulate.h"

#include <assert.h>
#include <math.h>
#include <string.h>

enum { MIN_VERTEX = 6, MIN_FACE = 2 }; // bytes of a line: three numbers, or a count of 0

typedef struct reader {
    stp_import* import;
    stp_context* context;
    unsigned char* text; ///< a copy that ends with a line end
    stp_text at, end;
    bool has_texcoords, has_colors, has_normals;
    size_t vertex_count, face_count;
    double origin[3];
    stp_mesh mesh;
    float* colors; ///< 4 per vertex, as written
    float brightest;
    uint32_t* corners; ///< of the face being read
    size_t corner_capacity;
    size_t index_count, index_capacity;
    uint64_t small, colored; ///< faces with fewer than three corners, and with a colour
} reader;

static stp_result fail_here(const reader* r, const char* what)
{
    uint64_t line = stp_line_number(r->text, (size_t)(r->at - r->text));
    return stp_fail(r->context, STP_ERROR_FORMAT, "%s: line %llu: %s", r->import->path,
                    (unsigned long long)line, what);
}

// Skips blanks, line ends and comments. @return false at the end of the text
static bool find_word(reader* r)
{
    for (;;) {
        r->at = stp_skip_blanks(r->at);
        if (*r->at == '#') {
            r->at = memchr(r->at, '\n', (size_t)(r->end - r->at));
        }
        if (*r->at != '\n') {
            return true;
        }
        if (r->at + 1 >= r->end) {
            return false;
        }
        r->at += 1;
    }
}

// Reads the next number, from the next line if need be.
static bool next_number(reader* r, double* value)
{
    stp_text after = find_word(r) ? stp_read_number(r->at, value) : NULL;
    if (after == NULL || (!stp_is_blank(*after) && *after != '\n' && *after != '#')) {
        return false;
    }
    r->at = after;
    return true;
}

static bool next_count(reader* r, size_t* count)
{
    double value;
    bool good =
        next_number(r, &value) && value >= 0.0 && value < (double)STP_NONE && value == floor(value);
    *count = good ? (size_t)value : 0;
    return good;
}

// The numbers that are left on the line, at most `limit`; the rest is skipped. @return their number
static int rest_of_line(reader* r, double* values, int limit)
{
    int count = 0;
    for (; count < limit; ++count) {
        stp_text start = stp_skip_blanks(r->at);
        stp_text after = *start != '\n' ? stp_read_number(start, &values[count]) : NULL;
        if (after == NULL) {
            break;
        }
        r->at = after;
    }
    r->at = memchr(r->at, '\n', (size_t)(r->end - r->at));
    assert(r->at != NULL && "the text ends with a line end");
    return count;
}

// The keyword, which may be missing: letters before "OFF" name what vertices have.
static stp_result read_keyword(reader* r)
{
    stp_text at = find_word(r) ? r->at : r->end - 1, end = stp_skip_word(at);
    if (stp_is_digit(*at)) {
        return STP_OK;
    }
    if (end - at >= 2 && stp_word_is(at, at + 2, "st")) {
        r->has_texcoords = true;
        at += 2;
    }
    if (at < end && *at == 'C') {
        r->has_colors = true;
        at += 1;
    }
    if (at < end && *at == 'N') {
        r->has_normals = true;
        at += 1;
    }
    if (!stp_word_is(at, end, "off")) {
        return fail_here(r, "expected OFF, or a variant with C, N or ST");
    }
    r->at = end;
    at = stp_skip_blanks(end);
    return stp_word_is(at, stp_skip_word(at), "binary")
               ? stp_fail(r->context, STP_ERROR_UNSUPPORTED,
                          "%s: is binary OFF, which is not supported: save it as text",
                          r->import->path)
               : STP_OK;
}

static stp_result read_counts(reader* r)
{
    if (!next_count(r, &r->vertex_count) || !next_count(r, &r->face_count)) {
        return fail_here(r, "expected the numbers of vertices, faces and edges");
    }
    double edges;
    (void)rest_of_line(r, &edges, 1); // not used, and sometimes missing
    size_t left = (size_t)(r->end - r->at);
    return r->vertex_count <= left / MIN_VERTEX && r->face_count <= left / MIN_FACE
               ? STP_OK
               : stp_fail(
                     r->context, STP_ERROR_TRUNCATED,
                     "%s: its header says %zu vertices and %zu faces, but the file is too short",
                     r->import->path, r->vertex_count, r->face_count);
}

static stp_result alloc_vertices(reader* r)
{
    size_t count = r->vertex_count;
    stp_mesh* mesh = &r->mesh;
    mesh->vertex_count = (uint32_t)count;
    mesh->positions = STP_NEW_ARRAY(r->context, float, 3 * count + 1);
    bool good = mesh->positions != NULL;
    if (r->has_normals) {
        mesh->normals = STP_NEW_ARRAY(r->context, float, 3 * count + 1);
        good = good && mesh->normals != NULL;
    }
    if (r->has_texcoords) {
        mesh->texcoords[0] = STP_NEW_ARRAY(r->context, float, 2 * count + 1);
        good = good && mesh->texcoords[0] != NULL;
    }
    if (r->has_colors) {
        r->colors = STP_NEW_ARRAY(r->context, float, 4 * count + 1);
        good = good && r->colors != NULL;
    }
    return good ? STP_OK : stp_fail_memory(r->context);
}

// Normals follow the position, then colours of three or four numbers, then texture coordinates.
static void store_attributes(reader* r, size_t i, const double* n, int count)
{
    stp_mesh* mesh = &r->mesh;
    int used = 0;
    if (r->has_normals) {
        stp_vec3 normal = {0};
        if (count >= 3) {
            normal = stp_normalize((stp_vec3){(float)n[0], (float)n[1], (float)n[2]});
        }
        memcpy(mesh->normals + 3 * i, &normal, sizeof(normal));
        used = 3;
    }
    int texcoords = r->has_texcoords ? 2 : 0;
    if (r->has_colors) {
        int channels = count - used - texcoords;
        for (int k = 0; k < 4; ++k) {
            float value = k < channels && channels >= 3 ? (float)n[used + k] : (float)NAN;
            r->colors[4 * i + (size_t)k] = value;
            r->brightest = value > r->brightest && isfinite(value) ? value : r->brightest;
        }
        used += channels > 0 ? channels : 0;
    }
    for (int k = 0; k < texcoords; ++k) {
        float value = used + k < count ? (float)n[used + k] : 0.0f;
        value = isfinite(value) ? value : 0.0f;
        mesh->texcoords[0][2 * i + (size_t)k] = k == 0 ? value : 1.0f - value;
    }
}

static stp_result read_vertices(reader* r)
{
    enum { MAX_REST = 9 };
    bool placed = false;
    for (size_t i = 0; i < r->vertex_count; ++i) {
        double p[3], rest[MAX_REST];
        for (int k = 0; k < 3; ++k) {
            if (!next_number(r, &p[k])) {
                return fail_here(r, "expected the coordinates of a vertex");
            }
        }
        if (!placed && isfinite(p[0]) && isfinite(p[1]) && isfinite(p[2])) {
            stp_import_choose_origin(p, r->origin);
            placed = true;
        }
        for (int k = 0; k < 3; ++k) { // if not finite, the scene drops the faces
            r->mesh.positions[3 * i + (size_t)k] = (float)(p[k] - r->origin[k]);
        }
        store_attributes(r, i, rest, rest_of_line(r, rest, MAX_REST));
    }
    return STP_OK;
}

static stp_result read_face(reader* r)
{
    size_t count;
    if (!next_count(r, &count) || count > (size_t)(r->end - r->at) / 2) {
        return fail_here(r, "expected the corners of a face");
    }
    if (!STP_MAKE_ROOM(r->context, r->corners, r->corner_capacity, count)) {
        return stp_fail_memory(r->context);
    }
    for (size_t i = 0; i < count; ++i) {
        double value;
        if (!next_number(r, &value) || !(value >= 0.0 && value < (double)r->vertex_count) ||
            value != floor(value)) {
            return fail_here(r, "expected a vertex of the file as the corner of a face");
        }
        r->corners[i] = (uint32_t)value;
    }
    double color;
    r->colored += (uint64_t)(rest_of_line(r, &color, 1) > 0);
    if (count < 3) {
        r->small += 1;
        return STP_OK;
    }
    if (r->index_count / 3 + count - 2 >= STP_NONE) {
        return stp_fail(r->context, STP_ERROR_LIMIT, "%s: has more than 2^32 triangles",
                        r->import->path);
    }
    if (!STP_MAKE_ROOM(r->context, r->mesh.indices, r->index_capacity,
                       r->index_count + 3 * (count - 2)) ||
        !stp_triangulate(r->context, r->mesh.positions, r->corners, (uint32_t)count,
                         r->mesh.indices + r->index_count)) {
        return stp_fail_memory(r->context);
    }
    r->index_count += 3 * (count - 2);
    return STP_OK;
}

static stp_result make_colors(reader* r)
{
    size_t count = 4 * r->vertex_count;
    float factor = r->brightest > 1.0f ? 1.0f / 255.0f : 1.0f;
    if (r->colors == NULL) {
        return STP_OK;
    }
    r->mesh.colors = STP_NEW_ARRAY(r->context, uint16_t, count + 1);
    if (r->mesh.colors == NULL) {
        return stp_fail_memory(r->context);
    }
    for (size_t i = 0; i < count; ++i) { // without a colour: white
        float value = isnan(r->colors[i]) ? 1.0f : r->colors[i] * factor;
        r->mesh.colors[i] = stp_unorm16(i % 4 < 3 ? stp_srgb_to_linear(value) : value);
    }
    return STP_OK;
}

static stp_result add_to_scene(reader* r)
{
    stp_import* import = r->import;
    if (r->small > 0) {
        stp_warn(r->context, "%s: %llu faces with fewer than three corners are left out",
                 import->path, (unsigned long long)r->small);
    }
    if (r->colored > 0) {
        stp_warn(r->context, "%s: the colours of %llu faces are left out", import->path,
                 (unsigned long long)r->colored);
    }
    stp_import_set_origin(import, r->origin);
    r->mesh.triangle_count = (uint32_t)(r->index_count / 3);
    stp_result result = make_colors(r);
    uint32_t material = STP_NONE;
    result = result == STP_OK ? stp_add_plain_material(import, &material) : result;
    if (result != STP_OK || r->vertex_count == 0) {
        return result;
    }
    stp_part part = {.kind = STP_PART_MESH};
    stp_mesh mesh = r->mesh;
    mesh.material = material;
    r->mesh = (stp_mesh){0};
    result = stp_import_add_mesh(import, &mesh, &part.index);
    return result == STP_OK ? stp_scene_add_part(import->scene, part) : result;
}

static stp_result read_text(reader* r)
{
    stp_result result = read_keyword(r);
    result = result == STP_OK ? read_counts(r) : result;
    result = result == STP_OK ? alloc_vertices(r) : result;
    result = result == STP_OK ? read_vertices(r) : result;
    for (size_t i = 0; i < r->face_count && result == STP_OK; ++i) {
        result = read_face(r);
    }
    return result == STP_OK ? add_to_scene(r) : result;
}

static stp_result read(stp_import* import)
{
    size_t size = import->file.size;
    reader r = {.import = import, .context = import->context};
    stp_import_default_axes(import, 'y');
    r.text = stp_alloc(r.context, size + 1);
    if (r.text == NULL) {
        return stp_fail_memory(r.context);
    }
    if (size > 0) {
        memcpy(r.text, import->file.bytes, size);
    }
    r.text[size] = '\n';
    if (size > 0 && stp_whole_lines(r.text, size) == 0) {
        stp_text_end_lines(r.text, size);
    }
    r.at = r.text;
    r.end = r.text + size + 1;
    stp_result result = read_text(&r);
    void* arrays[] = {r.text,         r.corners,           r.colors,      r.mesh.positions,
                      r.mesh.normals, r.mesh.texcoords[0], r.mesh.colors, r.mesh.indices};
    for (size_t i = 0; i < sizeof(arrays) / sizeof(arrays[0]); ++i) {
        stp_free(r.context, arrays[i]);
    }
    return result;
}

const stp_importer stp_importer_off = {.name = "off", .extensions = "off", .read = read};
