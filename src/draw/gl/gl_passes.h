// SPDX-License-Identifier: MIT
// Passes of the OpenGL renderer. Each has functions that create, draw and destroy it, and owns its
// programs.
#pragma once

#include "base/core/context.h"
#include "draw/caps.h"
#include "draw/gl/gl.h"
#include "select/view_frame.h"

#include <stipple/base.h>

struct stp_gl_renderer;
struct view_block;

// Draws section caps (draw/caps.h), which the CPU fills, into a shaded picture.

/// Created on first use. Zero-initialize it.
typedef struct stp_gl_cap_pass {
    stp_caps* caps;
    GLuint program, nearness, pixels; ///< textures of an eye
    uint32_t width, height;           ///< size of the textures
    bool shows;                       ///< the eye's last shaded picture has caps
} stp_gl_cap_pass;

void stp_gl_cap_pass_destroy(struct stp_gl_renderer* r);
/// Draws the caps of the last shaded eye into its picture and depths, if the style enables them.
/// @return STP_OK, STP_ERROR_OUT_OF_MEMORY, STP_ERROR_UNSUPPORTED, or what reading the store
/// returns; logged
STP_MUST_USE stp_result stp_gl_cap_pass_draw(struct stp_gl_renderer* r);

// Post-shading effects: the same eye-dome lighting and ambient occlusion as on the CPU
// (draw/effect_shape.h), as compute passes over pixel nearness.

/// Programs and planes are created on first use. Zero-initialize it.
typedef struct stp_gl_effect_pass {
    GLuint window, blocks, shades, blur, darken;
    GLuint buffer;                         ///< effect_block
    GLuint planes[2], block_plane, two[2]; ///< an eye's nearness; its blocks; shading factors
    uint32_t width, height;                ///< size of the planes
} stp_gl_effect_pass;

void stp_gl_effect_pass_destroy(struct stp_gl_renderer* r);
/// Darkens the picture of the last shaded eye, if the style enables it.
/// @return STP_OK, STP_ERROR_OUT_OF_MEMORY, STP_ERROR_UNSUPPORTED; logged
STP_MUST_USE stp_result stp_gl_effect_pass_draw(struct stp_gl_renderer* r);

// The pixel filter, in the same integers as on the CPU (draw/cpu/pixel_filter.h).

/// Program and textures are created on first use. Zero-initialize it.
typedef struct stp_gl_pixel_filter_pass {
    GLuint program;
    GLuint kinds;                       ///< R8UI: of an eye's pixels, 1 where they show a splat
    GLuint copy;                        ///< the picture before it is filtered
    uint32_t width, height, full_width; ///< sizes of the textures
    bool warned; ///< a warning about a missing program or missing memory was logged
} stp_gl_pixel_filter_pass;

void stp_gl_pixel_filter_pass_destroy(struct stp_gl_renderer* r);
/// Call before shading, which then records what pixels show. @return whether the picture can be
/// filtered; false without the program or the memory for it: warns once
bool stp_gl_pixel_filter_pass_begin(struct stp_gl_renderer* r);
/// Filters the current eye's finished picture.
void stp_gl_pixel_filter_pass_draw(struct stp_gl_renderer* r);

// Blends overlapping splats: in two more passes after the visibility buffer (STP_FILTER_EWA), or in
// one pass that replaces it (STP_FILTER_BLEND, STP_FILTER_TEXTURED). Both produce sums of weighted
// colours, which shading divides by the sums of weights.

typedef struct stp_gl_filter_pass {
    GLuint planes_program, blend;              ///< for two passes; 0: not created yet
    GLuint tolerant, textured, tolerant_merge; ///< for one pass
    GLuint splat_texture;                      ///< R8; 0: not created yet
    GLuint vertex_array;
    GLuint planes, sums, framebuffer; ///< textures, RGBA32F; framebuffer of `sums`
    GLuint merged, ids;               ///< a framebuffer of the target's ids, sums and nearness
    GLuint pixels;                    ///< tolerant_pixel
    uint64_t bytes;                   ///< size of `pixels`
    uint32_t width, height;
} stp_gl_filter_pass;

