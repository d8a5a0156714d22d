// SPDX-License-Identifier: MIT
#include "scenes/support_sight.h"

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

static bool reaches_box(stp_boxd box, stp_vec3d eye, stp_vec3d direction)
{
    const double low[3] = {box.min.x, box.min.y, box.min.z},
                 high[3] = {box.max.x, box.max.y, box.max.z}, from[3] = {eye.x, eye.y, eye.z},
                 way[3] = {direction.x, direction.y, direction.z};
    double enter = 0.0, leave = (double)INFINITY;
    for (int k = 0; k < 3; ++k) {
        double a = (low[k] - 1e-9 - from[k]) / way[k], b = (high[k] + 1e-9 - from[k]) / way[k];
        double first = a < b ? a : b, last = a < b ? b : a;
        enter = first > enter ? first : enter;
        leave = last < leave ? last : leave;
        if (enter > leave) {
            return false;
        }
    }
    return true;
}

static stp_vec3d corner_of(const stp_mesh* mesh, const stp_affine* place, size_t corner)
{
    const float* p = mesh->positions + 3 * (size_t)mesh->indices[corner];
    return stp_affine_point(place, (stp_vec3d){(double)p[0], (double)p[1], (double)p[2]});
}

// Moeller and Trumbore 1997.
static void look_at_triangle(const stp_vec3d corners[3], stp_vec3d eye, stp_vec3d direction,
                             sight_hit* hit)
{
    stp_vec3d u = stp_subd(corners[1], corners[0]), v = stp_subd(corners[2], corners[0]);
    stp_vec3d p = stp_crossd(direction, v), from = stp_subd(eye, corners[0]);
    double determinant = stp_dotd(u, p);
    double a = stp_dotd(from, p) / determinant;
    stp_vec3d q = stp_crossd(from, u);
    double b = stp_dotd(direction, q) / determinant, t = stp_dotd(v, q) / determinant;
    if (a >= 0.0 && b >= 0.0 && a + b <= 1.0 && t > 0.0 && t < hit->distance) {
        *hit = (sight_hit){t, determinant < 0.0};
    }
}

sight_hit sight_look(const sight* s, stp_vec3d eye, stp_vec3d direction)
{
    sight_hit hit = {.distance = (double)INFINITY};
    for (size_t i = 0; i < s->part_count; ++i) {
        if (!reaches_box(s->boxes[i], eye, direction)) {
            continue;
        }
        const stp_mesh* mesh = &s->scene->meshes[s->parts[i].part.index];
        const stp_affine* place = &s->parts[i].transform;
        bool mirrored = stp_affine_determinant(place) < 0.0;
        for (size_t t = 0; t < mesh->triangle_count; ++t) {
            stp_vec3d corners[3];
            for (size_t k = 0; k < 3; ++k) {
                corners[k] = corner_of(mesh, place, 3 * t + (mirrored ? 2 - k : k));
            }
            look_at_triangle(corners, eye, direction, &hit);
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
