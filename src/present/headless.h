// SPDX-License-Identifier: MIT
//
// OpenGL without a window or a display server, through EGL. EGL is opened when it is asked for: a program that never asks
// runs where there is none.
#pragma once

#include <stdbool.h>

typedef struct stp_headless_desc {
    bool software;      ///< drawn by the processor, whatever there is
    bool only_hardware; ///< no context rather than one drawn by the processor
    bool debug;         ///< a debug context: it says what is wrong
} stp_headless_desc;

/// An OpenGL 4.5 core context. All zero at first.
typedef struct stp_headless {
    void *library, *display, *context;
    bool is_software;
    char device[160]; ///< what it calls itself
    void (*(*get_proc_address)(const char* name))(void);
} stp_headless;

/// Makes a context and makes it current on the calling thread. A graphics processor is taken before a software one.
/// @return NULL, or why there is none; then there is nothing to destroy
const char* stp_headless_create(const stp_headless_desc* desc, stp_headless* headless);
/// On the thread where the context is current; all made in it must be gone.
void stp_headless_destroy(stp_headless* headless);

/// For stp_draw_gl_desc: `user` is the stp_headless.
void (*stp_headless_get_proc_address(const char* name, void* user))(void);
