// SPDX-License-Identifier: MIT
#include "lab/kernels/kernels.h"

#include "lab/kernels/kernel_cases.h"

#define VECTOR STP_PROCESSOR_VECTOR
#define WIDE STP_PROCESSOR_WIDE

// clang-format off
const kernel kernels[] = {
    {"crc32c", "src/base/io/crc32c", VECTOR, "byte", kernel_make_bytes, NULL, kernel_run_crc32c, NULL},
    {"octahedral", "src/base/splats/octahedral", VECTOR, "normal", kernel_make_normals, NULL, kernel_run_octahedral, NULL},
    {"clusters-unpack", "src/store/clusters/clusters_unpack", VECTOR, "vertex", kernel_make_cluster, kernel_reset_cluster, kernel_run_cluster, NULL},
    {"fill", "src/capture/fill", VECTOR, "pixel", kernel_make_fill, kernel_reset_fill, kernel_run_fill, NULL},
    {"grid-buckets", "src/lod/grid", VECTOR, "point", kernel_make_buckets, NULL, kernel_run_buckets, NULL},
    {"neighbours-nearest", "src/lod/neighbours", VECTOR, "pair", kernel_make_nearest, NULL, kernel_run_nearest, NULL},
    {"neighbours-disk", "src/lod/neighbours", VECTOR, "pair", kernel_make_disks, NULL, kernel_run_disks, NULL},
    {"neighbours-squared", "src/lod/neighbours", VECTOR, "pair", kernel_make_squared, NULL, kernel_run_squared, NULL},
    {"normals-sum", "src/lod/point_normals", VECTOR, "pair", kernel_make_sums, NULL, kernel_run_sums, NULL},
    {"normals-project", "src/lod/point_normals", VECTOR, "matrix", kernel_make_planes, NULL, kernel_run_planes, NULL},
    {"growths-cut", "src/lod/blue/growths", VECTOR, "pair", kernel_make_growths, NULL, kernel_run_growths, NULL},
    {"curve-cells", "src/order/curve", WIDE, "point", kernel_make_cells, NULL, kernel_run_cells, NULL},
    {"curve-places", "src/order/curve", WIDE, "point", kernel_make_places, NULL, kernel_run_places, NULL},
    {"tree-fit", "src/order/tree", WIDE, "point", kernel_make_fit, NULL, kernel_run_fit, kernel_destroy_tree},
    {"tree-insert", "src/order/tree", WIDE, "insertion", kernel_make_insert, kernel_reset_insert, kernel_run_insert, kernel_destroy_tree},
    {"near-grid", "src/order/near_grid", VECTOR, "query", kernel_make_near_grid, NULL, kernel_run_near_grid, kernel_destroy_near_grid},
    {"triangles", "src/raster/triangles", WIDE, "triangle", kernel_make_triangles, NULL, kernel_run_triangles, NULL},
    {"splats", "src/raster/splats", WIDE, "splat", kernel_make_disk_splats, NULL, kernel_run_splats, NULL},
    {"splats-hidden", "src/raster/splats", WIDE, "splat", kernel_make_hidden, NULL, kernel_run_hidden, NULL},
    {"splats-squares", "src/raster/splats_squares", WIDE, "splat", kernel_make_square_splats, NULL, kernel_run_splats, NULL},
    {"splats-levels", "src/raster/splats_levels", WIDE, "splat", kernel_make_levels, NULL, kernel_run_levels, NULL},
    {"splats-split-levels", "src/raster/splats_levels", WIDE, "splat", kernel_make_levels, NULL, kernel_run_split_levels, NULL},
    {"splats-blend", "src/raster/splats_blend", WIDE, "splat", kernel_make_blend, kernel_reset_blend, kernel_run_blend, NULL},
    {"shade-merge", "src/draw/cpu/shade", WIDE, "pixel", kernel_make_merge, kernel_reset_merge, kernel_run_merge, NULL},
    {"shade-light", "src/draw/cpu/shade", WIDE, "lane", kernel_make_light, kernel_reset_light, kernel_run_light, NULL},
    {"shade-spread", "src/draw/cpu/shade", WIDE, "pixel", kernel_make_spread, NULL, kernel_run_spread, NULL},
    {"shade-depths", "src/draw/cpu/shade", WIDE, "pixel", kernel_make_depths, NULL, kernel_run_depths, NULL},
    {"effects-greatest", "src/draw/cpu/effects", WIDE, "pixel", kernel_make_rows, kernel_reset_rows, kernel_run_greatest, NULL},
    {"effects-gain", "src/draw/cpu/effects", WIDE, "pixel", kernel_make_rows, kernel_reset_rows, kernel_run_gain, NULL},
    {"effects-rise", "src/draw/cpu/effects", WIDE, "pixel", kernel_make_rows, kernel_reset_rows, kernel_run_rise, NULL},
    {"effects-eye-dome", "src/draw/cpu/effects", WIDE, "pixel", kernel_make_rows, kernel_reset_rows, kernel_run_eye_dome, NULL},
    {"effects-pair", "src/draw/cpu/effects", WIDE, "pixel", kernel_make_rows, kernel_reset_rows, kernel_run_pair, NULL},
    {"effects-blur", "src/draw/cpu/effects", WIDE, "pixel", kernel_make_rows, kernel_reset_rows, kernel_run_blur, NULL},
    {"effects-spread", "src/draw/cpu/effects", WIDE, "pixel", kernel_make_rows, kernel_reset_rows, kernel_run_blocks, NULL},
    {"pixel-filter", "src/draw/cpu/pixel_filter", WIDE, "pixel", kernel_make_pixels, kernel_reset_rows, kernel_run_pixels, NULL},
    {0},
};
// clang-format on
