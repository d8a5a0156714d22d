// SPDX-License-Identifier: MIT
//
// OpenGL without a window or a display server, through EGL. EGL is loaded on first use: programs
// that do not use it run on systems without it.
#pragma once

#include <stdbool.h>

typedef struct stp_headless_desc {
    bool software;      ///< software rendering, even if there is a GPU
    bool only_hardware; ///< fail rather than use a software renderer
    bool debug;         ///< a debug context, which reports errors
} stp_headless_desc;

/// An OpenGL 4.5 core context. Initialise to zero.
typedef struct stp_headless {
    void *library, *display, *context;
    bool is_software;
    char device[160]; ///< device name as reported by the driver
    void (*(*get_proc_address)(const char* name))(void);
} stp_headless;

/// Creates a context and makes it current on the calling thread. Prefers a GPU to a software
/// renderer.
/// @return NULL, or the reason of failure; then there is nothing to destroy
const char* stp_headless_create(const stp_headless_desc* desc, stp_headless* headless);
/// Call on the thread where the context is current, after destroying everything created in it.
void stp_headless_destroy(stp_headless* headless);

/// For stp_draw_gl_desc; `user` is the stp_headless.
void (*stp_headless_get_proc_address(const char* name, void* user))(void);
