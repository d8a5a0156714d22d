// SPDX-License-Identifier: MIT
//
// Inside the LAS reader: compressed points (LAZ). The VLR and the table of chunks (laz_table.c),
// chunks whose points follow one another (formats 0 to 5, laz_pointwise.c), and chunks in layers
// (formats 6 to 10, laz_layered.c).
//
// Facts of the format: M. Isenburg, LASzip: lossless compression of LiDAR data, 2013, and the files
// that LASzip writes.
#pragma once

#include "import/las/las.h"
#include "import/las/laz_coder.h"

/// Reads the compression VLR and the chunk table, and checks them against the header and the file.
/// @return STP_OK, STP_ERROR_FORMAT, STP_ERROR_UNSUPPORTED, STP_ERROR_TRUNCATED,
/// STP_ERROR_OUT_OF_MEMORY (logged)
STP_MUST_USE stp_result stp_laz_read_table(stp_las* las);

/// Decodes one chunk at a time; each thread has its own.
typedef struct stp_laz stp_laz;

/// @return NULL if memory runs out
stp_laz* stp_laz_create(const stp_las* las);
void stp_laz_destroy(const stp_las* las, stp_laz* laz);
/// Starts a chunk. @return whether it is valid
bool stp_laz_begin(stp_laz* laz, const stp_las_chunk* chunk);
/// Decodes the next `count` points of the chunk into a block. @return false if the chunk is damaged
bool stp_laz_next(stp_laz* laz, size_t count, stp_las_block* block);

// For these files:

typedef struct stp_laz_pointwise stp_laz_pointwise;
typedef struct stp_laz_layered stp_laz_layered;

struct stp_laz {
    const stp_las* las;
    unsigned char* numbers; ///< memory of all models
    uint32_t epoch;         ///< number of the current chunk; models of earlier ones are reset
    stp_las_chunk chunk;
    uint64_t given; ///< points of the chunk so far
    stp_laz_pointwise* pointwise;
    stp_laz_layered* layered;
};

// Made twice: see stp_laz_pool.
void stp_laz_pointwise_make(stp_laz_pool* pool, stp_laz_pointwise* p);
void stp_laz_layered_make(stp_laz_pool* pool, stp_laz_layered* l);

/// @return NULL if memory runs out
stp_laz_pointwise* stp_laz_pointwise_create(const stp_las* las);
void stp_laz_pointwise_destroy(const stp_las* las, stp_laz_pointwise* p);
stp_laz_layered* stp_laz_layered_create(const stp_las* las);

// Start after the first point of a chunk, which is uncompressed. `raw` is that point, `block` holds
// it at index 0, `bytes` follow it.
bool stp_laz_pointwise_begin(stp_laz* laz, const stp_las_block* block, const unsigned char* raw,
                             const unsigned char* bytes, size_t size);
bool stp_laz_layered_begin(stp_laz* laz, const stp_las_block* block, const unsigned char* raw,
                           const unsigned char* bytes, size_t size);
// Decode points [first, first + count) of a block.
bool stp_laz_pointwise_next(stp_laz* laz, size_t first, size_t count, stp_las_block* block);
bool stp_laz_layered_next(stp_laz* laz, size_t first, size_t count, stp_las_block* block);
