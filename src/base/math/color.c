// SPDX-License-Identifier: MIT
#include "base/math/color.h"

#include "base/math/color_table.h"

#include <assert.h>
#include <math.h>

float stp_srgb8_to_linear(uint8_t value)
{
    return srgb_decoded[value];
}

uint8_t stp_linear_to_srgb8(float linear)
{
    if (!(linear > 0.0f)) {
        return 0;
    }
    if (linear >= 1.0f) {
        return 255;
    }
    // count the thresholds at or below `linear`; the square root gives a good first guess
    uint32_t reached = srgb_start[(uint32_t)(sqrtf(linear) * 255.0f)];
    assert((reached == 0 || linear >= srgb_threshold[reached - 1]) && "the guess is not too high");
    while (reached < 255 && linear >= srgb_threshold[reached]) {
        reached += 1;
    }
    return (uint8_t)reached;
}
