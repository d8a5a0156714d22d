// SPDX-License-Identifier: MIT
#include "builder/stored_results.h"

#include "base/io/bytes.h"
#include "base/splats/light_normal.h"
#include "base/splats/splat_codes.h"
#include "builder/shadings.h"
#include "store/bytes/columns.h"
#include "store/file/validate.h"

#include <assert.h>
#include <stdlib.h>

enum {
    SPLAT_SET_KIND = 1, ///< type of result, at the start of its header
    MESH_KIND = 2,
    SPLAT_SET_HEAD = 704,
    OCTAVES_AT = 48,
    COUNTS_AT = OCTAVES_AT + 4 * STP_OCTAVE_LIMIT,
    RADII_AT = COUNTS_AT + 4 * STP_PREFIX_TABLE_SIZE,
    MESH_HEAD = 64,
    COLUMNS_AT = RADII_AT + 4 * STP_PREFIX_TABLE_SIZE, ///< STP_SPLATS_*
    ATTRIBUTES_AT = COLUMNS_AT + 4,                    ///< bit mask of attributes
    LEAVES_AT = ATTRIBUTES_AT + 4,
    LIGHTS_AT = LEAVES_AT + 4, ///< octaves with light normals
    ATTRIBUTE_COLUMN = 7,
    LEAF_COLUMN = ATTRIBUTE_COLUMN + STP_ATTRIBUTES,
    ERROR_COLUMN,
    TURN_COLUMN,
    SPREAD_COLUMN,
    COLUMNS,
};
_Static_assert(LIGHTS_AT + 4 <= SPLAT_SET_HEAD, "the head holds the table");

// Writes or reads consecutive numbers.
typedef struct cursor {
    unsigned char* write;
    const unsigned char* read;
} cursor;

static void put_u32(cursor* at, uint32_t value)
{
    stp_write_u32(at->write, value);
    at->write += 4;
}

static void put_f32(cursor* at, float value)
{
    stp_write_f32(at->write, value);
    at->write += 4;
}

static uint32_t get_u32(cursor* at)
{
    at->read += 4;
    return stp_read_u32(at->read - 4);
}

static float get_f32(cursor* at)
{
    at->read += 4;
    return stp_read_f32(at->read - 4);
}

static void write_splat_set_head(const stp_splats* s, uint32_t candidates,
                                 unsigned char head[SPLAT_SET_HEAD])
{
    memset(head, 0, SPLAT_SET_HEAD);
    cursor at = {.write = head};
    put_u32(&at, SPLAT_SET_KIND);
    put_u32(&at, s->count);
    put_u32(&at, s->octave_count);
    put_u32(&at, s->table.size);
    put_f32(&at, s->origin.x);
    put_f32(&at, s->origin.y);
    put_f32(&at, s->origin.z);
    put_f32(&at, s->step);
    put_f32(&at, s->candidate_radius);
    put_f32(&at, s->paper_radius);
    put_u32(&at, s->paper_count);
    put_u32(&at, candidates);
    assert(at.write == head + OCTAVES_AT && "the fields fill the head up to the tables");
    assert(s->octave_count <= STP_OCTAVE_LIMIT && s->table.size <= STP_PREFIX_TABLE_SIZE);
    stp_write_u32(head + COLUMNS_AT, s->columns);
    stp_write_u32(head + LEAVES_AT, s->leaf_count);
    stp_write_u32(head + LIGHTS_AT, s->light_octaves);
    stp_write_u32(head + ATTRIBUTES_AT, stp_splats_attributes(s));
    for (uint32_t i = 0; i < s->octave_count; ++i) {
        stp_write_u32(head + OCTAVES_AT + 4 * i, s->octave_ends[i]);
    }
    for (uint32_t i = 0; i < s->table.size; ++i) {
        stp_write_u32(head + COUNTS_AT + 4 * i, s->table.count[i]);
        stp_write_f32(head + RADII_AT + 4 * i, s->table.radius[i]);
    }
}

