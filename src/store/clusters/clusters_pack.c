// SPDX-License-Identifier: MIT
// Packs a gathered cluster into bits. Each channel uses its smallest layout.
#include "store/clusters/clusters_encode.h"

#include <assert.h>

/// Little-endian, lowest bit first. @return the end
static unsigned char* pack_values(const uint32_t* values, uint32_t count, uint32_t width,
                                  unsigned char* out)
{
    assert(width >= 1 && width <= 32);
    uint64_t bits = 0;
    uint32_t filled = 0;
    for (uint32_t i = 0; i < count; ++i) {
        assert((uint64_t)values[i] >> width == 0 && "the value fits its width");
        bits |= (uint64_t)values[i] << filled;
        filled += width;
        if (filled >= 32) {
            stp_write_u32(out, (uint32_t)bits);
            out += 4;
            bits >>= 32;
            filled -= 32;
        }
    }
    for (; filled > 0; filled -= filled < 8 ? filled : 8) {
        *out++ = (unsigned char)bits;
        bits >>= 8;
    }
    return out;
}

static uint8_t width_of(uint32_t range)
{
    return (uint8_t)(range != 0 ? 32 - __builtin_clz(range) : 0);
}

/// A channel's values minus their origin, and the values of its parts.
typedef struct packing {
    clusters_channel channel;
    uint32_t count, group;
    uint32_t values[STP_CLUSTER_VERTICES];
    uint32_t bases[STP_CLUSTER_VERTICES];
} packing;

/// Finds the origin, the width, and the low bits that all values share.
static void measure_values(packing* p, const int32_t* values)
{
    assert(p->count >= 1);
    int32_t minimum = values[0];
    uint32_t all = 0, maximum = 0;
    for (uint32_t i = 1; i < p->count; ++i) {
        minimum = values[i] < minimum ? values[i] : minimum;
    }
    for (uint32_t i = 0; i < p->count; ++i) {
        p->values[i] = (uint32_t)values[i] - (uint32_t)minimum;
        all |= p->values[i];
        maximum = p->values[i] > maximum ? p->values[i] : maximum;
    }
    uint32_t shift = all != 0 ? (uint32_t)__builtin_ctz(all) : CLUSTERS_MAX_SHIFT;
    p->channel = (clusters_channel){
        .origin = minimum,
        .width = width_of(maximum),
        .shift = (uint8_t)(shift < CLUSTERS_MAX_SHIFT ? shift : CLUSTERS_MAX_SHIFT)};
}

static void drop_bits(packing* p, uint32_t shift)
{
    p->channel.shift = (uint8_t)shift;
    p->channel.width -= p->channel.width > shift ? (uint8_t)shift : p->channel.width;
    for (uint32_t i = 0; i < p->count && shift > 0; ++i) {
        assert((p->values[i] & ((1u << shift) - 1u)) == 0 && "only zero bits are dropped");
        p->values[i] >>= shift;
    }
}

/// Finds the minimum of each part and the width of the rest. @return whether the rest is equal in
/// all parts
static bool split_values(packing* p)
{
    assert(p->group != 0);
    uint32_t maximum = 0;
    bool alike = true;
    for (uint32_t first = 0, part = 0; first < p->count; first += p->group, ++part) {
        uint32_t end = p->count - first > p->group ? first + p->group : p->count;
        uint32_t minimum = p->values[first];
        for (uint32_t i = first + 1; i < end; ++i) {
            minimum = p->values[i] < minimum ? p->values[i] : minimum;
        }
        for (uint32_t i = first; i < end; ++i) {
            uint32_t own = p->values[i] - minimum;
            maximum = own > maximum ? own : maximum;
            alike = alike && (part == 0 || own == p->values[i - first] - p->bases[0]);
        }
        p->bases[part] = minimum;
    }
    p->channel.own_width = width_of(maximum);
    return alike;
}

static uint32_t count_bytes(const packing* p, stp_cluster_layout layout)
{
    clusters_channel channel = p->channel;
    channel.layout = (uint8_t)layout;
    return clusters_base_bytes(&channel, p->count, p->group) +
           clusters_own_bytes(&channel, p->count, p->group);
}

/// Writes a channel in its layout. Other layouts than plain need its values split.
static unsigned char* write_values(packing* p, unsigned char* out)
{
    if (p->channel.layout == STP_CLUSTER_PLAIN) {
        p->channel.own_width = 0;
        return p->channel.width != 0 ? pack_values(p->values, p->count, p->channel.width, out)
                                     : out;
    }
    uint32_t parts = (p->count + p->group - 1) / p->group;
    for (uint32_t i = 0; i < p->count; ++i) {
        p->values[i] -= p->bases[i / p->group];
    }
    if (p->channel.width != 0) {
        out = pack_values(p->bases, parts, p->channel.width, out);
    }
    uint32_t own = p->channel.layout == STP_CLUSTER_GROUPED ? p->count : p->group;
    return p->channel.own_width != 0 ? pack_values(p->values, own, p->channel.own_width, out) : out;
}

