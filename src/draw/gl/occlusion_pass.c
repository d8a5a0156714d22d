// SPDX-License-Identifier: MIT
#include "base/core/context.h"
#include "draw/gl/gl_passes.h"
#include "draw/gl/gl_renderer.h"

#include <assert.h>
#include <string.h>

void stp_gl_occlusion_pass_destroy(stp_gl_renderer* r)
{
    stp_gl_occlusion_pass* pass = &r->occlusion;
    const GLuint buffers[] = {pass->pyramid, pass->counters};
    r->gl.DeleteProgram(pass->cull);
    r->gl.DeleteProgram(pass->fill);
    r->gl.DeleteBuffers(2, buffers);
    *pass = (stp_gl_occlusion_pass){0};
}

bool stp_gl_occlusion_pass_serves(const stp_gl_renderer* r)
{
    return r->target.eye_count == 1 && !r->placement.frame.parallel &&
           r->style->filter == STP_FILTER_NONE && r->style->point_sizing == STP_POINTS_ADAPTIVE &&
           !r->omits.occlusion;
}

/// Matrix from right, down, depth and 1 to X, Y, N and W.
static void make_screen(const stp_view_frame* f, double shift_x, double shift_y, double scale,
                        double out[4][4])
{
    const double rows[4][4] = {{f->scale, 0.0, f->center_x + shift_x, 0.0},
                               {0.0, f->scale, f->center_y + shift_y, 0.0},
                               {0.0, 0.0, 0.0, scale},
                               {0.0, 0.0, 1.0, 0.0}};
    memcpy(out, rows, sizeof(rows));
}

static void multiply(const double a[4][4], const double b[4][4], double out[4][4])
{
    for (int r = 0; r < 4; ++r) {
        for (int c = 0; c < 4; ++c) {
            out[r][c] =
                a[r][0] * b[0][c] + a[r][1] * b[1][c] + a[r][2] * b[2][c] + a[r][3] * b[3][c];
        }
    }
}

void stp_gl_occlusion_pass_set_view(const stp_gl_renderer* r, view_block* view)
{
    const stp_gl_occlusion_pass* pass = &r->occlusion;
    const stp_view_frame *now = &r->placement.frame, *then = &pass->frame;
    view->corner = (float)now->corner;
    if (!pass->known || now->parallel) {
        return;
    }
    const double x = now->center_x + r->placement.shift_x, y = now->center_y + r->placement.shift_y;
    const double back[4][4] = {{1.0 / now->scale, 0.0, 0.0, -x / now->scale},
                               {0.0, 1.0 / now->scale, 0.0, -y / now->scale},
                               {0.0, 0.0, 0.0, 1.0},
                               {0.0, 0.0, 1.0 / r->placement.nearness_scale, 0.0}};
    const stp_vec3d from[3] = {now->right, now->down, now->forward};
    const stp_vec3d to[3] = {then->right, then->down, then->forward};
    double turn[4][4] = {{0.0}}, screen[4][4], rest[4][4], all[4][4];
    for (int k = 0; k < 3; ++k) {
        for (int c = 0; c < 3; ++c) {
            turn[k][c] = stp_dotd(to[k], from[c]);
        }
        turn[k][3] = stp_dotd(to[k], stp_subd(now->eye, then->eye));
    }
    turn[3][3] = 1.0;
    make_screen(then, pass->shift_x, pass->shift_y, pass->nearness_scale, screen);
    multiply((const double(*)[4])turn, back, rest);
    multiply((const double(*)[4])screen, (const double(*)[4])rest, all);
    for (int k = 0; k < 4; ++k) {
        for (int c = 0; c < 4; ++c) {
            view->earlier[k][c] = (float)all[k][c];
        }
    }
}

static stp_result make_cull(stp_gl_renderer* r)
{
    stp_gl_occlusion_pass* pass = &r->occlusion;
    char defines[256];
    if (pass->counters == 0) {
        r->gl.CreateBuffers(1, &pass->counters);
        r->gl.NamedBufferStorage(pass->counters, 2 * sizeof(uint32_t), NULL, 0);
        r->gl.ObjectLabel(GL_BUFFER, pass->counters, -1, "set aside");
    }
    return pass->cull != 0
               ? STP_OK
               : stp_gl_program_create_compute(r->base.context, &r->gl, "occlude.comp.glsl",
                                               stp_gl_page_defines(r, "", defines, sizeof(defines)),
                                               &pass->cull);
}

