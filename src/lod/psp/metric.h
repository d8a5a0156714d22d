// SPDX-License-Identifier: MIT
// Error metrics of merges, each a table of functions (Wu, Zhang, Kobbelt 2005, section 4).
//
// Geometry is in merge units: model units times a power of two, such that the diagonal of the
// points' bounding box is about 2^20. Errors then fit in floats, and products of areas do not
// underflow.
#pragma once

#include "lod/psp/forest.h"
#include "lod/psp/room.h"

/// A splat during merging.
typedef struct stp_psp_splat {
    stp_ellipse ellipse;
    float area;
    float color[3]; ///< linear RGB
    uint32_t id;    ///< number of the splat; within a piece, perhaps STP_PSP_RECORDED | its record
    uint32_t key;   ///< smallest index of the represented points: breaks ties
} stp_psp_splat;

/// Shared by all splats of a merge.
typedef struct stp_psp_shared {
    stp_context* context;
    const stp_psp_points* points;
    const stp_psp_room* room; ///< storage of per-point arrays; NULL: in memory
    stp_psp_desc desc;
    float scale;     ///< from model units to merge units
    float minimum;   ///< minimum length of axes
    stp_vec3 middle; ///< centre of the points' bounding box
    void* own;       ///< metric's data, from `open`
} stp_psp_shared;

/// Position of a point in merge units.
stp_vec3 stp_psp_point_at(const stp_psp_shared* shared, uint32_t point);

enum { STP_PSP_STATE_MAX = 512 }; ///< maximum size of a state in bytes

/// An error metric. Splats may have a metric-specific state. Functions are called from several
/// threads concurrently, for different splats.
typedef struct stp_psp_metric_table {
    /// Size of a splat's state: a multiple of 8, at most STP_PSP_STATE_MAX; may be 0
    size_t state_bytes;
    int power;      ///< errors, including the distance weight, have unit length^power
    bool by_length; ///< errors are weighted by the distance between the centres (formulas 1 and 2)
    /// Creates `shared->own`; false if out of memory or disk space. NULL: not needed.
    bool (*open)(stp_psp_shared* shared);
    void (*close)(stp_psp_shared* shared);
    /// Creates the state of a point's splat; may also change the splat. NULL: no state.
    void (*begin)(const stp_psp_shared* shared, uint32_t point, stp_psp_splat* splat, void* state);
    /// Error of a merge, at least 0, without the distance weight. `a` is the splat with the lower
    /// key.
    double (*error)(const stp_psp_shared* shared, const stp_psp_splat* a, const void* a_state,
                    const stp_psp_splat* b, const void* b_state);
    /// Computes ellipse, area and state of a merged splat. `merged` already has colours mixed by
    /// area, which may be replaced. Called once per merge, lower key first. Inputs and outputs do
    /// not alias.
    void (*merge)(const stp_psp_shared* shared, const stp_psp_splat* a, const void* a_state,
                  const stp_psp_splat* b, const void* b_state, stp_psp_splat* merged,
                  void* merged_state);
    /// Turns the normals in a state to the other side. NULL: it has none.
    void (*turn)(void* state);
} stp_psp_metric_table;

extern const stp_psp_metric_table stp_psp_metric_normals, stp_psp_metric_distances,
    stp_psp_metric_regions;

const stp_psp_metric_table* stp_psp_metric_find(stp_psp_metric metric);

/// Error of a merge as the queue orders it: weighted, a float of at most FLT_MAX. Infinite if the
/// merge is not allowed (stp_psp_desc.min_cosine). Symmetric in `a` and `b`.
float stp_psp_pair_error(const stp_psp_shared* shared, const stp_psp_metric_table* metric,
                         const stp_psp_splat* a, const void* a_state, const stp_psp_splat* b,
                         const void* b_state);

/// Merges two splats, given in any order: ellipse, state, area, colour, key. The caller sets the
/// id.
void stp_psp_merge_pair(const stp_psp_shared* shared, const stp_psp_metric_table* metric,
                        const stp_psp_splat* a, const void* a_state, const stp_psp_splat* b,
                        const void* b_state, stp_psp_splat* merged, void* merged_state);
