// SPDX-License-Identifier: MIT
#include "lod/stochastic/patches.h"

#include "base/math.h"

#include <string.h>

enum {
    GRAIN = 64,       ///< leaves
    POINTS_MOST = 64, ///< of a leaf that is divided
    NEAR = 6,         ///< neighbours of a point
    SMALL = 3,        ///< patches of at most so many points join the nearest larger one
};
#define LEVEL 0.005f // flatness up to which a leaf is one patch
#define ALIKE 0.8f   // cosine of normals of a patch and of its seed
#define RISE 0.35f   // how steeply a patch may leave the plane of its seed
#define FEW 2.0f     // doubt of a patch of one point

/// A leaf's points.
typedef struct leaf_points {
    uint32_t count;
    stp_vec3 at[POINTS_MOST], normals[POINTS_MOST];
    uint8_t near[POINTS_MOST][NEAR]; ///< nearest first; itself where there are fewer
    uint8_t patch[POINTS_MOST];
    uint32_t patch_count;
} leaf_points;

typedef struct patch_loop {
    const stp_leaf_octree* octree;
    const stp_leaf_points* points;
    const stp_leaf_facts* facts;
    stp_patches* patches;
} patch_loop;

static void load(const patch_loop* l, size_t leaf, leaf_points* p)
{
    const stp_leaf_cell* cell = &l->octree->leaves[leaf];
    p->count = cell->end - cell->begin;
    for (uint32_t i = 0; i < p->count; ++i) {
        size_t point = l->octree->order[cell->begin + i];
        const uint16_t* at = l->points->positions + 3 * point;
        const float* n = l->points->normals + 3 * point;
        p->at[i] = (stp_vec3){(float)(at[0] - cell->corner[0]), (float)(at[1] - cell->corner[1]),
                              (float)(at[2] - cell->corner[2])};
        p->normals[i] = (stp_vec3){n[0], n[1], n[2]};
    }
}

static void find_near(leaf_points* p)
{
    for (uint32_t i = 0; i < p->count; ++i) {
        float squares[NEAR];
        uint32_t found = 0;
        for (uint32_t k = 0; k < p->count; ++k) {
            stp_vec3 d = stp_sub(p->at[k], p->at[i]);
            float square = stp_dot(d, d);
            if (k == i || (found == NEAR && square >= squares[NEAR - 1])) {
                continue;
            }
            uint32_t at = found < NEAR ? found++ : NEAR - 1;
            for (; at > 0 && squares[at - 1] > square; --at) {
                squares[at] = squares[at - 1];
                p->near[i][at] = p->near[i][at - 1];
            }
            squares[at] = square;
            p->near[i][at] = (uint8_t)k;
        }
        for (; found < NEAR; ++found) {
            p->near[i][found] = (uint8_t)i;
        }
    }
}

/// Whether a point lies on the surface that a seed is of.
static bool belongs(const leaf_points* p, uint32_t seed, uint32_t point)
{
    stp_vec3 d = stp_sub(p->at[point], p->at[seed]), n = p->normals[seed];
    float rise = stp_dot(d, n), square = stp_dot(d, d);
    return fabsf(stp_dot(n, p->normals[point])) >= ALIKE && rise * rise <= RISE * RISE * square;
}

/// Grows a patch from a seed.
static uint32_t grow(leaf_points* p, uint32_t seed, uint8_t patch)
{
    uint8_t stack[POINTS_MOST];
    uint32_t height = 0, size = 0;
    stack[height++] = (uint8_t)seed;
    p->patch[seed] = patch;
    while (height > 0) {
        uint32_t i = stack[--height];
        size += 1;
        for (uint32_t k = 0; k < NEAR; ++k) {
            uint32_t other = p->near[i][k];
            if (p->patch[other] == UINT8_MAX && belongs(p, seed, other)) {
                p->patch[other] = patch;
                stack[height++] = (uint8_t)other;
            }
        }
    }
    return size;
}

/// The seed that is next: of the points without a patch, the one whose neighbours' normals are most like its own.
static uint32_t find_seed(const leaf_points* p, const float* alike)
{
    uint32_t best = UINT32_MAX;
    for (uint32_t i = 0; i < p->count; ++i) {
        if (p->patch[i] == UINT8_MAX && (best == UINT32_MAX || alike[i] > alike[best])) {
            best = i;
        }
    }
    return best;
}

/// Gives points of small patches the patch of the nearest point of a large one.
static void join_small(leaf_points* p, const uint32_t* sizes)
{
    uint8_t numbers[POINTS_MOST + 1], kept[POINTS_MOST];
    uint32_t large = 0;
    memcpy(kept, p->patch, p->count);
    for (uint32_t k = 0; k < p->patch_count; ++k) {
        bool is_large = sizes[k] > SMALL && large < STP_PATCHES_MOST;
        numbers[k] = is_large ? (uint8_t)large++ : UINT8_MAX;
    }
    for (uint32_t i = 0; i < p->count; ++i) {
        float least = HUGE_VALF;
        p->patch[i] = numbers[kept[i]];
        for (uint32_t k = 0; numbers[kept[i]] == UINT8_MAX && k < p->count; ++k) {
            if (numbers[kept[k]] == UINT8_MAX) {
                continue;
            }
            stp_vec3 d = stp_sub(p->at[k], p->at[i]);
            float square = stp_dot(d, d), across = stp_dot(d, p->normals[k]);
            square += 4.0f * across * across;
            if (square < least) {
                least = square;
                p->patch[i] = numbers[kept[k]];
            }
        }
        p->patch[i] = large > 0 ? p->patch[i] : 0;
    }
    p->patch_count = large > 0 ? large : 1;
}

