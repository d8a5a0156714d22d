// SPDX-License-Identifier: MIT
#include "store/bytes/columns.h"

#include "base/splats/light_normal.h"

#include <assert.h>

// Lays out columns one after the other, each at the next multiple of `alignment`.
static uint64_t place(stp_store_column* columns, const uint64_t* sizes, size_t count,
                      uint64_t alignment)
{
    assert(count <= STP_STORE_COLUMN_LIMIT);
    uint64_t end = 0;
    for (size_t i = 0; i < STP_STORE_COLUMN_LIMIT; ++i) {
        uint64_t size = i < count ? sizes[i] : 0;
        uint64_t offset = size != 0 ? stp_store_align(end, alignment) : end;
        columns[i] = (stp_store_column){.offset = offset, .size = size};
        end = offset + size;
    }
    return end;
}

uint64_t stp_store_mesh_columns(uint32_t vertex_count, uint32_t triangle_count, uint32_t present,
                                stp_store_column columns[STP_STORE_COLUMN_LIMIT])
{
    uint64_t n = vertex_count;
    uint64_t sizes[STP_MESH_COLUMNS] = {
        [STP_MESH_POSITIONS] = 12 * n,
        [STP_MESH_NORMALS] = (present & STP_COLUMN_NORMALS) != 0 ? 4 * n : 0,
        [STP_MESH_TEXCOORDS_0] = (present & STP_COLUMN_TEXCOORDS_0) != 0 ? 8 * n : 0,
        [STP_MESH_TEXCOORDS_1] = (present & STP_COLUMN_TEXCOORDS_1) != 0 ? 8 * n : 0,
        [STP_MESH_COLORS] = (present & STP_COLUMN_COLORS) != 0 ? 8 * n : 0,
        [STP_MESH_INDICES] = 12 * (uint64_t)triangle_count,
    };
    return place(columns, sizes, STP_MESH_COLUMNS, STP_STORE_COLUMN_ALIGNMENT);
}

uint64_t stp_store_point_columns(uint32_t point_count, uint32_t present,
                                 stp_store_column columns[STP_STORE_COLUMN_LIMIT])
{
    uint64_t n = point_count;
    uint64_t sizes[STP_POINT_COLUMNS] = {
        [STP_POINT_POSITIONS] = 12 * n,
        [STP_POINT_NORMALS] = (present & STP_COLUMN_NORMALS) != 0 ? 4 * n : 0,
        [STP_POINT_COLORS] = (present & STP_COLUMN_COLORS) != 0 ? 4 * n : 0,
    };
    return place(columns, sizes, STP_POINT_COLUMNS, STP_STORE_COLUMN_ALIGNMENT);
}

uint64_t stp_store_octave_columns(const stp_splats* splats, uint32_t octave,
                                  stp_store_column columns[STP_STORE_COLUMN_LIMIT])
{
    assert(octave < splats->octave_count);
    uint64_t prefix = splats->octave_ends[octave];
    assert(prefix >= stp_store_octave_begin(splats, octave) && "octave ends ascend");
    uint64_t n = prefix - stp_store_octave_begin(splats, octave);
    uint64_t entries = (splats->columns & STP_SPLATS_FLAT_COLORS) != 0 ? n : prefix;
    uint64_t lights = stp_has_light_normals(splats, octave) ? prefix : 0;
    uint64_t sizes[STP_OCTAVE_COLUMNS] = {
        [STP_OCTAVE_POSITIONS] = 6 * n,
        [STP_OCTAVE_NORMALS] = 2 * n,
        [STP_OCTAVE_MATERIALS] = n,
        [STP_OCTAVE_COLORS] = 3 * entries,
        [STP_OCTAVE_COVERAGES] = entries,
        [STP_OCTAVE_SHAPES] = (splats->columns & STP_SPLATS_SHAPES) != 0 ? 4 * n : 0,
        [STP_OCTAVE_RANGES] = (splats->columns & STP_SPLATS_RANGES) != 0 ? 4 * n : 0,
        [STP_OCTAVE_ERRORS] = (splats->columns & STP_SPLATS_ERRORS) != 0 ? 4 * n : 0,
        [STP_OCTAVE_TURNS] = 2 * lights,
        [STP_OCTAVE_SPREADS] = lights,
    };
    return place(columns, sizes, STP_OCTAVE_COLUMNS, 1);
}

uint64_t stp_store_pyramid_begin(const stp_splats* splats, uint32_t octave)
{
    assert(octave <= splats->octave_count);
    uint64_t entries = 0;
    if ((splats->columns & STP_SPLATS_FLAT_COLORS) != 0) {
        return stp_store_octave_begin(splats, octave);
    }
    for (uint32_t i = 0; i < octave; ++i) {
        entries += splats->octave_ends[i];
    }
    return entries;
}
