// SPDX-License-Identifier: MIT
// CSS colour names and hexadecimal colours.
#pragma once

#include <stdbool.h>
#include <stdint.h>

/// Reads a CSS colour name (ignoring case), or RRGGBB or RGB in hexadecimal, with or without "#".
/// @param color receives red, green and blue, sRGB
/// @return false if the text is not a colour
bool color_parse(const char* text, uint8_t color[3]);
