// SPDX-License-Identifier: MIT
// Points as written by scanners, and the expected result.
#pragma once

#include "formats_test.h"
#include "las_writer.h"

#include <assert.h>
#include <stdlib.h>

static inline uint32_t las_random(uint32_t* state, uint32_t below)
{
    *state = *state * 1664525u + 1013904223u;
    return (uint32_t)((uint64_t)*state * below >> 32);
}

/// A sequence with everything that occurs in scans: several returns, jumps in position and time,
/// changes of every value.
static inline void las_make_points(las_point* points, size_t count, unsigned format, uint32_t seed)
{
    uint32_t s = seed;
    bool old = format < 6;
    unsigned maximum = old ? 8 : 16;
    double time = 1e9;
    las_point p = {.position = {100000, -200000, 5000}, .return_number = 1, .return_count = 1};
    for (size_t i = 0; i < count; ++i) {
        unsigned far = las_random(&s, 50) == 0 ? 1u << las_random(&s, 31) : 40;
        for (int k = 0; k < 3; ++k) {
            uint32_t step = las_random(&s, far) - far / 3; // below 0, too
            p.position[k] = (int32_t)((uint32_t)p.position[k] + step);
        }
        if (las_random(&s, 3) == 0) {
            p.return_count = (uint8_t)las_random(&s, maximum);
            p.return_number = (uint8_t)las_random(&s, maximum);
        }
        p.channel = (uint8_t)(las_random(&s, 5) == 0 && !old ? las_random(&s, 4) : p.channel);
        p.intensity = (uint16_t)(las_random(&s, 4) == 0 ? las_random(&s, 65536) : p.intensity + 3u);
        p.class = (uint8_t)(las_random(&s, 9) == 0 ? las_random(&s, old ? 32 : 256) : p.class);
        p.flags = (uint8_t)(las_random(&s, 9) == 0 ? las_random(&s, 8) : p.flags);
        p.user = (uint8_t)(las_random(&s, 9) == 0 ? las_random(&s, 256) : p.user);
        p.source = (uint16_t)(las_random(&s, 20) == 0 ? las_random(&s, 65536) : p.source);
        if (las_random(&s, 6) == 0) {
            p.angle =
                (int16_t)(old ? (int)las_random(&s, 181) - 90 : (int)las_random(&s, 60001) - 30000);
        }
        if (las_random(&s, 3) != 0) {
            static const double jumps[] = {1e6, -1e6, 0.3, -0.001, 1e-12, 77.0};
            time += las_random(&s, 20) == 0 ? jumps[las_random(&s, 6)] : 1e-5 * las_random(&s, 3);
        }
        memcpy(&p.time, &time, sizeof(time));
        bool grey = las_random(&s, 4) == 0;
        for (int k = 0; k < 3; ++k) {
            bool same = las_random(&s, 3) == 0;
            p.rgb[k] = (uint16_t)(grey ? p.rgb[0] : same ? p.rgb[k] : las_random(&s, 65536));
        }
        p.nir = (uint16_t)(las_random(&s, 2) == 0 ? las_random(&s, 65536) : p.nir);
        points[i] = p;
    }
}

static inline bool las_same_values(const void* column, const uint64_t* wanted, size_t count,
                                   size_t size)
{
    for (size_t i = 0; i < count; ++i) {
        if (column == NULL || memcmp((const char*)column + i * size, &wanted[i], size) != 0) {
            fprintf(stderr, "point %zu: another value of %zu bytes\n", i, size);
            return false;
        }
    }
    return true;
}

// The attribute of a point, as 8 little-endian bytes.
static inline uint64_t las_attribute(const las_point* p, int attribute, bool old)
{
    switch (attribute) {
    case STP_ATTRIBUTE_INTENSITY:
        return p->intensity;
    case STP_ATTRIBUTE_CLASS:
        return p->class;
    case STP_ATTRIBUTE_RETURN:
        return p->return_number;
    case STP_ATTRIBUTE_RETURNS:
        return p->return_count;
    case STP_ATTRIBUTE_SCAN_ANGLE:
        return (uint16_t)(int16_t)(old ? lround(p->angle / 0.006) : p->angle);
    case STP_ATTRIBUTE_SOURCE:
        return p->source;
    case STP_ATTRIBUTE_TIME:
        return p->time;
    default:
        return p->nir;
    }
}

/// Whether a set holds points [first, first + its count) of the written ones; `place` is its
/// object's transform.
static inline bool las_set_is_right(const las_desc* desc, const stp_point_set* set, size_t first,
                                    const stp_affine* place)
{
    static uint64_t wanted[20000];
    const las_point* points = desc->points + first;
    unsigned format = desc->format;
    bool old = format < 6, has_time = format != 0 && format != 2;
    bool has_rgb =
        format == 2 || format == 3 || format == 5 || format == 7 || format == 8 || format == 10;
    size_t count = set->point_count;
    assert(count <= sizeof(wanted) / sizeof(wanted[0]) && "the array holds a value per point");
    double scale = desc->scale != 0.0 ? desc->scale : 0.01;
    bool good = (set->colors != NULL) == has_rgb;
    for (size_t i = 0; i < count && good; ++i) {
        const float* p = set->positions + 3 * i;
        stp_vec3d at =
            stp_affine_point(place, (stp_vec3d){(double)p[0], (double)p[1], (double)p[2]});
        const int32_t* n = points[i].position; // x, y, z become x, z, -y
        double x = n[0] * scale + desc->offset, y = n[1] * scale + desc->offset,
               z = n[2] * scale + desc->offset;
        double error = fabs(at.x - x) + fabs(at.y - z) + fabs(at.z + y);
        double maximum =
            1e-6 + 1e-7 * (fabs((double)p[0]) + fabs((double)p[1]) + fabs((double)p[2]));
        good = error <= maximum;
        for (int k = 0; k < 3 && has_rgb; ++k) {
            good = good && set->colors[4 * i + (size_t)k] == points[i].rgb[k] >> 8;
        }
        if (!good) {
            fprintf(stderr, "format %u: point %zu: place (off by %g) or colour\n", format,
                    first + i, error);
        }
    }
    for (int a = 0; a < STP_ATTRIBUTES && good; ++a) {
        bool there = a == STP_ATTRIBUTE_TIME            ? has_time
                     : a == STP_ATTRIBUTE_NEAR_INFRARED ? format == 8 || format == 10
                                                        : true;
        for (size_t i = 0; i < count; ++i) {
            wanted[i] = las_attribute(&points[i], a, old);
        }
        good = there ? las_same_values(set->attributes[a], wanted, count,
                                       stp_attribute_size((stp_attribute)a))
                     : set->attributes[a] == NULL;
        if (!good) {
            fprintf(stderr, "format %u: attribute %d\n", format, a);
        }
    }
    return good;
}
