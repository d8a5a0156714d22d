// SPDX-License-Identifier: MIT
// Converts the indices of a primitive to a list of triangles and finds the vertices it uses:
// exporters often let many primitives share one large vertex array, which each primitive would
// otherwise copy.
#include "base/core/sort.h"
#include "import/gltf/gltf_primitive.h"

#include <assert.h>
#include <string.h>

static stp_result check_indices(stp_gltf_scope* scope, const uint32_t* indices, size_t count,
                                size_t vertex_count)
{
    uint32_t largest = 0;
    for (size_t i = 0; i < count; ++i) {
        largest = indices[i] > largest ? indices[i] : largest;
    }
    if (count == 0 || largest < vertex_count) {
        return STP_OK;
    }
    size_t at = 0;
    while (indices[at] < vertex_count) {
        at += 1;
    }
    return stp_gltf_fail(scope, STP_ERROR_FORMAT, "index %u at %zu, but there are %zu vertices",
                         indices[at], at, vertex_count);
}

// The stored indices; NULL if the primitive has none and uses its vertices in order.
static stp_result read_indices(stp_gltf_scope* scope, const json_t* primitive, size_t vertex_count,
                               uint32_t** indices, size_t* count)
{
    uint32_t index = STP_NONE;
    *indices = NULL;
    *count = vertex_count;
    stp_result result = stp_gltf_index(scope, primitive, "indices", STP_GLTF_ACCESSORS, &index);
    if (result != STP_OK || index == STP_NONE) {
        return result;
    }
    stp_gltf_accessor accessor;
    result = stp_gltf_accessor_get(scope, index, &accessor);
    if (result != STP_OK) {
        return result;
    }
    *count = accessor.count;
    *indices = STP_NEW_ARRAY(scope->gltf->context, uint32_t, accessor.count);
    if (*indices == NULL) {
        return STP_ERROR_OUT_OF_MEMORY;
    }
    result = stp_gltf_accessor_indices(scope, &accessor, *indices);
    if (result == STP_OK) {
        result = check_indices(scope, *indices, *count, vertex_count);
    }
    if (result != STP_OK) {
        stp_free(scope->gltf->context, *indices);
        *indices = NULL;
    }
    return result;
}

static uint32_t index_at(const uint32_t* indices, size_t i)
{
    return indices != NULL ? indices[i] : (uint32_t)i;
}

// Writes the triangles of a strip or fan; drops degenerate ones, which join strips.
static size_t unroll(const uint32_t* indices, size_t count, stp_gltf_mode mode, uint32_t* out)
{
    size_t triangles = 0;
    for (size_t i = 0; i + 2 < count; ++i) {
        uint32_t a = index_at(indices, i), b = index_at(indices, i + 1 + i % 2),
                 c = index_at(indices, i + 2 - i % 2);
        if (mode == STP_GLTF_TRIANGLE_FAN) {
            a = index_at(indices, i + 1);
            b = index_at(indices, i + 2);
            c = index_at(indices, 0);
        }
        if (a != b && b != c && c != a) {
            memcpy(out + 3 * triangles++, (const uint32_t[3]){a, b, c}, 3 * sizeof(uint32_t));
        }
    }
    assert(triangles == 0 || triangles <= count - 2);
    return triangles;
}

static stp_result assemble(stp_gltf_scope* scope, stp_gltf_mode mode, uint32_t* stored,
                           size_t count, uint32_t** indices, size_t* triangle_count)
{
    stp_context* context = scope->gltf->context;
    if (mode == STP_GLTF_TRIANGLES) {
        if (count % 3 != 0) {
            stp_gltf_warn(scope, "%zu indices do not make triangles: the last are left out", count);
        }
        *triangle_count = count / 3;
        if (stored != NULL) {
            *indices = stored;
            return STP_OK;
        }
        *indices = STP_NEW_ARRAY(context, uint32_t, *triangle_count * 3);
        for (size_t i = 0; *indices != NULL && i < *triangle_count * 3; ++i) {
            (*indices)[i] = (uint32_t)i;
        }
        return *indices != NULL ? STP_OK : STP_ERROR_OUT_OF_MEMORY;
    }
    size_t maximum = count < 3 ? 0 : count - 2;
    *indices = maximum <= SIZE_MAX / 3 ? STP_NEW_ARRAY(context, uint32_t, maximum * 3) : NULL;
    if (*indices != NULL) {
        *triangle_count = unroll(stored, count, mode, *indices);
    }
    stp_free(context, stored);
    return *indices != NULL ? STP_OK : STP_ERROR_OUT_OF_MEMORY;
}

