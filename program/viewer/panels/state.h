// SPDX-License-Identifier: MIT
// The state of the window, shared by the parts of the viewer. Used by the window thread only.
#pragma once

#include "program/options/point_colors.h"
#include "program/present/flight.h"
#include "program/present/navigate.h"
#include "program/present/viewpoints.h"
#include "program/viewer/model/explorer.h"
#include "program/viewer/model/folder.h"
#include "program/viewer/model/loader.h"
#include "program/viewer/model/paint_thread.h"
#include "program/viewer/model/part_mask.h"
#include "program/viewer/model/path_list.h"
#include "program/viewer/model/space_mouse.h"
#include "program/viewer/panels/viewer.h"
#include "program/viewer/window/window.h"

// Colours of the scene's points, filter of classes, and properties of a clicked point.

/// Settings of one file; all zero: own colours, all classes.
typedef struct point_style {
    int color;          ///< point_color
    bool automatic;     ///< it follows from the file
    bool has_range;     ///< the user chose a range
    double low, high;   ///< ends of the colour scale, if `has_range`
    bool hides;         ///< some classes are not drawn
    uint8_t shown[256]; ///< visible classes, if `hides`
    uint32_t scene;     ///< serial of the scene that the elevations belong to; 0: unknown
    double elevation[2];
} point_style;

// The start page of a window without a file, and the file dialog.

typedef struct start_page start_page;
struct viewer;

/// Loads the list of recent files. @return NULL if memory runs out
start_page* start_create(void);
void start_destroy(start_page* s);
/// Makes an opened file the most recent one.
void start_opened(start_page* s, const char* path);
const recent_files* start_recent(const start_page* s);

/// Shows or hides the dialog.
void start_show_dialog(struct viewer* v, bool shown);
bool start_has_dialog(const struct viewer* v);
/// The folder shown by the dialog, and the text typed into it; "": none.
const char* start_folder(const struct viewer* v);
const char* start_typed(const struct viewer* v);
/// Number of entries that the dialog lists.
size_t start_listed(const struct viewer* v);
/// Opens a recent file; a missing file is removed from the list. @return false if there is no such
/// entry
bool start_open_recent(struct viewer* v, size_t index);

// Called for each frame of the window.
void start_dialog(struct viewer* v);
void start_show(struct viewer* v);

enum {
    FRAME_HISTORY = 120,
    PATH_ROOM = 4096,
    SECTION_PLANES = 8, ///< maximum, in addition to a box
    MEASURE_POINTS = 64,
    MESSAGES = 4, ///< maximum number of unread messages
};

/// A message to the user.
typedef struct viewer_message {
    char text[512]; ///< empty: no message
    bool is_error;
    double ms; ///< time of arrival
} viewer_message;

/// The action of the pressed mouse button.
typedef enum drag_kind {
    DRAG_NONE,
    DRAG_ORBIT,
    DRAG_PAN,
    DRAG_LOOK,
    DRAG_SECTION,
    DRAG_PARTS, ///< the edge of the panel of parts
} drag_kind;

typedef struct input_state {
    drag_kind drag;
    int button;             ///< pressed over the picture; 0: none
    float start_x, start_y; ///< pixels of the window
    float last_x, last_y;
    bool moved;       ///< a drag, not a click
    double pan_depth; ///< depth of the dragged point
    SDL_GameController* pad;
    space_mouse* space_mouse; ///< NULL: built without support
    bool pushed;              ///< the SpaceMouse moves the camera or the model
    bool flies;               ///< keys, sticks or the SpaceMouse fly the camera
} input_state;

/// A rectangle of the window, in pixels.
typedef struct viewer_area {
    float x, y, width, height;
} viewer_area;

typedef struct section_plane {
    bool on, flipped;
    stp_vec3d origin; ///< a point of the plane at offset 0
    stp_vec3d normal; ///< unit vector
    float offset;     ///< along the normal
} section_plane;

typedef struct section_state {
    bool has_box;
    stp_boxd box;
    section_plane planes[STP_SECTION_PLANES];
    int plane_count;
} section_state;

typedef struct measure_state {
    bool on, snaps;
    stp_vec3d points[MEASURE_POINTS];
    int count;
} measure_state;

typedef struct flight_record {
    bool on, plays;
    double start_ms, last_ms;
    stp_flight_key* keys; ///< malloc'ed
    size_t count, capacity;
} flight_record;

/// The last automatic framing. It is repeated when the picture gets another shape, as long as the
/// user has not moved the camera.
typedef struct framing_state {
    bool on;
    stp_outline_item part; ///< what was framed; depth 0: everything
    uint32_t scene;        ///< serial of the framed scene
    stp_navigator framed;  ///< the camera that it gave
} framing_state;

/// The selected part in the picture.
typedef struct selection_state {
    stp_outline_item item; ///< what the shape is of
    uint32_t scene;        ///< serial; 0: no shape
    uint64_t frame;        ///< of the picture that the mask belongs to
    part_shape shape;
    part_mask mask;
} selection_state;

typedef struct shot shot;

/// Widgets for the number of splats.
enum { SPLAT_PLACE_CHOICE, SPLAT_PLACE_SLIDER, SPLAT_PLACE_NUMBER, SPLAT_PLACES };

