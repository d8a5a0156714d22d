// SPDX-License-Identifier: MIT
// Colours of vertices and faces. Properties of 8 bits and fractions have a known range. Wider whole
// numbers often hold 8-bit values, and floats too: the largest value of the file decides.
#include "import/ply/ply.h"

#include <assert.h>

enum { ABOVE_1 = 1, ABOVE_8_BITS = 2, ABOVE_16_BITS = 4 };

static const char* const names[4] = {"red r diffuse_red", "green g diffuse_green",
                                     "blue b diffuse_blue", "alpha a diffuse_alpha"};

bool stp_ply_find_colors(const stp_ply_element* element, stp_ply_colors* colors)
{
    atomic_init(&colors->seen, 0);
    atomic_init(&colors->seen_alpha, 0);
    for (int channel = 0; channel < 4; ++channel) {
        colors->slots[channel] = NULL;
        for (size_t i = 0; i < element->property_count; ++i) {
            const stp_ply_property* property = &element->properties[i];
            if (!property->is_list && colors->slots[channel] == NULL &&
                stp_ply_is_one_of(property->name, names[channel])) {
                colors->slots[channel] = property;
            }
        }
    }
    bool complete =
        colors->slots[0] != NULL && colors->slots[1] != NULL && colors->slots[2] != NULL;
    colors->wide = false;
    for (int channel = 0; channel < 4; ++channel) {
        const stp_ply_property* slot = complete ? colors->slots[channel] : NULL;
        colors->slots[channel] = slot;
        colors->wide = colors->wide || (slot != NULL && slot->type > STP_PLY_UINT8);
    }
    return complete;
}

void stp_ply_note_wide_color(stp_ply_colors* colors, int channel, double value)
{
    assert(channel >= 0 && channel < 4 && colors->slots[channel] != NULL);
    atomic_uint* seen = channel < 3 ? &colors->seen : &colors->seen_alpha;
    unsigned bit = value > 65535.0 ? ABOVE_16_BITS : value > 255.0 ? ABOVE_8_BITS : ABOVE_1;
    if ((atomic_load_explicit(seen, memory_order_relaxed) & bit) == 0) {
        atomic_fetch_or_explicit(seen, bit, memory_order_relaxed);
    }
}

static float white_of_integers(stp_ply_type type, unsigned seen)
{
    static const float largest[] = {127.0f,   255.0f,        32767.0f,
                                    65535.0f, 2147483647.0f, 4294967295.0f};
    assert(type < STP_PLY_FLOAT32);
    return type <= STP_PLY_UINT8 || (seen & ABOVE_16_BITS) != 0 ? largest[type]
           : (seen & ABOVE_8_BITS) == 0                         ? 255.0f
           : type == STP_PLY_INT16                              ? 32767.0f
                                                                : 65535.0f;
}

stp_ply_color_scale stp_ply_find_color_scale(const stp_ply_colors* colors)
{
    stp_ply_color_scale scale;
    for (int channel = 0; channel < 4; ++channel) {
        const stp_ply_property* property = colors->slots[channel];
        unsigned seen = atomic_load(channel < 3 ? &colors->seen : &colors->seen_alpha);
        scale.factor[channel] = scale.divisor[channel] = 1.0f;
        if (property == NULL) {
            continue;
        }
        if (property->type < STP_PLY_FLOAT32) {
            scale.divisor[channel] = white_of_integers(property->type, seen);
        } else if (channel < 3 && (seen & (ABOVE_8_BITS | ABOVE_16_BITS)) != 0) {
            scale.divisor[channel] = 65535.0f;
        } else if (channel < 3 && seen != 0) {
            scale.factor[channel] = 1.0f / 255.0f;
        }
    }
    return scale;
}
