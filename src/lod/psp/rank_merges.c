// SPDX-License-Identifier: MIT
// The paper's record of merges (Wu, Zhang, Kobbelt 2005, section 5) as levels of a forest.
#include "base/splats/splat_codes.h"
#include "lod/psp/forest.h"

#include <assert.h>

#define PI 3.14159265358979323846

enum {
    FIRST = 0x100,            ///< code of the smallest normal float
    RANKS = 87 * 256 - FIRST, ///< codes from there to 2^-40
};

/// Numbers the merges in runs, the last merge first, in `runs`. Splats of equal levels are split in
/// the order of their places, so merges whose splats have ascending places share a run.
/// @return number of runs
static uint32_t find_runs(const stp_psp_forest* f, uint32_t* places, uint32_t* runs)
{
    uint32_t next = 0, run = 0, last = 0;
    for (uint32_t i = f->point_count + f->merge_count; i-- > 0;) {
        if (f->parents[i] == UINT32_MAX) {
            places[i] = next++;
        }
    }
    for (uint32_t i = f->merge_count; i-- > 0;) {
        uint32_t place = places[f->point_count + i];
        run += place < last ? 1 : 0;
        last = place;
        runs[i] = run;
        places[f->merges[i].left] = next++;
        places[f->merges[i].right] = next++;
    }
    assert(next == f->point_count + f->merge_count && "each splat has a place");
    return run + 1;
}

stp_result stp_psp_rank_merges(stp_context* context, stp_psp_forest* f)
{
    uint32_t* places =
        STP_NEW_ARRAY(context, uint32_t, (size_t)f->point_count + f->merge_count + 1);
    uint32_t* runs = STP_NEW_ARRAY(context, uint32_t, (size_t)f->merge_count + 1);
    bool made = places != NULL && runs != NULL;
    if (made) {
        uint32_t count = find_runs(f, places, runs), share = (count + RANKS - 1) / RANKS;
        for (uint32_t i = 0; i < f->merge_count; ++i) {
            // a level is the area of a disk (stp_psp_sequence_make takes its radius)
            double radius = (double)stp_range_level(FIRST + (count - 1 - runs[i]) / share);
            f->merges[i].level = PI * radius * radius;
        }
        f->ranked = true;
    }
    stp_free(context, places);
    stp_free(context, runs);
    return made ? STP_OK : stp_fail_memory(context);
}
