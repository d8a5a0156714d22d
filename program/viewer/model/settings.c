// SPDX-License-Identifier: MIT
#include "program/viewer/model/settings.h"

#include "base/io/file.h"
#include "program/options/cloud_style.h"

#include <assert.h>
#include <jansson.h>
#include <limits.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <sys/stat.h>

typedef enum field_type { FIELD_BOOL, FIELD_INT, FIELD_WHOLE, FIELD_FLOAT } field_type;

typedef struct field {
    const char* name;
    field_type type;
    size_t offset;
    double minimum, maximum;
} field;

#define DETAIL_KEY "method" ///< the policy's; older files have it by this name

#define PLACE(member) offsetof(viewer_settings, member)
/// Settings that are not in the table of drawing_rows.
static const field fields[] = {
    {"backend", FIELD_INT, PLACE(backend), 0, BACKEND_COUNT - 1},
    {"parts", FIELD_BOOL, PLACE(parts), 0, 0},
    {"parts_width", FIELD_FLOAT, PLACE(parts_width), (double)VIEWER_PARTS_WIDTH_MIN,
     (double)VIEWER_PARTS_WIDTH_MAX},
    {"page", FIELD_INT, PLACE(page), 0, PAGE_COUNT - 1},
    {"adapts", FIELD_BOOL, PLACE(adapts), 0, 0},
    {"budget_ms", FIELD_FLOAT, PLACE(budget_ms), 4, 500},
    {"samples", FIELD_INT, PLACE(samples), 1, 8},
    {"splats_by", FIELD_WHOLE, PLACE(drawing.quality.method), 0, STP_METHOD_STOCHASTIC},
    {"unit", FIELD_INT, PLACE(unit), 0, UNIT_COUNT - 1},
    {"point_sizing", FIELD_INT, PLACE(drawing.style.point_sizing), 0, STP_POINTS_UNITS},
    {"point_scale", FIELD_FLOAT, PLACE(point_scale), 0.25, 4},
    {"point_pixels", FIELD_FLOAT, PLACE(point_pixels), 1, CLOUD_POINT_PIXELS},
    {"point_metres", FIELD_FLOAT, PLACE(point_metres), 1e-6, 1e6},
    {"guides", FIELD_BOOL, PLACE(guides), 0, 0},
    {"fovea", FIELD_BOOL, PLACE(fovea), 0, 0},
    {"fovea_factor", FIELD_FLOAT, PLACE(fovea_factor), 1, 8},
    {"space_mouse_flies", FIELD_BOOL, PLACE(space_mouse_flies), 0, 0},
    {"shot_width", FIELD_INT, PLACE(shot_width), 16, 16384},
    {"shot_height", FIELD_INT, PLACE(shot_height), 16, 16384},
    {"shot_samples", FIELD_INT, PLACE(shot_samples), 1, 8},
};
enum { FIELD_COUNT = sizeof(fields) / sizeof(fields[0]) };

viewer_settings viewer_settings_default(void)
{
    return (viewer_settings){.parts = true,
                             .parts_width = VIEWER_PARTS_WIDTH,
                             .page = PAGE_NONE,
                             .point_scale = 1.0f,
                             .point_pixels = 3.0f,
                             .point_metres = 0.05f,
                             .guides = true,
                             .adapts = true,
                             .budget_ms = 33.0f,
                             .drawing = drawing_settings_of_viewer(),
                             .samples = 4,
                             .fovea_factor = 2.0f,
                             .shot_width = 3840,
                             .shot_height = 2160,
                             .shot_samples = 2};
}

int viewer_settings_detail(const viewer_settings* settings)
{
    const stp_quality* quality = &settings->drawing.quality;
    return quality->reference ? DETAIL_ORIGINAL : (int)quality->policy;
}

void viewer_settings_set_detail(viewer_settings* settings, int detail)
{
    stp_quality* quality = &settings->drawing.quality;
    quality->reference = detail == DETAIL_ORIGINAL;
    quality->policy = quality->reference ? STP_POLICY_INSERTION : (stp_policy)detail;
}

/// @return false if the value is not a number within the range
static bool read_number(const json_t* value, double minimum, double maximum, double* number)
{
    *number = json_is_number(value) ? json_number_value(value) : 0.0;
    return json_is_number(value) && *number >= minimum && *number <= maximum;
}

