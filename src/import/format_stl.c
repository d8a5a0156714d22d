// SPDX-License-Identifier: MIT
//
// STL, ascii and binary. Corners at the same place are one vertex, so meshes are indexed and shade
// flat; facet normals are ignored, the winding counts. The colours that VisCAM and Magics hide in
// the attribute bytes are left alone: each means the opposite of the other. Up is z where nothing
// else is asked for, as in the CAD programs and printers that write the format.
#include "base/bytes.h"
#include "import/surface.h"
#include "import/text.h"

#include <string.h>

#define HEADER_SIZE ((size_t)84)
#define FACET_SIZE ((size_t)50)

// A mesh in the making.
typedef struct welder {
    stp_import* import;
    stp_context* context;
    stp_lookup corners; ///< positions to vertices
    float* positions;
    size_t vertex_count, vertex_capacity; ///< capacity in vertices
    uint32_t* indices;
    size_t index_count, index_capacity;
    uint32_t material;
} welder;

static stp_result fail_facet(const welder* w, uint64_t facet)
{
    return stp_fail(w->context, STP_ERROR_FORMAT,
                    "%s: facet %llu has a position that is not finite", w->import->path,
                    (unsigned long long)facet + 1);
}

static stp_result add_corner(welder* w, stp_vec3 p)
{
    p = (stp_vec3){p.x + 0.0f, p.y + 0.0f, p.z + 0.0f}; // -0 becomes 0: the same place
    uint32_t index;
    stp_result result =
        stp_lookup_add(&w->corners, &p, sizeof(p), (uint32_t)w->vertex_count, &index);
    if (result != STP_OK) {
        return result;
    }
    if (index == w->vertex_count) {
        float* positions = stp_grow_array(w->context, w->positions, &w->vertex_capacity,
                                          w->vertex_count + 1, 3 * sizeof(float));
        if (positions == NULL) {
            return stp_fail_memory(w->context);
        }
        w->positions = positions;
        memcpy(positions + 3 * w->vertex_count, &p, sizeof(p));
        w->vertex_count += 1;
    }
    uint32_t* indices = stp_grow_array(w->context, w->indices, &w->index_capacity,
                                       w->index_count + 1, sizeof(uint32_t));
    if (indices == NULL) {
        return stp_fail_memory(w->context);
    }
    w->indices = indices;
    indices[w->index_count++] = index;
    return STP_OK;
}

// Adds what was gathered as an object below the root; as a part of the root itself where it has no
// name.
static stp_result end_solid(welder* w, const char* name)
{
    stp_scene* scene = w->import->scene;
    stp_result result = STP_OK;
    if (w->index_count != 0) {
        result = stp_add_plain_material(w->import, &w->material);
        stp_object object = {
            .name = name, .parent = w->import->root, .transform = stp_affine_identity()};
        if (result == STP_OK && name != NULL) {
            result = stp_scene_add_object(scene, &object, NULL);
        }
        stp_mesh mesh = {.name = name,
                         .vertex_count = (uint32_t)w->vertex_count,
                         .triangle_count = (uint32_t)(w->index_count / 3),
                         .positions = w->positions,
                         .indices = w->indices,
                         .material = w->material};
        stp_part part = {.kind = STP_PART_MESH};
        if (result == STP_OK) {
            w->positions = NULL;
            w->indices = NULL;
            result = stp_scene_add_mesh(scene, &mesh, &part.index);
        }
        if (result == STP_OK) {
            result = stp_scene_add_part(scene, part);
        }
    }
    stp_lookup_destroy(&w->corners);
    stp_free(w->context, w->positions);
    stp_free(w->context, w->indices);
    w->positions = NULL;
    w->indices = NULL;
    w->vertex_count = w->vertex_capacity = w->index_count = w->index_capacity = 0;
    return result;
}

static stp_result read_binary(welder* w, size_t facet_count)
{
    const unsigned char* facet = w->import->file.bytes + HEADER_SIZE;
    if (facet_count >= STP_NONE / 3) {
        return stp_fail(w->context, STP_ERROR_LIMIT, "%s: has more than 2^32 corners",
                        w->import->path);
    }
    for (size_t i = 0; i < facet_count; ++i, facet += FACET_SIZE) {
        for (size_t corner = 0; corner < 3; ++corner) {
            const unsigned char* bytes = facet + 12 + 12 * corner; // the normal comes first
            stp_vec3 p = {stp_read_f32(bytes), stp_read_f32(bytes + 4), stp_read_f32(bytes + 8)};
            stp_result result = stp_is_finite(p) ? add_corner(w, p) : fail_facet(w, i);
            if (result != STP_OK) {
                return result;
            }
        }
    }
    return end_solid(w, NULL);
}

static stp_result fail_line(const welder* w, stp_text text, stp_text at, const char* what)
{
    return stp_fail(w->context, STP_ERROR_FORMAT, "%s: line %llu: %s", w->import->path,
                    (unsigned long long)stp_line_number(text, (size_t)(at - text)), what);
}

