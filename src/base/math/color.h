// SPDX-License-Identifier: MIT
// The sRGB transfer function (IEC 61966-2-1) without the C library's pow, so the bits are the same
// everywhere.
#pragma once

#include <stdint.h>

/// Decodes one 8-bit channel to a linear value, 0..1.
float stp_srgb8_to_linear(uint8_t value);

/// Encodes a linear value as the 8-bit code whose decoded value is nearest. Clamps to 0..1; NaN
/// becomes 0.
uint8_t stp_linear_to_srgb8(float linear);
