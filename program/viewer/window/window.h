// SPDX-License-Identifier: MIT
// The viewer's window and the scene picture in it: with OpenGL if available, else drawn by SDL.
#pragma once

#include <stipple/image.h>

#include <SDL.h>
#include <stdbool.h>

typedef struct window_gl window_gl;

typedef struct window {
    SDL_Window* handle;
    SDL_GLContext gl;       ///< NULL: SDL draws
    SDL_Renderer* renderer; ///< NULL: OpenGL draws
    window_gl* functions;
    int version;       ///< version of OpenGL: 45 for 4.5
    char device[128];  ///< device that draws the window
    int width, height; ///< in pixels, which may differ from window units
    float density;     ///< pixels per window unit
    float scale;       ///< scale of text and distances, relative to their usual pixels
    // a second context, for the painter thread
    SDL_Window* worker_window;
    SDL_GLContext worker;
    bool has_worker;   ///< it has OpenGL 4.5
    bool is_hardware;  ///< OpenGL runs on a GPU
    uint64_t shown_ms; ///< when the last frame was shown
    // the picture
    uint32_t borrowed; ///< a texture of the worker context to show instead; 0: none
    uint32_t texture;
    SDL_Texture* streamed;
    uint32_t texture_width, texture_height;
} window;

typedef struct window_desc {
    const char* title;
    int width, height;
    bool software; ///< do not use OpenGL
    float scale;   ///< scale of text and distances; 0: that of the display
} window_desc;

/// @return false if no window can be created: the reason is in `reason`
bool window_create(window* w, const window_desc* desc, char* reason, size_t reason_size);
void window_destroy(window* w);
/// Updates the window's size. @return whether it changed
bool window_measure(window* w);

/// Uploads a picture to the texture. @return false if memory runs out
bool window_upload(window* w, const stp_image* image);
/// Shows a texture of the worker context from now on.
void window_borrow(window* w, uint32_t texture);
// Callbacks for the painter; `window` is the window.
bool window_begin_worker(void* window);
void window_end_worker(void* window);
void (*window_get_proc_address(const char* name, void* window))(void);
/// The picture, for gui_picture.
void* window_picture(const window* w);

void window_clear(window* w);
void window_show(window* w);
/// Waits until the display has what window_show was given last.
void window_finish(window* w);
