// SPDX-License-Identifier: MIT
//
// How a tile of the visibility buffer, 64 x 16 pixels, becomes colours:
//
//   merged     nearest of all workers' pixels, which are cleared, row by row; runs of equal ids
//   looked up  surfaces of runs: one per id, cached between tiles
//   lit        surfaces in lanes: one for up to 16 pixels of a run with a single colour and normal,
//              one per pixel elsewhere; one vector of lanes at a time
//   written    lanes copied to their pixels
//
// Each variant implements merging and lighting (shade_lanes.h). All arithmetic is single IEEE
// operations in a fixed order: all variants give the same bits. A pixel depends only on the tile's
// picture, not on the cache.
#pragma once

#include "draw/cpu/cpu.h"
#include "draw/shading_setup.h"

enum {
    SHADE_WIDTH = 64,           ///< pixels of a tile's row
    SHADE_ROWS = CPU_BAND_ROWS, ///< rows of a tile
    SHADE_PIXELS = SHADE_WIDTH * SHADE_ROWS,
    SHADE_REACH = 16,     ///< maximum pixels of a row lit as one
    SHADE_LANES_MAX = 16, ///< maximum vector width of all variants
    SHADE_LANES = SHADE_PIXELS + SHADE_LANES_MAX,
    SHADE_EMPTY_LANE = SHADE_LANES, ///< first lane of the colour of background pixels
    SHADE_CACHE_BITS = 10,
    SHADE_CACHE = 1 << SHADE_CACHE_BITS,
    SHADE_KEPT = SHADE_CACHE + 2 * SHADE_PIXELS, ///< surfaces of ids: cached, and of two tiles
    SHADE_EMPTY = SHADE_KEPT,                    ///< surface of background pixels
    SHADE_OWN = SHADE_EMPTY + 1,                 ///< first per-pixel surface
    SHADE_SURFACES = SHADE_OWN + SHADE_PIXELS,
};

/// Lighting parameters of a material, computed once per store.
struct stp_cpu_shade_material {
    float metallic;
    float rough;     ///< 0: most polished, 1: not polished
    float a2, gloss; ///< shape and size of the key light's highlight
    float emissive[3];
    float unlit; ///< 1 or 0
};

/// A surface to light: sixteen floats.
typedef struct stp_cpu_shade_surface {
    float color[4]; ///< linear, and opacity
    /// Scene space, any length; zero: none. The fourth is how far the normals of what it stands for
    /// are spread: 1 less the length of their mean; 0: not at all
    float normal[4];
    stp_cpu_shade_material material;
} stp_cpu_shade_surface;

/// True nearness = factor * buffer nearness + shift.
typedef struct stp_cpu_shade_nearness {
    float factor, shift;
} stp_cpu_shade_nearness;

/// Inputs of surfaces, per item.
struct stp_cpu_shade_item {
    float normal_matrix[3][3];
    float blend;
    stp_cpu_shade_nearness nearness;
    uint32_t first_id, count;
    uint32_t low_count; ///< 0: no blending
    uint32_t material;  ///< meshes and points: index in stp_cpu_renderer.shade_materials
    stp_draw_kind kind;
    const uint8_t *colors, *low_colors, *materials;
    const int8_t* normals;
    stp_light_normals lights, low_lights; ///< without turns: the normals
};

/// Light and eye.
typedef struct stp_cpu_shade_scene {
    const uint8_t* encode; ///< three bytes longer than its size
    stp_lighting light;
    /// Towards the eye from (x, y) of a tile: start + across x + down y, not of unit length.
    stp_vec3 start, across, down;
    bool parallel; ///< towards the eye: start
} stp_cpu_shade_scene;

/// Lanes lit together. Padding lanes, up to a whole vector, hold valid surfaces.
typedef struct stp_cpu_shade_lanes {
    uint32_t count;
    bool wants_linear;
    uint32_t surface[SHADE_LANES];
    float x[SHADE_LANES], y[SHADE_LANES]; ///< positions, relative to the tile
    uint32_t bytes[SHADE_LANES + SHADE_WIDTH + SHADE_LANES_MAX];
    float linear[3][SHADE_LANES]; ///< only if requested
} stp_cpu_shade_lanes;

/// A row of a tile. Pixels beyond the picture are empty.
typedef struct stp_cpu_shade_merged {
    uint32_t ids[1 + SHADE_WIDTH]; ///< id of pixel i is at i + 1; UINT32_MAX: none
    float nearness[SHADE_WIDTH + SHADE_LANES_MAX];
    uint64_t there;  ///< covered pixels: bit i is pixel i
    uint64_t starts; ///< first pixel, and those whose id differs from the previous pixel's
} stp_cpu_shade_merged;

/// Pixels of one row.
typedef struct stp_cpu_shade_run {
    uint8_t x, length;      ///< pixels of the tile's row
    uint16_t surface, lane; ///< indices of the surface and of the first lane
    bool flat;              ///< one lane for SHADE_REACH pixels
} stp_cpu_shade_run;

/// @param roughness,metallic 0..1
stp_cpu_shade_material stp_cpu_make_shade_material(float metallic, float roughness,
                                                   const float emissive[3], bool unlit);

