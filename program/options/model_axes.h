// SPDX-License-Identifier: MIT
// Up axis and unit of a model: choices of options and of the viewer.
#pragma once

#include "program/options/command.h"

#define MODEL_UP_WORDS "x|-x|y|-y|z|-z"
#define MODEL_UNIT_WORDS "m|mm|cm|in|ft|us-ft"

enum { MODEL_UPS = 6, MODEL_UNITS = 6 };

extern const char* const model_up_names[MODEL_UPS];
extern const char model_up_axes[MODEL_UPS]; ///< as stp_import_desc.up
extern const char* const model_unit_names[MODEL_UNITS];
extern const double model_unit_metres[MODEL_UNITS];

/// The choices, by their places in the words.
typedef struct model_axes {
    int up, unit;
    bool has_up, has_unit; ///< they were given
} model_axes;

/// As stp_import_desc.up; 0: not given.
char model_axes_up(const model_axes* axes);
/// Length of one unit in metres; 0: not given.
double model_axes_unit(const model_axes* axes);

// Options that correct what the file of a model says; checked by tool_take_axes.
#define OPTION_MODEL_UP(NAME, axes)                                                                \
    {                                                                                              \
        .name = (NAME), .type = OPTION_CHOICE, .argument = "AXIS", .words = MODEL_UP_WORDS,        \
        .help = "up axis of the model, whatever its file says", .value = &(axes)->up,              \
        .given = &(axes)->has_up, .group = "Input", .rare = true                                   \
    }
#define OPTION_MODEL_UNIT(axes)                                                                    \
    {                                                                                              \
        .name = "unit", .type = OPTION_CHOICE, .words = MODEL_UNIT_WORDS,                          \
        .help = "unit of length of the model, whatever its file says", .value = &(axes)->unit,     \
        .given = &(axes)->has_unit, .group = "Input", .rare = true                                 \
    }
