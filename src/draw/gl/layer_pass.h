// SPDX-License-Identifier: MIT
//
// Transparent surfaces, layer by layer, as src/draw/cpu/layers.h: each pass draws transparent triangles and splats only, and
// keeps of each pixel the nearest that is behind the layer before and in front of what is opaque.
#pragma once

#include "base/context.h"
#include "draw/gl/gl.h"

struct gl_renderer;

typedef struct gl_layer_pass {
    bool possible, of_splats; ///< whether the scene has transparent surfaces, and splats of them
    bool active;              ///< the picture that is drawn has layers
    bool told;                ///< that there is no memory
    uint8_t of_shading[256];  ///< whether splats of a shading are transparent
    GLuint noise;             ///< blue noise, as shaders read it
    GLuint triangles, points, large, take, compose; ///< programs
    uint32_t width, height;                         ///< of the textures; 0: none
    struct {
        GLuint ids, nearness, framebuffer;
    } layers[2];
    GLuint light, below;
    uint32_t count; ///< passes of the last picture
} gl_layer_pass;

/// What the scene has of transparent surfaces. @return STP_OK; logged
STP_MUST_USE stp_result gl_layer_pass_create(struct gl_renderer* r);
void gl_layer_pass_destroy(struct gl_renderer* r);
/// Programs depend on the pages.
void gl_layer_pass_destroy_programs(struct gl_renderer* r);
/// Before a picture's items are made: whether it has layers. Where there is no memory for them a warning is logged once.
void gl_layer_pass_begin(struct gl_renderer* r);
/// After the opaque picture is done: draws all layers over it. Waits after each. @return as gl_program_create
STP_MUST_USE stp_result gl_layer_pass_draw(struct gl_renderer* r);
