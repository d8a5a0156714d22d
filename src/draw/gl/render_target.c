// SPDX-License-Identifier: MIT
// Render targets.
#include "base/core/context.h"
#include "draw/gl/gl_renderer.h"
#include "select/eyes.h"

#include <assert.h>

void stp_gl_dispatch_pixels(stp_gl_renderer* r, GLuint program, uint32_t width, uint32_t height)
{
    r->gl.UseProgram(program);
    r->gl.DispatchCompute((width + GROUP_SIDE - 1) / GROUP_SIDE,
                          (height + GROUP_SIDE - 1) / GROUP_SIDE, 1);
    r->dispatches += 1;
}

GLuint stp_gl_make_texture(const stp_gl* gl, GLenum format, uint32_t width, uint32_t height,
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

void stp_gl_read_texture(const stp_gl* gl, GLuint texture, GLenum format, GLenum type,
                         uint32_t width, uint32_t height, uint64_t band_bytes, void* pixels)
{
    assert(width > 0 && band_bytes <= INT32_MAX && "sizes per call have 31 bits");
    uint64_t row_bytes = UINT64_C(4) * width;
    uint32_t rows = row_bytes < band_bytes ? (uint32_t)(band_bytes / row_bytes) : 1;
    gl->BindBuffer(GL_PIXEL_PACK_BUFFER, 0);
    gl->PixelStorei(GL_PACK_ALIGNMENT, 4);
    for (uint32_t y = 0; y < height; y += rows) {
        uint32_t left = height - y, band = rows < left ? rows : left;
        gl->GetTextureSubImage(texture, 0, 0, (GLint)y, 0, (GLsizei)width, (GLsizei)band, 1, format,
                               type, (GLsizei)(band * row_bytes),
                               (unsigned char*)pixels + y * row_bytes);
    }
}

void stp_gl_target_destroy(stp_gl_renderer* r)
{
    stp_gl_target* t = &r->target;
    const GLuint textures[] = {t->ids, t->nearness, t->picture, t->depths, t->sums};
    r->gl.DeleteFramebuffers(1, &t->framebuffer);
    r->gl.DeleteTextures(5, textures);
    *t = (stp_gl_target){0};
}

static stp_result fail(stp_gl_renderer* r, uint32_t width, uint32_t height)
{
    stp_gl_target_destroy(r);
    return stp_fail(r->base.context, STP_ERROR_OUT_OF_MEMORY,
                    "gl: not enough graphics memory for a picture of %ux%u", width, height);
}

static void make_textures(stp_gl_renderer* r)
{
    const stp_gl* gl = &r->gl;
    stp_gl_target* t = &r->target;
    t->ids = stp_gl_make_texture(gl, GL_R32UI, t->width, t->height, "ids");
    t->nearness = stp_gl_make_texture(gl, GL_DEPTH_COMPONENT32F, t->width, t->height, "nearness");
    t->picture = stp_gl_make_texture(gl, GL_RGBA8, t->full_width, t->height, "picture");
    t->depths = stp_gl_make_texture(gl, GL_R32F, t->width, t->height * t->eye_count, "depths");
    gl->CreateFramebuffers(1, &t->framebuffer);
    gl->NamedFramebufferTexture(t->framebuffer, GL_COLOR_ATTACHMENT0, t->ids, 0);
    gl->NamedFramebufferTexture(t->framebuffer, GL_DEPTH_ATTACHMENT, t->nearness, 0);
    gl->NamedFramebufferDrawBuffer(t->framebuffer, GL_COLOR_ATTACHMENT0);
    if (t->full_width != t->width * t->eye_count) {
        gl->ClearTexImage(t->picture, 0, GL_RGBA, GL_UNSIGNED_BYTE, NULL);
    }
}

stp_result stp_gl_target_make(stp_gl_renderer* r, const stp_view* view, bool sums)
{
    assert(view->width > 0 && view->height > 0 && "the view was checked");
    const stp_gl* gl = &r->gl;
    stp_gl_target* t = &r->target;
    stp_view one = stp_view_of_eye(view, 0);
    uint32_t eyes = stp_view_eye_count(view);
    GLint maximum = 0;
    gl->GetIntegerv(GL_MAX_TEXTURE_SIZE, &maximum);
    if (view->width > (uint32_t)maximum || (uint64_t)one.height * eyes > (uint64_t)maximum) {
        return stp_fail(r->base.context, STP_ERROR_LIMIT,
                        "gl: pictures of this device have at most %dx%d pixels, not %ux%u", maximum,
                        maximum, view->width, view->height);
    }
    while (gl->GetError() != GL_NO_ERROR) { // discard errors of earlier calls
    }
    if (t->full_width != view->width || t->height != one.height || t->eye_count != eyes) {
        stp_gl_target_destroy(r);
        *t = (stp_gl_target){
            .width = one.width, .height = one.height, .eye_count = eyes, .full_width = view->width};
        make_textures(r);
        GLenum status = gl->CheckNamedFramebufferStatus(t->framebuffer, GL_DRAW_FRAMEBUFFER);
        if (gl->GetError() != GL_NO_ERROR || status != GL_FRAMEBUFFER_COMPLETE) {
            return fail(r, view->width, view->height);
        }
    }
    if (sums && t->sums == 0) {
        t->sums = stp_gl_make_texture(gl, GL_RGBA32F, t->full_width, t->height, "sums");
        if (gl->GetError() != GL_NO_ERROR) {
            return fail(r, view->width, view->height);
        }
    }
    return STP_OK;
}
