// SPDX-License-Identifier: MIT
#include "support_progressive.h"

#include "base/math/rng.h"
#include "base/splats/coverage.h"
#include "base/splats/octahedral.h"
#include "base/splats/splat_codes.h"
#include "lod/psp/forest.h"
#include "store/bytes/operators.h"

#include <assert.h>
#include <math.h>
#include <string.h>

static double unit(uint64_t seed, uint64_t at)
{
    return (double)(stp_rng_hash(seed, at) >> 11) * 0x1p-53;
}

static bool make_columns(stp_arena* arena, uint32_t count, stp_splats* set)
{
    *set = (stp_splats){.count = count, .step = 0.25f, .columns = STP_OPERATOR_COLUMNS};
    set->positions = STP_ARENA_ARRAY(arena, uint16_t, 3 * (size_t)count + 1);
    set->normals = STP_ARENA_ARRAY(arena, int8_t, 2 * (size_t)count + 1);
    set->materials = STP_ARENA_ARRAY(arena, uint8_t, (size_t)count + 1);
    set->colors = STP_ARENA_ARRAY(arena, uint8_t, 3 * (size_t)count + 1);
    set->coverages = STP_ARENA_ARRAY(arena, uint8_t, (size_t)count + 1);
    set->shapes = STP_ARENA_ARRAY(arena, uint32_t, (size_t)count + 1);
    set->ranges = STP_ARENA_ARRAY(arena, uint32_t, (size_t)count + 1);
    return set->positions != NULL && set->normals != NULL && set->materials != NULL &&
           set->colors != NULL && set->coverages != NULL && set->shapes != NULL &&
           set->ranges != NULL;
}

uint32_t progressive_sample_mark(stp_progressive_counts counts, const uint32_t* order,
                                 uint32_t wanted, bool* marks)
{
    uint32_t splits = wanted > counts.base ? wanted - counts.base : 0;
    splits = splits < counts.splits ? splits : counts.splits;
    for (uint32_t i = 0; i < counts.base + 2 * splits; ++i) {
        marks[i] = true;
    }
    for (uint32_t s = 0; s < splits; ++s) {
        marks[order[s]] = false;
    }
    return counts.base + splits;
}

bool progressive_sample_empty(stp_arena* arena, const stp_splats* like, stp_splats* set)
{
    bool made = make_columns(arena, like->count, set);
    size_t n = like->count;
    set->step = like->step;
    if (made) {
        memset(set->positions, 0, 6 * n);
        memset(set->normals, 0, 2 * n);
        memset(set->materials, 0, n);
        memset(set->colors, 0, 3 * n);
        memset(set->coverages, 0, n);
        memset(set->shapes, 0, 4 * n);
        memset(set->ranges, 0, 4 * n);
    }
    return made;
}

bool progressive_sample_is_same(const stp_splats* a, const stp_splats* b, uint32_t count)
{
    size_t n = count;
    return memcmp(a->positions, b->positions, 6 * n) == 0 &&
           memcmp(a->normals, b->normals, 2 * n) == 0 &&
           memcmp(a->materials, b->materials, n) == 0 && memcmp(a->colors, b->colors, 3 * n) == 0 &&
           memcmp(a->coverages, b->coverages, n) == 0 && memcmp(a->shapes, b->shapes, 4 * n) == 0 &&
           memcmp(a->ranges, b->ranges, 4 * n) == 0;
}

void progressive_sample_octaves(stp_splats* set, uint32_t first)
{
    set->octave_count = 0;
    for (uint64_t end = first; end < set->count && set->octave_count + 1 < STP_OCTAVE_LIMIT;
         end *= 4) {
        set->octave_ends[set->octave_count++] = (uint32_t)end;
    }
    set->octave_ends[set->octave_count++] = set->count;
    assert(set->octave_count <= STP_OCTAVE_LIMIT && "the set holds the octaves");
    set->table.size = set->octave_count;
    for (uint32_t k = 0; k < set->octave_count; ++k) {
        set->table.count[k] = set->octave_ends[k];
        set->table.radius[k] = 64.0f / (float)(1u << k);
    }
}

/// The columns of a splat that a reader copies unchecked.
static void fill_splat(const stp_splats* set, const progressive_desc* d, uint32_t at)
{
    size_t i = at;
    for (uint64_t k = 0; k < 3; ++k) {
        uint64_t h = stp_rng_hash(d->seed + 2, 3 * i + k);
        set->positions[3 * i + k] = (uint16_t)(d->wild ? h : 100 * i + h % 64);
        set->colors[3 * i + k] = (uint8_t)(h >> 20 & (d->wild ? 255 : 15));
    }
    uint64_t h = stp_rng_hash(d->seed + 3, i);
    set->normals[2 * i] = (int8_t)(d->wild ? h : h % 5);
    set->normals[2 * i + 1] = (int8_t)(h >> 8 & (d->wild ? 255 : 7));
    set->materials[i] = 0;
    set->coverages[i] = d->wild ? (uint8_t)(h >> 24) : STP_COVERAGE_WHOLE;
    uint32_t larger = (uint32_t)(h >> 32) % (d->wild ? 0xFFFu : 0x600u), smaller = larger;
    if (h >> 63 != 0) {
        smaller = (uint32_t)(h >> 40) % (larger + 1);
    }
    set->shapes[i] = larger | smaller << 12 | ((uint32_t)(h >> 48) & 255u) << 24;
}

