// SPDX-License-Identifier: MIT
#include "lab/kernels/kernels.h"

#include "lab/kernels/kernel_cases.h"

#define AVX2 STP_PROCESSOR_AVX2
#define AVX512 STP_PROCESSOR_AVX512

// clang-format off
const kernel kernels[] = {
    {"crc32c", "src/base/io/crc32c", AVX2, "byte", kernel_make_bytes, NULL, kernel_run_crc32c, NULL},
    {"octahedral", "src/base/splats/octahedral", AVX2, "normal", kernel_make_normals, NULL, kernel_run_octahedral, NULL},
    {"clusters-unpack", "src/store/clusters/clusters_unpack", AVX2, "vertex", kernel_make_cluster, kernel_reset_cluster, kernel_run_cluster, NULL},
    {"fill", "src/capture/fill", AVX2, "pixel", kernel_make_fill, kernel_reset_fill, kernel_run_fill, NULL},
    {"grid-buckets", "src/lod/grid", AVX2, "point", kernel_make_buckets, NULL, kernel_run_buckets, NULL},
    {"neighbours-nearest", "src/lod/neighbours", AVX2, "pair", kernel_make_nearest, NULL, kernel_run_nearest, NULL},
    {"neighbours-disk", "src/lod/neighbours", AVX2, "pair", kernel_make_disks, NULL, kernel_run_disks, NULL},
    {"neighbours-squared", "src/lod/neighbours", AVX2, "pair", kernel_make_squared, NULL, kernel_run_squared, NULL},
    {"normals-sum", "src/lod/point_normals", AVX2, "pair", kernel_make_sums, NULL, kernel_run_sums, NULL},
    {"normals-project", "src/lod/point_normals", AVX2, "matrix", kernel_make_planes, NULL, kernel_run_planes, NULL},
    {"growths-cut", "src/lod/blue/growths", AVX2, "pair", kernel_make_growths, NULL, kernel_run_growths, NULL},
    {"curve-cells", "src/order/curve", AVX512, "point", kernel_make_cells, NULL, kernel_run_cells, NULL},
    {"curve-places", "src/order/curve", AVX512, "point", kernel_make_places, NULL, kernel_run_places, NULL},
    {"tree-fit", "src/order/tree", AVX512, "point", kernel_make_fit, NULL, kernel_run_fit, kernel_destroy_tree},
    {"tree-insert", "src/order/tree", AVX512, "insertion", kernel_make_insert, kernel_reset_insert, kernel_run_insert, kernel_destroy_tree},
    {"near-grid", "src/order/near_grid", AVX2, "query", kernel_make_near_grid, NULL, kernel_run_near_grid, kernel_destroy_near_grid},
    {"triangles", "src/raster/triangles", AVX512, "triangle", kernel_make_triangles, NULL, kernel_run_triangles, NULL},
    {"splats", "src/raster/splats", AVX512, "splat", kernel_make_disk_splats, NULL, kernel_run_splats, NULL},
    {"splats-hidden", "src/raster/splats", AVX512, "splat", kernel_make_hidden, NULL, kernel_run_hidden, NULL},
    {"splats-squares", "src/raster/splats_squares", AVX512, "splat", kernel_make_square_splats, NULL, kernel_run_splats, NULL},
    {"splats-levels", "src/raster/splats_levels", AVX512, "splat", kernel_make_levels, NULL, kernel_run_levels, NULL},
    {"splats-split-levels", "src/raster/splats_levels", AVX512, "splat", kernel_make_levels, NULL, kernel_run_split_levels, NULL},
    {"splats-blend", "src/raster/splats_blend", AVX512, "splat", kernel_make_blend, kernel_reset_blend, kernel_run_blend, NULL},
    {"shade-merge", "src/draw/cpu/shade", AVX512, "pixel", kernel_make_merge, kernel_reset_merge, kernel_run_merge, NULL},
    {"shade-light", "src/draw/cpu/shade", AVX512, "lane", kernel_make_light, kernel_reset_light, kernel_run_light, NULL},
    {"shade-spread", "src/draw/cpu/shade", AVX512, "pixel", kernel_make_spread, NULL, kernel_run_spread, NULL},
    {"shade-depths", "src/draw/cpu/shade", AVX512, "pixel", kernel_make_depths, NULL, kernel_run_depths, NULL},
    {"effects-greatest", "src/draw/cpu/effects", AVX512, "pixel", kernel_make_rows, kernel_reset_rows, kernel_run_greatest, NULL},
    {"effects-gain", "src/draw/cpu/effects", AVX512, "pixel", kernel_make_rows, kernel_reset_rows, kernel_run_gain, NULL},
    {"effects-rise", "src/draw/cpu/effects", AVX512, "pixel", kernel_make_rows, kernel_reset_rows, kernel_run_rise, NULL},
    {"effects-eye-dome", "src/draw/cpu/effects", AVX512, "pixel", kernel_make_rows, kernel_reset_rows, kernel_run_eye_dome, NULL},
    {"effects-pair", "src/draw/cpu/effects", AVX512, "pixel", kernel_make_rows, kernel_reset_rows, kernel_run_pair, NULL},
    {"effects-blur", "src/draw/cpu/effects", AVX512, "pixel", kernel_make_rows, kernel_reset_rows, kernel_run_blur, NULL},
    {"effects-spread", "src/draw/cpu/effects", AVX512, "pixel", kernel_make_rows, kernel_reset_rows, kernel_run_blocks, NULL},
    {"pixel-filter", "src/draw/cpu/pixel_filter", AVX512, "pixel", kernel_make_pixels, kernel_reset_rows, kernel_run_pixels, NULL},
    {0},
};
// clang-format on
