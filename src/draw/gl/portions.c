// SPDX-License-Identifier: MIT
// Draws commands in one batch, or in several with a wait after each, so that a picture can be
// cancelled between batches.
#include "draw/gl/gl_renderer.h"

#include <assert.h>

static const uint64_t portion_vertices = 100000; // a few milliseconds on a CPU, much less on a GPU
static const GLuint64 check_every = 1000000;     // nanoseconds

stp_result stp_gl_portion_wait(stp_gl_renderer* r)
{
    const stp_gl* gl = &r->gl;
    if (r->base.stop == NULL) {
        return STP_OK;
    }
    GLsync sync = gl->FenceSync(GL_SYNC_GPU_COMMANDS_COMPLETE, 0);
    GLenum state = GL_TIMEOUT_EXPIRED;
    while (state == GL_TIMEOUT_EXPIRED && !stp_renderer_is_stopped(&r->base) &&
           gl->GetGraphicsResetStatus() == GL_NO_ERROR) {
        state = gl->ClientWaitSync(sync, GL_SYNC_FLUSH_COMMANDS_BIT, check_every);
    }
    gl->DeleteSync(sync);
    return stp_renderer_is_stopped(&r->base) ? STP_ERROR_CANCELLED : STP_OK;
}

/// End of the batch that begins with a command.
static size_t find_end(const struct stp_gl_command* commands, size_t first, size_t count)
{
    assert(first < count && "a batch has a command");
    uint64_t vertices = commands[first].count;
    size_t end = first + 1;
    while (end < count && vertices + commands[end].count <= portion_vertices) {
        vertices += commands[end].count;
        end += 1;
    }
    return end;
}

stp_result stp_gl_portion_draw(stp_gl_renderer* r, GLenum mode, const stp_gl_commands* commands,
                               GLintptr offset, GLintptr count_offset)
{
    const stp_gl* gl = &r->gl;
    if (r->base.stop == NULL) {
        gl->MultiDrawArraysIndirectCount(mode, (const void*)offset, count_offset,
                                         (GLsizei)commands->count, 0);
        r->draw_calls += 1;
        return STP_OK;
    }
    stp_result result = STP_OK;
    for (size_t first = 0, end; first < commands->count && result == STP_OK; first = end) {
        end = find_end(commands->commands, first, commands->count);
        GLintptr at = offset + (GLintptr)(first * sizeof(struct stp_gl_command));
        gl->MultiDrawArraysIndirect(mode, (const void*)at, (GLsizei)(end - first), 0);
        r->draw_calls += 1;
        result = stp_gl_portion_wait(r);
    }
    return result;
}
