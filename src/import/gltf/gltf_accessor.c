// SPDX-License-Identifier: MIT
#include "import/gltf/gltf_accessor.h"

#include "base/io/bytes.h"

#include <assert.h>
#include <string.h>

static size_t component_size(stp_gltf_component component)
{
    switch (component) {
    case STP_GLTF_I8:
    case STP_GLTF_U8:
        return 1;
    case STP_GLTF_I16:
    case STP_GLTF_U16:
        return 2;
    case STP_GLTF_U32:
    case STP_GLTF_F32:
        return 4;
    }
    return 0; // not a component type of glTF
}

static uint32_t count_components(const char* type)
{
    static const struct {
        const char* type;
        uint32_t count;
    } types[] = {{"SCALAR", 1}, {"VEC2", 2}, {"VEC3", 3}, {"VEC4", 4},
                 {"MAT2", 4},   {"MAT3", 9}, {"MAT4", 16}};
    for (size_t i = 0; type != NULL && i < sizeof(types) / sizeof(types[0]); ++i) {
        if (strcmp(type, types[i].type) == 0) {
            return types[i].count;
        }
    }
    return 0;
}

// Finds `count` elements of `size` bytes, from `offset` on in a view. *stride receives their
// distance; NULL: they are packed.
static stp_result find_elements(stp_gltf_scope* scope, const stp_gltf_accessor* accessor,
                                uint32_t view, size_t offset, size_t count, size_t size,
                                size_t* stride, const unsigned char** bytes)
{
    size_t view_size, view_stride;
    stp_result result = stp_gltf_view(scope, view, bytes, &view_size, &view_stride);
    if (result != STP_OK) {
        return result;
    }
    if (stride != NULL) {
        *stride = view_stride != 0 ? view_stride : size;
    }
    size_t step = stride != NULL ? *stride : size;
    if (size == 0 || step < size) {
        return stp_gltf_fail(scope, STP_ERROR_FORMAT,
                             "accessors[%u] has elements of %zu bytes, but bufferViews[%u] has a "
                             "stride of %zu",
                             accessor->index, size, view, step);
    }
    bool fits = count == 0 || (offset <= view_size && size <= view_size - offset &&
                               count - 1 <= (view_size - offset - size) / step);
    if (!fits) {
        return stp_gltf_fail(scope, STP_ERROR_FORMAT,
                             "accessors[%u] needs %zu elements of %zu bytes with a stride of %zu "
                             "from byte %zu on, but bufferViews[%u] has %zu bytes",
                             accessor->index, count, size, step, offset, view, view_size);
    }
    assert(count == 0 || offset + (count - 1) * step + size <= view_size);
    *bytes = *bytes != NULL && count != 0 ? *bytes + offset : NULL;
    return STP_OK;
}

static uint32_t read_unsigned(stp_gltf_component component, const unsigned char* bytes)
{
    return component == STP_GLTF_U8    ? bytes[0]
           : component == STP_GLTF_U16 ? stp_read_u16(bytes)
                                       : stp_read_u32(bytes);
}

static stp_result check_sparse_indices(stp_gltf_scope* scope, const stp_gltf_accessor* accessor)
{
    size_t size = component_size(accessor->sparse_component);
    for (size_t i = 0; i < accessor->sparse_count; ++i) {
        uint32_t index =
            read_unsigned(accessor->sparse_component, accessor->sparse_indices + i * size);
        if (index >= accessor->count) {
            return stp_gltf_fail(
                scope, STP_ERROR_FORMAT,
                "accessors[%u]: sparse index %u at %zu, but there are %zu elements",
                accessor->index, index, i, accessor->count);
        }
    }
    return STP_OK;
}