typedef struct viewer {
    viewer_options options;
    viewer_settings settings;
    window window;
    loader* loader;
    painter* painter;
    uint32_t wake_event;
    bool quits;
    int dirty;      ///< number of window frames left to redraw
    uint64_t shows; ///< frames shown
    double last_ms; ///< time of the last step
    viewer_area picture_area;
    // the scene
    loader_news news;
    char file[PATH_ROOM]; ///< shown or being loaded: a file or a folder
    size_t more;          ///< number of further files that were opened with it
    path_list inputs;     ///< all files of the scene
    path_list dropped;    ///< files of a drop that is not yet complete
    bool can_correct;     ///< up axis and unit: no input is built yet
    char up;              ///< corrections of the inputs (scene_input)
    double unit_metres;
    uint32_t opening;                        ///< serial that the painter is opening
    uint32_t former;                         ///< serials up to this one belong to the previous file
    uint32_t file_number, shown_file_number; ///< number of files so far; number of the shown one
    const painter_scene* scene;
    const painter_picture* picture;
    uint64_t request;
    // the camera
    stp_navigator camera, glide_from, glide_to;
    double glide_start; ///< negative: no glide in progress
    bool has_camera;
    framing_state framing;
    selection_state selection;
    input_state input;
    // parts, sections, measures, viewpoints
    stp_context* context; ///< the window's own
    explorer* explorer;   ///< parts of `scene`; NULL: none
    uint64_t marks_version;
    char search[128];
    bool enters;     ///< select the first match when it is found
    bool finds;      ///< focus the search field
    bool has_picked; ///< something was clicked in this scene
    stp_pick picked;
    point_style look;
    section_state section;
    int section_grabbed; ///< the dragged handle (section_drag.c)
    start_page* start;
    measure_state measure;
    stp_viewpoints views;
    stp_viewpoints carried; ///< hidden parts of the same file's previous, coarser scene
    char* views_path;       ///< NULL: viewpoints cannot be saved
    char current_view[128], view_name[128], view_note[512];
    bool view_pins;
    flight_record record;
    shot* shot; ///< the picture being saved; NULL: none
    bool shot_clear;
    char last_shot[PATH_ROOM + 512];
    // the panels
    bool shows_help, shows_panels;
    float splat_places[SPLAT_PLACES][4]; ///< x0, y0, x1, y1; all 0: not visible
    float frame_times[FRAME_HISTORY];
    int newest_time;
    viewer_message messages[MESSAGES]; ///< newest first
    double report_ms;                  ///< time of the last report
    bool report_rests;                 ///< value of `rests` in it
} viewer;

// viewer.c, messages.c
void viewer_redraw(viewer* v);
/// Wakes the window, from any thread.
void viewer_wake(void* viewer);
void viewer_open(viewer* v, const char* path); ///< a file, or all models of a folder
/// Opens files and the models of folders as one scene.
void viewer_open_all(viewer* v, const char* const* paths, size_t count);
/// Shows the same files with another up axis and unit (scene_input).
void viewer_correct(viewer* v, char up, double unit_metres);
void viewer_show_message(viewer* v, bool is_error, const char* format, ...)
    __attribute__((format(printf, 3, 4)));
/// Whether everything is at rest: the picture is final.
bool viewer_is_idle(const viewer* v);

// camera_moves.c
void camera_begin(viewer* v); ///< for a new scene
/// Starts a camera glide to another position.
void camera_glide(viewer* v, const stp_navigator* to);
void camera_step(viewer* v, double seconds);
void camera_face(viewer* v, const char* name);
/// Frames the selected part or everything. `level`: also levels a tilted horizon.
void camera_frame(viewer* v, bool level);
void camera_switch_projection(viewer* v);
/// The scene point at a position of the window. @return false if there is none
bool camera_seen(const viewer* v, float x, float y, stp_vec3d* point);
/// The camera of the shown picture. @return false if there is none
bool camera_of_picture(const viewer* v, stp_navigator* n);
stp_boxd camera_scene_box(const viewer* v);

// framing.c
/// Turns to a standard view of everything. @return false if no standard view has that name
bool framing_face(viewer* v, const char* name, stp_navigator* to);
/// Frames the selected part, or everything.
void framing_frame(viewer* v, stp_navigator* to);
/// Repeats the last framing if the picture has another shape.
void framing_step(viewer* v);

// input.c
void input_take(viewer* v, const SDL_Event* event);
/// Moves the camera by held keys, sticks and the SpaceMouse.
void input_step(viewer* v, double seconds);
/// Whether one of them moves the camera or the model.
bool input_moves(const viewer* v);
/// Starts support of gamepads and of a SpaceMouse.
void input_begin(viewer* v);
void input_destroy(viewer* v);

// space_mouse_step.c
/// Handles what the SpaceMouse has sent. @return whether it flies the camera; otherwise it is
/// at rest or moves the model
bool space_mouse_step(viewer* v, double seconds);

// panels.c
/// The area that the panels leave for the picture.
viewer_area panels_layout(const viewer* v);
void panels_show(viewer* v);
void panels_switch_parts(viewer* v);
/// Prints the coordinates under the cursor, as in the status line. @return false if there are none
bool panels_print_place(const viewer* v, char* text, size_t size);
/// Whether the edge of the panel of parts, which can be dragged, is at a position of the window.
bool panels_edge(const viewer* v, float x, float y);
/// Moves that edge.
void panels_drag_edge(viewer* v, float x);

// statistics_pages.c
void page_statistics(viewer* v);
void page_quality(viewer* v);

// request.c
bool viewer_uses_gl(const viewer* v);
paint_request request_make(viewer* v);

// report.c
/// Writes the report at most every 50 ms; immediately if `last`, or when the viewer comes to rest
/// or starts to work.
void report_write(viewer* v, bool last);
