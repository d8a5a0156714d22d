// SPDX-License-Identifier: MIT
// Caps of sections (draw/caps.h), which the processor fills, put into a picture that was shaded.
#pragma once

#include "draw/caps.h"
#include "draw/gl/gl.h"

struct gl_renderer;

/// Made when it is first needed. All zero at first.
typedef struct gl_cap_pass {
    stp_caps* caps;
    GLuint program, nearness, pixels; ///< textures of an eye
    uint32_t width, height;           ///< of the textures
    bool shows;                       ///< caps in the eye's picture that was shaded last
} gl_cap_pass;

void gl_cap_pass_destroy(struct gl_renderer* r);
/// Puts the caps of the eye that was shaded last into its picture and depths, where the style wants them.
/// @return STP_OK, STP_ERROR_OUT_OF_MEMORY, STP_ERROR_UNSUPPORTED, or what reading the store returns; logged
STP_MUST_USE stp_result gl_cap_pass_draw(struct gl_renderer* r);
