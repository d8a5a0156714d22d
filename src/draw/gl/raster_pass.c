// SPDX-License-Identifier: MIT
#include "draw/gl/raster_pass.h"

#include "base/core/context.h"
#include "draw/gl/gl_renderer.h"

#include <assert.h>

enum { GROUPS_ACROSS = 32768 };

uint64_t stp_gl_raster_groups(uint64_t splats)
{
    return (splats + RASTER_GROUP - 1) / RASTER_GROUP;
}

stp_result stp_gl_raster_pass_create(stp_gl_renderer* r)
{
    stp_gl_raster_pass* pass = &r->raster;
    stp_context* context = r->base.context;
    char defines[256];
    *pass = (stp_gl_raster_pass){0};
    r->gl.CreateVertexArrays(1, &pass->vertex_array);
    stp_result result = stp_gl_program_create_compute(
        context, &r->gl, "raster.comp.glsl", stp_gl_page_defines(r, "", defines, sizeof(defines)),
        &pass->program);
    if (result == STP_OK) {
        result = stp_gl_program_create(context, &r->gl, "screen.vert.glsl", "merge.frag.glsl", "",
                                       &pass->merge);
    }
    return result;
}

void stp_gl_raster_pass_destroy(stp_gl_renderer* r)
{
    stp_gl_raster_pass* pass = &r->raster;
    const stp_gl* gl = &r->gl;
    gl->DeleteProgram(pass->program);
    gl->DeleteProgram(pass->merge);
    gl->DeleteVertexArrays(1, &pass->vertex_array);
    gl->DeleteBuffers(1, &pass->pixels);
    *pass = (stp_gl_raster_pass){0};
}

static stp_result make_pixels(stp_gl_renderer* r)
{
    stp_gl_raster_pass* pass = &r->raster;
    const stp_gl* gl = &r->gl;
    uint64_t needed = (uint64_t)r->target.width * r->target.height * sizeof(uint64_t);
    GLint64 maximum = 0;
    if (needed <= pass->bytes) {
        return STP_OK;
    }
    gl->DeleteBuffers(1, &pass->pixels);
    pass->pixels = 0;
    pass->bytes = 0;
    gl->GetInteger64v(GL_MAX_SHADER_STORAGE_BLOCK_SIZE, &maximum);
    while (gl->GetError() != GL_NO_ERROR) { // discard errors of earlier calls
    }
    if ((int64_t)needed <= maximum) {
        gl->CreateBuffers(1, &pass->pixels);
        gl->NamedBufferStorage(pass->pixels, (GLsizeiptr)needed, NULL, 0);
    }
    if (pass->pixels == 0 || gl->GetError() != GL_NO_ERROR) {
        return stp_fail(r->base.context, STP_ERROR_OUT_OF_MEMORY,
                        "gl: not enough graphics memory for a visibility buffer of %ux%u",
                        r->target.width, r->target.height);
    }
    gl->ObjectLabel(GL_BUFFER, pass->pixels, -1, "raster pixels");
    pass->bytes = needed;
    return STP_OK;
}

static void clear(const stp_gl_renderer* r)
{
    const stp_gl* gl = &r->gl;
    const GLuint ones = UINT32_MAX, zero = 0;
    GLsizeiptr half = (GLsizeiptr)r->target.width * (GLsizeiptr)r->target.height * 4;
    gl->ClearNamedBufferSubData(r->raster.pixels, GL_R32UI, 0, half, GL_RED_INTEGER,
                                GL_UNSIGNED_INT, &zero);
    gl->ClearNamedBufferSubData(r->raster.pixels, GL_R32UI, half, half, GL_RED_INTEGER,
                                GL_UNSIGNED_INT, &ones);
}

static void bind(const stp_gl_renderer* r, const stp_gl_splat_source* source)
{
    const stp_gl* gl = &r->gl;
    GLsizeiptr count = source->count;
    gl->BindBufferBase(GL_SHADER_STORAGE_BUFFER, BINDING_RASTER_PIXELS, r->raster.pixels);
    gl->BindBufferBase(GL_SHADER_STORAGE_BUFFER, BINDING_COUNTERS, r->shade.counters);
    gl->BindBufferRange(GL_SHADER_STORAGE_BUFFER, BINDING_RASTER_COMMANDS, source->buffer,
                        source->offset, count * (GLsizeiptr)sizeof(struct stp_gl_command));
    gl->BindBufferRange(GL_SHADER_STORAGE_BUFFER, BINDING_RASTER_GROUPS, source->buffer,
                        source->groups_offset, count * (GLsizeiptr)sizeof(uint32_t));
}

static void dispatch(stp_gl_renderer* r, uint64_t groups)
{
    uint64_t rows = (groups + GROUPS_ACROSS - 1) / GROUPS_ACROSS;
    uint64_t across = groups < GROUPS_ACROSS ? groups : GROUPS_ACROSS;
    assert(rows <= 65535 && across * rows >= groups && "limits of a dispatch");
    r->gl.DispatchCompute((GLuint)across, (GLuint)rows, 1);
    r->dispatches += 1;
}

static void merge(stp_gl_renderer* r)
{
    const stp_gl* gl = &r->gl;
    const stp_gl_target* t = &r->target;
    gl->MemoryBarrier(GL_SHADER_STORAGE_BARRIER_BIT);
    gl->UseProgram(r->raster.merge);
    gl->BindVertexArray(r->raster.vertex_array);
    gl->Viewport(0, 0, (GLsizei)t->width, (GLsizei)t->height);
    gl->DrawArrays(GL_TRIANGLES, 0, 3);
    r->draw_calls += 1;
}

stp_result stp_gl_raster_pass_draw(stp_gl_renderer* r, const stp_gl_splat_source* source)
{
    const stp_gl* gl = &r->gl;
    const stp_gl_raster_pass* pass = &r->raster;
    assert(source->count > 0 && source->groups <= (uint64_t)GROUPS_ACROSS * 65535);
    stp_result result = make_pixels(r);
    if (result != STP_OK) {
        return result;
    }
    clear(r);
    bind(r, source);
    gl->UseProgram(pass->program);
    gl->Uniform1ui(0, source->count);
    for (GLuint stage = 0; stage < 2; ++stage) {
        gl->Uniform1ui(1, stage);
        dispatch(r, source->groups);
        gl->MemoryBarrier(GL_SHADER_STORAGE_BARRIER_BIT);
    }
    merge(r);
    return STP_OK;
}
