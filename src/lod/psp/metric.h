// SPDX-License-Identifier: MIT
// Error metrics of a merge, each behind one table of functions (Wu, Zhang, Kobbelt 2005, 4).
//
// All geometry is in units of the merge: model units times a power of two, so that the diagonal of
// all points' box is about 2^20. Errors then fit in floats, and no product of areas vanishes.
#pragma once

#include "lod/psp/forest.h"
#include "lod/psp/room.h"

/// A splat while it may be merged.
typedef struct stp_psp_splat {
    stp_ellipse ellipse;
    float area;
    float color[3]; ///< linear
    uint32_t id;    ///< number of the splat
    uint32_t key;   ///< smallest index of the represented points: breaks ties
} stp_psp_splat;

/// Shared by all splats of a merge.
typedef struct stp_psp_shared {
    stp_context* context;
    const stp_psp_points* points;
    const stp_psp_room* room; ///< storage for arrays of points; NULL: in memory
    stp_psp_desc desc;
    float scale;     ///< from model units to those of the merge
    float least;     ///< minimum length of axes
    stp_vec3 middle; ///< of the points' box
    void* own;       ///< the metric's, from its `open`
} stp_psp_shared;

/// The position of a point, in units of the merge.
stp_vec3 stp_psp_point_at(const stp_psp_shared* shared, uint32_t point);

enum { STP_PSP_STATE_MOST = 512 }; ///< bytes of a state

/// An error metric. Each splat may have a metric-specific state. Functions run on several threads
/// at once, for different splats.
typedef struct stp_psp_metric_table {
    size_t
        state_bytes; ///< of a splat's state, a multiple of 8, at most STP_PSP_STATE_MOST; may be 0
    int power;       ///< errors have the unit length^power, with the weight by the edge's length
    bool by_length;  ///< errors are weighted by the distance of the two centres (formulas 1 and 2)
    /// Makes `shared->own`; false if out of memory. NULL: not needed.
    bool (*open)(stp_psp_shared* shared);
    void (*close)(stp_psp_shared* shared);
    /// Makes the state of a point's splat; may also change the splat. NULL without a state.
    void (*begin)(const stp_psp_shared* shared, uint32_t point, stp_psp_splat* splat, void* state);
    /// The error of a merge, at least 0, without the weight by length. Called with the splat of
    /// lower key first.
    double (*error)(const stp_psp_shared* shared, const stp_psp_splat* a, const void* a_state,
                    const stp_psp_splat* b, const void* b_state);
    /// Makes the ellipse, the area and the state of two splats merged. `merged` comes with colours
    /// mixed by area, and may get others. Called once for each merge, lower key first; what is read
    /// and written differs.
    void (*merge)(const stp_psp_shared* shared, const stp_psp_splat* a, const void* a_state,
                  const stp_psp_splat* b, const void* b_state, stp_psp_splat* merged,
                  void* merged_state);
    /// Turns the normals in a state to the other side. NULL: it has none.
    void (*turn)(void* state);
} stp_psp_metric_table;

extern const stp_psp_metric_table stp_psp_metric_normals, stp_psp_metric_distances,
    stp_psp_metric_regions;

const stp_psp_metric_table* stp_psp_metric_find(stp_psp_metric metric);

/// The error of a merge as the queue orders it: weighted, as a float at most FLT_MAX. Infinite if
/// the merge is not allowed (stp_psp_desc.least_cosine). The two may be in any order.
float stp_psp_pair_error(const stp_psp_shared* shared, const stp_psp_metric_table* metric,
                         const stp_psp_splat* a, const void* a_state, const stp_psp_splat* b,
                         const void* b_state);

/// Merges two splats, in any order: ellipse, state, area, colour, key. The caller sets the id.
void stp_psp_merge_pair(const stp_psp_shared* shared, const stp_psp_metric_table* metric,
                        const stp_psp_splat* a, const void* a_state, const stp_psp_splat* b,
                        const void* b_state, stp_psp_splat* merged, void* merged_state);
