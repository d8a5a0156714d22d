// SPDX-License-Identifier: MIT
// The SpaceMouse moves the camera or the model; its first two buttons frame and switch between them.
#include "program/viewer/panels/panels.h"

static void press_space_mouse(viewer* v, uint32_t pressed)
{
    if ((pressed & SPACE_MOUSE_FRAME) != 0) {
        camera_frame(v, true);
    }
    if ((pressed & SPACE_MOUSE_SWITCH) != 0) {
        v->settings.space_mouse_flies = !v->settings.space_mouse_flies;
        viewer_show_message(v, false,
                            v->settings.space_mouse_flies ? "The SpaceMouse moves the camera"
                                                          : "The SpaceMouse moves the model");
    }
}

bool space_mouse_step(viewer* v, double seconds)
{
    input_state* in = &v->input;
    space_mouse_motion motion = space_mouse_read(in->space_mouse);
    // the daemon tells all programs of each movement
    bool ours = (SDL_GetWindowFlags(v->window.handle) & SDL_WINDOW_INPUT_FOCUS) != 0;
    bool begins = !in->pushed;
    in->pushed = motion.moves && ours && v->has_camera;
    if (ours && motion.pressed != 0) {
        press_space_mouse(v, motion.pressed);
    }
    if (!in->pushed) {
        return false;
    }
    v->glide_start = -1.0;
    if (v->settings.space_mouse_flies) {
        stp_navigator_fly_six(&v->camera, &motion.axes, seconds);
        return true;
    }
    if (begins) {
        viewer_area a = v->picture_area;
        stp_vec3d point;
        bool seen = camera_seen(v, a.x + 0.5f * a.width, a.y + 0.5f * a.height, &point);
        stp_navigator_begin_orbit(&v->camera, seen ? &point : NULL);
    }
    stp_navigator_hold_six(&v->camera, &motion.axes, seconds);
    return false;
}
