// SPDX-License-Identifier: MIT
#include "lab/scan/scan_sweep.h"

#include "base/math/color.h"
#include "base/math/rng.h"
#include "lab/scenes/trigonometry.h"

#include <assert.h>

#define LOWEST (-60.0) ///< degrees of elevation
#define SPAN 150.0
#define SWATH 60.0 ///< degrees across a flight

double scan_settings_set_resolution(scan_settings* settings, double resolution)
{
    double turn = resolution > 30.0 ? resolution : 360.0 / resolution;
    double span = settings->airborne ? SWATH : SPAN;
    settings->columns = (uint32_t)(turn + 0.5);
    settings->rows = (uint32_t)(turn * span / 360.0 + 0.5);
    settings->columns = settings->columns > 4 ? settings->columns : 4;
    settings->rows = settings->rows > 2 ? settings->rows : 2;
    return span / (double)settings->rows;
}

scan_ray scan_ray_of(const scan_settings* settings, const scan_station* station, uint32_t column,
                     uint32_t row)
{
    assert(column < settings->columns && row < settings->rows);
    double part = ((double)row + 0.5) / (double)settings->rows;
    if (!settings->airborne) {
        double azimuth = (double)column / (double)settings->columns;
        double angle = LOWEST + SPAN * part, level = turn_cosine(angle / 360.0);
        stp_vec3d direction = {level * turn_cosine(azimuth), level * turn_sine(azimuth),
                               turn_sine(angle / 360.0)};
        return (scan_ray){station->place, direction, angle};
    }
    double angle = SWATH * (part - 0.5), side = turn_sine(angle / 360.0);
    double done = ((double)column + 0.5) / (double)settings->columns;
    stp_vec3d ahead = stp_normalized(station->along);
    return (scan_ray){stp_addd(station->place, stp_scaled(station->along, done)),
                      {side * ahead.y, -side * ahead.x, -turn_cosine(angle / 360.0)},
                      angle};
}

/// Nearly normal with deviation 1, and never beyond 6: the sum of twelve uniform numbers.
static double gauss(uint64_t seed, uint64_t index)
{
    uint64_t sum = 0;
    for (uint64_t i = 0; i < 3; ++i) {
        uint64_t bits = stp_rng_hash(seed, 3 * index + i);
        sum += (bits & 0xFFFFu) + (bits >> 16 & 0xFFFFu) + (bits >> 32 & 0xFFFFu) + (bits >> 48);
    }
    return ((double)sum + 6.0) / 65536.0 - 6.0;
}

/// Lambertian reflection; the returned intensity falls with distance.
static uint16_t strength_of(const scan_surface* surface, stp_vec3d direction, double half)
{
    double albedo = 0.2126 * (double)surface->color[0] + 0.7152 * (double)surface->color[1] +
                    0.0722 * (double)surface->color[2];
    double cosine = fabs(stp_dotd(surface->normal, direction));
    double far = surface->distance / half;
    return (uint16_t)(65535.0 * fmin(albedo * cosine, 1.0) / (1.0 + far * far) + 0.5);
}

typedef struct sweep {
    const scan_target* target;
    const scan_settings* settings;
    const scan_station* station;
    uint32_t first;
    scan_point* points;
} sweep;

static void cast_ray(const sweep* s, uint32_t column, uint32_t row, scan_point* point)
{
    const scan_settings* set = s->settings;
    uint64_t cell = (uint64_t)column * set->rows + row, station = s->station->number - 1;
    uint64_t all = (uint64_t)set->columns * set->rows;
    scan_ray ray = scan_ray_of(set, s->station, column, row);
    *point = (scan_point){.row = row,
                          .column = column,
                          .angle = (float)ray.angle,
                          .time = (double)(station * all + cell)};
    scan_surface surface;
    if (!scan_target_intersect(s->target, ray.origin, ray.direction, 0.0, set->range, &surface)) {
        return;
    }
    double error = set->noise * gauss(stp_rng_hash(set->seed, station), cell);
    error = error > -surface.distance ? error : -surface.distance;
    stp_vec3d place = stp_addd(surface.place, stp_scaled(ray.direction, error));
    stp_vec3 normal = stp_to_float(surface.normal);
    point->hit = true;
    point->intensity = strength_of(&surface, ray.direction, set->half);
    point->object = surface.object;
    point->range_error = (float)error;
    for (int i = 0; i < 3; ++i) {
        point->color[i] = stp_linear_to_srgb8(surface.color[i]);
    }
    point->normal[0] = normal.x;
    point->normal[1] = normal.y;
    point->normal[2] = normal.z;
    point->place[0] = place.x;
    point->place[1] = place.y;
    point->place[2] = place.z;
}

static void sweep_columns(size_t begin, size_t end, uint32_t worker, void* user)
{
    (void)worker;
    const sweep* s = user;
    for (size_t i = begin; i < end; ++i) {
        for (uint32_t row = 0; row < s->settings->rows; ++row) {
            cast_ray(s, s->first + (uint32_t)i, row, &s->points[i * s->settings->rows + row]);
        }
    }
}

void scan_sweep(const scan_target* target, const scan_settings* settings,
                const scan_station* station, uint32_t first, uint32_t count, scan_point* points)
{
    assert((uint64_t)first + count <= settings->columns);
    sweep s = {target, settings, station, first, points};
    stp_parallel_for(target->context, count, 1, sweep_columns, &s);
}
