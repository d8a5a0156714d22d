// SPDX-License-Identifier: MIT
// Inputs and calls of the kernels, for the table in kernels.c.
#pragma once

#include "base/math/rng.h"
#include "lab/kernels/kernels.h"

/// Uniform in [low, high).
static inline float kernel_random(uint64_t seed, uint64_t index, float low, float high)
{
    return low + (high - low) * ((float)(stp_rng_hash(seed, index) >> 40) * 0x1p-24f);
}

/// Random numbers in the case's arena; NULL if out of memory.
static inline float* kernel_random_floats(kernel_case* c, uint64_t seed, size_t count, float low,
                                          float high)
{
    float* out = STP_ARENA_ARRAY(c->arena, float, count);
    for (size_t i = 0; out != NULL && i < count; ++i) {
        out[i] = kernel_random(seed, i, low, high);
    }
    return out;
}

/// Allocates the output. @return false if out of memory
static inline bool kernel_set_output(kernel_case* c, size_t bytes, uint64_t elements)
{
    c->output = stp_arena_alloc(c->arena, bytes);
    c->output_bytes = bytes;
    c->elements = elements;
    return c->output != NULL;
}

// cases_columns.c
bool kernel_make_bytes(kernel_case* c);
void kernel_run_crc32c(kernel_case* c);
bool kernel_make_normals(kernel_case* c);
void kernel_run_octahedral(kernel_case* c);
bool kernel_make_cluster(kernel_case* c);
void kernel_reset_cluster(kernel_case* c);
void kernel_run_cluster(kernel_case* c);

// cases_capture.c
bool kernel_make_fill(kernel_case* c);
void kernel_reset_fill(kernel_case* c);
void kernel_run_fill(kernel_case* c);

// cases_lod.c
bool kernel_make_buckets(kernel_case* c);
void kernel_run_buckets(kernel_case* c);
bool kernel_make_nearest(kernel_case* c);
void kernel_run_nearest(kernel_case* c);
bool kernel_make_disks(kernel_case* c);
void kernel_run_disks(kernel_case* c);
bool kernel_make_squared(kernel_case* c);
void kernel_run_squared(kernel_case* c);
bool kernel_make_sums(kernel_case* c);
void kernel_run_sums(kernel_case* c);
bool kernel_make_planes(kernel_case* c);
void kernel_run_planes(kernel_case* c);
bool kernel_make_growths(kernel_case* c);
void kernel_run_growths(kernel_case* c);

// cases_order.c
bool kernel_make_cells(kernel_case* c);
void kernel_run_cells(kernel_case* c);
bool kernel_make_places(kernel_case* c);
void kernel_run_places(kernel_case* c);
bool kernel_make_fit(kernel_case* c);
void kernel_run_fit(kernel_case* c);
bool kernel_make_insert(kernel_case* c);
void kernel_reset_insert(kernel_case* c);
void kernel_run_insert(kernel_case* c);
void kernel_destroy_tree(kernel_case* c);
bool kernel_make_near_grid(kernel_case* c);
void kernel_run_near_grid(kernel_case* c);
void kernel_destroy_near_grid(kernel_case* c);

// cases_raster.c
bool kernel_make_triangles(kernel_case* c);
void kernel_run_triangles(kernel_case* c);
bool kernel_make_disk_splats(kernel_case* c);
bool kernel_make_square_splats(kernel_case* c);
void kernel_run_splats(kernel_case* c);
bool kernel_make_hidden(kernel_case* c);
void kernel_run_hidden(kernel_case* c);
bool kernel_make_levels(kernel_case* c);
void kernel_run_levels(kernel_case* c);
void kernel_run_split_levels(kernel_case* c);
bool kernel_make_blend(kernel_case* c);
void kernel_reset_blend(kernel_case* c);
void kernel_run_blend(kernel_case* c);

// cases_shade.c
bool kernel_make_merge(kernel_case* c);
void kernel_reset_merge(kernel_case* c);
void kernel_run_merge(kernel_case* c);
bool kernel_make_light(kernel_case* c);
void kernel_reset_light(kernel_case* c);
void kernel_run_light(kernel_case* c);
bool kernel_make_spread(kernel_case* c);
void kernel_run_spread(kernel_case* c);
bool kernel_make_depths(kernel_case* c);
void kernel_run_depths(kernel_case* c);

// cases_effects.c
bool kernel_make_rows(kernel_case* c);
void kernel_reset_rows(kernel_case* c);
void kernel_run_greatest(kernel_case* c);
void kernel_run_gain(kernel_case* c);
void kernel_run_rise(kernel_case* c);
void kernel_run_eye_dome(kernel_case* c);
void kernel_run_pair(kernel_case* c);
void kernel_run_blur(kernel_case* c);
void kernel_run_blocks(kernel_case* c);
bool kernel_make_pixels(kernel_case* c);
void kernel_run_pixels(kernel_case* c);
