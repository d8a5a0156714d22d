// SPDX-License-Identifier: MIT
//
// STL, ascii and binary. Corners at the same position become one vertex, so meshes are indexed and
// flat-shaded; facet normals are ignored, only the winding counts. The default up axis is z, as in
// CAD programs and printers.
#include "base/io/bytes.h"
#include "import/reading/point_columns.h"
#include "import/reading/smooth.h"
#include "import/reading/surface.h"
#include "import/reading/text.h"
#include "import/stl/stl_weld.h"

#include <assert.h>
#include <math.h>
#include <string.h>

#define HEADER_SIZE ((size_t)84)

// A file being read.
typedef struct reader {
    stp_import* import;
    stp_context* context;
    stp_weld weld; ///< the mesh in the making
    uint32_t material;
    // texts only:
    const unsigned char* tail; ///< a copy of an unfinished last line
    size_t tail_at;            ///< where it is in the file
    size_t facet_start;        ///< indices before the facet in the making
    const char* name;          ///< name of the solid being read; may be NULL
    double origin[3];          ///< subtracted from positions
    bool placed;               ///< the origin was chosen
} reader;

// Colours of the welded vertices. @return false if memory runs out
static bool make_colors(const reader* r, uint16_t** colors)
{
    const stp_weld* weld = &r->weld;
    *colors = NULL;
    if (weld->colors == NULL) {
        return true;
    }
    *colors = STP_NEW_ARRAY(r->context, uint16_t, 4 * weld->vertex_count);
    for (size_t i = 0; i < weld->vertex_count && *colors != NULL; ++i) {
        stp_stl_color(weld->coding, r->import->file.bytes, weld->colors[i], *colors + 4 * i);
    }
    return *colors != NULL;
}

// Adds the collected triangles as an object below the root; without a name, and before any named
// solid, as a part of the root.
static stp_result end_solid(reader* r, const char* name)
{
    stp_scene* scene = r->import->scene;
    stp_weld* weld = &r->weld;
    stp_result result = STP_OK;
    if (weld->index_count != 0) {
        result = stp_weld_finish(weld);
        result = result == STP_OK ? stp_add_plain_material(r->import, &r->material) : result;
        stp_object object = {
            .name = name, .parent = r->import->root, .transform = stp_affine_identity()};
        bool at_root = scene->object_count == (size_t)r->import->root + 1;
        if (result == STP_OK && (name != NULL || !at_root)) {
            result = stp_scene_add_object(scene, &object, NULL);
        }
        stp_mesh mesh = {.name = name,
                         .vertex_count = (uint32_t)weld->vertex_count,
                         .triangle_count = (uint32_t)(weld->index_count / 3),
                         .positions = weld->positions,
                         .indices = weld->indices,
                         .material = r->material};
        stp_part part = {.kind = STP_PART_MESH};
        if (result == STP_OK && !make_colors(r, &mesh.colors)) {
            result = stp_fail_memory(r->context);
        }
        if (result == STP_OK) {
            weld->positions = NULL;
            weld->indices = NULL;
            result = stp_import_add_mesh(r->import, &mesh, &part.index);
        }
        if (result == STP_OK) {
            result = stp_scene_add_part(scene, part);
        }
    }
    stp_weld_clear(weld);
    return result;
}

static stp_result read_binary(reader* r, size_t facet_count)
{
    const unsigned char* facets = r->import->file.bytes + HEADER_SIZE;
    if (facet_count >= STP_NONE / 3) {
        return stp_fail(r->context, STP_ERROR_LIMIT, "%s: has more than 2^32 corners",
                        r->import->path);
    }
    assert(HEADER_SIZE + facet_count * STP_STL_FACET_SIZE <= r->import->file.size);
    stp_stl_coding coding = stp_stl_find_coding(r->import->file.bytes, facet_count);
    stp_result result = stp_weld_begin(&r->weld, facets, facet_count, coding);
    for (size_t i = 0; result == STP_OK && i < 3 * facet_count; ++i) {
        result = stp_weld_add(&r->weld, stp_stl_corner(facets, i));
    }
    return result == STP_OK ? end_solid(r, NULL) : result;
}

