// SPDX-License-Identifier: MIT
// Codes a mesh as clusters: sorts triangles along a curve, splits at 128 triangles or 256 vertices,
// packs.
#include "store/clusters/clusters_encode.h"

#include "base/core/context.h"

#include <assert.h>

enum {
    TEXCOORD_EXPONENT = -16, // rounds to within a sixteenth of a texel of an 8k texture
    FLOAT_DIGITS = 23,
    PREFETCH = 8, // distance in triangles
};

typedef struct encoding {
    stp_context* context;
    stp_cluster_maker* maker;
    unsigned char* entries;
    unsigned char* data;
    size_t entry_count, entry_capacity, data_size, data_capacity;
    int step_exponent, texcoord_exponents[2];
    int32_t minimum[3], maximum[3];
    uint64_t vertex_count;
} encoding;

static stp_result append_cluster(encoding* e, uint32_t first_triangle)
{
    if (e->data_size / 4 > UINT32_MAX - CLUSTER_MAX_BYTES - e->entry_count * 8) {
        return stp_fail(e->context, STP_ERROR_LIMIT,
                        "a mesh of %u triangles does not fit into one block",
                        e->maker->mesh->triangle_count);
    }
    if (!STP_MAKE_ROOM(e->context, e->data, e->data_capacity, e->data_size + CLUSTER_MAX_BYTES) ||
        !stp_make_room(e->context, &e->entries, &e->entry_capacity, e->entry_count + 1,
                       CLUSTERS_ENTRY_BYTES)) {
        return stp_fail_memory(e->context);
    }
    assert(e->data_size % 4 == 0 && "offsets count units of 4 bytes");
    clusters_entry entry = {.offset = (uint32_t)(e->data_size / 4),
                            .first_triangle = first_triangle};
    stp_cluster_maker_finish(e->maker, &entry);
    e->data_size += stp_clusters_pack(e->maker, &entry, e->data + e->data_size);
    for (int k = 0; k < 3; ++k) {
        const int32_t* values = e->maker->values[k];
        for (uint32_t v = 0; v < e->maker->vertex_count; ++v) {
            e->minimum[k] = values[v] < e->minimum[k] ? values[v] : e->minimum[k];
            e->maximum[k] = values[v] > e->maximum[k] ? values[v] : e->maximum[k];
        }
    }
    e->vertex_count += e->maker->vertex_count;
    clusters_write_entry(e->entries + e->entry_count * CLUSTERS_ENTRY_BYTES, &entry);
    e->entry_count += 1;
    return STP_OK;
}

/// Gathers loose parts of one class from `at` on, as many as fit; triangles one by one if those are
/// not whole parts. @return the start of the next cluster
static uint32_t gather_parts(encoding* e, const uint64_t* order, uint32_t at, uint32_t end)
{
    uint32_t part_class = (uint32_t)(order[at] >> 32);
    uint32_t part = clusters_part_triangles(part_class);
    uint32_t maximum = STP_CLUSTER_TRIANGLES / part;
    uint32_t other = STP_CLUSTER_VERTICES / clusters_part_vertices(part_class);
    maximum = part * (other < maximum ? other : maximum);
    maximum = end - at < maximum ? end - at : maximum;
    bool whole = maximum % part == 0; // an earlier cluster may have split a part
    if (whole && stp_cluster_maker_take_parts(e->maker, order + at, maximum, part_class)) {
        return at + maximum;
    }
    stp_cluster_maker_begin(e->maker);
    uint32_t stop = at + maximum;
    while (at < stop && stp_cluster_maker_add(e->maker, (uint32_t)order[at])) {
        at += 1;
    }
    return at;
}

/// Prefetches the vertices of a triangle further along the curve.
static void prefetch(const stp_cluster_maker* m, const uint64_t* order, uint32_t at, uint32_t end)
{
    if (end - at > 2 * PREFETCH) {
        const uint32_t* next = m->mesh->indices + 3 * (size_t)(uint32_t)order[at + PREFETCH];
        __builtin_prefetch(m->mesh->indices + 3 * (size_t)(uint32_t)order[at + 2 * PREFETCH]);
        for (int k = 0; k < 3; ++k) {
            __builtin_prefetch(&m->places[next[k]]);
        }
    }
}

