// SPDX-License-Identifier: MIT
// Coded meshes read: checked once as a whole, then any cluster at any time.
#include "store/clusters.h"

#include "base/context.h"
#include "store/clusters_layout.h"

#if __BYTE_ORDER__ != __ORDER_LITTLE_ENDIAN__
#error "values are used straight from the file, which is little-endian"
#endif

static const unsigned char* entry_at(const stp_clusters* clusters, uint32_t index)
{
    return clusters->bytes + CLUSTERS_HEADER_BYTES + (size_t)index * CLUSTERS_ENTRY_BYTES;
}

static int read_exponent(const unsigned char* p)
{
    return (int16_t)stp_read_u16(p);
}

/// Bytes of a cluster of these counts and widths, of its table's too; the table must be there.
static uint64_t measure(uint32_t present, const clusters_entry* entry, const unsigned char* table,
                        uint32_t table_bytes, uint32_t extra)
{
    uint64_t size = table_bytes + 3u * (uint64_t)entry->triangle_count;
    for (uint32_t i = 0, channel = 0; i < STP_CLUSTER_CHANNELS; ++i) {
        uint32_t count = clusters_values(present, i, entry->last_vertex + 1u, entry->normal_count);
        if (count != 0) {
            uint32_t width = i <= STP_CLUSTER_Z ? entry->width[i] : table[4 * extra + channel++];
            size += ((uint64_t)count * width + 7) / 8;
        }
    }
    return (size + 3) & ~(uint64_t)3;
}

static uint32_t count_extra(uint32_t present, uint32_t normal_count)
{
    uint32_t extra = 0;
    for (uint32_t i = STP_CLUSTER_Z + 1; i < STP_CLUSTER_CHANNELS; ++i) {
        extra += clusters_values(present, i, 1, normal_count) != 0;
    }
    return extra;
}

static bool are_indices(const clusters_entry* entry, const uint8_t* indices)
{
    uint32_t smooth = 3u * entry->smooth_count, faces = smooth + 3u * entry->face_count;
    bool good = true;
    for (uint32_t i = 0; i < 3u * entry->triangle_count; ++i) {
        bool lit = i < smooth || (i < faces && i % 3 == 0);
        good =
            good && indices[i] <= entry->last_vertex && (!lit || indices[i] < entry->normal_count);
    }
    return good;
}

/// @return where the cluster ends, 0 where it is wrong
static uint64_t check_cluster(const stp_clusters* c, const clusters_entry* entry, uint64_t begin)
{
    uint64_t end = c->size - CLUSTERS_PADDING_BYTES;
    uint32_t vertex_count = entry->last_vertex + 1u;
    bool good = 4 * (uint64_t)entry->offset == begin && entry->triangle_count >= 1 &&
                entry->triangle_count <= STP_CLUSTER_TRIANGLES &&
                entry->smooth_count + entry->face_count <= entry->triangle_count &&
                entry->normal_count <= vertex_count;
    for (int k = 0; k < 3; ++k) {
        good = good && entry->width[k] <= 32;
    }
    uint32_t extra = good ? count_extra(c->present, entry->normal_count) : 0;
    uint32_t table_bytes = clusters_table_bytes(extra);
    if (!good || table_bytes > end - begin) {
        return 0;
    }
    const unsigned char* table = c->bytes + begin;
    for (uint32_t i = 4 * extra; i < table_bytes; ++i) {
        good = good && table[i] <= (i < 5 * extra ? 32 : 0);
    }
    uint64_t size = measure(c->present, entry, table, table_bytes, extra);
    if (!good || size > end - begin || !are_indices(entry, table + table_bytes)) {
        return 0;
    }
    return begin + size;
}

static const char* check_clusters(const stp_clusters* c)
{
    uint64_t begin = CLUSTERS_HEADER_BYTES + (uint64_t)c->cluster_count * CLUSTERS_ENTRY_BYTES;
    uint64_t triangles = 0, vertices = 0;
    for (uint32_t i = 0; i < c->cluster_count; ++i) {
        const unsigned char* bytes = entry_at(c, i);
        clusters_entry entry = clusters_read_entry(bytes);
        if (entry.first_triangle != triangles || bytes[27] != 0 || stp_read_u16(bytes + 30) != 0) {
            return "has clusters whose triangles do not follow each other";
        }
        begin = check_cluster(c, &entry, begin);
        if (begin == 0) {
            return "has a cluster whose counts, sizes or indices are not possible";
        }
        triangles += entry.triangle_count;
        vertices += entry.last_vertex + 1u;
    }
    if (triangles != c->triangle_count || vertices != c->vertex_count) {
        return "has clusters of other counts than it says";
    }
    if (begin + CLUSTERS_PADDING_BYTES != c->size ||
        stp_read_u64(c->bytes + begin) != 0) { // 8 bytes: the padding
        return "does not end behind its last cluster";
    }
    return NULL;
}

