// SPDX-License-Identifier: MIT
// Attaching and detaching gamepads: SDL's virtual ones, which need neither a device nor a display.
#include "tests.h"

#include "program/viewer/model/gamepad.h"

#include <math.h>

enum { AXES = 6, BUTTONS = 15 };

static int attach(void)
{
    return SDL_JoystickAttachVirtual(SDL_JOYSTICK_TYPE_GAMECONTROLLER, AXES, BUTTONS, 0);
}

/// Like the viewer's loop: handles all pending events. @return the gamepad in use
static SDL_JoystickID take_all(SDL_GameController** pad)
{
    SDL_Event event;
    SDL_GameControllerUpdate();
    while (SDL_PollEvent(&event)) {
        (void)gamepad_take(pad, &event);
    }
    return *pad != NULL ? SDL_JoystickInstanceID(SDL_GameControllerGetJoystick(*pad)) : -1;
}

/// @return false if SDL cannot make virtual gamepads, or there are real ones
static bool begin(test_state* test)
{
    gamepad_begin();
    if (SDL_WasInit(SDL_INIT_GAMECONTROLLER) == 0 || SDL_NumJoysticks() > 0) {
        SDL_GameController* none = NULL;
        gamepad_end(&none);
        test->skipped = "there are gamepads, or none can be made";
        return false;
    }
    return true;
}

void test_viewer_gamepad_is_replaced_when_it_disconnects(test_state* test)
{
    SDL_GameController* pad = NULL;
    if (!begin(test)) {
        return;
    }
    CHECK_EQUAL(-1, take_all(&pad));
    int first = attach();
    SDL_JoystickID first_id = SDL_JoystickGetDeviceInstanceID(first);
    CHECK(first >= 0);
    CHECK_EQUAL(first_id, take_all(&pad));
    SDL_JoystickID second_id = SDL_JoystickGetDeviceInstanceID(attach());
    SDL_JoystickID third_id = SDL_JoystickGetDeviceInstanceID(attach());
    CHECK(second_id != first_id && third_id != second_id);
    CHECK_EQUAL(first_id, take_all(&pad)); // attaching another one changes nothing
    CHECK_EQUAL(0, SDL_JoystickDetachVirtual(2));
    CHECK_EQUAL(first_id, take_all(&pad)); // nor does detaching another one
    CHECK_EQUAL(0, SDL_JoystickDetachVirtual(0));
    CHECK_EQUAL(second_id, take_all(&pad));
    CHECK_EQUAL(0, SDL_JoystickDetachVirtual(0));
    CHECK_EQUAL(-1, take_all(&pad));
    // detached before its event was handled
    CHECK(attach() == 0 && SDL_JoystickDetachVirtual(0) == 0);
    SDL_JoystickID last_id = SDL_JoystickGetDeviceInstanceID(attach());
    CHECK_EQUAL(last_id, take_all(&pad));
    CHECK_EQUAL(0, SDL_JoystickDetachVirtual(0));
    gamepad_end(&pad);
    CHECK(pad == NULL);
}

void test_viewer_gamepad_sticks_move_beyond_a_hand_at_rest(test_state* test)
{
    static const Sint16 axes[AXES] = {32767, 32767, 2000, -16384, -32768, 32767};
    SDL_GameController* pad = NULL;
    if (!begin(test)) {
        return;
    }
    gamepad_sticks none = gamepad_read(NULL);
    CHECK(none.moves[0] == 0.0 && none.turn == 0.0);
    (void)attach();
    CHECK(take_all(&pad) >= 0);
    SDL_Joystick* stick = SDL_GameControllerGetJoystick(pad);
    for (int i = 0; i < AXES; ++i) {
        CHECK_EQUAL(0, SDL_JoystickSetVirtualAxis(stick, i, axes[i]));
    }
    (void)take_all(&pad);
    gamepad_sticks sticks = gamepad_read(pad);
    CHECK(sticks.moves[0] == 1.0 && sticks.moves[1] == 1.0 && sticks.moves[2] == -1.0);
    CHECK(sticks.turn == 0.0); // within the dead zone
    CHECK(fabs(sticks.nod + 0.412) < 0.001);
    CHECK_EQUAL(0, SDL_JoystickDetachVirtual(0));
    gamepad_end(&pad);
}
