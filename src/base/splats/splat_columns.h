// SPDX-License-Identifier: MIT
//
// The splats of one node: columns in progressive order, so that the first n splats are the best n.
// Splats of method `blue` are called surfels.
//
//   octave      0        1              2                3
//   splats   [0 .. e0) [.. e1)       [.. e2)          [.. e3 = count)
//   colours  e0 for octave 0 | e1 for octave 1 | e2 for octave 2 | e3 for octave 3  (the pyramid)
//
// Over an octave of the order, the insertion radius halves. In a short prefix each splat
// represents a large patch, so each octave stores colours and coverages for the whole prefix that
// ends with it: 1 + 1/4 + 1/16 + ... of the column. A prefix of n splats, e(k-1) < n <= e(k), is
// drawn with the colours of octave k; splats below e(k-1) blend them with octave k - 1
// (docs/algorithms/finish.md).
#pragma once

#include "base/math/math.h"

#include <stipple/attributes.h>
#include <stipple/types.h>

#include <stdbool.h>

enum {
    STP_PREFIX_TABLE_SIZE = 64, ///< maximum breakpoints of a prefix table
    STP_OCTAVE_LIMIT = 24,      ///< maximum octaves of a splat set
    /// Triangles drawn in preference to one splat: this many cost five times as much as the splat,
    /// but look better (docs/notes/2026-11-proportion.md). Limits the splats that a build makes
    /// and a view draws.
    STP_TRIANGLES_PER_SPLAT = 8,
    STP_POSITION_STEPS = 65535, ///< steps of the grid of positions along the longest side of a set
};

/// Coverage of prefixes: the coverage radius (non-increasing) at breakpoints `count` (ascending).
/// Every candidate lies within `radius` of one of the first `count` points. Log-log interpolation
/// between breakpoints is conservative: the true radius is never larger. Node-space units.
typedef struct stp_prefix_table {
    uint32_t size;
    uint32_t count[STP_PREFIX_TABLE_SIZE];
    float radius[STP_PREFIX_TABLE_SIZE];
} stp_prefix_table;

/// Methods: algorithms that choose the splats of a set and the subset that a view draws.
enum {
    STP_METHOD_BLUE = 1,       ///< Progressive Blue Surfels (Brandt et al. 2019)
    STP_METHOD_SPT = 2,        ///< Sequential Point Trees (Dachsbacher et al. 2003)
    STP_METHOD_PSP = 3,        ///< Progressive Splatting (Wu et al. 2005)
    STP_METHOD_STOCHASTIC = 4, ///< view-dependent Stochastic Sampling (Bhakar et al. 2004)
    /// A few ellipses of `psp` for the uppermost sets of `blue`, drawn in place of its first disks.
    /// Nobody chooses it, and lists of methods leave it out
    STP_METHOD_COARSE = 5,
};

/// Optional columns of a set, and its colour layout.
enum {
    STP_SPLATS_SHAPES = 1,      ///< each splat has its own size
    STP_SPLATS_RANGES = 2,      ///< each splat is drawn within a range of levels
    STP_SPLATS_FLAT_COLORS = 4, ///< one colour and coverage per splat, no pyramid
    STP_SPLATS_REPLACED = 8,    ///< disk shapes mark the splats that large triangles replace
    STP_SPLATS_ERRORS = 16,     ///< ranges depend on the view direction; requires ranges
    STP_SPLATS_COLUMNS = 31,    ///< all bits that this version supports
};

/// Maximum slope of levels over depth: level ranges of neighbouring splats overlap by this share of
/// the distance. A view that allows a larger error uses one level for the whole set.
#define STP_LEVEL_SLOPE 0.005f

enum {
    STP_GROUP_SPLATS = 64,
    /// Large triangles are drawn beside a node's set only with at most this many part and node
    /// instances below the node.
    STP_LARGE_USES = 64,
};

/// Bounds of STP_GROUP_SPLATS consecutive splats of a set with ranges, for culling. Computed on
/// loading; not stored.
typedef struct stp_splat_group {
    uint16_t low[3], high[3]; ///< bounds of their grid positions
    uint16_t largest;         ///< code of the maximum radius (src/base/splats/splat_codes.h)
    int8_t axis[3];           ///< axis of a cone that holds their normals, 127 is 1
    uint8_t sine;             ///< sine of half the cone's angle, 255 is 1; 255 also if it is wider
    uint64_t replaced;        ///< one bit per splat, lowest first: large triangles replace it
} stp_splat_group;

/// A leaf of a set built leaf by leaf (docs/format.md, Leaves): a cube of the set's position grid,
/// and properties of the splats in it. A leaf's splats are consecutive in each octave, in random
/// order, so its first splats are a random sample. Codes: src/base/splats/leaf_codes.h.
typedef struct stp_splat_leaf {
    uint16_t corner[3]; ///< minimum corner on the grid
    uint8_t place;      ///< bits 0-4: depth d, 2^(16 - d) grid steps wide; bits 5-6: STP_LEAF_*
    uint8_t extent;     ///< side of a square with the surface's area: 64 is the cube's side
    uint32_t count;     ///< splats in the whole set, at least 1
    int8_t normal[2];   ///< mean normal, octahedral
    uint8_t flatness;   ///< deviation from flat
    uint8_t spread;     ///< sine of the maximum angle to `normal`; 255: 1, or any angle
} stp_splat_leaf;

enum {
    STP_LEAF_DEPTH = 31, ///< bits of stp_splat_leaf.place
    STP_LEAF_DEPTH_MAX = 16,
    STP_LEAF_EDGE = 32,     ///< contains an edge
    STP_LEAF_ORIENTED = 64, ///< the orientation of its normal is known
};

