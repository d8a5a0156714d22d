// SPDX-License-Identifier: MIT
// Structure of a capture: views are divided into bands of rows. Each band is drawn into a
// visibility buffer and reduced to its covered pixels; then all covered pixels become candidates.
#pragma once

#include "capture/capture.h"
#include "raster/target.h"
#include "raster/texture.h"

#include <stdatomic.h>

enum {
    STP_CAPTURE_DIRECTIONS = 8,
    STP_CAPTURE_RESOLUTION_MIN = 4,
    STP_CAPTURE_RESOLUTION_MAX = 16384,
};

struct stp_capture_textures {
    const stp_scene* scene;
    stp_texture_pyramid* pyramids; ///< one per texture; without levels if unused
    /// The same of textures of roughness and metal, and of normal maps: linear
    stp_texture_pyramid* surfaces;
};

/// A parallel projection in pixels: x = right . p + shift_x, y = down . p + shift_y.
typedef struct stp_capture_view {
    stp_vec3d toward;      ///< unit, towards the viewer
    stp_vec3d right, down; ///< unit vectors, divided by the pixel size
    double shift_x, shift_y;
    stp_vec3d depth; ///< nearness = depth . p + 1.5, between 1.1 and 1.9
    uint32_t width, height;
    uint32_t* silhouette; ///< one bit per pixel (silhouettes.h), or NULL
} stp_capture_view;

/// Rows of a view, and the covered pixels found there.
typedef struct stp_capture_band {
    uint32_t view, row_begin, row_end;
    uint32_t count;
    uint32_t* pixels;     ///< row * width + column, ascending
    uint64_t* primitives; ///< triangle or point that covers each pixel, numbered through all parts
} stp_capture_band;

struct stp_fill_map;

/// State shared by all steps.
typedef struct stp_capture_job {
    const stp_scene* scene;
    const stp_placed_part* parts;
    size_t part_count;
    uint64_t* first_primitives; ///< first primitive of each part, and the total
    stp_box* boxes; ///< box of each part, in its own space; contiguous, as each view tests all
    const stp_placed_set* sets;
    size_t set_count;
    uint64_t* first_splats; ///< first splat of each set, and the total; numbered after parts
    stp_boxd* set_boxes;    ///< box of each set's disks, in the captured space
    _Atomic uint32_t* seen; ///< one bit per splat
    stp_vec3d centre, half_extent;
    const stp_texture_pyramid* pyramids; ///< per texture
    const stp_texture_pyramid* surfaces; ///< likewise, of roughness, metal and normals
    bool has_lights; ///< a part's material has a normal map, or a set has light normals
    /// Primitives drawn into one buffer: ids are 32-bit numbers below 2^32 - 1
    uint64_t ids_per_pass;
    uint32_t view_count;
    stp_capture_view* views;
    size_t band_count;
    stp_capture_band* bands;
    uint64_t covered_pixels;
    bool keeps_silhouettes;                 ///< whether to keep those of the first views
    uint64_t room;                          ///< candidates that fit into the columns
    const struct stp_fill_map* represented; ///< drops pixels known to it; NULL: keep all
} stp_capture_job;

/// From a part's own space to the captured space minus its centre.
static inline stp_affine stp_capture_placement(const stp_capture_job* job, size_t part)
{
    return stp_affine_shifted(job->parts[part].transform, job->centre);
}

static inline uint64_t stp_capture_part_primitives(const stp_capture_job* job)
{
    return job->first_primitives[job->part_count];
}

static inline uint64_t stp_capture_primitive_count(const stp_capture_job* job)
{
    return stp_capture_part_primitives(job) + job->first_splats[job->set_count];
}

/// Sets up views along `directions` with a common pixel size.
void stp_capture_set_views(stp_capture_job* job, const stp_vec3d* directions, uint32_t count,
                           double pixel_size);

/// Longer side of the widest view, in scene units; `area` receives that of all views together.
double stp_capture_widest(const stp_capture_job* job, const stp_vec3d* directions, uint32_t count,
                          double* area);

/// Draws parts [begin, end) into a buffer of the band's rows. Ids count from the first part's first
/// primitive.
/// @return STP_OK or STP_ERROR_OUT_OF_MEMORY (not logged)
STP_MUST_USE stp_result stp_capture_draw_parts(const stp_capture_job* job,
                                               const stp_capture_band* band, size_t begin,
                                               size_t end, const stp_raster_target* target,
                                               stp_arena* scratch);

