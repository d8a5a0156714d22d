// SPDX-License-Identifier: MIT
#include "support_sight.h"

#include <math.h>

bool sight_open(sight* s, const stp_scene* scene)
{
    *s = (sight){.scene = scene};
    if (stp_scene_flatten(scene, scene->root, 1000000, &s->parts, &s->part_count) != STP_OK) {
        return false;
    }
    s->boxes = calloc(s->part_count + 1, sizeof(*s->boxes));
    for (size_t i = 0; s->boxes != NULL && i < s->part_count; ++i) {
        stp_box box = scene->meshes[s->parts[i].part.index].bounds;
        s->boxes[i] = stp_affine_box(&s->parts[i].transform,
                                     (stp_boxd){stp_to_double(box.min), stp_to_double(box.max)});
    }
    return s->boxes != NULL;
}

void sight_close(sight* s)
{
    free(s->boxes);
    stp_free(s->scene->context, s->parts);
}

/// Narrows the part of a ray that is between two planes across an axis. @return whether any is left
static bool narrow(double low, double high, double from, double way, double* enter, double* leave)
{
    double a = (low - 1e-9 - from) / way, b = (high + 1e-9 - from) / way;
    double first = a < b ? a : b, last = a < b ? b : a;
    *enter = first > *enter ? first : *enter;
    *leave = last < *leave ? last : *leave;
    return *enter <= *leave;
}

static bool reaches_box(const stp_boxd* box, const stp_vec3d* eye, const stp_vec3d* direction)
{
    double enter = 0.0, leave = (double)INFINITY;
    return narrow(box->min.x, box->max.x, eye->x, direction->x, &enter, &leave) &&
           narrow(box->min.z, box->max.z, eye->z, direction->z, &enter, &leave) &&
           narrow(box->min.y, box->max.y, eye->y, direction->y, &enter, &leave);
}

/// A ray in the space of a part: distances, in lengths of the direction, are the same.
typedef struct local_ray {
    stp_vec3d from, way;
} local_ray;

static stp_vec3d row_of(const stp_affine* a, int row)
{
    return (stp_vec3d){a->m[row][0], a->m[row][1], a->m[row][2]};
}

static local_ray enter_part(const stp_affine* place, stp_vec3d eye, stp_vec3d direction)
{
    stp_vec3d a = row_of(place, 0), b = row_of(place, 1), c = row_of(place, 2);
    double share = 1.0 / stp_affine_determinant(place);
    const stp_vec3d columns[3] = {stp_scaled(stp_crossd(b, c), share),
                                  stp_scaled(stp_crossd(c, a), share),
                                  stp_scaled(stp_crossd(a, b), share)};
    stp_vec3d from = {eye.x - place->m[0][3], eye.y - place->m[1][3], eye.z - place->m[2][3]};
    return (local_ray){
        stp_addd(stp_addd(stp_scaled(columns[0], from.x), stp_scaled(columns[1], from.y)),
                 stp_scaled(columns[2], from.z)),
        stp_addd(stp_addd(stp_scaled(columns[0], direction.x), stp_scaled(columns[1], direction.y)),
                 stp_scaled(columns[2], direction.z))};
}

// Moeller and Trumbore 1997. In a mirrored part, corners and space are both turned around.
static void look_at_triangle(const float* p, const float* q, const float* r, const local_ray* ray,
                             sight_hit* hit)
{
    const double x = (double)p[0], y = (double)p[1], z = (double)p[2];
    const double ux = (double)q[0] - x, uy = (double)q[1] - y, uz = (double)q[2] - z;
    const double vx = (double)r[0] - x, vy = (double)r[1] - y, vz = (double)r[2] - z;
    const stp_vec3d* d = &ray->way;
    const double px = d->y * vz - d->z * vy, py = d->z * vx - d->x * vz, pz = d->x * vy - d->y * vx;
    const double fx = ray->from.x - x, fy = ray->from.y - y, fz = ray->from.z - z;
    double determinant = ux * px + uy * py + uz * pz;
    double a = (fx * px + fy * py + fz * pz) / determinant;
    if (!(a >= 0.0 && a <= 1.0)) {
        return;
    }
    const double qx = fy * uz - fz * uy, qy = fz * ux - fx * uz, qz = fx * uy - fy * ux;
    double b = (d->x * qx + d->y * qy + d->z * qz) / determinant;
    double t = (vx * qx + vy * qy + vz * qz) / determinant;
    if (b >= 0.0 && a + b <= 1.0 && t > 0.0 && t < hit->distance) {
        *hit = (sight_hit){t, determinant < 0.0};
    }
}

sight_hit sight_look(const sight* s, stp_vec3d eye, stp_vec3d direction)
{
    sight_hit hit = {.distance = (double)INFINITY};
    for (size_t i = 0; i < s->part_count; ++i) {
        if (!reaches_box(&s->boxes[i], &eye, &direction)) {
            continue;
        }
        const stp_mesh* mesh = &s->scene->meshes[s->parts[i].part.index];
        const local_ray ray = enter_part(&s->parts[i].transform, eye, direction);
        const uint32_t* corners = mesh->indices;
        for (size_t t = 0; t < mesh->triangle_count; ++t, corners += 3) {
            look_at_triangle(mesh->positions + 3 * (size_t)corners[0],
                             mesh->positions + 3 * (size_t)corners[1],
                             mesh->positions + 3 * (size_t)corners[2], &ray, &hit);
        }
    }
    return hit;
}

bool sight_is_inside(const sight* s, bool ground, stp_vec3d eye)
{
    // not quite upright: edges and walls are
    sight_hit above = sight_look(s, eye, (stp_vec3d){0.0113, 1.0, 0.0071});
    sight_hit below = sight_look(s, eye, (stp_vec3d){0.0113, -1.0, 0.0071});
    bool nothing = isinf(below.distance);
    return (above.from_behind && (below.from_behind || nothing)) ||
           (ground && nothing && !isinf(above.distance));
}
