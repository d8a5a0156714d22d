// SPDX-License-Identifier: MIT
#include "base/core/sort.h"
#include "lod/psp/rounds.h"
#include "lod/psp/scale.h"

#include <assert.h>
#include <string.h>

typedef struct assembly {
    const stp_psp_rounds* rounds;
    stp_psp_forest* forest;
    const float* levels; ///< levels of the merges, in order of creation; merge units
    uint32_t* ranks;     ///< position of each merge in the forest
    double unit;         ///< an error of 1 in model units
} assembly;

static uint32_t splat_of(const assembly* a, uint32_t id)
{
    uint32_t points = a->forest->point_count;
    return id < points ? id : points + a->ranks[id - points];
}

static void place_some(size_t begin, size_t end, uint32_t worker, void* user)
{
    const assembly* a = user;
    stp_psp_forest* f = a->forest;
    (void)worker;
    for (size_t i = begin; i < end; ++i) {
        const stp_psp_history* h = &a->rounds->histories[i];
        for (uint32_t m = 0; m < h->count; ++m) {
            const stp_psp_record* record = &h->records[m];
            uint32_t rank = a->ranks[h->first + m], splat = f->point_count + rank;
            uint32_t left = splat_of(a, record->left), right = splat_of(a, record->right);
            assert(left < splat && right < splat && left != right && "parts come first");
            assert(f->parents[left] == UINT32_MAX && f->parents[right] == UINT32_MAX);
            f->merges[rank] = (stp_psp_merge){.left = left < right ? left : right,
                                              .right = left < right ? right : left,
                                              .error = (double)record->error * a->unit,
                                              .level = (double)a->levels[h->first + m] * a->unit};
            f->parents[left] = f->parents[right] = rank;
            f->ellipses[splat] = stp_psp_scale_ellipse(&record->ellipse, a->rounds->shared.scale);
            memcpy(f->colors + 3 * (size_t)splat, record->color, 3);
        }
    }
}

static void place_points(size_t begin, size_t end, uint32_t worker, void* user)
{
    const assembly* a = user;
    const stp_psp_points* points = a->rounds->shared.points;
    (void)worker;
    for (size_t i = begin; i < end; ++i) {
        a->forest->ellipses[i] =
            stp_psp_scale_ellipse(&a->forest->ellipses[i], a->rounds->shared.scale);
        for (size_t k = 0; k < 3; ++k) {
            a->forest->colors[3 * i + k] =
                points->colors != NULL ? stp_psp_color(points, i)[k] : 255;
        }
    }
}

static void find_levels(const stp_psp_rounds* r, float* levels)
{
    uint32_t points = r->shared.points->count;
    for (uint32_t i = 0; i < r->history_count; ++i) {
        const stp_psp_history* h = &r->histories[i];
        for (uint32_t m = 0; m < h->count; ++m) {
            const stp_psp_record* record = &h->records[m];
            float level = record->error;
            assert(record->left < points + h->first + m && record->right < points + h->first + m);
            assert(level >= 0.0f && "bits of levels are sorted as integers");
            if (record->left >= points) {
                level = stp_max(level, levels[record->left - points]);
            }
            if (record->right >= points) {
                level = stp_max(level, levels[record->right - points]);
            }
            levels[h->first + m] = level;
        }
    }
}

stp_result stp_psp_order_merges(const stp_psp_rounds* r, stp_psp_forest* f)
{
    assert(r->keep_history && r->merge_count <= f->point_count);
    stp_context* context = r->shared.context;
    size_t merges = r->merge_count, splats = (size_t)f->point_count + merges;
    float* levels = STP_NEW_ARRAY(context, float, merges + 1);
    uint32_t* ranks = STP_NEW_ARRAY(context, uint32_t, merges + 1);
    uint64_t* items = STP_NEW_ARRAY(context, uint64_t, 2 * merges + 1);
    uint64_t* sorted = NULL;
    f->merges = STP_NEW_ARRAY(context, stp_psp_merge, merges + 1);
    f->parents = STP_NEW_ARRAY(context, uint32_t, splats + 1);
    if (levels != NULL && ranks != NULL && items != NULL && f->merges != NULL &&
        f->parents != NULL) {
        find_levels(r, levels);
        for (size_t i = 0; i < merges; ++i) {
            uint32_t bits;
            memcpy(&bits, &levels[i], sizeof(bits)); // bits of positive floats sort like the floats
            items[i] = (uint64_t)bits << 32 | i;
        }
        sorted = stp_parallel_sort_u64(context, items, items + merges, merges, 32, 32);
    }
    if (sorted != NULL) {
        for (size_t i = 0; i < merges; ++i) {
            ranks[(uint32_t)sorted[i]] = (uint32_t)i;
        }
        memset(f->parents, 0xff, splats * sizeof(*f->parents));
        f->merge_count = (uint32_t)merges;
        assembly a = {r, f, levels, ranks, stp_psp_error_unit(r->metric->power, r->shared.scale)};
        stp_parallel_for(context, f->point_count, 1 << 16, place_points, &a);
        stp_parallel_for(context, r->history_count, 1, place_some, &a);
    }
    stp_free(context, levels);
    stp_free(context, ranks);
    stp_free(context, items);
    return sorted != NULL ? STP_OK : stp_fail_memory(context);
}
