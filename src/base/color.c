// SPDX-License-Identifier: MIT
#include "base/color.h"

#include "base/color_table.h"

float stp_srgb8_to_linear(uint8_t value)
{
    return srgb_decoded[value];
}

uint8_t stp_linear_to_srgb8(float linear)
{
    int low = 0, high = 255; // how many thresholds are at or below `linear`
    while (low < high) {
        int middle = (low + high) / 2;
        if (linear >= srgb_threshold[middle]) {
            low = middle + 1;
        } else {
            high = middle;
        }
    }
    return (uint8_t)low;
}
