// SPDX-License-Identifier: MIT
// Options that say how models are read, checked against the inputs of a command.
#pragma once

#include "program/options/model_axes.h"

/// Sets --columns for all models imported or built from now on; NULL is allowed. @return 0, or the
/// code of a usage error if the list is invalid or applies to none of the inputs
int tool_take_columns(const char* names, int input_count, char** inputs);
/// Sets --smooth likewise; a built file is a usage error.
int tool_take_smooth(double degrees, int input_count, char** inputs);

/// Refuses standard input as a model. @return 0, or the code of a usage error
int tool_check_inputs(int input_count, char** inputs);

/// Corrects the up axis and the unit of all models imported or built from now on. @return 0, or the
/// code of a usage error if the inputs are not models, or tool_check_inputs refuses them
int tool_take_axes(const model_axes* axes, int input_count, char** inputs);
