// SPDX-License-Identifier: MIT
#include "import/e57/e57.h"
#include "import/reading/text.h"
#include "import/reading/xml_reading.h"

#include <assert.h>
#include <errno.h>
#include <stdlib.h>
#include <string.h>

#define MAX_SIZE ((uint64_t)64 << 20) ///< bytes of the XML section
#define DEPTH_MAX 64
#define NODES_MAX ((size_t)1 << 20)

typedef struct parsing {
    stp_xml_reading xml;
    stp_e57* e57;
    stp_e57_node* open; ///< innermost element
    size_t depth, node_count;
    char* text; ///< text of the innermost element so far
    size_t length, capacity;
    bool out_of_memory;
} parsing;

static void stop(parsing* p, const char* why)
{
    p->xml.refused = why;
    p->out_of_memory = p->out_of_memory || why == NULL;
    (void)XML_StopParser(p->xml.parser, XML_FALSE);
}

// A copy followed by a line end, for number parsing.
static bool copy_text(stp_arena* arena, const char* bytes, size_t length, stp_e57_text* text)
{
    char* copy = stp_arena_alloc(arena, length + 2);
    if (copy == NULL) {
        return false;
    }
    memcpy(copy, bytes, length);
    memcpy(copy + length, "\n", 2);
    *text = (stp_e57_text){copy, length};
    return true;
}

static bool add_attribute(stp_arena* arena, stp_e57_node* node, const XML_Char** pair)
{
    stp_e57_attribute* a = STP_ARENA_ARRAY(arena, stp_e57_attribute, 1);
    if (a == NULL) {
        return false;
    }
    a->next = node->attributes;
    a->name = stp_arena_copy_text(arena, pair[0], strlen(pair[0]));
    node->attributes = a;
    return a->name != NULL && copy_text(arena, pair[1], strlen(pair[1]), &a->value);
}

static void XMLCALL begin_element(void* user, const XML_Char* name, const XML_Char** attributes)
{
    parsing* p = user;
    stp_arena* arena = &p->e57->arena;
    p->node_count += 1;
    p->depth += 1;
    if (p->depth > DEPTH_MAX || p->node_count > NODES_MAX) {
        stop(p, p->depth > DEPTH_MAX ? "is nested too deeply" : "has too many elements");
        return;
    }
    stp_e57_node* node = STP_ARENA_ARRAY(arena, stp_e57_node, 1);
    if (node == NULL) {
        stop(p, NULL);
        return;
    }
    *node =
        (stp_e57_node){.name = stp_arena_copy_text(arena, name, strlen(name)), .parent = p->open};
    bool good = node->name != NULL;
    for (size_t i = 0; good && attributes[i] != NULL; i += 2) {
        good = add_attribute(arena, node, attributes + i);
    }
    if (!good) {
        stop(p, NULL);
        return;
    }
    if (p->open == NULL) {
        p->e57->root = node;
    } else if (p->open->last == NULL) {
        p->open->first = p->open->last = node;
    } else {
        p->open->last->next = node;
        p->open->last = node;
    }
    p->open = node;
    p->length = 0;
}

// Only elements without children keep their text.
static void XMLCALL end_element(void* user, const XML_Char* name)
{
    (void)name;
    parsing* p = user;
    if (p->xml.refused != NULL || p->out_of_memory) { // called once more after `stop`
        return;
    }
    if (p->open->first == NULL && p->length > 0 &&
        !copy_text(&p->e57->arena, p->text, p->length, &p->open->text)) {
        stop(p, NULL);
        return;
    }
    assert(p->depth > 0);
    p->length = 0;
    p->depth -= 1;
    p->open = p->open->parent;
}

static void XMLCALL add_text(void* user, const XML_Char* bytes, int length)
{
    parsing* p = user;
    assert(length >= 0 && p->length <= p->capacity);
    size_t needed = p->length + (size_t)length;
    if (needed > p->capacity) {
        if (!STP_MAKE_ROOM(p->e57->import->context, p->text, p->capacity, needed)) {
            stop(p, NULL);
            return;
        }
    }
    memcpy(p->text + p->length, bytes, (size_t)length);
    p->length = needed;
}