static void divide(leaf_points* p)
{
    float alike[POINTS_MOST];
    uint32_t sizes[POINTS_MOST];
    find_near(p);
    for (uint32_t i = 0; i < p->count; ++i) {
        alike[i] = 0.0f;
        for (uint32_t k = 0; k < NEAR; ++k) {
            alike[i] += fabsf(stp_dot(p->normals[i], p->normals[p->near[i][k]]));
        }
    }
    memset(p->patch, UINT8_MAX, sizeof(p->patch));
    p->patch_count = 0;
    for (uint32_t seed = find_seed(p, alike); seed != UINT32_MAX; seed = find_seed(p, alike)) {
        sizes[p->patch_count] = grow(p, seed, (uint8_t)p->patch_count);
        p->patch_count += 1;
    }
    join_small(p, sizes);
}

static bool is_whole(const patch_loop* l, size_t leaf)
{
    const stp_leaf_cell* cell = &l->octree->leaves[leaf];
    return cell->end - cell->begin > POINTS_MOST || l->facts[leaf].flatness <= LEVEL ||
           cell->end - cell->begin < 2 * (SMALL + 1);
}

static void count_some(size_t begin, size_t end, uint32_t worker, void* user)
{
    (void)worker;
    const patch_loop* l = user;
    leaf_points p;
    for (size_t leaf = begin; leaf < end; ++leaf) {
        uint32_t first = l->octree->leaves[leaf].begin, count = l->octree->leaves[leaf].end - first;
        if (is_whole(l, leaf)) {
            memset(l->patches->of_points + first, 0, count);
            l->patches->begins[leaf + 1] = 1;
            continue;
        }
        load(l, leaf, &p);
        divide(&p);
        memcpy(l->patches->of_points + first, p.patch, count);
        l->patches->begins[leaf + 1] = p.patch_count;
    }
}

/// Place, normal and doubt of a patch, from the points of a divided leaf.
static void measure_patch(const leaf_points* p, const uint8_t* of_points, uint32_t index,
                          const uint16_t corner[3], stp_patch* out)
{
    stp_vec3 sum = {0}, place = {0};
    uint32_t count = 0;
    for (uint32_t i = 0; i < p->count; ++i) {
        if (of_points[i] == index) {
            bool turned = stp_dot(sum, p->normals[i]) < 0.0f;
            sum = stp_add(sum, stp_scale(p->normals[i], turned ? -1.0f : 1.0f));
            place = stp_add(place, p->at[i]);
            count += 1;
        }
    }
    place = stp_scale(place, 1.0f / (float)count);
    out->normal = stp_normalize(sum);
    float whole = 0.0f, across = 0.0f;
    for (uint32_t i = 0; i < p->count; ++i) {
        if (of_points[i] == index) {
            stp_vec3 d = stp_sub(p->at[i], place);
            float rise = stp_dot(d, out->normal);
            whole += stp_dot(d, d);
            across += rise * rise;
        }
    }
    out->doubt = 3.0f * (whole > 0.0f ? across / whole : 0.0f) + FEW / (float)count;
    out->place = stp_add(place, (stp_vec3){(float)corner[0], (float)corner[1], (float)corner[2]});
    out->count = count;
}

static void measure_some(size_t begin, size_t end, uint32_t worker, void* user)
{
    (void)worker;
    const patch_loop* l = user;
    leaf_points p;
    for (size_t leaf = begin; leaf < end; ++leaf) {
        const stp_leaf_cell* cell = &l->octree->leaves[leaf];
        const stp_leaf_facts* f = &l->facts[leaf];
        uint32_t first = l->patches->begins[leaf], last = l->patches->begins[leaf + 1];
        if (last - first == 1) {
            l->patches->all[first] = (stp_patch){.place = {f->mean[0], f->mean[1], f->mean[2]},
                                                 .normal = f->normal,
                                                 .doubt = f->known ? 3.0f * f->flatness : 1.0f,
                                                 .leaf = (uint32_t)leaf,
                                                 .count = cell->end - cell->begin};
            continue;
        }
        load(l, leaf, &p);
        for (uint32_t k = first; k < last; ++k) {
            l->patches->all[k].leaf = (uint32_t)leaf;
            measure_patch(&p, l->patches->of_points + cell->begin, k - first, cell->corner,
                          &l->patches->all[k]);
        }
    }
}

stp_result stp_patches_make(stp_context* context, const stp_leaf_octree* octree,
                            const stp_leaf_points* points, const stp_leaf_facts* facts,
                            stp_patches* patches)
{
    uint32_t leaves = octree->leaf_count, all = octree->leaves[leaves - 1].end;
    *patches = (stp_patches){.begins = STP_NEW_ZEROED(context, uint32_t, (size_t)leaves + 1),
                             .of_points = STP_NEW_ARRAY(context, uint8_t, all)};
    if (patches->begins == NULL || patches->of_points == NULL) {
        return stp_fail_memory(context);
    }
    patch_loop loop = {octree, points, facts, patches};
    stp_parallel_for(context, leaves, GRAIN, count_some, &loop);
    for (uint32_t i = 0; i < leaves; ++i) {
        patches->begins[i + 1] += patches->begins[i];
    }
    patches->count = patches->begins[leaves];
    patches->all = STP_NEW_ARRAY(context, stp_patch, patches->count);
    if (patches->all == NULL) {
        return stp_fail_memory(context);
    }
    stp_parallel_for(context, leaves, GRAIN, measure_some, &loop);
    return STP_OK;
}

void stp_patches_destroy(stp_context* context, stp_patches* patches)
{
    stp_free(context, patches->all);
    stp_free(context, patches->begins);
    stp_free(context, patches->of_points);
    *patches = (stp_patches){0};
}