/// Gathers triangles one by one. @return the start of the next cluster
static uint32_t gather_triangles(encoding* e, const uint64_t* order, uint32_t at, uint32_t end)
{
    uint32_t first = at, left = end - at, maximum = STP_CLUSTER_TRIANGLES;
    if (left > maximum && left < 2 * maximum) {
        maximum = (left + 1) / 2; // avoids a last cluster of few triangles
    }
    stp_cluster_maker_begin(e->maker);
    for (; at < end && at - first < maximum; ++at) {
        if (order != NULL) {
            prefetch(e->maker, order, at, end);
        }
        if (!stp_cluster_maker_add(e->maker, order != NULL ? (uint32_t)order[at] : at)) {
            break;
        }
    }
    return at;
}

static stp_result split_clusters(encoding* e, const uint64_t* order, uint32_t triangle_count)
{
    uint32_t end = order == NULL ? triangle_count : 0;
    for (uint32_t at = 0; at < triangle_count;) {
        while (at == end || (end < triangle_count && order[end] >> 32 == order[at] >> 32)) {
            end += 1; // the end of the class
        }
        bool loose = order != NULL && order[at] >> 32 != 0;
        uint32_t first = at;
        at = loose ? gather_parts(e, order, at, end) : gather_triangles(e, order, at, end);
        assert(at > first && at <= end && e->maker->triangle_count == at - first);
        stp_result result = append_cluster(e, first);
        if (result != STP_OK) {
            return result;
        }
    }
    return STP_OK;
}

/// Clusters given by their ends.
static stp_result take_ranges(encoding* e, const uint32_t* ends, uint32_t count)
{
    for (uint32_t i = 0, at = 0; i < count; ++i) {
        uint32_t first = at;
        assert(ends[i] > first && ends[i] <= e->maker->mesh->triangle_count);
        stp_cluster_maker_begin(e->maker);
        while (at < ends[i] && stp_cluster_maker_add(e->maker, at)) {
            at += 1;
        }
        if (at < ends[i]) {
            return stp_fail(e->context, STP_ERROR_LIMIT,
                            "cluster %u of %u triangles has more than %d triangles or %d vertices",
                            i, ends[i] - first, STP_CLUSTER_TRIANGLES, STP_CLUSTER_VERTICES);
        }
        stp_result result = append_cluster(e, first);
        if (result != STP_OK) {
            return result;
        }
    }
    assert(ends[count - 1] == e->maker->mesh->triangle_count);
    return STP_OK;
}

/// Joins header, entries and clusters in one allocation.
static stp_result join(const encoding* e, uint32_t triangle_count, stp_coded_mesh* coded)
{
    size_t entry_bytes = e->entry_count * CLUSTERS_ENTRY_BYTES;
    size_t begin = CLUSTERS_HEADER_BYTES + entry_bytes;
    size_t size = begin + e->data_size + CLUSTERS_PADDING_BYTES;
    assert(e->vertex_count <= UINT32_MAX && (begin + e->data_size) / 4 <= UINT32_MAX);
    unsigned char* bytes = stp_alloc(e->context, size);
    if (bytes == NULL) {
        return stp_fail_memory(e->context);
    }
    memset(bytes, 0, CLUSTERS_HEADER_BYTES);
    stp_write_u32(bytes, (uint32_t)e->entry_count);
    stp_write_u32(bytes + 4, triangle_count);
    stp_write_u32(bytes + 8, (uint32_t)e->vertex_count);
    stp_write_u16(bytes + 12, (uint16_t)e->maker->present);
    stp_write_u16(bytes + 14, (uint16_t)(int16_t)e->step_exponent);
    stp_write_u16(bytes + 16, (uint16_t)(int16_t)e->texcoord_exponents[0]);
    stp_write_u16(bytes + 18, (uint16_t)(int16_t)e->texcoord_exponents[1]);
    for (size_t i = 0; i < e->entry_count; ++i) {
        unsigned char* entry = e->entries + i * CLUSTERS_ENTRY_BYTES;
        stp_write_u32(entry, stp_read_u32(entry) + (uint32_t)(begin / 4));
    }
    if (e->entry_count != 0) {
        memcpy(bytes + CLUSTERS_HEADER_BYTES, e->entries, entry_bytes);
        memcpy(bytes + begin, e->data, e->data_size);
    }
    memset(bytes + begin + e->data_size, 0, CLUSTERS_PADDING_BYTES);
    *coded = (stp_coded_mesh){.bytes = bytes,
                              .size = size,
                              .cluster_count = (uint32_t)e->entry_count,
                              .triangle_count = triangle_count,
                              .vertex_count = (uint32_t)e->vertex_count};
    if (e->entry_count != 0) {
        float step = clusters_power_of_two(e->step_exponent);
        const int32_t *a = e->minimum, *b = e->maximum;
        coded->bounds = (stp_box){
            {(float)a[0] * step, (float)a[1] * step, (float)a[2] * step},
            {(float)b[0] * step, (float)b[1] * step, (float)b[2] * step},
        };
    }
    return STP_OK;
}

