// SPDX-License-Identifier: MIT
#include "program/viewer/window/window.h"

#include <SDL_opengl.h>
#include <assert.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum {
    WIDTH_MIN = 300,
    HEIGHT_MIN = 200,
    FRAME_MS = 16, ///< shortest time between frames without a GPU
};

// The OpenGL functions of the window, all of version 1.1.
struct window_gl {
    void (*gen_textures)(GLsizei, GLuint*);
    void (*delete_textures)(GLsizei, const GLuint*);
    void (*bind_texture)(GLenum, GLuint);
    void (*tex_parameteri)(GLenum, GLenum, GLint);
    void (*tex_image)(GLenum, GLint, GLint, GLsizei, GLsizei, GLint, GLenum, GLenum, const void*);
    void (*tex_sub_image)(GLenum, GLint, GLint, GLint, GLsizei, GLsizei, GLenum, GLenum,
                          const void*);
    void (*viewport)(GLint, GLint, GLsizei, GLsizei);
    void (*clear_color)(GLfloat, GLfloat, GLfloat, GLfloat);
    void (*clear)(GLbitfield);
    void (*finish)(void);
    const GLubyte* (*get_string)(GLenum);
    GLenum (*get_error)(void);
};

static bool load_functions(window_gl* gl)
{
    const struct {
        const char* name;
        void* place;
    } list[] = {
        {"glGenTextures", &gl->gen_textures},
        {"glDeleteTextures", &gl->delete_textures},
        {"glBindTexture", &gl->bind_texture},
        {"glTexParameteri", &gl->tex_parameteri},
        {"glTexImage2D", &gl->tex_image},
        {"glTexSubImage2D", &gl->tex_sub_image},
        {"glViewport", &gl->viewport},
        {"glClearColor", &gl->clear_color},
        {"glClear", &gl->clear},
        {"glFinish", &gl->finish},
        {"glGetString", &gl->get_string},
        {"glGetError", &gl->get_error},
    };
    for (size_t i = 0; i < sizeof(list) / sizeof(list[0]); ++i) {
        void* function = SDL_GL_GetProcAddress(list[i].name);
        if (function == NULL) {
            return false;
        }
        memcpy(list[i].place, &function, sizeof(function));
    }
    return true;
}

static float display_scale(void)
{
    float dpi = 0.0f;
    if (SDL_GetDisplayDPI(0, &dpi, NULL, NULL) != 0 || !(dpi > 0.0f)) {
        return 1.0f;
    }
    // rounded to quarters, so that text stays crisp; displays report odd sizes
    float scale = roundf(4.0f * dpi / 96.0f) / 4.0f;
    return scale < 1.0f ? 1.0f : scale > 3.0f ? 3.0f : scale;
}

static bool create_gl(window* w, const window_desc* desc, int major, int minor)
{
    SDL_GL_SetAttribute(SDL_GL_CONTEXT_MAJOR_VERSION, major);
    SDL_GL_SetAttribute(SDL_GL_CONTEXT_MINOR_VERSION, minor);
    SDL_GL_SetAttribute(SDL_GL_CONTEXT_PROFILE_MASK, SDL_GL_CONTEXT_PROFILE_CORE);
    SDL_GL_SetAttribute(SDL_GL_DOUBLEBUFFER, 1);
    SDL_GL_SetAttribute(SDL_GL_DEPTH_SIZE, 0);
    // without this, a context does not report that it was lost
    SDL_GL_SetAttribute(SDL_GL_CONTEXT_RESET_NOTIFICATION, SDL_GL_CONTEXT_RESET_LOSE_CONTEXT);
    w->handle = SDL_CreateWindow(
        desc->title, SDL_WINDOWPOS_UNDEFINED, SDL_WINDOWPOS_UNDEFINED, desc->width, desc->height,
        SDL_WINDOW_OPENGL | SDL_WINDOW_RESIZABLE | SDL_WINDOW_ALLOW_HIGHDPI);
    if (w->handle == NULL) {
        return false;
    }
    w->gl = SDL_GL_CreateContext(w->handle);
    if (w->gl == NULL) { // not every driver supports it
        SDL_GL_SetAttribute(SDL_GL_CONTEXT_RESET_NOTIFICATION,
                            SDL_GL_CONTEXT_RESET_NO_NOTIFICATION);
        w->gl = SDL_GL_CreateContext(w->handle);
    }
    w->functions = w->gl != NULL ? calloc(1, sizeof(*w->functions)) : NULL;
    if (w->functions == NULL || !load_functions(w->functions)) {
        window_destroy(w);
        return false;
    }
    w->version = 10 * major + minor;
    SDL_GL_SetSwapInterval(1);
    snprintf(w->device, sizeof(w->device), "%s",
             (const char*)w->functions->get_string(GL_RENDERER));
    return true;
}

