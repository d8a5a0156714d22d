// SPDX-License-Identifier: MIT
// The layout of columns within a block (docs/format.md, Blocks).
#pragma once

#include "base/splats/splat_columns.h"
#include "store/bytes/format.h"

#include <assert.h>

enum { STP_STORE_COLUMN_LIMIT = 10 };

/// A column: a byte range of a block. Absent ones have size 0.
typedef struct stp_store_column {
    uint64_t offset, size;
} stp_store_column;

typedef enum stp_store_mesh_column {
    STP_MESH_POSITIONS,
    STP_MESH_NORMALS,
    STP_MESH_TEXCOORDS_0,
    STP_MESH_TEXCOORDS_1,
    STP_MESH_COLORS,
    STP_MESH_INDICES,
    STP_MESH_COLUMNS
} stp_store_mesh_column;

typedef enum stp_store_point_column {
    STP_POINT_POSITIONS,
    STP_POINT_NORMALS,
    STP_POINT_COLORS,
    STP_POINT_COLUMNS
} stp_store_point_column;

typedef enum stp_store_octave_column {
    STP_OCTAVE_POSITIONS,
    STP_OCTAVE_NORMALS,
    STP_OCTAVE_MATERIALS,
    STP_OCTAVE_COLORS,
    STP_OCTAVE_COVERAGES,
    STP_OCTAVE_SHAPES,
    STP_OCTAVE_RANGES,
    STP_OCTAVE_ERRORS,
    STP_OCTAVE_TURNS,
    STP_OCTAVE_SPREADS,
    STP_OCTAVE_COLUMNS
} stp_store_octave_column;

// Each function fills `columns` and returns the size of the block.
uint64_t stp_store_mesh_columns(uint32_t vertex_count, uint32_t triangle_count, uint32_t present,
                                stp_store_column columns[STP_STORE_COLUMN_LIMIT]);
uint64_t stp_store_point_columns(uint32_t point_count, uint32_t present,
                                 stp_store_column columns[STP_STORE_COLUMN_LIMIT]);
/// Columns of octave `octave`: the splats it adds, with their colours, coverages and light normals.
/// These are those of the whole prefix unless colours are flat.
uint64_t stp_store_octave_columns(const stp_splats* splats, uint32_t octave,
                                  stp_store_column columns[STP_STORE_COLUMN_LIMIT]);

/// Number of splats before octave `octave`.
static inline uint32_t stp_store_octave_begin(const stp_splats* splats, uint32_t octave)
{
    assert(octave <= splats->octave_count);
    return octave == 0 ? 0 : splats->octave_ends[octave - 1];
}

/// Number of colour entries before octave `octave`, or of all octaves if it is the octave count.
/// Flat colours have one entry per splat.
uint64_t stp_store_pyramid_begin(const stp_splats* splats, uint32_t octave);

/// Index of splat 0 among the colours with which octave `octave` draws a prefix.
static inline uint64_t stp_store_colors_begin(const stp_splats* splats, uint32_t octave)
{
    bool flat = (splats->columns & STP_SPLATS_FLAT_COLORS) != 0;
    return flat ? 0 : stp_store_pyramid_begin(splats, octave);
}
