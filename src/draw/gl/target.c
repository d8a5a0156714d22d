// SPDX-License-Identifier: MIT
// What pictures are drawn into.
#include "base/context.h"
#include "draw/gl/renderer.h"

static GLuint make_texture(const stp_gl* gl, GLenum format, uint32_t width, uint32_t height,
                           const char* label)
{
    GLuint texture;
    gl->CreateTextures(GL_TEXTURE_2D, 1, &texture);
    gl->TextureStorage2D(texture, 1, format, (GLsizei)width, (GLsizei)height);
    gl->TextureParameteri(texture, GL_TEXTURE_MIN_FILTER, GL_NEAREST);
    gl->TextureParameteri(texture, GL_TEXTURE_MAG_FILTER, GL_NEAREST);
    gl->ObjectLabel(GL_TEXTURE, texture, -1, label);
    return texture;
}

void gl_target_destroy(gl_renderer* r)
{
    gl_target* t = &r->target;
    const GLuint textures[] = {t->ids, t->nearness, t->picture, t->depths, t->sums};
    r->gl.DeleteFramebuffers(1, &t->framebuffer);
    r->gl.DeleteTextures(5, textures);
    *t = (gl_target){0};
}

static stp_result fail(gl_renderer* r, uint32_t width, uint32_t height)
{
    gl_target_destroy(r);
    return stp_fail(r->base.context, STP_ERROR_OUT_OF_MEMORY,
                    "gl: there is no graphics memory for a picture of %ux%u", width, height);
}

stp_result gl_target_make(gl_renderer* r, uint32_t width, uint32_t height, bool sums)
{
    const stp_gl* gl = &r->gl;
    gl_target* t = &r->target;
    GLint most = 0;
    gl->GetIntegerv(GL_MAX_TEXTURE_SIZE, &most);
    if (width > (uint32_t)most || height > (uint32_t)most) {
        return stp_fail(r->base.context, STP_ERROR_LIMIT,
                        "gl: pictures of this device have at most %dx%d pixels, not %ux%u", most,
                        most, width, height);
    }
    while (gl->GetError() != GL_NO_ERROR) { // what was before is not the target's
    }
    if (t->width != width || t->height != height) {
        gl_target_destroy(r);
        t->ids = make_texture(gl, GL_R32UI, width, height, "ids");
        t->nearness = make_texture(gl, GL_DEPTH_COMPONENT32F, width, height, "nearness");
        t->picture = make_texture(gl, GL_RGBA8, width, height, "picture");
        t->depths = make_texture(gl, GL_R32F, width, height, "depths");
        gl->CreateFramebuffers(1, &t->framebuffer);
        gl->NamedFramebufferTexture(t->framebuffer, GL_COLOR_ATTACHMENT0, t->ids, 0);
        gl->NamedFramebufferTexture(t->framebuffer, GL_DEPTH_ATTACHMENT, t->nearness, 0);
        gl->NamedFramebufferDrawBuffer(t->framebuffer, GL_COLOR_ATTACHMENT0);
        GLenum status = gl->CheckNamedFramebufferStatus(t->framebuffer, GL_DRAW_FRAMEBUFFER);
        if (gl->GetError() != GL_NO_ERROR || status != GL_FRAMEBUFFER_COMPLETE) {
            return fail(r, width, height);
        }
        t->width = width;
        t->height = height;
    }
    if (sums && t->sums == 0) {
        t->sums = make_texture(gl, GL_RGBA32F, width, height, "sums");
        if (gl->GetError() != GL_NO_ERROR) {
            return fail(r, width, height);
        }
    }
    return STP_OK;
}
