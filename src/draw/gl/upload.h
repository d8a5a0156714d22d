// SPDX-License-Identifier: MIT
//
// Uploads a store's data to the pool, in the shaders' layout (shaders/interface.h). Each item is
// uploaded as a whole on first use; it is there when the frame has been made (conversions.h).
#pragma once

#include "draw/gl/gl_renderer.h"

enum {
    UPLOAD_POINTS = 65536,          ///< maximum points of a chunk
    UPLOAD_CLUSTER_TRIANGLES = 128, ///< triangles per cluster made of a mesh of columns
};

/// Creates the tables of entries. @return STP_OK, STP_ERROR_OUT_OF_MEMORY (logged)
STP_MUST_USE stp_result stp_gl_entries_create(stp_gl_renderer* r);
void stp_gl_entries_destroy(stp_gl_renderer* r);

/// Result of an upload request.
typedef enum stp_gl_upload {
    GL_UPLOAD_THERE,   ///< resident in the pool
    GL_UPLOAD_LATER,   ///< upload limit of the frame reached
    GL_UPLOAD_NO_ROOM, ///< pool full: this frame uses all of it
    GL_UPLOAD_FAILED,  ///< no memory, no data of the store, or no context; logged
} stp_gl_upload;

/// Words per splat of shapes, ranges and errors, which follow an octave's positions and materials.
uint32_t stp_gl_option_words(const stp_splats* splats);

/// Requests octave `octave` of a set: the positions of its own splats, or the colours of all
/// splats up to its end, and then their light normals, if the octave has them. `urgent`: ignores the
/// upload limit.
stp_gl_upload stp_gl_upload_octave(stp_gl_renderer* r, uint32_t set, uint32_t octave, bool colors,
                                   bool urgent);
stp_gl_upload stp_gl_upload_mesh(stp_gl_renderer* r, uint32_t mesh);
stp_gl_upload stp_gl_upload_points(stp_gl_renderer* r, uint32_t point_set, uint32_t chunk,
                                   bool urgent);
stp_gl_upload stp_gl_upload_texture(stp_gl_renderer* r, uint32_t texture, bool data);

static inline uint32_t stp_gl_octave_entry(const stp_gl_renderer* r, uint32_t set, uint32_t octave,
                                           bool colors)
{
    return r->entries.sets[set] + 2 * octave + (colors ? 1u : 0u);
}

static inline uint32_t stp_gl_address(const stp_gl_renderer* r, uint32_t entry)
{
    return r->pool.entries[entry].address;
}

/// Takes room for an upload of `words`, and begins it: `source` receives its source, to be filled.
/// @return GL_UPLOAD_THERE if it has
stp_gl_upload stp_gl_upload_begin(stp_gl_renderer* r, uint32_t entry, uint64_t words, bool urgent,
                                  stp_gl_source** source);
/// Ends an upload, whose pieces were added with this result. After a failure, nothing of it is in
/// the pool.
stp_gl_upload stp_gl_upload_end(stp_gl_renderer* r, uint32_t entry, stp_result result);