static stp_result fail_line(const reader* r, stp_text at, bool in_tail, const char* what)
{
    stp_text bytes = r->import->file.bytes;
    size_t offset = in_tail ? r->tail_at + (size_t)(at - r->tail) : (size_t)(at - bytes);
    return stp_fail(r->context, STP_ERROR_FORMAT, "%s: line %llu: %s", r->import->path,
                    (unsigned long long)stp_line_number(bytes, offset), what);
}

static stp_result read_vertex(reader* r, stp_text at, bool in_tail)
{
    double n[3];
    stp_text next = at;
    for (int i = 0; i < 3 && next != NULL; ++i) {
        next = stp_read_number(next, &n[i]);
    }
    if (next == NULL) {
        return fail_line(r, at, in_tail, "expected three coordinates");
    }
    if (!r->placed && isfinite(n[0]) && isfinite(n[1]) && isfinite(n[2])) {
        stp_import_choose_origin(n, r->origin);
        stp_import_set_origin(r->import, r->origin);
        r->placed = true;
    } // before, the facets are dropped
    const double* o = r->origin;
    stp_vec3 p = {(float)(n[0] - o[0]) + 0.0f, (float)(n[1] - o[1]) + 0.0f,
                  (float)(n[2] - o[2]) + 0.0f}; // -0 becomes 0
    if (r->weld.index_count >= STP_NONE - 1) {
        return stp_fail(r->context, STP_ERROR_LIMIT, "%s: has more than 2^32 corners",
                        r->import->path);
    }
    return stp_weld_add(&r->weld, p);
}

static stp_result copy_name(const reader* r, stp_text at, const char** name)
{
    at = stp_skip_blanks(at);
    stp_text end = at;
    for (stp_text c = at; *c != '\n'; ++c) {
        end = stp_is_blank(*c) ? end : c + 1;
    }
    *name = NULL;
    if (end == at) {
        return STP_OK;
    }
    size_t length = end - at < 4096 ? (size_t)(end - at) : 4096;
    *name = stp_arena_copy_text(&r->import->scene->text, (const char*)at, length);
    return *name != NULL ? STP_OK : stp_fail_memory(r->context);
}

// Only "solid", "vertex" and the ends of facets and solids matter.
static stp_result read_line(reader* r, stp_text at, bool in_tail)
{
    stp_text word = stp_skip_blanks(at);
    stp_text next = stp_skip_word(word);
    if (stp_word_is(word, next, "vertex")) {
        return read_vertex(r, next, in_tail);
    }
    if (stp_word_is(word, next, "endfacet") || stp_word_is(word, next, "endloop")) {
        size_t corners = r->weld.index_count - r->facet_start;
        assert(r->facet_start <= r->weld.index_count);
        r->facet_start = r->weld.index_count;
        return corners == 3 || corners == 0
                   ? STP_OK
                   : fail_line(r, word, in_tail, "expected three vertices per facet");
    }
    if (stp_word_is(word, next, "solid")) {
        if (r->weld.index_count != r->facet_start) {
            return fail_line(r, word, in_tail, "a solid begins within a facet");
        }
        stp_result result = end_solid(r, r->name);
        r->facet_start = 0;
        return result == STP_OK ? copy_name(r, next, &r->name) : result;
    }
    return STP_OK;
}

static stp_result read_lines(reader* r, stp_text at, stp_text end, bool in_tail)
{
    assert(at == end || end[-1] == '\n');
    stp_result result = STP_OK;
    while (at < end && result == STP_OK) {
        result = read_line(r, at, in_tail);
        at = (stp_text)memchr(at, '\n', (size_t)(end - at)) + 1;
    }
    return result;
}

