// SPDX-License-Identifier: MIT
// The XML of a 3MF model. Names are compared without their prefixes, because each of the
// specifications has elements of its own.
#include "import/reading/text.h"
#include "import/reading/xml_reading.h"
#include "import/threemf/threemf.h"

#include <assert.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { NUMBERS_SIZE = 1024, DEPTH_MAX = 64 }; // bytes of an attribute with numbers

typedef struct parsing {
    stp_xml_reading xml;
    stp_3mf* m;
    uint32_t model;
    double unit_metres;
    stp_3mf_object* object; ///< the one being read; NULL: none
    stp_3mf_group* group;
    const XML_Char** attributes; ///< of the element being read
    int depth;
    bool stopped;
    bool logged; ///< the failure that stopped it is already logged
    bool no_memory;
} parsing;

static void stop(parsing* p)
{
    p->stopped = true;
    (void)XML_StopParser(p->xml.parser, XML_FALSE);
}

static void stop_with(parsing* p, const char* fault)
{
    p->xml.refused = p->stopped ? p->xml.refused : fault;
    stop(p);
}

static void stop_memory(parsing* p)
{
    p->no_memory = true;
    stop(p);
}

// After a call that has logged why it failed.
static void stop_logged(parsing* p)
{
    p->logged = true;
    stop(p);
}

static const char* attribute(const parsing* p, const char* name)
{
    for (const XML_Char** at = p->attributes; *at != NULL; at += 2) {
        if (strcmp(stp_xml_local_name(at[0]), name) == 0) {
            return at[1];
        }
    }
    return NULL;
}

// Reads numbers of an attribute. @return their number
static int read_numbers(const parsing* p, const char* name, double* numbers, int limit)
{
    unsigned char text[NUMBERS_SIZE];
    const char* value = attribute(p, name);
    size_t length = value != NULL ? strlen(value) : sizeof(text);
    if (length + 1 >= sizeof(text)) {
        return 0;
    }
    memcpy(text, value, length);
    text[length] = '\n';
    int count = 0;
    for (stp_text at = text; count < limit; ++count) {
        at = stp_skip_blanks(at);
        at = *at != '\n' ? stp_read_number(at, &numbers[count]) : NULL;
        if (at == NULL) {
            break;
        }
    }
    return count;
}

// A whole number; `missing` if the attribute is missing or is none.
static uint32_t read_index(const parsing* p, const char* name, uint32_t missing)
{
    double number;
    bool good = read_numbers(p, name, &number, 1) == 1 && number >= 0.0 &&
                number < (double)STP_NONE && number == floor(number);
    return good ? (uint32_t)number : missing;
}

static const char* copy_text(parsing* p, const char* text)
{
    if (text == NULL || text[0] == '\0') {
        return NULL;
    }
    const char* copy = stp_arena_copy_text(&p->m->import->scene->text, text, strlen(text));
    if (copy == NULL) {
        stop_memory(p);
    }
    return copy;
}

typedef struct resource_key {
    uint32_t kind, model, id;
} resource_key;

uint32_t stp_3mf_find(const stp_3mf* m, stp_3mf_kind kind, uint32_t model, uint32_t id)
{
    resource_key key = {(uint32_t)kind, model, id};
    return stp_lookup_find(&m->names, &key, sizeof(key), STP_NONE);
}

stp_result stp_3mf_find_model(stp_3mf* m, const char* path, uint32_t* model)
{
    uint32_t fresh = (uint32_t)m->model_count;
    stp_result result = stp_lookup_add(&m->paths, path, strlen(path), fresh, model);
    if (result != STP_OK || *model != fresh) {
        return result;
    }
    if (!STP_MAKE_ROOM(m->context, m->models, m->model_capacity, m->model_count + 1)) {
        return stp_fail_memory(m->context);
    }
    m->models[m->model_count++] = path;
    return STP_OK;
}

// The first resource with an id wins.
static void name_resource(parsing* p, stp_3mf_kind kind, size_t index)
{
    resource_key key = {(uint32_t)kind, p->model, read_index(p, "id", STP_NONE)};
    uint32_t found;
    if (stp_lookup_add(&p->m->names, &key, sizeof(key), (uint32_t)index, &found) != STP_OK) {
        stop_logged(p);
    }
}

#define ADD(p, array, count, capacity)                                                             \
    (STP_MAKE_ROOM((p)->m->context, (p)->m->array, (p)->m->capacity, (p)->m->count + 1)            \
         ? &(p)->m->array[(p)->m->count++]                                                         \
         : (stop_memory(p), NULL))

