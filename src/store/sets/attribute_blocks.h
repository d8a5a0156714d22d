// SPDX-License-Identifier: MIT
//
// Attributes of scanned points in a file (docs/format.md, Attributes). Each octave of a set whose
// splats are points has a block, and so has each original point set. A block stores each attribute
// as a column in chunks, so one attribute is read without the others. Readers that ask for none
// skip the blocks.
#pragma once

#include "store/bytes/deflate.h"
#include "store/file/store.h"

#include <stipple/attributes.h>

/// Statistics of one attribute, known without reading its values. The directory sorts them by
/// attribute.
typedef struct stp_store_attribute {
    uint32_t attribute; ///< stp_attribute
    uint64_t count;     ///< values over all original points, each point counted once
    double low, high;
    double low_percentile, high_percentile; ///< the 2nd and 98th percentile
} stp_store_attribute;

/// Number of points with one value of a categorical attribute such as the class.
typedef struct stp_store_attribute_value {
    uint32_t attribute, value;
    uint64_t count;
} stp_store_attribute_value;

/// Statistics of an attribute. @return NULL if the file does not have it
const stp_store_attribute* stp_store_find_attribute(const stp_store* store,
                                                    stp_attribute attribute);

/// Bit mask of the attributes that are stored for an octave of a set, or for a point set.
uint32_t stp_store_octave_attributes(const stp_store* store, uint32_t set, uint32_t octave);
uint32_t stp_store_point_attributes(const stp_store* store, uint32_t point_set);

/// Values of splats [first, first + count) of a set, in their memory format (stipple/attributes.h).
/// Octaves without the attribute, or beyond the end of a partial file, give 0. @return STP_OK,
/// STP_ERROR_FORMAT, STP_ERROR_ARGUMENT (no such set, or too few splats); logged
STP_MUST_USE stp_result stp_store_get_values(stp_store* store, uint32_t set,
                                             stp_attribute attribute, uint32_t first,
                                             uint32_t count, void* values);
/// The same for a point set.
STP_MUST_USE stp_result stp_store_get_point_values(stp_store* store, uint32_t point_set,
                                                   stp_attribute attribute, uint32_t first,
                                                   uint32_t count, void* values);

/// The file's coordinate system, if all sources that name one agree; else NULL.
const char* stp_store_coordinate_system(const stp_store* store);

/// Converts a value to a number.
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
