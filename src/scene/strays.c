// SPDX-License-Identifier: MIT
#include "scene/strays.h"

#include <assert.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum {
    SAMPLE = 1024,   ///< points that tell where most lie
    TRIM_SHARE = 24, ///< one of so many at each end of an axis may be a stray: more than strays are
    MOST_SHARE = 32, ///< more than one of so many points are no strays
    FEWEST_POINTS = 8, ///< fewer have no rest to be far from
    PIECES_MAX = 4096
};
#define FAR 8.0 // strays are as many widths of the rest beyond it

static int compare_floats(const void* a, const void* b)
{
    float x = *(const float*)a, y = *(const float*)b;
    return x < y ? -1 : x > y;
}

/// Most points of a sample along an axis.
static void find_middle(const stp_point_set* points, int axis, float* low, float* high)
{
    float values[SAMPLE];
    uint32_t count = points->point_count < SAMPLE ? points->point_count : SAMPLE;
    for (uint32_t i = 0; i < count; ++i) {
        size_t at = (size_t)((uint64_t)i * points->point_count / count);
        values[i] = points->positions[3 * at + (size_t)axis];
    }
    qsort(values, count, sizeof(float), compare_floats);
    uint32_t trimmed = count / TRIM_SHARE > 0 ? count / TRIM_SHARE : 1;
    assert(2 * trimmed < count);
    *low = values[trimmed];
    *high = values[count - 1 - trimmed];
}

static bool is_inside(const stp_box* box, const float* p)
{
    return p[0] >= box->min.x && p[0] <= box->max.x && p[1] >= box->min.y && p[1] <= box->max.y &&
           p[2] >= box->min.z && p[2] <= box->max.z;
}

bool stp_is_stray(const stp_strays* strays, const float position[3])
{
    return strays->count > 0 && !is_inside(&strays->rest, position);
}

static double distance_to(const stp_box* box, const float* p)
{
    const double low[3] = {(double)box->min.x, (double)box->min.y, (double)box->min.z};
    const double high[3] = {(double)box->max.x, (double)box->max.y, (double)box->max.z};
    double sum = 0.0;
    for (int k = 0; k < 3; ++k) {
        double away = fmax(fmax(low[k] - (double)p[k], (double)p[k] - high[k]), 0.0);
        sum += away * away;
    }
    return sqrt(sum);
}

stp_strays stp_strays_find(const stp_point_set* points)
{
    stp_strays none = {0};
    if (points->point_count < FEWEST_POINTS) {
        return none;
    }
    float low[3], high[3];
    double width = 0.0;
    for (int k = 0; k < 3; ++k) {
        find_middle(points, k, &low[k], &high[k]);
        width = fmax(width, (double)high[k] - (double)low[k]);
    }
    float margin = (float)(FAR * width);
    if (!(width > 0.0)) { // most points coincide: there is no measure of far
        return none;
    }
    stp_strays found = {.width = width,
                        .rest = {{low[0] - margin, low[1] - margin, low[2] - margin},
                                 {high[0] + margin, high[1] + margin, high[2] + margin}}};
    const float corners[2][3] = {
        {points->bounds.min.x, points->bounds.min.y, points->bounds.min.z},
        {points->bounds.max.x, points->bounds.max.y, points->bounds.max.z}};
    if (is_inside(&found.rest, corners[0]) && is_inside(&found.rest, corners[1])) {
        return none;
    }
    for (size_t i = 0; i < points->point_count; ++i) {
        const float* p = points->positions + 3 * i;
        if (!is_inside(&found.rest, p)) {
            found.count += 1;
            found.distance = fmax(found.distance, distance_to(&found.rest, p));
        }
    }
    return found.count <= 1 || found.count <= points->point_count / MOST_SHARE ? found : none;
}

/// A distance in words: "12 km", "300 m", or in units of the scene where these are unknown.
static void describe_distance(const stp_scene* scene, double distance, char* text, size_t size)
{
    double metres = distance * scene->unit_metres;
    if (!(scene->unit_metres > 0.0)) {
        snprintf(text, size, "%.3g units", distance);
    } else {
        const char* format = metres >= 1000.0 ? "%.0f km" : metres >= 10.0 ? "%.0f m" : "%.2g m";
        snprintf(text, size, format, metres >= 1000.0 ? metres / 1000.0 : metres);
    }
}

