// SPDX-License-Identifier: MIT
// The byte layout of a coded mesh (docs/format.md, Clusters), shared by encoder and decoder.
#pragma once

#include "base/io/bytes.h"
#include "store/bytes/format.h"
#include "store/clusters/clusters.h"

#include <assert.h>

enum {
    CLUSTERS_HEADER_BYTES = 24,
    CLUSTERS_ENTRY_BYTES = 32,
    /// After the last cluster: reading a value touches up to 7 bytes beyond it.
    CLUSTERS_PADDING_BYTES = 8,
    CLUSTERS_EXPONENT_MIN = -149,
    CLUSTERS_EXPONENT_MAX = 96, ///< any 32-bit multiple of such a step is finite
    CLUSTERS_NUMBER_LIMIT = (1 << 30) - 1,
    CLUSTERS_CHANNEL_BYTES = 8, ///< size of an extra channel's table entry
    CLUSTERS_MAX_SHIFT = 24,
    CLUSTERS_MAX_OWN = 32,
};

static inline uint32_t clusters_read_present(const void* bytes)
{
    return stp_read_u16((const unsigned char*)bytes + 12);
}

/// A cluster's entry.
typedef struct clusters_entry {
    uint32_t offset; ///< in units of 4 bytes, from the block's start
    uint32_t first_triangle;
    int32_t origin[3];
    uint8_t width[3];
    uint8_t triangle_count;
    uint8_t last_vertex;
    uint8_t smooth_count, face_count;
    uint8_t group; ///< vertices per part; 0: no parts
    uint8_t shift; ///< x, y and z are multiples of 2^shift steps from `origin`
    bool repeats;  ///< all parts repeat the first one's triangles
    bool grouped;  ///< x, y, z have a layer of parts
    uint8_t own_width[3];
    uint16_t normal_count;
} clusters_entry;

static inline clusters_entry clusters_read_entry(const unsigned char* p)
{
    uint32_t counts = stp_read_u16(p + 28), own = stp_read_u16(p + 30);
    return (clusters_entry){
        .offset = stp_read_u32(p),
        .first_triangle = stp_read_u32(p + 4),
        .origin = {(int32_t)stp_read_u32(p + 8), (int32_t)stp_read_u32(p + 12),
                   (int32_t)stp_read_u32(p + 16)},
        .width = {p[20], p[21], p[22]},
        .triangle_count = p[23],
        .last_vertex = p[24],
        .smooth_count = p[25],
        .face_count = p[26],
        .group = p[27],
        .shift = (uint8_t)(counts >> 9 & 31),
        .repeats = (counts >> 14 & 1) != 0,
        .grouped = own >> 15 != 0,
        .own_width = {own & 31, own >> 5 & 31, own >> 10 & 31},
        .normal_count = (uint16_t)(counts & 511),
    };
}

static inline void clusters_write_entry(unsigned char* p, const clusters_entry* entry)
{
    assert(entry->normal_count <= entry->last_vertex + 1u && entry->shift <= CLUSTERS_MAX_SHIFT);
    stp_write_u32(p, entry->offset);
    stp_write_u32(p + 4, entry->first_triangle);
    for (int k = 0; k < 3; ++k) {
        stp_write_u32(p + 8 + 4 * k, (uint32_t)entry->origin[k]);
        p[20 + k] = entry->width[k];
        assert(entry->width[k] <= 32 && entry->own_width[k] < 32 && "own widths have 5 bits");
    }
    p[23] = entry->triangle_count;
    p[24] = entry->last_vertex;
    p[25] = entry->smooth_count;
    p[26] = entry->face_count;
    p[27] = entry->group;
    stp_write_u16(p + 28, (uint16_t)(entry->normal_count | entry->shift << 9 |
                                     (entry->repeats ? 1 : 0) << 14));
    stp_write_u16(p + 30, (uint16_t)(entry->own_width[0] | entry->own_width[1] << 5 |
                                     entry->own_width[2] << 10 | (entry->grouped ? 1 : 0) << 15));
}

