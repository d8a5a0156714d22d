// SPDX-License-Identifier: MIT
#include "tests.h"

#include "present/camera.h"
#include "select/view_frame.h"

#include <string.h>

void test_camera_frames_every_box(test_state* test)
{
    const stp_boxd boxes[] = {{{-1, -1, -1}, {1, 1, 1}},
                              {{100, 0, -3}, {140, 1, 9}},
                              {{5e5, 0, 5e5}, {5e5 + 3, 80, 5e5 + 7}},
                              {{0, 0, 0}, {10, 0, 10}}};
    for (int i = 0; i < 4; ++i) {
        for (const char* const* name = stp_camera_names(); *name != NULL; ++name) {
            for (int mode = 0; mode < 3; ++mode) {
                stp_view view = {.width = mode == 1 ? 300 : 640,
                                 .height = mode == 1 ? 500 : 360,
                                 .ortho_height = mode == 2 ? 1 : 0};
                CHECK(stp_camera_frame(*name, &boxes[i], &view));
                stp_view_frame frame;
                CHECK(stp_view_frame_make(&view, &frame));
                double low_x = 1e9, high_x = -1e9, low_y = 1e9, high_y = -1e9;
                for (int corner = 0; corner < 8; ++corner) {
                    const stp_boxd* b = &boxes[i];
                    stp_vec3d p = {(corner & 1) != 0 ? b->max.x : b->min.x,
                                   (corner & 2) != 0 ? b->max.y : b->min.y,
                                   (corner & 4) != 0 ? b->max.z : b->min.z};
                    stp_vec3d q = stp_subd(p, frame.eye);
                    double z = stp_dotd(q, frame.forward), w = frame.parallel ? 1.0 : z;
                    CHECK(z > 0.0);
                    double x =
                        (frame.center_x + frame.scale * stp_dotd(q, frame.right) / w) / frame.width;
                    double y =
                        (frame.center_y + frame.scale * stp_dotd(q, frame.down) / w) / frame.height;
                    low_x = fmin(low_x, x);
                    high_x = fmax(high_x, x);
                    low_y = fmin(low_y, y);
                    high_y = fmax(high_y, y);
                }
                // all of it is in the picture, and a corner reaches nearly to the picture's edge
                CHECK(low_x > 0.02 && high_x < 0.98 && low_y > 0.02 && high_y < 0.98);
                CHECK(low_x < 0.05 || high_x > 0.95 || low_y < 0.05 || high_y > 0.95);
                stp_vec3d middle = stp_scaled(stp_addd(boxes[i].min, boxes[i].max), 0.5);
                stp_vec3d gaze = stp_normalized(stp_subd(middle, frame.eye));
                CHECK(stp_dotd(gaze, frame.forward) > 1.0 - 1e-9);
            }
        }
    }
}

void test_camera_directions_are_what_they_are_called(test_state* test)
{
    stp_boxd box = {{-1, -2, -3}, {1, 2, 3}};
    const struct {
        const char* name;
        stp_vec3d toward;
    } cases[] = {{"front", {0, 0, 1}}, {"back", {0, 0, -1}}, {"left", {-1, 0, 0}},
                 {"right", {1, 0, 0}}, {"top", {0, 1, 0}},   {"bottom", {0, -1, 0}}};
    for (int i = 0; i < 6; ++i) {
        stp_view view = {.width = 100, .height = 100};
        CHECK(stp_camera_frame(cases[i].name, &box, &view));
        stp_vec3d toward = stp_normalized(stp_subd(view.eye, view.target));
        CHECK(stp_dotd(toward, cases[i].toward) > 0.999999);
        CHECK(view.fov_degrees == 60.0);
    }
    stp_view view = {.width = 100, .height = 100, .fov_degrees = 30};
    CHECK(stp_camera_frame("iso", &box, &view) && view.fov_degrees == 30.0);
    CHECK(!stp_camera_frame("nowhere", &box, &view) && !stp_camera_frame("d26", &box, &view));
    stp_boxd empty = stp_boxd_empty(), point = {{1, 1, 1}, {1, 1, 1}};
    stp_view_frame frame;
    CHECK(stp_camera_frame("iso", &empty, &view) && stp_view_frame_make(&view, &frame));
    CHECK(stp_camera_frame("iso", &point, &view) && stp_view_frame_make(&view, &frame));
}

void test_camera_judging_directions_avoid_what_was_captured(test_state* test)
{
    stp_boxd box = {{-1, -1, -1}, {1, 1, 1}};
    stp_vec3d seen[26];
    for (int i = 0; i < 26; ++i) {
        char name[8];
        snprintf(name, sizeof(name), "d%d", i);
        stp_view view = {.width = 100, .height = 100, .ortho_height = 1};
        CHECK(stp_camera_frame(name, &box, &view));
        seen[i] = stp_normalized(stp_subd(view.eye, view.target));
        for (int code = 0; code < 27; ++code) { // corners, faces and edges of a cube
            stp_vec3d c = {code % 3 - 1, code / 3 % 3 - 1, code / 9 - 1};
            CHECK(stp_dotd(seen[i], stp_normalized(c)) < 0.941); // 19.8 degrees or more
        }
        for (int k = 0; k < i; ++k) {
            CHECK(stp_dotd(seen[i], seen[k]) < 0.94); // 20 degrees apart
        }
    }
}
