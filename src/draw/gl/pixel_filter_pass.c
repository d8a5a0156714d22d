// SPDX-License-Identifier: MIT
// The pixel filter (draw/cpu/pixel_filter.h), as a compute pass over a copy of the picture.
#include "base/core/context.h"
#include "draw/gl/gl_passes.h"
#include "draw/gl/gl_renderer.h"

#include <assert.h>

void stp_gl_pixel_filter_pass_destroy(stp_gl_renderer* r)
{
    stp_gl_pixel_filter_pass* pass = &r->pixel_filter;
    const GLuint textures[] = {pass->kinds, pass->copy};
    r->gl.DeleteProgram(pass->program);
    r->gl.DeleteTextures(2, textures);
    *pass = (stp_gl_pixel_filter_pass){0};
}

/// Creates the program, unless it failed before.
static bool make_program(stp_gl_renderer* r)
{
    stp_gl_pixel_filter_pass* pass = &r->pixel_filter;
    return pass->program != 0 ||
           (!pass->warned &&
            stp_gl_program_create_compute(r->base.context, &r->gl, "pixel_filter.comp.glsl", NULL,
                                          &pass->program) == STP_OK);
}

static bool make_textures(stp_gl_renderer* r)
{
    const stp_gl* gl = &r->gl;
    const stp_gl_target* t = &r->target;
    stp_gl_pixel_filter_pass* pass = &r->pixel_filter;
    if (pass->full_width == t->full_width && pass->width == t->width && pass->height == t->height) {
        return true;
    }
    const GLuint old[] = {pass->kinds, pass->copy};
    gl->DeleteTextures(2, old);
    while (gl->GetError() != GL_NO_ERROR) { // discard errors of earlier calls
    }
    pass->kinds = stp_gl_make_texture(gl, GL_R8UI, t->width, t->height, "kinds of pixels");
    pass->copy = stp_gl_make_texture(gl, GL_RGBA8, t->full_width, t->height, "unfiltered picture");
    bool made = gl->GetError() == GL_NO_ERROR;
    pass->width = made ? t->width : 0;
    pass->height = t->height;
    pass->full_width = t->full_width;
    return made;
}

bool stp_gl_pixel_filter_pass_begin(stp_gl_renderer* r)
{
    stp_gl_pixel_filter_pass* pass = &r->pixel_filter;
    bool can = make_program(r) && make_textures(r);
    if (!can && !pass->warned) {
        pass->warned = true;
        stp_warn(
            r->base.context,
            "gl: the program or the graphics memory to filter a picture of %ux%u is missing: it "
            "is not filtered",
            r->target.full_width, r->target.height);
    }
    return can;
}

void stp_gl_pixel_filter_pass_draw(stp_gl_renderer* r)
{
    const stp_gl* gl = &r->gl;
    const stp_gl_target* t = &r->target;
    GLint x = (GLint)(r->eye * t->width);
    assert(r->pixel_filter.program != 0 && "begun before shading");
    gl->MemoryBarrier(GL_TEXTURE_UPDATE_BARRIER_BIT | GL_TEXTURE_FETCH_BARRIER_BIT);
    gl->CopyImageSubData(t->picture, GL_TEXTURE_2D, 0, x, 0, 0, r->pixel_filter.copy, GL_TEXTURE_2D,
                         0, x, 0, 0, (GLsizei)t->width, (GLsizei)t->height, 1);
    gl->BindTextureUnit(UNIT_FROM, r->pixel_filter.copy);
    gl->BindTextureUnit(UNIT_BLOCKS, r->pixel_filter.kinds);
    gl->BindImageTexture(IMAGE_PICTURE, t->picture, 0, GL_FALSE, 0, GL_WRITE_ONLY, GL_RGBA8);
    stp_gl_dispatch_pixels(r, r->pixel_filter.program, t->width, t->height);
    gl->MemoryBarrier(GL_SHADER_IMAGE_ACCESS_BARRIER_BIT | GL_TEXTURE_FETCH_BARRIER_BIT |
                      GL_TEXTURE_UPDATE_BARRIER_BIT);
}
