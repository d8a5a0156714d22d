// SPDX-License-Identifier: MIT
//
// Selection by compute shaders (shaders/select.comp.glsl): the graph's nodes lie in buffers, each level of the walk down is
// one dispatch, and items, runs and indirect draw commands with their counts are left in buffers. The list is that of
// stp_select, in no order.
//
// It does all of a scene with prefixes by insertion radius, for one eye and one size of splats; what else a quality or a
// view asks for is the processor's. Renderers draw the processor's lists; this one is there where it is faster to make.
#pragma once

#include "draw/gl/gl.h"
#include "select/select.h"

typedef enum gl_select_buffer {
    GL_SELECT_NODES,
    GL_SELECT_EDGES,
    GL_SELECT_PARTS,
    GL_SELECT_SETS,
    GL_SELECT_QUEUE,
    GL_SELECT_LEVELS,
    GL_SELECT_ITEMS,
    GL_SELECT_RUNS,
    GL_SELECT_COMMANDS,
    GL_SELECT_VIEW,
    GL_SELECT_PYRAMID,
    GL_SELECT_BUFFERS
} gl_select_buffer;

/// All zero at first.
typedef struct gl_select_pass {
    stp_context* context;
    const stp_gl* gl;
    const stp_store* store;
    GLuint program;
    GLuint buffers[GL_SELECT_BUFFERS]; ///< by binding
    uint32_t level_count;              ///< of the graph, the root's included
    size_t pyramid_bytes;
} gl_select_pass;

/// What was counted.
typedef struct gl_select_counts {
    uint32_t items, runs, splat_commands, triangle_commands;
    uint32_t hidden, visited; ///< nodes
} gl_select_counts;

/// @return STP_OK, STP_ERROR_OUT_OF_MEMORY, STP_ERROR_LIMIT (the graph is too deep), STP_ERROR_UNSUPPORTED; logged
STP_MUST_USE stp_result gl_select_create(stp_context* context, const stp_gl* gl,
                                         const stp_store* store, gl_select_pass* pass);
void gl_select_destroy(gl_select_pass* pass);

/// Whether a list is one of those that are made here.
bool gl_select_can(const stp_view* view, const stp_quality* quality);

/// Makes the list; does not wait. gl_select_can must be so.
/// @return STP_OK, STP_ERROR_ARGUMENT (a view that is none), STP_ERROR_OUT_OF_MEMORY; logged
STP_MUST_USE stp_result gl_select_run(gl_select_pass* pass, const stp_view* view,
                                      const stp_quality* quality);

/// Waits, and reads the list back: items and runs, in no order and without ids.
/// @return STP_OK, STP_ERROR_LIMIT (there was no room for all of it), STP_ERROR_OUT_OF_MEMORY; logged
STP_MUST_USE stp_result gl_select_read(gl_select_pass* pass, stp_draw_list* list,
                                       gl_select_counts* counts);
