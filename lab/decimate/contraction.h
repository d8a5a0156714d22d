// SPDX-License-Identifier: MIT
// Contracts pairs of neighbouring points, the least quadric error first (Pauly, Gross, Kobbelt.
// Efficient Simplification of Point-Sampled Surfaces. 2002, 3.2).
#pragma once

#include "base/core/context.h"
#include "base/math/math.h"
#include "lab/decimate/point_disks.h"

// Distinct positions of points: merges coincident points.

typedef struct stp_distinct {
    uint32_t count;
    float* positions; ///< 3 per place
    /// 3 per place: means of its points, unit length or zero; NULL: the input has none
    float* normals;
    uint32_t* points;      ///< per position, its first point along the curve
    uint32_t* places;      ///< per point, the index of its position
    stp_color_mean* means; ///< per position, the mean colour of its points
} stp_distinct;

/// Lists positions along a space-filling curve, so that neighbours are close in memory
/// (stp_sort_spatially).
/// @return STP_OK, STP_ERROR_OUT_OF_MEMORY (logged); freed by stp_distinct_destroy, also after a
///         failure
STP_MUST_USE stp_result stp_distinct_make(stp_context* context, const stp_decimate_input* input,
                                          stp_distinct* distinct);
void stp_distinct_destroy(stp_context* context, stp_distinct* distinct);
/// Replaces corners of triangles, which are points, by their positions, and drops triangles that
/// are degenerate then. `welded` (room for all) may be `triangles`. @return the number left
uint32_t stp_distinct_weld(const stp_distinct* distinct, const uint32_t* triangles,
                           uint32_t triangle_count, uint32_t* welded);

// Neighbour links of points, while points are merged.

typedef struct stp_point_links {
    stp_context* context;
    uint32_t count;           ///< number of points
    uint32_t* kept;           ///< per point, the point it was merged into; itself: none
    uint32_t *first, *last;   ///< per point: first and last entry of its list; UINT32_MAX: none
    uint32_t *targets, *next; ///< per entry: linked point, next entry; UINT32_MAX ends a list
    uint32_t* marks;          ///< per point: stamp of its last listing
    uint32_t stamp;
} stp_point_links;

/// Links two points if one is among the nearest of the other.
/// @param neighbours k per point, other points without repeats; UINT32_MAX if there are fewer
/// @return STP_OK, STP_ERROR_OUT_OF_MEMORY, STP_ERROR_LIMIT (logged); freed by
///         stp_point_links_destroy, also after a failure
STP_MUST_USE stp_result stp_point_links_make(stp_context* context, const uint32_t* neighbours,
                                             uint32_t count, uint32_t k, stp_point_links* links);
/// Merges `gone` into `kept`, which takes its neighbours. Both must be unmerged.
void stp_point_links_unite(stp_point_links* links, uint32_t kept, uint32_t gone);
/// Lists the neighbours of an unmerged point, each once.
/// @param out space for all points.
/// @return number of neighbours
uint32_t stp_point_links_list(stp_point_links* links, uint32_t point, uint32_t* out);
void stp_point_links_destroy(stp_point_links* links);

// Sums of squared distances from planes (Garland, Heckbert. Surface Simplification Using Quadric
// Error Metrics. 1997).

/// x' A x + 2 b' x + c.
typedef struct stp_quadric {
    double a[6]; ///< xx, xy, xz, yy, yz, zz
    stp_vec3d b;
    double c;
} stp_quadric;

/// Adds the plane through a point with a unit normal.
void stp_quadric_add_plane(stp_quadric* quadric, stp_vec3d point, stp_vec3d normal);
stp_quadric stp_quadric_sum(const stp_quadric* a, const stp_quadric* b);
/// The value at a point; never below 0.
double stp_quadric_at(const stp_quadric* quadric, stp_vec3d point);
/// Sum of the squared normals: the number of planes.
double stp_quadric_planes(const stp_quadric* quadric);
/// Point of minimum value. Stays near `start` along directions in which the value hardly changes
/// (less than a thousandth of the mean); returns `start` if the minimum is farther away than
/// `reach`.
stp_vec3d stp_quadric_minimum(const stp_quadric* quadric, stp_vec3d start, double reach);

/// Best pair of a point.
typedef struct stp_contraction_pair {
    double error; ///< value of both quadrics at the contracted point; 0 if it is rounding noise
    /// Orders pairs of equal error: squared length x the numbers of represented points
    double weight;
    uint32_t partner; ///< UINT32_MAX: none
} stp_contraction_pair;

typedef struct stp_contraction {
    stp_context* context;
    stp_distinct* points;     ///< normals and means are summed on contraction
    const stp_ellipse* disks; ///< disks of the points; only their normals are read, to begin
    stp_point_links links;
    stp_vec3d middle; ///< origin of positions
    double minimum;   ///< error per plane; below it, an error is rounding noise
    stp_vec3d* positions;
    stp_quadric* quadrics;
    stp_contraction_pair* pairs; ///< best pair of each point
    uint32_t* heap;              ///< heap of points, the best pair first
    uint32_t* places;            ///< heap index of points; UINT32_MAX: not in it
    uint32_t* near;              ///< neighbours of one point
    uint32_t* near_near;         ///< those of one of them
    uint32_t heap_count;
    uint32_t left; ///< number of remaining points
} stp_contraction;

/// Prepares all pairs. `context`, `points` and `disks` are set; neighbours as in
/// stp_point_links_make.
/// @return STP_OK, STP_ERROR_OUT_OF_MEMORY, STP_ERROR_LIMIT (logged); freed by
///         stp_contraction_destroy, also after a failure
STP_MUST_USE stp_result stp_contraction_make(stp_contraction* c, const uint32_t* neighbours,
                                             uint32_t k);
/// Contracts the best pair. @return false if no pair is left
bool stp_contraction_step(stp_contraction* c);
void stp_contraction_destroy(stp_contraction* c);
