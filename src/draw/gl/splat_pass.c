// SPDX-License-Identifier: MIT
// Splats: as points with one draw call, and those too large for points with another
// (shaders/splat.*, large.*).
#include "base/core/context.h"
#include "draw/gl/gl_renderer.h"

#include <assert.h>
#include <stddef.h>
#include <stdio.h>

const char* stp_gl_page_defines(const stp_gl_renderer* r, const char* more, char* text, size_t size)
{
    int length = snprintf(text, size, "#define PAGE_COUNT %u\n#define PAGE_SHIFT %u\n%s%s%s%s",
                          r->program_pages, r->pool.page_shift,
                          r->directory->texture_count > 0 ? "#define TEXTURES\n" : "",
                          r->layer_pass.of_splats ? "#define GLASS\n" : "",
                          r->program_squares ? "#define SQUARE\n" : "", more);
    assert(length >= 0 && (size_t)length < size && "no define is truncated");
    (void)length;
    return text;
}

const char* stp_gl_large_vertex_shader(const stp_gl_renderer* r)
{
    return r->program_squares ? "large_square.vert.glsl" : "large.vert.glsl";
}

const char* stp_gl_large_fragment_shader(const stp_gl_renderer* r)
{
    return r->program_squares ? "splat.frag.glsl" : "large.frag.glsl";
}

stp_result stp_gl_splat_pass_create(stp_gl_renderer* r)
{
    const stp_gl* gl = &r->gl;
    stp_gl_splat_pass* pass = &r->splats;
    char defines[256];
    stp_gl_page_defines(r, "", defines, sizeof(defines));
    *pass = (stp_gl_splat_pass){0};
    gl->CreateVertexArrays(1, &pass->vertex_array);
    gl->CreateBuffers(1, &pass->large_buffer);
    gl->NamedBufferStorage(pass->large_buffer, sizeof(large_block), NULL, GL_DYNAMIC_STORAGE_BIT);
    gl->ObjectLabel(GL_BUFFER, pass->large_buffer, -1, "large splats");
    stp_result result = stp_gl_program_create(r->base.context, gl, "splat.vert.glsl",
                                              "splat.frag.glsl", defines, &pass->points);
    if (result == STP_OK) {
        result = stp_gl_program_create(r->base.context, gl, stp_gl_large_vertex_shader(r),
                                       stp_gl_large_fragment_shader(r), defines, &pass->large);
    }
    return result;
}

void stp_gl_splat_pass_destroy(stp_gl_renderer* r)
{
    const stp_gl* gl = &r->gl;
    stp_gl_splat_pass* pass = &r->splats;
    gl->DeleteProgram(pass->points);
    gl->DeleteProgram(pass->large);
    gl->DeleteVertexArrays(1, &pass->vertex_array);
    gl->DeleteBuffers(1, &pass->large_buffer);
    *pass = (stp_gl_splat_pass){0};
}

void stp_gl_splat_pass_begin(stp_gl_renderer* r)
{
    const stp_gl* gl = &r->gl;
    const uint32_t none[4] = {4, 0, 0, 0}; // command of the large ones: one quad each
    gl->NamedBufferSubData(r->splats.large_buffer, 0, sizeof(none), none);
    gl->BindBufferBase(GL_SHADER_STORAGE_BUFFER, BINDING_LARGE, r->splats.large_buffer);
}

stp_result stp_gl_splat_pass_points(stp_gl_renderer* r, const stp_gl_splat_source* source,
                                    GLuint program)
{
    const stp_gl* gl = &r->gl;
    gl->Enable(GL_PROGRAM_POINT_SIZE);
    gl->BindVertexArray(r->splats.vertex_array);
    gl->UseProgram(program);
    gl->BindBuffer(GL_DRAW_INDIRECT_BUFFER, source->buffer);
    gl->BindBuffer(GL_PARAMETER_BUFFER_ARB, source->buffer);
    stp_result result = STP_OK;
    const stp_gl_commands* commands = &r->frame.commands[GL_COMMANDS_SPLATS];
    if (source->buffer == r->frame.buffer) {
        result = stp_gl_portion_draw(r, GL_POINTS, commands, source->offset, source->count_offset);
    } else { // created for measuring
        gl->MultiDrawArraysIndirectCount(GL_POINTS, (const void*)source->offset,
                                         source->count_offset, (GLsizei)source->count, 0);
        r->draw_calls += 1;
    }
    gl->Disable(GL_PROGRAM_POINT_SIZE);
    return result;
}

void stp_gl_splat_pass_large(stp_gl_renderer* r, GLuint program)
{
    const stp_gl* gl = &r->gl;
    gl->MemoryBarrier(GL_COMMAND_BARRIER_BIT | GL_SHADER_STORAGE_BARRIER_BIT);
    gl->BindVertexArray(r->splats.vertex_array);
    gl->UseProgram(program);
    gl->BindBuffer(GL_DRAW_INDIRECT_BUFFER, r->splats.large_buffer);
    gl->DrawArraysIndirect(GL_TRIANGLE_STRIP, NULL);
    r->draw_calls += 1;
}
