// SPDX-License-Identifier: MIT
//
// Uploads a store's data to the pool, in the shaders' layout (shaders/interface.h). Each item is
// uploaded as a whole on first use.
#pragma once

#include "draw/gl/gl_renderer.h"

#include <string.h>

enum {
    UPLOAD_POINTS = 65536,          ///< maximum points of a chunk
    UPLOAD_CLUSTER_TRIANGLES = 128, ///< triangles per cluster made of a mesh of columns
};

/// Creates the tables of entries. @return STP_OK, STP_ERROR_OUT_OF_MEMORY (logged)
STP_MUST_USE stp_result gl_entries_create(gl_renderer* r);
void gl_entries_destroy(gl_renderer* r);

/// Result of an upload request.
typedef enum gl_upload {
    GL_UPLOAD_THERE,   ///< resident in the pool
    GL_UPLOAD_LATER,   ///< upload limit of the frame reached
    GL_UPLOAD_NO_ROOM, ///< pool full: this frame uses all of it
    GL_UPLOAD_FAILED,  ///< reading the store failed, or the context is lost; logged
} gl_upload;

/// Words per splat of shapes and ranges, which follow an octave's positions and materials.
uint32_t gl_option_words(const stp_splats* surfels);

/// Requests octave `octave` of a set: the positions of its own surfels, or the colours of all
/// surfels up to its end. `urgent`: ignores the upload limit.
gl_upload gl_upload_octave(gl_renderer* r, uint32_t set, uint32_t octave, bool colors, bool urgent);
gl_upload gl_upload_mesh(gl_renderer* r, uint32_t mesh);
gl_upload gl_upload_points(gl_renderer* r, uint32_t point_set, uint32_t chunk, bool urgent);
gl_upload gl_upload_texture(gl_renderer* r, uint32_t texture, bool data);

static inline uint32_t gl_octave_entry(const gl_renderer* r, uint32_t set, uint32_t octave,
                                       bool colors)
{
    return r->entries.sets[set] + 2 * octave + (colors ? 1u : 0u);
}

static inline uint32_t gl_address(const gl_renderer* r, uint32_t entry)
{
    return r->pool.entries[entry].address;
}

/// Sequential writer of words to an item in the pool.
typedef struct gl_writer {
    gl_pool* pool;
    uint32_t address;
    uint64_t left;   ///< remaining words
    uint32_t* words; ///< space in the ring
    uint32_t used, room;
    gl_ring_part part;
    bool failed;
} gl_writer;

gl_writer gl_writer_begin(gl_renderer* r, uint32_t entry, uint64_t words);
/// Sends the written words and gets more space.
void gl_writer_turn(gl_writer* writer);

static inline void gl_write(gl_writer* writer, uint32_t word)
{
    if (writer->used == writer->room) {
        gl_writer_turn(writer);
    }
    if (!writer->failed) {
        writer->words[writer->used++] = word;
    }
}

static inline void gl_write_float(gl_writer* writer, float value)
{
    uint32_t word;
    memcpy(&word, &value, sizeof(word));
    gl_write(writer, word);
}

/// Starts an upload of `words`. @return GL_UPLOAD_THERE if there is room, and it can be written
gl_upload gl_upload_begin(gl_renderer* r, uint32_t entry, uint64_t words, bool urgent);
/// Ends an upload: after a failure, nothing of it is in the pool.
gl_upload gl_upload_end(gl_renderer* r, uint32_t entry, gl_writer* writer, bool good);
