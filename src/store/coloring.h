// SPDX-License-Identifier: MIT
//
// Colours of points by an attribute, and classes that are hidden. They take the places of the file's own colours and coverages
// when data is loaded, so that whoever draws need not know:
//
//   colour      of a splat or point that has the attribute: from its value; others keep theirs
//   coverage 0  of a splat: it is hidden. The smallest share that files hold (code 0, 1 of 255) becomes the next one (code 1)
//   alpha 0     of a point: it is hidden
#pragma once

#include "store/attributes.h"

typedef struct stp_store_coloring {
    bool by_attribute;
    stp_attribute attribute;
    double low, high; ///< of what is coloured on an even scale: the ends of the scale
    bool hides;
    uint8_t shown[256]; ///< whether points of a class are drawn; only looked at where `hides`
} stp_store_coloring;

/// Whether an attribute's values are colours that are told apart, rather than a scale.
bool stp_attribute_is_distinct(stp_attribute attribute);

/// The colour of a value: sRGB.
void stp_store_color_value(const stp_store_coloring* coloring, double value, uint8_t color[3]);

/// Colours a store's points from now on; NULL, or all zero: as they are stored. What was loaded is dropped, and pointers to it
/// end. Not while a residency is attached. @return STP_OK, STP_ERROR_ARGUMENT (logged)
STP_MUST_USE stp_result stp_store_set_coloring(stp_store* store,
                                               const stp_store_coloring* coloring);
/// How points are coloured; never NULL.
const stp_store_coloring* stp_store_get_coloring(const stp_store* store);
