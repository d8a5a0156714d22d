// SPDX-License-Identifier: MIT
// The sRGB transfer function (IEC 61966-2-1), without the C library's pow: the same bits everywhere.
#pragma once

#include <stdint.h>

/// Decodes one 8-bit channel: 0..1 linear.
float stp_srgb8_to_linear(uint8_t value);

/// Encodes 0..1 linear (clamped; not-a-number becomes 0) to the 8-bit value that decodes nearest to it.
uint8_t stp_linear_to_srgb8(float linear);
