// SPDX-License-Identifier: MIT
#include "software_gl.h"

#include <stdio.h>
#include <stdlib.h>

#if __has_include(<EGL/egl.h>) && __has_include(<GL/glcorearb.h>)

#include <EGL/egl.h>
#include <EGL/eglext.h>
#include <GL/glcorearb.h>
#include <dlfcn.h>

// No library is linked for a comparison: EGL is opened at run time, and the rest asked of it.
#define EGL_FUNCTIONS(X)                                                                           \
    X(PFNEGLGETPROCADDRESSPROC, eglGetProcAddress)                                                 \
    X(PFNEGLINITIALIZEPROC, eglInitialize)                                                         \
    X(PFNEGLTERMINATEPROC, eglTerminate)                                                           \
    X(PFNEGLBINDAPIPROC, eglBindAPI)                                                               \
    X(PFNEGLCREATECONTEXTPROC, eglCreateContext)                                                   \
    X(PFNEGLDESTROYCONTEXTPROC, eglDestroyContext)                                                 \
    X(PFNEGLMAKECURRENTPROC, eglMakeCurrent)
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
    void* library;
    EGLDisplay display;
    EGLContext context;
    GLuint programs[2], buffers[2], vertex_array;
    GLsizei count;
#define X(type, name) type name;
    EGL_FUNCTIONS(X)
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
    *(void**)&gl->name = dlsym(gl->library, #name);                                                \
    found = found && gl->name != NULL;
    EGL_FUNCTIONS(X)
#undef X
    if (!found) {
        return false;
    }
#define X(type, name)                                                                              \
    gl->name = (type)gl->eglGetProcAddress(#name);                                                 \
    found = found && gl->name != NULL;
    GL_FUNCTIONS(X)
#undef X
    return found;
}

static bool make_current(software_gl* gl)
{
    PFNEGLGETPLATFORMDISPLAYEXTPROC get_display =
        (PFNEGLGETPLATFORMDISPLAYEXTPROC)gl->eglGetProcAddress("eglGetPlatformDisplayEXT");
    if (get_display == NULL) {
        return false;
    }
    gl->display = get_display(EGL_PLATFORM_SURFACELESS_MESA, EGL_DEFAULT_DISPLAY, NULL);
    if (gl->display == EGL_NO_DISPLAY || !gl->eglInitialize(gl->display, NULL, NULL)) {
        gl->display = EGL_NO_DISPLAY;
        return false;
    }
    static const EGLint wanted[] = {EGL_CONTEXT_MAJOR_VERSION,
                                    4,
                                    EGL_CONTEXT_MINOR_VERSION,
                                    5,
                                    EGL_CONTEXT_OPENGL_PROFILE_MASK,
                                    EGL_CONTEXT_OPENGL_CORE_PROFILE_BIT,
                                    EGL_NONE};
    gl->eglBindAPI(EGL_OPENGL_API);
    gl->context = gl->eglCreateContext(gl->display, EGL_NO_CONFIG_KHR, EGL_NO_CONTEXT, wanted);
    return gl->context != EGL_NO_CONTEXT &&
           gl->eglMakeCurrent(gl->display, EGL_NO_SURFACE, EGL_NO_SURFACE, gl->context);
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
    gl->library = dlopen("libEGL.so.1", RTLD_NOW | RTLD_LOCAL);
    if (gl->library == NULL || !find_functions(gl) || !make_current(gl) ||
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
    if (gl->display != EGL_NO_DISPLAY) {
        gl->eglMakeCurrent(gl->display, EGL_NO_SURFACE, EGL_NO_SURFACE, EGL_NO_CONTEXT);
        if (gl->context != EGL_NO_CONTEXT) {
            gl->eglDestroyContext(gl->display, gl->context);
        }
        gl->eglTerminate(gl->display);
    }
    // the library stays: drivers do not survive being unloaded
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

#else

struct software_gl {
    int unused;
};

software_gl* software_gl_create(uint32_t width, uint32_t height, uint32_t threads)
{
    (void)width;
    (void)height;
    (void)threads;
    return NULL; // built without the headers of EGL and OpenGL
}

void software_gl_destroy(software_gl* gl)
{
    free(gl);
}

const char* software_gl_name(const software_gl* gl)
{
    (void)gl;
    return "";
}

bool software_gl_upload(software_gl* gl, const float* positions, const float* normals,
                        uint32_t count)
{
    (void)gl;
    (void)positions;
    (void)normals;
    (void)count;
    return false;
}

void software_gl_draw(software_gl* gl, float size_px, bool disks)
{
    (void)gl;
    (void)size_px;
    (void)disks;
}

void software_gl_warm(software_gl* gl, float size_px, bool disks)
{
    software_gl_draw(gl, size_px, disks);
}

#endif