bool progressive_sample_make(stp_arena* arena, const progressive_desc* d, stp_splats* set)
{
    uint32_t count = d->base + 2 * d->splits, inner = 0;
    if (!make_columns(arena, count, set)) {
        return false;
    }
    uint32_t* room = STP_ARENA_ARRAY(arena, uint32_t, (size_t)count + 1);
    if (room == NULL) {
        return false;
    }
    stp_progressive_queue queue = {.ranges = set->ranges, .heap = room};
    for (uint32_t i = 0; i < count; ++i) {
        uint32_t split = i < d->base ? 0 : (i - d->base) / 2, top = 0x8200, highest;
        uint64_t h = stp_rng_hash(d->seed, i);
        fill_splat(set, d, i);
        if (i >= d->base && (i - d->base) % 2 == 0) {
            room[count] = stp_progressive_queue_take(&queue); // waits for its second child
        }
        if (i >= d->base) {
            top = set->ranges[room[count]] & 0xFFFFu;
        }
        highest = i < d->base ? STP_RANGE_INFINITE : top + (uint32_t)(h >> 40) % 4;
        // enough parents for the remaining splits, and no more
        uint32_t needed = d->splits - split - (i >= d->base ? 1 : 0), left = count - i;
        bool must = queue.count == 0 && inner < d->splits && i + 1 >= d->base &&
                    (i < d->base || (i - d->base) % 2 == 1) && needed > 0;
        bool may = inner < d->splits && (stp_rng_hash(d->seed + 1, i) & 1u) != 0;
        must = must || (inner < d->splits && d->splits - inner >= left);
        uint32_t lowest = 0;
        if (must || may) {
            uint32_t drop = (uint32_t)(h & (d->coarse ? 1u : 0x1Fu)) * (d->coarse ? 256u : 1u);
            lowest = top > drop + 1 ? top - drop : 1;
            inner += 1;
        }
        set->ranges[i] = lowest | highest << 16;
        stp_progressive_queue_add(&queue, i);
    }
    return inner == d->splits;
}

static float bumps(float x, float z)
{
    return 0.2f * sinf(7.0f * x) * cosf(5.0f * z) + 0.03f * sinf(31.0f * (x + z));
}

/// Points of the surface with its normals and colours.
static void make_points(uint32_t count, float* positions, float* normals, uint8_t* colors)
{
    uint32_t side = (uint32_t)ceil(sqrt((double)count));
    for (uint32_t i = 0; i < count; ++i) {
        float x = ((float)(i % side) + 0.6f * (float)unit(1, i)) / (float)side;
        float z = ((float)(i / side) + 0.6f * (float)unit(2, i)) / (float)side;
        float slope_x = (bumps(x + 1e-3f, z) - bumps(x - 1e-3f, z)) / 2e-3f;
        float slope_z = (bumps(x, z + 1e-3f) - bumps(x, z - 1e-3f)) / 2e-3f;
        stp_vec3 n = stp_normalize((stp_vec3){-slope_x, 1.0f, -slope_z});
        const float at[3] = {x, bumps(x, z), z}, facing[3] = {n.x, n.y, n.z};
        memcpy(positions + 3 * i, at, sizeof(at));
        memcpy(normals + 3 * i, facing, sizeof(facing));
        float light = 128.0f + 60.0f * sinf(9.0f * x) + 12.0f * (float)unit(3, i);
        colors[3 * i] = (uint8_t)light;
        colors[3 * i + 1] = (uint8_t)(0.8f * light + 6.0f * (float)unit(4, i));
        colors[3 * i + 2] = (uint8_t)(90.0f + 50.0f * z);
    }
}

static uint16_t to_grid(float x, float step)
{
    float value = (x + 0.5f) / step + 0.5f;
    return value > 0.0f ? (value < 65535.0f ? (uint16_t)value : 65535) : 0;
}

/// The code of a direction in the plane perpendicular to a normal.
static uint32_t direction_of(const int8_t* normal, stp_vec3 major)
{
    stp_disk_axes axes = stp_disk_axes_of((float)normal[0], (float)normal[1]);
    float turn = atan2f(stp_dot(major, axes.y), stp_dot(major, axes.x)) / 3.14159265f;
    return (uint32_t)(int32_t)floorf(turn * 256.0f + 0.5f) & 255u;
}

