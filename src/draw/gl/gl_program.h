// SPDX-License-Identifier: MIT
//
// Programs built from the embedded shaders. A line `#include "name"` is replaced by that file, once
// per shader. If the environment variable STP_SHADER_DIR is set, files are read from that folder
// instead.
#pragma once

#include "draw/gl/gl.h"

/// Compiles and links the shaders of a pass: NAME.vert.glsl and NAME.frag.glsl, or NAME.comp.glsl.
/// `defines` are lines inserted at the top ("#define PAGE_COUNT 1\n"); NULL: none.
/// @return STP_OK, STP_ERROR_OUT_OF_MEMORY, STP_ERROR_UNSUPPORTED (rejected by the driver, with its
/// message); logged
STP_MUST_USE stp_result stp_gl_program_create(stp_context* context, const stp_gl* gl,
                                              const char* vertex, const char* fragment,
                                              const char* defines, GLuint* program);
STP_MUST_USE stp_result stp_gl_program_create_compute(stp_context* context, const stp_gl* gl,
                                                      const char* compute, const char* defines,
                                                      GLuint* program);

/// Text of a shader with its includes. Free it with stp_free.
/// @return STP_OK, STP_ERROR_OUT_OF_MEMORY, STP_ERROR_UNSUPPORTED (there is no such shader); logged
STP_MUST_USE stp_result stp_gl_program_text(stp_context* context, const char* name,
                                            const char* defines, char** text);