stp_result stp_gl_occlusion_pass_cull(stp_gl_renderer* r, bool late)
{
    const stp_gl* gl = &r->gl;
    const GLuint zero = 0;
    stp_result result = make_cull(r);
    if (result != STP_OK) {
        return result;
    }
    stp_gl_occlusion_pass* pass = &r->occlusion;
    if (!late) {
        gl->ClearNamedBufferSubData(pass->counters, GL_R32UI, 0, 2 * sizeof(uint32_t),
                                    GL_RED_INTEGER, GL_UNSIGNED_INT, &zero);
    }
    assert(pass->known && pass->pyramid != 0 && "a first picture is drawn without culling");
    gl->BindBufferBase(GL_SHADER_STORAGE_BUFFER, BINDING_PYRAMID, pass->pyramid);
    gl->BindBufferBase(GL_SHADER_STORAGE_BUFFER, BINDING_COUNTERS, pass->counters);
    gl->UseProgram(pass->cull);
    gl->Uniform1ui(1, late ? 1 : 0);
    for (int i = 0; i < GL_COMMANDS_CULLED; ++i) {
        const stp_gl_commands* c = &r->frame.commands[i];
        if (c->count > 0) {
            gl->BindBufferRange(GL_SHADER_STORAGE_BUFFER, BINDING_OCCLUDED_COMMANDS,
                                r->frame.buffer, c->offset,
                                (GLsizeiptr)(c->count * sizeof(*c->commands)));
            gl->Uniform1ui(0, (GLuint)c->count);
            gl->DispatchCompute(((GLuint)c->count + OCCLUDE_GROUP - 1) / OCCLUDE_GROUP, 1, 1);
            r->dispatches += 1;
        }
    }
    gl->MemoryBarrier(GL_COMMAND_BARRIER_BIT | GL_SHADER_STORAGE_BARRIER_BIT);
    stp_gl_bind_frame(r);
    return STP_OK;
}

static stp_result make_pyramid(stp_gl_renderer* r)
{
    const stp_gl* gl = &r->gl;
    stp_gl_occlusion_pass* pass = &r->occlusion;
    uint64_t blocks = 0;
    if (pass->width == r->target.width && pass->height == r->target.height) {
        return STP_OK;
    }
    gl->DeleteBuffers(1, &pass->pyramid);
    pass->width = pass->height = 0;
    pass->known = false;
    while (gl->GetError() != GL_NO_ERROR) { // discard errors of earlier calls
    }
    for (uint32_t side = PYRAMID_BLOCK; side < PYRAMID_BLOCK << PYRAMID_LEVELS; side *= 2) {
        blocks += (uint64_t)((r->target.width + side - 1) / side) *
                  ((r->target.height + side - 1) / side);
    }
    gl->CreateBuffers(1, &pass->pyramid);
    gl->NamedBufferStorage(pass->pyramid, (GLsizeiptr)(blocks * sizeof(float)), NULL, 0);
    gl->ObjectLabel(GL_BUFFER, pass->pyramid, -1, "depth pyramid");
    if (gl->GetError() != GL_NO_ERROR) {
        return stp_fail(r->base.context, STP_ERROR_OUT_OF_MEMORY,
                        "gl: not enough graphics memory for the depths of a picture of %ux%u",
                        r->target.width, r->target.height);
    }
    pass->width = r->target.width;
    pass->height = r->target.height;
    return STP_OK;
}

stp_result stp_gl_occlusion_pass_fill(stp_gl_renderer* r)
{
    const stp_gl* gl = &r->gl;
    stp_gl_occlusion_pass* pass = &r->occlusion;
    const uint32_t tile = GROUP_SIDE * PYRAMID_BLOCK;
    stp_result result = make_pyramid(r);
    if (result == STP_OK && pass->fill == 0) {
        result = stp_gl_program_create_compute(r->base.context, gl, "pyramid.comp.glsl", NULL,
                                               &pass->fill);
    }
    if (result != STP_OK) {
        return result;
    }
    assert(!r->placement.frame.parallel && "matrices to earlier pictures are in perspective");
    gl->BindTextureUnit(UNIT_NEARNESS, r->target.nearness);
    gl->BindBufferBase(GL_SHADER_STORAGE_BUFFER, BINDING_PYRAMID, pass->pyramid);
    gl->UseProgram(pass->fill);
    gl->DispatchCompute((pass->width + tile - 1) / tile, (pass->height + tile - 1) / tile, 1);
    gl->MemoryBarrier(GL_SHADER_STORAGE_BARRIER_BIT);
    r->dispatches += 1;
    pass->known = true;
    pass->frame = r->placement.frame;
    pass->shift_x = r->placement.shift_x;
    pass->shift_y = r->placement.shift_y;
    pass->nearness_scale = r->placement.nearness_scale;
    stp_gl_bind_frame(r);
    return STP_OK;
}

_Static_assert(GROUP_SIDE == 1 << (PYRAMID_LEVELS - 1), "a group has a block of the last level");