// The text is read in place; only a last line without a line end is copied, to append one.
static stp_result read_ascii(reader* r)
{
    stp_text bytes = r->import->file.bytes;
    size_t size = r->import->file.size, whole = size;
    while (whole > 0 && bytes[whole - 1] != '\n') {
        whole -= 1;
    }
    unsigned char* tail = stp_alloc(r->context, size - whole + 1);
    if (tail == NULL) {
        return stp_fail_memory(r->context);
    }
    memcpy(tail, bytes + whole, size - whole);
    tail[size - whole] = '\n';
    if (whole == 0) {
        stp_text_end_lines(tail, size);
    }
    r->tail = tail;
    r->tail_at = whole;
    stp_result result = read_lines(r, bytes, bytes + whole, false);
    if (result == STP_OK) {
        result = read_lines(r, tail, tail + (size - whole) + 1, true);
    }
    stp_free(r->context, tail);
    if (result == STP_OK && r->weld.index_count != r->facet_start) {
        return stp_fail(r->context, STP_ERROR_TRUNCATED, "%s: ends within a facet",
                        r->import->path);
    }
    return result == STP_OK ? end_solid(r, r->name) : result;
}

// Whether the file size matches the number of facets.
static bool is_binary(const unsigned char* bytes, size_t size)
{
    return size >= HEADER_SIZE && (size - HEADER_SIZE) % STP_STL_FACET_SIZE == 0 &&
           (size - HEADER_SIZE) / STP_STL_FACET_SIZE == stp_read_u32(bytes + 80);
}

// "solid" begins a text, but also the header of many binary files: those have the size their count
// says, or a zero byte early on.
static bool is_ascii(const unsigned char* bytes, size_t size)
{
    size_t at = 0;
    while (at < size && (stp_is_blank(bytes[at]) || bytes[at] == '\n')) {
        at += 1;
    }
    if (size - at < 6 || !stp_word_is(bytes + at, bytes + at + 5, "solid")) {
        return false;
    }
    if (is_binary(bytes, size)) {
        return false;
    }
    size_t head = size < 4096 ? size : 4096;
    for (; at < head; ++at) {
        if (bytes[at] == 0) {
            return false;
        }
    }
    return true;
}

static bool detect(const unsigned char* bytes, size_t size)
{
    size_t head = size < 1024 ? size : 1024;
    for (size_t i = 0; i + 8 <= head && is_ascii(bytes, size); ++i) {
        if (stp_word_is(bytes + i, bytes + i + 5, "facet") ||
            stp_word_is(bytes + i, bytes + i + 8, "endsolid")) {
            return true;
        }
    }
    return false; // a binary file is recognised only by its size, so the extension decides
}

static stp_result read_with(reader* r)
{
    const stp_mapped_file* file = &r->import->file;
    if (file->size != 0 && is_ascii(file->bytes, file->size)) {
        return read_ascii(r);
    }
    if (file->size < HEADER_SIZE) {
        return stp_fail(r->context, STP_ERROR_TRUNCATED,
                        "%s: is shorter than the header of an STL file", r->import->path);
    }
    uint64_t count = stp_read_u32(file->bytes + 80);
    uint64_t held = (file->size - HEADER_SIZE) / STP_STL_FACET_SIZE;
    if (count > held) {
        return stp_fail(r->context, STP_ERROR_TRUNCATED,
                        "%s: its header says %llu facets, but it ends after %llu", r->import->path,
                        (unsigned long long)count, (unsigned long long)held);
    }
    if (!is_binary(file->bytes, file->size)) {
        stp_warn(r->context, "%s: has more data than the facets that its header declares",
                 r->import->path);
    }
    return read_binary(r, (size_t)count);
}

static stp_result read(stp_import* import)
{
    reader r = {.import = import,
                .context = import->context,
                .weld = {.context = import->context},
                .material = STP_NONE};
    stp_import_default_axes(import, 'z');
    size_t objects = import->scene->part_count;
    stp_result result = read_with(&r);
    stp_weld_clear(&r.weld);
    if (result == STP_OK && import->scene->part_count == objects) {
        stp_warn(import->context, "%s: has no facets", import->path);
    }
    return result;
}

const stp_importer stp_importer_stl = {
    .name = "stl", .title = "STL", .extensions = "stl", .detect = detect, .read = read};
