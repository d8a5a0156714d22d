// SPDX-License-Identifier: MIT
#include "lod/levels/simplify_group.h"

#include "base/core/sort.h"

#include <assert.h>
#include <string.h>

/// A group before and after its simplification.
typedef struct change {
    stp_context* context;
    const stp_group_mesh* group; ///< afterwards
    uint32_t before;             ///< triangles before
    uint32_t* corners;           ///< their corners
    stp_vec3d* normals;          ///< and normals, unit; zero: without area
    double* areas;               ///< and areas
    float* colors;               ///< NULL, or the colours of their corners
    const uint32_t* tags;        ///< and tags
    uint32_t* from;              ///< per triangle that is left: its number before
    uint32_t* merged;            ///< per vertex: the one that stands for it
} change;

stp_result stp_group_create(stp_context* context, uint32_t triangle_count, bool colors,
                            stp_group_mesh* group)
{
    size_t count = (size_t)triangle_count + 1;
    *group = (stp_group_mesh){
        .triangle_count = triangle_count,
        .indices = STP_NEW_ARRAY(context, uint32_t, 3 * count),
        .tags = STP_NEW_ARRAY(context, uint32_t, count),
        .sides = STP_NEW_ARRAY(context, uint8_t, count),
        .colors = colors ? STP_NEW_ARRAY(context, float, 9 * count) : NULL,
        .spreads = STP_NEW_ARRAY(context, float, 2 * count),
    };
    bool good = group->indices != NULL && group->tags != NULL && group->sides != NULL &&
                group->spreads != NULL && (group->colors != NULL || !colors);
    return good ? STP_OK : stp_fail_memory(context);
}

void stp_group_destroy(stp_context* context, stp_group_mesh* group)
{
    stp_free(context, group->positions);
    stp_free(context, group->vertices);
    stp_free(context, group->locked);
    stp_free(context, group->indices);
    stp_free(context, group->tags);
    stp_free(context, group->sides);
    stp_free(context, group->colors);
    stp_free(context, group->spreads);
    *group = (stp_group_mesh){0};
}

stp_result stp_group_number(stp_context* context, stp_group_mesh* group)
{
    uint32_t corners = 3 * group->triangle_count;
    size_t room = (size_t)corners + 1;
    uint64_t* items = STP_NEW_ARRAY(context, uint64_t, room);
    uint64_t* scratch = STP_NEW_ARRAY(context, uint64_t, room);
    group->vertices = STP_NEW_ARRAY(context, uint32_t, room);
    bool good = items != NULL && scratch != NULL && group->vertices != NULL;
    group->vertex_count = 0;
    if (good) {
        for (uint32_t i = 0; i < corners; ++i) {
            items[i] = (uint64_t)group->indices[i] << 32 | i;
        }
        const uint64_t* sorted = stp_sort_u64(items, scratch, corners, 32, 32);
        for (uint32_t i = 0; i < corners; ++i) {
            uint32_t vertex = (uint32_t)(sorted[i] >> 32);
            if (i == 0 || group->vertices[group->vertex_count - 1] != vertex) {
                group->vertices[group->vertex_count++] = vertex;
            }
            group->indices[(uint32_t)sorted[i]] = group->vertex_count - 1;
        }
        group->positions = STP_NEW_ARRAY(context, float, 3 * (size_t)group->vertex_count + 1);
        group->locked = STP_NEW_ZEROED(context, uint8_t, (size_t)group->vertex_count + 1);
        good = group->positions != NULL && group->locked != NULL;
    }
    stp_free(context, items);
    stp_free(context, scratch);
    return good ? STP_OK : stp_fail_memory(context);
}

