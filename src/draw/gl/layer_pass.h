// SPDX-License-Identifier: MIT
//
// Depth peeling of transparent surfaces, as in src/draw/cpu/layers.h. Each pass draws transparent
// triangles and splats only. Per pixel it keeps the nearest fragment behind the previous layer and
// in front of the opaque surface.
#pragma once

#include "base/core/context.h"
#include "draw/gl/gl.h"

struct stp_gl_renderer;

typedef struct stp_gl_layer_pass {
    bool possible, of_splats; ///< whether the scene has transparent surfaces, and splats of them
    bool active;              ///< the current picture has layers
    bool warned;              ///< a warning about missing memory was logged
    uint8_t of_shading[256];  ///< per shading: whether its splats are transparent
    GLuint noise;             ///< blue noise in the shaders' layout
    GLuint triangles, points, large, take, compose; ///< programs
    uint32_t width, height;                         ///< size of the textures; 0: none
    struct {
        GLuint ids, nearness, framebuffer;
    } layers[2];
    GLuint light, below;
    uint32_t count; ///< layers of the last picture, without the final empty pass
} stp_gl_layer_pass;

/// Finds the transparent surfaces of the scene. @return STP_OK; logged
STP_MUST_USE stp_result stp_gl_layer_pass_create(struct stp_gl_renderer* r);
void stp_gl_layer_pass_destroy(struct stp_gl_renderer* r);
/// Deletes the programs, which depend on the number of pages.
void stp_gl_layer_pass_destroy_programs(struct stp_gl_renderer* r);
/// Decides whether a picture has layers. Call before its items are made. Logs a warning once if
/// memory is insufficient.
void stp_gl_layer_pass_begin(struct stp_gl_renderer* r);
/// Call after the opaque picture is drawn: draws all layers over it. Waits after each. @return as
/// stp_gl_program_create
STP_MUST_USE stp_result stp_gl_layer_pass_draw(struct stp_gl_renderer* r);