static void fill_of_ellipse(const stp_splats* set, uint32_t i, const stp_psp_forest* f,
                            uint32_t splat, uint32_t range)
{
    const stp_ellipse* e = &f->ellipses[splat];
    set->positions[3 * i] = to_grid(e->center.x, set->step);
    set->positions[3 * i + 1] = to_grid(e->center.y, set->step);
    set->positions[3 * i + 2] = to_grid(e->center.z, set->step);
    stp_octahedral_encode(e->normal, set->normals + 2 * i);
    memcpy(set->colors + 3 * i, f->colors + 3 * splat, 3);
    set->materials[i] = 0;
    set->coverages[i] = STP_COVERAGE_WHOLE;
    uint32_t larger = stp_shape_code(stp_length(e->major) / set->step);
    uint32_t smaller = stp_shape_code(e->minor / set->step);
    smaller = smaller < larger ? smaller : larger;
    set->shapes[i] = larger | smaller << 12 | direction_of(set->normals + 2 * i, e->major) << 24;
    set->ranges[i] = range;
}

/// Codes of the merge levels: errors are lengths, and no child's level exceeds its parent's.
static void find_levels(const stp_psp_forest* f, uint32_t* codes)
{
    for (uint32_t m = 0; m < f->merge_count; ++m) {
        const uint32_t parts[2] = {f->merges[m].left, f->merges[m].right};
        uint32_t code = stp_range_code((float)sqrt(f->merges[m].error), 0.0f) & 0xFFFFu;
        for (int p = 0; p < 2; ++p) {
            uint32_t part = parts[p] >= f->point_count ? codes[parts[p] - f->point_count] : 0;
            code = part > code ? part : code;
        }
        codes[m] = code > 0x100 ? code : 0x100;
    }
}

/// Places the remaining splats, then the two of each merge, highest level first.
static void place_forest(const stp_psp_forest* f, const uint32_t* codes, uint32_t* splats,
                         uint32_t* room, stp_splats* set)
{
    uint32_t all = f->point_count + f->merge_count, count = 0;
    for (uint32_t i = 0; i < all; ++i) {
        if (f->parents[i] == UINT32_MAX) {
            uint32_t low = i >= f->point_count ? codes[i - f->point_count] : 0;
            splats[count] = i;
            fill_of_ellipse(set, count++, f, i, low | (uint32_t)STP_RANGE_INFINITE << 16);
        }
    }
    stp_progressive_queue queue = stp_progressive_queue_begin(set->ranges, count, 0, room);
    while (queue.count > 0) {
        uint32_t parent = stp_progressive_queue_take(&queue);
        uint32_t merge = splats[parent] - f->point_count;
        const uint32_t parts[2] = {f->merges[merge].left, f->merges[merge].right};
        for (int p = 0; p < 2; ++p) {
            uint32_t low = parts[p] >= f->point_count ? codes[parts[p] - f->point_count] : 0;
            stp_vec3 d = stp_sub(f->ellipses[parts[p]].center, f->ellipses[splats[parent]].center);
            float level = (float)sqrt(f->merges[merge].error) + STP_LEVEL_SLOPE * stp_length(d);
            uint32_t high = stp_range_code(0.0f, level) >> 16;
            high = high > codes[merge] ? high : codes[merge];
            splats[count] = parts[p];
            fill_of_ellipse(set, count, f, parts[p], low | high << 16);
            stp_progressive_queue_add(&queue, count++);
        }
    }
}

bool progressive_sample_of_forest(stp_arena* arena, stp_context* context, uint32_t count,
                                  uint32_t base, stp_splats* set)
{
    float* positions = STP_ARENA_ARRAY(arena, float, 3 * (size_t)count);
    float* normals = STP_ARENA_ARRAY(arena, float, 3 * (size_t)count);
    uint8_t* colors = STP_ARENA_ARRAY(arena, uint8_t, 3 * (size_t)count);
    uint32_t* codes = STP_ARENA_ARRAY(arena, uint32_t, count);
    uint32_t* splats = STP_ARENA_ARRAY(arena, uint32_t, 2 * (size_t)count);
    uint32_t* room = STP_ARENA_ARRAY(arena, uint32_t, 2 * (size_t)count);
    if (positions == NULL || normals == NULL || colors == NULL || codes == NULL || splats == NULL ||
        room == NULL) {
        return false;
    }
    make_points(count, positions, normals, colors);
    stp_psp_points points = {
        .count = count, .positions = positions, .normals = normals, .colors = colors};
    stp_psp_desc desc = stp_psp_desc_default();
    stp_psp_forest f;
    if (stp_psp_forest_make(context, &points, &desc, base, &f) != STP_OK) {
        return false;
    }
    bool made = make_columns(arena, f.point_count + f.merge_count, set);
    if (made) {
        set->step = 0x1p-15f;
        find_levels(&f, codes);
        place_forest(&f, codes, splats, room, set);
    }
    stp_psp_forest_destroy(context, &f);
    return made;
}