static int exponent_of(double value)
{
    uint64_t bits;
    memcpy(&bits, &value, sizeof(bits));
    return (int)(bits >> 52 & 2047) - 1023;
}

static float find_largest(const float* numbers, size_t count)
{
    float largest = 0.0f;
    for (size_t i = 0; i < count; ++i) {
        largest = stp_max(largest, fabsf(numbers[i]));
    }
    return largest;
}

/// Fills the steps and the channels that distinguish vertices. @return false if the mesh is too
/// large for its step
static bool prepare(encoding* e, const stp_store_mesh* mesh, double step)
{
    stp_cluster_maker* m = e->maker;
    e->step_exponent = exponent_of(step);
    double largest = (double)find_largest(mesh->positions, 3 * (size_t)mesh->vertex_count);
    if (!(step > 0.0) || e->step_exponent < CLUSTERS_EXPONENT_MIN ||
        e->step_exponent > CLUSTERS_EXPONENT_MAX ||
        !(largest / step <= (double)CLUSTERS_NUMBER_LIMIT)) {
        return false;
    }
    assert((double)clusters_power_of_two(e->step_exponent) == step && "a power of two");
    m->mesh = mesh;
    m->inverse_step = 1.0 / step;
    for (uint32_t k = 0; k < 3; ++k) {
        e->minimum[k] = INT32_MAX;
        e->maximum[k] = INT32_MIN;
    }
    m->present = mesh->normals != NULL ? STP_COLUMN_NORMALS : 0;
    for (uint32_t set = 0; set < 2; ++set) {
        if (mesh->texcoords[set] == NULL) {
            continue;
        }
        m->present |= set == 0 ? STP_COLUMN_TEXCOORDS_0 : STP_COLUMN_TEXCOORDS_1;
        double size = (double)find_largest(mesh->texcoords[set], 2 * (size_t)mesh->vertex_count);
        int exponent = exponent_of(size) - FLOAT_DIGITS;
        exponent = exponent > TEXCOORD_EXPONENT ? exponent : TEXCOORD_EXPONENT;
        exponent = exponent < CLUSTERS_EXPONENT_MAX ? exponent : CLUSTERS_EXPONENT_MAX;
        e->texcoord_exponents[set] = exponent;
        m->texcoord_inverses[set] = 1.0 / (double)clusters_power_of_two(exponent);
        m->extra_channels[m->extra_count++] = STP_CLUSTER_TEXCOORDS + 2 * set;
        m->extra_channels[m->extra_count++] = STP_CLUSTER_TEXCOORDS + 2 * set + 1;
    }
    if (mesh->colors != NULL) {
        m->present |= STP_COLUMN_COLORS;
        for (uint32_t k = 0; k < 4; ++k) {
            m->extra_channels[m->extra_count++] = STP_CLUSTER_COLORS + k;
        }
    }
    assert(m->extra_count <= STP_CLUSTER_CHANNELS - STP_CLUSTER_TEXCOORDS);
    return true;
}

