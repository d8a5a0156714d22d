// SPDX-License-Identifier: MIT
//
// Standard views look along a fixed direction from the position that stp_camera_fit chooses.
//
// "d0".."d25" judge approximations from directions that were not captured. The capture looks from
// the corners of a cube, and from its faces and edges for surface that the corners miss. These 26
// directions divide the sphere into 48 equal triangles; d0 to d25 are the middles of 26 of them (24
// that rotate into each other, and two of the others), 20 degrees from the nearest edge, 32 from a
// face and 27 from a corner.
#include "select/camera.h"

#include <assert.h>
#include <string.h>

/// The middle of the triangle (1, 0, 0), (1, 1, 0), (1, 1, 1) on the sphere
#define A 0.85125413593678223
#define B 0.47862549063280974
#define C 0.21513724867401407

typedef struct standard_view {
    const char* name;
    stp_vec3d toward; ///< from the centre to the eye
    stp_vec3d up;
} standard_view;

static const standard_view views[] = {
    {"front", {0, 0, 1}, {0, 1, 0}},  {"back", {0, 0, -1}, {0, 1, 0}},
    {"left", {-1, 0, 0}, {0, 1, 0}},  {"right", {1, 0, 0}, {0, 1, 0}},
    {"top", {0, 1, 0}, {0, 0, -1}},   {"bottom", {0, -1, 0}, {0, 0, 1}},
    {"iso", {1, 1, 1}, {0, 1, 0}},    {"d0", {A, B, C}, {0, 1, 0}},
    {"d1", {A, -B, -C}, {0, 1, 0}},   {"d2", {-A, B, -C}, {0, 1, 0}},
    {"d3", {-A, -B, C}, {0, 1, 0}},   {"d4", {B, C, A}, {0, 1, 0}},
    {"d5", {B, -C, -A}, {0, 1, 0}},   {"d6", {-B, C, -A}, {0, 1, 0}},
    {"d7", {-B, -C, A}, {0, 1, 0}},   {"d8", {C, A, B}, {0, 1, 0}},
    {"d9", {C, -A, -B}, {0, 1, 0}},   {"d10", {-C, A, -B}, {0, 1, 0}},
    {"d11", {-C, -A, B}, {0, 1, 0}},  {"d12", {B, A, -C}, {0, 1, 0}},
    {"d13", {B, -A, C}, {0, 1, 0}},   {"d14", {-B, A, C}, {0, 1, 0}},
    {"d15", {-B, -A, -C}, {0, 1, 0}}, {"d16", {A, C, -B}, {0, 1, 0}},
    {"d17", {A, -C, B}, {0, 1, 0}},   {"d18", {-A, C, B}, {0, 1, 0}},
    {"d19", {-A, -C, -B}, {0, 1, 0}}, {"d20", {C, B, -A}, {0, 1, 0}},
    {"d21", {C, -B, A}, {0, 1, 0}},   {"d22", {-C, B, A}, {0, 1, 0}},
    {"d23", {-C, -B, -A}, {0, 1, 0}}, {"d24", {B, A, C}, {0, 1, 0}},
    {"d25", {-A, -B, -C}, {0, 1, 0}},
};
enum { VIEW_COUNT = sizeof(views) / sizeof(views[0]) };

const char* const* stp_camera_names(void)
{
    static const char* const names[] = {
        "front", "back", "left", "right", "top", "bottom", "iso", "d0",  "d1",  "d2",  "d3",  "d4",
        "d5",    "d6",   "d7",   "d8",    "d9",  "d10",    "d11", "d12", "d13", "d14", "d15", "d16",
        "d17",   "d18",  "d19",  "d20",   "d21", "d22",    "d23", "d24", "d25", NULL,
    };
    assert(sizeof(names) / sizeof(names[0]) == VIEW_COUNT + 1 && "both tables have all views");
    return names;
}

static const standard_view* find(const char* name)
{
    for (size_t i = 0; i < VIEW_COUNT; ++i) {
        if (strcmp(views[i].name, name) == 0) {
            return &views[i];
        }
    }
    return NULL;
}

bool stp_camera_face(const char* name, stp_view* view)
{
    const standard_view* standard = find(name);
    if (standard == NULL) {
        return false;
    }
    stp_vec3d toward = stp_normalized(standard->toward);
    stp_vec3d right = stp_normalized(stp_crossd(standard->up, toward));
    view->eye = toward;
    view->target = (stp_vec3d){0};
    view->up = stp_crossd(toward, right);
    view->fov_degrees = view->fov_degrees > 0.0 ? view->fov_degrees : STP_CAMERA_FOV;
    return true;
}

bool stp_camera_frame(const char* name, const stp_boxd* box, stp_view* view)
{
    bool found = stp_camera_face(name, view);
    if (found) {
        stp_camera_fit(view, box);
    }
    return found;
}

bool stp_camera_is_standard(const char* name)
{
    return find(name) != NULL;
}
