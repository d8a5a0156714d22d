// SPDX-License-Identifier: MIT
// The viewer's window, and the picture of the scene in it: with OpenGL where there is any, else drawn by SDL.
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
    int version;       ///< of OpenGL: 45 for 4.5
    char device[128];  ///< what draws the window
    int width, height; ///< in pixels, which may be more than the window's units
    float density;     ///< pixels a unit
    float scale;       ///< of text and distances, in pixels
    // a second context, for the thread that draws
    SDL_Window* worker_window;
    SDL_GLContext worker;
    bool has_worker;  ///< of OpenGL 4.5
    bool is_hardware; ///< OpenGL is drawn by a graphics processor
    // the picture
    uint32_t borrowed; ///< a texture of the worker's that is shown instead; 0: none
    uint32_t texture;
    SDL_Texture* streamed;
    uint32_t texture_width, texture_height;
} window;

typedef struct window_desc {
    const char* title;
    int width, height;
    bool software; ///< no OpenGL
    float scale;   ///< of text; 0: the display's
} window_desc;

/// @return false where no window can be made: the reason is in `reason`
bool window_create(window* w, const window_desc* desc, char* reason, size_t reason_size);
void window_destroy(window* w);
/// Takes in the window's size. @return whether it changed
bool window_measure(window* w);

/// Makes a picture the texture. @return false where there is no room for it
bool window_upload(window* w, const stp_image* image);
/// Shows a texture of the worker's context from now on.
void window_borrow(window* w, uint32_t texture);
// For the painter; `window` is the window.
bool window_begin_worker(void* window);
void window_end_worker(void* window);
void (*window_get_proc_address(const char* name, void* window))(void);
/// The picture, for gui_picture.
void* window_picture(const window* w);

void window_clear(window* w);
void window_show(window* w);
/// What the window shows, from the top; `pixels` has room for width * height * 4 bytes. To be called before window_show.
bool window_read(window* w, uint8_t* pixels);