/// Unit normal of a triangle, or zero, and its area.
static stp_vec3d normal_of(const stp_group_mesh* group, const uint32_t corners[3], double* area)
{
    stp_vec3d p[3];
    for (int k = 0; k < 3; ++k) {
        const float* at = group->positions + 3 * (size_t)corners[k];
        p[k] = (stp_vec3d){(double)at[0], (double)at[1], (double)at[2]};
    }
    stp_vec3d cross = stp_crossd(stp_subd(p[1], p[0]), stp_subd(p[2], p[0]));
    double twice = sqrt(stp_dotd(cross, cross));
    *area = 0.5 * twice;
    return twice > 0.0 ? stp_scaled(cross, 1.0 / twice) : (stp_vec3d){0};
}

static stp_result begin_change(stp_context* context, const stp_group_mesh* group, change* c)
{
    size_t count = (size_t)group->triangle_count + 1;
    *c = (change){.context = context,
                  .group = group,
                  .before = group->triangle_count,
                  .corners = STP_NEW_ARRAY(context, uint32_t, 3 * count),
                  .normals = STP_NEW_ARRAY(context, stp_vec3d, count),
                  .areas = STP_NEW_ARRAY(context, double, count),
                  .tags = group->tags,
                  .from = STP_NEW_ARRAY(context, uint32_t, count),
                  .merged = STP_NEW_ARRAY(context, uint32_t, (size_t)group->vertex_count + 1)};
    if (c->corners == NULL || c->normals == NULL || c->areas == NULL || c->from == NULL ||
        c->merged == NULL) {
        return stp_fail_memory(context);
    }
    memcpy(c->corners, group->indices, 3 * sizeof(uint32_t) * group->triangle_count);
    for (uint32_t t = 0; t < group->triangle_count; ++t) {
        c->normals[t] = normal_of(group, c->corners + 3 * (size_t)t, &c->areas[t]);
        c->from[t] = t;
    }
    return STP_OK;
}

static void end_change(change* c)
{
    stp_free(c->context, c->corners);
    stp_free(c->context, c->normals);
    stp_free(c->context, c->areas);
    stp_free(c->context, c->colors);
    stp_free(c->context, c->from);
    stp_free(c->context, c->merged);
}

/// Corners of `c`, sorted by the vertices that stand for them. `starts`: of each vertex.
/// @return corners (stp_free); NULL if out of memory
static uint32_t* sort_corners(const change* c, uint32_t* starts)
{
    uint32_t count = 3 * c->before, vertices = c->group->vertex_count;
    uint32_t* sorted = STP_NEW_ARRAY(c->context, uint32_t, (size_t)count + 1);
    memset(starts, 0, ((size_t)vertices + 1) * sizeof(*starts));
    for (uint32_t i = 0; i < count && sorted != NULL; ++i) {
        starts[c->merged[c->corners[i]] + 1] += 1;
    }
    for (uint32_t v = 0; v < vertices && sorted != NULL; ++v) {
        starts[v + 1] += starts[v];
    }
    for (uint32_t i = count; i-- > 0 && sorted != NULL;) {
        // filled from the end: corners of a vertex ascend
        uint32_t v = c->merged[c->corners[i]];
        sorted[--starts[v + 1]] = i;
    }
    // each start is now that of the vertex before: the next entry holds its own
    for (uint32_t v = 0; v < vertices && sorted != NULL; ++v) {
        starts[v] = starts[v + 1];
    }
    starts[vertices] = count;
    return sorted;
}

/// The mean colour of the corners of a tag that were merged into a vertex.
static void mean_color(const change* c, const uint32_t* sorted, uint32_t begin, uint32_t end,
                       uint32_t tag, double mean[3])
{
    double weight = 0.0;
    mean[0] = mean[1] = mean[2] = 0.0;
    for (uint32_t i = begin; i < end; ++i) {
        uint32_t triangle = sorted[i] / 3;
        if (c->tags[triangle] != tag) {
            continue;
        }
        double w = c->areas[triangle] + 1e-30;
        const float* color = c->colors + 3 * (size_t)sorted[i];
        for (int k = 0; k < 3; ++k) {
            mean[k] += w * (double)color[k];
        }
        weight += w;
    }
    for (int k = 0; k < 3 && weight > 0.0; ++k) {
        mean[k] /= weight;
    }
}