// False if the result is not a set or a count exceeds its limit; other values are not checked.
static bool read_splat_set_head(const unsigned char* head, stp_splats* s, uint32_t* candidates)
{
    *s = (stp_splats){0};
    cursor at = {.read = head};
    uint32_t kind = get_u32(&at);
    s->count = get_u32(&at);
    s->octave_count = get_u32(&at);
    s->table.size = get_u32(&at);
    s->origin.x = get_f32(&at);
    s->origin.y = get_f32(&at);
    s->origin.z = get_f32(&at);
    s->step = get_f32(&at);
    s->candidate_radius = get_f32(&at);
    s->paper_radius = get_f32(&at);
    s->paper_count = get_u32(&at);
    *candidates = get_u32(&at);
    assert(at.read == head + OCTAVES_AT && "reader and writer have the same fields");
    s->columns = stp_read_u32(head + COLUMNS_AT);
    s->leaf_count = stp_read_u32(head + LEAVES_AT);
    s->light_octaves = stp_read_u32(head + LIGHTS_AT);
    if (kind != SPLAT_SET_KIND || s->columns > STP_SPLATS_COLUMNS ||
        s->octave_count > STP_OCTAVE_LIMIT || s->table.size > STP_PREFIX_TABLE_SIZE) {
        return false;
    }
    for (uint32_t i = 0; i < s->octave_count; ++i) {
        s->octave_ends[i] = stp_read_u32(head + OCTAVES_AT + 4 * i);
    }
    for (uint32_t i = 0; i < s->table.size; ++i) {
        s->table.count[i] = stp_read_u32(head + COUNTS_AT + 4 * i);
        s->table.radius[i] = stp_read_f32(head + RADII_AT + 4 * i);
    }
    return true;
}

static bool has_bit(uint32_t mask, int attribute)
{
    return (mask & stp_attribute_bit((stp_attribute)attribute)) != 0;
}

static size_t pad(size_t size)
{
    return (size + 63) & ~(size_t)63;
}

// Size of each column: at most 24 octaves of 2^32 splats, so sums cannot overflow.
static void size_columns(const stp_splats* s, uint32_t attributes, size_t sizes[COLUMNS])
{
    size_t entries = (size_t)stp_store_pyramid_begin(s, s->octave_count);
    sizes[0] = 6 * (size_t)s->count;
    sizes[1] = 2 * (size_t)s->count;
    sizes[2] = s->count;
    sizes[3] = 3 * entries;
    sizes[4] = entries;
    sizes[5] = (s->columns & STP_SPLATS_SHAPES) != 0 ? 4 * (size_t)s->count : 0;
    sizes[6] = (s->columns & STP_SPLATS_RANGES) != 0 ? 4 * (size_t)s->count : 0;
    sizes[ERROR_COLUMN] = (s->columns & STP_SPLATS_ERRORS) != 0 ? 4 * (size_t)s->count : 0;
    size_t lights = (size_t)stp_light_normals_begin(s, s->octave_count);
    sizes[TURN_COLUMN] = 2 * lights;
    sizes[SPREAD_COLUMN] = lights;
    sizes[LEAF_COLUMN] = sizeof(stp_splat_leaf) * (size_t)s->leaf_count;
    for (int i = 0; i < STP_ATTRIBUTES; ++i) {
        size_t size = stp_attribute_size((stp_attribute)i) * s->count;
        sizes[ATTRIBUTE_COLUMN + i] = has_bit(attributes, i) ? size : 0;
    }
}

/// Whether a set's columns satisfy what a renderer relies on.
static bool is_sound(const stp_splats* s, uint32_t shading_count)
{
    uint8_t highest = 0;
    for (uint32_t i = 0; i < s->count; ++i) {
        highest = s->materials[i] > highest ? s->materials[i] : highest;
    }
    for (uint32_t i = 0; s->shapes != NULL && i < s->count; ++i) {
        if (!stp_shape_is_valid(s->shapes[i])) {
            return false;
        }
    }
    for (uint32_t i = 0; s->ranges != NULL && i < s->count; ++i) {
        if (!stp_range_is_valid(s->ranges[i])) {
            return false;
        }
    }
    if (s->leaf_count > 0 && stp_splat_leaves_fault(s, s->leaves, s->leaf_count) != NULL) {
        return false;
    }
    return s->count == 0 || highest < shading_count;
}

