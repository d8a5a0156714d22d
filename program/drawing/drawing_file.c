// SPDX-License-Identifier: MIT
//
// Drawing settings in the viewer's settings file: the rows that have a key.
#include "program/drawing/drawing_table.h"

#include <string.h>

static const double full_byte = 255.0;
static const char* const color_keys[3] = {"red", "green", "blue"};

static void read_color(uint8_t color[3], const json_t* root)
{
    for (int i = 0; i < 3; ++i) {
        const json_t* value = json_object_get(root, color_keys[i]);
        double share = json_number_value(value);
        if (json_is_number(value) && share >= 0.0 && share <= 1.0) {
            color[i] = (uint8_t)(share * full_byte + 0.5);
        }
    }
}

static bool write_color(const uint8_t color[3], json_t* root)
{
    bool written = true;
    for (int i = 0; i < 3; ++i) {
        written = json_object_set_new(root, color_keys[i], json_real(color[i] / full_byte)) == 0 &&
                  written;
    }
    return written;
}

static void read_row(const drawing_row* row, drawing_settings* settings, const json_t* value)
{
    uint32_t choices = drawing_choice_count(row);
    double high = choices > 0 ? (double)choices - 1.0 : row->high;
    if (row->option.type == OPTION_SWITCH && choices == 0) {
        if (json_is_boolean(value)) {
            drawing_set_index(row, settings, json_is_true(value));
        }
        return;
    }
    double number = json_number_value(value);
    if (!json_is_number(value) || number < row->low || number > high) {
        return;
    }
    if (row->option.type == OPTION_FLOAT) {
        drawing_set_number(row, settings, number);
    } else {
        drawing_set_index(row, settings, (uint64_t)number);
    }
}

static json_t* write_row(const drawing_row* row, const drawing_settings* settings)
{
    if (row->option.type == OPTION_FLOAT) {
        return json_real((double)drawing_get_number(row, settings));
    }
    uint64_t index = drawing_get_index(row, settings);
    return row->option.type == OPTION_SWITCH && drawing_choice_count(row) == 0
               ? json_boolean(index != 0)
               : json_integer((json_int_t)index);
}

void drawing_settings_read(drawing_settings* settings, const json_t* root)
{
    size_t count;
    const drawing_row* rows = drawing_rows(&count);
    for (size_t i = 0; i < count; ++i) {
        if (rows[i].key != NULL && rows[i].option.type == OPTION_COLOR) {
            read_color(drawing_color(&rows[i], settings), root);
        } else if (rows[i].key != NULL) {
            read_row(&rows[i], settings, json_object_get(root, rows[i].key));
        }
    }
}

bool drawing_settings_write(const drawing_settings* settings, json_t* root)
{
    size_t count;
    const drawing_row* rows = drawing_rows(&count);
    drawing_settings copy = *settings;
    bool written = true;
    for (size_t i = 0; i < count; ++i) {
        if (rows[i].key != NULL && rows[i].option.type == OPTION_COLOR) {
            written = write_color(drawing_color(&rows[i], &copy), root) && written;
        } else if (rows[i].key != NULL) {
            json_t* value = write_row(&rows[i], settings);
            written = json_object_set_new(root, rows[i].key, value) == 0 && written;
        }
    }
    return written;
}
