// SPDX-License-Identifier: MIT
//
// Attributes of scanned points in a file (docs/format.md, Attributes). Each octave of a set whose
// splats are points has a block, and so has each original point set. A block stores each attribute
// as a column in chunks, so one attribute is read without the others. Readers that ask for none
// skip the blocks.
#pragma once

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

// Colours points by an attribute and hides classes. The results replace the file's own colours and
// coverages when data is loaded, so renderers need not know:
//
//   colour      from the attribute's value; splats and points without it keep their colour
//   coverage 0  hides a splat. The smallest stored coverage (code 0, 1 of 255) becomes
//               the next one (code 1)
//   alpha 0     hides a point
typedef struct stp_store_coloring {
    bool by_attribute;
    stp_attribute attribute;
    double low, high; ///< ends of a continuous scale
    bool hides;
    uint8_t shown[256]; ///< whether points of a class are drawn; only read if `hides`
} stp_store_coloring;

/// Whether an attribute is categorical (distinct colours) rather than continuous.
bool stp_attribute_is_distinct(stp_attribute attribute);

/// Sets how a store's points are coloured; NULL or all zero: as stored. Drops loaded data and
/// invalidates pointers to it. Not allowed while a residency is attached. @return STP_OK,
/// STP_ERROR_ARGUMENT (logged)
STP_MUST_USE stp_result stp_store_set_coloring(stp_store* store,
                                               const stp_store_coloring* coloring);
/// The current colouring; never NULL.
const stp_store_coloring* stp_store_get_coloring(const stp_store* store);
