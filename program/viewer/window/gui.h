// SPDX-License-Identifier: MIT
//
// The part of Dear ImGui that the viewer uses, for C. One window, one thread.
//
// Panels are fixed rectangles; all sizes are in pixels of the window. A tooltip may be NULL.
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

/// `gl`: the window's OpenGL context, or NULL with an SDL renderer. Font sizes and distances are
/// multiplied by `scale`. @return false on failure
bool gui_create(struct SDL_Window* window, void* gl, struct SDL_Renderer* renderer, float scale);
void gui_destroy(void);
void gui_take_event(const union SDL_Event* event);
/// Size of the window in pixels; `density` is pixels per mouse unit.
void gui_begin_frame(int width, int height, float density);
/// Draws everything added since gui_begin_frame.
void gui_end_frame(void);
/// Whether a panel uses the mouse, or a text field the keyboard.
bool gui_wants_mouse(void);
bool gui_wants_keys(void);
/// Whether the mouse rests on a widget whose tooltip will appear soon.
bool gui_awaits_tooltip(void);
/// Layout metrics: height of a line of widgets, height of a line of text, spacing of widgets.
float gui_line_height(void);
float gui_text_height(void);
float gui_gap(void);
float gui_text_width(const char* text);

// Panels and their layout.
void gui_panel_begin(const char* name, float x, float y, float width, float height);
/// One line of widgets or text, vertically centred.
void gui_bar_begin(const char* name, float x, float y, float width, float height, bool of_text);
void gui_panel_end(void); ///< ends any of these
/// A panel above all others, centred at a position, as high as its content.
void gui_dialog_begin(const char* name, float x, float y, float width);
void gui_same_line(void);
void gui_right_aligned(float width);
void gui_space(void);
void gui_separator(void);
void gui_fill_width(void); ///< applies to the next widget
void gui_push_id(int id);
void gui_pop_id(void);
void gui_disable(bool disabled); ///< until gui_enable
void gui_enable(void);
/// A collapsible section. @return whether it is open
bool gui_section(const char* label, bool open);

// Text.
void gui_text(const char* format, ...) __attribute__((format(printf, 1, 2)));
void gui_dim_text(const char* format, ...) __attribute__((format(printf, 1, 2)));
void gui_dim_paragraph(const char* format, ...) __attribute__((format(printf, 1, 2)));
void gui_paragraph(const char* format, ...) __attribute__((format(printf, 1, 2)));
/// A name on the left and a value beside it.
void gui_value(const char* name, const char* format, ...) __attribute__((format(printf, 2, 3)));
/// A colour swatch (linear light; alpha is ignored) before the rest of the line.
void gui_square(const float color[4]);
/// As gui_value, with a colour swatch (linear light; alpha is ignored) before the value.
void gui_swatch(const char* name, const float color[4], const char* format, ...)
    __attribute__((format(printf, 3, 4)));
void gui_tooltip(const char* text); ///< for the previous widget

// Widgets return true if the user changed or pressed them.
bool gui_button(const char* label, const char* tooltip);
/// Width of the panel divided by `share`.
bool gui_wide_button(const char* label, int share, const char* tooltip);
bool gui_toggle(const char* label, bool on, const char* tooltip);
/// A toggle with a user-defined name, shortened to leave `beside` pixels to its right.
bool gui_name_toggle(const char* name, bool on, float beside, const char* tooltip);
bool gui_check(const char* label, bool* value, const char* tooltip);
bool gui_slider(const char* label, float* value, float minimum, float maximum, const char* format,
                const char* tooltip);
/// Same, on a logarithmic scale.
bool gui_log_slider(const char* label, float* value, float minimum, float maximum,
                    const char* format, const char* tooltip);
/// Same, for a whole number; `maximum` is at most 2^63 - 1.
bool gui_log_count(const char* label, uint64_t* value, uint64_t minimum, uint64_t maximum,
                   const char* tooltip);