static void read_field(const field* f, const json_t* value, viewer_settings* settings)
{
    char* place = (char*)settings + f->offset;
    double number;
    if (f->type == FIELD_BOOL && json_is_boolean(value)) {
        *(bool*)place = json_is_true(value);
    } else if (f->type != FIELD_BOOL && read_number(value, f->minimum, f->maximum, &number)) {
        if (f->type == FIELD_INT) {
            *(int*)place = (int)number;
        } else if (f->type == FIELD_WHOLE) {
            *(uint32_t*)place = (uint32_t)number;
        } else {
            *(float*)place = (float)number;
        }
    }
}

static json_t* write_field(const field* f, const viewer_settings* settings)
{
    const char* place = (const char*)settings + f->offset;
    return f->type == FIELD_BOOL    ? json_boolean(*(const bool*)place)
           : f->type == FIELD_INT   ? json_integer(*(const int*)place)
           : f->type == FIELD_WHOLE ? json_integer((json_int_t) * (const uint32_t*)place)
                                    : json_real((double)*(const float*)place);
}

bool viewer_settings_parse(viewer_settings* settings, const char* text)
{
    json_t* root = json_loads(text, 0, NULL);
    bool valid = json_is_object(root);
    double detail;
    for (int i = 0; valid && i < FIELD_COUNT; ++i) {
        read_field(&fields[i], json_object_get(root, fields[i].name), settings);
    }
    if (valid && read_number(json_object_get(root, DETAIL_KEY), 0, DETAIL_COUNT - 1, &detail)) {
        viewer_settings_set_detail(settings, (int)detail);
    }
    if (valid) {
        drawing_settings_read(&settings->drawing, root);
    }
    json_decref(root);
    return valid;
}

char* viewer_settings_print(const viewer_settings* settings)
{
    json_t* root = json_object();
    json_t* detail = json_integer(viewer_settings_detail(settings));
    bool whole = json_object_set_new(root, DETAIL_KEY, detail) == 0;
    for (int i = 0; whole && i < FIELD_COUNT; ++i) {
        whole = json_object_set_new(root, fields[i].name, write_field(&fields[i], settings)) == 0;
    }
    whole = whole && drawing_settings_write(&settings->drawing, root);
    char* text = whole ? json_dumps(root, JSON_INDENT(1) | JSON_REAL_PRECISION(6)) : NULL;
    json_decref(root);
    return text;
}

/// @return false if there is no folder for settings
static bool find_file(char* path, size_t size, bool makes_folder)
{
    const char* config = getenv("XDG_CONFIG_HOME");
    const char* home = getenv("HOME");
    char base[PATH_MAX - 64];
    bool named = config != NULL && config[0] == '/';
    if (!named && (home == NULL || home[0] != '/')) {
        return false;
    }
    int length = named ? snprintf(base, sizeof(base), "%s", config)
                       : snprintf(base, sizeof(base), "%s/.config", home);
    if (length < 0 || (size_t)length >= sizeof(base)) {
        return false;
    }
    if (makes_folder) {
        (void)mkdir(base, 0777);
        length = snprintf(path, size, "%s/stipple", base);
        (void)mkdir(path, 0777);
    }
    length = snprintf(path, size, "%s/stipple/viewer.json", base);
    return length > 0 && (size_t)length < size;
}

void viewer_settings_load(viewer_settings* settings)
{
    char path[PATH_MAX], text[8192];
    if (find_file(path, sizeof(path), false)) {
        text[stp_file_peek(path, text, sizeof(text) - 1)] = 0;
        (void)viewer_settings_parse(settings, text);
    }
}

void viewer_settings_save(const viewer_settings* settings)
{
    char path[PATH_MAX], aside[PATH_MAX + 8];
    char* text = viewer_settings_print(settings);
    if (text != NULL && find_file(path, sizeof(path), true)) {
        snprintf(aside, sizeof(aside), "%s.new", path);
        FILE* file = fopen(aside, "wb");
        bool written = file != NULL && fputs(text, file) >= 0;
        written = file != NULL && fclose(file) == 0 && written;
        if (!written || rename(aside, path) != 0) {
            (void)remove(aside);
        }
    }
    free(text);
}
