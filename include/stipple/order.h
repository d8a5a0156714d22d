// SPDX-License-Identifier: MIT
//
// Orders of points in which every prefix covers the whole set evenly.
#pragma once

#include <stipple/types.h>

#ifdef __cplusplus
extern "C" {
#endif

typedef enum stp_order_kind {
    STP_ORDER_EXACT, ///< exact greedy permutation (farthest-first traversal)
    STP_ORDER_PAPER_FAST, ///< Brandt 3.2 with the schedule the published times fit: samples halved, accepts grow
    STP_ORDER_PAPER_TEXT, ///< Brandt 3.2 as printed: fixed samples, one accept more every interval
    STP_ORDER_RANDOM,     ///< uniformly random
    STP_ORDER_BEST_OF_K,  ///< the best of `samples` random candidates a pick (Mitchell 1991)
} stp_order_kind;

typedef enum stp_order_metric {
    STP_METRIC_SIDE, ///< |p - q|, plus the set's diameter where the normals face apart (n.m < 0)
    STP_METRIC_EUCLIDEAN, ///< |p - q|
} stp_order_metric;

/// How to order. A field left zero means its default.
typedef struct stp_order_desc {
    size_t struct_size;      ///< sizeof(stp_order_desc), or 0: its first version
    stp_order_kind kind;     ///< default exact
    stp_order_metric metric; ///< default side-aware; Euclidean where there are no normals
    uint64_t seed;           ///< of the random kinds; same seed, same order, on any machine
    uint32_t samples;        ///< random samples a round; default 200
    uint32_t interval;       ///< rounds until the schedule changes; default 500
    float
        drop_factor; ///< paper kinds: a sample nearer than this times the round's pick is dropped from
                     ///< the input (3.2: "at close vicinity"); default 0: none
    uint32_t thread_count; ///< threads for one order; 0: all of the context
} stp_order_desc;

/// What was measured on the way. This struct does not grow.
typedef struct stp_order_report {
    double index_ms;         ///< sorting and building the search structure
    double order_ms;         ///< choosing
    uint64_t distance_count; ///< point distances evaluated, where the kind counts them
} stp_order_report;

/// Orders the best `wanted` of `point_count` points.
///
/// Deterministic: the same bytes for any number of threads and any processor. Exact orders start with the
/// point nearest to the centre of the bounding box and break ties by Morton position (with the side-aware metric,
/// points of a cell of 1/16 of the box that face differently are apart on the curve). Points that coincide
/// with a chosen one (distance 0) are never chosen by the exact kinds: fewer than `wanted` may come back.
///
/// @param positions  3 floats a point, finite
/// @param normals    3 floats a point, unit; NULL: none
/// @param order      receives up to `wanted` distinct indices
/// @param radii      receives for each the distance to the nearest earlier one (infinity for the first);
///                   NULL: not wanted. Exact kinds: never increasing.
/// @param ordered    receives how many were ordered
/// @param final_radius receives the distance of the farthest point to the order; NULL: not wanted
/// @param desc       NULL: all zero
/// @param report     may be NULL
/// @return STP_OK, STP_ERROR_OUT_OF_MEMORY, STP_ERROR_CANCELLED, or STP_ERROR_ARGUMENT where a position is not
/// finite, or STP_ERROR_UNSUPPORTED where `desc` sets fields that this library does not know
STP_API STP_MUST_USE stp_result stp_order_points(stp_context* context, const stp_order_desc* desc,
                                                 const float* positions, const float* normals,
                                                 uint32_t point_count, uint32_t wanted,
                                                 uint32_t* order, float* radii, uint32_t* ordered,
                                                 float* final_radius, stp_order_report* report);

#ifdef __cplusplus
}
#endif
