// SPDX-License-Identifier: MIT
//
// The splats of one node: columns in progressive order, so that the first n splats are the best n. Those of method `blue` are
// called surfels, here and wherever they are made.
//
//   octave      0        1              2                                 3
//   surfels  [0 .. e0) [.. e1)     [.. e2)                           [.. e3 = count)
//   colours  e0 for octave 0 | e1 for octave 1 | e2 for octave 2 | e3 for octave 3      (the colour pyramid)
//
// An octave is the run of the order over which the insertion radius halves. A surfel drawn as one of few
// stands for a large patch, so each octave has its own colours and coverages for the whole prefix that ends
// with it: 1 + 1/4 + 1/16 + ... of the column. A prefix of n surfels, e(k-1) < n <= e(k), is drawn with the
// colours of octave k, blended with those of octave k - 1 for the surfels below e(k-1) (design.md, Finish).
#pragma once

#include <stipple/attributes.h>
#include <stipple/types.h>

#include <stdbool.h>

enum {
    STP_PREFIX_TABLE_SIZE = 64, ///< most breakpoints of a prefix table
    STP_OCTAVE_LIMIT = 24,      ///< most octaves of a surfel set
    /// Triangles that are drawn rather than one splat: so many cost five times as much, and look better
    /// (docs/notes/2026-11-proportion.md). A build makes no more surfels, a view draws no more of them.
    STP_TRIANGLES_PER_SURFEL = 8,
};

/// How far a prefix covers: for breakpoints `count` (ascending), the coverage radius reached (not ascending):
/// every candidate lies within `radius` of one of the first `count` points. Between breakpoints log-log
/// interpolation is conservative: the true radius is never larger. Units of the node's space.
typedef struct stp_prefix_table {
    uint32_t size;
    uint32_t count[STP_PREFIX_TABLE_SIZE];
    float radius[STP_PREFIX_TABLE_SIZE];
} stp_prefix_table;

/// Ids of methods: how the splats of a set were chosen, and which of them a view draws.
enum {
    STP_METHOD_BLUE = 1,       ///< Progressive Blue Surfels (Brandt et al. 2019)
    STP_METHOD_SPT = 2,        ///< Sequential Point Trees (Dachsbacher et al. 2003)
    STP_METHOD_PSP = 3,        ///< Progressive Splatting (Wu et al. 2005)
    STP_METHOD_STOCHASTIC = 4, ///< view-dependent Stochastic Sampling (Bhakar et al. 2004)
};

/// Optional columns of a set, and how its colours are kept.
enum {
    STP_SPLATS_SHAPES = 1,      ///< splats have a size of their own
    STP_SPLATS_RANGES = 2,      ///< each splat is drawn within a range of levels
    STP_SPLATS_FLAT_COLORS = 4, ///< one colour and coverage a splat, without a pyramid
    STP_SPLATS_REPLACED = 8,    ///< shapes of disks tell which splats large triangles replace
    STP_SPLATS_COLUMNS = 15,    ///< all that this version knows
};

/// How steeply levels may rise with depth: by so much of the distance, ranges of neighbouring splats overlap. A view that
/// allows a larger error takes one level for all of a set.
#define STP_LEVEL_SLOPE 0.005f

enum {
    STP_GROUP_SPLATS = 64,
    /// Most uses of parts and nodes below a node for its large triangles to be drawn beside its set.
    STP_LARGE_USES = 64,
};

/// Bounds of STP_GROUP_SPLATS consecutive splats of a set with ranges, for culling. Computed on loading; not stored.
typedef struct stp_splat_group {
    uint16_t low[3], high[3]; ///< of positions
    uint16_t largest;         ///< code of the largest radius (src/base/splat_codes.h)
    int8_t axis[3];           ///< of a cone that holds their normals, 127 is 1
    uint8_t sine;             ///< of half its angle, 255 is 1; 255 also of wider cones
    uint64_t replaced;        ///< a bit a splat, the lowest one first: large triangles replace it
} stp_splat_group;

