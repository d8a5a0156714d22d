// SPDX-License-Identifier: MIT
#include "program/viewer/model/settings.h"

#include "base/io/file.h"
#include "program/options/cloud_style.h"
#include "program/viewer/model/splat_count.h"

#include <assert.h>
#include <jansson.h>
#include <limits.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

typedef enum field_type { FIELD_BOOL, FIELD_INT, FIELD_WHOLE, FIELD_FLOAT } field_type;

typedef struct field {
    const char* name;
    field_type type;
    size_t offset;
    double minimum, maximum;
} field;

#define PLACE(member) offsetof(viewer_settings, member)
static const field fields[] = {
    {"backend", FIELD_INT, PLACE(backend), 0, BACKEND_COUNT - 1},
    {"parts", FIELD_BOOL, PLACE(parts), 0, 0},
    {"page", FIELD_INT, PLACE(page), 0, PAGE_COUNT - 1},
    {"adapts", FIELD_BOOL, PLACE(adapts), 0, 0},
    {"budget_ms", FIELD_FLOAT, PLACE(budget_ms), 4, 500},
    {"splat_size", FIELD_FLOAT, PLACE(splat_size), 1, 16},
    {"splat_count", FIELD_WHOLE, PLACE(splat_count), 0, SPLAT_COUNT_MAX},
    {"samples", FIELD_INT, PLACE(samples), 1, 8},
    {"method", FIELD_INT, PLACE(method), 0, METHOD_COUNT - 1},
    {"splats_by", FIELD_INT, PLACE(splats_by), 0, STP_METHOD_STOCHASTIC},
    {"filter", FIELD_INT, PLACE(filter), 0, STP_FILTER_EWA},
    {"light", FIELD_INT, PLACE(light), 0, 1},
    {"unit", FIELD_INT, PLACE(unit), 0, UNIT_COUNT - 1},
    {"point_sizing", FIELD_INT, PLACE(point_sizing), 0, STP_POINTS_UNITS},
    {"point_scale", FIELD_FLOAT, PLACE(point_scale), 0.25, 4},
    {"point_pixels", FIELD_FLOAT, PLACE(point_pixels), 1, CLOUD_POINT_PIXELS},
    {"point_metres", FIELD_FLOAT, PLACE(point_metres), 1e-6, 1e6},
    {"guides", FIELD_BOOL, PLACE(guides), 0, 0},
    {"caps", FIELD_BOOL, PLACE(caps), 0, 0},
    {"fovea", FIELD_BOOL, PLACE(fovea), 0, 0},
    {"fovea_factor", FIELD_FLOAT, PLACE(fovea_factor), 1, 8},
    {"eye_dome_strength", FIELD_FLOAT, PLACE(eye_dome), -1, 4},
    {"ambient_occlusion", FIELD_FLOAT, PLACE(ambient_occlusion), 0, 12},
    {"red", FIELD_FLOAT, PLACE(background[0]), 0, 1},
    {"green", FIELD_FLOAT, PLACE(background[1]), 0, 1},
    {"blue", FIELD_FLOAT, PLACE(background[2]), 0, 1},
    {"shot_width", FIELD_INT, PLACE(shot_width), 16, 16384},
    {"shot_height", FIELD_INT, PLACE(shot_height), 16, 16384},
    {"shot_samples", FIELD_INT, PLACE(shot_samples), 1, 8},
};
enum { FIELD_COUNT = sizeof(fields) / sizeof(fields[0]) };

viewer_settings viewer_settings_default(void)
{
    return (viewer_settings){.parts = true,
                             .page = PAGE_NONE,
                             .point_scale = 1.0f,
                             .point_pixels = 3.0f,
                             .point_metres = 0.05f,
                             .eye_dome = -1.0f,
                             .guides = true,
                             .adapts = true,
                             .budget_ms = 33.0f,
                             .splat_size = 1.0f,
                             .samples = 4,
                             .fovea_factor = 2.0f,
                             .ambient_occlusion = 3.0f,
                             .caps = true,
                             .background = {0.86f, 0.88f, 0.90f},
                             .shot_width = 3840,
                             .shot_height = 2160,
                             .shot_samples = 2};
}

bool viewer_settings_parse(viewer_settings* settings, const char* text)
{
    json_t* root = json_loads(text, 0, NULL);
    bool valid = json_is_object(root);
    for (int i = 0; valid && i < FIELD_COUNT; ++i) {
        const field* f = &fields[i];
        const json_t* value = json_object_get(root, f->name);
        char* place = (char*)settings + f->offset;
        if (f->type == FIELD_BOOL && json_is_boolean(value)) {
            bool on = json_is_true(value);
            memcpy(place, &on, sizeof(on));
        } else if (f->type != FIELD_BOOL && json_is_number(value)) {
            double number = json_number_value(value);
            if (number >= f->minimum && number <= f->maximum) {
                int whole = f->type == FIELD_INT ? (int)number : 0;
                uint32_t count = f->type == FIELD_WHOLE ? (uint32_t)number : 0;
                float real = (float)number;
                memcpy(place,
                       f->type == FIELD_INT     ? (const void*)&whole
                       : f->type == FIELD_WHOLE ? (const void*)&count
                                                : (const void*)&real,
                       sizeof(whole));
            }
        }
    }
    json_decref(root);
    return valid;
}

char* viewer_settings_print(const viewer_settings* settings)
{
    json_t* root = json_object();
    bool whole = root != NULL;
    for (int i = 0; whole && i < FIELD_COUNT; ++i) {
        const field* f = &fields[i];
        const char* place = (const char*)settings + f->offset;
        bool on;
        int number;
        uint32_t count;
        float real;
        assert(f->offset + sizeof(number) <= sizeof(*settings) && "any type is read at any field");
        memcpy(&on, place, sizeof(on));
        memcpy(&number, place, sizeof(number));
        memcpy(&count, place, sizeof(count));
        memcpy(&real, place, sizeof(real));
        json_t* value = f->type == FIELD_BOOL    ? json_boolean(on)
                        : f->type == FIELD_INT   ? json_integer(number)
                        : f->type == FIELD_WHOLE ? json_integer((json_int_t)count)
                                                 : json_real((double)real);
        whole = json_object_set_new(root, f->name, value) == 0;
    }
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