// Splat sets (splat_disks.c): their share of each step.

/// Numbers the splats and adds their disks to the box. @return STP_OK or STP_ERROR_OUT_OF_MEMORY
/// (logged)
STP_MUST_USE stp_result stp_capture_prepare_sets(stp_capture_job* job, stp_boxd* box);
void stp_capture_drop_sets(stp_capture_job* job);

/// Draws the disks of sets [begin, end) into a buffer of the band's rows. Ids count from
/// `first_id`.
/// @return STP_OK or STP_ERROR_OUT_OF_MEMORY (not logged)
STP_MUST_USE stp_result stp_capture_draw_sets(const stp_capture_job* job,
                                              const stp_capture_band* band, size_t begin,
                                              size_t end, uint32_t first_id,
                                              const stp_raster_target* target, stp_arena* scratch);

/// Marks the visible splats of a band's finished buffer and clears their pixels. `primitives`:
/// that of each pixel; NULL: ids are primitives.
void stp_capture_take_splats(const stp_capture_job* job, const stp_capture_band* band,
                             const stp_raster_target* target, const uint64_t* primitives);

uint64_t stp_capture_seen_count(const stp_capture_job* job);

/// Appends the visible splats to the candidates; the columns have room for all.
/// @return STP_OK or STP_ERROR_OUT_OF_MEMORY (logged)
STP_MUST_USE stp_result stp_capture_resolve_sets(const stp_capture_job* job,
                                                 stp_candidates* candidates);

/// Draws views [begin, end): adds to job->bands and covered_pixels. On failure, frees the bands.
STP_MUST_USE stp_result stp_capture_draw(stp_capture_job* job, uint32_t begin, uint32_t end);
void stp_capture_drop_bands(stp_capture_job* job);

/// Grows the columns for `more` candidates; if they must grow, also for `spare` ones.
/// @return STP_OK, STP_ERROR_OUT_OF_MEMORY or STP_ERROR_LIMIT (logged)
STP_MUST_USE stp_result stp_capture_make_room(stp_capture_job* job, uint64_t more, uint64_t spare,
                                              stp_candidates* candidates);

/// Appends the covered pixels of all bands to the candidates and empties the bands.
/// @return STP_OK, STP_ERROR_OUT_OF_MEMORY or STP_ERROR_LIMIT (logged)
STP_MUST_USE stp_result stp_capture_append(stp_capture_job* job, uint64_t spare,
                                           stp_candidates* candidates);

/// Writes the covered pixels of all bands as candidates from `first` on; the columns have room for
/// all.
void stp_capture_resolve(const stp_capture_job* job, stp_candidates* candidates, size_t first);

/// The alpha of a material at a point of a triangle, read at full resolution.
float stp_capture_alpha(const stp_material* material, const stp_texture_pyramid* level0,
                        const stp_mesh* mesh, uint32_t triangle, float weight1, float weight2);

/// Texture coordinates of a texture use at a vertex; false if the mesh has none.
bool stp_capture_texcoord(const stp_mesh* mesh, const stp_texture_use* use, uint32_t vertex,
                          double uv[2]);

/// Level 0 of a material's base colour texture; empty if the material has none.
stp_texture_pyramid stp_capture_level0(const stp_scene* scene, const stp_material* material);

STP_MUST_USE stp_result stp_capture_textures_create_empty(const stp_scene* scene,
                                                          stp_capture_textures** textures);
/// Makes the mip levels of a material's textures unless they exist; see stp_capture_textures_create.
STP_MUST_USE stp_result stp_capture_textures_add(stp_capture_textures* textures,
                                                 const stp_material* material, bool colors_only);

/// Like stp_capture_all and stp_capture_parts, with fewer primitives per pass, for tests.
STP_MUST_USE stp_result stp_capture_all_in_passes(const stp_scene* scene,
                                                  const stp_capture_sources* sources,
                                                  const stp_capture_desc* desc,
                                                  uint64_t ids_per_pass,
                                                  stp_candidates* candidates);
STP_MUST_USE stp_result stp_capture_parts_in_passes(const stp_scene* scene,
                                                    const stp_placed_part* parts, size_t part_count,
                                                    const stp_capture_desc* desc,
                                                    uint64_t ids_per_pass,
                                                    stp_candidates* candidates);