// Points the columns into a result's bytes. False if it cannot be a set.
static bool read_splat_set(const void* result, size_t size, stp_splats* s, uint32_t* candidates)
{
    if (size < SPLAT_SET_HEAD || !read_splat_set_head(result, s, candidates) ||
        stp_store_splat_set_fault(s) != NULL) {
        return false;
    }
    uint32_t attributes = stp_read_u32((const unsigned char*)result + ATTRIBUTES_AT);
    size_t sizes[COLUMNS], offsets[COLUMNS], end = SPLAT_SET_HEAD;
    size_columns(s, attributes, sizes);
    for (int i = 0; i < COLUMNS; ++i) {
        assert(end % 64 == 0 && "columns are aligned");
        offsets[i] = end;
        end += pad(sizes[i]);
    }
    if (end != size || attributes >> STP_ATTRIBUTES != 0) {
        return false;
    }
    uintptr_t bytes = (uintptr_t)result; // read-only memory, with the type of heap sets
    s->positions = (uint16_t*)(bytes + offsets[0]);
    s->normals = (int8_t*)(bytes + offsets[1]);
    s->materials = (uint8_t*)(bytes + offsets[2]);
    s->colors = (uint8_t*)(bytes + offsets[3]);
    s->coverages = (uint8_t*)(bytes + offsets[4]);
    s->shapes = sizes[5] != 0 ? (uint32_t*)(bytes + offsets[5]) : NULL;
    s->ranges = sizes[6] != 0 ? (uint32_t*)(bytes + offsets[6]) : NULL;
    s->errors = sizes[ERROR_COLUMN] != 0 ? (uint32_t*)(bytes + offsets[ERROR_COLUMN]) : NULL;
    s->turns = sizes[TURN_COLUMN] != 0 ? (int8_t*)(bytes + offsets[TURN_COLUMN]) : NULL;
    s->spreads = sizes[SPREAD_COLUMN] != 0 ? (uint8_t*)(bytes + offsets[SPREAD_COLUMN]) : NULL;
    s->leaves = sizes[LEAF_COLUMN] != 0 ? (stp_splat_leaf*)(bytes + offsets[LEAF_COLUMN]) : NULL;
    for (int i = 0; i < STP_ATTRIBUTES; ++i) {
        bool there = sizes[ATTRIBUTE_COLUMN + i] != 0;
        s->attributes[i] = there ? (void*)(bytes + offsets[ATTRIBUTE_COLUMN + i]) : NULL;
    }
    return true;
}

bool stp_work_find_splat_set(stp_work* work, stp_hash key, uint32_t shading_count,
                             stp_splats* splats, uint32_t* candidates)
{
    size_t size = 0;
    const void* result = stp_work_find(work, key, &size);
    if (result == NULL) {
        return false;
    }
    if (!read_splat_set(result, size, splats, candidates) || !is_sound(splats, shading_count)) {
        stp_work_drop(work, key); // a checksum does not prove validity
        return false;
    }
    return true;
}

static stp_result store_splat_set(stp_work* work, stp_hash key, const stp_splats* splats,
                                  uint32_t candidates)
{
    static const unsigned char zeros[64];
    unsigned char head[SPLAT_SET_HEAD];
    write_splat_set_head(splats, candidates, head);
    size_t sizes[COLUMNS];
    size_columns(splats, stp_splats_attributes(splats), sizes);
    const void* columns[COLUMNS] = {splats->positions, splats->normals,   splats->materials,
                                    splats->colors,    splats->coverages, splats->shapes,
                                    splats->ranges};
    for (int i = 0; i < STP_ATTRIBUTES; ++i) {
        columns[ATTRIBUTE_COLUMN + i] = splats->attributes[i];
    }
    columns[LEAF_COLUMN] = splats->leaves;
    columns[ERROR_COLUMN] = splats->errors;
    columns[TURN_COLUMN] = splats->turns;
    columns[SPREAD_COLUMN] = splats->spreads;
    stp_bytes parts[1 + 2 * COLUMNS] = {{head, SPLAT_SET_HEAD}};
    for (int i = 0; i < COLUMNS; ++i) {
        assert((columns[i] != NULL || sizes[i] == 0) && "a column is missing");
        parts[1 + 2 * i] = (stp_bytes){columns[i], sizes[i]};
        parts[2 + 2 * i] = (stp_bytes){zeros, pad(sizes[i]) - sizes[i]};
    }
    return stp_work_store(work, key, parts, 1 + 2 * COLUMNS, NULL);
}

stp_result stp_work_store_splat_set(stp_work* work, stp_hash key, const stp_splats* splats,
                                    uint32_t candidates, stp_splats* stored)
{
    const char* fault = stp_store_splat_set_fault(splats);
    if (fault != NULL) {
        return stp_fail(stp_work_get_context(work), STP_ERROR_FORMAT, "a splat set: %s", fault);
    }
    // an invalid entry under the key is dropped the first time; the second attempt succeeds
    stp_result result = STP_OK;
    for (int attempt = 0; result == STP_OK && attempt < 2; ++attempt) {
        uint32_t unused;
        stp_splats found;
        result = store_splat_set(work, key, splats, candidates);
        if (result == STP_OK &&
            stp_work_find_splat_set(work, key, STP_SHADING_LIMIT, &found, &unused)) {
            if (stored != NULL) {
                *stored = found;
            }
            return STP_OK;
        }
    }
    return result == STP_OK ? stp_fail(stp_work_get_context(work), STP_ERROR_IO,
                                       "a splat set cannot be read back from the work folder")
                            : result;
}