// Renumbers the used vertices of [low, low + range) in ascending order.
static stp_result number_used(stp_gltf_scope* scope, uint32_t low, size_t range, uint32_t* indices,
                              size_t count, stp_gltf_selection* selection)
{
    stp_context* context = scope->gltf->context;
    uint32_t* numbers = STP_NEW_ZEROED(context, uint32_t, range);
    if (numbers == NULL) {
        return STP_ERROR_OUT_OF_MEMORY;
    }
    for (size_t i = 0; i < count; ++i) {
        numbers[indices[i] - low] = 1;
    }
    uint32_t used = 0;
    for (size_t i = 0; i < range; ++i) {
        used += numbers[i];
    }
    assert(used > 0 && used <= count && used <= range);
    uint32_t* map = STP_NEW_ARRAY(context, uint32_t, used);
    if (map == NULL) {
        stp_free(context, numbers);
        return STP_ERROR_OUT_OF_MEMORY;
    }
    used = 0;
    for (size_t i = 0; i < range; ++i) {
        if (numbers[i] != 0) {
            map[used] = low + (uint32_t)i;
            numbers[i] = used++;
        }
    }
    for (size_t i = 0; i < count; ++i) {
        indices[i] = numbers[indices[i] - low];
    }
    stp_free(context, numbers);
    *selection = (stp_gltf_selection){.count = used, .map = map};
    return STP_OK;
}

// Same, for a range too large to scan.
static stp_result number_sorted(stp_gltf_scope* scope, uint32_t* indices, size_t count,
                                stp_gltf_selection* selection)
{
    stp_context* context = scope->gltf->context;
    uint64_t* items = STP_NEW_ARRAY(context, uint64_t, count * 2);
    uint32_t* map = STP_NEW_ARRAY(context, uint32_t, count);
    if (items == NULL || map == NULL) {
        stp_free(context, items);
        stp_free(context, map);
        return STP_ERROR_OUT_OF_MEMORY;
    }
    for (size_t i = 0; i < count; ++i) {
        items[i] = (uint64_t)indices[i] << 32 | i;
    }
    const uint64_t* sorted = stp_sort_u64(items, items + count, count, 32, 32);
    size_t used = 0;
    for (size_t i = 0; i < count; ++i) {
        uint32_t index = (uint32_t)(sorted[i] >> 32);
        if (used == 0 || map[used - 1] != index) {
            map[used++] = index;
        }
        indices[(uint32_t)sorted[i]] = (uint32_t)(used - 1);
    }
    assert(used > 0 && used <= count);
    stp_free(context, items);
    *selection = (stp_gltf_selection){.count = used, .map = map};
    return STP_OK;
}

static stp_result select_vertices(stp_gltf_scope* scope, uint32_t* indices, size_t count,
                                  stp_gltf_selection* selection)
{
    uint32_t low = STP_NONE, high = 0;
    for (size_t i = 0; i < count; ++i) {
        low = indices[i] < low ? indices[i] : low;
        high = indices[i] > high ? indices[i] : high;
    }
    if (count == 0) {
        *selection = (stp_gltf_selection){0};
        return STP_OK;
    }
    assert(low <= high);
    size_t range = (size_t)high - low + 1;
    if (range / 64 > count) {
        return number_sorted(scope, indices, count, selection);
    }
    if (range / 2 > count) {
        return number_used(scope, low, range, indices, count, selection);
    }
    for (size_t i = 0; low != 0 && i < count; ++i) {
        indices[i] -= low;
    }
    *selection = (stp_gltf_selection){.first = low, .count = range};
    return STP_OK;
}

static stp_result draco_triangles(stp_gltf_scope* scope, const stp_draco_mesh* draco,
                                  uint32_t** indices, size_t* triangle_count)
{
    *triangle_count = stp_draco_face_count(draco);
    *indices = STP_NEW_ARRAY(scope->gltf->context, uint32_t, *triangle_count * 3);
    if (*indices == NULL) {
        return STP_ERROR_OUT_OF_MEMORY;
    }
    stp_draco_indices(draco, *indices);
    return STP_OK;
}

#ifndef NDEBUG
static bool are_below(const uint32_t* indices, size_t count, size_t limit)
{
    for (size_t i = 0; i < count; ++i) {
        if (indices[i] >= limit) {
            return false;
        }
    }
    return true;
}
#endif

stp_result stp_gltf_triangles(stp_gltf_scope* scope, const json_t* primitive, stp_gltf_mode mode,
                              stp_gltf_vertices* vertices, uint32_t** indices,
                              size_t* triangle_count)
{
    stp_result result;
    *triangle_count = 0;
    if (vertices->draco != NULL) {
        result = draco_triangles(scope, vertices->draco, indices, triangle_count);
    } else {
        uint32_t* stored;
        size_t count;
        result = read_indices(scope, primitive, vertices->count, &stored, &count);
        if (result == STP_OK) {
            result = assemble(scope, mode, stored, count, indices, triangle_count);
        }
    }
    if (result == STP_OK && *triangle_count > UINT32_MAX / 3) {
        result = stp_gltf_fail(scope, STP_ERROR_LIMIT, "it has %zu triangles", *triangle_count);
    }
    if (result == STP_OK) {
        result = select_vertices(scope, *indices, *triangle_count * 3, &vertices->selection);
    }
    const stp_gltf_selection* selection = &vertices->selection;
    assert(result != STP_OK || are_below(*indices, *triangle_count * 3, selection->count));
    assert(result != STP_OK || selection->first + selection->count <= vertices->count);
    (void)selection;
    return result;
}

stp_result stp_gltf_points(stp_gltf_scope* scope, const json_t* primitive,
                           stp_gltf_vertices* vertices)
{
    uint32_t* stored;
    size_t count;
    stp_result result = read_indices(scope, primitive, vertices->count, &stored, &count);
    vertices->selection = (stp_gltf_selection){.count = count, .map = stored};
    return result;
}
