// SPDX-License-Identifier: MIT
//
// Draws splats with compute shaders (shaders/raster.comp.glsl): atomically into a buffer, then
// copied to the visibility buffer. The picture is the same as with points; splat_choice.h measures
// which is faster.
#pragma once

#include "draw/gl/gl.h"

struct gl_renderer;

/// Location of the splat commands to draw.
typedef struct gl_splat_source {
    GLuint buffer;
    GLintptr offset, count_offset; ///< offsets of the commands, and of their count
    /// Offset of the first group of each command; for the compute rasteriser
    GLintptr groups_offset;
    uint32_t count;  ///< number of commands
    uint64_t groups; ///< number of groups of all commands
} gl_splat_source;

/// Finds the splat commands of the frame. @return whether there are any
bool gl_splat_source_find(const struct gl_renderer* r, gl_splat_source* source);

typedef struct gl_raster_pass {
    GLuint program, merge;
    GLuint vertex_array;
    GLuint pixels;
    uint64_t bytes; ///< size of `pixels`
} gl_raster_pass;

STP_MUST_USE stp_result gl_raster_pass_create(struct gl_renderer* r);
void gl_raster_pass_destroy(struct gl_renderer* r);

/// Draws into the visibility buffer, together with previously drawn items; queues large splats.
/// Changes bindings of gl_bind_frame.
/// @return STP_OK, STP_ERROR_OUT_OF_MEMORY (logged)
STP_MUST_USE stp_result gl_raster_pass_draw(struct gl_renderer* r, const gl_splat_source* source);

/// Number of groups that draw this many splats.
uint64_t gl_raster_groups(uint64_t splats);
