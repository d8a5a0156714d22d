// SPDX-License-Identifier: MIT
#include "program/files/import_options.h"

#include "import/reading/import.h"
#include "import/text/text_columns.h"
#include "program/files/scene_file.h"
#include "program/options/program.h"
#include "program/options/tool.h"

#include <string.h>
#include <unistd.h>

int tool_take_columns(const char* names, int input_count, char** inputs)
{
    stp_columns columns;
    const char* wrong = names != NULL ? stp_columns_parse(names, &columns) : NULL;
    if (wrong != NULL) {
        return tool_usage_error("--columns %s: %s", names, wrong);
    }
    bool applies = names == NULL || input_count == 0;
    for (int i = 0; i < input_count && !applies; ++i) {
        applies = !program_is_scene(inputs[i]) && stp_import_takes_columns(inputs[i]);
    }
    if (!applies) {
        return tool_usage_error("--columns applies to text point clouds; %s is not one", inputs[0]);
    }
    tool_settings_get()->columns = names;
    return 0;
}

int tool_take_smooth(double degrees, int input_count, char** inputs)
{
    for (int i = 0; degrees > 0.0 && i < input_count; ++i) {
        if (tool_is_store_file(inputs[i])) {
            return tool_usage_error("%s is built; --smooth is an option of build", inputs[i]);
        }
    }
    tool_settings_get()->smooth_degrees = degrees;
    return 0;
}

int tool_check_inputs(int input_count, char** inputs)
{
    for (int i = 0; i < input_count; ++i) {
        bool streams = (strcmp(inputs[i], "-") == 0 && access("-", F_OK) != 0) ||
                       strcmp(inputs[i], "/dev/stdin") == 0 ||
                       strncmp(inputs[i], "/dev/fd/", 8) == 0;
        if (streams) {
            return tool_usage_error("a model cannot come from standard input: its name tells the "
                                    "format, and files beside it may belong to it; write it to a "
                                    "file first");
        }
    }
    return 0;
}

int tool_take_axes(const model_axes* axes, int input_count, char** inputs)
{
    int code = tool_check_inputs(input_count, inputs);
    if (code != 0) {
        return code;
    }
    bool any = axes->has_up || axes->has_unit;
    for (int i = 0; any && i < input_count; ++i) {
        if (program_is_scene(inputs[i])) {
            return tool_usage_error("the axes and the unit of %s are fixed", inputs[i]);
        }
        if (tool_is_store_file(inputs[i])) {
            return tool_usage_error("%s is built; its up axis and unit are options of build",
                                    inputs[i]);
        }
    }
    tool_settings_get()->up = model_axes_up(axes);
    tool_settings_get()->unit_metres = model_axes_unit(axes);
    return 0;
}
