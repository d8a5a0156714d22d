// SPDX-License-Identifier: MIT
// Figure 3 of Brandt et al. 2019: violin and box plots of the spacings of prefixes, orders side by
// side.
#pragma once

#include "program/options/command.h"

/// One violin: the spacings of one prefix of one order, relative to the largest even spacing.
typedef struct plot_violin {
    const char* label; ///< name of the order
    uint32_t count;    ///< points of the prefix
    float* values;     ///< ascending; owned by the caller
    uint32_t value_count;
} plot_violin;

/// Writes an SVG: violins of the same count are grouped, in the given order. Failures are logged.
STP_MUST_USE stp_result plot_violins(stp_context* context, const char* path,
                                     const plot_violin* violins, size_t violin_count);
