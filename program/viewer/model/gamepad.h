// SPDX-License-Identifier: MIT
// Chooses the gamepad in use: the first attached one, and when it is detached, another.
#pragma once

#include <SDL.h>
#include <stdbool.h>

/// Starts gamepad support; attached gamepads are reported as events. Without any, the viewer uses
/// mouse and keyboard.
void gamepad_begin(void);

/// Handles an event that a gamepad was attached or detached. @return whether it was one
bool gamepad_take(SDL_GameController** pad, const SDL_Event* event);

/// Positions of sticks and triggers, -1 to 1; small deflections count as 0.
typedef struct gamepad_sticks {
    double moves[3];  ///< right, up, forward: left stick and triggers
    double turn, nod; ///< right stick: right, down
} gamepad_sticks;

/// Reads the gamepad; NULL gives all 0.
gamepad_sticks gamepad_read(SDL_GameController* pad);

/// NULL is allowed.
void gamepad_end(SDL_GameController** pad);