typedef struct stp_cpu_shade_kernels {
    /// Takes the minimum of `count` buffers at `at` and clears them there. `copy`, unless NULL,
    /// receives it.
    void (*merge)(uint64_t* const* buffers, uint32_t count, size_t at, uint32_t size,
                  uint64_t* copy, stp_cpu_shade_merged* row);
    void (*light)(const stp_cpu_shade_scene* scene, const stp_cpu_shade_surface* surfaces,
                  stp_cpu_shade_lanes* lanes);
    /// Writes colours and true nearness of runs, up to SHADE_LANES_MAX - 1 pixels past the end.
    void (*spread)(const stp_cpu_shade_run* run, const stp_cpu_shade_run* end,
                   const stp_cpu_shade_nearness* surfaces, const uint32_t* lanes,
                   const float* nearness, uint8_t* colors, float* depth);
    /// Writes the nearness of the minimum of `count` buffers for `size` pixels at `at`; 0: empty.
    void (*find_depths)(uint64_t* const* buffers, uint32_t count, size_t at, size_t size,
                        float* depth);
} stp_cpu_shade_kernels;

extern const stp_cpu_shade_kernels stp_cpu_shade_kernels_portable, stp_cpu_shade_kernels_vector,
    stp_cpu_shade_kernels_wide;
const stp_cpu_shade_kernels* stp_cpu_choose_shade_kernels(void);

/// Variation among the pixels of an id.
typedef enum stp_cpu_shade_kind {
    SHADE_FLAT,     ///< not at all
    SHADE_SMOOTH,   ///< triangles with a varying normal or colour
    SHADE_TEXTURED, ///< triangles with textures
} stp_cpu_shade_kind;

typedef struct stp_cpu_shade_tile {
    uint32_t x, y, width, height;
    uint32_t number; ///< counts tiles
    bool any;        ///< has covered pixels
    stp_cpu_shade_merged rows[SHADE_ROWS];
    uint32_t row_runs[SHADE_ROWS + 1]; ///< first run of each row, then the number of runs
    stp_cpu_shade_run runs[SHADE_PIXELS];
    uint32_t extra;      ///< next tile-local slot
    uint32_t miss_count; ///< surfaces allocated, but not filled yet
    uint16_t misses[SHADE_PIXELS];
} stp_cpu_shade_tile;

typedef struct stp_cpu_triangle_memory stp_cpu_triangle_memory;

/// Surface cache of a worker, and its tiles: data of a tile is prefetched while the previous tile
/// is lit.
struct stp_cpu_shade_memory {
    stp_cpu_shade_surface* surfaces; ///< SHADE_SURFACES, one cache line each
    unsigned char* room;             ///< memory of the surfaces
    struct {
        uint32_t id;   ///< UINT32_MAX: none
        uint32_t tile; ///< tile of its last use
    } slots[SHADE_KEPT];
    uint32_t item[SHADE_KEPT];
    uint32_t cluster[SHADE_KEPT]; ///< triangles: index of the cluster
    stp_cpu_shade_nearness nearness[SHADE_KEPT + 1];
    uint8_t kind[SHADE_KEPT + 1];
    uint8_t splats[SHADE_KEPT + 1]; ///< 1 for surfaces of splats
    uint32_t tile_count;
    uint32_t last_item;
    stp_cpu_shade_tile tiles[2];
    stp_cpu_shade_lanes lanes;
    stp_cpu_triangle_memory* triangles;
};

/// NULL if out of memory.
stp_cpu_shade_memory* stp_cpu_make_shade_memory(stp_context* context);
void stp_cpu_destroy_shade_memory(stp_context* context, stp_cpu_shade_memory* memory);
void stp_cpu_reset_surfaces(stp_cpu_shade_memory* memory);
/// NULL if out of memory. Free it with stp_free.
stp_cpu_triangle_memory* stp_cpu_make_triangle_memory(stp_context* context);
void stp_cpu_reset_triangles(stp_cpu_triangle_memory* memory);

/// Index of the item that `id` belongs to.
uint32_t stp_cpu_find_item(const stp_cpu_renderer* r, uint32_t id);

/// Starts the next tile: slots of the tile before the previous one may be reused.
stp_cpu_shade_tile* stp_cpu_begin_tile(stp_cpu_shade_memory* memory);
/// Surface of an id, which may not be filled yet.
uint32_t stp_cpu_find_surface(stp_cpu_shade_memory* memory, stp_cpu_shade_tile* tile, uint32_t id);
/// Prefetches the data of a tile's unfilled surfaces.
void stp_cpu_prefetch_surfaces(const stp_cpu_renderer* r, stp_cpu_shade_memory* memory,
                               const stp_cpu_shade_tile* tile);
/// Fills a tile's unfilled surfaces.
void stp_cpu_make_surfaces(const stp_cpu_renderer* r, stp_cpu_shade_memory* memory,
                           stp_cpu_shade_tile* tile);

/// The surface of a splat or point, by its item and its index there.
void stp_cpu_make_splat_surface(const stp_cpu_renderer* r, uint32_t slot, uint32_t index,
                                stp_cpu_shade_surface* surface);
/// Direction to the eye from a place in the picture, of any length.
stp_vec3 stp_cpu_toward_eye(const stp_cpu_renderer* r, double x, double y);
/// Light and eye for places in the whole picture.
stp_cpu_shade_scene stp_cpu_make_shade_scene(const stp_cpu_renderer* r);

void stp_cpu_prefetch_triangle(const stp_cpu_renderer* r, stp_cpu_shade_memory* memory,
                               uint32_t at);
/// Fills surface `at` of a prefetched triangle, and its cached data.
stp_cpu_shade_kind stp_cpu_make_triangle_surface(const stp_cpu_renderer* r,
                                                 stp_cpu_shade_memory* memory, uint32_t at);
/// Makes per-pixel surfaces, from `out`, for a run of a triangle that is not flat; (x, y) is its
/// first pixel in the picture, `nearness` is from the buffer.
void stp_cpu_make_pixel_surfaces(const stp_cpu_renderer* r, stp_cpu_shade_memory* memory,
                                 const stp_cpu_shade_run* run, uint32_t x, uint32_t y,
                                 const float* nearness, stp_cpu_shade_surface* out);
