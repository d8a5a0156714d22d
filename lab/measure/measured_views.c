// SPDX-License-Identifier: MIT
#include "lab/measure/measured_views.h"

#include "program/files/scene_file.h"
#include "select/camera.h"

#include <string.h>

bool measured_standard_view(const char* name, const stp_boxd* box, stp_view* view)
{
    view->fov_degrees = view->fov_degrees > 0.0 ? view->fov_degrees : STP_CAMERA_PLACED_FOV;
    if (!stp_camera_face(name, view)) {
        return false;
    }
    if (strcmp(name, "iso") == 0) {
        view->eye = (stp_vec3d){1.0, 0.8, 1.2};
        view->up = (stp_vec3d){0.0, 1.0, 0.0};
    }
    stp_camera_fit(view, box);
    return true;
}

bool measured_view(const stp_store* store, const char* name, stp_view* view)
{
    stp_boxd box = stp_visible_bounds(store, NULL);
    return tool_find_stored_view(store, name, view) || measured_standard_view(name, &box, view);
}
