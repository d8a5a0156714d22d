// SPDX-License-Identifier: MIT
//
// Point attributes that scanners record besides position, normal and colour. Each attribute has one
// fixed value type; file readers convert to it.
#pragma once

#include <stddef.h>
#include <stdint.h>

typedef enum stp_attribute {
    STP_ATTRIBUTE_INTENSITY,     ///< uint16_t: return strength; 65535 is the strongest
    STP_ATTRIBUTE_CLASS,         ///< uint8_t: classification, ASPRS LAS 1.4, table 17
    STP_ATTRIBUTE_RETURN,        ///< uint8_t: return number within its pulse, from 1
    STP_ATTRIBUTE_RETURNS,       ///< uint8_t: number of returns of the pulse
    STP_ATTRIBUTE_SCAN_ANGLE,    ///< int16_t: 0.006 degrees each, from -30000 to 30000
    STP_ATTRIBUTE_SOURCE,        ///< uint16_t: flight line or station
    STP_ATTRIBUTE_TIME,          ///< double: GPS time in seconds, as in the file
    STP_ATTRIBUTE_NEAR_INFRARED, ///< uint16_t: 65535 is the brightest
    STP_ATTRIBUTES
} stp_attribute;

/// Bit of an attribute in an attribute mask.
static inline uint32_t stp_attribute_bit(stp_attribute attribute)
{
    return 1u << (uint32_t)attribute;
}

/// Size of one value in bytes.
static inline size_t stp_attribute_size(stp_attribute attribute)
{
    static const uint8_t sizes[STP_ATTRIBUTES] = {2, 1, 1, 1, 2, 2, 8, 2};
    return sizes[attribute];
}

/// Name used by commands and labels, such as "intensity".
static inline const char* stp_attribute_name(stp_attribute attribute)
{
    static const char* const names[STP_ATTRIBUTES] = {
        "intensity", "class", "return", "returns", "scan angle", "source", "time", "near infrared"};
    return names[attribute];
}
