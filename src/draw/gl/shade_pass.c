// SPDX-License-Identifier: MIT
// Shades the visibility buffer into the picture.
#include "base/core/context.h"
#include "draw/gl/gl_renderer.h"

#include <assert.h>

stp_result stp_gl_shade_pass_create(stp_gl_renderer* r)
{
    stp_gl_shade_pass* pass = &r->shade;
    stp_context* context = r->base.context;
    char defines[256];
    *pass = (stp_gl_shade_pass){0};
    r->gl.CreateBuffers(1, &pass->counters);
    r->gl.NamedBufferStorage(pass->counters, GL_COUNTERS * sizeof(uint32_t), NULL,
                             GL_DYNAMIC_STORAGE_BIT);
    r->gl.ObjectLabel(GL_BUFFER, pass->counters, -1, "counters");
    r->gl.CreateBuffers(1, &pass->copied);
    r->gl.NamedBufferStorage(pass->copied, GL_COUNTERS * sizeof(uint32_t), NULL,
                             GL_CLIENT_STORAGE_BIT);
    return stp_gl_program_create_compute(context, &r->gl, "shade.comp.glsl",
                                         stp_gl_page_defines(r, "", defines, sizeof(defines)),
                                         &pass->shade);
}

/// A program that few pictures use.
static stp_result need(stp_gl_renderer* r, GLuint* program, const char* name, const char* defines)
{
    return *program != 0
               ? STP_OK
               : stp_gl_program_create_compute(r->base.context, &r->gl, name, defines, program);
}

void stp_gl_shade_pass_destroy(stp_gl_renderer* r)
{
    stp_gl_shade_pass* pass = &r->shade;
    r->gl.DeleteProgram(pass->shade);
    r->gl.DeleteProgram(pass->kinds);
    r->gl.DeleteProgram(pass->sums);
    r->gl.DeleteProgram(pass->average);
    r->gl.DeleteProgram(pass->add);
    r->gl.DeleteBuffers(1, &pass->counters);
    r->gl.DeleteBuffers(1, &pass->copied);
    *pass = (stp_gl_shade_pass){0};
}

static void bind_pictures(stp_gl_renderer* r, bool sums)
{
    const stp_gl_target* t = &r->target;
    r->gl.BindBufferBase(GL_SHADER_STORAGE_BUFFER, BINDING_COUNTERS, r->shade.counters);
    r->gl.BindImageTexture(IMAGE_PICTURE, t->picture, 0, GL_FALSE, 0, GL_WRITE_ONLY, GL_RGBA8);
    r->gl.BindImageTexture(IMAGE_DEPTH, t->depths, 0, GL_FALSE, 0, GL_WRITE_ONLY, GL_R32F);
    if (sums) {
        r->gl.BindImageTexture(IMAGE_SUMS, t->sums, 0, GL_FALSE, 0, GL_READ_WRITE, GL_RGBA32F);
    }
}

static void finish(stp_gl_renderer* r)
{
    r->gl.MemoryBarrier(GL_SHADER_IMAGE_ACCESS_BARRIER_BIT | GL_TEXTURE_FETCH_BARRIER_BIT |
                        GL_TEXTURE_UPDATE_BARRIER_BIT | GL_BUFFER_UPDATE_BARRIER_BIT);
}

stp_result stp_gl_shade_pass_draw(stp_gl_renderer* r, bool sums, bool kinds)
{
    assert((!sums || r->target.sums != 0) && "the target is made for sums");
    assert(!(sums && kinds) && "sums are not filtered");
    char defines[256];
    GLuint* program = sums ? &r->shade.sums : kinds ? &r->shade.kinds : &r->shade.shade;
    const char* define = sums ? "#define SUMS\n" : kinds ? "#define KINDS\n" : "";
    stp_result result = need(r, program, "shade.comp.glsl",
                             stp_gl_page_defines(r, define, defines, sizeof(defines)));
    if (result != STP_OK) {
        return result;
    }
    if (kinds) {
        r->gl.BindImageTexture(IMAGE_KINDS, r->pixel_filter.kinds, 0, GL_FALSE, 0, GL_WRITE_ONLY,
                               GL_R8UI);
    }
    bind_pictures(r, sums);
    r->gl.BindTextureUnit(UNIT_IDS, r->target.ids);
    r->gl.BindTextureUnit(UNIT_NEARNESS, r->target.nearness);
    stp_gl_filter_pass_bind(r);
    stp_gl_dispatch_pixels(r, *program, r->target.width, r->target.height);
    finish(r);
    return STP_OK;
}

stp_result stp_gl_shade_pass_add(stp_gl_renderer* r)
{
    assert(r->target.sums != 0);
    stp_result result = need(r, &r->shade.add, "add.comp.glsl", NULL);
    if (result == STP_OK) {
        bind_pictures(r, true);
        r->gl.BindImageTexture(IMAGE_PICTURE, r->target.picture, 0, GL_FALSE, 0, GL_READ_ONLY,
                               GL_RGBA8);
        stp_gl_dispatch_pixels(r, r->shade.add, r->target.width, r->target.height);
        finish(r);
    }
    return result;
}

stp_result stp_gl_shade_pass_average(stp_gl_renderer* r)
{
    assert(r->target.sums != 0);
    stp_result result = need(r, &r->shade.average, "average.comp.glsl", NULL);
    if (result == STP_OK) {
        bind_pictures(r, true);
        stp_gl_dispatch_pixels(r, r->shade.average, r->target.width, r->target.height);
        finish(r);
    }
    return result;
}

void stp_gl_shade_pass_clear(stp_gl_renderer* r)
{
    const uint32_t none[GL_COUNTERS] = {0};
    r->gl.NamedBufferSubData(r->shade.counters, 0, sizeof(none), none);
}

void stp_gl_shade_pass_clear_counter(stp_gl_renderer* r, stp_gl_counter counter)
{
    const uint32_t none = 0;
    GLintptr at = (GLintptr)counter * (GLintptr)sizeof(none);
    r->gl.NamedBufferSubData(r->shade.counters, at, sizeof(none), &none);
}

uint32_t stp_gl_shade_pass_read(stp_gl_renderer* r, stp_gl_counter counter)
{
    assert(counter < GL_COUNTERS);
    const stp_gl* gl = &r->gl;
    GLintptr at = (GLintptr)counter * (GLintptr)sizeof(uint32_t);
    uint32_t value = 0;
    gl->CopyNamedBufferSubData(r->shade.counters, r->shade.copied, at, at, sizeof(value));
    gl->GetNamedBufferSubData(r->shade.copied, at, sizeof(value), &value);
    return value;
}
