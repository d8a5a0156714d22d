// SPDX-License-Identifier: MIT
// The viewer's camera: position and movements.
#include "base/core/clock.h"
#include "program/viewer/panels/panels.h"

#include <assert.h>
#include <stdlib.h>

static const double glide_ms = 350.0;

enum { SEEN_COLUMNS = 24, SEEN_ROWS = 14 }; ///< grid of depth samples over the picture

stp_boxd camera_scene_box(const viewer* v)
{
    return v->scene != NULL ? v->scene->bounds : stp_boxd_empty();
}

void camera_begin(viewer* v)
{
    stp_boxd box = camera_scene_box(v);
    v->picture_area = panels_layout(v); // beside the panels of this scene, not those of an empty
                                        // window
    uint32_t width = (uint32_t)v->picture_area.width, height = (uint32_t)v->picture_area.height;
    stp_navigator_init(&v->camera, &box, width, height);
    const char* name = v->options.view;
    (void)framing_face(v, "iso", &v->camera);
    if (name != NULL) {
        stp_view view = {.width = v->camera.width, .height = v->camera.height};
        if (tool_find_stored_view(v->scene->store, name, &view)) {
            stp_navigator_read_view(&v->camera, &view);
        } else if (!framing_face(v, name, &v->camera) && !views_begin_at(v, name)) {
            viewer_show_message(v, true, "there is no view named %s", name);
        }
        v->options.view = NULL; // only for the first file
    }
    v->has_camera = true;
    v->glide_start = -1.0;
}

void camera_glide(viewer* v, const stp_navigator* to)
{
    v->glide_from = v->camera;
    v->glide_to = *to;
    v->glide_start = stp_clock_ms();
}

bool camera_of_picture(const viewer* v, stp_navigator* n)
{
    if (v->picture == NULL || v->scene == NULL || v->picture->scene != v->scene->serial) {
        return false;
    }
    *n = v->camera;
    stp_navigator_read_view(n, &v->picture->view);
    n->width = v->picture->view.width;
    n->height = v->picture->view.height;
    return true;
}

/// Depth along the view direction at a pixel; 0 if there is nothing or the depth is not known.
static double depth_at(const painter_picture* picture, uint32_t x, uint32_t y)
{
    assert(x < picture->image.width && y < picture->image.height);
    double nearness = (double)picture->nearness[(size_t)y * picture->image.width + x];
    return nearness > 0.0 && !(picture->view.ortho_height > 0.0) ? picture->near_distance / nearness
                                                                 : 0.0;
}

bool camera_seen(const viewer* v, float x, float y, stp_vec3d* point)
{
    stp_navigator n;
    if (!camera_of_picture(v, &n) || !(v->picture_area.width > 0.0f)) {
        return false;
    }
    const stp_image* image = &v->picture->image;
    double px = (double)((x - v->picture_area.x) / v->picture_area.width) * (double)image->width;
    double py = (double)((y - v->picture_area.y) / v->picture_area.height) * (double)image->height;
    if (!(px >= 0.0) || !(py >= 0.0) || px >= (double)image->width || py >= (double)image->height) {
        return false;
    }
    // clicks are not exact to the pixel, so thin objects also match next to it
    double nearest = 0.0, best = HUGE_VAL;
    for (int dy = -3; dy <= 3; ++dy) {
        for (int dx = -3; dx <= 3; ++dx) {
            int ix = (int)px + dx, iy = (int)py + dy, away = dx * dx + dy * dy;
            if (ix < 0 || iy < 0 || ix >= (int)image->width || iy >= (int)image->height) {
                continue;
            }
            double depth = depth_at(v->picture, (uint32_t)ix, (uint32_t)iy);
            if (depth > 0.0 && (double)away < best) {
                best = (double)away;
                nearest = depth;
            }
        }
    }
    if (nearest > 0.0) {
        *point = stp_navigator_point(&n, px, py, nearest);
    }
    return nearest > 0.0;
}

static int compare_numbers(const void* a, const void* b)
{
    double x = *(const double*)a, y = *(const double*)b;
    return (x > y) - (x < y);
}

/// Distance to the visible content, nearer than most of it. 0: nothing is visible.
static double seen_distance(const viewer* v)
{
    double depths[SEEN_COLUMNS * SEEN_ROWS];
    size_t count = 0;
    const stp_image* image = &v->picture->image;
    for (uint32_t row = 0; row < SEEN_ROWS; ++row) {
        for (uint32_t column = 0; column < SEEN_COLUMNS; ++column) {
            double depth =
                depth_at(v->picture, (2 * column + 1) * image->width / (2 * SEEN_COLUMNS),
                         (2 * row + 1) * image->height / (2 * SEEN_ROWS));
            if (depth > 0.0) {
                depths[count++] = depth;
            }
        }
    }
    if (count < 4) {
        return 0.0;
    }
    qsort(depths, count, sizeof(depths[0]), compare_numbers);
    return depths[count / 4];
}

void camera_step(viewer* v, double seconds)
{
    if (v->glide_start >= 0.0) {
        double part = (stp_clock_ms() - v->glide_start) / glide_ms;
        part = part < 1.0 ? part * part * (3.0 - 2.0 * part) : 1.0;
        uint32_t width = v->camera.width, height = v->camera.height;
        v->camera = stp_navigator_mix(&v->glide_from, &v->glide_to, part);
        v->camera.width = width;
        v->camera.height = height;
        if (part >= 1.0) {
            v->glide_start = -1.0;
        }
    } else if (v->input.flies && v->picture != NULL && v->scene != NULL &&
               v->picture->scene == v->scene->serial) {
        stp_navigator_adapt_speed(&v->camera, seen_distance(v), seconds);
    }
}

void camera_face(viewer* v, const char* name)
{
    stp_navigator to = v->camera;
    if (v->scene != NULL && framing_face(v, name, &to)) {
        camera_glide(v, &to);
    }
}

void camera_frame(viewer* v, bool level)
{
    stp_navigator to = v->camera;
    to.roll = level ? 0.0 : to.roll;
    if (v->scene != NULL) {
        framing_frame(v, &to);
        camera_glide(v, &to);
    }
}

void camera_switch_projection(viewer* v)
{
    v->glide_start = -1.0;
    stp_navigator_switch_projection(&v->camera);
}
