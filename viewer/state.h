// SPDX-License-Identifier: MIT
// What the parts of the viewer share: the state of the window. All of it belongs to the window's thread.
#pragma once

#include "loader.h"
#include "painter.h"
#include "viewer.h"
#include "window.h"

#include "present/navigate.h"

enum {
    FRAME_HISTORY = 120,
    PATH_ROOM = 4096,
};

/// What a pressed mouse button does.
typedef enum drag_kind { DRAG_NONE, DRAG_ORBIT, DRAG_PAN, DRAG_LOOK } drag_kind;

typedef struct input_state {
    drag_kind drag;
    int button;             ///< that was pressed on the picture; 0: none
    float start_x, start_y; ///< pixels of the window
    float last_x, last_y;
    bool moved;       ///< it is no click any more
    double pan_depth; ///< of what the hand holds
    SDL_GameController* pad;
    bool flies; ///< keys or sticks move the camera
} input_state;

/// Part of the window, in pixels.
typedef struct viewer_area {
    float x, y, width, height;
} viewer_area;

typedef struct viewer {
    viewer_options options;
    viewer_settings settings;
    window window;
    loader* loader;
    painter* painter;
    uint32_t wake_event;
    bool quits;
    int dirty;      ///< so many frames of the window are still to be shown
    uint64_t shows; ///< frames shown
    double last_ms; ///< of the last step
    viewer_area picture_area;
    // the scene
    loader_news news;
    char file[PATH_ROOM];                    ///< that is shown or loaded
    uint32_t opening;                        ///< serial that the painter opens
    uint32_t file_number, shown_file_number; ///< files so far; the one that is shown
    const painter_scene* scene;
    const painter_picture* picture;
    uint64_t request;
    // the camera
    stp_navigator camera, glide_from, glide_to;
    double glide_start; ///< negative: it does not glide
    bool has_camera;
    input_state input;
    // the panels
    bool shows_help, shows_panels;
    float frame_times[FRAME_HISTORY];
    int newest_time;
    char message[512];
    bool message_is_error;
    double message_ms; ///< when it came
    double report_ms;  ///< when a report was written
    bool report_rests; ///< what it said
} viewer;

// viewer.c
void viewer_redraw(viewer* v);
void viewer_open(viewer* v, const char* path);
void viewer_say(viewer* v, bool is_error, const char* format, ...)
    __attribute__((format(printf, 3, 4)));
/// Whether everything stands still: the picture is the best there is of what is asked.
bool viewer_rests(const viewer* v);

// camera.c
void camera_begin(viewer* v); ///< of a new scene
/// Begins a movement of the camera to another place.
void camera_glide(viewer* v, const stp_navigator* to);
void camera_step(viewer* v, double seconds);
void camera_face(viewer* v, const char* name);
void camera_frame(viewer* v);
void camera_switch_projection(viewer* v);
/// What the picture shows at a place of the window. @return false where that is nothing
bool camera_seen(const viewer* v, float x, float y, stp_vec3d* point);
/// The camera of the picture that is shown. @return false where there is none
bool camera_of_picture(const viewer* v, stp_navigator* n);
stp_boxd camera_scene_box(const viewer* v);

// input.c
void input_take(viewer* v, const SDL_Event* event);
/// Moves the camera by keys and sticks that are held.
void input_step(viewer* v, double seconds);
void input_destroy(viewer* v);

// panels.c
/// Where the panels leave room for the picture.
viewer_area panels_layout(const viewer* v);
void panels_show(viewer* v);

// pages.c
void page_statistics(viewer* v);
void page_quality(viewer* v);

// request.c
paint_request request_make(const viewer* v);

// report.c
/// Writes what is shown where that changed; at once where `last`.
void report_write(viewer* v, bool last);
