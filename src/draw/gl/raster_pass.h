// SPDX-License-Identifier: MIT
//
// Splats drawn by compute shaders (shaders/raster.comp.glsl): into a buffer, with atomic operations, and from there into the
// visibility buffer. The picture is that of the points; which is faster is measured (splat_choice.h).
#pragma once

#include "draw/gl/gl.h"

struct gl_renderer;

/// Where the commands of splats lie that are to be drawn.
typedef struct gl_splat_source {
    GLuint buffer;
    GLintptr offset, count_offset; ///< of the commands, and of their number
    GLintptr groups_offset;        ///< of the first group of each; for the compute rasteriser
    uint32_t count;                ///< of commands
    uint64_t groups;               ///< in all
} gl_splat_source;

/// The frame's; for points. @return whether there are any
bool gl_splat_source_find(const struct gl_renderer* r, gl_splat_source* source);

typedef struct gl_raster_pass {
    GLuint program, merge;
    GLuint vertex_array;
    GLuint pixels;
    uint64_t bytes; ///< of `pixels`
} gl_raster_pass;

STP_MUST_USE stp_result gl_raster_pass_create(struct gl_renderer* r);
void gl_raster_pass_destroy(struct gl_renderer* r);

/// Draws into the visibility buffer, which the items drawn before have drawn into too; large ones are noted. Changes what
/// gl_bind_frame has bound.
/// @return STP_OK, STP_ERROR_OUT_OF_MEMORY (logged)
STP_MUST_USE stp_result gl_raster_pass_draw(struct gl_renderer* r, const gl_splat_source* source);

/// Groups that draw so many splats.
uint64_t gl_raster_groups(uint64_t splats);
