// SPDX-License-Identifier: MIT
//
// Progressive orders of points: every prefix covers the whole set evenly.
#pragma once

#include <stipple/types.h>

#ifdef __cplusplus
extern "C" {
#endif

typedef enum stp_order_kind {
    STP_ORDER_EXACT, ///< exact greedy permutation (farthest-first traversal)
    /// Brandt 3.2, with the schedule that fits the published times: samples halved, accepts grow
    STP_ORDER_PAPER_FAST,
    STP_ORDER_PAPER_TEXT, ///< Brandt 3.2 as printed: fixed samples, one more accept every interval
    STP_ORDER_RANDOM,     ///< uniformly random
    STP_ORDER_BEST_OF_K,  ///< the best of `samples` random candidates per pick (Mitchell 1991)
} stp_order_kind;

typedef enum stp_order_metric {
    STP_METRIC_SIDE,      ///< |p - q|, plus the set's diameter if the normals face apart (n.m < 0)
    STP_METRIC_EUCLIDEAN, ///< |p - q|
} stp_order_metric;

/// Options of an order. Zero selects the default of each field.
typedef struct stp_order_desc {
    size_t struct_size;      ///< sizeof(stp_order_desc), or 0: its first version
    stp_order_kind kind;     ///< default exact
    stp_order_metric metric; ///< default side-aware; Euclidean without normals
    /// For random kinds; the same seed gives the same order on any machine
    uint64_t seed;
    uint32_t samples;  ///< random samples per round; default 200
    uint32_t interval; ///< rounds until the schedule changes; default 500
    /// Paper kinds: a sample nearer than this times the round's pick is dropped from the input
    /// (3.2: "at close vicinity"); default 0: none
    float drop_factor;
    uint32_t thread_count; ///< threads for one order; 0: all of the context
} stp_order_desc;

/// Measurements. This struct does not grow.
typedef struct stp_order_report {
    double index_ms;         ///< sorting and building the search structure
    double order_ms;         ///< choosing
    uint64_t distance_count; ///< point distances evaluated, if the kind counts them
} stp_order_report;

/// Orders the best `wanted` of `point_count` points.
///
/// Deterministic: the same bytes for any number of threads and any CPU. Exact orders start with the
/// point nearest to the centre of the bounding box and break ties by Morton order. (With the
/// side-aware metric, the curve separates points by facing within cells of 1/16 of the box.) Exact
/// kinds never choose a point that coincides with a chosen one (distance 0), so they may return
/// fewer than `wanted`.
///
/// @param positions 3 floats per point, finite
/// @param normals 3 floats per point, unit length; NULL: none
/// @param order      receives up to `wanted` distinct indices
/// @param radii receives each point's distance to the nearest earlier one (infinity for the first);
///                   NULL: not wanted. Exact kinds: never increasing.
/// @param ordered receives the number of ordered points
/// @param final_radius receives the distance of the farthest point to the order; NULL: not wanted
/// @param desc       NULL: all zero
/// @param report     may be NULL
/// @return STP_OK, STP_ERROR_OUT_OF_MEMORY, STP_ERROR_CANCELLED, STP_ERROR_ARGUMENT if a position
/// is not finite, or STP_ERROR_UNSUPPORTED if `desc` sets fields that this library does not know
STP_API STP_MUST_USE stp_result stp_order_points(stp_context* context, const stp_order_desc* desc,
                                                 const float* positions, const float* normals,
                                                 uint32_t point_count, uint32_t wanted,
                                                 uint32_t* order, float* radii, uint32_t* ordered,
                                                 float* final_radius, stp_order_report* report);

#ifdef __cplusplus
}
#endif
