// SPDX-License-Identifier: MIT
//
// Conversions of a store's data into the words that shaders read (shaders/interface.h). They are
// collected in pieces of a few thousand words. All threads convert a batch of pieces straight into
// mapped memory, and it is copied to the pool.
#pragma once

#include "base/splats/splat_columns.h"
#include "draw/gl/pool.h"
#include "raster/texture.h"
#include "store/clusters/clusters.h"
#include "store/file/store.h"

/// A mesh, and what is read of it.
typedef struct stp_gl_mesh_source {
    stp_store_mesh mesh; ///< of columns; else only described
    stp_clusters clusters;
    bool clustered;
    bool reads[2]; ///< texture coordinates that the material uses
    bool colors;
} stp_gl_mesh_source;

/// An octave of a splat set.
typedef struct stp_gl_octave_source {
    stp_splats splats;
    uint32_t octave;
} stp_gl_octave_source;

typedef struct stp_gl_points_source {
    stp_store_point_set points;
    bool hides; ///< colours of zero alpha hide points
} stp_gl_points_source;

/// What an item of the pool is converted from. The store's memory stays; that of a texture must do so
/// until stp_gl_conversions_send or stp_gl_conversions_drop.
typedef struct stp_gl_source {
    uint32_t entry; ///< of the pool
    union {
        stp_gl_octave_source octave;
        stp_gl_mesh_source mesh;
        stp_gl_points_source points;
        stp_texture_pyramid texture;
    } of;
} stp_gl_source;

typedef struct stp_gl_piece stp_gl_piece;

/// Writes all words of a piece. Any thread calls it.
typedef void stp_gl_convert(const stp_gl_source* source, const stp_gl_piece* piece,
                            uint32_t* words);

/// A part of an item. What the units are is up to the function: splats, clusters, ...
struct stp_gl_piece {
    stp_gl_convert* convert;
    size_t begin, end; ///< units
    uint64_t place;    ///< a number for the function
    uint32_t source, words;
    uint32_t address; ///< in the pool
    uint32_t offset;  ///< in the batch, in words
};

enum { GL_PIECE_WORDS = 1 << 14 }; ///< of a piece, about

/// Zero-initialize it.
typedef struct stp_gl_conversions {
    stp_gl_source* sources;
    size_t source_count, source_capacity;
    stp_gl_piece* pieces; ///< of the batch
    size_t piece_count, piece_capacity;
    uint32_t words;   ///< of these
    uint32_t address; ///< of the last item's next piece
    uint64_t left;    ///< words of the last item without a piece
} stp_gl_conversions;

void stp_gl_conversions_destroy(stp_context* context, stp_gl_conversions* c);

/// Begins an item of `words`, which has a place in the pool. @return its source, to be filled before
/// its first piece is added; NULL if out of memory (logged)
stp_gl_source* stp_gl_conversions_begin(stp_gl_conversions* c, const stp_gl_pool* pool,
                                        uint32_t entry, uint64_t words);
/// Adds a piece of up to POOL_PART_WORDS to the last item. A full batch is sent first. @return as
/// stp_gl_conversions_send; STP_ERROR_OUT_OF_MEMORY; STP_ERROR_FORMAT if the item gets more words
/// than it announced: its file was overwritten. Logged; what is collected stays, to be dropped
STP_MUST_USE stp_result stp_gl_conversions_add(stp_gl_conversions* c, stp_gl_pool* pool,
                                               stp_gl_piece piece);
/// Adds pieces of the units [begin, end), `each` words a unit.
STP_MUST_USE stp_result stp_gl_conversions_add_range(stp_gl_conversions* c, stp_gl_pool* pool,
                                                     stp_gl_convert* convert, size_t begin,
                                                     size_t end, uint32_t each);
/// Ends an item. @return STP_OK, STP_ERROR_FORMAT (logged) if words are missing
STP_MUST_USE stp_result stp_gl_conversions_end(const stp_gl_conversions* c,
                                               const stp_gl_pool* pool);
/// Converts and sends what is collected. @return STP_OK; STP_ERROR_UNSUPPORTED (logged) if the
/// context is lost: then nothing of these items is in the pool
STP_MUST_USE stp_result stp_gl_conversions_send(stp_gl_conversions* c, stp_gl_pool* pool);
/// Removes the last item, which has no pieces yet, from the pool.
void stp_gl_conversions_cancel(stp_gl_conversions* c, stp_gl_pool* pool);
/// Removes the items of the batch from the pool.
void stp_gl_conversions_drop(stp_gl_conversions* c, stp_gl_pool* pool);
