// SPDX-License-Identifier: MIT
#pragma once

#include "program/options/command.h"

/// Reads `text` into the option's value. @return true; or false, with the reason in `problem` as
/// the end of a sentence that begins with the text
bool option_set_value(const option* o, const char* text, char* problem, size_t problem_size);
