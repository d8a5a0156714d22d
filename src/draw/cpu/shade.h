// SPDX-License-Identifier: MIT
//
// How a tile of the visibility buffer, 64 x 16 pixels, becomes colours:
//
//   merged     the nearest of all workers' pixels, which are left empty, row by row; where ids change, a run begins
//   looked up  what runs show: one surface an id, remembered from tile to tile
//   lit        surfaces in lanes: one for up to 16 pixels of a run whose colour and normal are the same all over,
//              one a pixel elsewhere; a vector of lanes at a time
//   written    lanes spread over their pixels
//
// Merging and lighting are the variants' (shade_lanes.h). All arithmetic is single IEEE operations in a fixed order: all
// variants give the same bits. What a pixel gets depends on the tile's picture alone, not on what is remembered.
#pragma once

#include "draw/cpu/cpu.h"
#include "draw/lighting.h"

enum {
    SHADE_WIDTH = 64,           ///< pixels of a tile's row
    SHADE_ROWS = CPU_BAND_ROWS, ///< of a tile
    SHADE_PIXELS = SHADE_WIDTH * SHADE_ROWS,
    SHADE_REACH = 16,      ///< pixels of a row that are lit as one, at most
    SHADE_LANES_MOST = 16, ///< of any variant's vectors
    SHADE_LANES = SHADE_PIXELS + SHADE_LANES_MOST,
    SHADE_EMPTY_LANE = SHADE_LANES, ///< pixels that show nothing have their colour from here on
    SHADE_CACHE_BITS = 10,
    SHADE_CACHE = 1 << SHADE_CACHE_BITS,
    SHADE_KEPT = SHADE_CACHE + 2 * SHADE_PIXELS, ///< surfaces of ids: remembered, and of two tiles
    SHADE_EMPTY = SHADE_KEPT,                    ///< the surface of pixels that show nothing
    SHADE_OWN = SHADE_EMPTY + 1,                 ///< first of the pixels' own surfaces
    SHADE_SURFACES = SHADE_OWN + SHADE_PIXELS,
};

/// What light needs of a material, worked out once a store.
struct cpu_shade_material {
    float metallic;
    float rough;     ///< 0: as polished as anything is drawn, 1: not at all
    float a2, gloss; ///< shape and size of the key light's highlight
    float emissive[3];
    float unlit; ///< 1 or 0
};

/// What light falls on: sixteen floats, of which those that are the fourth of four are not looked at.
typedef struct cpu_shade_surface {
    float color[4];  ///< linear, and opacity
    float normal[4]; ///< scene space, of any length; zero: none
    cpu_shade_material material;
} cpu_shade_surface;

/// Nearness = factor * that of the buffer + shift: cpu_true_nearness.
typedef struct cpu_shade_nearness {
    float factor, shift;
} cpu_shade_nearness;

/// What surfaces are made of, for each item.
struct cpu_shade_item {
    float normal_matrix[3][3];
    float blend;
    cpu_shade_nearness nearness;
    uint32_t first_id, count;
    uint32_t low_count; ///< 0 where nothing is blended
    uint32_t material;  ///< of meshes and points
    stp_draw_kind kind;
    const uint8_t *colors, *low_colors, *materials;
    const int8_t* normals;
};

/// Light, and where it is seen from.
typedef struct cpu_shade_scene {
    const uint8_t* encode; ///< three bytes longer than its size
    stp_lighting light;
    /// Towards the eye from (x, y) of a tile: start + across x + down y, not of unit length.
    stp_vec3 start, across, down;
    bool parallel; ///< towards the eye: start
} cpu_shade_scene;

/// What is lit at once. Lanes beyond the last, up to a whole vector, hold valid surfaces.
typedef struct cpu_shade_lanes {
    uint32_t count;
    bool wants_linear;
    uint32_t surface[SHADE_LANES];
    float x[SHADE_LANES], y[SHADE_LANES]; ///< of the tile
    uint32_t bytes[SHADE_LANES + SHADE_WIDTH + SHADE_LANES_MOST];
    float linear[3][SHADE_LANES]; ///< only where wanted
} cpu_shade_lanes;

/// A row of a tile. Pixels beyond the picture are empty.
typedef struct cpu_shade_merged {
    uint32_t ids[1 + SHADE_WIDTH]; ///< from the second on; UINT32_MAX: none
    float nearness[SHADE_WIDTH + SHADE_LANES_MOST];
    uint64_t there;  ///< pixels that show something: bit i is pixel i
    uint64_t starts; ///< pixels whose id is not that of the pixel before
} cpu_shade_merged;

/// Pixels of one row.
typedef struct cpu_shade_run {
    uint8_t x, length;      ///< of the tile
    uint16_t surface, lane; ///< the first lane
    bool flat;              ///< one lane for SHADE_REACH pixels
} cpu_shade_run;

/// @param roughness,metallic 0..1
cpu_shade_material cpu_make_shade_material(float metallic, float roughness, const float emissive[3],
                                           bool unlit);