/// Number of values of a channel; 0 if the mesh or cluster lacks it.
static inline uint32_t clusters_values(uint32_t present, uint32_t channel, uint32_t vertex_count,
                                       uint32_t normal_count)
{
    switch (channel) {
    case STP_CLUSTER_X:
    case STP_CLUSTER_Y:
    case STP_CLUSTER_Z:
        return vertex_count;
    case STP_CLUSTER_NORMAL_U:
    case STP_CLUSTER_NORMAL_V:
        return normal_count;
    case STP_CLUSTER_TEXCOORDS:
    case STP_CLUSTER_TEXCOORDS + 1:
        return (present & STP_COLUMN_TEXCOORDS_0) != 0 ? vertex_count : 0;
    case STP_CLUSTER_TEXCOORDS + 2:
    case STP_CLUSTER_TEXCOORDS + 3:
        return (present & STP_COLUMN_TEXCOORDS_1) != 0 ? vertex_count : 0;
    default:
        return (present & STP_COLUMN_COLORS) != 0 ? vertex_count : 0;
    }
}

/// Layout of a channel's values.
typedef struct clusters_channel {
    int32_t origin;
    uint8_t width, own_width;
    uint8_t layout; ///< stp_cluster_layout
    uint8_t shift;
} clusters_channel;

static inline clusters_channel clusters_read_channel(const unsigned char* p)
{
    return (clusters_channel){(int32_t)stp_read_u32(p), p[4], p[5], p[6], p[7]};
}

static inline void clusters_write_channel(unsigned char* p, const clusters_channel* channel)
{
    stp_write_u32(p, (uint32_t)channel->origin);
    p[4] = channel->width;
    p[5] = channel->own_width;
    p[6] = channel->layout;
    p[7] = channel->shift;
}

/// The channel of x, y or z (`k`: 0 to 2).
static inline clusters_channel clusters_position_channel(const clusters_entry* entry, uint32_t k)
{
    assert(k <= STP_CLUSTER_Z);
    return (clusters_channel){entry->origin[k], entry->width[k], entry->own_width[k],
                              entry->grouped ? STP_CLUSTER_GROUPED : STP_CLUSTER_PLAIN,
                              entry->shift};
}

/// Bytes of the layer of parts, or of all values if `group` is 0.
static inline uint32_t clusters_base_bytes(const clusters_channel* channel, uint32_t count,
                                           uint32_t group)
{
    assert(channel->layout == STP_CLUSTER_PLAIN || group != 0);
    uint32_t values = channel->layout == STP_CLUSTER_PLAIN ? count : (count + group - 1) / group;
    return (values * channel->width + 7) / 8;
}

/// Bytes of the values within parts.
static inline uint32_t clusters_own_bytes(const clusters_channel* channel, uint32_t count,
                                          uint32_t group)
{
    uint32_t values = channel->layout == STP_CLUSTER_PLAIN     ? 0
                      : channel->layout == STP_CLUSTER_GROUPED ? count
                                                               : group;
    return (values * channel->own_width + 7) / 8;
}

/// Number of triangles whose corners are stored.
static inline uint32_t clusters_index_triangles(const clusters_entry* entry)
{
    return entry->repeats ? entry->triangle_count * entry->group / (entry->last_vertex + 1u)
                          : entry->triangle_count;
}

static inline float clusters_power_of_two(int exponent)
{
    assert(exponent >= -1022 && exponent <= 1023 && "a normal double");
    uint64_t bits = (uint64_t)(exponent + 1023) << 52;
    double value;
    memcpy(&value, &bits, sizeof(value));
    return (float)value; // exact down to the smallest float
}

// Unpacks many cluster values at a time.

enum { CLUSTERS_UNPACK_WIDTH = 16 }; ///< largest width that it handles

/// Unpacks the positions of the first vertices (x, y, z runs of `count` values), bit-identical to
/// the scalar code. @return the number of vertices done: all but the last few, or 0 if the layout
/// does not allow it or the variant does nothing (portable)
uint32_t stp_clusters_unpack_portable(const stp_cluster_run runs[3], uint32_t count, float step,
                                      float* positions);
uint32_t stp_clusters_unpack_vector(const stp_cluster_run runs[3], uint32_t count, float step,
                                    float* positions);