static stp_result get_sparse(stp_gltf_scope* scope, const json_t* sparse,
                             stp_gltf_accessor* accessor)
{
    const json_t *indices, *values;
    stp_result result = stp_gltf_object(scope, sparse, "indices", &indices);
    if (result == STP_OK) {
        result = stp_gltf_object(scope, sparse, "values", &values);
    }
    uint32_t index_view = STP_NONE, value_view = STP_NONE;
    size_t count = 0, component = 0, index_offset = 0, value_offset = 0;
    if (result == STP_OK) {
        result = stp_gltf_size(scope, sparse, "count", &count);
    }
    if (result == STP_OK) {
        result = stp_gltf_size(scope, indices, "componentType", &component);
    }
    if (result == STP_OK) {
        result = stp_gltf_index(scope, indices, "bufferView", STP_GLTF_BUFFER_VIEWS, &index_view);
    }
    if (result == STP_OK) {
        result = stp_gltf_size(scope, indices, "byteOffset", &index_offset);
    }
    if (result == STP_OK) {
        result = stp_gltf_index(scope, values, "bufferView", STP_GLTF_BUFFER_VIEWS, &value_view);
    }
    if (result == STP_OK) {
        result = stp_gltf_size(scope, values, "byteOffset", &value_offset);
    }
    if (result != STP_OK || count == 0) {
        return result;
    }
    bool is_good =
        index_view != STP_NONE && value_view != STP_NONE && count <= accessor->count &&
        (component == STP_GLTF_U8 || component == STP_GLTF_U16 || component == STP_GLTF_U32);
    if (!is_good) {
        return stp_gltf_fail(
            scope, STP_ERROR_FORMAT,
            "accessors[%u]: sparse needs two bufferViews, unsigned indices, and at "
            "most %zu of them, but has %zu",
            accessor->index, accessor->count, count);
    }
    accessor->sparse_component = (stp_gltf_component)component;
    result =
        find_elements(scope, accessor, index_view, index_offset, count,
                      component_size(accessor->sparse_component), NULL, &accessor->sparse_indices);
    if (result == STP_OK) {
        size_t size = component_size(accessor->component) * accessor->component_count;
        result = find_elements(scope, accessor, value_view, value_offset, count, size, NULL,
                               &accessor->sparse_values);
    }
    if (result != STP_OK) {
        return result;
    }
    assert(count <= accessor->count);
    accessor->sparse_count = count;
    return check_sparse_indices(scope, accessor);
}

static stp_result check_header(stp_gltf_scope* scope, const json_t* json, size_t component,
                               const stp_gltf_accessor* accessor)
{
    if (component_size((stp_gltf_component)component) == 0) {
        return stp_gltf_fail(scope, STP_ERROR_FORMAT, "accessors[%u]: componentType %zu is unknown",
                             accessor->index, component);
    }
    if (accessor->component_count == 0) {
        const char* type = stp_gltf_text(json, "type");
        return stp_gltf_fail(scope, STP_ERROR_FORMAT, "accessors[%u]: type %.40s is unknown",
                             accessor->index, type != NULL ? type : "(none)");
    }
    if (accessor->count >= STP_NONE) {
        return stp_gltf_fail(scope, STP_ERROR_LIMIT, "accessors[%u] has %zu elements",
                             accessor->index, accessor->count);
    }
    return STP_OK;
}

stp_result stp_gltf_accessor_describe(stp_gltf_scope* scope, uint32_t index,
                                      stp_gltf_accessor* accessor)
{
    *accessor = (stp_gltf_accessor){.index = index};
    const json_t* json;
    size_t component = 0;
    stp_result result = stp_gltf_item(scope, STP_GLTF_ACCESSORS, index, &json);
    if (result == STP_OK) {
        result = stp_gltf_size(scope, json, "componentType", &component);
    }
    if (result == STP_OK) {
        result = stp_gltf_size(scope, json, "count", &accessor->count);
    }
    if (result != STP_OK) {
        return result;
    }
    accessor->component_count = count_components(stp_gltf_text(json, "type"));
    accessor->normalized = stp_gltf_flag(json, "normalized");
    accessor->component = (stp_gltf_component)component;
    return check_header(scope, json, component, accessor);
}

