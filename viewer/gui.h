// SPDX-License-Identifier: MIT
//
// What the viewer uses of Dear ImGui, for C. One window, one thread.
//
// Panels are rectangles that do not move; all sizes are in pixels of the window. A tooltip may be NULL.
#pragma once

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

struct SDL_Window;
struct SDL_Renderer;
union SDL_Event;

/// `gl`: the window's OpenGL context, or NULL with an SDL renderer. Font sizes and distances are for `scale` 1 times scale.
/// @return false where it cannot be made
bool gui_create(struct SDL_Window* window, void* gl, struct SDL_Renderer* renderer, float scale);
void gui_destroy(void);
void gui_take_event(const union SDL_Event* event);
/// Of a window of so many pixels, `density` of them a unit of its mouse.
void gui_begin_frame(int width, int height, float density);
/// Draws what was said since gui_begin_frame.
void gui_end_frame(void);
/// Whether a panel has the mouse, or a text field the keys.
bool gui_wants_mouse(void);
bool gui_wants_keys(void);
/// Whether the mouse rests on something whose tooltip comes soon.
bool gui_waits(void);
/// Distances of the look: a line of widgets, a line of text, the space between widgets.
float gui_line_height(void);
float gui_text_height(void);
float gui_gap(void);
float gui_text_width(const char* text);

// Panels and their order.
void gui_panel_begin(const char* name, float x, float y, float width, float height);
/// One line of widgets or text, in the middle of the height.
void gui_bar_begin(const char* name, float x, float y, float width, float height, bool of_text);
void gui_panel_end(void); ///< ends each of these
/// A panel over all others, its middle at a place where there is room, as high as what is in it.
void gui_dialog_begin(const char* name, float x, float y, float width);
void gui_same_line(void);
void gui_right_aligned(float width);
void gui_space(void);
void gui_separator(void);
void gui_fill_width(void); ///< of the next widget
void gui_push_id(int id);
void gui_pop_id(void);
void gui_disable(bool disabled); ///< ends with gui_enable
void gui_enable(void);
/// A part that folds. @return whether it is open
bool gui_section(const char* label, bool open);

// Text.
void gui_text(const char* format, ...) __attribute__((format(printf, 1, 2)));
void gui_faint(const char* format, ...) __attribute__((format(printf, 1, 2)));
void gui_faint_paragraph(const char* format, ...) __attribute__((format(printf, 1, 2)));
void gui_paragraph(const char* format, ...) __attribute__((format(printf, 1, 2)));
/// A name on the left and a value beside it.
void gui_value(const char* name, const char* format, ...) __attribute__((format(printf, 2, 3)));
/// A square of a colour (linear light, with alpha) before what follows in the line.
void gui_square(const float color[4]);
/// The same with a square of a colour (linear light, with alpha) before the value.
void gui_swatch(const char* name, const float color[4], const char* format, ...)
    __attribute__((format(printf, 3, 4)));
void gui_tooltip(const char* text); ///< of the widget before

// Widgets: true when the hand changed or pressed them.
bool gui_button(const char* label, const char* tooltip);
/// As wide as the panel, divided by `share`.
bool gui_wide_button(const char* label, int share, const char* tooltip);
bool gui_toggle(const char* label, bool on, const char* tooltip);
/// A toggle with a name that people gave: any text, cut short where less than `beside` would be left to its right.
bool gui_name_toggle(const char* name, bool on, float beside, const char* tooltip);
bool gui_check(const char* label, bool* value, const char* tooltip);
bool gui_slider(const char* label, float* value, float least, float most, const char* format,
                const char* tooltip);
/// The same where a step is a factor.
bool gui_log_slider(const char* label, float* value, float least, float most, const char* format,
                    const char* tooltip);
/// The same of a whole number; `most` is at most 2^63 - 1.
bool gui_log_count(const char* label, uint64_t* value, uint64_t least, uint64_t most,
                   const char* tooltip);
/// A field that such a number is typed into, with buttons for one more and one less.
bool gui_count(const char* label, uint64_t* value, uint64_t least, uint64_t most,
               const char* tooltip);
/// Where the widget before is, without its label, as x0, y0, x1, y1; all 0 where it is out of sight.
void gui_last_place(float place[4]);
bool gui_number(const char* label, double* value, double step, const char* format,
                const char* tooltip);
bool gui_whole_number(const char* label, int* value, int least, int most, const char* tooltip);
bool gui_choice(const char* label, int* value, const char* const* words, int count,
                const char* tooltip);
bool gui_color(const char* label, float color[3], const char* tooltip);
/// @return whether the text changed; *entered: whether it was ended with Enter
bool gui_input(const char* label, const char* hint, char* text, size_t size, bool* entered);
void gui_focus_next(void); ///< the keys go to the next widget

enum {
    GUI_ROW_OPENED = 1,   ///< it was folded or unfolded
    GUI_ROW_CLICKED = 2,  ///< chosen
    GUI_ROW_DOUBLE = 4,   ///< twice
    GUI_ROW_SWITCHED = 8, ///< its eye was clicked
};

typedef struct gui_row {
    const char* label;
    const char* detail; ///< dimmed, behind the label; NULL: none
    int depth;
    bool has_children, open, selected, shown, faint;
} gui_row;

/// A line of a tree, with an eye that says whether it is shown. @return GUI_ROW_*
int gui_tree_row(const gui_row* row);
/// A line of a list, of such a height too: a name and something dimmed at the right. @return GUI_ROW_CLICKED, GUI_ROW_DOUBLE
int gui_list_row(const char* label, const char* detail, bool selected);
/// Of a long list of rows of one height only those in sight are to be said: begins with the first, ends with the last.
void gui_rows_begin(int count, int* first, int* last);
void gui_rows_end(int count, int last);
void gui_list_begin(const char* name, float height); ///< a part that scrolls
void gui_list_end(void);
void gui_scroll_to_row(int row); ///< of a list of rows

void gui_progress(float fraction, const char* text);
/// Bars of the last values, the newest on the right; `mark`: a line at a value. Both in the unit of values.
void gui_graph(const float* values, int count, int newest, float most, float mark, float height,
               const char* tooltip);

// Over the picture, under the panels. Colours are 0xRRGGBBAA.
void gui_picture(void* texture, float x0, float y0, float x1, float y1);
void gui_clip(float x0, float y0, float x1, float y1); ///< until gui_unclip
void gui_unclip(void);
void gui_line(float x0, float y0, float x1, float y1, uint32_t color, float width);
void gui_disc(float x, float y, float radius, uint32_t fill, uint32_t rim);
/// A convex polygon of corners x, y, x, y, ...
void gui_polygon(const float* corners, int count, uint32_t fill, uint32_t rim);
/// Text around a place, `size` times as large as usual.
void gui_letters(float x, float y, float size, const char* text, uint32_t color);
void gui_box(float x0, float y0, float x1, float y1, uint32_t fill, uint32_t rim);
/// Text on a plate, the middle of its last line at a place.
void gui_plate(float x, float y, const char* text, uint32_t color);
/// The same from a left edge on, as wide as there is room, its last line at y. @return how high its other lines are
float gui_plate_at(float x, float y, float room, const char* text, uint32_t color);

#ifdef __cplusplus
}
#endif