void stp_strays_report(const stp_scene* scene)
{
    uint64_t strays = 0, sets = 0;
    double farthest = 0.0;
    const char* name = NULL;
    for (size_t i = 0; i < scene->point_set_count; ++i) {
        stp_strays found = stp_strays_find(&scene->point_sets[i]);
        name = strays == 0 ? scene->point_sets[i].name : name;
        strays += found.count;
        sets += found.count > 0 ? 1 : 0;
        farthest = fmax(farthest, found.distance);
    }
    if (strays == 0) {
        return;
    }
    char distance[32], of[48] = "";
    describe_distance(scene, farthest, distance, sizeof(distance));
    if (sets > 1) {
        snprintf(of, sizeof(of), " (of %llu clouds)", (unsigned long long)sets);
    }
    stp_warn(scene->context, "%s%s%llu point%s%s %s up to %s from the rest",
             name != NULL && sets == 1 ? name : "", name != NULL && sets == 1 ? ": " : "",
             (unsigned long long)strays, strays == 1 ? "" : "s", of, strays == 1 ? "lies" : "lie",
             distance);
}

/// Run of strays that lie near to each other, or are still to be divided.
typedef struct stray_run {
    uint32_t first, count;
} stray_run;

static double longest_side(const stp_place* places, uint32_t count, int* axis, double* middle)
{
    double longest = -1.0;
    for (int k = 0; k < 3; ++k) {
        float low = places[0].at[k], high = low;
        for (uint32_t i = 1; i < count; ++i) {
            low = fminf(low, places[i].at[k]);
            high = fmaxf(high, places[i].at[k]);
        }
        double side = (double)high - (double)low;
        if (side > longest) {
            longest = side;
            *axis = k;
            *middle = 0.5 * ((double)low + (double)high);
        }
    }
    return longest;
}

/// Moves the places below the middle to the front, in their order. @return how many
static uint32_t divide(stp_place* places, stp_place* scratch, uint32_t count, int axis,
                       double middle)
{
    uint32_t below = 0, above = 0;
    for (uint32_t i = 0; i < count; ++i) {
        if ((double)places[i].at[axis] <= middle) {
            places[below++] = places[i];
        } else {
            scratch[above++] = places[i];
        }
    }
    memcpy(places + below, scratch, above * sizeof(*places));
    return below;
}

stp_result stp_strays_group(stp_context* context, const stp_strays* strays, stp_place* places,
                            uint32_t* ends, uint32_t* group_count)
{
    stray_run* runs = STP_NEW_ARRAY(context, stray_run, 2 * (size_t)strays->count);
    stp_place* scratch = STP_NEW_ARRAY(context, stp_place, strays->count);
    *group_count = 0;
    if (runs == NULL || scratch == NULL) {
        stp_free(context, scratch);
        stp_free(context, runs);
        return stp_fail_memory(context);
    }
    // the last run is the first in the array of places, so groups end in ascending order
    uint32_t waiting = 1, made = 0;
    runs[0] = (stray_run){0, strays->count};
    while (waiting > 0) {
        stray_run run = runs[--waiting];
        int axis = 0;
        double middle = 0.0;
        double side = longest_side(places + run.first, run.count, &axis, &middle);
        uint32_t below = side > strays->width && made + waiting + 1 < PIECES_MAX
                             ? divide(places + run.first, scratch, run.count, axis, middle)
                             : run.count;
        if (below == run.count) {
            ends[made++] = run.first + run.count;
            continue;
        }
        assert(below > 0);
        runs[waiting++] = (stray_run){run.first + below, run.count - below};
        runs[waiting++] = (stray_run){run.first, below};
    }
    assert(made > 0 && ends[made - 1] == strays->count);
    *group_count = made;
    stp_free(context, scratch);
    stp_free(context, runs);
    return STP_OK;
}
