// SPDX-License-Identifier: MIT
// Triangles: opaque materials with one command, and those with per-fragment tests with another.
#include "base/core/context.h"
#include "draw/gl/gl_renderer.h"

stp_result stp_gl_triangle_pass_create(stp_gl_renderer* r)
{
    stp_gl_triangle_pass* pass = &r->triangles;
    char defines[256];
    *pass = (stp_gl_triangle_pass){0};
    r->gl.CreateVertexArrays(1, &pass->vertex_array);
    stp_result result =
        stp_gl_program_create(r->base.context, &r->gl, "triangle.vert.glsl", "triangle.frag.glsl",
                              stp_gl_page_defines(r, "", defines, sizeof(defines)), &pass->plain);
    if (result == STP_OK) {
        result = stp_gl_program_create(
            r->base.context, &r->gl, "triangle.vert.glsl", "triangle.frag.glsl",
            stp_gl_page_defines(r, "#define KEEP\n", defines, sizeof(defines)), &pass->keep);
    }
    return result;
}

void stp_gl_triangle_pass_destroy(stp_gl_renderer* r)
{
    stp_gl_triangle_pass* pass = &r->triangles;
    r->gl.DeleteProgram(pass->plain);
    r->gl.DeleteProgram(pass->keep);
    r->gl.DeleteVertexArrays(1, &pass->vertex_array);
    *pass = (stp_gl_triangle_pass){0};
}

static stp_result draw(stp_gl_renderer* r, GLuint program, const stp_gl_commands* commands)
{
    if (commands->count == 0) {
        return STP_OK;
    }
    r->gl.UseProgram(program);
    return stp_gl_portion_draw(r, GL_TRIANGLES, commands, commands->offset, commands->count_offset);
}

stp_result stp_gl_triangle_pass_draw(stp_gl_renderer* r)
{
    const stp_gl* gl = &r->gl;
    gl->BindVertexArray(r->triangles.vertex_array);
    gl->BindBuffer(GL_DRAW_INDIRECT_BUFFER, r->frame.buffer);
    gl->BindBuffer(GL_PARAMETER_BUFFER_ARB, r->frame.buffer);
    stp_result result = draw(r, r->triangles.plain, &r->frame.commands[GL_COMMANDS_TRIANGLES]);
    return result == STP_OK ? draw(r, r->triangles.keep, &r->frame.commands[GL_COMMANDS_KEEP])
                            : result;
}