static stp_result fail(const parsing* p)
{
    const stp_import* import = p->e57->import;
    enum XML_Error code = XML_GetErrorCode(p->xml.parser);
    if (p->out_of_memory || code == XML_ERROR_NO_MEMORY) {
        return stp_fail_memory(import->context);
    }
    return stp_fail(import->context, STP_ERROR_FORMAT, "%s: line %llu of its XML section %s%s",
                    import->path, (unsigned long long)XML_GetCurrentLineNumber(p->xml.parser),
                    p->xml.refused != NULL ? "" : "cannot be read: ",
                    p->xml.refused != NULL ? p->xml.refused : XML_ErrorString(code));
}

static stp_result parse(parsing* p)
{
    const stp_e57* e57 = p->e57;
    stp_xml_begin(&p->xml);
    XML_SetElementHandler(p->xml.parser, begin_element, end_element);
    XML_SetCharacterDataHandler(p->xml.parser, add_text);
    uint64_t at = e57->xml_logical, end = at + e57->xml_length;
    do {
        const unsigned char* bytes = (const unsigned char*)"";
        size_t held = at < end ? stp_e57_peek(e57, at, &bytes) : 0;
        held = held < end - at ? held : (size_t)(end - at);
        assert((held > 0 || at == end) && "the section lies within the file");
        at += held;
        if (XML_Parse(p->xml.parser, (const char*)bytes, (int)held, at == end) != XML_STATUS_OK) {
            return fail(p);
        }
    } while (at < end);
    return STP_OK;
}

stp_result stp_e57_read_tree(stp_e57* e57)
{
    stp_context* context = e57->import->context;
    if (e57->xml_length > MAX_SIZE) {
        return stp_fail(context, STP_ERROR_LIMIT,
                        "%s: its XML section has %llu bytes, more than %llu", e57->import->path,
                        (unsigned long long)e57->xml_length, (unsigned long long)MAX_SIZE);
    }
    parsing p = {.e57 = e57, .xml.parser = XML_ParserCreate(NULL)};
    if (p.xml.parser == NULL) {
        return stp_fail_memory(context);
    }
    stp_result result = parse(&p);
    XML_ParserFree(p.xml.parser);
    stp_free(context, p.text);
    return result;
}

const stp_e57_node* stp_e57_child(const stp_e57_node* node, const char* name)
{
    const stp_e57_node* child = node != NULL ? node->first : NULL;
    while (child != NULL && strcmp(child->name, name) != 0) {
        child = child->next;
    }
    return child;
}

const stp_e57_text* stp_e57_attribute_of(const stp_e57_node* node, const char* name)
{
    const stp_e57_attribute* a = node->attributes;
    while (a != NULL && strcmp(a->name, name) != 0) {
        a = a->next;
    }
    return a != NULL ? &a->value : NULL;
}

bool stp_e57_number(const stp_e57_text* text, double* value)
{
    double read;
    bool good =
        text != NULL && text->length > 0 && stp_read_number((stp_text)text->bytes, &read) != NULL;
    *value = good ? read : *value;
    return good;
}

bool stp_e57_integer(const stp_e57_text* text, int64_t* value)
{
    if (text == NULL || text->length == 0) {
        return false;
    }
    char* end;
    errno = 0;
    long long read = strtoll(text->bytes, &end, 10);
    if (end == text->bytes || errno != 0) {
        return false;
    }
    *value = read;
    return true;
}

bool stp_e57_unsigned(const stp_e57_text* text, uint64_t* value)
{
    int64_t read = -1;
    bool good = stp_e57_integer(text, &read) && read >= 0;
    *value = good ? (uint64_t)read : *value;
    return good;
}
