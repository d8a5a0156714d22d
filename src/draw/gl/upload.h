// SPDX-License-Identifier: MIT
//
// Things of a store on their way to the pool, in the form that shaders read (shaders/interface.h). Each is brought whole
// when it is first needed.
#pragma once

#include "draw/gl/renderer.h"

#include <string.h>

enum {
    UPLOAD_POINTS = 65536,          ///< of a chunk
    UPLOAD_CLUSTER_TRIANGLES = 128, ///< of a mesh that has no clusters of its own
};

/// Tables of entries. @return STP_OK, STP_ERROR_OUT_OF_MEMORY (logged)
STP_MUST_USE stp_result gl_things_create(gl_renderer* r);
void gl_things_destroy(gl_renderer* r);

/// What came of asking for a thing.
typedef enum gl_upload {
    GL_UPLOAD_THERE,   ///< it is in the pool
    GL_UPLOAD_LATER,   ///< the frame has uploaded enough
    GL_UPLOAD_NO_ROOM, ///< all that is in the pool is used by this frame
    GL_UPLOAD_FAILED,  ///< the store could not give it, or the context is lost; logged
} gl_upload;

/// Words of a splat's shape and range, which lie behind the places of an octave.
uint32_t gl_option_words(const stp_splats* surfels);

/// Octave `octave` of a set: where its own surfels are, or the colours of all up to its end. `urgent`: whatever was uploaded.
gl_upload gl_upload_octave(gl_renderer* r, uint32_t set, uint32_t octave, bool colors, bool urgent);
gl_upload gl_upload_mesh(gl_renderer* r, uint32_t mesh);
gl_upload gl_upload_points(gl_renderer* r, uint32_t point_set, uint32_t chunk, bool urgent);
gl_upload gl_upload_texture(gl_renderer* r, uint32_t texture, bool data);

static inline uint32_t gl_octave_entry(const gl_renderer* r, uint32_t set, uint32_t octave,
                                       bool colors)
{
    return r->things.sets[set] + 2 * octave + (colors ? 1u : 0u);
}

static inline uint32_t gl_address(const gl_renderer* r, uint32_t entry)
{
    return r->pool.entries[entry].address;
}

/// Words written one after the other to where a thing lies.
typedef struct gl_writer {
    gl_pool* pool;
    uint32_t address;
    uint64_t left;   ///< words to come
    uint32_t* words; ///< of the ring
    uint32_t used, room;
    gl_ring_part part;
    bool failed;
} gl_writer;

gl_writer gl_writer_begin(gl_renderer* r, uint32_t entry, uint64_t words);
/// Sends what was written and takes more room.
void gl_writer_turn(gl_writer* writer);
/// @return false where the context was lost
bool gl_writer_end(gl_writer* writer);

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

/// Starts an upload of `words`. @return GL_UPLOAD_THERE where there is room, and it can be written
gl_upload gl_upload_begin(gl_renderer* r, uint32_t entry, uint64_t words, bool urgent);
/// Ends it: where it failed, nothing is in the pool.
gl_upload gl_upload_end(gl_renderer* r, uint32_t entry, gl_writer* writer, bool good);
