// SPDX-License-Identifier: MIT
//
// How a scene is drawn, and the one table of what users can change about it: a row is an option of
// render and fly, a key of the viewer's settings file, a control of the viewer, or several of
// these. A new effect is a member of stp_draw_style and a row.
#pragma once

#include "draw/draw.h"
#include "program/options/command.h"

/// What options and controls set. What needs an open file (colours, the size of points, hidden
/// objects) is added before drawing.
typedef struct drawing_settings {
    stp_draw_style style; ///< eye_dome below 0: the scene's own (cloud_style_eye_dome)
    stp_quality quality;
} drawing_settings;

/// Where the viewer has the control of a row.
typedef enum drawing_panel {
    DRAWING_PANEL_NONE,
    DRAWING_PANEL_LIGHT,
    DRAWING_PANEL_BACKGROUND,
    DRAWING_PANEL_SPLAT_SIZE,
    DRAWING_PANEL_OVERLAPS,
    DRAWING_PANEL_SECTION,
    DRAWING_PANEL_SIDES,
} drawing_panel;

enum { DRAWING_WORDS = 4 };

typedef struct drawing_row {
    /// Of the command line; drawing_options_table adds the value and `given`. Its type is that of
    /// the setting, and all numbers below have its unit.
    option option;
    size_t offset;       ///< of the value in drawing_settings
    size_t given_offset; ///< of a bool that is set if the option is given; 0: none
    double initial;      ///< of a number or switch

    const char* key;       ///< in the viewer's settings file; NULL: none
    double low, high;      ///< range of a number in that file
    double viewer_initial; ///< as `initial`, in the viewer

    drawing_panel panel;
    const char *label, *tooltip;
    const char* choices[DRAWING_WORDS]; ///< labels of the first words; none: a checkbox
    /// Of a number: ends of the slider, and how it prints. If the option may be given without a
    /// value, a checkbox switches between 0 and that value, and shows the slider, named `amount`.
    float smallest, largest;
    const char *format, *amount;
} drawing_row;

/// All rows.
const drawing_row* drawing_rows(size_t* count);

enum { DRAWING_OPTION_ROOM = 32 }; ///< entries of a table

/// Fills a table of DRAWING_OPTION_ROOM options (ends with a NULL name), which change `settings`,
/// and gives these their initial values. @return the table
const option* drawing_options_table(option* table, drawing_settings* settings);

/// The settings of a new viewer.
drawing_settings drawing_settings_of_viewer(void);
/// Takes over valid values of a settings file; the others stay unchanged.
void drawing_settings_read(drawing_settings* settings, const json_t* root);
/// Adds the values to a settings file. @return false if memory runs out
bool drawing_settings_write(const drawing_settings* settings, json_t* root);

/// The number of labels of a row; 0: its control is not a choice.
uint32_t drawing_choice_count(const drawing_row* row);

/// The value of a number (OPTION_FLOAT), in the option's unit.
float drawing_get_number(const drawing_row* row, const drawing_settings* settings);
void drawing_set_number(const drawing_row* row, drawing_settings* settings, double value);
/// The value of a choice (its index), switch (0 or 1) or count.
uint64_t drawing_get_index(const drawing_row* row, const drawing_settings* settings);
void drawing_set_index(const drawing_row* row, drawing_settings* settings, uint64_t value);
/// The place of a colour.
uint8_t* drawing_color(const drawing_row* row, drawing_settings* settings);
