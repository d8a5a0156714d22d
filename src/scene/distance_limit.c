// SPDX-License-Identifier: MIT
#include "scene/bulk.h"
#include "scene/finish_steps.h"

#include <assert.h>
#include <stdio.h>
#include <string.h>

#define STEP ((size_t)1 << 20) // points

// Also false for NaN.
static bool reaches(const float* p)
{
    const float maximum = (float)STP_SCENE_DISTANCE_LIMIT;
    return fabsf(p[0]) <= maximum && fabsf(p[1]) <= maximum && fabsf(p[2]) <= maximum;
}

static bool all_reach(const float* positions, size_t count)
{
    bool all = true;
    for (size_t i = 0; i < 3 * count; ++i) {
        all = fabsf(positions[i]) <= (float)STP_SCENE_DISTANCE_LIMIT && all;
    }
    return all;
}

bool stp_is_within_distance_limit(stp_boxd box)
{
    const double maximum =
        STP_SCENE_DISTANCE_LIMIT * (1.0 + 1e-6); // tolerance for rounding to float
    stp_vec3d low = box.min, high = box.max;     // NaN coordinates leave an axis empty
    return low.x <= high.x && low.y <= high.y && low.z <= high.z && low.x >= -maximum &&
           low.y >= -maximum && low.z >= -maximum && high.x <= maximum && high.y <= maximum &&
           high.z <= maximum;
}

uint32_t stp_mesh_drop_distant(stp_mesh* mesh)
{
    if (all_reach(mesh->positions, mesh->vertex_count)) {
        return 0;
    }
    uint32_t kept = 0;
    for (uint32_t t = 0; t < mesh->triangle_count; ++t) {
        const uint32_t* corners = mesh->indices + 3 * (size_t)t;
        bool whole = true;
        for (int k = 0; k < 3; ++k) {
            whole = whole && reaches(mesh->positions + 3 * (size_t)corners[k]);
        }
        if (whole) {
            memmove(mesh->indices + 3 * (size_t)kept, corners, 3 * sizeof(uint32_t));
            kept += 1;
        }
    }
    for (uint32_t i = 0; i < mesh->vertex_count; ++i) {
        float* p = mesh->positions + 3 * (size_t)i;
        if (!reaches(p)) {
            p[0] = p[1] = p[2] = 0.0f;
        }
    }
    assert(kept <= mesh->triangle_count);
    uint32_t dropped = mesh->triangle_count - kept;
    mesh->triangle_count = kept;
    return dropped;
}

// Computes the bounds. Releases spilled pages. @return whether all points are within the limit
static bool measure_points(stp_point_set* points)
{
    size_t count = points->point_count, step;
    bool all = true;
    points->bounds = stp_box_empty();
    for (size_t i = 0; i < count; i += step) {
        const float* positions = points->positions + 3 * i;
        step = count - i < STEP ? count - i : STEP;
        for (size_t k = 0; k < step; ++k) {
            const float* p = positions + 3 * k;
            all = reaches(p) && all;
            stp_box_add(&points->bounds, (stp_vec3){p[0], p[1], p[2]});
        }
        if (points->spilled) {
            stp_spill_forget(positions, 3 * step * sizeof(float));
        }
    }
    return all;
}

// Compacts all columns. @return number of dropped points
static uint32_t drop_distant(stp_point_set* points)
{
    stp_bulk_array arrays[STP_POINT_ARRAYS];
    stp_points_get_arrays(points, arrays);
    uint32_t kept = 0;
    for (uint32_t i = 0; i < points->point_count; ++i) {
        if (!reaches(points->positions + 3 * (size_t)i)) {
            continue;
        }
        for (int k = 0; k < STP_POINT_ARRAYS; ++k) {
            size_t size = arrays[k].size / points->point_count;
            unsigned char* bytes = arrays[k].bytes;
            if (size != 0) {
                memmove(bytes + kept * size, bytes + i * size, size);
            }
        }
        kept += 1;
    }
    uint32_t dropped = points->point_count - kept;
    points->point_count = kept;
    return dropped;
}

uint32_t stp_point_set_measure(stp_point_set* points)
{
    uint32_t dropped = 0;
    if (!measure_points(points)) {
        dropped = drop_distant(points);
        bool all = measure_points(points);
        assert(all && dropped > 0);
        (void)all;
    }
    return dropped;
}

void stp_scene_report_dropped(const stp_scene* scene)
{
    const stp_damage* d = &scene->damaged;
    if (d->count == 0) {
        return;
    }
    uint32_t object = 0, at = 0; // first object that shows it
    for (; object < scene->object_count; ++object) {
        const stp_object* o = &scene->objects[object];
        for (at = 0; at < o->part_count; ++at) {
            stp_part part = scene->parts[o->first_part + at];
            if (part.kind == d->first.kind && part.index == d->first.index) {
                break;
            }
        }
        if (at < o->part_count) {
            break;
        }
    }
    const char* name = object < scene->object_count ? scene->objects[object].name : NULL;
    char others[64] = "";
    if (d->count > 1) {
        snprintf(others, sizeof(others), ", and some of %u more", d->count - 1);
    }
    stp_warn(scene->context,
             "object %u (%s): %u %s that are not finite, or farther than %g from its origin, are "
             "left out%s",
             object, name != NULL ? name : "no name", d->dropped,
             d->first.kind == STP_PART_MESH ? "triangles with corners" : "points",
             STP_SCENE_DISTANCE_LIMIT, others);
}
