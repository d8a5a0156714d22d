// SPDX-License-Identifier: MIT
#include "import/stl/stl_colors.h"

#include "base/io/bytes.h"
#include "import/reading/surface.h"

#include <assert.h>
#include <string.h>

enum { TEXT_SIZE = 80, HEADER_SIZE = 84, ATTRIBUTE = 48, MARK = 0x8000, CHANNEL = 31 };

static uint16_t attribute_of(const unsigned char* facets, size_t facet)
{
    return stp_read_u16(facets + facet * STP_STL_FACET_SIZE + ATTRIBUTE);
}

// The four bytes behind "COLOR=" in the header's text; NULL: there are none.
static const unsigned char* header_color(const unsigned char* header)
{
    static const char key[] = "COLOR=";
    const size_t length = sizeof(key) - 1;
    for (size_t i = 0; i + length + 4 <= TEXT_SIZE; ++i) {
        if (memcmp(header + i, key, length) == 0) {
            return header + i + length;
        }
    }
    return NULL;
}

stp_stl_coding stp_stl_find_coding(const unsigned char* bytes, size_t facet_count)
{
    if (header_color(bytes) != NULL) {
        return STP_STL_MAGICS;
    }
    for (size_t i = 0; i < facet_count; ++i) {
        if ((attribute_of(bytes + HEADER_SIZE, i) & MARK) != 0) {
            return STP_STL_VISCAM;
        }
    }
    return STP_STL_PLAIN;
}

uint16_t stp_stl_color_bits(stp_stl_coding coding, const unsigned char* facets, size_t corner)
{
    uint16_t bits = coding != STP_STL_PLAIN ? attribute_of(facets, corner / 3) : 0;
    bool own = ((bits & MARK) != 0) == (coding == STP_STL_VISCAM);
    return own ? bits : coding == STP_STL_MAGICS ? MARK : 0;
}

void stp_stl_color(stp_stl_coding coding, const unsigned char* header, uint16_t bits,
                   uint16_t color[4])
{
    assert(coding != STP_STL_PLAIN);
    const unsigned char* base = coding == STP_STL_MAGICS ? header_color(header) : NULL;
    bool own = ((bits & MARK) != 0) == (coding == STP_STL_VISCAM);
    for (unsigned i = 0; i < 3; ++i) {
        unsigned shift = 5 * (coding == STP_STL_VISCAM ? 2 - i : i);
        float value = own            ? (float)(bits >> shift & CHANNEL) / (float)CHANNEL
                      : base != NULL ? (float)base[i] / 255.0f
                                     : 1.0f;
        color[i] = stp_unorm16(stp_srgb_to_linear(value));
    }
    color[3] = 65535;
}
