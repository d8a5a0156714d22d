// SPDX-License-Identifier: MIT
// What the viewer remembers from one start to the next.
#pragma once

#include "draw/draw.h"

#include <stdbool.h>

enum { BACKEND_AUTO, BACKEND_PROCESSOR, BACKEND_OPENGL, BACKEND_COUNT };

/// Units in which lengths are shown.
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
    viewer_page page; ///< of the panel on the right
    bool adapts;      ///< splats grow while the camera moves, as the budget wants
    float budget_ms, splat_size;
    uint32_t splat_count; ///< so many splats are drawn in all; 0: as their size asks
    int samples;          ///< a side, at rest
    int method;           ///< stp_policy; beyond it: original geometry only
    int splats_by; ///< whose splats are drawn (STP_METHOD_*); 0, or none of the file's: its first
    int filter, light;
    int unit;                         ///< UNIT_*
    int point_sizing;                 ///< stp_point_sizing, in scenes that have points
    float point_scale;                ///< times the usual size of points, where it is adaptive
    float point_pixels, point_metres; ///< their width, where it is fixed
    bool guides;                      ///< view cube and scale bar
    bool caps;                        ///< solids that sections cut are filled
    bool fovea;
    float fovea_factor;
    float eye_dome;          ///< 0: none; below: as usual for the scene
    float ambient_occlusion; ///< in hundredths of the picture's height; 0: none
    float background[3];
    int shot_width, shot_height, shot_samples;
} viewer_settings;

enum { METHOD_ORIGINAL = STP_POLICY_SWITCH + 1, METHOD_COUNT };

viewer_settings viewer_settings_default(void);
/// Takes over what a text in JSON says and what is in range; the rest stays. @return false where it is no object
bool viewer_settings_parse(viewer_settings* settings, const char* text);
/// A text from malloc; NULL where memory runs out.
char* viewer_settings_print(const viewer_settings* settings);

/// $XDG_CONFIG_HOME/stipple/viewer.json, or ~/.config/stipple/viewer.json; what cannot be read or written is left out.
void viewer_settings_load(viewer_settings* settings);
void viewer_settings_save(const viewer_settings* settings);
