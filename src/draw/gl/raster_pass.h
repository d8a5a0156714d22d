// SPDX-License-Identifier: MIT
//
// Draws splats with compute shaders (shaders/raster.comp.glsl): atomically into a buffer, then
// copied to the visibility buffer. The picture is the same as with points; splat_choice.h measures
// which is faster.
#pragma once

#include "draw/gl/gl.h"

struct stp_gl_renderer;

/// Location of the splat commands to draw.
typedef struct stp_gl_splat_source {
    GLuint buffer;
    GLintptr offset, count_offset; ///< offsets of the commands, and of their count
    /// Offset of the first group of each command; for the compute rasteriser
    GLintptr groups_offset;
    uint32_t count;  ///< number of commands
    uint64_t groups; ///< number of groups of all commands
} stp_gl_splat_source;

/// Finds the splat commands of the frame. @return whether there are any
bool stp_gl_splat_source_find(const struct stp_gl_renderer* r, stp_gl_splat_source* source);

typedef struct stp_gl_raster_pass {
    GLuint program, merge;
    GLuint vertex_array;
    GLuint pixels;
    uint64_t bytes; ///< size of `pixels`
} stp_gl_raster_pass;

STP_MUST_USE stp_result stp_gl_raster_pass_create(struct stp_gl_renderer* r);
void stp_gl_raster_pass_destroy(struct stp_gl_renderer* r);

/// Draws into the visibility buffer, together with previously drawn items; queues large splats.
/// Changes bindings of stp_gl_bind_frame.
/// @return STP_OK, STP_ERROR_OUT_OF_MEMORY (logged)
STP_MUST_USE stp_result stp_gl_raster_pass_draw(struct stp_gl_renderer* r,
                                                const stp_gl_splat_source* source);

/// Number of groups that draw this many splats.
uint64_t stp_gl_raster_groups(uint64_t splats);
