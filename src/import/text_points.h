// SPDX-License-Identifier: MIT
//
// Lines of points to a cloud, on all threads. A line fills one cell; lines that hold no point leave
// theirs empty.
#pragma once

#include "import/cloud.h"
#include "import/text_columns.h"

typedef struct stp_text_points {
    // of the caller:
    stp_cloud* cloud; ///< created; its cells are filled
    const stp_text_blocks* blocks;
    stp_columns columns;
    uint64_t first_line; ///< cell 0; as many lines as the cloud has cells are read
    bool strict;         ///< no line may be blank, a comment or a count
    bool zero_is_empty;  ///< what lies in the origin is no point
    bool color_fractions;
    stp_column_ranges ranges; ///< expected; then those of all points
    // found:
    uint64_t declared;   ///< points by all count lines
    uint64_t lines;      ///< that hold a point, or a place that is not finite
    uint64_t not_finite; ///< of them
    uint64_t count_lines;
} stp_text_points;

/// The columns of a cloud that the columns of a text fill.
stp_point_columns_desc stp_text_points_wants(const stp_columns* columns);

/// Fills all cells. Colours run to 255 (or 1, where they are written as fractions up to 1; or
/// 65535, where one is above 255), intensities as intensity.h judges. Where the values of all lines
/// are other than the ranges expected, the text is read a second time.
/// @return STP_OK; STP_ERROR_FORMAT for a line that cannot be read, unless it is the last, which is
/// a loss; STP_ERROR_OUT_OF_MEMORY, STP_ERROR_CANCELLED (logged)
STP_MUST_USE stp_result stp_text_points_read(stp_text_points* points);

/// Reads a whole file of points a line (format_xyz.c), z up. `intensity_first` as for
/// stp_columns_find.
STP_MUST_USE stp_result stp_points_text_read(stp_import* import, bool intensity_first);