static void begin_group(parsing* p, uint32_t texture)
{
    stp_3mf_group* group = ADD(p, groups, group_count, group_capacity);
    if (group != NULL) {
        *group = (stp_3mf_group){.texture = texture, .first = p->m->value_count};
        name_resource(p, STP_3MF_GROUP, p->m->group_count - 1);
    }
    p->group = group;
}

static void add_value(parsing* p, const float value[4])
{
    if (p->group == NULL) {
        return;
    }
    float(*added)[4] = ADD(p, values, value_count, value_capacity);
    if (added != NULL) {
        memcpy(*added, value, sizeof(*added));
        p->group->count += 1;
    }
}

// "#RRGGBB" or "#RRGGBBAA"; white if it is neither.
static void add_color(parsing* p, const char* text)
{
    float color[4] = {1.0f, 1.0f, 1.0f, 1.0f};
    size_t length = text != NULL ? strlen(text) : 0;
    char* end;
    if ((length == 7 || length == 9) && text[0] == '#') {
        unsigned long bits = strtoul(text + 1, &end, 16);
        bits = length == 7 ? bits << 8 | 0xff : bits;
        for (int i = 0; i < 4 && *end == '\0'; ++i) {
            color[i] = (float)(bits >> (24 - 8 * i) & 0xff) / 255.0f;
        }
    }
    add_value(p, color);
}

static stp_wrap read_wrap(const parsing* p, const char* name)
{
    const char* style = attribute(p, name);
    return style == NULL                  ? STP_WRAP_REPEAT
           : strcmp(style, "mirror") == 0 ? STP_WRAP_MIRROR
           : strcmp(style, "wrap") == 0   ? STP_WRAP_REPEAT
                                          : STP_WRAP_CLAMP;
}

static void add_texture(parsing* p)
{
    const char* path = attribute(p, "path");
    struct {
        stp_hash path;
        uint64_t wrap_u, wrap_v;
    } key = {
        stp_hash_bytes((stp_hash){0}, path != NULL ? path : "", path != NULL ? strlen(path) : 0),
        read_wrap(p, "tilestyleu"), read_wrap(p, "tilestylev")};
    uint32_t fresh = (uint32_t)p->m->texture_count, found;
    if (stp_lookup_add(&p->m->pictures, &key, sizeof(key), fresh, &found) != STP_OK) {
        stop_logged(p);
        return;
    }
    stp_3mf_texture* texture =
        found == fresh ? ADD(p, textures, texture_count, texture_capacity) : NULL;
    if (texture != NULL) {
        *texture = (stp_3mf_texture){.path = copy_text(p, path),
                                     .wrap_u = (stp_wrap)key.wrap_u,
                                     .wrap_v = (stp_wrap)key.wrap_v,
                                     .material = STP_NONE,
                                     .builder = SIZE_MAX};
    }
    name_resource(p, STP_3MF_TEXTURE, found);
}

static void add_texcoord(parsing* p)
{
    double u = 0.0, v = 0.0;
    (void)read_numbers(p, "u", &u, 1);
    (void)read_numbers(p, "v", &v, 1);
    float value[4] = {(float)u, 1.0f - (float)v, 0.0f, 0.0f}; // v starts at the bottom
    value[0] = isfinite(value[0]) ? value[0] : 0.0f;
    value[1] = isfinite(value[1]) ? value[1] : 0.0f;
    add_value(p, value);
}

static void begin_object(parsing* p)
{
    stp_3mf* m = p->m;
    stp_3mf_object* object = ADD(p, objects, object_count, object_capacity);
    p->object = object;
    if (object == NULL) {
        return;
    }
    uint32_t group = read_index(p, "pid", STP_NONE);
    *object = (stp_3mf_object){
        .model = p->model,
        .name = copy_text(p, attribute(p, "name")),
        .group = group != STP_NONE ? stp_3mf_find(m, STP_3MF_GROUP, p->model, group) : STP_NONE,
        .value = read_index(p, "pindex", 0),
        .first_vertex = m->vertex_count,
        .first_triangle = m->triangle_count,
        .first_use = m->use_count,
        .added = STP_NONE};
    name_resource(p, STP_3MF_OBJECT, m->object_count - 1);
}