/// A field for such a number, with buttons to increase and decrease it.
bool gui_count(const char* label, uint64_t* value, uint64_t minimum, uint64_t maximum,
               const char* tooltip);
/// Rectangle x0, y0, x1, y1 of the previous widget, without its label; all 0 if it is not visible.
void gui_last_place(float place[4]);
bool gui_number(const char* label, double* value, double step, const char* format,
                const char* tooltip);
bool gui_whole_number(const char* label, int* value, int minimum, int maximum, const char* tooltip);
bool gui_choice(const char* label, int* value, const char* const* words, int count,
                const char* tooltip);
bool gui_color(const char* label, float color[3], const char* tooltip);
/// @return whether the text changed; *entered: whether Enter was pressed
bool gui_input(const char* label, const char* hint, char* text, size_t size, bool* entered);
/// Replaces what was typed by a completion, of at most `size` bytes. @return false if there is none
typedef bool (*gui_completer)(const char* typed, char* text, size_t size, void* user);
/// The same; Tab completes the text.
bool gui_input_completed(const char* label, const char* hint, char* text, size_t size,
                         gui_completer complete, void* user, bool* entered);
void gui_focus_next(void); ///< gives the keyboard focus to the next widget

enum {
    GUI_ROW_OPENED = 1,   ///< expanded or collapsed
    GUI_ROW_CLICKED = 2,  ///< clicked
    GUI_ROW_DOUBLE = 4,   ///< double-clicked
    GUI_ROW_SWITCHED = 8, ///< its eye was clicked
};

typedef struct gui_row {
    const char* label;
    const char* detail; ///< dimmed, behind the label; NULL: none
    int depth;
    bool has_children, open, selected, shown, faint;
} gui_row;

/// A row of a tree, with an eye that shows its visibility. @return GUI_ROW_*
int gui_tree_row(const gui_row* row);
/// A row of a list, of the same height: a name, and dimmed text at the right. @return
/// GUI_ROW_CLICKED, GUI_ROW_DOUBLE
int gui_list_row(const char* label, const char* detail, bool selected);
/// Only the visible rows of a long list with rows of equal height need to be added: from `first` up
/// to, not including, `last`.
void gui_rows_begin(int count, int* first, int* last);
void gui_rows_end(int count, int last);
void gui_list_begin(const char* name, float height); ///< a scrolling area
void gui_list_end(void);
void gui_scroll_to_row(int row); ///< in a list of rows

void gui_progress(float fraction, const char* text);
/// A bar chart of the last values, newest on the right, with a line at `mark`.
void gui_graph(const float* values, int count, int newest, float maximum, float mark, float height,
               const char* tooltip);

// Drawing over the picture, under the panels. Colours are 0xRRGGBBAA.
void gui_picture(void* texture, float x0, float y0, float x1, float y1);
void gui_clip(float x0, float y0, float x1, float y1); ///< until gui_unclip
void gui_unclip(void);
void gui_line(float x0, float y0, float x1, float y1, uint32_t color, float width);
void gui_disc(float x, float y, float radius, uint32_t fill, uint32_t rim);
/// A convex polygon of corners x, y, x, y, ...
void gui_polygon(const float* corners, int count, uint32_t fill, uint32_t rim);
/// Text centred at a position, `size` times the normal size.
void gui_letters(float x, float y, float size, const char* text, uint32_t color);
void gui_box(float x0, float y0, float x1, float y1, uint32_t fill, uint32_t rim);
void gui_fill(float x0, float y0, float x1, float y1, uint32_t fill); ///< a plain rectangle
void gui_resize_cursor(void); ///< this frame's cursor shows that an edge can be dragged sideways
/// Text on a background plate; its last line is centred at a position.
void gui_plate(float x, float y, const char* text, uint32_t color);
/// Same, left-aligned and as wide as there is room; its last line is at y. @return the height of
/// the other lines
float gui_plate_at(float x, float y, float room, const char* text, uint32_t color);

#ifdef __cplusplus
}
#endif