stp_result stp_gltf_accessor_get(stp_gltf_scope* scope, uint32_t index, stp_gltf_accessor* accessor)
{
    const json_t *json = NULL, *sparse = NULL;
    size_t offset = 0;
    uint32_t view = STP_NONE;
    stp_result result = stp_gltf_accessor_describe(scope, index, accessor);
    if (result == STP_OK) {
        result = stp_gltf_item(scope, STP_GLTF_ACCESSORS, index, &json);
    }
    if (result == STP_OK) {
        result = stp_gltf_size(scope, json, "byteOffset", &offset);
    }
    if (result == STP_OK) {
        result = stp_gltf_index(scope, json, "bufferView", STP_GLTF_BUFFER_VIEWS, &view);
    }
    if (result == STP_OK) {
        result = stp_gltf_object(scope, json, "sparse", &sparse);
    }
    if (result != STP_OK) {
        return result;
    }
    size_t size = component_size(accessor->component) * accessor->component_count;
    if (view != STP_NONE) {
        result = find_elements(scope, accessor, view, offset, accessor->count, size,
                               &accessor->stride, &accessor->bytes);
    } else if (accessor->count > scope->gltf->content_bytes) {
        // zeros take no space in the file, but in memory
        result = stp_gltf_fail(scope, STP_ERROR_LIMIT,
                               "accessors[%u] claims %zu zero elements in a file of %zu bytes",
                               index, accessor->count, scope->gltf->content_bytes);
    }
    return result == STP_OK && sparse != NULL ? get_sparse(scope, sparse, accessor) : result;
}

float stp_gltf_accessor_divisor(const stp_gltf_accessor* accessor)
{
    static const float divisors[] = {127.0f, 255.0f, 32767.0f, 65535.0f, 1.0f, 4294967296.0f};
    int kind = (int)accessor->component - STP_GLTF_I8;
    return accessor->normalized && kind >= 0 && kind < 6 ? divisors[kind] : 1.0f;
}

static float read_component(stp_gltf_component component, const unsigned char* bytes,
                            bool normalized)
{
    switch (component) {
    case STP_GLTF_I8: {
        float value = (float)(int8_t)bytes[0];
        return normalized ? stp_max(value / 127.0f, -1.0f) : value;
    }
    case STP_GLTF_U8:
        return normalized ? (float)bytes[0] / 255.0f : (float)bytes[0];
    case STP_GLTF_I16: {
        float value = (float)(int16_t)stp_read_u16(bytes);
        return normalized ? stp_max(value / 32767.0f, -1.0f) : value;
    }
    case STP_GLTF_U16: {
        float value = (float)stp_read_u16(bytes);
        return normalized ? value / 65535.0f : value;
    }
    case STP_GLTF_U32: {
        double value = (double)stp_read_u32(bytes);
        return (float)(normalized ? value / 4294967295.0 : value);
    }
    case STP_GLTF_F32:
        break;
    }
    return stp_read_f32(bytes);
}

// A separate tight loop for each type.
#define CONVERT(component, size)                                                                   \
    for (size_t i = 0; i < selection->count; ++i) {                                                \
        size_t element = selection->map != NULL ? selection->map[i] : selection->first + i;        \
        const unsigned char* from = accessor->bytes + element * accessor->stride;                  \
        for (size_t c = 0; c < components; ++c) {                                                  \
            out[i * components + c] = read_component((component), from + c * (size), normalized);  \
        }                                                                                          \
    }                                                                                              \
    break

static void convert(const stp_gltf_accessor* accessor, const stp_gltf_selection* selection,
                    float* out)
{
    size_t components = accessor->component_count;
    bool normalized = accessor->normalized;
    switch (accessor->component) {
    case STP_GLTF_I8:
        CONVERT(STP_GLTF_I8, 1);
    case STP_GLTF_U8:
        CONVERT(STP_GLTF_U8, 1);
    case STP_GLTF_I16:
        CONVERT(STP_GLTF_I16, 2);
    case STP_GLTF_U16:
        CONVERT(STP_GLTF_U16, 2);
    case STP_GLTF_U32:
        CONVERT(STP_GLTF_U32, 4);
    case STP_GLTF_F32:
        CONVERT(STP_GLTF_F32, 4);
    }
}

