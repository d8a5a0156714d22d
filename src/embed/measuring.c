// SPDX-License-Identifier: MIT
#include "embed/measuring.h"

#include <stdio.h>

static double degrees(double radians)
{
    return radians * (180.0 / STP_PI);
}

stp_distance stp_measure_distance(stp_vec3d from, stp_vec3d to)
{
    stp_vec3d way = stp_subd(to, from);
    stp_distance d = {.length = stp_lengthd(way), .height = way.y};
    d.horizontal = stp_lengthd((stp_vec3d){way.x, 0, way.z});
    d.slope = d.length > 0.0 ? degrees(atan2(d.height, d.horizontal)) : 0.0;
    return d;
}

double stp_measure_angle(stp_vec3d from, stp_vec3d corner, stp_vec3d to)
{
    stp_vec3d a = stp_normalized(stp_subd(from, corner));
    stp_vec3d b = stp_normalized(stp_subd(to, corner));
    if (stp_lengthd(a) == 0.0 || stp_lengthd(b) == 0.0) {
        return 0.0;
    }
    // unlike the arc cosine, exact near 0 and 180 degrees too (Kahan)
    return degrees(2.0 * atan2(stp_lengthd(stp_subd(a, b)), stp_lengthd(stp_addd(a, b))));
}

double stp_measure_area(const stp_vec3d* points, size_t count, double* perimeter)
{
    stp_vec3d twice = {0, 0, 0};
    double around = 0.0;
    count = points != NULL ? count : 0;
    for (size_t i = 0; i < count; ++i) { // relative to the first: survey coordinates are large
        stp_vec3d a = stp_subd(points[i], points[0]);
        stp_vec3d b = stp_subd(points[(i + 1) % count], points[0]);
        twice = stp_addd(twice, stp_crossd(a, b));
        around += stp_lengthd(stp_subd(b, a));
    }
    if (perimeter != NULL) {
        *perimeter = around;
    }
    return count >= 3 ? 0.5 * stp_lengthd(twice) : 0.0;
}

stp_vec3d stp_measure_coordinates(const stp_measuring* measuring, stp_vec3d p)
{
    char up = measuring != NULL ? measuring->up : 'y';
    return up == 'z' ? (stp_vec3d){p.x, -p.z, p.y} : up == 'x' ? (stp_vec3d){p.y, -p.x, p.z} : p;
}

static double shown_metres(const stp_measuring* m)
{
    return m->unit_metres > 0.0 && m->shown_metres > 0.0 ? m->shown_metres : m->unit_metres;
}

double stp_measure_factor(const stp_measuring* m)
{
    double shown = shown_metres(m);
    return shown > 0.0 && shown != m->unit_metres ? m->unit_metres / shown : 1.0;
}

const char* stp_measure_unit(const stp_measuring* measuring)
{
    static const struct {
        double metres;
        const char* name;
    } units[] = {{1.0, "m"},     {0.001, "mm"},    {0.01, "cm"},
                 {1000.0, "km"}, {0.0254, "in"},   {0.3048, "ft"},
                 {0.9144, "yd"}, {1609.344, "mi"}, {1200.0 / 3937.0, "us-ft"}};
    double shown = shown_metres(measuring);
    for (size_t i = 0; i < sizeof(units) / sizeof(units[0]); ++i) {
        if (fabs(shown - units[i].metres) <= 1e-9 * units[i].metres) {
            return units[i].name;
        }
    }
    return "";
}

void stp_measure_text(const stp_measuring* measuring, double length, int digits, char* text,
                      size_t size)
{
    digits = digits < 1 ? 1 : digits > 17 ? 17 : digits;
    const char* unit = measuring != NULL ? stp_measure_unit(measuring) : "";
    length *= measuring != NULL ? stp_measure_factor(measuring) : 1.0;
    if (text != NULL && size > 0) {
        snprintf(text, size, "%.*g%s%s", digits, length, unit[0] != '\0' ? " " : "", unit);
    }
}
