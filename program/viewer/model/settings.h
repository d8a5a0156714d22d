// SPDX-License-Identifier: MIT
// Settings that persist between sessions.
#pragma once

#include "program/drawing/drawing_table.h"

#include <stdbool.h>

enum { BACKEND_AUTO, BACKEND_PROCESSOR, BACKEND_OPENGL, BACKEND_COUNT };

/// Display units of lengths.
enum { UNIT_FILE, UNIT_MM, UNIT_CM, UNIT_M, UNIT_IN, UNIT_FT, UNIT_COUNT };

typedef enum viewer_page {
    PAGE_NONE,
    PAGE_STATISTICS,
    PAGE_QUALITY,
    PAGE_SECTION,
    PAGE_MEASURE,
    PAGE_VIEWS,
    PAGE_COUNT
} viewer_page;

// Widths of the panel of parts, pixels at scale 1.
#define VIEWER_PARTS_WIDTH 260.0f
#define VIEWER_PARTS_WIDTH_MIN 140.0f
#define VIEWER_PARTS_WIDTH_MAX 1200.0f

typedef struct viewer_settings {
    int backend; ///< BACKEND_*
    bool parts;
    float parts_width; ///< of the panel of parts, pixels at scale 1
    viewer_page page;  ///< page of the right panel
    bool adapts;       ///< limit the frame time: splats grow while the camera moves
    float budget_ms;
    /// Of its style, point_sizing counts in scenes with points; its quality has the size and number
    /// of splats (0: by size), policy, method and reference.
    drawing_settings drawing;
    int samples;                      ///< per axis, at rest
    int unit;                         ///< UNIT_*
    float point_scale;                ///< relative to the adaptive point size
    float point_pixels, point_metres; ///< fixed width of points
    bool guides;                      ///< view cube and scale bar
    bool fovea;
    float fovea_factor;
    bool space_mouse_flies; ///< it moves the camera, not the model
    int shot_width, shot_height, shot_samples;
} viewer_settings;

/// What the user chooses as detail: an stp_policy, or original geometry only.
enum { DETAIL_ORIGINAL = STP_POLICY_SWITCH + 1, DETAIL_COUNT };
int viewer_settings_detail(const viewer_settings* settings);
void viewer_settings_set_detail(viewer_settings* settings, int detail);

viewer_settings viewer_settings_default(void);
/// Takes over valid values of a JSON text; the others stay unchanged. @return false if it is not an
/// object
bool viewer_settings_parse(viewer_settings* settings, const char* text);
/// Text from malloc; NULL if memory runs out.
char* viewer_settings_print(const viewer_settings* settings);

/// $XDG_CONFIG_HOME/stipple/viewer.json, or ~/.config/stipple/viewer.json; errors of reading and
/// writing are ignored.
void viewer_settings_load(viewer_settings* settings);
void viewer_settings_save(const viewer_settings* settings);