static void substitute(const stp_gltf_accessor* accessor, float* all)
{
    size_t components = accessor->component_count;
    size_t size = component_size(accessor->component);
    size_t index_size = component_size(accessor->sparse_component);
    for (size_t i = 0; i < accessor->sparse_count; ++i) {
        size_t element =
            read_unsigned(accessor->sparse_component, accessor->sparse_indices + i * index_size);
        assert(element < accessor->count && "check_sparse_indices");
        for (size_t c = 0; c < components; ++c) {
            all[element * components + c] = read_component(
                accessor->component, accessor->sparse_values + (i * components + c) * size,
                accessor->normalized);
        }
    }
}

#ifndef NDEBUG
static bool selects_existing(const stp_gltf_selection* selection, size_t count)
{
    for (size_t i = 0; selection->map != NULL && i < selection->count; ++i) {
        if (selection->map[i] >= count) {
            return false;
        }
    }
    return selection->map != NULL || selection->first + selection->count <= count;
}
#endif

stp_result stp_gltf_accessor_floats(stp_gltf_scope* scope, const stp_gltf_accessor* accessor,
                                    const stp_gltf_selection* selection, float* out)
{
    stp_context* context = scope->gltf->context;
    size_t components = accessor->component_count;
    assert(selects_existing(selection, accessor->count));
    if (accessor->sparse_count == 0 && accessor->bytes != NULL) {
        convert(accessor, selection, out);
        return STP_OK;
    }
    if (accessor->sparse_count == 0) {
        memset(out, 0, selection->count * components * sizeof(float));
        return STP_OK;
    }
    // expands all elements with their substitutes, then copies the selected ones
    assert(accessor->sparse_indices != NULL && accessor->sparse_values != NULL);
    float* all = STP_NEW_ZEROED(context, float, (accessor->count * components));
    if (all == NULL) {
        return STP_ERROR_OUT_OF_MEMORY;
    }
    if (accessor->bytes != NULL) {
        convert(accessor, &(stp_gltf_selection){.count = accessor->count}, all);
    }
    substitute(accessor, all);
    for (size_t i = 0; i < selection->count; ++i) {
        size_t element = selection->map != NULL ? selection->map[i] : selection->first + i;
        memcpy(out + i * components, all + element * components, components * sizeof(float));
    }
    stp_free(context, all);
    return STP_OK;
}

stp_result stp_gltf_accessor_indices(stp_gltf_scope* scope, const stp_gltf_accessor* accessor,
                                     uint32_t* out)
{
    stp_gltf_component component = accessor->component;
    bool is_unsigned =
        component == STP_GLTF_U8 || component == STP_GLTF_U16 || component == STP_GLTF_U32;
    if (!is_unsigned || accessor->component_count != 1) {
        return stp_gltf_fail(scope, STP_ERROR_FORMAT,
                             "indices: accessors[%u] is not of unsigned scalars", accessor->index);
    }
    if (accessor->bytes == NULL) {
        memset(out, 0, accessor->count * sizeof(*out));
    } else if (component == STP_GLTF_U8) {
        for (size_t i = 0; i < accessor->count; ++i) {
            out[i] = accessor->bytes[i * accessor->stride];
        }
    } else if (component == STP_GLTF_U16) {
        for (size_t i = 0; i < accessor->count; ++i) {
            out[i] = stp_read_u16(accessor->bytes + i * accessor->stride);
        }
    } else {
        for (size_t i = 0; i < accessor->count; ++i) {
            out[i] = stp_read_u32(accessor->bytes + i * accessor->stride);
        }
    }
    size_t sparse_size = component_size(accessor->sparse_component);
    size_t value_size = component_size(component);
    for (size_t i = 0; i < accessor->sparse_count; ++i) {
        size_t element =
            read_unsigned(accessor->sparse_component, accessor->sparse_indices + i * sparse_size);
        assert(element < accessor->count && "check_sparse_indices");
        out[element] = read_unsigned(component, accessor->sparse_values + i * value_size);
    }
    return STP_OK;
}