/// A leaf of a set that was made leaf by leaf (docs/format.md, Leaves): a cube of the set's grid of positions, and what is
/// known of the splats in it. These lie together in each octave, shuffled, so those of the leaf that come first are a
/// random sample of it. Codes: src/base/leaf_codes.h.
typedef struct stp_splat_leaf {
    uint16_t corner[3]; ///< its lowest place on the grid
    uint8_t place;      ///< bits 0-4 the depth d: 2^(16 - d) places wide; bits 5-6 STP_LEAF_*
    uint8_t extent; ///< side of a square with the area of the surface in it: 64 is the cube's side
    uint32_t count; ///< splats in the whole set, at least 1
    int8_t normal[2]; ///< octahedral: the one that stands for all
    uint8_t flatness; ///< how far from flat
    uint8_t spread;   ///< sine of how far normals lie from that one, 255 is 1, or any
} stp_splat_leaf;

enum {
    STP_LEAF_DEPTH = 31, ///< bits of stp_splat_leaf.place
    STP_LEAF_DEPTH_MOST = 16,
    STP_LEAF_EDGE = 32,     ///< there is an edge in it
    STP_LEAF_ORIENTED = 64, ///< the sign of its normal is known
};

/// The splats of a node by any method, in its order. Those of `blue`, surfels, take 12 bytes each (position 6, normal 2,
/// colour 3, material 1), about 14.4 with pyramids.
typedef struct stp_splats {
    uint32_t count;
    stp_vec3 origin;     ///< of the position grid, in the node's space
    float step;          ///< of the position grid: a power of two
    uint16_t* positions; ///< 3 a surfel: origin + step * value
    int8_t* normals;     ///< 2 a surfel, octahedral (src/base/octahedral.h); facing outwards
    uint8_t* materials;  ///< index of a shading
    uint32_t octave_count;
    uint32_t octave_ends[STP_OCTAVE_LIMIT]; ///< ascending; the last is `count`
    /// 3 an entry, sRGB; sum of octave_ends entries, octave 0 first. Flat ones: an entry a surfel.
    uint8_t* colors;
    uint8_t*
        coverages; ///< 1 an entry, same layout: which part of the disk is drawn (src/base/coverage.h); 255: all of it
    uint32_t columns;        ///< STP_SPLATS_*
    uint32_t* shapes;        ///< NULL, or 1 a surfel (src/base/splat_shape.h)
    uint32_t* ranges;        ///< NULL, or 1 a surfel (src/base/splat_range.h)
    stp_splat_group* groups; ///< NULL, or 1 for each STP_GROUP_SPLATS
    /// NULL, or the leaves that the set was made of, along a Morton curve: their counts tell which splats are whose
    /// (src/base/leaf_runs.h). Of a store's sets, see stp_store_get_leaves.
    stp_splat_leaf* leaves;
    uint32_t leaf_count;
    /// Each NULL, or a value a splat, as the point that it is has it (attributes.h). A store gives none with its sets:
    /// src/store/attributes.h.
    void* attributes[STP_ATTRIBUTES];
    bool plain_coverages; ///< coverages are shares of 255 instead: of files before version 1.2
    bool unknown_signs;   ///< normals are estimates of which either side may be outside
    /// Scene units by which splats may lie from the original points that they are: 0 where that is not known.
    float position_error;
    stp_prefix_table table;
    float
        candidate_radius; ///< half the diagonal of a capture pixel: how far surface may lie from a candidate
    float
        paper_radius; ///< r_m: median distance to the nearest neighbour within the first p_m (Brandt 4.1)
    uint32_t paper_count; ///< p_m
} stp_splats;

/// The attributes that a set has columns of: a bit each (stp_attribute_bit).
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
    STP_SHADING_TRANSPARENT =
        4, ///< of a blended material: coverage is opacity, not holes; since format 1.2
};

/// What a surfel's material byte stands for; at most 256 in a file.
typedef struct stp_shading {
    float metallic, roughness;
    float emissive[3]; ///< linear
    uint32_t flags;
} stp_shading;
