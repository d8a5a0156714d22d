// SPDX-License-Identifier: MIT
#include "draw/gl/gl.h"

#include <string.h>

const char* stp_gl_load(stp_gl* gl, const stp_draw_gl_desc* desc)
{
#define X(type, name)                                                                              \
    gl->name = (type)desc->get_proc_address("gl" #name, desc->user);                               \
    if (gl->name == NULL) {                                                                        \
        return "gl" #name;                                                                         \
    }
    STP_GL_FUNCTIONS(X)
#undef X
    static const char* const names[] = {"glMultiDrawArraysIndirectCount",
                                        "glMultiDrawArraysIndirectCountARB"};
    for (int i = 0; i < 2 && gl->MultiDrawArraysIndirectCount == NULL; ++i) {
        gl->MultiDrawArraysIndirectCount =
            (PFNGLMULTIDRAWARRAYSINDIRECTCOUNTARBPROC)desc->get_proc_address(names[i], desc->user);
    }
    return gl->MultiDrawArraysIndirectCount != NULL ? NULL : names[0];
}

bool stp_gl_has(const stp_gl* gl, const char* extension)
{
    GLint count = 0;
    gl->GetIntegerv(GL_NUM_EXTENSIONS, &count);
    for (GLint i = 0; i < count; ++i) {
        const GLubyte* name = gl->GetStringi(GL_EXTENSIONS, (GLuint)i);
        if (name != NULL && strcmp((const char*)name, extension) == 0) {
            return true;
        }
    }
    return false;
}
