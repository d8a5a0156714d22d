// SPDX-License-Identifier: MIT
#include "scene_file.h"

#include "present/camera.h"

#include <string.h>

stp_result tool_open_scene(stp_context* context, const char* path, stp_store** store)
{
    // names and ids are not needed for a picture, and can be most of a directory
    stp_store_open_desc desc = {.defer_objects = true};
    return stp_store_open_with(context, path, &desc, store);
}

bool tool_find_view(const stp_store* store, const char* name, stp_view* view)
{
    const stp_store_directory* directory = stp_store_get_directory(store);
    for (uint32_t i = 0; i < directory->view_count; ++i) {
        const stp_store_view* stored = &directory->views[i];
        if (stored->name != NULL && strcmp(stored->name, name) == 0) {
            view->eye = stored->eye;
            view->target = stored->target;
            view->up = stored->up;
            view->fov_degrees = view->fov_degrees > 0.0 ? view->fov_degrees : stored->fov_degrees;
            return true;
        }
    }
    stp_boxd box = directory->root != STP_STORE_NONE ? directory->nodes[directory->root].bounds
                                                     : stp_boxd_empty();
    return stp_camera_frame(name, &box, view);
}
