// SPDX-License-Identifier: MIT
//
// Attributes of scanned points in a file (docs/format.md, Attributes): a block for each octave of a set whose splats are points,
// and for each original point set. Blocks hold columns in chunks, so that one column is read without the others, and readers that
// ask for none skip them.
#pragma once

#include "store/deflate.h"
#include "store/store.h"

#include <stipple/attributes.h>

/// What is known of a file's attribute without reading values. The directory lists them by attribute.
typedef struct stp_store_attribute {
    uint32_t attribute; ///< stp_attribute
    uint64_t count;     ///< values of all original points, each once
    double low, high;
    double low_percentile, high_percentile; ///< 2 and 98 of 100 lie below
} stp_store_attribute;

/// How many points have a value: of classes.
typedef struct stp_store_attribute_value {
    uint32_t attribute, value;
    uint64_t count;
} stp_store_attribute_value;

/// Whether a file has an attribute. @return NULL: it does not
const stp_store_attribute* stp_store_find_attribute(const stp_store* store,
                                                    stp_attribute attribute);

/// The attributes that the values of a set's octave, or of a point set, are there of: a bit each.
uint32_t stp_store_octave_attributes(const stp_store* store, uint32_t set, uint32_t octave);
uint32_t stp_store_point_attributes(const stp_store* store, uint32_t point_set);

/// Values of splats [first, first + count) of a set, as they are in memory (stipple/attributes.h), 0 where an octave has none.
/// @return STP_OK, STP_ERROR_FORMAT, STP_ERROR_TRUNCATED, STP_ERROR_ARGUMENT (there are fewer splats); logged
STP_MUST_USE stp_result stp_store_get_values(stp_store* store, uint32_t set,
                                             stp_attribute attribute, uint32_t first,
                                             uint32_t count, void* values);
/// The same of a point set.
STP_MUST_USE stp_result stp_store_get_point_values(stp_store* store, uint32_t point_set,
                                                   stp_attribute attribute, uint32_t first,
                                                   uint32_t count, void* values);

/// The coordinate system of a file: what its sources that tell one agree on. NULL: they do not, or none tells.
const char* stp_store_coordinate_system(const stp_store* store);

/// A value as a number.
static inline double stp_attribute_number(stp_attribute attribute, const void* values, size_t index)
{
    switch (attribute) {
    case STP_ATTRIBUTE_TIME:
        return ((const double*)values)[index];
    case STP_ATTRIBUTE_SCAN_ANGLE:
        return (double)((const int16_t*)values)[index];
    case STP_ATTRIBUTE_INTENSITY:
    case STP_ATTRIBUTE_SOURCE:
    case STP_ATTRIBUTE_NEAR_INFRARED:
        return (double)((const uint16_t*)values)[index];
    default:
        return (double)((const uint8_t*)values)[index];
    }
}