/// Axes share one layout and one shift, because the entry has only one of each.
static unsigned char* pack_positions(const stp_cluster_maker* m, clusters_entry* entry,
                                     unsigned char* out)
{
    const unsigned char* start = out;
    packing axes[3];
    uint32_t shift = CLUSTERS_MAX_SHIFT, plain = 0, grouped = 0;
    for (uint32_t k = 0; k < 3; ++k) {
        axes[k].count = m->vertex_count;
        axes[k].group = entry->group;
        measure_values(&axes[k], m->values[k]);
        shift = axes[k].channel.shift < shift ? axes[k].channel.shift : shift;
    }
    for (uint32_t k = 0; k < 3; ++k) {
        drop_bits(&axes[k], shift);
        plain += count_bytes(&axes[k], STP_CLUSTER_PLAIN);
        if (entry->group != 0) {
            (void)split_values(&axes[k]);
            grouped += count_bytes(&axes[k], STP_CLUSTER_GROUPED);
        }
    }
    entry->shift = (uint8_t)shift;
    entry->grouped = entry->group != 0 && grouped < plain;
    for (uint32_t k = 0; k < 3; ++k) {
        axes[k].channel.layout = entry->grouped ? STP_CLUSTER_GROUPED : STP_CLUSTER_PLAIN;
        out = write_values(&axes[k], out);
        entry->origin[k] = axes[k].channel.origin;
        entry->width[k] = axes[k].channel.width;
        entry->own_width[k] = axes[k].channel.own_width;
    }
    assert((size_t)(out - start) == (entry->grouped ? grouped : plain) && "as measured");
    (void)start;
    return out;
}

static unsigned char* pack_channel(const int32_t* values, uint32_t count, uint32_t group,
                                   unsigned char* table, unsigned char* out)
{
    packing p = {.count = count, .group = group};
    measure_values(&p, values);
    drop_bits(&p, p.channel.shift);
    if (group != 0) {
        stp_cluster_layout layout = split_values(&p) ? STP_CLUSTER_REPEATED : STP_CLUSTER_GROUPED;
        bool smaller = count_bytes(&p, layout) < count_bytes(&p, STP_CLUSTER_PLAIN);
        p.channel.layout = smaller ? (uint8_t)layout : STP_CLUSTER_PLAIN;
    }
    out = write_values(&p, out);
    clusters_write_channel(table, &p.channel);
    return out;
}

/// Whether all parts repeat the first one's triangles, with shifted vertex indices.
static bool are_parts_alike(const stp_cluster_maker* m, uint32_t parts)
{
    if (m->group == 0 || parts * m->group != m->vertex_count || m->triangle_count % parts != 0) {
        return false;
    }
    uint32_t period = m->triangle_count / parts;
    bool alike = true;
    for (uint32_t t = 0; t < m->triangle_count; ++t) {
        for (uint32_t k = 0; k < 3; ++k) {
            alike = alike && m->corners[t][k] == m->corners[t % period][k] + t / period * m->group;
        }
    }
    return alike;
}

size_t stp_clusters_pack(const stp_cluster_maker* m, clusters_entry* entry, unsigned char* bytes)
{
    assert(m->group <= UINT8_MAX && m->vertex_count >= 1 && m->triangle_count >= 1);
    entry->group = (uint8_t)m->group;
    entry->repeats = m->group != 0 && are_parts_alike(m, m->vertex_count / m->group);
    uint32_t counts[STP_CLUSTER_CHANNELS], extra = 0;
    for (uint32_t i = STP_CLUSTER_Z + 1; i < STP_CLUSTER_CHANNELS; ++i) {
        counts[i] = clusters_values(m->present, i, m->vertex_count, entry->normal_count);
        extra += counts[i] != 0;
    }
    unsigned char* table = bytes;
    unsigned char* out = bytes + (size_t)CLUSTERS_CHANNEL_BYTES * extra;
    size_t index_bytes = 3 * (size_t)clusters_index_triangles(entry);
    memcpy(out, m->corners, index_bytes);
    out = pack_positions(m, entry, out + index_bytes);
    for (uint32_t i = STP_CLUSTER_Z + 1; i < STP_CLUSTER_CHANNELS; ++i) {
        if (counts[i] != 0) {
            out = pack_channel(m->values[i], counts[i], m->group, table, out);
            table += CLUSTERS_CHANNEL_BYTES;
        }
    }
    assert(table == bytes + (size_t)CLUSTERS_CHANNEL_BYTES * extra);
    while (((size_t)(out - bytes) & 3) != 0) {
        *out++ = 0;
    }
    assert((size_t)(out - bytes) <= CLUSTER_MAX_BYTES);
    return (size_t)(out - bytes);
}