static bool read_mesh(const void* result, size_t size, stp_coded_mesh* mesh)
{
    cursor at = {.read = result};
    if (size < MESH_HEAD || get_u32(&at) != MESH_KIND) {
        return false;
    }
    *mesh = (stp_coded_mesh){.bytes = at.read - 4 + MESH_HEAD, .size = size - MESH_HEAD};
    mesh->cluster_count = get_u32(&at);
    mesh->triangle_count = get_u32(&at);
    mesh->vertex_count = get_u32(&at);
    float* bounds[] = {&mesh->bounds.min.x, &mesh->bounds.min.y, &mesh->bounds.min.z,
                       &mesh->bounds.max.x, &mesh->bounds.max.y, &mesh->bounds.max.z};
    for (int i = 0; i < 6; ++i) {
        *bounds[i] = get_f32(&at);
    }
    uint64_t clusters = mesh->cluster_count;
    return mesh->triangle_count <= STP_CLUSTER_TRIANGLES * clusters &&
           mesh->vertex_count <= STP_CLUSTER_VERTICES * clusters;
}

bool stp_work_find_mesh(stp_work* work, stp_hash key, stp_coded_mesh* mesh)
{
    size_t size = 0;
    const void* result = stp_work_find(work, key, &size);
    if (result == NULL) {
        return false;
    }
    if (!read_mesh(result, size, mesh)) {
        stp_work_drop(work, key);
        return false;
    }
    return true;
}

static stp_result store_mesh(stp_work* work, stp_hash key, const stp_coded_mesh* mesh)
{
    unsigned char head[MESH_HEAD] = {0};
    cursor at = {.write = head};
    put_u32(&at, MESH_KIND);
    put_u32(&at, mesh->cluster_count);
    put_u32(&at, mesh->triangle_count);
    put_u32(&at, mesh->vertex_count);
    put_f32(&at, mesh->bounds.min.x);
    put_f32(&at, mesh->bounds.min.y);
    put_f32(&at, mesh->bounds.min.z);
    put_f32(&at, mesh->bounds.max.x);
    put_f32(&at, mesh->bounds.max.y);
    put_f32(&at, mesh->bounds.max.z);
    assert(at.write <= head + MESH_HEAD && "the fields fit the head");
    const stp_bytes parts[] = {{head, MESH_HEAD}, {mesh->bytes, mesh->size}};
    return stp_work_store(work, key, parts, 2, NULL);
}

stp_result stp_work_store_mesh(stp_work* work, stp_hash key, const stp_coded_mesh* mesh,
                               stp_coded_mesh* stored)
{
    stp_result result = STP_OK;
    for (int attempt = 0; result == STP_OK && attempt < 2; ++attempt) {
        stp_coded_mesh found;
        result = store_mesh(work, key, mesh);
        if (result == STP_OK && stp_work_find_mesh(work, key, &found)) {
            if (stored != NULL) {
                *stored = found;
            }
            return STP_OK;
        }
    }
    return result == STP_OK ? stp_fail(stp_work_get_context(work), STP_ERROR_IO,
                                       "a coded mesh cannot be read back from the work folder")
                            : result;
}

static int compare_keys(const void* left, const void* right)
{
    const stp_hash* a = &((const stp_build_result*)left)->key;
    const stp_hash* b = &((const stp_build_result*)right)->key;
    if (a->high != b->high) {
        return a->high < b->high ? -1 : 1;
    }
    return a->low < b->low ? -1 : a->low > b->low ? 1 : 0;
}

size_t stp_build_count_found(stp_build_result* origins, size_t count)
{
    size_t found = 0;
    if (count > 1) {
        qsort(origins, count, sizeof(*origins), compare_keys);
    }
    for (size_t begin = 0, end; begin < count; begin = end) {
        bool made = false;
        assert((begin == 0 || compare_keys(&origins[begin - 1], &origins[begin]) < 0) &&
               "each key is one run");
        for (end = begin; end < count && stp_hash_equal(origins[begin].key, origins[end].key);
             ++end) {
            made = made || origins[end].made;
        }
        found += made ? 0 : end - begin;
    }
    return found;
}
