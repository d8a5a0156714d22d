// SPDX-License-Identifier: MIT
#include "base/core/context.h"
#include "draw/gl/gl_passes.h"
#include "draw/gl/gl_renderer.h"
#include "raster/splats_blend.h"

#include <assert.h>
#include <stdio.h>

bool stp_gl_filter_is_tolerant(const stp_gl_renderer* r)
{
    return r->style->filter == STP_FILTER_BLEND || r->style->filter == STP_FILTER_TEXTURED;
}

static stp_result make_two_pass_programs(stp_gl_renderer* r)
{
    stp_gl_filter_pass* pass = &r->filter;
    stp_context* context = r->base.context;
    char defines[256];
    stp_gl_page_defines(r, "", defines, sizeof(defines));
    stp_result result = STP_OK;
    if (pass->planes_program == 0) {
        result = stp_gl_program_create_compute(context, &r->gl, "planes.comp.glsl", defines,
                                               &pass->planes_program);
    }
    if (result == STP_OK && pass->blend == 0) {
        result = stp_gl_program_create(context, &r->gl, "blend.vert.glsl", "blend.frag.glsl",
                                       defines, &pass->blend);
    }
    return result;
}

static stp_result make_one_pass_programs(stp_gl_renderer* r)
{
    stp_gl_filter_pass* pass = &r->filter;
    stp_context* context = r->base.context;
    char more[96], defines[256];
    bool ordered = stp_gl_has(&r->gl, "GL_ARB_fragment_shader_interlock");
    bool textured = r->style->filter == STP_FILTER_TEXTURED;
    GLuint* program = textured ? &pass->textured : &pass->tolerant;
    snprintf(more, sizeof(more), "#define LEAVES\n%s%s", ordered ? "#define INTERLOCK\n" : "",
             textured ? "#define TEXTURED\n" : "");
    stp_gl_page_defines(r, more, defines, sizeof(defines));
    stp_result result = STP_OK;
    if (*program == 0) {
        result = stp_gl_program_create(context, &r->gl, "blend.vert.glsl", "tolerant.frag.glsl",
                                       defines, program);
    }
    if (result == STP_OK && pass->tolerant_merge == 0) {
        result = stp_gl_program_create(context, &r->gl, "screen.vert.glsl",
                                       "tolerant_merge.frag.glsl", "", &pass->tolerant_merge);
    }
    return result;
}

static void destroy_targets(stp_gl_renderer* r)
{
    stp_gl_filter_pass* pass = &r->filter;
    const GLuint textures[] = {pass->planes, pass->sums};
    r->gl.DeleteFramebuffers(1, &pass->framebuffer);
    r->gl.DeleteFramebuffers(1, &pass->merged);
    r->gl.DeleteTextures(2, textures);
    r->gl.DeleteBuffers(1, &pass->pixels);
    pass->framebuffer = pass->planes = pass->sums = pass->pixels = pass->merged = pass->ids = 0;
    pass->width = pass->height = 0;
    pass->bytes = 0;
}

void stp_gl_filter_pass_destroy(stp_gl_renderer* r)
{
    stp_gl_filter_pass* pass = &r->filter;
    destroy_targets(r);
    r->gl.DeleteProgram(pass->planes_program);
    r->gl.DeleteProgram(pass->blend);
    r->gl.DeleteProgram(pass->tolerant);
    r->gl.DeleteProgram(pass->textured);
    r->gl.DeleteTextures(1, &pass->splat_texture);
    r->gl.DeleteProgram(pass->tolerant_merge);
    r->gl.DeleteVertexArrays(1, &pass->vertex_array);
    *pass = (stp_gl_filter_pass){0};
}

static stp_result fail(stp_gl_renderer* r)
{
    destroy_targets(r);
    return stp_fail(r->base.context, STP_ERROR_OUT_OF_MEMORY,
                    "gl: not enough graphics memory to blend pictures of %ux%u", r->target.width,
                    r->target.height);
}

static GLuint make_texture(stp_gl_renderer* r, const char* label)
{
    const stp_gl* gl = &r->gl;
    GLuint texture;
    gl->CreateTextures(GL_TEXTURE_2D, 1, &texture);
    gl->TextureStorage2D(texture, 1, GL_RGBA32F, (GLsizei)r->target.width,
                         (GLsizei)r->target.height);
    gl->TextureParameteri(texture, GL_TEXTURE_MIN_FILTER, GL_NEAREST);
    gl->TextureParameteri(texture, GL_TEXTURE_MAG_FILTER, GL_NEAREST);
    gl->ObjectLabel(GL_TEXTURE, texture, -1, label);
    return texture;
}

