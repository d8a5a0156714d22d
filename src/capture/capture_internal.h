// SPDX-License-Identifier: MIT
// How a capture runs: views are cut into bands of rows; each band is drawn into a visibility buffer
// and squeezed to its covered pixels; then all of these become candidates.
#pragma once

#include "capture/capture.h"
#include "raster/target.h"
#include "raster/texture.h"

#include <stdatomic.h>

enum {
    STP_CAPTURE_DIRECTIONS = 8,
    STP_CAPTURE_RESOLUTION_LEAST = 4,
    STP_CAPTURE_RESOLUTION_MOST = 16384,
};

struct stp_capture_textures {
    const stp_scene* scene;
    stp_texture_pyramid* pyramids; ///< one a texture; without levels where it is not needed
};

/// A parallel projection, in pixels: x = right . p + shift_x, y = down . p + shift_y.
typedef struct stp_capture_view {
    stp_vec3d toward;      ///< unit, towards the viewer
    stp_vec3d right, down; ///< unit over pixel size
    double shift_x, shift_y;
    stp_vec3d depth; ///< nearness = depth . p + 1.5, between 1.1 and 1.9
    uint32_t width, height;
    uint32_t* silhouette; ///< a bit a pixel (silhouettes.h), or NULL
} stp_capture_view;

/// Rows of a view, and the covered pixels found there.
typedef struct stp_capture_band {
    uint32_t view, row_begin, row_end;
    uint32_t count;
    uint32_t* pixels;     ///< row * width + column, ascending
    uint64_t* primitives; ///< what covers each: a triangle or point, numbered through all parts
} stp_capture_band;

struct stp_fill_map;

/// What all steps read.
typedef struct stp_capture_job {
    const stp_scene* scene;
    const stp_placed_part* parts;
    size_t part_count;
    uint64_t* first_primitives; ///< of each part, and the count of all
    stp_box* boxes; ///< of each part, own space: side by side, as each view looks at all of them
    const stp_placed_set* sets;
    size_t set_count;
    uint64_t* first_surfels; ///< of each set, and the count of all; primitives after those of parts
    stp_boxd* set_boxes;     ///< of each set's disks, in the captured space
    _Atomic uint32_t* seen;  ///< a bit a surfel
    stp_vec3d centre, half_extent;
    const stp_texture_pyramid* pyramids; ///< by texture
    uint64_t
        ids_a_pass; ///< primitives drawn into one buffer: ids are 32-bit numbers below 2^32 - 1
    uint32_t view_count;
    stp_capture_view* views;
    size_t band_count;
    stp_capture_band* bands;
    uint64_t covered_pixels;
    bool keeps_silhouettes;               ///< of the first views
    uint64_t room;                        ///< candidates that the columns have room for
    const struct stp_fill_map* stand_ins; ///< pixels that it knows are not kept; NULL: all are
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
    return stp_capture_part_primitives(job) + job->first_surfels[job->set_count];
}

/// Sets up the views: `directions` at a common pixel size.
void stp_capture_set_views(stp_capture_job* job, const stp_vec3d* directions, uint32_t count,
                           double pixel_size);

/// The longer side of the widest view, in scene units; `area`: of all views together.
double stp_capture_widest(const stp_capture_job* job, const stp_vec3d* directions, uint32_t count,
                          double* area);

/// Draws parts [begin, end) into a buffer of the band's rows; ids count from the first one's first primitive.
/// @return STP_OK or STP_ERROR_OUT_OF_MEMORY (not logged)
STP_MUST_USE stp_result stp_capture_draw_parts(const stp_capture_job* job,
                                               const stp_capture_band* band, size_t begin,
                                               size_t end, const stp_raster_target* target,
                                               stp_arena* scratch);

// Sets of surfels (splats.c): what they add to each step.

/// Numbers the surfels, and adds their disks to the box. @return STP_OK or STP_ERROR_OUT_OF_MEMORY (logged)
STP_MUST_USE stp_result stp_capture_prepare_sets(stp_capture_job* job, stp_boxd* box);
void stp_capture_drop_sets(stp_capture_job* job);

