// SPDX-License-Identifier: MIT
// A SpaceMouse: a device with six axes, whose movements the daemon spacenavd sends through its
// socket. A thread waits for them, so nothing polls.
#pragma once

#include "program/present/navigate.h"

#include <stdbool.h>

enum { SPACE_MOUSE_FRAME = 1, SPACE_MOUSE_SWITCH = 2 }; ///< the first two buttons, as bits

typedef struct space_mouse space_mouse;

/// Movements since the last call of space_mouse_read.
typedef struct space_mouse_motion {
    stp_six_axes axes; ///< mean of the deflections; if there is no new one, the last
    bool moves;        ///< a deflection is not 0
    uint32_t pressed;  ///< buttons that went down: bit i is button i; others are left out
} space_mouse_motion;

/// Starts the thread, which connects to the daemon. Without a daemon it ends, and nothing moves.
/// There can be one SpaceMouse in a process. `wake` is called by the thread when there is something
/// to read. @return NULL if the viewer was built without libspnav, or if memory runs out
space_mouse* space_mouse_open(void (*wake)(void* user), void* user);
/// Ends the thread; `wake` is not called any more. NULL is allowed.
void space_mouse_close(space_mouse* m);

/// Takes what the device has sent. NULL gives all 0. After the daemon has gone away, nothing moves.
space_mouse_motion space_mouse_read(space_mouse* m);
/// Whether a daemon is connected. NULL gives false.
bool space_mouse_is_connected(space_mouse* m);