/// A context that shares the window's textures. It has a hidden window of its own, because two
/// threads must not draw into the same one.
static void create_worker(window* w)
{
    SDL_GL_SetAttribute(SDL_GL_SHARE_WITH_CURRENT_CONTEXT, 1);
    w->worker_window =
        SDL_CreateWindow("worker", 0, 0, 16, 16, SDL_WINDOW_OPENGL | SDL_WINDOW_HIDDEN);
    w->worker = w->worker_window != NULL ? SDL_GL_CreateContext(w->worker_window) : NULL;
    SDL_GL_MakeCurrent(w->handle, w->gl);
    w->has_worker = w->worker != NULL;
    static const char* const processors[] = {"llvmpipe", "softpipe", "swrast", "SWR"};
    w->is_hardware = w->has_worker;
    for (size_t i = 0; i < sizeof(processors) / sizeof(processors[0]); ++i) {
        w->is_hardware = w->is_hardware && strstr(w->device, processors[i]) == NULL;
    }
}

static bool create_software(window* w, const window_desc* desc)
{
    SDL_SetHint(SDL_HINT_FRAMEBUFFER_ACCELERATION, "0"); // otherwise SDL would still use OpenGL
    w->handle =
        SDL_CreateWindow(desc->title, SDL_WINDOWPOS_UNDEFINED, SDL_WINDOWPOS_UNDEFINED, desc->width,
                         desc->height, SDL_WINDOW_RESIZABLE | SDL_WINDOW_ALLOW_HIGHDPI);
    w->renderer =
        w->handle != NULL ? SDL_CreateRenderer(w->handle, -1, SDL_RENDERER_SOFTWARE) : NULL;
    if (w->renderer == NULL) {
        window_destroy(w);
        return false;
    }
    snprintf(w->device, sizeof(w->device), "SDL, without OpenGL");
    return true;
}

bool window_create(window* w, const window_desc* desc, char* reason, size_t reason_size)
{
    *w = (window){0};
    const char* x11 = getenv("DISPLAY");
    const char* wayland = getenv("WAYLAND_DISPLAY");
    const char* driver = getenv("SDL_VIDEODRIVER");
    bool named = (x11 != NULL && *x11 != 0) || (wayland != NULL && *wayland != 0) ||
                 (driver != NULL && *driver != 0);
    // without a display, SDL would take over a console
    if (!named || SDL_InitSubSystem(SDL_INIT_VIDEO | SDL_INIT_EVENTS) != 0) {
        snprintf(
            reason, reason_size,
            "there is no display for a window (%s); stipple render and stipple fly work without "
            "one",
            named ? SDL_GetError() : "neither DISPLAY nor WAYLAND_DISPLAY is set");
        return false;
    }
    bool made = !desc->software && (create_gl(w, desc, 4, 5) || create_gl(w, desc, 3, 3));
    if (!made && !create_software(w, desc)) {
        snprintf(reason, reason_size, "cannot create the window: %s", SDL_GetError());
        SDL_QuitSubSystem(SDL_INIT_VIDEO | SDL_INIT_EVENTS);
        return false;
    }
    if (w->gl != NULL && w->version >= 45) {
        create_worker(w);
    }
    SDL_SetWindowMinimumSize(w->handle, WIDTH_MIN, HEIGHT_MIN);
    (void)window_measure(w);
    w->scale = desc->scale > 0.0f ? desc->scale : fmaxf(display_scale(), w->density);
    return true;
}

void window_destroy(window* w)
{
    if (w->worker != NULL) {
        SDL_GL_DeleteContext(w->worker);
    }
    if (w->worker_window != NULL) {
        SDL_DestroyWindow(w->worker_window);
    }
    if (w->streamed != NULL) {
        SDL_DestroyTexture(w->streamed);
    }
    if (w->renderer != NULL) {
        SDL_DestroyRenderer(w->renderer);
    }
    if (w->texture != 0) {
        w->functions->delete_textures(1, &w->texture);
    }
    if (w->gl != NULL) {
        SDL_GL_DeleteContext(w->gl);
    }
    if (w->handle != NULL) {
        SDL_DestroyWindow(w->handle);
    }
    free(w->functions);
    *w = (window){0};
}

bool window_measure(window* w)
{
    int width = 0, height = 0, units = 0, other = 0;
    if (w->gl != NULL) {
        SDL_GL_GetDrawableSize(w->handle, &width, &height);
    } else if (SDL_GetRendererOutputSize(w->renderer, &width, &height) != 0) {
        return false;
    }
    SDL_GetWindowSize(w->handle, &units, &other);
    width = width > 0 ? width : 1;
    height = height > 0 ? height : 1;
    w->density = units > 0 ? (float)width / (float)units : 1.0f;
    bool changed = width != w->width || height != w->height;
    w->width = width;
    w->height = height;
    return changed;
}