static stp_result read_vertex(welder* w, stp_text text, stp_text at)
{
    double n[3];
    stp_text next = at;
    for (int i = 0; i < 3 && next != NULL; ++i) {
        next = stp_read_number(next, &n[i]);
    }
    if (next == NULL) {
        return fail_line(w, text, at, "a vertex has three numbers");
    }
    stp_vec3 p = {(float)n[0], (float)n[1], (float)n[2]};
    if (!stp_is_finite(p)) {
        return fail_line(w, text, at, "the numbers of a vertex are finite");
    }
    if (w->index_count >= STP_NONE) {
        return stp_fail(w->context, STP_ERROR_LIMIT, "%s: has more than 2^32 corners",
                        w->import->path);
    }
    return add_corner(w, p);
}

static stp_result copy_name(const welder* w, stp_text at, const char** name)
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
    *name = stp_arena_copy_text(&w->import->scene->text, (const char*)at, length);
    return *name != NULL ? STP_OK : stp_fail_memory(w->context);
}

// Only "solid", "vertex" and what ends a facet or a solid matter.
static stp_result read_lines(welder* w, stp_text text, stp_text end)
{
    const char* name = NULL;
    size_t facet_start = 0;
    stp_result result = STP_OK;
    for (stp_text at = text; at < end && result == STP_OK;) {
        stp_text word = stp_skip_blanks(at);
        stp_text next = stp_skip_word(word);
        if (stp_word_is(word, next, "vertex")) {
            result = read_vertex(w, text, next);
        } else if (stp_word_is(word, next, "endfacet") || stp_word_is(word, next, "endloop")) {
            size_t corners = w->index_count - facet_start;
            result = corners == 3 || corners == 0
                         ? STP_OK
                         : fail_line(w, text, word, "a facet has three vertices");
            facet_start = w->index_count;
        } else if (stp_word_is(word, next, "solid")) {
            result = end_solid(w, name);
            facet_start = 0;
            if (result == STP_OK) {
                result = copy_name(w, next, &name);
            }
        }
        at = (stp_text)memchr(next, '\n', (size_t)(end - next)) + 1;
    }
    if (result == STP_OK && w->index_count != facet_start) {
        return stp_fail(w->context, STP_ERROR_TRUNCATED, "%s: ends within a facet",
                        w->import->path);
    }
    return result == STP_OK ? end_solid(w, name) : result;
}

static stp_result read_ascii(welder* w)
{
    size_t size = w->import->file.size;
    unsigned char* text = stp_alloc(w->context, size + 1);
    if (text == NULL) {
        return stp_fail_memory(w->context);
    }
    memcpy(text, w->import->file.bytes, size);
    text[size] = '\n';
    stp_result result = read_lines(w, text, text + size + 1);
    stp_free(w->context, text);
    return result;
}

// Whether the size is what the count of facets makes it.
static bool is_binary(const unsigned char* bytes, size_t size)
{
    return size >= HEADER_SIZE && (size - HEADER_SIZE) % FACET_SIZE == 0 &&
           (size - HEADER_SIZE) / FACET_SIZE == stp_read_u32(bytes + 80);
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
    return false; // a binary file says nothing but its size: the extension decides
}

static stp_result read_with(welder* w)
{
    const stp_mapped_file* file = &w->import->file;
    if (file->size != 0 && is_ascii(file->bytes, file->size)) {
        return read_ascii(w);
    }
    if (file->size < HEADER_SIZE) {
        return stp_fail(w->context, STP_ERROR_TRUNCATED,
                        "%s: is shorter than the header of an STL file", w->import->path);
    }
    uint64_t count = stp_read_u32(file->bytes + 80);
    uint64_t held = (file->size - HEADER_SIZE) / FACET_SIZE;
    if (count > held) {
        return stp_fail(w->context, STP_ERROR_TRUNCATED,
                        "%s: has %llu facets by its header, but ends after %llu", w->import->path,
                        (unsigned long long)count, (unsigned long long)held);
    }
    if (!is_binary(file->bytes, file->size)) {
        stp_warn(w->context, "%s: has more bytes than the facets of its header take",
                 w->import->path);
    }
    return read_binary(w, (size_t)count);
}

static stp_result read(stp_import* import)
{
    welder w = {.import = import,
                .context = import->context,
                .corners = {.context = import->context},
                .material = STP_NONE};
    stp_import_default_axes(import, 'z');
    size_t objects = import->scene->part_count;
    stp_result result = read_with(&w);
    stp_lookup_destroy(&w.corners);
    stp_free(w.context, w.positions);
    stp_free(w.context, w.indices);
    if (result == STP_OK && import->scene->part_count == objects) {
        stp_warn(import->context, "%s: has no facets", import->path);
    }
    return result;
}

const stp_importer stp_importer_stl = {
    .name = "stl", .extensions = "stl", .detect = detect, .read = read};