const char* stp_clusters_open(const void* bytes, size_t size, stp_clusters* clusters)
{
    const unsigned char* p = bytes;
    *clusters = (stp_clusters){0};
    if (size < CLUSTERS_HEADER_BYTES + CLUSTERS_PADDING_BYTES) {
        return "is too short to hold clusters";
    }
    stp_clusters made = {
        .bytes = bytes,
        .size = size,
        .cluster_count = stp_read_u32(p),
        .triangle_count = stp_read_u32(p + 4),
        .vertex_count = stp_read_u32(p + 8),
        .present = clusters_read_present(p),
    };
    uint32_t known =
        STP_COLUMN_NORMALS | STP_COLUMN_COLORS | STP_COLUMN_TEXCOORDS_0 | STP_COLUMN_TEXCOORDS_1;
    bool good = made.present <= known && stp_read_u32(p + 20) == 0 &&
                made.cluster_count <=
                    (size - CLUSTERS_HEADER_BYTES - CLUSTERS_PADDING_BYTES) / CLUSTERS_ENTRY_BYTES;
    for (int k = 0; k < 3; ++k) {
        int exponent = read_exponent(p + 14 + 2 * k);
        good = good && exponent >= CLUSTERS_EXPONENT_LEAST && exponent <= CLUSTERS_EXPONENT_MOST;
    }
    if (!good) {
        return "has clusters of which the counts, columns or steps are not possible";
    }
    made.step = clusters_power_of_two(read_exponent(p + 14));
    made.texcoord_steps[0] = clusters_power_of_two(read_exponent(p + 16));
    made.texcoord_steps[1] = clusters_power_of_two(read_exponent(p + 18));
    const char* fault = check_clusters(&made);
    if (fault == NULL) {
        *clusters = made;
    }
    return fault;
}

/// Where the runs of a cluster that is being opened lie.
typedef struct run_cursor {
    const unsigned char *origin, *width, *next;
} run_cursor;

/// The next `run_count` channels, of `value_count` values each; 0: they are absent.
static void get_runs(run_cursor* cursor, stp_cluster_run* runs, uint32_t run_count,
                     uint32_t value_count)
{
    for (uint32_t i = 0; i < run_count; ++i) {
        runs[i] = (stp_cluster_run){.bits = cursor->next};
        if (value_count != 0) {
            runs[i].origin = (int32_t)stp_read_u32(cursor->origin);
            runs[i].width = *cursor->width;
            cursor->next += (value_count * runs[i].width + 7) / 8;
            cursor->origin += 4;
            cursor->width += 1;
        }
    }
}

void stp_clusters_get(const stp_clusters* clusters, uint32_t index, stp_cluster* cluster)
{
    const unsigned char* bytes = entry_at(clusters, index);
    clusters_entry entry = clusters_read_entry(bytes);
    uint32_t present = clusters->present, vertex_count = entry.last_vertex + 1u;
    uint32_t sets[2] = {(present & STP_COLUMN_TEXCOORDS_0) != 0 ? vertex_count : 0,
                        (present & STP_COLUMN_TEXCOORDS_1) != 0 ? vertex_count : 0};
    uint32_t colors = (present & STP_COLUMN_COLORS) != 0 ? vertex_count : 0;
    uint32_t extra = (entry.normal_count != 0 ? 2u : 0) + (sets[0] != 0 ? 2u : 0) +
                     (sets[1] != 0 ? 2u : 0) + (colors != 0 ? 4u : 0);
    const unsigned char* table = clusters->bytes + 4 * (size_t)entry.offset;
    cluster->first_triangle = entry.first_triangle;
    cluster->triangle_count = entry.triangle_count;
    cluster->vertex_count = vertex_count;
    cluster->smooth_count = entry.smooth_count;
    cluster->face_count = entry.face_count;
    cluster->normal_count = entry.normal_count;
    cluster->indices = table + clusters_table_bytes(extra);
    run_cursor cursor = {.origin = bytes + 8,
                         .width = bytes + 20,
                         .next = cluster->indices + 3 * (size_t)entry.triangle_count};
    get_runs(&cursor, &cluster->runs[STP_CLUSTER_X], 3, vertex_count);
    cursor.origin = table;
    cursor.width = table + 4 * (size_t)extra;
    get_runs(&cursor, &cluster->runs[STP_CLUSTER_NORMAL_U], 2, entry.normal_count);
    get_runs(&cursor, &cluster->runs[STP_CLUSTER_TEXCOORDS], 2, sets[0]);
    get_runs(&cursor, &cluster->runs[STP_CLUSTER_TEXCOORDS + 2], 2, sets[1]);
    get_runs(&cursor, &cluster->runs[STP_CLUSTER_COLORS], 4, colors);
}

uint32_t stp_clusters_first_triangle(const stp_clusters* clusters, uint32_t index)
{
    return stp_read_u32(entry_at(clusters, index) + 4);
}

