// SPDX-License-Identifier: MIT
// Settings that persist between sessions.
#pragma once

#include "draw/draw.h"

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

typedef struct viewer_settings {
    int backend; ///< BACKEND_*
    bool parts;
    viewer_page page; ///< page of the right panel
    bool adapts;      ///< limit the frame time: splats grow while the camera moves
    float budget_ms, splat_size;
    uint32_t splat_count; ///< total number of splats to draw; 0: by splat size
    int samples;          ///< per axis, at rest
    int method;           ///< stp_policy; above its values: original geometry only
    int splats_by;        ///< method to draw (STP_METHOD_*); if 0 or not in the file, the first
    int filter, light;
    int unit;                         ///< UNIT_*
    int point_sizing;                 ///< stp_point_sizing, in scenes with points
    float point_scale;                ///< relative to the adaptive point size
    float point_pixels, point_metres; ///< fixed width of points
    bool guides;                      ///< view cube and scale bar
    bool caps;                        ///< fill solids where sections cut them
    bool fovea;
    float fovea_factor;
    float eye_dome;          ///< 0: off; negative: default for the scene
    float ambient_occlusion; ///< radius in percent of the picture's height; 0: off
    float background[3];
    int shot_width, shot_height, shot_samples;
} viewer_settings;

enum { METHOD_ORIGINAL = STP_POLICY_SWITCH + 1, METHOD_COUNT };

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