typedef struct cpu_shade_kernels {
    /// Takes the least of `count` buffers at `at` and empties them there.
    void (*merge)(uint64_t* const* buffers, uint32_t count, size_t at, uint32_t size,
                  cpu_shade_merged* row);
    void (*light)(const cpu_shade_scene* scene, const cpu_shade_surface* surfaces,
                  cpu_shade_lanes* lanes);
    /// Writes colours and true nearness of runs, up to SHADE_LANES_MOST - 1 pixels more than there are.
    void (*spread)(const cpu_shade_run* run, const cpu_shade_run* end,
                   const cpu_shade_nearness* surfaces, const uint32_t* lanes, const float* nearness,
                   uint8_t* colors, float* depth);
} cpu_shade_kernels;

extern const cpu_shade_kernels cpu_shade_kernels_portable, cpu_shade_kernels_avx2,
    cpu_shade_kernels_avx512;
const cpu_shade_kernels* cpu_choose_shade_kernels(void);

/// How the pixels of an id differ.
typedef enum cpu_shade_kind {
    SHADE_FLAT,     ///< not at all
    SHADE_SMOOTH,   ///< triangles whose normal or colour is not the same everywhere
    SHADE_TEXTURED, ///< triangles with textures
} cpu_shade_kind;

typedef struct cpu_shade_tile {
    uint32_t x, y, width, height;
    uint32_t number; ///< counts tiles
    bool any;        ///< shows something
    cpu_shade_merged rows[SHADE_ROWS];
    uint32_t row_runs[SHADE_ROWS + 1]; ///< of each row, the first
    cpu_shade_run runs[SHADE_PIXELS];
    uint32_t extra;      ///< the next place of this tile alone
    uint32_t miss_count; ///< surfaces found, but not made yet
    uint16_t misses[SHADE_PIXELS];
} cpu_shade_tile;

typedef struct cpu_triangle_memory cpu_triangle_memory;

/// What a worker remembers, and its tiles: what one needs is asked of memory while the one before is lit.
struct cpu_shade_memory {
    cpu_shade_surface* surfaces; ///< SHADE_SURFACES, each in a line of the cache
    unsigned char* room;         ///< that they lie in
    struct {
        uint32_t id;   ///< UINT32_MAX: none
        uint32_t tile; ///< that it was wanted in last
    } slots[SHADE_KEPT];
    uint32_t item[SHADE_KEPT];
    uint32_t cluster[SHADE_KEPT]; ///< of triangles
    cpu_shade_nearness nearness[SHADE_KEPT + 1];
    uint8_t kind[SHADE_KEPT + 1];
    uint32_t tile_count;
    uint32_t last_item;
    cpu_shade_tile tiles[2];
    cpu_shade_lanes lanes;
    cpu_triangle_memory* triangles;
};

/// NULL where memory runs out.
cpu_shade_memory* cpu_make_shade_memory(stp_context* context);
void cpu_destroy_shade_memory(stp_context* context, cpu_shade_memory* memory);
void cpu_forget_surfaces(cpu_shade_memory* memory);
/// stp_free. NULL where memory runs out.
cpu_triangle_memory* cpu_make_triangle_memory(stp_context* context);
void cpu_forget_triangles(cpu_triangle_memory* memory);

/// The place in the frame's items of what `id` belongs to.
uint32_t cpu_find_item(const cpu_renderer* r, uint32_t id);

/// The next tile: places of the last but one may be taken from now on.
cpu_shade_tile* cpu_begin_tile(cpu_shade_memory* memory);
/// The surface of an id, which may have to be made yet.
uint32_t cpu_find_surface(cpu_shade_memory* memory, cpu_shade_tile* tile, uint32_t id);
/// Asks for what those surfaces of a tile are made of that are not made yet.
void cpu_ask_surfaces(const cpu_renderer* r, cpu_shade_memory* memory, const cpu_shade_tile* tile);
/// Makes them.
void cpu_make_surfaces(const cpu_renderer* r, cpu_shade_memory* memory, cpu_shade_tile* tile);

/// The surface of a surfel or point, by its item and its index there.
void cpu_make_splat_surface(const cpu_renderer* r, uint32_t slot, uint32_t index,
                            cpu_shade_surface* surface);
/// Light and eye for places in the whole picture.
cpu_shade_scene cpu_make_shade_scene(const cpu_renderer* r);

void cpu_ask_triangle(const cpu_renderer* r, cpu_shade_memory* memory, uint32_t at);
/// Makes surface `at` of a triangle that was asked for, and what is remembered beside it.
cpu_shade_kind cpu_make_triangle_surface(const cpu_renderer* r, cpu_shade_memory* memory,
                                         uint32_t at);
/// Makes surfaces of pixels' own, from `out` on, of a run of a triangle that is not flat; (x, y) is its first pixel in the
/// picture, `nearness` what the buffer says.
void cpu_make_pixel_surfaces(const cpu_renderer* r, cpu_shade_memory* memory,
                             const cpu_shade_run* run, uint32_t x, uint32_t y,
                             const float* nearness, cpu_shade_surface* out);
