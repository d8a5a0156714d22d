// SPDX-License-Identifier: MIT
#pragma once

#include <stipple/base.h>

/// Rows of RGBA bytes, sRGB, top row first. Alpha 0: background; 255: covered.
typedef struct stp_image {
    uint32_t width, height;
    uint8_t* pixels; ///< width * height * 4 bytes
} stp_image;
