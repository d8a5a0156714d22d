// SPDX-License-Identifier: MIT
//
// How a row of the visibility buffer becomes colours: in chunks of 64 pixels, each of which is
//
//   merged     the nearest of all workers' pixels, which are left empty
//   looked up  what each pixel shows: codes of surfels, or the colour and normal of a triangle or point
//   lit        decoded, turned, lit and encoded, a vector of pixels at a time
//
// Merging and lighting are the variants' (shade_lanes.h). All arithmetic is single IEEE operations in the order of
// cpu_light_surface: all variants give the same bits, and the same as pixels lit one by one.
#pragma once

#include "draw/cpu/cpu.h"

enum { SHADE_CHUNK = 64 };

/// What lighting needs of an item, and what its surfels' codes are.
struct cpu_shade_item {
    float normal_matrix[9]; ///< first, as floats: gathered
    float blend;
    uint32_t first_id, count;
    uint32_t low_count; ///< 0 where nothing is blended
    uint32_t material;  ///< of meshes and points
    stp_draw_kind kind;
    const uint8_t *colors, *low_colors, *materials;
    const int8_t* normals;
    uint8_t unused[128 - 15 * 4 - 4 - 4 * sizeof(void*)]; ///< two lines of the cache
};

/// What light needs of a material, worked out once a store. Gathered: eight floats.
struct cpu_shade_material {
    float metallic, kept, a2, gloss, emissive[3];
    float unlit; ///< 1 or 0
};

/// What all pixels of a row have in common.
typedef struct cpu_shade_row {
    const cpu_shade_item* items;
    const cpu_shade_material* materials;
    const float* decode;
    const uint8_t* encode; ///< three bytes longer than its size
    cpu_light light;
    stp_vec3 start,
        step;       ///< towards the eye from pixel x: start + step (x + 0.5), not of unit length
    bool parallel;  ///< towards the eye: start
    uint32_t empty; ///< colour of pixels that show nothing
} cpu_shade_row;

/// Pixels of a row. Lanes that show nothing hold whatever they hold, but valid indices.
typedef struct cpu_shade_chunk {
    uint64_t pixels[SHADE_CHUNK];
    int32_t there[SHADE_CHUNK]; ///< -1: shows something
    int32_t coded[SHADE_CHUNK]; ///< -1: colour and normal are codes
    int32_t item[SHADE_CHUNK], material[SHADE_CHUNK];
    int32_t color[SHADE_CHUNK], low[SHADE_CHUNK]; ///< sRGB bytes
    int32_t code[SHADE_CHUNK];                    ///< octahedral normal: two bytes
    float blend[SHADE_CHUNK];
    float linear[3][SHADE_CHUNK], normal[3][SHADE_CHUNK];
    bool has_codes, has_low;
    float out[3][SHADE_CHUNK]; ///< linear light
    uint32_t bytes[SHADE_CHUNK];
} cpu_shade_chunk;

typedef struct cpu_shade_kernels {
    /// Takes the least of `count` buffers at `at`, empties them there, and writes how near pixels are.
    /// @return whether any pixel shows anything
    bool (*merge)(uint64_t* const* buffers, uint32_t count, size_t at, uint32_t size,
                  uint64_t* pixels, float* depth);
    /// Lights pixels x .. x + size - 1 of a row.
    void (*light)(const cpu_shade_row* row, cpu_shade_chunk* chunk, uint32_t x, uint32_t size);
} cpu_shade_kernels;

extern const cpu_shade_kernels cpu_shade_kernels_portable, cpu_shade_kernels_avx2,
    cpu_shade_kernels_avx512;
const cpu_shade_kernels* cpu_choose_shade_kernels(void);

/// Triangles shaded lately; stp_free. NULL where memory runs out.
cpu_mesh_memory* cpu_make_mesh_memory(stp_context* context);
void cpu_forget_triangles(cpu_mesh_memory* memory);

/// The place in the frame's items of what `id` belongs to.
uint32_t cpu_find_item(const cpu_renderer* r, uint32_t id);

/// Looks up a triangle's pixel. @return false where its material needs more than the chunk holds: then `out` is
/// its colour
bool cpu_look_up_triangle(const cpu_renderer* r, cpu_worker* worker, const cpu_shade_row* row,
                          cpu_shade_chunk* chunk, uint32_t lane, uint32_t x, uint32_t y,
                          float out[3]);
