// SPDX-License-Identifier: MIT
// The panels' own functions, for each other.
#pragma once

#include "state.h"

#include "present/measuring.h"
#include "present/scale_bar.h"

// parts.c
void parts_show(viewer* v, float x, float y, float width, float height);
/// @return whether the key was one of its commands
bool parts_take_key(viewer* v, SDL_Keycode key);

// messages.c, beside viewer_say
void messages_clear(viewer* v);
/// Puts the newest error away. @return false where there is none
bool messages_put_away(viewer* v);
const char* messages_newest(const viewer* v); ///< NULL: it is old, or there is none
const char* messages_error(const viewer* v);  ///< the newest that was not put away; NULL: none
/// Why there is nothing in the picture; NULL: there is something.
const char* messages_why_empty(const viewer* v);
void messages_overlay(const viewer* v);

// pages.c
/// "12.3 M": a count for people.
void page_print_count(char* text, size_t size, uint64_t count);

// splats.c
/// The most splats that can be asked for by number; 0: there is no choice.
uint32_t splats_all(const viewer* v);
/// The number in effect; 0: they are drawn by size.
uint32_t splats_count(const viewer* v);
/// Whether the file holds sets that stand for others where few splats suffice.
bool viewer_mixes_methods(const viewer* v);
/// From size to number and back.
void splats_switch(viewer* v);
/// @return whether the key was one that changes the number; `fine`: by less
bool splats_take_key(viewer* v, SDL_Keycode key, bool fine);
/// "1,234": a whole number for people.
void splats_print(char* text, size_t size, uint64_t count);
/// The part of the Display panel.
void splats_show(viewer* v);

// section.c
void section_begin(viewer* v); ///< of a new scene
void page_section(viewer* v);
/// What is cut away of the scene now.
stp_sections section_make(const viewer* v);
// section_drag.c
/// Takes hold of the handle at a place of the window. @return false where there is none
bool section_grab(viewer* v, float x, float y);
/// Moves what is held as the hand moves.
void section_drag(viewer* v, float from_x, float from_y, float to_x, float to_y);
/// Where the handle of a plane (from 0 on; then the sides of the box) is in the window. @return false where it is not shown
bool section_handle(const viewer* v, int index, float* x, float* y);
void section_drag_overlay(const viewer* v, const stp_navigator* n);
void section_overlay(const viewer* v, const stp_navigator* n);
/// The file's number of an axis of the scene (0..2), and back: inside, y is up.
int section_file_axis(const viewer* v, int axis);
void section_take(viewer* v, const stp_sections* sections); ///< of a saved viewpoint

// measure.c
void page_measure(viewer* v);
void measure_unit_choice(viewer* v);
void measure_overlay(const viewer* v, const stp_navigator* n);
void measure_click(viewer* v, const stp_pick* pick, const stp_vec3d* seen);
void measure_undo(viewer* v);
/// The file's unit and up axis, and the unit that is shown.
stp_measuring measure_units(const viewer* v);
/// A length (of the file) in the unit that is shown.
void measure_print(const viewer* v, double length, char* text, size_t size);
/// A point in the file's coordinates, in the unit that is shown.
void measure_print_point(const viewer* v, stp_vec3d point, char* text, size_t size);

// point_look.c
void point_look_begin(viewer* v); ///< of a new file
/// Adds colours of points and pixels to what is asked for.
void point_look_give(viewer* v, paint_request* request);
/// Whose splats are drawn: of the chosen method, or, where they lack what points are coloured by, of another (STP_METHOD_*).
/// @param originals receives whether only original points have it
uint32_t point_look_method(const viewer* v, bool* originals);
void point_look_show(viewer* v);    ///< in the panel
void point_look_overlay(viewer* v); ///< the scale beside the picture

// cloud_page.c
/// The strength of eye-dome lighting: the usual one of the scene where nobody chose another.
float cloud_page_eye_dome(const viewer* v);
/// Adds the size of points to what is asked for.
void cloud_page_give(const viewer* v, paint_request* request);
void cloud_page_show(viewer* v); ///< in the panel

// orientation.c
/// The side of the view cube (present/view_cube.h) at a place of the window; -1: none.
int orientation_side(const viewer* v, float x, float y);
/// Where a side (of STP_VIEW_CUBE_SIDES) of the cube can be clicked. @return its view; NULL: it cannot
const char* orientation_place(const viewer* v, int side, float* x, float* y);
/// Turns to the side of the view cube at a place of the window. @return false where there is none
bool orientation_click(viewer* v, float x, float y);
/// The scale bar in the unit that is shown; its length is 0 where none is drawn.
stp_scale_bar orientation_scale_bar(const viewer* v, const stp_navigator* n);
void orientation_overlay(const viewer* v, const stp_navigator* n);

// views.c
void page_views(viewer* v);
void views_begin(viewer* v); ///< of a new file
void views_end(viewer* v);
/// Begins at a saved viewpoint, with its sections and what is hidden there. @return whether there is one of that name
bool views_begin_at(viewer* v, const char* name);
void views_save(viewer* v); ///< what is seen now, as another viewpoint
/// Keeps what is hidden, for the same file's next, finer scene; and brings it back there.
void views_carry(viewer* v);
void views_bring(viewer* v);
void views_overlay(const viewer* v, const stp_navigator* n);

// record.c
void record_switch(viewer* v); ///< begins or ends
void record_step(viewer* v);
void record_play(viewer* v); ///< the last one, or stops it
void record_end(viewer* v);
/// "FOLDER/NAME-001.ENDING", the first that is not there yet, in the folder of pictures, which is made.
void record_name_file(const viewer* v, const char* ending, char* path, size_t size);

// shots.c
void shot_begin(viewer* v);
void shot_step(viewer* v); ///< says when one is done
void shot_end(viewer* v);

// overlay.c
void overlay_show(viewer* v);
/// A point of the scene in pixels of the window. @return false where it is not before the eye
bool overlay_place(const viewer* v, const stp_navigator* n, stp_vec3d point, float* x, float* y);
void overlay_line(const viewer* v, const stp_navigator* n, stp_vec3d a, stp_vec3d b, uint32_t color,
                  float width);
void overlay_box(const viewer* v, const stp_navigator* n, const stp_boxd* box, uint32_t color,
                 float width);
