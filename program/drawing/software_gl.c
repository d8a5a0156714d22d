// SPDX-License-Identifier: MIT
#include "program/drawing/software_gl.h"

#include "program/present/headless.h"

#include <GL/glcorearb.h>
#include <assert.h>
#include <stdio.h>
#include <stdlib.h>

#define GL_FUNCTIONS(X)                                                                            \
    X(PFNGLGETSTRINGPROC, glGetString)                                                             \
    X(PFNGLGETERRORPROC, glGetError)                                                               \
    X(PFNGLCREATEFRAMEBUFFERSPROC, glCreateFramebuffers)                                           \
    X(PFNGLCREATETEXTURESPROC, glCreateTextures)                                                   \
    X(PFNGLTEXTURESTORAGE2DPROC, glTextureStorage2D)                                               \
    X(PFNGLNAMEDFRAMEBUFFERTEXTUREPROC, glNamedFramebufferTexture)                                 \
    X(PFNGLBINDFRAMEBUFFERPROC, glBindFramebuffer)                                                 \
    X(PFNGLVIEWPORTPROC, glViewport)                                                               \
    X(PFNGLENABLEPROC, glEnable)                                                                   \
    X(PFNGLCREATEBUFFERSPROC, glCreateBuffers)                                                     \
    X(PFNGLDELETEBUFFERSPROC, glDeleteBuffers)                                                     \
    X(PFNGLNAMEDBUFFERSTORAGEPROC, glNamedBufferStorage)                                           \
    X(PFNGLCREATEVERTEXARRAYSPROC, glCreateVertexArrays)                                           \
    X(PFNGLVERTEXARRAYVERTEXBUFFERPROC, glVertexArrayVertexBuffer)                                 \
    X(PFNGLENABLEVERTEXARRAYATTRIBPROC, glEnableVertexArrayAttrib)                                 \
    X(PFNGLVERTEXARRAYATTRIBFORMATPROC, glVertexArrayAttribFormat)                                 \
    X(PFNGLVERTEXARRAYATTRIBBINDINGPROC, glVertexArrayAttribBinding)                               \
    X(PFNGLBINDVERTEXARRAYPROC, glBindVertexArray)                                                 \
    X(PFNGLCREATESHADERPROC, glCreateShader)                                                       \
    X(PFNGLSHADERSOURCEPROC, glShaderSource)                                                       \
    X(PFNGLCOMPILESHADERPROC, glCompileShader)                                                     \
    X(PFNGLCREATEPROGRAMPROC, glCreateProgram)                                                     \
    X(PFNGLATTACHSHADERPROC, glAttachShader)                                                       \
    X(PFNGLLINKPROGRAMPROC, glLinkProgram)                                                         \
    X(PFNGLGETPROGRAMIVPROC, glGetProgramiv)                                                       \
    X(PFNGLUSEPROGRAMPROC, glUseProgram)                                                           \
    X(PFNGLUNIFORM1FPROC, glUniform1f)                                                             \
    X(PFNGLCLEARPROC, glClear)                                                                     \
    X(PFNGLDRAWARRAYSPROC, glDrawArrays)                                                           \
    X(PFNGLFINISHPROC, glFinish)

struct software_gl {
    stp_headless headless;
    GLuint programs[2], buffers[2], vertex_array;
    GLsizei count;
#define X(type, name) type name;
    GL_FUNCTIONS(X)
#undef X
};

static const char* const vertex_text =
    "#version 450\n"
    "layout(location = 0) in vec3 position;\n"
    "layout(location = 1) in vec3 normal;\n"
    "layout(location = 0) uniform float size;\n"
    "flat out vec3 n;\n"
    "void main() { gl_Position = vec4(position, 1); gl_PointSize = size; n = normal; }\n";
static const char* const square_text = "#version 450\n"
                                       "flat in vec3 n;\n"
                                       "layout(location = 0) out vec4 color;\n"
                                       "void main() { color = vec4(n * 0.5 + 0.5, 1); }\n";
static const char* const disk_text =
    "#version 450\n"
    "flat in vec3 n;\n"
    "layout(location = 0) out vec4 color;\n"
    "void main() {\n"
    "    vec2 q = gl_PointCoord * 2 - 1;\n"
    "    float z = -(n.x * q.x + n.y * q.y) / (abs(n.z) > 0.001 ? n.z : 0.001);\n"
    "    if (dot(q, q) + z * z > 1) discard;\n"
    "    color = vec4(n * 0.5 + 0.5, 1);\n"
    "}\n";