static bool upload_gl(window* w, const stp_image* image)
{
    const window_gl* gl = w->functions;
    if (w->texture == 0) {
        gl->gen_textures(1, &w->texture);
    }
    gl->bind_texture(GL_TEXTURE_2D, w->texture);
    GLsizei width = (GLsizei)image->width, height = (GLsizei)image->height;
    if (w->texture_width != image->width || w->texture_height != image->height) {
        while (gl->get_error() != GL_NO_ERROR) {
        }
        gl->tex_parameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, GL_LINEAR);
        gl->tex_parameteri(GL_TEXTURE_2D, GL_TEXTURE_MAG_FILTER, GL_LINEAR);
        gl->tex_parameteri(GL_TEXTURE_2D, GL_TEXTURE_WRAP_S, GL_CLAMP_TO_EDGE);
        gl->tex_parameteri(GL_TEXTURE_2D, GL_TEXTURE_WRAP_T, GL_CLAMP_TO_EDGE);
        gl->tex_image(GL_TEXTURE_2D, 0, GL_RGBA8, width, height, 0, GL_RGBA, GL_UNSIGNED_BYTE,
                      image->pixels);
        return gl->get_error() == GL_NO_ERROR;
    }
    gl->tex_sub_image(GL_TEXTURE_2D, 0, 0, 0, width, height, GL_RGBA, GL_UNSIGNED_BYTE,
                      image->pixels);
    return true;
}

static bool upload_software(window* w, const stp_image* image)
{
    if (w->texture_width != image->width || w->texture_height != image->height) {
        if (w->streamed != NULL) {
            SDL_DestroyTexture(w->streamed);
        }
        w->streamed =
            SDL_CreateTexture(w->renderer, SDL_PIXELFORMAT_RGBA32, SDL_TEXTUREACCESS_STREAMING,
                              (int)image->width, (int)image->height);
        if (w->streamed == NULL) {
            return false;
        }
        SDL_SetTextureBlendMode(w->streamed, SDL_BLENDMODE_NONE);
    }
    return SDL_UpdateTexture(w->streamed, NULL, image->pixels, (int)(4 * image->width)) == 0;
}

bool window_upload(window* w, const stp_image* image)
{
    assert(image->width > 0 && image->height > 0 && "0 marks a texture that was not made");
    bool done = w->gl != NULL ? upload_gl(w, image) : upload_software(w, image);
    w->borrowed = 0;
    w->texture_width = done ? image->width : 0;
    w->texture_height = done ? image->height : 0;
    return done;
}

void window_borrow(window* w, uint32_t texture)
{
    w->borrowed = texture;
}

bool window_begin_worker(void* user)
{
    window* w = user;
    return w->worker != NULL && SDL_GL_MakeCurrent(w->worker_window, w->worker) == 0;
}

void window_end_worker(void* user)
{
    window* w = user;
    SDL_GL_MakeCurrent(w->worker_window, NULL);
}

void (*window_get_proc_address(const char* name, void* user))(void)
{
    (void)user;
    void* address = SDL_GL_GetProcAddress(name);
    void (*function)(void);
    memcpy(&function, &address, sizeof(function));
    return function;
}

void* window_picture(const window* w)
{
    if (w->borrowed != 0) {
        return (void*)(uintptr_t)w->borrowed;
    }
    return w->texture_width == 0 ? NULL
           : w->gl != NULL       ? (void*)(uintptr_t)w->texture
                                 : w->streamed;
}

void window_clear(window* w)
{
    if (w->gl != NULL) {
        w->functions->viewport(0, 0, w->width, w->height);
        w->functions->clear_color(0.10f, 0.11f, 0.12f, 1.0f);
        w->functions->clear(GL_COLOR_BUFFER_BIT);
    } else {
        SDL_SetRenderDrawColor(w->renderer, 26, 28, 31, 255);
        SDL_RenderClear(w->renderer);
    }
}

void window_show(window* w)
{
    if (w->gl != NULL) {
        SDL_GL_SwapWindow(w->handle);
    } else {
        SDL_RenderPresent(w->renderer);
    }
    // a renderer on the processor does not wait for the display: it would draw frames that nobody
    // sees
    uint64_t now = SDL_GetTicks64(), passed = now - w->shown_ms;
    if (!w->is_hardware && passed < FRAME_MS) {
        SDL_Delay((uint32_t)(FRAME_MS - passed));
    }
    w->shown_ms = SDL_GetTicks64();
}

void window_finish(window* w)
{
    if (w->gl != NULL) {
        w->functions->finish();
    }
    // the display's server handles requests in their order, and answers this one
    int top, left, bottom, right;
    (void)SDL_GetWindowBordersSize(w->handle, &top, &left, &bottom, &right);
}