static void add_vertex(parsing* p)
{
    double place[3];
    bool good = read_numbers(p, "x", &place[0], 1) == 1 &&
                read_numbers(p, "y", &place[1], 1) == 1 && read_numbers(p, "z", &place[2], 1) == 1;
    if (!good || p->object == NULL) {
        stop_with(p, "has a vertex without three coordinates, or outside an object");
        return;
    }
    float(*vertex)[3] = ADD(p, vertices, vertex_count, vertex_capacity);
    for (int i = 0; i < 3 && vertex != NULL; ++i) {
        (*vertex)[i] = (float)place[i]; // if not finite, the scene drops the triangles
    }
    p->object->vertex_count += vertex != NULL;
}

static void add_triangle(parsing* p)
{
    static const char* const corner_names[] = {"v1", "v2", "v3"};
    static const char* const value_names[] = {"p1", "p2", "p3"};
    stp_3mf_object* object = p->object;
    stp_3mf_triangle t = {.group = object != NULL ? object->group : STP_NONE};
    for (int i = 0; i < 3; ++i) {
        t.corners[i] = read_index(p, corner_names[i], STP_NONE);
        if (object == NULL || t.corners[i] >= object->vertex_count) {
            stop_with(p, "has a triangle with a vertex that does not exist");
            return;
        }
    }
    uint32_t id = read_index(p, "pid", STP_NONE);
    if (id != STP_NONE) {
        t.group = stp_3mf_find(p->m, STP_3MF_GROUP, p->model, id);
    }
    uint32_t first = read_index(p, "p1", object->value);
    for (int i = 0; i < 3; ++i) {
        t.values[i] = i == 0 ? first : read_index(p, value_names[i], first);
    }
    stp_3mf_triangle* added = ADD(p, triangles, triangle_count, triangle_capacity);
    if (added != NULL) {
        *added = t;
        object->triangle_count += 1;
    }
}

// The file has the matrix transposed: its rows are our columns.
static bool read_transform(const parsing* p, stp_affine* transform)
{
    double n[12];
    *transform = stp_affine_identity();
    if (attribute(p, "transform") == NULL) {
        return true;
    }
    if (read_numbers(p, "transform", n, 12) != 12) {
        return false;
    }
    bool finite = true;
    for (int i = 0; i < 12; ++i) {
        transform->m[i % 3][i / 3] = n[i];
        finite = finite && isfinite(n[i]);
    }
    return finite;
}

static void fill_use(parsing* p, stp_3mf_use* use)
{
    const char* path = attribute(p, "path");
    *use = (stp_3mf_use){.model = p->model,
                         .id = read_index(p, "objectid", STP_NONE),
                         .name = copy_text(p, attribute(p, "partnumber"))};
    if (!read_transform(p, &use->transform)) {
        stop_with(p, "has a transform that is not twelve numbers");
    }
    if (path == NULL || p->stopped) {
        return;
    }
    use->path = copy_text(p, path + (path[0] == '/'));
    if (use->path != NULL && stp_3mf_find_model(p->m, use->path, &use->model) != STP_OK) {
        stop_logged(p);
    }
}

static double unit_named(const char* name)
{
    static const struct {
        const char* name;
        double metres;
    } units[] = {
        {"micron", 1e-6}, {"centimeter", 0.01}, {"inch", 0.0254}, {"foot", 0.3048}, {"meter", 1.0}};
    for (size_t i = 0; name != NULL && i < sizeof(units) / sizeof(units[0]); ++i) {
        if (strcmp(units[i].name, name) == 0) {
            return units[i].metres;
        }
    }
    return 0.001;
}

static void begin_use(parsing* p, bool item)
{
    stp_3mf* m = p->m;
    if (item && m->root == STP_NONE) {
        m->root = p->model;
        m->unit_metres = p->unit_metres;
    }
    if (item && p->model == m->root) { // builds of other models do not count
        stp_3mf_use* use = ADD(p, items, item_count, item_capacity);
        if (use != NULL) {
            fill_use(p, use);
        }
    } else if (!item && p->object != NULL) {
        stp_3mf_use* use = ADD(p, uses, use_count, use_capacity);
        if (use != NULL) {
            p->object->use_count += 1;
            fill_use(p, use);
        }
    }
}

static bool is_one_of(const char* name, const char* a, const char* b)
{
    return strcmp(name, a) == 0 || strcmp(name, b) == 0;
}