static bool find_functions(software_gl* gl)
{
    bool found = true;
#define X(type, name)                                                                              \
    gl->name = (type)gl->headless.get_proc_address(#name);                                         \
    found = found && gl->name != NULL;
    GL_FUNCTIONS(X)
#undef X
    return found;
}

static GLuint make_program(software_gl* gl, const char* fragment_text)
{
    const char* texts[2] = {vertex_text, fragment_text};
    GLuint program = gl->glCreateProgram();
    for (int i = 0; i < 2; ++i) {
        GLuint shader = gl->glCreateShader(i == 0 ? GL_VERTEX_SHADER : GL_FRAGMENT_SHADER);
        gl->glShaderSource(shader, 1, &texts[i], NULL);
        gl->glCompileShader(shader);
        gl->glAttachShader(program, shader);
    }
    gl->glLinkProgram(program);
    GLint linked = 0;
    gl->glGetProgramiv(program, GL_LINK_STATUS, &linked);
    return linked != 0 ? program : 0;
}

static bool make_target(software_gl* gl, uint32_t width, uint32_t height)
{
    GLuint framebuffer, textures[2];
    gl->glCreateFramebuffers(1, &framebuffer);
    gl->glCreateTextures(GL_TEXTURE_2D, 2, textures);
    gl->glTextureStorage2D(textures[0], 1, GL_RGBA8, (GLsizei)width, (GLsizei)height);
    gl->glTextureStorage2D(textures[1], 1, GL_DEPTH_COMPONENT32F, (GLsizei)width, (GLsizei)height);
    gl->glNamedFramebufferTexture(framebuffer, GL_COLOR_ATTACHMENT0, textures[0], 0);
    gl->glNamedFramebufferTexture(framebuffer, GL_DEPTH_ATTACHMENT, textures[1], 0);
    gl->glBindFramebuffer(GL_FRAMEBUFFER, framebuffer);
    gl->glViewport(0, 0, (GLsizei)width, (GLsizei)height);
    gl->glEnable(GL_DEPTH_TEST);
    gl->glEnable(GL_PROGRAM_POINT_SIZE);
    gl->programs[0] = make_program(gl, square_text);
    gl->programs[1] = make_program(gl, disk_text);
    return gl->programs[0] != 0 && gl->programs[1] != 0 && gl->glGetError() == GL_NO_ERROR;
}

software_gl* software_gl_create(uint32_t width, uint32_t height, uint32_t threads)
{
    software_gl* gl = calloc(1, sizeof(*gl));
    if (gl == NULL) {
        return NULL;
    }
    char count[16];
    snprintf(count, sizeof(count), "%u", threads);
    setenv("LP_NUM_THREADS", count, 1);
    setenv("LIBGL_ALWAYS_SOFTWARE", "1", 0);
    const stp_headless_desc desc = {.software = true};
    if (stp_headless_create(&desc, &gl->headless) != NULL || !find_functions(gl) ||
        !make_target(gl, width, height)) {
        software_gl_destroy(gl);
        return NULL;
    }
    return gl;
}

void software_gl_destroy(software_gl* gl)
{
    if (gl == NULL) {
        return;
    }
    if (gl->headless.context != NULL) {
        stp_headless_destroy(&gl->headless);
    }
    free(gl);
}

const char* software_gl_name(const software_gl* gl)
{
    const GLubyte* name = gl->glGetString(GL_RENDERER);
    return name != NULL ? (const char*)name : "";
}

bool software_gl_upload(software_gl* gl, const float* positions, const float* normals,
                        uint32_t count)
{
    const float* columns[2] = {positions, normals};
    gl->glDeleteBuffers(2, gl->buffers);
    gl->glCreateBuffers(2, gl->buffers);
    gl->glCreateVertexArrays(1, &gl->vertex_array);
    for (GLuint i = 0; i < 2; ++i) {
        gl->glNamedBufferStorage(gl->buffers[i], (GLsizeiptr)count * 12, columns[i], 0);
        gl->glVertexArrayVertexBuffer(gl->vertex_array, i, gl->buffers[i], 0, 12);
        gl->glEnableVertexArrayAttrib(gl->vertex_array, i);
        gl->glVertexArrayAttribFormat(gl->vertex_array, i, 3, GL_FLOAT, GL_FALSE, 0);
        gl->glVertexArrayAttribBinding(gl->vertex_array, i, i);
    }
    gl->glBindVertexArray(gl->vertex_array);
    gl->count = (GLsizei)count;
    return gl->glGetError() == GL_NO_ERROR;
}

static void draw_first(software_gl* gl, float size_px, bool disks, GLsizei count)
{
    assert(gl->vertex_array != 0 && count <= gl->count && "points were uploaded");
    gl->glUseProgram(gl->programs[disks ? 1 : 0]);
    gl->glUniform1f(0, size_px);
    gl->glClear(GL_COLOR_BUFFER_BIT | GL_DEPTH_BUFFER_BIT);
    gl->glDrawArrays(GL_POINTS, 0, count);
    gl->glFinish();
}

void software_gl_draw(software_gl* gl, float size_px, bool disks)
{
    draw_first(gl, size_px, disks, gl->count);
}

void software_gl_warm(software_gl* gl, float size_px, bool disks)
{
    draw_first(gl, size_px, disks, 1);
}
