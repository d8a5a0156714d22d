// SPDX-License-Identifier: MIT
#include "base/color.h"

#include "base/color_table.h"

float stp_srgb8_to_linear(uint8_t value)
{
    return srgb_decoded[value];
}

uint8_t stp_linear_to_srgb8(float linear)
{
    uint32_t reached =
        0; // how many thresholds are at or below `linear`: found bit by bit, without branches
    for (uint32_t step = 128; step != 0; step /= 2) {
        reached += linear >= srgb_threshold[reached + step - 1] ? step : 0;
    }
    return (uint8_t)reached;
}
