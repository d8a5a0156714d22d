// SPDX-License-Identifier: MIT
#include "import/gltf/gltf.h"

#include <assert.h>
#include <stdio.h>
#include <string.h>

stp_gltf_scope stp_gltf_scope_begin(const stp_gltf* gltf)
{
    return (stp_gltf_scope){.gltf = gltf};
}

void stp_gltf_set_place(stp_gltf_scope* scope, const char* format, ...)
{
    va_list list;
    va_start(list, format);
    vsnprintf(scope->place, sizeof(scope->place), format, list);
    va_end(list);
}

// Replaces the message by "place: sentence".
static void keep_message(stp_gltf_scope* scope, char* out, const char* format, va_list list)
    __attribute__((format(printf, 3, 0)));

static void keep_message(stp_gltf_scope* scope, char* out, const char* format, va_list list)
{
    int written = snprintf(out, STP_GLTF_MESSAGE_SIZE, "%s%s", scope->place,
                           scope->place[0] != '\0' ? ": " : "");
    size_t used = written > 0 ? (size_t)written : 0;
    assert(used < STP_GLTF_MESSAGE_SIZE && "the place is much shorter");
    vsnprintf(out + used, STP_GLTF_MESSAGE_SIZE - used, format, list);
}

stp_result stp_gltf_fail(stp_gltf_scope* scope, stp_result result, const char* format, ...)
{
    va_list list;
    va_start(list, format);
    keep_message(scope, scope->error, format, list);
    va_end(list);
    return result;
}

void stp_gltf_warn(stp_gltf_scope* scope, const char* format, ...)
{
    if (scope->warning[0] == '\0') {
        va_list list;
        va_start(list, format);
        keep_message(scope, scope->warning, format, list);
        va_end(list);
    }
}

stp_result stp_gltf_scope_end(stp_gltf_scope* scope, stp_result result)
{
    stp_context* context = scope->gltf->context;
    const char* path = scope->gltf->import->path;
    if (scope->warning[0] != '\0') {
        stp_warn(context, "%s: %s", path, scope->warning);
        scope->warning[0] = '\0';
    }
    if (result == STP_OK || scope->logged) {
        return result;
    }
    assert(scope->error[0] != '\0' || result == STP_ERROR_OUT_OF_MEMORY);
    return scope->error[0] != '\0' ? stp_fail(context, result, "%s: %s", path, scope->error)
                                   : stp_fail_memory(context);
}

stp_result stp_gltf_logged(stp_gltf_scope* scope, stp_result result)
{
    scope->logged = scope->logged || result != STP_OK;
    return result;
}

static const char* list_name(stp_gltf_list list)
{
    static const char* const names[] = {
#define X(name, text) text,
        STP_GLTF_LISTS(X)
#undef X
    };
    assert((unsigned)list < STP_GLTF_LIST_COUNT);
    return names[list];
}

size_t stp_gltf_count(const stp_gltf* gltf, stp_gltf_list list)
{
    return json_array_size(gltf->lists[list]);
}

// The member, or NULL if it is missing or null.
static const json_t* find(const json_t* object, const char* key)
{
    const json_t* member = json_object_get(object, key);
    return json_is_null(member) ? NULL : member;
}

stp_result stp_gltf_find_lists(stp_gltf_scope* scope, stp_gltf* gltf)
{
    for (int i = 0; i < STP_GLTF_LIST_COUNT; ++i) {
        const char* name = list_name((stp_gltf_list)i);
        stp_result result = stp_gltf_array(scope, gltf->root, name, &gltf->lists[i]);
        if (result != STP_OK) {
            return result;
        }
        if (json_array_size(gltf->lists[i]) >= STP_NONE) {
            return stp_gltf_fail(scope, STP_ERROR_LIMIT, "%s has more than 2^32 entries", name);
        }
    }
    return STP_OK;
}

stp_result stp_gltf_item(stp_gltf_scope* scope, stp_gltf_list list, size_t index,
                         const json_t** item)
{
    *item = json_array_get(scope->gltf->lists[list], index);
    if (!json_is_object(*item)) {
        scope->place[0] = '\0'; // the item itself is the location
        return stp_gltf_fail(scope, STP_ERROR_FORMAT, "%s[%zu] is not an object", list_name(list),
                             index);
    }
    return STP_OK;
}

