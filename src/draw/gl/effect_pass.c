// SPDX-License-Identifier: MIT
#include "base/core/context.h"
#include "draw/effect_shape.h"
#include "draw/gl/gl_passes.h"
#include "draw/gl/gl_renderer.h"

#include <assert.h>

void stp_gl_effect_pass_destroy(stp_gl_renderer* r)
{
    stp_gl_effect_pass* pass = &r->effects;
    const GLuint textures[] = {pass->planes[0], pass->planes[1], pass->block_plane, pass->two[0],
                               pass->two[1]};
    r->gl.DeleteProgram(pass->window);
    r->gl.DeleteProgram(pass->blocks);
    r->gl.DeleteProgram(pass->shades);
    r->gl.DeleteProgram(pass->blur);
    r->gl.DeleteProgram(pass->darken);
    r->gl.DeleteBuffers(1, &pass->buffer);
    r->gl.DeleteTextures(5, textures);
    *pass = (stp_gl_effect_pass){0};
}

static stp_result make_programs(stp_gl_renderer* r)
{
    stp_gl_effect_pass* pass = &r->effects;
    stp_context* context = r->base.context;
    const struct {
        const char* name;
        GLuint* program;
    } programs[] = {{"window.comp.glsl", &pass->window},
                    {"blocks.comp.glsl", &pass->blocks},
                    {"shades.comp.glsl", &pass->shades},
                    {"blur.comp.glsl", &pass->blur},
                    {"darken.comp.glsl", &pass->darken}};
    stp_result result = STP_OK;
    for (size_t i = 0; i < sizeof(programs) / sizeof(programs[0]) && result == STP_OK; ++i) {
        if (*programs[i].program == 0) {
            result = stp_gl_program_create_compute(context, &r->gl, programs[i].name, NULL,
                                                   programs[i].program);
        }
    }
    if (result == STP_OK && pass->buffer == 0) {
        r->gl.CreateBuffers(1, &pass->buffer);
        r->gl.NamedBufferStorage(pass->buffer, sizeof(effect_block), NULL, GL_DYNAMIC_STORAGE_BIT);
    }
    return result;
}

static stp_result make_planes(stp_gl_renderer* r)
{
    const stp_gl* gl = &r->gl;
    stp_gl_effect_pass* pass = &r->effects;
    uint32_t width = r->target.width, height = r->target.height;
    if (pass->width == width && pass->height == height) {
        return STP_OK;
    }
    const GLuint old[] = {pass->planes[0], pass->planes[1], pass->block_plane, pass->two[0],
                          pass->two[1]};
    gl->DeleteTextures(5, old);
    while (gl->GetError() != GL_NO_ERROR) { // discard errors of earlier calls
    }
    for (int i = 0; i < 2; ++i) {
        pass->planes[i] = stp_gl_make_texture(gl, GL_R32F, width, height, "nearness of effects");
        pass->two[i] = stp_gl_make_texture(gl, GL_RG32F, width, height, "shades");
    }
    pass->block_plane =
        stp_gl_make_texture(gl, GL_R32F, (width + EFFECT_BLOCK - 1) / EFFECT_BLOCK,
                            (height + EFFECT_BLOCK - 1) / EFFECT_BLOCK, "blocks of nearness");
    pass->width = width;
    pass->height = height;
    if (gl->GetError() != GL_NO_ERROR) {
        pass->width = 0;
        return stp_fail(r->base.context, STP_ERROR_OUT_OF_MEMORY,
                        "gl: not enough graphics memory for effects on a picture of %ux%u", width,
                        height);
    }
    return STP_OK;
}

static void send_numbers(stp_gl_renderer* r, const stp_effect_shape* shape)
{
    assert(shape->pair_count <= EFFECT_PAIRS && shape->light_step > 0);
    const stp_placement* p = &r->placement;
    bool constant = p->frame.parallel;
    double gain = constant ? p->frame.scale / fabs(p->nearness_scale) : p->frame.scale;
    effect_block block = {.numbers = {(float)gain, constant ? 1.0f : 0.0f, shape->light, 0.0f},
                          .pair_count = shape->pair_count,
                          .light_step = (uint32_t)shape->light_step};
    if (shape->pair_count > 0) {
        block.numbers[3] = STP_OCCLUSION_STRENGTH / (float)shape->pair_count;
    }
    for (uint32_t i = 0; i < shape->pair_count; ++i) {
        const stp_effect_pair* pair = &shape->pairs[i];
        float* place = block.pairs[(size_t)2 * i];
        place[0] = (float)pair->x;
        place[1] = (float)pair->y;
        place[2] = pair->far ? 1.0f : 0.0f;
        for (int k = 0; k < 3; ++k) {
            block.pairs[2 * (size_t)i + 1][k] = pair->numbers[k];
        }
    }
    r->gl.NamedBufferSubData(r->effects.buffer, 0, sizeof(block), &block);
    r->gl.BindBufferBase(GL_UNIFORM_BUFFER, BINDING_EFFECTS, r->effects.buffer);
}