/// Textures of the picture's size; `pixels`: also those for blending in one pass.
static stp_result make_targets(stp_gl_renderer* r, bool pixels)
{
    stp_gl_filter_pass* pass = &r->filter;
    const stp_gl* gl = &r->gl;
    const stp_gl_target* t = &r->target;
    while (gl->GetError() != GL_NO_ERROR) { // discard errors of earlier calls
    }
    if (pass->vertex_array == 0) {
        gl->CreateVertexArrays(1, &pass->vertex_array);
    }
    if (pass->ids != t->ids || pass->width != t->width || pass->height != t->height) {
        destroy_targets(r);
        pass->planes = make_texture(r, "planes");
        pass->sums = make_texture(r, "blended");
        gl->CreateFramebuffers(1, &pass->framebuffer);
        gl->NamedFramebufferTexture(pass->framebuffer, GL_COLOR_ATTACHMENT0, pass->sums, 0);
        const GLenum buffers[] = {GL_COLOR_ATTACHMENT0, GL_COLOR_ATTACHMENT1};
        gl->CreateFramebuffers(1, &pass->merged);
        gl->NamedFramebufferTexture(pass->merged, GL_COLOR_ATTACHMENT0, t->ids, 0);
        gl->NamedFramebufferTexture(pass->merged, GL_COLOR_ATTACHMENT1, pass->sums, 0);
        gl->NamedFramebufferTexture(pass->merged, GL_DEPTH_ATTACHMENT, t->nearness, 0);
        gl->NamedFramebufferDrawBuffers(pass->merged, 2, buffers);
        pass->ids = t->ids;
        pass->width = t->width;
        pass->height = t->height;
    }
    if (pixels && pass->pixels == 0) {
        uint64_t needed = (uint64_t)t->width * t->height * sizeof(tolerant_pixel);
        GLint64 maximum = 0;
        gl->GetInteger64v(GL_MAX_SHADER_STORAGE_BLOCK_SIZE, &maximum);
        if ((int64_t)needed > maximum) {
            return fail(r);
        }
        gl->CreateBuffers(1, &pass->pixels);
        gl->NamedBufferStorage(pass->pixels, (GLsizeiptr)needed, NULL, 0);
        gl->ObjectLabel(GL_BUFFER, pass->pixels, -1, "tolerant pixels");
        pass->bytes = needed;
    }
    return gl->GetError() != GL_NO_ERROR ? fail(r) : STP_OK;
}

static void find_planes(stp_gl_renderer* r)
{
    const stp_gl* gl = &r->gl;
    const stp_gl_target* t = &r->target;
    gl->BindTextureUnit(UNIT_IDS, t->ids);
    gl->BindTextureUnit(UNIT_NEARNESS, t->nearness);
    gl->BindImageTexture(IMAGE_PLANES, r->filter.planes, 0, GL_FALSE, 0, GL_WRITE_ONLY, GL_RGBA32F);
    stp_gl_dispatch_pixels(r, r->filter.planes_program, t->width, t->height);
    gl->MemoryBarrier(GL_TEXTURE_FETCH_BARRIER_BIT);
}

stp_result stp_gl_filter_pass_blend(stp_gl_renderer* r)
{
    assert(r->style->filter == STP_FILTER_EWA);
    const stp_gl* gl = &r->gl;
    stp_gl_filter_pass* pass = &r->filter;
    const GLfloat none[4] = {0};
    stp_gl_splat_source source;
    stp_result result = make_targets(r, false);
    result = result == STP_OK ? make_two_pass_programs(r) : result;
    if (result != STP_OK) {
        return result;
    }
    gl->ClearNamedFramebufferfv(pass->framebuffer, GL_COLOR, 0, none);
    if (!stp_gl_splat_source_find(r, &source)) {
        return STP_OK;
    }
    find_planes(r);
    gl->BindTextureUnit(UNIT_PLANES, pass->planes);
    gl->BindFramebuffer(GL_FRAMEBUFFER, pass->framebuffer);
    gl->Disable(GL_DEPTH_TEST);
    gl->Enable(GL_BLEND);
    gl->BlendEquation(GL_FUNC_ADD);
    gl->BlendFunc(GL_ONE, GL_ONE);
    result = stp_gl_splat_pass_points(r, &source, pass->blend);
    stp_gl_set_visible_state(r);
    return result;
}

