// SPDX-License-Identifier: MIT
// Functions shared by the panels.
#pragma once

#include "embed/measuring.h"
#include "program/present/navigate.h"
#include "program/viewer/panels/state.h"

// part_tree.c
void parts_show(viewer* v, float x, float y, float width, float height);
/// @return whether it handled the key
bool parts_take_key(viewer* v, SDL_Keycode key);

// messages.c, beside viewer_show_message
void messages_clear(viewer* v);
/// Dismisses the newest error. @return false if there is none
bool messages_put_away(viewer* v);
const char* messages_newest(const viewer* v); ///< NULL if it has expired or there is none
const char* messages_error(const viewer* v);  ///< the newest error not dismissed; NULL: none
/// Why the picture is empty; NULL if it is not.
const char* messages_explain_empty(const viewer* v);
void messages_overlay(const viewer* v);

// statistics_pages.c
/// Formats a count for people: "12.3 M".
void page_print_count(char* text, size_t size, uint64_t count);

// splat_controls.c
/// The maximum splat count; 0: counts are not available.
uint32_t splats_all(const viewer* v);
/// The active splat count; 0: splats are drawn by size.
uint32_t splats_count(const viewer* v);
/// Whether the file holds sets that replace others where few splats suffice.
bool viewer_mixes_methods(const viewer* v);
/// Switches between size and number.
void splats_switch(viewer* v);
/// @return whether the key changes the number; `fine`: in small steps
bool splats_take_key(viewer* v, SDL_Keycode key, bool fine);
/// Formats a whole number for people: "1,234".
void splats_print(char* text, size_t size, uint64_t count);
/// The controls in the Display panel.
void splats_show(viewer* v);

// section.c
void section_begin(viewer* v); ///< for a new scene
void page_section(viewer* v);
/// The active sections of the scene.
stp_sections section_make(const viewer* v);
// section_drag.c
/// Grabs the handle at a position of the window. @return false if there is none
bool section_grab(viewer* v, float x, float y);
/// Moves the grabbed handle with the mouse.
void section_drag(viewer* v, float from_x, float from_y, float to_x, float to_y);
/// Position in the window of a plane's handle (planes from 0; then the sides of the box). @return
/// false if it is not visible
bool section_handle(const viewer* v, int index, float* x, float* y);
void section_drag_overlay(const viewer* v, const stp_navigator* n);
void section_overlay(const viewer* v, const stp_navigator* n);
/// Converts a scene axis (0..2) to the file's axis, and back: inside, y is up.
int section_file_axis(const viewer* v, int axis);
void section_take(viewer* v, const stp_sections* sections); ///< from a saved viewpoint

// measure_tool.c
void page_measure(viewer* v);
void measure_unit_choice(viewer* v);
void measure_overlay(const viewer* v, const stp_navigator* n);
void measure_click(viewer* v, const stp_pick* pick, const stp_vec3d* seen);
void measure_undo(viewer* v);
/// The file's unit and up axis, and the display unit.
stp_measuring measure_units(const viewer* v);
/// Converts a length of the file to the display unit.
void measure_print(const viewer* v, double length, char* text, size_t size);
/// Converts a point to the file's coordinates: in the display unit, or as east, north and height in
/// the file's unit if the file names its coordinate system and z is up.
void measure_print_point(const viewer* v, stp_vec3d point, char* text, size_t size);
/// Copies a point's coordinates along the file's axes, in its unit, to the clipboard.
void measure_copy(viewer* v, stp_vec3d point);

// point_style.c
void point_style_begin(viewer* v); ///< for a new file
/// Chooses again a colour that follows from the file: for a newer scene of it.
void point_style_follow(viewer* v);
/// Adds colours of points and pixels to the request.
void point_style_give(viewer* v, paint_request* request);
/// The method to draw (STP_METHOD_*): the selected one, or another one if it lacks the attribute
/// that colours points.
/// @param originals receives whether only original points have the attribute
uint32_t point_style_method(const viewer* v, bool* originals);
void point_style_show(viewer* v);    ///< draws the controls in the panel
void point_style_overlay(viewer* v); ///< draws the colour scale beside the picture

// drawing_controls.c
void drawing_controls_show(viewer* v, drawing_panel panel); ///< the controls of one place

// cloud_page.c
/// Strength of eye-dome lighting: the scene's default unless the user chose another.
float cloud_page_eye_dome(const viewer* v);
/// Adds the point size to the request.
void cloud_page_give(const viewer* v, paint_request* request);
void cloud_page_show(viewer* v); ///< draws the controls in the panel

// orientation.c
/// Where a side (of STP_VIEW_CUBE_SIDES) of the cube can be clicked. @return its view; NULL: it is
/// not clickable
const char* orientation_place(const viewer* v, int side, float* x, float* y);
/// Turns the camera to the side of the view cube at a position of the window. @return false if
/// there is none
bool orientation_click(viewer* v, float x, float y);
/// The scale bar in the display unit; its length is 0 if it is hidden.
stp_scale_bar orientation_scale_bar(const viewer* v, const stp_navigator* n);
void orientation_overlay(const viewer* v, const stp_navigator* n);

// model_page.c
void model_page_show(viewer* v); ///< the controls in the panel

// saved_views.c
void page_views(viewer* v);
void views_begin(viewer* v); ///< for a new file
void views_end(viewer* v);
/// Starts at a saved viewpoint, with its sections and hidden parts. @return whether it exists
bool views_begin_at(viewer* v, const char* name);
void views_save(viewer* v); ///< saves the current view as a new viewpoint
/// Keeps the hidden parts for the next, finer scene of the same file, and restores them there.
void views_keep_hidden(viewer* v);
void views_restore_hidden(viewer* v);
void views_overlay(const viewer* v, const stp_navigator* n);

// record.c
void record_switch(viewer* v); ///< starts or stops recording
void record_step(viewer* v);
void record_play(viewer* v); ///< plays the last recording, or stops it
void record_end(viewer* v);
/// "FOLDER/NAME-001.ENDING", the first unused name in the folder of pictures, which is created if
/// needed.
void record_name_file(const viewer* v, const char* ending, char* path, size_t size);

// shots.c
void shot_begin(viewer* v);
void shot_step(viewer* v); ///< reports finished pictures
void shot_end(viewer* v);

// selection.c
/// Tints the selected part in the picture, also where something hides it.
void selection_overlay(viewer* v);
void selection_end(viewer* v);

// overlay.c
void overlay_show(viewer* v);
/// Projects a point of the scene to window pixels. @return false if it is behind the eye
bool overlay_place(const viewer* v, const stp_navigator* n, stp_vec3d point, float* x, float* y);
void overlay_line(const viewer* v, const stp_navigator* n, stp_vec3d a, stp_vec3d b, uint32_t color,
                  float width);
void overlay_box(const viewer* v, const stp_navigator* n, const stp_boxd* box, uint32_t color,
                 float width);