/// The splats of a node, of any method, in order. Surfels of `blue` take 12 bytes each (position 6,
/// normal 2, colour 3, material 1), about 14.4 with pyramids, at most 18.4 with light normals.
typedef struct stp_splats {
    uint32_t count;
    stp_vec3 origin;     ///< origin of the position grid, in the node's space
    float step;          ///< step of the position grid, node units: a power of two
    uint16_t* positions; ///< 3 per splat: origin + step * value
    int8_t* normals;    ///< 2 per splat, octahedral (src/base/splats/octahedral.h); facing outwards
    uint8_t* materials; ///< shading index
    uint32_t octave_count;
    uint32_t octave_ends[STP_OCTAVE_LIMIT]; ///< ascending; the last is `count`
    /// 3 per entry, sRGB; the sum of octave_ends entries, octave 0 first. Without a pyramid: one
    /// entry per splat.
    uint8_t* colors;
    /// 1 per entry, same layout: share of the disk that is drawn (src/base/splats/coverage.h); 255:
    /// all
    uint8_t* coverages;
    /// Octaves with light normals (src/base/splats/light_normal.h), one bit each, lowest first; 0
    /// without a pyramid. They have an entry for each splat of the octave's prefix, octave 0 first.
    uint32_t light_octaves;
    int8_t* turns;           ///< NULL, or 2 per entry: by how much the normal's code differs
    uint8_t* spreads;        ///< NULL, or 1 per entry: 1 less the length of the mean normal; 255: 1
    uint32_t columns;        ///< STP_SPLATS_*
    uint32_t* shapes;        ///< NULL, or 1 per splat (src/base/splats/splat_codes.h)
    uint32_t* ranges;        ///< NULL, or 1 per splat (src/base/splats/splat_codes.h)
    uint32_t* errors;        ///< NULL, or 1 per splat (src/base/splats/splat_codes.h)
    stp_splat_group* groups; ///< NULL, or 1 per STP_GROUP_SPLATS splats
    /// NULL, or the set's leaves, along a Morton curve; their counts assign splats to leaves
    /// (src/base/splats/leaf_runs.h). For sets of a store, see stp_store_get_leaves.
    stp_splat_leaf* leaves;
    uint32_t leaf_count;
    /// Each NULL, or one value per splat: the attribute of its point (attributes.h). A store does
    /// not return them with its sets: src/store/file/point_attributes.h.
    void* attributes[STP_ATTRIBUTES];
    bool plain_coverages; ///< coverages are shares of 255: files before version 1.2
    bool unknown_signs;   ///< normals are estimates; either side may be outside
    /// Maximum distance from splats to their original points, in scene units; 0: unknown.
    float position_error;
    stp_prefix_table table;
    /// Half the diagonal of a capture pixel: maximum distance from surface to a candidate
    float candidate_radius;
    /// r_m: median distance to the nearest neighbour within the first p_m (Brandt 4.1)
    float paper_radius;
    uint32_t paper_count; ///< p_m
} stp_splats;

/// Attributes for which a set has columns, one bit each (stp_attribute_bit).
static inline uint32_t stp_splats_attributes(const stp_splats* splats)
{
    uint32_t mask = 0;
    for (uint32_t i = 0; i < STP_ATTRIBUTES; ++i) {
        mask |= splats->attributes[i] != NULL ? 1u << i : 0;
    }
    return mask;
}

enum {
    STP_SHADING_UNLIT = 1,
    STP_SHADING_DOUBLE_SIDED = 2,
    /// The material is blended: coverage is opacity, not holes; since format 1.2
    STP_SHADING_TRANSPARENT = 4,
    /// Backs are not drawn, as for single-sided materials of glTF. In files by a section of its
    /// own.
    STP_SHADING_FRONT_ONLY = 8,
};

/// Material that a splat's material byte refers to; at most 256 per file.
typedef struct stp_shading {
    float metallic, roughness;
    float emissive[3]; ///< linear
    uint32_t flags;
    /// By how much the candidate radius of a splat is larger than its set's, as a share of that:
    /// above -1, at most STP_GROWTH_MAX; since format 1.4
    float growth;
} stp_shading;

enum { STP_GROWTH_MAX = 63 };

/// Whether any shading has a growth.
static inline bool stp_any_growth(const stp_shading* shadings, uint32_t count)
{
    for (uint32_t i = 0; i < count; ++i) {
        if (shadings[i].growth > 0.0f || shadings[i].growth < 0.0f) {
            return true;
        }
    }
    return false;
}

/// The largest growth of any shading, at least 0.
static inline float stp_largest_growth(const stp_shading* shadings, uint32_t count)
{
    float largest = 0.0f;
    for (uint32_t i = 0; i < count; ++i) {
        largest = shadings[i].growth > largest ? shadings[i].growth : largest;
    }
    return largest;
}

/// Share of a splat's drawn radius that its shading's growth applies to: radii are multiplied by
/// 1 + growth * share. `radius` is that of a set's splats, `candidate_radius` included.
static inline float stp_growth_share(float candidate_radius, float radius)
{
    return candidate_radius < radius ? candidate_radius / radius : 1.0f;
}

// Positions of the splats in a set.

/// Position of a splat in the space of its set's node.
static inline stp_vec3d stp_splat_place(const stp_splats* set, size_t index)
{
    const uint16_t* at = set->positions + 3 * index;
    double step = (double)set->step;
    return (stp_vec3d){(double)set->origin.x + step * (double)at[0],
                       (double)set->origin.y + step * (double)at[1],
                       (double)set->origin.z + step * (double)at[2]};
}