/// The style's texture, which may change between pictures, and the weight of one-pixel splats.
static void send_texture(stp_gl_renderer* r)
{
    const stp_gl* gl = &r->gl;
    GLuint* texture = &r->filter.splat_texture;
    const GLsizei side = STP_SPLAT_TEXTURE_SIDE;
    stp_splat_texture made =
        r->style->splat_texture != NULL ? *r->style->splat_texture : stp_splat_texture_gaussian();
    if (*texture == 0) {
        gl->CreateTextures(GL_TEXTURE_2D, 1, texture);
        gl->TextureStorage2D(*texture, 1, GL_R8, side, side);
        gl->TextureParameteri(*texture, GL_TEXTURE_MIN_FILTER, GL_LINEAR);
        gl->TextureParameteri(*texture, GL_TEXTURE_MAG_FILTER, GL_LINEAR);
        gl->TextureParameteri(*texture, GL_TEXTURE_WRAP_S, GL_CLAMP_TO_EDGE);
        gl->TextureParameteri(*texture, GL_TEXTURE_WRAP_T, GL_CLAMP_TO_EDGE);
        gl->ObjectLabel(GL_TEXTURE, *texture, -1, "splat texture");
    }
    gl->TextureSubImage2D(*texture, 0, 0, 0, side, side, GL_RED, GL_UNSIGNED_BYTE, made.texels);
    gl->BindTextureUnit(UNIT_SPLAT_TEXTURE, *texture);
    float opacity = stp_splat_texture_mean(&made);
    gl->UseProgram(r->filter.textured);
    gl->Uniform1ui(0, 1 + (GLuint)((float)(STP_BLEND_WEIGHT - 1) * opacity));
}

/// Copies the buffer's pixels to where shading and other passes read them.
static void merge_tolerant(stp_gl_renderer* r)
{
    const stp_gl* gl = &r->gl;
    stp_gl_filter_pass* pass = &r->filter;
    gl->MemoryBarrier(GL_SHADER_STORAGE_BARRIER_BIT);
    gl->BindFramebuffer(GL_FRAMEBUFFER, pass->merged);
    gl->Viewport(0, 0, (GLsizei)r->target.width, (GLsizei)r->target.height);
    gl->BindVertexArray(pass->vertex_array);
    gl->UseProgram(pass->tolerant_merge);
    gl->DrawArrays(GL_TRIANGLES, 0, 3);
    r->draw_calls += 1;
    stp_gl_set_visible_state(r);
}

stp_result stp_gl_filter_pass_draw_tolerant(stp_gl_renderer* r)
{
    assert(stp_gl_filter_is_tolerant(r));
    const stp_gl* gl = &r->gl;
    stp_gl_filter_pass* pass = &r->filter;
    const GLuint zero = 0;
    const GLfloat none[4] = {0};
    stp_gl_splat_source source;
    stp_result result = make_targets(r, true);
    result = result == STP_OK ? make_one_pass_programs(r) : result;
    if (result != STP_OK) {
        return result;
    }
    assert(pass->bytes == (uint64_t)pass->width * pass->height * sizeof(tolerant_pixel));
    gl->ClearNamedBufferSubData(pass->pixels, GL_R32UI, 0, (GLsizeiptr)pass->bytes, GL_RED_INTEGER,
                                GL_UNSIGNED_INT, &zero);
    gl->ClearNamedFramebufferfv(pass->framebuffer, GL_COLOR, 0, none);
    bool textured = r->style->filter == STP_FILTER_TEXTURED;
    if (textured) {
        send_texture(r);
    }
    if (stp_gl_splat_source_find(r, &source)) {
        gl->BindTextureUnit(UNIT_NEARNESS, r->target.nearness);
        gl->BindFramebuffer(GL_FRAMEBUFFER, pass->framebuffer);
        gl->Disable(GL_DEPTH_TEST);
        gl->ColorMask(GL_FALSE, GL_FALSE, GL_FALSE, GL_FALSE); // the shader has no outputs
        gl->BindBufferBase(GL_SHADER_STORAGE_BUFFER, BINDING_RASTER_PIXELS, pass->pixels);
        stp_gl_splat_pass_begin(r);
        stp_gl_timer_begin_count(gl, &r->timer, GL_COUNTED_POINTS);
        result = stp_gl_splat_pass_points(r, &source, textured ? pass->textured : pass->tolerant);
        stp_gl_timer_end_count(gl, &r->timer);
        stp_gl_set_visible_state(r);
        if (result == STP_OK) {
            stp_gl_timer_begin_count(gl, &r->timer, GL_COUNTED_LARGE);
            stp_gl_splat_pass_large(r, r->splats.large);
            stp_gl_timer_end_count(gl, &r->timer);
            merge_tolerant(r);
        }
        stp_gl_bind_frame(r);
    }
    return result;
}

void stp_gl_filter_pass_bind(stp_gl_renderer* r)
{
    if (r->style->filter != STP_FILTER_NONE) {
        r->gl.BindTextureUnit(UNIT_BLENDED, r->filter.sums);
    }
}
