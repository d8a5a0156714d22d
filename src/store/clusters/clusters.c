// SPDX-License-Identifier: MIT
// Reads coded meshes: checked once as a whole, then any cluster at any time.
#include "store/clusters/clusters.h"

#include "store/clusters/clusters_layout.h"

#include <assert.h>
#include <stdatomic.h>

#if __BYTE_ORDER__ != __ORDER_LITTLE_ENDIAN__
#error "values are used straight from the file, which is little-endian"
#endif

static const unsigned char* entry_at(const stp_clusters* clusters, uint32_t index)
{
    assert(index < clusters->cluster_count);
    return clusters->bytes + CLUSTERS_HEADER_BYTES + (size_t)index * CLUSTERS_ENTRY_BYTES;
}

static int read_exponent(const unsigned char* p)
{
    return (int16_t)stp_read_u16(p);
}

/// Bytes of a cluster with these counts and extra channels, including its table.
static uint64_t measure(uint32_t present, const clusters_entry* entry,
                        const clusters_channel* extra, uint32_t table_bytes)
{
    uint64_t size = table_bytes + 3u * (uint64_t)clusters_index_triangles(entry);
    for (uint32_t i = 0; i < STP_CLUSTER_CHANNELS; ++i) {
        uint32_t count = clusters_values(present, i, entry->last_vertex + 1u, entry->normal_count);
        if (count != 0) {
            clusters_channel channel =
                i > STP_CLUSTER_Z ? *extra++ : clusters_position_channel(entry, i);
            size += clusters_base_bytes(&channel, count, entry->group) +
                    clusters_own_bytes(&channel, count, entry->group);
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
    uint32_t stored = 3 * clusters_index_triangles(entry);
    uint32_t limit = entry->repeats ? entry->group : entry->last_vertex + 1u;
    bool good = true;
    for (uint32_t i = 0; i < stored; ++i) {
        bool lit = i < smooth || (i < faces && i % 3 == 0);
        good = good && indices[i] < limit && (!lit || indices[i] < entry->normal_count);
    }
    return good;
}

/// Whether the parts that a cluster declares are valid.
static bool are_parts(const clusters_entry* entry)
{
    uint32_t vertices = entry->last_vertex + 1u;
    if (entry->group == 0) {
        return !entry->grouped && !entry->repeats;
    }
    uint32_t parts = (vertices + entry->group - 1) / entry->group;
    uint32_t lit = entry->smooth_count + entry->face_count;
    return !entry->repeats ||
           (vertices % entry->group == 0 && entry->triangle_count % parts == 0 &&
            (lit == 0 || (lit == entry->triangle_count && entry->normal_count == vertices)));
}

static bool is_channel(const clusters_channel* channel, uint32_t group)
{
    return channel->width <= 32 && channel->own_width <= CLUSTERS_MAX_OWN &&
           channel->shift <= CLUSTERS_MAX_SHIFT && channel->layout <= STP_CLUSTER_REPEATED &&
           (channel->layout == STP_CLUSTER_PLAIN ? channel->own_width == 0 : group != 0);
}

/// Copies the descriptions of a cluster's extra channels from its table.
static void read_channels(const unsigned char* table, uint32_t count, clusters_channel* channels)
{
    for (uint32_t i = 0; i < count; ++i) {
        channels[i] = clusters_read_channel(table + (size_t)CLUSTERS_CHANNEL_BYTES * i);
    }
    atomic_signal_fence(memory_order_seq_cst); // use the checked copy, never reload
}

/// @return the end of the cluster, or 0 if it is invalid
static uint64_t check_cluster(const stp_clusters* c, const clusters_entry* entry, uint64_t begin)
{
    uint64_t end = c->size - CLUSTERS_PADDING_BYTES;
    uint32_t vertex_count = entry->last_vertex + 1u;
    bool good = 4 * (uint64_t)entry->offset == begin && entry->triangle_count >= 1 &&
                entry->triangle_count <= STP_CLUSTER_TRIANGLES &&
                entry->smooth_count + entry->face_count <= entry->triangle_count &&
                entry->normal_count <= vertex_count && are_parts(entry);
    for (uint32_t k = 0; k < 3; ++k) {
        clusters_channel channel = clusters_position_channel(entry, k);
        good = good && is_channel(&channel, entry->group);
    }
    uint32_t extra = good ? count_extra(c->present, entry->normal_count) : 0;
    uint32_t table_bytes = CLUSTERS_CHANNEL_BYTES * extra;
    if (!good || table_bytes > end - begin) {
        return 0;
    }
    const unsigned char* table = c->bytes + begin;
    clusters_channel channels[STP_CLUSTER_CHANNELS];
    read_channels(table, extra, channels);
    for (uint32_t i = 0; i < extra; ++i) {
        good = good && is_channel(&channels[i], entry->group);
    }
    uint64_t size = good ? measure(c->present, entry, channels, table_bytes) : 0;
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
        atomic_signal_fence(memory_order_seq_cst);
        if (entry.first_triangle != triangles || bytes[29] >> 7 != 0) {
            return "has clusters whose triangle ranges have gaps or overlaps";
        }
        begin = check_cluster(c, &entry, begin);
        if (begin == 0) {
            return "has a cluster with invalid counts, sizes or indices";
        }
        triangles += entry.triangle_count;
        vertices += entry.last_vertex + 1u;
    }
    if (triangles != c->triangle_count || vertices != c->vertex_count) {
        return "has clusters whose counts differ from its header";
    }
    if (begin + CLUSTERS_PADDING_BYTES != c->size ||
        stp_read_u64(c->bytes + begin) != 0) { // the 8 padding bytes
        return "does not end after its last cluster";
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
        .processor = stp_processor_detect(),
    };
    uint32_t known =
        STP_COLUMN_NORMALS | STP_COLUMN_COLORS | STP_COLUMN_TEXCOORDS_0 | STP_COLUMN_TEXCOORDS_1;
    bool good = made.present <= known && stp_read_u32(p + 20) == 0 &&
                made.cluster_count <=
                    (size - CLUSTERS_HEADER_BYTES - CLUSTERS_PADDING_BYTES) / CLUSTERS_ENTRY_BYTES;
    for (int k = 0; k < 3; ++k) {
        int exponent = read_exponent(p + 14 + 2 * k);
        good = good && exponent >= CLUSTERS_EXPONENT_MIN && exponent <= CLUSTERS_EXPONENT_MAX;
    }
    if (!good) {
        return "has invalid counts, columns or steps of clusters";
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

/// Builds the run of a channel with `count` values that start at `next`. @return the end of its
/// values
static const unsigned char* get_run(stp_cluster_run* run, const clusters_channel* channel,
                                    uint32_t count, uint32_t group, const unsigned char* next)
{
    const unsigned char* own = next + clusters_base_bytes(channel, count, group);
    *run = (stp_cluster_run){.bits = next,
                             .own = own,
                             .origin = channel->origin,
                             .width = channel->width,
                             .own_width = channel->own_width,
                             .shift = channel->shift,
                             .group = (uint8_t)group,
                             .layout = channel->layout};
    return own + clusters_own_bytes(channel, count, group);
}

static const uint8_t zeros[3 * STP_CLUSTER_TRIANGLES];
static const stp_cluster_run no_run = {.bits = zeros, .own = zeros};

static void get_nothing(stp_cluster* cluster)
{
    *cluster = (stp_cluster){.vertex_count = 1, .indices = zeros, .period = STP_CLUSTER_TRIANGLES};
    for (int i = 0; i < STP_CLUSTER_CHANNELS; ++i) {
        cluster->runs[i] = no_run;
    }
}

/// Whether a cluster's counts, widths and offset are valid. Extra channels are checked elsewhere.
static bool is_entry(const stp_clusters* c, const clusters_entry* entry)
{
    uint64_t minimum = CLUSTERS_HEADER_BYTES + (uint64_t)c->cluster_count * CLUSTERS_ENTRY_BYTES;
    uint64_t begin = 4 * (uint64_t)entry->offset;
    bool good = begin >= minimum && begin <= c->size - CLUSTERS_PADDING_BYTES &&
                entry->triangle_count >= 1 && entry->triangle_count <= STP_CLUSTER_TRIANGLES &&
                entry->first_triangle <= c->triangle_count &&
                entry->triangle_count <= c->triangle_count - entry->first_triangle &&
                entry->smooth_count + entry->face_count <= entry->triangle_count &&
                entry->normal_count <= entry->last_vertex + 1u && are_parts(entry) &&
                clusters_index_triangles(entry) >= 1;
    for (uint32_t k = 0; k < 3; ++k) {
        clusters_channel channel = clusters_position_channel(entry, k);
        good = good && is_channel(&channel, entry->group);
    }
    return good;
}

/// Builds the runs of the channels before `last`, from `next` on; the others read as absent.
/// @return their end, or NULL if a channel is invalid
static const unsigned char* get_runs(uint32_t present, const clusters_entry* entry, uint32_t last,
                                     const clusters_channel* further, const unsigned char* next,
                                     stp_cluster_run runs[STP_CLUSTER_CHANNELS])
{
    for (uint32_t i = last; i < STP_CLUSTER_CHANNELS; ++i) {
        runs[i] = no_run;
    }
    for (uint32_t i = 0; i < last; ++i) {
        uint32_t count = clusters_values(present, i, entry->last_vertex + 1u, entry->normal_count);
        if (count == 0) {
            runs[i] = no_run;
            continue;
        }
        clusters_channel channel =
            i > STP_CLUSTER_Z ? *further++ : clusters_position_channel(entry, i);
        if (i > STP_CLUSTER_Z && !is_channel(&channel, entry->group)) {
            return NULL;
        }
        next = get_run(&runs[i], &channel, count, entry->group, next);
    }
    return next;
}

/// Opens a cluster with the channels before `last`.
static void get_channels(const stp_clusters* clusters, uint32_t index, uint32_t last,
                         stp_cluster* cluster)
{
    clusters_entry entry = clusters_read_entry(entry_at(clusters, index));
    atomic_signal_fence(memory_order_seq_cst);
    uint64_t left = clusters->size - CLUSTERS_PADDING_BYTES - 4 * (uint64_t)entry.offset;
    uint32_t extra = count_extra(clusters->present, entry.normal_count);
    if (!is_entry(clusters, &entry) || (uint64_t)CLUSTERS_CHANNEL_BYTES * extra > left) {
        get_nothing(cluster);
        return;
    }
    const unsigned char* table = clusters->bytes + 4 * (size_t)entry.offset;
    clusters_channel channels[STP_CLUSTER_CHANNELS];
    if (last > STP_CLUSTER_Z + 1) {
        read_channels(table, extra, channels);
    }
    cluster->first_triangle = entry.first_triangle;
    cluster->triangle_count = entry.triangle_count;
    cluster->vertex_count = entry.last_vertex + 1u;
    cluster->smooth_count = entry.smooth_count;
    cluster->face_count = entry.face_count;
    cluster->normal_count = entry.normal_count;
    cluster->indices = table + (size_t)CLUSTERS_CHANNEL_BYTES * extra;
    cluster->period = clusters_index_triangles(&entry);
    cluster->stride = entry.group;
    const unsigned char* end =
        get_runs(clusters->present, &entry, last, channels,
                 cluster->indices + 3 * (size_t)cluster->period, cluster->runs);
    if (end == NULL || (uint64_t)(end - table) > left) {
        get_nothing(cluster);
    }
    assert(cluster->period >= 1 && "stp_cluster_corners divides by it");
}

void stp_clusters_get(const stp_clusters* clusters, uint32_t index, stp_cluster* cluster)
{
    get_channels(clusters, index, STP_CLUSTER_CHANNELS, cluster);
}

void stp_clusters_get_shape(const stp_clusters* clusters, uint32_t index, stp_cluster* cluster)
{
    get_channels(clusters, index, STP_CLUSTER_Z + 1, cluster);
}

/// Indices from `base` on; those that are not below `limit` become `base`. Compiled to vectors.
static void raise_indices(const uint8_t* restrict from, size_t count, uint32_t base, int32_t limit,
                          uint32_t* restrict to)
{
    for (size_t i = 0; i < count; ++i) {
        int32_t index = from[i];
        to[i] = base + (uint32_t)(index < limit ? index : 0);
    }
}

void stp_cluster_indices(const stp_cluster* cluster, uint32_t first, uint32_t* indices)
{
    assert(cluster->vertex_count <= UINT32_MAX - first);
    size_t length = 3 * (size_t)cluster->period, all = 3 * (size_t)cluster->triangle_count;
    uint32_t begin = 0;
    for (size_t at = 0; at < all; at += length) {
        raise_indices(cluster->indices, length, first + begin,
                      (int32_t)(cluster->vertex_count - begin), indices + at);
        begin += cluster->stride;
    }
}

uint32_t stp_clusters_first_triangle(const stp_clusters* clusters, uint32_t index)
{
    return stp_read_u32(entry_at(clusters, index) + 4);
}

uint32_t stp_clusters_triangles(const stp_clusters* clusters, uint32_t index)
{
    uint32_t end = index + 1 < clusters->cluster_count
                       ? stp_clusters_first_triangle(clusters, index + 1)
                       : clusters->triangle_count;
    uint32_t count = end - stp_clusters_first_triangle(clusters, index);
    return count < STP_CLUSTER_TRIANGLES ? count : STP_CLUSTER_TRIANGLES; // of overwritten files
}

uint32_t stp_clusters_find(const stp_clusters* clusters, uint32_t triangle)
{
    assert(triangle < clusters->triangle_count);
    // Clusters hold about equally many triangles, so this guess is close.
    uint32_t count = clusters->cluster_count, step = 1;
    uint32_t guess = (uint32_t)((uint64_t)triangle * count / clusters->triangle_count);
    uint32_t low = guess, high = guess;
    if (stp_clusters_first_triangle(clusters, guess) <= triangle) {
        for (high = guess + 1; high < count; step *= 2) {
            if (stp_clusters_first_triangle(clusters, high) > triangle) {
                break;
            }
            low = high;
            high = step < count - high ? high + step : count;
        }
    } else {
        for (low = guess > 0 ? guess - 1 : 0;
             low > 0 && stp_clusters_first_triangle(clusters, low) > triangle; step *= 2) {
            high = low;
            low = step < low ? low - step : 0;
        }
    }
    while (high - low > 1) {
        uint32_t middle = low + (high - low) / 2;
        if (stp_clusters_first_triangle(clusters, middle) <= triangle) {
            low = middle;
        } else {
            high = middle;
        }
    }
    assert(low < clusters->cluster_count);
    return low;
}

void stp_clusters_prefetch(const stp_clusters* clusters, uint32_t index)
{
    enum { LINE = 64, MOST = 16 };
    size_t begin = 4 * (size_t)stp_read_u32(entry_at(clusters, index)), end = clusters->size;
    if (index + 1 < clusters->cluster_count) {
        end = 4 * (size_t)stp_read_u32(entry_at(clusters, index + 1));
    }
    for (size_t at = begin; at < end && at < begin + (size_t)LINE * MOST; at += LINE) {
        __builtin_prefetch(clusters->bytes + at);
    }
}

stp_box stp_clusters_bounds(const stp_clusters* clusters, uint32_t index)
{
    clusters_entry entry = clusters_read_entry(entry_at(clusters, index));
    float low[3], high[3];
    for (int k = 0; k < 3; ++k) {
        low[k] = (float)entry.origin[k] * clusters->step;
        // Values of a forged or overwritten file may wrap at 32 bits. Then only the box is wrong.
        int64_t range = ((int64_t)1 << (entry.width[k] < 32 ? entry.width[k] : 32)) - 1;
        int64_t last = (int64_t)entry.origin[k] + range * ((int64_t)1 << (entry.shift & 31));
        high[k] = (float)last * clusters->step;
    }
    return (stp_box){{low[0], low[1], low[2]}, {high[0], high[1], high[2]}};
}

/// Unpacks one axis of grouped positions.
static void get_grouped(const stp_cluster_run* run, uint32_t count, float step, float* out)
{
    for (uint32_t i = 0, part = 0; i < count; ++part) {
        uint32_t base = stp_cluster_bits(run->bits, run->width, part);
        uint32_t end = count - i > run->group ? i + run->group : count;
        for (; i < end; ++i) {
            uint32_t value = base + stp_cluster_bits(run->own, run->own_width, i);
            out[3 * i] = (float)(int32_t)((uint32_t)run->origin + (value << run->shift)) * step;
        }
    }
}

/// Nothing: without vectors, values are unpacked one by one.
uint32_t stp_clusters_unpack_portable(const stp_cluster_run runs[3], uint32_t count, float step,
                                      float* positions)
{
    (void)runs, (void)count, (void)step, (void)positions;
    return 0;
}

void stp_cluster_positions(const stp_clusters* clusters, const stp_cluster* cluster,
                           float positions[3 * STP_CLUSTER_VERTICES])
{
    uint32_t done = STP_VARIANT_OF_TWO(clusters->processor, stp_clusters_unpack)(
        cluster->runs, cluster->vertex_count, clusters->step, positions);
    assert(done <= cluster->vertex_count);
    for (uint32_t k = 0; k < 3; ++k) {
        const stp_cluster_run run = cluster->runs[k];
        if (run.layout != STP_CLUSTER_PLAIN) {
            get_grouped(&run, cluster->vertex_count, clusters->step, positions + k);
            continue;
        }
        uint64_t mask = ((uint64_t)1 << run.width) - 1;
        for (uint32_t i = done, at = done * run.width; i < cluster->vertex_count;
             ++i, at += run.width) {
            uint64_t bits;
            memcpy(&bits, run.bits + (at >> 3), sizeof(bits));
            uint32_t value = (uint32_t)((bits >> (at & 7)) & mask) << run.shift;
            positions[3 * i + k] = (float)(int32_t)((uint32_t)run.origin + value) * clusters->step;
        }
    }
}

/// Decodes a vertex normal; not of unit length.
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
    if (triangle >= cluster->smooth_count + cluster->face_count) {
        return false;
    }
    uint32_t corner[3];
    stp_cluster_corners(cluster, triangle, corner);
    bool smooth = triangle < cluster->smooth_count;
    for (int k = 0; k < 3; ++k) {
        uint32_t vertex = corner[k] < cluster->normal_count ? corner[k] : 0;
        normals[k] = k == 0 || smooth ? decode_normal(cluster, vertex) : normals[0];
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
