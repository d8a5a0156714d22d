// SPDX-License-Identifier: MIT
//
// External visibility (Brandt 3.1): a subtree seen from outside, by parallel projection from all
// sides. Each covered pixel is a candidate: a point of visible surface that may become a splat.
// Texels cut out by an alpha mask are not captured: the mask is read at the pixel's centre at full
// resolution, so the share of captured pixels equals the share of remaining surface. Blended
// surfaces are captured in half their pixels, chosen by a hash, so that surfaces behind glass are
// captured too; their alpha is recorded. Each point of a point set is one pixel.
#pragma once

#include "base/splats/splat_columns.h"
#include "capture/silhouettes.h"
#include "scene/scene.h"

/// Limit on the pixels drawn per requested candidate when the resolution is automatic. Sparse
/// scenes have mostly empty pixels; the limit bounds the cost.
#define STP_CAPTURE_MAX_PIXELS_EACH 1024.0

/// Mip levels of a scene's textures, as far as splats show them. Making them takes as long as a
/// small capture: make them once to capture many nodes of one scene.
typedef struct stp_capture_textures stp_capture_textures;

typedef struct stp_capture_desc {
    /// Default 8: a cube's corners. 14: also its faces. 26: also the middles of its edges. Any
    /// other number: spread evenly over the sphere.
    uint32_t direction_count;
    /// `direction_count` unit vectors towards the viewer, instead of the defaults. Surface they
    /// miss is not filled in. NULL: use the defaults.
    const stp_vec3d* directions;
    /// Pixels along the longer side of the widest picture; one scale for all directions. Default:
    /// chosen to give about `wanted_candidates`.
    uint32_t resolution;
    double pixel_size;          ///< side of a pixel in scene units; 0: from `resolution`
    uint64_t wanted_candidates; ///< for the automatic resolution; default 1.75 million
    bool no_fill;               ///< skip the fill (fill.h); 26 directions are never filled
    const stp_capture_textures* textures; ///< textures of this scene; NULL: made for this call
} stp_capture_desc;

/// A prefix of a splat set that replaces the geometry it was made from (Brandt 3.4), with its
/// transform.
typedef struct stp_placed_set {
    const stp_splats* splats;
    uint32_t prefix;      ///< splats of the prefix, at least 1
    float radius;         ///< radius of their disks, in the set's own space
    stp_affine transform; ///< to the captured space
    bool unknown_signs;   ///< either side of a splat may be outside
} stp_placed_set;

/// Sources of a capture.
typedef struct stp_capture_sources {
    const stp_placed_part* parts;
    size_t part_count;
    const stp_placed_set* sets;
    size_t set_count;
} stp_capture_sources;

/// Candidates as columns, in an order that is independent of the thread count. First captured
/// pixels, by direction, row and column; then visible splats of sets, in the order of their sets.
typedef struct stp_candidates {
    uint32_t count;
    float* positions; ///< 3 each, in the node's space minus `origin`
    float* normals;   ///< 3 each, unit, on the side of the surface that faces the viewer
    /// 3 each, of length 0 to 1: the mean normal of the surface by which light falls on it, turned
    /// by normal maps; of a splat of a set, its light normal. NULL: the normals
    float* light_normals;
    /// RGBA each, sRGB: base colour with texture and vertex colour. Alpha: opacity of a blended
    /// material; for a splat of a set, the share of its disk that is surface
    uint8_t* colors;
    /// Scene material, or material_count + variant (scene/looks.h); of a splat of a set, its
    /// shading
    uint32_t* materials;
    /// Each NULL, or one value per candidate (stipple/attributes.h), for points and for splats of
    /// point sets.
    void* attributes[STP_ATTRIBUTES];
    /// direction_count + 1: index of each direction's first candidate; NULL: none
    uint32_t* view_starts;
    stp_vec3d origin;   ///< centre of the captured box: positions are relative to it
    double pixel_size;  ///< side of a capture pixel, scene units
    uint32_t set_count; ///< the last `set_count` candidates are splats of sets
    float set_radius;   ///< largest radius of their disks, scene units
    /// Surface area that each of them represents, square scene units; may be NULL
    float* set_areas;
    /// Maximum distance of visible surface from a candidate; 0: half a pixel's diagonal
    double surface_radius;
    uint32_t resolution, direction_count;
    stp_silhouette silhouettes[STP_SILHOUETTES]; ///< silhouettes of the first directions
    uint32_t silhouette_count;                   ///< 0: none kept
    uint32_t filled; ///< captured candidates, before those of sets, that the main directions missed
    uint64_t covered_pixels, triangle_views; ///< statistics
    double raster_ms, resolve_ms;
} stp_candidates;

