// SPDX-License-Identifier: MIT
#include "select/eyes.h"

#include "select/view_frame.h"

#include <assert.h>

stp_view stp_view_of_eye(const stp_view* view, uint32_t eye)
{
    stp_view one = *view;
    stp_view_frame frame;
    assert(eye < stp_view_eye_count(view));
    if (stp_view_eye_count(view) == 1) {
        return one;
    }
    one.eye_distance = 0.0;
    one.width /= 2;
    if (stp_view_frame_make(&one, &frame)) { // otherwise its user rejects it
        double side = eye == 0 ? -0.5 : 0.5;
        stp_vec3d shift = stp_scaled(frame.right, side * view->eye_distance);
        one.eye = stp_addd(view->eye, shift);
        one.target = stp_addd(view->target, shift);
    }
    return one;
}
