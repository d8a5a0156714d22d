// SPDX-License-Identifier: MIT
// Pajarola. Efficient Level-of-Details for Point Based Rendering. 2003: the points of an octree's
// cell become one ellipse.
#include "base/core/jobs.h"
#include "base/splats/coverage.h"
#include "lab/decimate/octree_cells.h"
#include "lab/decimate/point_disks.h"

#include <assert.h>

enum { GRAIN = 32 };

typedef struct ellipse_maker {
    const stp_octree_cells* tree;
    stp_decimate_output* output;
    float minimum; ///< minimum length of an axis
} ellipse_maker;

/// Sums over the disks of a cell, weighted by area.
typedef struct cell_sums {
    double weight;
    stp_vec3d center; ///< relative to the first disk
    stp_vec3d normal;
    stp_color_mean color;
} cell_sums;

static void add_disk(const ellipse_maker* m, const stp_octree_cell* cell, uint32_t place,
                     cell_sums* sums)
{
    uint32_t point = m->tree->order[place];
    const stp_decimate_input* input = m->tree->input;
    const stp_ellipse* disk = &m->tree->disks[point];
    const stp_ellipse* first = &m->tree->disks[m->tree->order[cell->begin]];
    double area = (double)stp_ellipse_area(disk);
    stp_vec3d d = stp_subd(stp_to_double(disk->center), stp_to_double(first->center));
    sums->center = stp_addd(sums->center, stp_scaled(d, area));
    // without normals the outside is unknown: face like the first disk
    bool turned = input->normals == NULL && stp_dot(disk->normal, first->normal) < 0.0f;
    sums->normal =
        stp_addd(sums->normal, stp_scaled(stp_to_double(disk->normal), turned ? -area : area));
    sums->weight += area;
    stp_color_mean_add(&sums->color, input, point, area);
}

/// Ellipse that covers the disks of a cell. Its axes are those of the disks' scatter in its plane.
static stp_ellipse cover_cell(const ellipse_maker* m, const stp_octree_cell* cell,
                              const cell_sums* sums)
{
    const stp_octree_cells* t = m->tree;
    const stp_ellipse* first = &t->disks[t->order[cell->begin]];
    double share = sums->weight > 0.0 ? 1.0 / sums->weight : 0.0, xx = 0.0, xy = 0.0, yy = 0.0;
    stp_vec3 center = stp_add(first->center, stp_to_float(stp_scaled(sums->center, share)));
    stp_vec3 normal = stp_to_float(stp_normalized(sums->normal));
    normal = stp_dot(normal, normal) > 0.0f ? normal : first->normal;
    stp_disk_axes axes = stp_disk_axes_across(normal);
    for (uint32_t i = cell->begin; i < cell->end; ++i) {
        const stp_ellipse* disk = &t->disks[t->order[i]];
        double area = (double)stp_ellipse_area(disk), radius = (double)disk->minor;
        stp_vec3 d = stp_sub(disk->center, center);
        double u = (double)stp_dot(d, axes.x), v = (double)stp_dot(d, axes.y);
        double nu = (double)stp_dot(disk->normal, axes.x),
               nv = (double)stp_dot(disk->normal, axes.y);
        // variance of a disk about its centre: a quarter of the radius squared, in its plane
        double own = 0.25 * radius * radius;
        xx += area * (u * u + own * (1.0 - nu * nu));
        xy += area * (u * v - own * nu * nv);
        yy += area * (v * v + own * (1.0 - nv * nv));
    }
    // relative to the centre: far from the origin, float precision may be coarser than disks
    stp_ellipse_fit fit = stp_ellipse_fit_begin((stp_vec3){0}, normal);
    fit.xx = xx;
    fit.xy = xy;
    fit.yy = yy;
    stp_ellipse_fit_orient(&fit, m->minimum);
    for (uint32_t i = cell->begin; i < cell->end; ++i) {
        stp_vec3 samples[STP_ELLIPSE_SAMPLES];
        stp_ellipse disk = t->disks[t->order[i]];
        disk.center = stp_sub(disk.center, center);
        stp_ellipse_sample(&disk, samples);
        for (int s = 0; s < STP_ELLIPSE_SAMPLES; ++s) {
            stp_ellipse_fit_expand(&fit, samples[s]);
        }
    }
    fit.center = center;
    return stp_ellipse_fit_end(&fit);
}

static void make_some(size_t begin, size_t end, uint32_t worker, void* user)
{
    const ellipse_maker* m = user;
    (void)worker;
    for (size_t i = begin; i < end; ++i) {
        const stp_octree_cell* cell = &m->tree->cells[i];
        assert(cell->begin < cell->end && "cells without points are not chosen");
        cell_sums sums = {0};
        for (uint32_t place = cell->begin; place < cell->end; ++place) {
            add_disk(m, cell, place, &sums);
        }
        m->output->ellipses[i] = cell->end - cell->begin == 1
                                     ? m->tree->disks[m->tree->order[cell->begin]]
                                     : cover_cell(m, cell, &sums);
        stp_color_mean_write(&sums.color, m->output->colors + 3 * i);
    }
}

typedef stp_result (*chooser)(stp_octree_cells* tree, uint32_t target);

static stp_result decimate(stp_context* context, const stp_decimate_input* input, uint32_t target,
                           chooser choose, stp_decimate_output* output)
{
    *output = (stp_decimate_output){0};
    stp_ellipse* disks = NULL;
    stp_result result = stp_decimate_check(context, input);
    if (result == STP_OK) {
        result = stp_decimate_make_disks(context, input, &disks, NULL);
    }
    stp_octree_cells tree = {.context = context, .input = input, .disks = disks};
    result = result == STP_OK ? stp_octree_cells_make(&tree) : result;
    result = result == STP_OK ? choose(&tree, target) : result;
    result = result == STP_OK ? stp_decimate_make_room(context, output, tree.count) : result;
    if (result == STP_OK) {
        stp_box box = stp_decimate_box(input);
        ellipse_maker m = {.tree = &tree,
                           .output = output,
                           .minimum =
                               fmaxf(1e-9f * stp_length(stp_sub(box.max, box.min)), FLT_MIN)};
        stp_parallel_for(context, tree.count, GRAIN, make_some, &m);
    }
    stp_octree_cells_destroy(&tree);
    stp_free(context, disks);
    return result;
}

stp_result stp_decimate_by_octree(stp_context* context, const stp_decimate_input* input,
                                  uint32_t target, stp_decimate_output* output)
{
    return decimate(context, input, target, stp_octree_cells_open, output);
}

stp_result stp_decimate_by_octree_level(stp_context* context, const stp_decimate_input* input,
                                        uint32_t target, stp_decimate_output* output)
{
    return decimate(context, input, target, stp_octree_cells_take_level, output);
}