/// Fraction of a disk's area that is nearest to its splat if splats are evenly spaced and their
/// disks just cover the surface.
#define STP_WHOLE_SHARE 0.5

/// Probability of drawing a pixel of a disk over thin geometry: the surface nearest to its splat
/// over the disk's area. Thin geometry is seen from both sides.
static inline double stp_chance_of_share(double share)
{
    return 0.5 * share;
}

static inline double stp_share_of_chance(double chance)
{
    return 2.0 * chance;
}

/// First candidate that is a splat of a set; the candidate count if there is none.
static inline uint32_t stp_first_of_sets(const stp_candidates* candidates)
{
    return candidates->count - candidates->set_count;
}

/// Captures the parts (their transforms relative to the captured node's space).
/// @return STP_OK, STP_ERROR_OUT_OF_MEMORY, STP_ERROR_CANCELLED, or STP_ERROR_LIMIT if the
/// requested resolution gives 2^32 - 1 candidates or more
STP_MUST_USE stp_result stp_capture_parts(const stp_scene* scene, const stp_placed_part* parts,
                                          size_t part_count, const stp_capture_desc* desc,
                                          stp_candidates* candidates);
/// Appends all splats of sets, visible or not, to candidates whose columns have room for them. For
/// clouds, where every point may be seen. `origin` must be set; `set_areas` must be NULL.
/// @return STP_OK, or STP_ERROR_OUT_OF_MEMORY (logged)
STP_MUST_USE stp_result stp_candidates_add_sets(stp_context* context, const stp_placed_set* sets,
                                                size_t set_count, stp_candidates* candidates);
/// Captures parts and sets into the same pictures. A disk that wins pixels yields its splat once,
/// at the splat's own position, so surfaces do not grow. A splat whose neighbours won all its
/// pixels is taken too if its centre is not occluded. With sets, the desc should give the pixel
/// size: the resolution is not chosen automatically.
/// @return as stp_capture_parts
STP_MUST_USE stp_result stp_capture_all(const stp_scene* scene, const stp_capture_sources* sources,
                                        const stp_capture_desc* desc, stp_candidates* candidates);

/// Statistics of a capture, without making candidates and without the fill.
typedef struct stp_capture_count {
    uint64_t pixels; ///< covered by parts
    uint64_t splats; ///< visible splats of sets
    double widest;   ///< longer side of the widest picture, scene units
} stp_capture_count;
STP_MUST_USE stp_result stp_capture_count_all(const stp_scene* scene,
                                              const stp_capture_sources* sources,
                                              const stp_capture_desc* desc,
                                              stp_capture_count* count);
void stp_candidates_destroy(stp_context* context, stp_candidates* candidates);

/// The scene must outlive them. @param colors_only without those of roughness, metal, emission and
/// normals: enough for stp_capture_triangle_color, not for a capture
STP_MUST_USE stp_result stp_capture_textures_create(const stp_scene* scene, bool colors_only,
                                                    stp_capture_textures** textures);
void stp_capture_textures_destroy(stp_capture_textures* textures);

/// Whether base colours of a mesh differ from place to place.
bool stp_capture_has_colors(const stp_capture_textures* textures, const stp_mesh* mesh);
/// The base colour at a point of a triangle, with texture and vertex colours: the mean around the
/// point, over a share of the triangle's width. `weights`: barycentric. `color`: red, green, blue,
/// linear
void stp_capture_triangle_color(const stp_capture_textures* textures, const stp_mesh* mesh,
                                uint32_t triangle, const float weights[3], double share,
                                float color[3]);

/// The directions of a desc: `count` unit vectors from the object towards the viewer. Corners are
/// those of a cube, not of the object's box: a flat box's corners lie almost in its plane and would
/// see its large faces at grazing angles. Pure; no libm.
void stp_capture_directions(uint32_t count, stp_vec3d* directions);