uint32_t stp_clusters_find(const stp_clusters* clusters, uint32_t triangle)
{
    uint32_t low = 0, high = clusters->cluster_count;
    while (high - low > 1) {
        uint32_t middle = low + (high - low) / 2;
        if (stp_clusters_first_triangle(clusters, middle) <= triangle) {
            low = middle;
        } else {
            high = middle;
        }
    }
    return low;
}

stp_box stp_clusters_bounds(const stp_clusters* clusters, uint32_t index)
{
    clusters_entry entry = clusters_read_entry(entry_at(clusters, index));
    float low[3], high[3];
    for (int k = 0; k < 3; ++k) {
        low[k] = (float)entry.origin[k] * clusters->step;
        // values wrap at 32 bits in a forged file: then the box is wrong, and nothing else
        int64_t last = (int64_t)entry.origin[k] + (((int64_t)1 << entry.width[k]) - 1);
        high[k] = (float)last * clusters->step;
    }
    return (stp_box){{low[0], low[1], low[2]}, {high[0], high[1], high[2]}};
}

void stp_cluster_positions(const stp_clusters* clusters, const stp_cluster* cluster,
                           float positions[3 * STP_CLUSTER_VERTICES])
{
    for (uint32_t k = 0; k < 3; ++k) {
        const stp_cluster_run run = cluster->runs[k];
        uint64_t mask = ((uint64_t)1 << run.width) - 1;
        for (uint32_t i = 0, at = 0; i < cluster->vertex_count; ++i, at += run.width) {
            uint64_t bits;
            memcpy(&bits, run.bits + (at >> 3), sizeof(bits));
            int32_t value = (int32_t)((uint32_t)run.origin + (uint32_t)((bits >> (at & 7)) & mask));
            positions[3 * i + k] = (float)value * clusters->step;
        }
    }
}

/// Not of unit length.
static stp_vec3 decode_normal(const stp_cluster* cluster, uint32_t vertex)
{
    const float scale = 1.0f / (float)STP_CLUSTER_NORMAL_LIMIT;
    float u = (float)stp_cluster_value(&cluster->runs[STP_CLUSTER_NORMAL_U], vertex) * scale;
    float v = (float)stp_cluster_value(&cluster->runs[STP_CLUSTER_NORMAL_V], vertex) * scale;
    float z = 1.0f - fabsf(u) - fabsf(v);
    float fold = z < 0.0f ? -z : 0.0f;
    u += u >= 0.0f ? -fold : fold;
    v += v >= 0.0f ? -fold : fold;
    return (stp_vec3){u, v, z};
}

bool stp_cluster_normals(const stp_cluster* cluster, uint32_t triangle, stp_vec3 normals[3])
{
    const uint8_t* corner = cluster->indices + 3 * (size_t)triangle;
    if (triangle >= cluster->smooth_count + cluster->face_count) {
        return false;
    }
    bool smooth = triangle < cluster->smooth_count;
    for (int k = 0; k < 3; ++k) {
        normals[k] = k == 0 || smooth ? decode_normal(cluster, corner[k]) : normals[0];
    }
    return true;
}

void stp_cluster_color(const stp_cluster* cluster, uint32_t vertex, float color[4])
{
    for (int k = 0; k < 3; ++k) {
        float root = (float)stp_cluster_value(&cluster->runs[STP_CLUSTER_COLORS + k], vertex) *
                     (1.0f / (float)STP_CLUSTER_COLOR_LIMIT);
        color[k] = root * root;
    }
    color[3] = (float)stp_cluster_value(&cluster->runs[STP_CLUSTER_COLORS + 3], vertex) *
               (1.0f / (float)STP_CLUSTER_ALPHA_LIMIT);
}

stp_coded_mesh stp_clusters_describe(const stp_clusters* clusters)
{
    stp_coded_mesh coded = {
        .bytes = clusters->bytes,
        .size = clusters->size,
        .cluster_count = clusters->cluster_count,
        .triangle_count = clusters->triangle_count,
        .vertex_count = clusters->vertex_count,
    };
    stp_box box = {{FLT_MAX, FLT_MAX, FLT_MAX}, {-FLT_MAX, -FLT_MAX, -FLT_MAX}};
    for (uint32_t i = 0; i < clusters->cluster_count; ++i) {
        stp_cluster cluster;
        stp_clusters_get(clusters, i, &cluster);
        for (uint32_t v = 0; v < cluster.vertex_count; ++v) {
            stp_vec3 p = stp_cluster_position(clusters, &cluster, v);
            box.min = (stp_vec3){stp_min(p.x, box.min.x), stp_min(p.y, box.min.y),
                                 stp_min(p.z, box.min.z)};
            box.max = (stp_vec3){stp_max(p.x, box.max.x), stp_max(p.y, box.max.y),
                                 stp_max(p.z, box.max.z)};
        }
    }
    coded.bounds = clusters->cluster_count != 0 ? box : coded.bounds;
    return coded;
}
