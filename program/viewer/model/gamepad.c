// SPDX-License-Identifier: MIT
#include "program/viewer/model/gamepad.h"

#include <math.h>

static const double stick_dead = 0.15; // dead zone of a stick

void gamepad_begin(void)
{
    (void)SDL_InitSubSystem(SDL_INIT_GAMECONTROLLER);
}

/// Whether the detached device is the one in use; its index is no longer valid.
static bool is_ours(SDL_GameController* pad, SDL_JoystickID which)
{
    return pad != NULL && SDL_JoystickInstanceID(SDL_GameControllerGetJoystick(pad)) == which;
}

/// Opens the first gamepad that can be opened.
static SDL_GameController* open_any(void)
{
    SDL_GameController* pad = NULL;
    for (int i = 0; pad == NULL && i < SDL_NumJoysticks(); ++i) {
        pad = SDL_IsGameController(i) ? SDL_GameControllerOpen(i) : NULL;
    }
    return pad;
}

bool gamepad_take(SDL_GameController** pad, const SDL_Event* event)
{
    if (event->type == SDL_CONTROLLERDEVICEADDED) {
        *pad = *pad != NULL ? *pad : open_any(); // device indices in events may be stale
        return true;
    }
    if (event->type == SDL_CONTROLLERDEVICEREMOVED) {
        if (is_ours(*pad, event->cdevice.which)) {
            SDL_GameControllerClose(*pad);
            *pad = open_any();
        }
        return true;
    }
    return false;
}

static double axis(SDL_GameController* pad, SDL_GameControllerAxis which)
{
    double value = (double)SDL_GameControllerGetAxis(pad, which) / 32767.0;
    double size = fmin(fabs(value), 1.0);
    return size > stick_dead ? copysign((size - stick_dead) / (1.0 - stick_dead), value) : 0.0;
}

gamepad_sticks gamepad_read(SDL_GameController* pad)
{
    if (pad == NULL) {
        return (gamepad_sticks){.turn = 0.0};
    }
    return (gamepad_sticks){.moves = {axis(pad, SDL_CONTROLLER_AXIS_LEFTX),
                                      axis(pad, SDL_CONTROLLER_AXIS_TRIGGERRIGHT) -
                                          axis(pad, SDL_CONTROLLER_AXIS_TRIGGERLEFT),
                                      -axis(pad, SDL_CONTROLLER_AXIS_LEFTY)},
                            .turn = axis(pad, SDL_CONTROLLER_AXIS_RIGHTX),
                            .nod = axis(pad, SDL_CONTROLLER_AXIS_RIGHTY)};
}

void gamepad_end(SDL_GameController** pad)
{
    if (*pad != NULL) {
        SDL_GameControllerClose(*pad);
        *pad = NULL;
    }
    if (SDL_WasInit(SDL_INIT_GAMECONTROLLER) != 0) {
        SDL_QuitSubSystem(SDL_INIT_GAMECONTROLLER);
    }
}
