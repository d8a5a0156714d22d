// SPDX-License-Identifier: MIT
// --color, --range and --classes: colours of points and pixels.
#pragma once

#include "draw/draw.h"
#include "program/options/command.h"
#include "store/file/point_attributes.h"

/// Words of --color, in the order of `point_color`.
#define POINT_COLOR_WORDS                                                                          \
    "auto|rgb|intensity|elevation|class|return|returns|scan-angle|source|time|near-infrared|"      \
    "normal"

typedef enum point_color {
    POINT_COLOR_AUTO, ///< until point_colors_choose
    POINT_COLOR_RGB,
    POINT_COLOR_INTENSITY,
    POINT_COLOR_ELEVATION,
    POINT_COLOR_CLASS,
    POINT_COLOR_RETURN,
    POINT_COLOR_RETURNS,
    POINT_COLOR_SCAN_ANGLE,
    POINT_COLOR_SOURCE,
    POINT_COLOR_TIME,
    POINT_COLOR_NEAR_INFRARED,
    POINT_COLOR_NORMAL,
    POINT_COLORS
} point_color;

/// Options as given; zero fields were not given.
typedef struct point_color_options {
    int color;           ///< point_color
    const char* range;   ///< LO,HI
    const char* classes; ///< N,N
} point_color_options;

/// The options, resolved for a file.
typedef struct point_coloring {
    stp_store_coloring points;
    stp_draw_coloring pixels;
    double elevation[2];
} point_coloring;

/// The attribute that a colour shows; STP_ATTRIBUTES if none.
stp_attribute point_color_attribute(int color);

/// The word of a colour: "near-infrared".
const char* point_color_name(int color);

enum { POINT_COLOR_OPTION_ROOM = 4 }; ///< entries of a table

/// Fills a table of POINT_COLOR_OPTION_ROOM entries. @return the table
const option* point_color_options_table(option* table, point_color_options* options);

/// Rejects invalid combinations of options. @return 0, or 2 (message printed)
int point_colors_check(const point_color_options* options);

/// Reads LO,HI. @return false on a syntax error
bool point_colors_read_range(const char* text, double* low, double* high);
/// Reads N,N and marks only these classes. @return false on a syntax error
bool point_colors_read_classes(const char* text, uint8_t shown[256]);

/// Whether a scene shows only heights (SRTM), which have no colours.
bool point_colors_is_terrain(const stp_store_directory* directory);

/// Resolves --color auto: elevation for heights (SRTM), and for points without colours: the
/// coarsest splats of a method (an index in the file's table) are white; else own colours. Other
/// colours stay as they are.
/// @return STP_OK, or why the splats cannot be read; logged
STP_MUST_USE stp_result point_colors_choose(stp_store* store, uint32_t method, int* color);

/// Whether the options ask for attributes that only points have.
bool point_colors_need_points(const point_color_options* options);

/// The method whose splats have the requested attributes: `preferred` (an index in the file's
/// table), else the first that has them.
/// @return its place; STP_STORE_NONE: none has it
uint32_t point_colors_find_method(const point_color_options* options, const stp_store* store,
                                  uint32_t preferred);
/// Whether original points have the requested attributes.
bool point_colors_has_originals(const point_color_options* options, const stp_store* store);

/// Resolves the options, including ranges that were not given. `method` is the index of the method
/// whose splats are drawn.
/// @return STP_OK, STP_ERROR_ARGUMENT (the file lacks the attribute), or why it cannot be read;
/// logged
STP_MUST_USE stp_result point_colors_find(const point_color_options* options, stp_context* context,
                                          stp_store* store, const char* path, uint32_t method,
                                          bool reference, point_coloring* coloring);

/// The elevations that contain most of a scene: 2nd and 98th percentile of its root's splats, or
/// all of it.
STP_MUST_USE stp_result point_colors_elevations(stp_context* context, stp_store* store,
                                                uint32_t method, double range[2]);

/// Adds "color" and "range" to the description of a picture. @return false if memory runs out
bool point_colors_describe(const point_color_options* options, const point_coloring* coloring,
                           json_t* object);
