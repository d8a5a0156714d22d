// SPDX-License-Identifier: MIT
// PTX, Leica's text format for scans: for each station its grid and pose, then all cells; those
// without a point as zeros. Coordinates are relative to the station.
#include "lab/scan/scan_file.h"

#include <assert.h>
#include <stdio.h>

enum { NUMBER_SIZE = 320 }; ///< room for any double with six decimals, and a blank

static stp_result append(scan_file* f, const char* text, int size)
{
    return stp_file_writer_append(f->writer, text, (size_t)size);
}

static stp_result begin_station(scan_file* f, const scan_station* s)
{
    char text[6 * NUMBER_SIZE + 128];
    const double* shift = f->desc.shift;
    double x = s->place.x + shift[0], y = s->place.y + shift[1], z = s->place.z + shift[2];
    // columns, rows, the scanner's position and axes, and the matrix, which is multiplied from the
    // right
    int size = snprintf(text, sizeof(text),
                        "%u\n%u\n%.6f %.6f %.6f\n1 0 0\n0 1 0\n0 0 1\n"
                        "1 0 0 0\n0 1 0 0\n0 0 1 0\n%.6f %.6f %.6f 1\n",
                        s->columns, s->rows, x, y, z, x, y, z);
    assert(size > 0 && (size_t)size < sizeof(text) && "no number is longer");
    return append(f, text, size);
}

static stp_result add(scan_file* f, const scan_station* s, const scan_point* points, size_t count)
{
    static const char miss[] = "0 0 0 0 0 0 0\n";
    stp_result result = STP_OK;
    for (size_t i = 0; i < count && result == STP_OK; ++i) {
        const scan_point* p = &points[i];
        if (!p->hit) {
            result = append(f, miss, sizeof(miss) - 1);
            continue;
        }
        char text[4 * NUMBER_SIZE + 64];
        int size =
            snprintf(text, sizeof(text), "%.6f %.6f %.6f %.6f %u %u %u\n", p->place[0] - s->place.x,
                     p->place[1] - s->place.y, p->place[2] - s->place.z,
                     (double)p->intensity / 65535.0, p->color[0], p->color[1], p->color[2]);
        assert(size > 0 && (size_t)size < sizeof(text) && "no number is longer");
        result = append(f, text, size);
    }
    return result;
}

const scan_format scan_format_ptx = {.ending = ".ptx", .begin_station = begin_station, .add = add};
