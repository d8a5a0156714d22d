// SPDX-License-Identifier: MIT
//
// Columns of a text file of points: given by the caller or a header line, or detected from their
// number and values.
#pragma once

#include "import/reading/import.h"
#include "import/text/text_blocks.h"

typedef enum stp_column {
    STP_COLUMN_X,
    STP_COLUMN_Y,
    STP_COLUMN_Z,
    STP_COLUMN_R,
    STP_COLUMN_G,
    STP_COLUMN_B,
    STP_COLUMN_INTENSITY,
    STP_COLUMN_NX,
    STP_COLUMN_NY,
    STP_COLUMN_NZ,
    STP_COLUMN_CLASS,
    STP_COLUMN_SKIP,
} stp_column;

enum { STP_COLUMN_SLOTS = STP_COLUMN_SKIP, STP_COLUMNS_MAX = 32 };

typedef struct stp_columns {
    uint8_t roles[STP_COLUMNS_MAX]; ///< an stp_column each
    uint32_t count;                 ///< number of columns up to the last used one
    uint32_t unused;                ///< number of the file's columns that are not used
} stp_columns;

/// Minimum and maximum of each column.
typedef struct stp_column_ranges {
    double low[STP_COLUMN_SLOTS], high[STP_COLUMN_SLOTS];
} stp_column_ranges;

stp_column_ranges stp_column_ranges_empty(void);

static inline bool stp_columns_have(const stp_columns* columns, stp_column column)
{
    for (uint32_t i = 0; i < columns->count; ++i) {
        if (columns->roles[i] == column) {
            return true;
        }
    }
    return false;
}

static inline bool stp_separates(unsigned char c)
{
    return c == ',' || c == ';';
}

/// Reads names like "x,y,z,r,g,b,intensity,nx,ny,nz,class,-"; "-" skips a column. @return NULL, or
/// the error (static text)
const char* stp_columns_parse(const char* names, stp_columns* columns);

/// Layout of a text with one point per line.
typedef struct stp_columns_found {
    stp_columns columns;
    uint64_t first_line;      ///< index of the first line of points, from 0
    uint64_t declared;        ///< points by the count lines before that
    double place[3];          ///< among most points (import/reading/place_sample.h)
    bool color_fractions;     ///< a colour is written with a point or an exponent
    stp_column_ranges ranges; ///< ranges of the sampled lines
} stp_columns_found;

/// Examines the first lines and a sample of the others. import->desc.columns has priority.
/// `intensity_first`: of four columns that might be colours, the first is an intensity. @return
/// STP_OK, STP_ERROR_FORMAT, STP_ERROR_OUT_OF_MEMORY (logged)
STP_MUST_USE stp_result stp_columns_find(stp_import* import, const stp_text_blocks* blocks,
                                         bool intensity_first, stp_columns_found* found);
