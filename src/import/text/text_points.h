// SPDX-License-Identifier: MIT
//
// Reads lines of points into a cloud, on all threads. A line fills one cell; lines without a point
// leave theirs empty.
#pragma once

#include "import/reading/cloud.h"
#include "import/text/text_columns.h"

typedef struct stp_text_points {
    // set by the caller:
    stp_cloud* cloud; ///< created; its cells are filled
    const stp_text_blocks* blocks;
    stp_columns columns;
    uint64_t first_line; ///< cell 0; as many lines as the cloud has cells are read
    stp_text first_at;   ///< start of that line; NULL: it is searched in its block
    bool strict;         ///< no line may be blank, a comment or a count
    bool zero_is_empty;  ///< a point at the origin counts as empty
    bool color_fractions;
    stp_column_ranges ranges; ///< expected; then those of all points
    // results:
    uint64_t declared;   ///< points by all count lines
    uint64_t lines;      ///< lines with a point, or with a non-finite position
    uint64_t not_finite; ///< lines with a position that is not finite
    uint64_t count_lines;
} stp_text_points;

/// The columns of a cloud that the columns of a text fill.
stp_point_columns_desc stp_text_points_wants(const stp_columns* columns);

/// Fills all cells. Colours range to 255 (or 1 if written as fractions up to 1; or 65535 if one is
/// above 255), intensities as in scan_values.h. If the actual values need other scales than the
/// expected ranges, the text is read a second time. @return STP_OK; STP_ERROR_FORMAT for an invalid
/// line (unless `strict`, the last one is reported as a loss instead); STP_ERROR_OUT_OF_MEMORY,
/// STP_ERROR_CANCELLED (logged)
STP_MUST_USE stp_result stp_text_points_read(stp_text_points* points);

/// Reads a complete file with one point per line (format_xyz.c), z up. `intensity_first` as for
/// stp_columns_find.
STP_MUST_USE stp_result stp_points_text_read(stp_import* import, bool intensity_first);