/// Draws the disks of sets [begin, end) into a buffer of the band's rows; ids count from `first_id`.
/// @return STP_OK or STP_ERROR_OUT_OF_MEMORY (not logged)
STP_MUST_USE stp_result stp_capture_draw_sets(const stp_capture_job* job,
                                              const stp_capture_band* band, size_t begin,
                                              size_t end, uint32_t first_id,
                                              const stp_raster_target* target, stp_arena* scratch);

/// Marks the surfels that are visible in a band's finished buffer, and empties their pixels. `primitives`: of each
/// pixel, where ids are not.
void stp_capture_take_surfels(const stp_capture_job* job, const stp_capture_band* band,
                              const stp_raster_target* target, const uint64_t* primitives);

uint64_t stp_capture_seen_count(const stp_capture_job* job);

/// Writes the surfels seen behind the candidates there are; the columns have room for all.
/// @return STP_OK or STP_ERROR_OUT_OF_MEMORY (logged)
STP_MUST_USE stp_result stp_capture_resolve_sets(const stp_capture_job* job,
                                                 stp_candidates* candidates);

/// Draws views [begin, end): adds to job->bands and covered_pixels. Where it fails, there are no bands.
STP_MUST_USE stp_result stp_capture_draw(stp_capture_job* job, uint32_t begin, uint32_t end);
void stp_capture_drop_bands(stp_capture_job* job);

/// Columns with room for so many more candidates, and for `spare` ones where they have to grow.
/// @return STP_OK, STP_ERROR_OUT_OF_MEMORY or STP_ERROR_LIMIT (logged)
STP_MUST_USE stp_result stp_capture_make_room(stp_capture_job* job, uint64_t more, uint64_t spare,
                                              stp_candidates* candidates);

/// Turns the covered pixels of all bands into candidates behind those that are there, and empties the bands.
/// @return STP_OK, STP_ERROR_OUT_OF_MEMORY or STP_ERROR_LIMIT (logged)
STP_MUST_USE stp_result stp_capture_append(stp_capture_job* job, uint64_t spare,
                                           stp_candidates* candidates);

/// Turns the covered pixels of all bands into candidates from `first` on; the columns have room for all.
void stp_capture_resolve(const stp_capture_job* job, stp_candidates* candidates, size_t first);

/// The alpha of a material at a point of a triangle, read at full resolution.
float stp_capture_alpha(const stp_material* material, const stp_texture_pyramid* level0,
                        const stp_mesh* mesh, uint32_t triangle, float weight1, float weight2);

/// Where a use of a texture reads it, at a point of a triangle; false where the mesh has no
/// coordinates.
bool stp_capture_texcoord(const stp_mesh* mesh, const stp_texture_use* use, uint32_t vertex,
                          double uv[2]);

/// A material's base colour texture without smaller levels; without any where the material has none.
stp_texture_pyramid stp_capture_level0(const stp_scene* scene, const stp_material* material);

STP_MUST_USE stp_result stp_capture_textures_create_empty(const stp_scene* scene,
                                                          stp_capture_textures** textures);
/// Makes the levels of a material's base colour, where they are not there yet.
STP_MUST_USE stp_result stp_capture_textures_add(stp_capture_textures* textures,
                                                 const stp_material* material);

/// stp_capture_all and stp_capture_parts with fewer primitives a pass, for tests.
STP_MUST_USE stp_result stp_capture_all_in_passes(const stp_scene* scene,
                                                  const stp_capture_sources* sources,
                                                  const stp_capture_desc* desc, uint64_t ids_a_pass,
                                                  stp_candidates* candidates);
STP_MUST_USE stp_result stp_capture_parts_in_passes(const stp_scene* scene,
                                                    const stp_placed_part* parts, size_t part_count,
                                                    const stp_capture_desc* desc,
                                                    uint64_t ids_a_pass,
                                                    stp_candidates* candidates);
