// SPDX-License-Identifier: MIT
//
// Programs made of the embedded shaders. A line `#include "name"` is replaced by that file, once a shader; where
// STP_SHADER_DIR is set in the environment, files are read from that folder instead.
#pragma once

#include "draw/gl/gl.h"

/// Compiles and links the shaders of a pass: NAME.vert.glsl and NAME.frag.glsl, or NAME.comp.glsl. `defines` are lines put
/// before all else ("#define PAGE_COUNT 1\n"); NULL: none.
/// @return STP_OK, STP_ERROR_OUT_OF_MEMORY, STP_ERROR_UNSUPPORTED (the driver refuses it, in its words); logged
STP_MUST_USE stp_result gl_program_create(stp_context* context, const stp_gl* gl,
                                          const char* vertex, const char* fragment,
                                          const char* defines, GLuint* program);
STP_MUST_USE stp_result gl_program_create_compute(stp_context* context, const stp_gl* gl,
                                                  const char* compute, const char* defines,
                                                  GLuint* program);

/// The whole text of a shader, with what it includes; for tests. stp_free. NULL where it, or memory, is not there; logged.
char* gl_program_text(stp_context* context, const char* name, const char* defines);
