// SPDX-License-Identifier: MIT
//
// Standard views look along a fixed direction, from just far enough to see the whole box, whose middle is
// the middle of the picture.
//
// "d0".."d25" are for judging approximations from where they were not captured: the capture looks from the
// corners of a cube, and from its faces and edges for what the corners miss. Directions to these 26 cut the sphere
// into 48 equal triangles; d0 to d25 are the middles of 26 of them (the 24 that turn into each other, and two of
// the others), 20 degrees from the nearest edge, 32 from a face and 27 from a corner.
#include "present/camera.h"

#include <string.h>

#define A                                                                                          \
    0.85125413593678223 // the middle of the triangle (1, 0, 0), (1, 1, 0), (1, 1, 1) on the sphere
#define B 0.47862549063280974
#define C 0.21513724867401407

typedef struct standard_view {
    const char* name;
    stp_vec3d toward; ///< from the middle to the eye
    stp_vec3d up;
} standard_view;

static const standard_view views[] = {
    {"front", {0, 0, 1}, {0, 1, 0}},   {"back", {0, 0, -1}, {0, 1, 0}},
    {"left", {-1, 0, 0}, {0, 1, 0}},   {"right", {1, 0, 0}, {0, 1, 0}},
    {"top", {0, 1, 0}, {0, 0, -1}},    {"bottom", {0, -1, 0}, {0, 0, 1}},
    {"iso", {1, 0.8, 1.2}, {0, 1, 0}}, {"d0", {A, B, C}, {0, 1, 0}},
    {"d1", {A, -B, -C}, {0, 1, 0}},    {"d2", {-A, B, -C}, {0, 1, 0}},
    {"d3", {-A, -B, C}, {0, 1, 0}},    {"d4", {B, C, A}, {0, 1, 0}},
    {"d5", {B, -C, -A}, {0, 1, 0}},    {"d6", {-B, C, -A}, {0, 1, 0}},
    {"d7", {-B, -C, A}, {0, 1, 0}},    {"d8", {C, A, B}, {0, 1, 0}},
    {"d9", {C, -A, -B}, {0, 1, 0}},    {"d10", {-C, A, -B}, {0, 1, 0}},
    {"d11", {-C, -A, B}, {0, 1, 0}},   {"d12", {B, A, -C}, {0, 1, 0}},
    {"d13", {B, -A, C}, {0, 1, 0}},    {"d14", {-B, A, C}, {0, 1, 0}},
    {"d15", {-B, -A, -C}, {0, 1, 0}},  {"d16", {A, C, -B}, {0, 1, 0}},
    {"d17", {A, -C, B}, {0, 1, 0}},    {"d18", {-A, C, B}, {0, 1, 0}},
    {"d19", {-A, -C, -B}, {0, 1, 0}},  {"d20", {C, B, -A}, {0, 1, 0}},
    {"d21", {C, -B, A}, {0, 1, 0}},    {"d22", {-C, B, A}, {0, 1, 0}},
    {"d23", {-C, -B, -A}, {0, 1, 0}},  {"d24", {B, A, C}, {0, 1, 0}},
    {"d25", {-A, -B, -C}, {0, 1, 0}},
};
enum { VIEW_COUNT = sizeof(views) / sizeof(views[0]) };

static const double filled = 0.94; // share of the picture that the box may reach

const char* const* stp_camera_names(void)
{
    static const char* const names[] = {
        "front", "back", "left", "right", "top", "bottom", "iso", "d0",  "d1",  "d2",  "d3",  "d4",
        "d5",    "d6",   "d7",   "d8",    "d9",  "d10",    "d11", "d12", "d13", "d14", "d15", "d16",
        "d17",   "d18",  "d19",  "d20",   "d21", "d22",    "d23", "d24", "d25", NULL,
    };
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

bool stp_camera_frame(const char* name, const stp_boxd* box, stp_view* view)
{
    const standard_view* standard = find(name);
    if (standard == NULL) {
        return false;
    }
    stp_boxd unit = {{-1, -1, -1}, {1, 1, 1}};
    stp_boxd b = stp_boxd_is_empty(*box) ? unit : *box;
    stp_vec3d center = stp_scaled(stp_addd(b.min, b.max), 0.5);
    stp_vec3d half = stp_scaled(stp_subd(b.max, b.min), 0.5);
    stp_vec3d toward = stp_normalized(standard->toward);
    stp_vec3d right = stp_normalized(stp_crossd(standard->up, toward));
    stp_vec3d up = stp_crossd(toward, right);
    view->fov_degrees = view->fov_degrees > 0.0 ? view->fov_degrees : 60.0;
    double aspect = (double)view->width / (double)view->height;
    aspect = view->eye_distance > 0.0 ? 0.5 * aspect : aspect; // each eye's half
    double slope_y = filled * tan(view->fov_degrees * (STP_PI / 360.0)), slope_x = slope_y * aspect;
    // The middle of the box is the middle of the picture; each corner must be within the picture's four planes
    // through the eye: |x| <= slope (D - z) at distance D, z towards the eye.
    double distance = 0.0, height = 0.0;
    for (int corner = 0; corner < 8; ++corner) {
        stp_vec3d p = {(corner & 1) != 0 ? half.x : -half.x, (corner & 2) != 0 ? half.y : -half.y,
                       (corner & 4) != 0 ? half.z : -half.z};
        double x = stp_dotd(right, p), y = stp_dotd(up, p), z = stp_dotd(toward, p);
        distance = fmax(distance, z + fmax(fabs(x) / slope_x, fabs(y) / slope_y));
        height = fmax(height, 2.0 * fmax(fabs(y), fabs(x) / aspect) / filled);
    }
    distance = distance > 0.0 ? distance : 1.0; // a single point
    if (view->ortho_height > 0.0) {
        view->ortho_height = height > 0.0 ? height : 1.0;
        distance = 2.0 * sqrt(stp_dotd(half, half));
        distance = distance > 0.0 ? distance : 1.0;
    }
    view->eye = stp_addd(center, stp_scaled(toward, distance));
    view->target = center;
    view->up = up;
    return true;
}