void stp_gl_filter_pass_destroy(struct stp_gl_renderer* r);

/// Whether the style's filter blends in one pass.
bool stp_gl_filter_is_tolerant(const struct stp_gl_renderer* r);

/// Call after the visibility buffer is drawn. @return STP_OK, STP_ERROR_OUT_OF_MEMORY,
/// STP_ERROR_UNSUPPORTED; logged
STP_MUST_USE stp_result stp_gl_filter_pass_blend(struct stp_gl_renderer* r);

/// Draws the splats' part of the visibility buffer and their colours in one pass. @return as
/// stp_gl_filter_pass_blend
STP_MUST_USE stp_result stp_gl_filter_pass_draw_tolerant(struct stp_gl_renderer* r);

/// Binds the blended colours for shading.
void stp_gl_filter_pass_bind(struct stp_gl_renderer* r);

// Depth peeling of transparent surfaces, as in src/draw/cpu/layers.h. Each pass draws transparent
// triangles and splats only. Per pixel it keeps the nearest fragment behind the previous layer and
// in front of the opaque surface.

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
    GLuint optical_depths; ///< of all triangles, for STP_TRANSPARENCY_NEAREST
    /// Layers of the last picture, without the final empty pass; 1 if the nearest stands for all
    uint32_t count;
} stp_gl_layer_pass;

/// Finds the transparent surfaces of the scene. @return STP_OK; logged
STP_MUST_USE stp_result stp_gl_layer_pass_create(struct stp_gl_renderer* r);
void stp_gl_layer_pass_destroy(struct stp_gl_renderer* r);
/// Deletes the programs, which depend on the number of pages.
void stp_gl_layer_pass_destroy_programs(struct stp_gl_renderer* r);
/// Decides whether a picture has layers. Call before its items are made. Logs a warning once if
/// memory is insufficient.
void stp_gl_layer_pass_begin(struct stp_gl_renderer* r);
/// Call after the opaque picture is drawn: draws all layers over it. Waits after each, unless one
/// stands for all. @return as
/// stp_gl_program_create
STP_MUST_USE stp_result stp_gl_layer_pass_draw(struct stp_gl_renderer* r);

// Two-pass occlusion culling, as on the CPU, without waiting for the GPU. Commands whose boxes are
// behind the previous picture's depths are deferred. The depths of the first pass then form a
// pyramid, and deferred commands that it does not occlude are drawn too. Compute shaders decide
// both by writing the commands' instance counts. The picture is the same as without culling.

typedef struct stp_gl_occlusion_pass {
    GLuint cull, fill;      ///< programs; created on first use
    GLuint pyramid;         ///< levels of blocks, floats
    GLuint counters;        ///< commands deferred after the first pass, and culled in the end
    uint32_t width, height; ///< view of the pyramid
    bool known;             ///< it is valid
    bool culls;             ///< the last sample was drawn in two passes
    stp_view_frame frame;   ///< frame of the pyramid's picture; then the rest of its projection
    double shift_x, shift_y, nearness_scale;
} stp_gl_occlusion_pass;

void stp_gl_occlusion_pass_destroy(struct stp_gl_renderer* r);

/// Whether this sample can be drawn in two passes: one eye, perspective, no filter (which blends
/// occluded splats), and no fixed-size points.
bool stp_gl_occlusion_pass_serves(const struct stp_gl_renderer* r);
/// Fills its part of the view block.
void stp_gl_occlusion_pass_set_view(const struct stp_gl_renderer* r, struct view_block* view);
/// `late` false: defers commands that the pyramid of an earlier picture occludes. `late` true:
/// draws deferred commands that this picture's pyramid does not occlude. @return as
/// stp_gl_program_create
STP_MUST_USE stp_result stp_gl_occlusion_pass_cull(struct stp_gl_renderer* r, bool late);
/// Builds the pyramid of everything drawn so far. @return STP_OK, STP_ERROR_OUT_OF_MEMORY, as
/// stp_gl_program_create; logged
STP_MUST_USE stp_result stp_gl_occlusion_pass_fill(struct stp_gl_renderer* r);
