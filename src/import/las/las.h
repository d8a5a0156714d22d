// SPDX-License-Identifier: MIT
//
// Inside the LAS reader. A file is a header, variable length records (VLRs), points, and extended
// records (EVLRs). Points come in chunks: runs of records, or compressed (laz.h). Each chunk is
// decoded alone, in blocks of STP_LAS_BLOCK points, and a block is stored in the columns of a point
// set.
//
// Facts of the format: ASPRS, LAS Specification 1.4, revision 15.
#pragma once

#include "import/reading/import.h"
#include "import/reading/point_columns.h"
#include "import/reading/scan_info.h"

enum {
    STP_LAS_BLOCK = 1024,
    STP_LAS_NO_FIELD = 0,  ///< offset of a field that the format does not have
    STP_LAS_WAVE_SIZE = 29 ///< bytes of a wave packet's description
};

/// Offsets of the fields of a point format within a record.
typedef struct stp_las_layout {
    uint8_t size; ///< bytes of a record without extra bytes
    uint8_t time, rgb, nir, wave;
} stp_las_layout;

typedef struct stp_las_chunk {
    uint64_t offset, size; ///< within the file
    uint64_t first, count; ///< points
    uint64_t read;         ///< number of its first points that are read
} stp_las_chunk;

typedef enum stp_laz_items { STP_LAZ_RAW, STP_LAZ_POINTWISE, STP_LAZ_LAYERED } stp_laz_items;

typedef struct stp_las {
    stp_import* import;
    stp_context* context;
    unsigned minor;  ///< minor version, 0 to 4
    unsigned format; ///< 0 to 10
    bool compressed; ///< from the format byte
    bool wkt;        ///< the coordinate system is stored as WKT
    stp_las_layout layout;
    size_t record_size;
    uint64_t point_count;
    uint64_t header_size, points; ///< offsets of the VLRs and of the points
    uint64_t vlr_count, evlr_count, evlrs;
    double scale[3], offset[3], low[3], high[3];
    int32_t origin[3]; ///< stored positions are relative to this one, in steps of `scale`
    stp_las_chunk* chunks;
    size_t chunk_count;
    stp_laz_items items; ///< how chunks are coded
    bool items_fixed;    ///< layered, version 4: see laz_layered.c
} stp_las;

typedef struct stp_las_record {
    const char* user; ///< 16 bytes, not necessarily terminated
    unsigned id;
    const unsigned char* bytes;
    uint64_t size;
} stp_las_record;

/// Reads and validates the header. @return STP_OK, STP_ERROR_FORMAT, STP_ERROR_UNSUPPORTED,
/// STP_ERROR_TRUNCATED
STP_MUST_USE stp_result stp_las_read_header(stp_las* las);

/// Iterates over VLRs, then EVLRs; starts as all zero.
typedef struct stp_las_records {
    uint64_t index, at;
    bool damaged; ///< a record does not fit: iteration stops before it
} stp_las_records;
/// The first record of a user and id. @return whether it exists
bool stp_las_find_record(const stp_las* las, const char* user, unsigned id, stp_las_record* record);

/// Copies the file's coordinate system to the scene and sets unit and axes. Scales z if it has a
/// different unit. Rejects geographic systems. @return STP_OK, STP_ERROR_UNSUPPORTED,
/// STP_ERROR_OUT_OF_MEMORY (logged)
STP_MUST_USE stp_result stp_las_read_system(stp_las* las);

/// Units found in a WKT text. Zero: none.
typedef struct stp_las_units {
    double horizontal, vertical; ///< metres
    bool geographic;             ///< horizontal coordinates are angles
} stp_las_units;
stp_las_units stp_las_wkt_units(const char* text, size_t size);

/// Decoded points of a chunk: columns of the kept values.
typedef struct stp_las_block {
    int32_t position[3][STP_LAS_BLOCK];
    uint64_t time[STP_LAS_BLOCK]; ///< bits of a double
    uint16_t rgb[3][STP_LAS_BLOCK];
    uint16_t nir[STP_LAS_BLOCK];
    uint16_t intensity[STP_LAS_BLOCK];
    uint16_t source[STP_LAS_BLOCK];
    int16_t angle[STP_LAS_BLOCK]; ///< 0.006 degrees each
    uint8_t classes[STP_LAS_BLOCK];
    uint8_t return_number[STP_LAS_BLOCK], return_count[STP_LAS_BLOCK];
} stp_las_block;

/// Converts whole degrees, as in formats 0 to 5, to steps of 0.006 degrees.
static inline int16_t stp_las_angle(int8_t degrees)
{
    int rounding = degrees < 0 ? -3 : 3;
    return (int16_t)((degrees * 1000 + rounding) / 6);
}

/// Reads `count` uncompressed records into a block, starting at index `first`.
void stp_las_read_records(const stp_las* las, const unsigned char* bytes, size_t count,
                          stp_las_block* block, size_t first);

/// Bits set while points are stored: bit i: attribute i is not zero everywhere.
enum {
    STP_LAS_SEEN_COLOR = 1 << STP_ATTRIBUTES, ///< a colour is not black
    STP_LAS_SEEN_WIDE = 2 << STP_ATTRIBUTES,  ///< a colour has more than 8 bits
};

/// Stores the first `count` points of a block in the columns of a set, starting at `first`. If
/// `wide`, colours use their upper 8 bits. @return the bits that were set
unsigned stp_las_store_block(const stp_las* las, const stp_las_block* block, size_t count,
                             bool wide, stp_point_set* set, size_t first);
/// Columns of a set with this many points.
stp_point_columns_desc stp_las_columns(const stp_las* las, uint32_t point_count);

/// Lists uncompressed records as chunks. @return STP_OK, STP_ERROR_OUT_OF_MEMORY (logged)
STP_MUST_USE stp_result stp_las_list_records(stp_las* las);
/// In a file with at least 4 times `maximum` points, limits the list of chunks to about that many
/// points: coarse nodes of COPC, else the first points of each compressed chunk, else short runs of
/// records. For a smaller file, empties it. @return STP_OK, STP_ERROR_OUT_OF_MEMORY (logged)
STP_MUST_USE stp_result stp_las_sample(stp_las* las, uint64_t maximum);
/// Marks the chunks of COPC levels 0 up to those that together have `maximum` points; other chunks
/// read nothing. @return false if the file is not COPC, its hierarchy is damaged or has no points
/// in these levels, or memory runs out: the caller chooses what is read
bool stp_las_sample_copc(stp_las* las, uint64_t maximum);
/// Number of chunks from `first` on that form a set of at most `points_in_set` points, at least
/// one, and their number of points.
size_t stp_las_chunks_of_set(const stp_las* las, size_t first, uint64_t points_in_set,
                             uint64_t* point_count);
/// Reads all points into sets of whole chunks with at most `points_in_set` points each, unless a
/// single chunk has more.
STP_MUST_USE stp_result stp_las_read_points(stp_las* las, uint64_t points_in_set);
/// The whole reader; see stp_las_read_points.
STP_MUST_USE stp_result stp_las_import(stp_import* import, uint64_t points_in_set);

/// Checks COPC's hierarchy and warns if it is damaged. Reading points does not need it.
void stp_las_check_copc(const stp_las* las);
/// Whether the file is COPC, and the number of nodes and levels of its hierarchy.
void stp_las_describe_copc(const stp_las* las, stp_scan_info* info);

/// Describes the file without reading a point. @return STP_OK, or a failure of the chunk table
/// (logged)
STP_MUST_USE stp_result stp_las_describe(stp_las* las, stp_scan_info* info);