_Static_assert(EFFECT_PAIRS == STP_EFFECT_PAIRS, "room for all pairs");

static void run(stp_gl_renderer* r, GLuint program, GLuint out, GLenum format, uint32_t width,
                uint32_t height)
{
    const stp_gl* gl = &r->gl;
    gl->BindImageTexture(IMAGE_PLANE, out, 0, GL_FALSE, 0, GL_WRITE_ONLY, format);
    stp_gl_dispatch_pixels(r, program, width, height);
    gl->MemoryBarrier(GL_TEXTURE_FETCH_BARRIER_BIT | GL_SHADER_IMAGE_ACCESS_BARRIER_BIT);
}

/// Nearness without gaps between disks: closes gaps narrower than the valley between disks, and
/// keeps silhouettes. @return the plane that holds it
static GLuint close_gaps(stp_gl_renderer* r, int32_t reach)
{
    assert(reach > 0 && "without gaps the depths are read as they are");
    static const GLint axes[4][2] = {{1, 0}, {0, 1}, {1, 0}, {0, 1}};
    const stp_gl* gl = &r->gl;
    stp_gl_effect_pass* pass = &r->effects;
    GLuint from = r->target.depths;
    gl->UseProgram(pass->window);
    for (int i = 0; i < 4; ++i) {
        GLuint to = pass->planes[i & 1];
        gl->BindTextureUnit(UNIT_FROM, from);
        gl->Uniform1i(0, i == 0 ? (GLint)(r->eye * r->target.height) : 0);
        gl->Uniform4i(1, axes[i][0], axes[i][1], reach, i < 2 ? 1 : 0);
        run(r, pass->window, to, GL_R32F, pass->width, pass->height);
        from = to;
    }
    return from;
}

static void find_blocks(stp_gl_renderer* r)
{
    stp_gl_effect_pass* pass = &r->effects;
    r->gl.UseProgram(pass->blocks);
    r->gl.BindTextureUnit(UNIT_FROM, r->target.depths);
    r->gl.Uniform1i(0, (GLint)(r->eye * r->target.height));
    run(r, pass->blocks, pass->block_plane, GL_R32F,
        (pass->width + EFFECT_BLOCK - 1) / EFFECT_BLOCK,
        (pass->height + EFFECT_BLOCK - 1) / EFFECT_BLOCK);
}

/// A pass that reads pixel nearness and a plane.
static void run_on(stp_gl_renderer* r, GLuint program, GLuint from, GLuint to, GLint near_row)
{
    r->gl.UseProgram(program);
    r->gl.Uniform1i(0, near_row);
    r->gl.BindTextureUnit(UNIT_FROM, from);
    run(r, program, to, GL_RG32F, r->effects.width, r->effects.height);
}

stp_result stp_gl_effect_pass_draw(stp_gl_renderer* r)
{
    const stp_gl* gl = &r->gl;
    stp_gl_effect_pass* pass = &r->effects;
    float size = r->list->mixes ? stp_max(r->list->splat_size, 1.0f) : 0.0f;
    stp_effect_shape shape = stp_effect_shape_make(r->style, r->target.height, size);
    if (!(shape.light > 0.0f) && shape.pair_count == 0) {
        return STP_OK;
    }
    stp_result result = make_programs(r);
    result = result == STP_OK ? make_planes(r) : result;
    if (result != STP_OK) {
        return result;
    }
    send_numbers(r, &shape);
    GLint row = (GLint)(r->eye * r->target.height);
    GLuint near = r->target.depths;
    if (shape.far) {
        find_blocks(r);
    }
    if (shape.close > 0) {
        near = close_gaps(r, shape.close);
        row = 0;
    }
    gl->BindTextureUnit(UNIT_NEARNESS, near);
    gl->BindTextureUnit(UNIT_BLOCKS, pass->block_plane);
    run_on(r, pass->shades, near, pass->two[0], row);
    if (shape.pair_count > 0) {
        run_on(r, pass->blur, pass->two[0], pass->two[1], row);
    }
    gl->BindTextureUnit(UNIT_BLOCKS, r->target.depths);
    gl->BindImageTexture(IMAGE_PICTURE, r->target.picture, 0, GL_FALSE, 0, GL_READ_WRITE, GL_RGBA8);
    run_on(r, pass->darken, pass->two[shape.pair_count > 0 ? 1 : 0], pass->two[0], row);
    gl->MemoryBarrier(GL_TEXTURE_UPDATE_BARRIER_BIT);
    return STP_OK;
}
