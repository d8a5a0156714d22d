// SPDX-License-Identifier: MIT
// Which of the gamepads that are attached flies: the first, and when that goes, one that is left.
#pragma once

#include <SDL.h>
#include <stdbool.h>

/// Asks SDL for gamepads; what is attached already comes as events. Without any the viewer has mouse and keys.
void gamepad_begin(void);

/// Takes in an event that a gamepad came or went. @return whether it was one
bool gamepad_take(SDL_GameController** pad, const SDL_Event* event);

/// Where sticks and triggers are, -1 to 1; what a hand at rest does is 0.
typedef struct gamepad_sticks {
    double moves[3];  ///< right, up, forward: left stick and triggers
    double turn, nod; ///< right stick: to the right, down
} gamepad_sticks;

/// Of no gamepad (NULL): all 0.
gamepad_sticks gamepad_read(SDL_GameController* pad);

/// NULL is allowed, and what there is then.
void gamepad_end(SDL_GameController** pad);