/// Sets the colours of the triangles that are left. Adds up the squared change of colour, as the
/// eye sees it, times area.
static stp_result merge_colors(const change* c, stp_group_mesh* group, double* changed)
{
    uint32_t* starts = STP_NEW_ARRAY(c->context, uint32_t, (size_t)group->vertex_count + 2);
    uint32_t* sorted = starts != NULL ? sort_corners(c, starts) : NULL;
    float* means = STP_NEW_ARRAY(c->context, float, 9 * (size_t)c->before + 1);
    bool good = sorted != NULL && means != NULL;
    for (uint32_t i = 0; i < 3 * c->before && good; ++i) {
        double mean[3], squared = 0.0;
        uint32_t v = c->merged[c->corners[i]];
        mean_color(c, sorted, starts[v], starts[v + 1], c->tags[i / 3], mean);
        for (int k = 0; k < 3; ++k) {
            double was = sqrt(fmax((double)c->colors[3 * (size_t)i + (size_t)k], 0.0));
            double is = sqrt(fmax(mean[k], 0.0));
            squared += (is - was) * (is - was);
            means[3 * (size_t)i + (size_t)k] = (float)mean[k];
        }
        *changed += c->areas[i / 3] * squared / 9.0; // a third of the area, of three channels
    }
    for (uint32_t t = 0; t < group->triangle_count && good; ++t) {
        memcpy(group->colors + 9 * (size_t)t, means + 9 * (size_t)c->from[t], 9 * sizeof(float));
    }
    stp_free(c->context, means);
    stp_free(c->context, sorted);
    stp_free(c->context, starts);
    return good ? STP_OK : stp_fail_memory(c->context);
}

/// Squared distance of the ends of two unit normals, 0 to 4; 0 if either is zero.
static double turn_of(stp_vec3d a, stp_vec3d b)
{
    double cosine = stp_dotd(a, b);
    bool none =
        !(cosine < 0.0) && !(cosine > 0.0) && (!(stp_dotd(a, a) > 0.0) || !(stp_dotd(b, b) > 0.0));
    return none || cosine > 1.0 ? 0.0 : 2.0 - 2.0 * cosine;
}

/// Adds up the squared change of the normal times area, and the areas afterwards. A triangle that
/// is gone is compared with the most alike of those around the vertices that stand for its corners.
static stp_result compare_normals(const change* c, double* changed, double* after)
{
    const stp_group_mesh* group = c->group;
    uint32_t* starts = STP_NEW_ZEROED(c->context, uint32_t, (size_t)group->vertex_count + 2);
    uint32_t* around = STP_NEW_ARRAY(c->context, uint32_t, 3 * (size_t)group->triangle_count + 1);
    stp_vec3d* normals = STP_NEW_ARRAY(c->context, stp_vec3d, (size_t)group->triangle_count + 1);
    uint8_t* left = STP_NEW_ZEROED(c->context, uint8_t, (size_t)c->before + 1);
    bool good = starts != NULL && around != NULL && normals != NULL && left != NULL;
    for (uint32_t i = 0; good && i < 3 * group->triangle_count; ++i) {
        starts[group->indices[i] + 2] += 1;
    }
    for (uint32_t v = 0; good && v < group->vertex_count; ++v) {
        starts[v + 2] += starts[v + 1];
    }
    for (uint32_t i = 0; good && i < 3 * group->triangle_count; ++i) {
        around[starts[group->indices[i] + 1]++] = i / 3;
    }
    for (uint32_t t = 0; good && t < group->triangle_count; ++t) {
        double area;
        normals[t] = normal_of(group, group->indices + 3 * (size_t)t, &area);
        left[c->from[t]] = 1;
        *after += area;
        *changed += c->areas[c->from[t]] * turn_of(c->normals[c->from[t]], normals[t]);
    }
    for (uint32_t t = 0; good && t < c->before; ++t) {
        double least = 4.0;
        for (size_t k = 0; k < 3 && left[t] == 0; ++k) {
            uint32_t v = c->merged[c->corners[3 * (size_t)t + k]];
            for (uint32_t i = starts[v]; i < starts[v + 1]; ++i) {
                double turn = turn_of(c->normals[t], normals[around[i]]);
                least = turn < least ? turn : least;
            }
        }
        *changed += left[t] == 0 ? c->areas[t] * least : 0.0;
    }
    stp_free(c->context, left);
    stp_free(c->context, normals);
    stp_free(c->context, around);
    stp_free(c->context, starts);
    return good ? STP_OK : stp_fail_memory(c->context);
}