stp_result stp_gltf_object(stp_gltf_scope* scope, const json_t* object, const char* key,
                           const json_t** member)
{
    *member = find(object, key);
    if (*member != NULL && !json_is_object(*member)) {
        return stp_gltf_fail(scope, STP_ERROR_FORMAT, "%s is not an object", key);
    }
    return STP_OK;
}

stp_result stp_gltf_array(stp_gltf_scope* scope, const json_t* object, const char* key,
                          const json_t** member)
{
    *member = find(object, key);
    if (*member != NULL && !json_is_array(*member)) {
        return stp_gltf_fail(scope, STP_ERROR_FORMAT, "%s is not an array", key);
    }
    return STP_OK;
}

stp_result stp_gltf_extension(stp_gltf_scope* scope, const json_t* object, const char* name,
                              const json_t** member)
{
    const json_t* extensions;
    stp_result result = stp_gltf_object(scope, object, "extensions", &extensions);
    return result == STP_OK ? stp_gltf_object(scope, extensions, name, member) : result;
}

// Numbers such as 3.0 count as whole. False if it is not a number, negative, or at least 2^53.
static bool to_size(const json_t* value, size_t* out)
{
    if (json_is_integer(value)) {
        json_int_t whole = json_integer_value(value);
        *out = (size_t)whole;
        return whole >= 0 && whole < (json_int_t)1 << 53;
    }
    if (json_is_real(value)) {
        double real = json_real_value(value);
        if (real >= 0.0 && real < 9007199254740992.0) {
            *out = (size_t)real;
            return (double)*out == real;
        }
    }
    return false;
}

stp_result stp_gltf_index(stp_gltf_scope* scope, const json_t* object, const char* key,
                          stp_gltf_list list, uint32_t* index)
{
    const json_t* member = find(object, key);
    *index = STP_NONE;
    if (member == NULL) {
        return STP_OK;
    }
    size_t value;
    if (!to_size(member, &value)) {
        return stp_gltf_fail(scope, STP_ERROR_FORMAT, "%s is not an index", key);
    }
    size_t count = stp_gltf_count(scope->gltf, list);
    if (value >= count) {
        return stp_gltf_fail(scope, STP_ERROR_FORMAT, "%s is %zu, but there are %zu %s", key, value,
                             count, list_name(list));
    }
    *index = (uint32_t)value;
    return STP_OK;
}

stp_result stp_gltf_size(stp_gltf_scope* scope, const json_t* object, const char* key,
                         size_t* value)
{
    const json_t* member = find(object, key);
    if (member != NULL && !to_size(member, value)) {
        return stp_gltf_fail(scope, STP_ERROR_FORMAT, "%s is not a whole number of at least 0",
                             key);
    }
    return STP_OK;
}

stp_result stp_gltf_number(stp_gltf_scope* scope, const json_t* object, const char* key,
                           double* value)
{
    const json_t* member = find(object, key);
    if (member == NULL) {
        return STP_OK;
    }
    if (!json_is_number(member)) {
        return stp_gltf_fail(scope, STP_ERROR_FORMAT, "%s is not a number", key);
    }
    *value = json_number_value(member);
    return STP_OK;
}

stp_result stp_gltf_numbers(stp_gltf_scope* scope, const json_t* object, const char* key,
                            size_t count, double* values)
{
    const json_t* member = find(object, key);
    if (member == NULL) {
        return STP_OK;
    }
    assert(count > 0);
    bool fits = json_is_array(member) && json_array_size(member) == count;
    for (size_t i = 0; fits && i < count; ++i) {
        const json_t* element = json_array_get(member, i);
        fits = json_is_number(element);
        values[i] = json_number_value(element);
    }
    if (!fits) {
        return stp_gltf_fail(scope, STP_ERROR_FORMAT, "%s is not an array of %zu numbers", key,
                             count);
    }
    return STP_OK;
}

const char* stp_gltf_text(const json_t* object, const char* key)
{
    return json_string_value(json_object_get(object, key));
}

bool stp_gltf_flag(const json_t* object, const char* key)
{
    return json_is_true(json_object_get(object, key));
}

stp_result stp_gltf_element_index(stp_gltf_scope* scope, const json_t* array, size_t element,
                                  size_t limit, uint32_t* index)
{
    size_t value;
    if (!to_size(json_array_get(array, element), &value) || value >= limit) {
        return stp_gltf_fail(scope, STP_ERROR_FORMAT, "element %zu is not an index below %zu",
                             element, limit);
    }
    *index = (uint32_t)value;
    return STP_OK;
}
