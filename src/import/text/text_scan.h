// SPDX-License-Identifier: MIT
//
// Parses numbers eight digits at a time, which dominates the time of reading text scans.
#pragma once

#include "base/io/bytes.h"
#include "import/reading/text.h"

#include <assert.h>

enum { STP_SCAN_MARGIN = 64 }; ///< bytes behind the text that must be readable

// Number of leading digits among the next eight bytes. *values receives the value of each byte.
static inline unsigned stp_scan_digits(stp_text at, uint64_t* values)
{
    *values = stp_read_u64(at) ^ UINT64_C(0x3030303030303030);
    uint64_t others =
        ((*values + UINT64_C(0x7676767676767676)) | *values) & UINT64_C(0x8080808080808080);
    return others == 0 ? 8 : (unsigned)__builtin_ctzll(others) >> 3;
}

// The number formed by the first `count` (1 to 8) of eight digits, combined in pairs and fours.
static inline uint64_t stp_join_digits(uint64_t values, unsigned count)
{
    assert(count >= 1 && count <= 8);
    values <<= 64 - 8 * count;
    values = values * 10 + (values >> 8);
    uint64_t low = (values & UINT64_C(0x000000FF000000FF)) * UINT64_C(0x000F424000000064);
    uint64_t high = (values >> 16 & UINT64_C(0x000000FF000000FF)) * UINT64_C(0x0000271000000001);
    return (low + high) >> 32;
}

/// As stp_read_number, with the same value to the last bit, for text with STP_SCAN_MARGIN readable
/// bytes behind it.
static inline stp_text stp_scan_number(stp_text start, double* value)
{
    static const double tens[] = {1e0, 1e1, 1e2,  1e3,  1e4,  1e5,  1e6,  1e7,
                                  1e8, 1e9, 1e10, 1e11, 1e12, 1e13, 1e14, 1e15};
    static const uint64_t whole_tens[] = {1, 10, 100, 1000, 10000, 100000, 1000000, 10000000};
    uint64_t values, digits = 0;
    bool negative = *start == '-';
    stp_text at = start + negative;
    unsigned whole = stp_scan_digits(at, &values), fraction = 0;
    if (whole == 0 || whole == 8) {
        return stp_read_number(start, value);
    }
    digits = stp_join_digits(values, whole);
    at += whole;
    if (*at == '.') {
        at += 1;
        fraction = stp_scan_digits(at, &values);
        if (fraction == 8) {
            digits = digits * 100000000 + stp_join_digits(values, 8);
            unsigned more = stp_scan_digits(at + 8, &values);
            if (more == 8 || whole + 8 + more > 18) {
                return stp_read_number(start, value);
            }
            digits = more > 0 ? digits * whole_tens[more] + stp_join_digits(values, more) : digits;
            fraction += more;
        } else if (fraction > 0) {
            digits = digits * whole_tens[fraction] + stp_join_digits(values, fraction);
        }
        at += fraction;
    }
    if ((*at | 0x20) == 'e' || *at == '#') {
        return stp_read_number(start, value);
    }
    assert(whole + fraction <= 18 && digits < UINT64_C(1000000000000000000));
    assert(fraction < sizeof(tens) / sizeof(tens[0]));
    double magnitude = (double)(int64_t)digits;
    if (fraction > 0) { // predicted, as columns repeat; a division takes longer than the rest
        magnitude /= tens[fraction];
    }
    uint64_t bits;
    memcpy(&bits, &magnitude, sizeof(bits));
    bits |= (uint64_t)negative << 63; // a branch would often be mispredicted
    memcpy(value, &bits, sizeof(bits));
    return at;
}
