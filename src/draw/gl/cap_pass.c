// SPDX-License-Identifier: MIT
#include "base/core/context.h"
#include "draw/gl/gl_passes.h"
#include "draw/gl/gl_renderer.h"

#include <assert.h>

void stp_gl_cap_pass_destroy(stp_gl_renderer* r)
{
    stp_gl_cap_pass* pass = &r->cap_pass;
    const GLuint textures[] = {pass->nearness, pass->pixels};
    stp_caps_destroy(pass->caps);
    r->gl.DeleteProgram(pass->program);
    r->gl.DeleteTextures(2, textures);
    *pass = (stp_gl_cap_pass){0};
}

static stp_result make_textures(stp_gl_renderer* r)
{
    const stp_gl* gl = &r->gl;
    stp_gl_cap_pass* pass = &r->cap_pass;
    const GLuint old[] = {pass->nearness, pass->pixels};
    uint32_t width = r->target.width, height = r->target.height;
    if (pass->width == width && pass->height == height) {
        return STP_OK;
    }
    gl->DeleteTextures(2, old);
    while (gl->GetError() != GL_NO_ERROR) { // discard errors of earlier calls
    }
    pass->nearness = stp_gl_make_texture(gl, GL_R32F, width, height, "nearness of caps");
    pass->pixels = stp_gl_make_texture(gl, GL_RGBA8, width, height, "caps");
    pass->width = width;
    pass->height = height;
    if (gl->GetError() != GL_NO_ERROR) {
        pass->width = 0;
        return stp_fail(r->base.context, STP_ERROR_OUT_OF_MEMORY,
                        "gl: not enough graphics memory for caps of a picture of %ux%u", width,
                        height);
    }
    return STP_OK;
}

static stp_result prepare(stp_gl_renderer* r)
{
    stp_gl_cap_pass* pass = &r->cap_pass;
    stp_result result = STP_OK;
    if (pass->caps == NULL) {
        result = stp_caps_create(r->base.context, r->store, &pass->caps);
    }
    if (result == STP_OK && pass->program == 0) {
        result = stp_gl_program_create_compute(r->base.context, &r->gl, "caps.comp.glsl", NULL,
                                               &pass->program);
    }
    return result == STP_OK ? make_textures(r) : result;
}

/// Uploads the caps, and draws them where they are nearest.
static void put(stp_gl_renderer* r, const stp_cap_picture* picture)
{
    const stp_gl* gl = &r->gl;
    const stp_gl_target* t = &r->target;
    const stp_gl_cap_pass* pass = &r->cap_pass;
    GLsizei width = (GLsizei)t->width, height = (GLsizei)t->height;
    assert(pass->width == t->width && pass->height == t->height && "one texel per pixel");
    gl->TextureSubImage2D(pass->nearness, 0, 0, 0, width, height, GL_RED, GL_FLOAT,
                          picture->nearness);
    gl->TextureSubImage2D(pass->pixels, 0, 0, 0, width, height, GL_RGBA, GL_UNSIGNED_BYTE,
                          picture->pixels);
    gl->BindTextureUnit(UNIT_NEARNESS, pass->nearness);
    gl->BindTextureUnit(UNIT_FROM, pass->pixels);
    gl->BindBufferBase(GL_SHADER_STORAGE_BUFFER, BINDING_COUNTERS, r->shade.counters);
    gl->BindImageTexture(IMAGE_PICTURE, t->picture, 0, GL_FALSE, 0, GL_WRITE_ONLY, GL_RGBA8);
    gl->BindImageTexture(IMAGE_DEPTH, t->depths, 0, GL_FALSE, 0, GL_READ_WRITE, GL_R32F);
    stp_gl_dispatch_pixels(r, pass->program, t->width, t->height);
    gl->MemoryBarrier(GL_SHADER_IMAGE_ACCESS_BARRIER_BIT | GL_TEXTURE_FETCH_BARRIER_BIT |
                      GL_TEXTURE_UPDATE_BARRIER_BIT | GL_BUFFER_UPDATE_BARRIER_BIT);
}

stp_result stp_gl_cap_pass_draw(stp_gl_renderer* r)
{
    r->cap_pass.shows = false;
    if (!r->style->caps || r->view->sections.count == 0) {
        return STP_OK;
    }
    const stp_placement* p = &r->placement;
    stp_view_frame frame = p->frame;
    stp_cap_depth depth = {p->nearness_scale, p->nearness_offset};
    stp_cap_picture picture = {0};
    frame.center_x += p->shift_x;
    frame.center_y += p->shift_y;
    stp_result result = prepare(r);
    if (result == STP_OK) {
        result = stp_caps_find(r->cap_pass.caps, &r->view->sections, r->visibility);
    }
    if (result == STP_OK) {
        result = stp_caps_fill(r->cap_pass.caps, &frame, r->style->headlight, &depth, &picture);
    }
    if (result == STP_OK && picture.any) {
        put(r, &picture);
        r->cap_pass.shows = true;
    }
    return result;
}