/// Measures the change of colours and normals, and adds it to the spreads.
static stp_result measure_look(const change* c, stp_group_mesh* group, double spreads[2],
                               double* size)
{
    double before = 0.0, after = 0.0;
    spreads[0] = spreads[1] = 0.0;
    stp_result result = group->colors != NULL ? merge_colors(c, group, &spreads[0]) : STP_OK;
    result = result == STP_OK ? compare_normals(c, &spreads[1], &after) : result;
    for (uint32_t t = 0; t < c->before; ++t) {
        before += c->areas[t];
        spreads[0] += c->areas[t] * (double)group->spreads[2 * (size_t)t];
        spreads[1] += c->areas[t] * (double)group->spreads[2 * (size_t)t + 1];
    }
    for (size_t k = 0; k < 2; ++k) {
        spreads[k] = before > 0.0 ? spreads[k] / before : 0.0;
        for (size_t t = 0; t < group->triangle_count; ++t) {
            group->spreads[2 * t + k] = (float)spreads[k];
        }
    }
    *size = group->triangle_count > 0 ? sqrt(2.0 * after / group->triangle_count) : 0.0;
    return result;
}

stp_result stp_group_simplify(stp_context* context, const stp_collapse_desc* desc,
                              stp_group_mesh* group, double* error, double spreads[2], double* size)
{
    change c;
    uint32_t before = group->triangle_count;
    stp_result result = begin_change(context, group, &c);
    float* places = STP_NEW_ARRAY(context, float, 3 * (size_t)group->vertex_count + 1);
    if (result == STP_OK && places == NULL) {
        result = stp_fail_memory(context);
    }
    if (result == STP_OK) {
        memcpy(places, group->positions, 3 * sizeof(float) * group->vertex_count);
        stp_collapse_mesh mesh = {.vertex_count = group->vertex_count,
                                  .triangle_count = before,
                                  .positions = group->positions,
                                  .indices = group->indices,
                                  .tags = c.from,
                                  .materials = group->keeps_tags ? group->tags : NULL,
                                  .locked = group->locked,
                                  .merged = c.merged};
        result = stp_collapse(context, &mesh, desc, error);
        group->triangle_count = mesh.triangle_count;
    }
    if (result == STP_OK && group->colors != NULL) {
        c.colors = STP_NEW_ARRAY(context, float, 9 * (size_t)before + 1);
        result = c.colors != NULL ? STP_OK : stp_fail_memory(context);
        if (c.colors != NULL) {
            memcpy(c.colors, group->colors, 9 * sizeof(float) * before);
        }
    }
    result = result == STP_OK ? measure_look(&c, group, spreads, size) : result;
    for (uint32_t t = 0; t < group->triangle_count && result == STP_OK; ++t) {
        assert(c.from[t] >= t && "triangles keep their order");
        group->tags[t] = group->tags[c.from[t]];
        group->sides[t] = group->sides[c.from[t]];
    }
    for (uint32_t v = 0; v < group->vertex_count && result == STP_OK; ++v) {
        bool moved = memcmp(places + 3 * (size_t)v, group->positions + 3 * (size_t)v,
                            3 * sizeof(float)) != 0;
        group->vertices[v] = moved ? UINT32_MAX : group->vertices[v];
    }
    stp_free(context, places);
    end_change(&c);
    return result;
}
