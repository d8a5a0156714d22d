// SPDX-License-Identifier: MIT
#include "lab/scan/scan_sweep.h"

#include <assert.h>

#define SWATH_PER_HEIGHT 1.1547005383792515 ///< twice the tangent of 30 degrees
#define OVERLAP 1.25                        ///< swath of a line over the distance to the next
#define RADIANS 0.017453292519943295

enum { MAX_COLUMNS = 65535 };

stp_result scan_plan_flight(const scan_target* target, double height, double step, uint32_t count,
                            scan_settings* settings, scan_station* lines)
{
    stp_boxd b = stp_caster_bounds(target->caster);
    assert(count > 0 && step > 0.0 && settings->rows > 0 && "the resolution is set before");
    stp_vec3d size = stp_subd(b.max, b.min);
    bool east = size.x >= size.y;
    double length = east ? size.x : size.y, width = east ? size.y : size.x;
    double minimum = fmax(1e-6, 0.01 * (length + size.z)); // width of a model without an area
    double apart = fmax(width, minimum) / count;
    length = fmax(length, minimum);
    height = height > 0.0 ? height : OVERLAP * apart / SWATH_PER_HEIGHT;
    double columns = ceil(length / (height * step * RADIANS));
    if (columns > (double)MAX_COLUMNS) {
        return stp_fail(target->context, STP_ERROR_LIMIT,
                        "a flight of %.6g m at %.6g m needs %.0f lines of rays, more than the "
                        "maximum of %d: choose a coarser --resolution or a larger --height",
                        length, height, columns, MAX_COLUMNS);
    }
    settings->columns = (uint32_t)columns;
    settings->half = height;
    for (uint32_t i = 0; i < count; ++i) { // there and back
        double across = ((double)i + 0.5) * apart, way = i % 2 == 0 ? length : -length;
        double from = i % 2 == 0 ? 0.0 : length, top = b.max.z + height;
        lines[i] =
            (scan_station){.number = i + 1,
                           .columns = settings->columns,
                           .rows = settings->rows,
                           .place = east ? (stp_vec3d){b.min.x + from, b.min.y + across, top}
                                         : (stp_vec3d){b.min.x + across, b.min.y + from, top},
                           .along = east ? (stp_vec3d){way, 0.0, 0.0} : (stp_vec3d){0.0, way, 0.0}};
    }
    return STP_OK;
}