/// Orders the triangles and finds the classes of loose parts.
static stp_result sort_triangles(encoding* e, const stp_store_mesh* mesh, uint64_t** order)
{
    const cluster_place* places = e->maker->places;
    uint64_t* items = STP_NEW_ARRAY(e->context, uint64_t, mesh->triangle_count);
    uint64_t* scratch = STP_NEW_ARRAY(e->context, uint64_t, mesh->triangle_count);
    if (items == NULL || scratch == NULL) {
        stp_free(e->context, items);
        stp_free(e->context, scratch);
        return stp_fail_memory(e->context);
    }
    *order = stp_clusters_sort(mesh, places, items, scratch);
    scratch = *order == items ? scratch : items;
    stp_result result = stp_clusters_sort_parts(e->context, mesh, places, order, &scratch);
    stp_free(e->context, scratch);
    return result;
}

/// @param ends of clusters; NULL: they are made here
static stp_result encode(encoding* e, const stp_store_mesh* mesh, const uint32_t* ends,
                         uint32_t cluster_count, stp_coded_mesh* coded)
{
    uint32_t count = mesh->triangle_count;
    cluster_place* places = STP_NEW_ARRAY(e->context, cluster_place, mesh->vertex_count);
    if (places == NULL) {
        return stp_fail_memory(e->context);
    }
    stp_clusters_place_vertices(mesh, e->maker->inverse_step, places);
    e->maker->places = places;
    uint64_t* order = NULL;
    stp_result result = STP_OK;
    if (ends == NULL && count > STP_CLUSTER_TRIANGLES) {
        result = sort_triangles(e, mesh, &order);
    }
    if (result == STP_OK) {
        result =
            ends != NULL ? take_ranges(e, ends, cluster_count) : split_clusters(e, order, count);
    }
    stp_free(e->context, order);
    stp_free(e->context, places);
    if (result == STP_OK && e->vertex_count > UINT32_MAX) {
        result =
            stp_fail(e->context, STP_ERROR_LIMIT,
                     "a mesh of %u triangles needs more vertices than 32 bits can number", count);
    }
    return result == STP_OK ? join(e, count, coded) : result;
}

static stp_result encode_mesh(stp_context* context, const stp_store_mesh* mesh, double step,
                              const uint32_t* ends, uint32_t cluster_count, stp_coded_mesh* coded)
{
    *coded = (stp_coded_mesh){0};
    encoding e = {.context = context, .maker = STP_NEW_ZEROED(context, stp_cluster_maker, 1)};
    if (e.maker == NULL) {
        return stp_fail_memory(context);
    }
    stp_result result = STP_OK;
    if (!prepare(&e, mesh, step)) {
        result = stp_fail(context, STP_ERROR_LIMIT,
                          "mesh %s: its coordinates are too large for a grid step of %g",
                          mesh->name != NULL ? mesh->name : "without a name", step);
    } else {
        e.maker->all_plain = ends != NULL && mesh->normals == NULL;
        result = encode(&e, mesh, ends, cluster_count, coded);
    }
    stp_free(context, e.data);
    stp_free(context, e.entries);
    stp_free(context, e.maker);
    return result;
}

stp_result stp_clusters_encode(stp_context* context, const stp_store_mesh* mesh, double step,
                               stp_coded_mesh* coded)
{
    return encode_mesh(context, mesh, step, NULL, 0, coded);
}

stp_result stp_clusters_encode_ranges(stp_context* context, const stp_store_mesh* mesh, double step,
                                      const uint32_t* ends, uint32_t count, stp_coded_mesh* coded)
{
    assert(count != 0 && ends[count - 1] == mesh->triangle_count);
    return encode_mesh(context, mesh, step, ends, count, coded);
}

void stp_coded_mesh_destroy(stp_context* context, stp_coded_mesh* coded)
{
    stp_free(context, (void*)(uintptr_t)coded->bytes);
    *coded = (stp_coded_mesh){0};
}