static void XMLCALL begin_element(void* user, const XML_Char* full, const XML_Char** attributes)
{
    parsing* p = user;
    const char* name = stp_xml_local_name(full);
    p->attributes = attributes;
    p->depth += 1;
    if (p->depth > DEPTH_MAX) {
        stop_with(p, "is nested too deeply");
    } else if (strcmp(name, "vertex") == 0) {
        add_vertex(p);
    } else if (strcmp(name, "triangle") == 0) {
        add_triangle(p);
    } else if (strcmp(name, "object") == 0) {
        begin_object(p);
    } else if (strcmp(name, "component") == 0) {
        begin_use(p, false);
    } else if (strcmp(name, "item") == 0) {
        begin_use(p, true);
    } else if (is_one_of(name, "basematerials", "colorgroup")) {
        begin_group(p, STP_NONE);
    } else if (strcmp(name, "texture2dgroup") == 0) {
        uint32_t texture =
            stp_3mf_find(p->m, STP_3MF_TEXTURE, p->model, read_index(p, "texid", STP_NONE));
        begin_group(p, texture);
        p->group = texture != STP_NONE ? p->group : NULL; // then its coordinates mean nothing
    } else if (strcmp(name, "base") == 0) {
        add_color(p, attribute(p, "displaycolor"));
    } else if (strcmp(name, "color") == 0) {
        add_color(p, attribute(p, "color"));
    } else if (strcmp(name, "tex2coord") == 0) {
        add_texcoord(p);
    } else if (strcmp(name, "texture2d") == 0) {
        add_texture(p);
    } else if (strcmp(name, "model") == 0) {
        p->unit_metres = unit_named(attribute(p, "unit"));
        p->m->unit_metres = p->model == p->m->root ? p->unit_metres : p->m->unit_metres;
    } else if (strcmp(name, "beam") == 0) {
        stp_losses_add(&p->m->import->losses, STP_LOSS_LINE, 1);
    }
}

static void XMLCALL end_element(void* user, const XML_Char* full)
{
    parsing* p = user;
    const char* name = stp_xml_local_name(full);
    p->depth -= 1;
    if (strcmp(name, "object") == 0) {
        p->object = NULL;
    } else if (is_one_of(name, "basematerials", "colorgroup") ||
               strcmp(name, "texture2dgroup") == 0) {
        p->group = NULL;
    }
}

static stp_result fail(const parsing* p)
{
    const stp_import* import = p->m->import;
    enum XML_Error code = XML_GetErrorCode(p->xml.parser);
    if (p->logged) {
        return STP_ERROR_OUT_OF_MEMORY; // the only failure of lookups
    }
    if (p->no_memory || code == XML_ERROR_NO_MEMORY) {
        return stp_fail_memory(import->context);
    }
    return stp_fail(import->context, STP_ERROR_FORMAT, "%s: %s: line %llu %s%s", import->path,
                    p->m->models[p->model],
                    (unsigned long long)XML_GetCurrentLineNumber(p->xml.parser),
                    p->xml.refused != NULL ? "" : "cannot be read: ",
                    p->xml.refused != NULL ? p->xml.refused : XML_ErrorString(code));
}

static stp_result parse_bytes(parsing* p, const unsigned char* bytes, size_t size)
{
    enum { STEP = 1 << 20 };
    stp_xml_begin(&p->xml);
    XML_SetElementHandler(p->xml.parser, begin_element, end_element);
    for (size_t at = 0; at <= size; at += STEP) {
        size_t part = size - at < STEP ? size - at : STEP;
        if (XML_Parse(p->xml.parser, (const char*)bytes + at, (int)part, at + STEP > size) !=
            XML_STATUS_OK) {
            return fail(p);
        }
    }
    return STP_OK;
}

stp_result stp_3mf_parse(stp_3mf* m, uint32_t model)
{
    assert(model < m->model_count);
    const char* path = m->models[model];
    const stp_zip_entry* entry = stp_zip_find(&m->zip, path);
    unsigned char* bytes;
    size_t size;
    if (entry == NULL) {
        return stp_fail(m->context, STP_ERROR_FORMAT, "%s: has no \"%.200s\"", m->import->path,
                        path);
    }
    stp_result result = stp_zip_read(&m->zip, entry, &bytes, &size);
    if (result != STP_OK) {
        return result;
    }
    parsing p = {.m = m, .model = model, .xml.parser = XML_ParserCreate(NULL)};
    result = p.xml.parser != NULL ? parse_bytes(&p, bytes, size) : stp_fail_memory(m->context);
    if (p.xml.parser != NULL) {
        XML_ParserFree(p.xml.parser);
    }
    stp_free(m->context, bytes);
    return result;
}
