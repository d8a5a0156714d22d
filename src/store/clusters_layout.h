// SPDX-License-Identifier: MIT
// The bytes of a coded mesh (docs/format.md, Clusters), for what writes and what reads them.
#pragma once

#include "base/bytes.h"
#include "store/clusters.h"
#include "store/format.h"

enum {
    CLUSTERS_HEADER_BYTES = 24,
    CLUSTERS_ENTRY_BYTES = 32,
    CLUSTERS_PADDING_BYTES =
        8, ///< after the last cluster: a value is read with seven bytes more than it has
    CLUSTERS_EXPONENT_LEAST = -149,
    CLUSTERS_EXPONENT_MOST = 96, ///< any 32-bit number of such steps is finite
    CLUSTERS_NUMBER_LIMIT = (1 << 30) - 1,
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
    uint16_t normal_count;
} clusters_entry;

static inline clusters_entry clusters_read_entry(const unsigned char* p)
{
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
        .normal_count = stp_read_u16(p + 28),
    };
}

static inline void clusters_write_entry(unsigned char* p, const clusters_entry* entry)
{
    stp_write_u32(p, entry->offset);
    stp_write_u32(p + 4, entry->first_triangle);
    for (int k = 0; k < 3; ++k) {
        stp_write_u32(p + 8 + 4 * k, (uint32_t)entry->origin[k]);
        p[20 + k] = entry->width[k];
    }
    p[23] = entry->triangle_count;
    p[24] = entry->last_vertex;
    p[25] = entry->smooth_count;
    p[26] = entry->face_count;
    p[27] = 0;
    stp_write_u16(p + 28, entry->normal_count);
    stp_write_u16(p + 30, 0);
}

/// How many values a channel has; 0 where the mesh or cluster does not have it.
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

/// Bytes of the table of origins and widths of `channel_count` channels beside the positions.
static inline uint32_t clusters_table_bytes(uint32_t channel_count)
{
    return 4 * channel_count + ((channel_count + 3) & ~3u);
}

static inline float clusters_power_of_two(int exponent)
{
    uint64_t bits = (uint64_t)(exponent + 1023) << 52;
    double value;
    memcpy(&value, &bits, sizeof(value));
    return (float)value; // exact down to the least float
}
