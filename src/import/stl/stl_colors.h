// SPDX-License-Identifier: MIT
//
// Colours in the attribute bytes of binary STL files: 5 bits for each of red, green and blue. VisCAM
// and SolidView set bit 15 of a facet with a colour and store red in the upper bits. Magics clears
// it, stores red in the lower bits, and writes the colour of all other facets into the file's
// header, as "COLOR=" and four bytes.
#pragma once

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#define STP_STL_FACET_SIZE ((size_t)50)

typedef enum stp_stl_coding { STP_STL_PLAIN, STP_STL_VISCAM, STP_STL_MAGICS } stp_stl_coding;

/// How the facets of a whole binary file store their colours; `bytes` begins with its 84-byte header.
stp_stl_coding stp_stl_find_coding(const unsigned char* bytes, size_t facet_count);

/// The attribute of a corner's facet; equal for all facets without a colour of their own.
uint16_t stp_stl_color_bits(stp_stl_coding coding, const unsigned char* facets, size_t corner);

/// Its colour: RGBA, linear, 65535 is 1. `header` is the file's.
void stp_stl_color(stp_stl_coding coding, const unsigned char* header, uint16_t bits,
                   uint16_t color[4]);
