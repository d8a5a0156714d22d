// SPDX-License-Identifier: MIT
// Synthetic candidates for tests: surfaces met by rays through regular pixels from several
// directions, as a capture would give them, and a plain farthest-first order.
#pragma once

#include "base/math/rng.h"
#include "base/splats/coverage.h"
#include "lod/blue/finish.h"

#include <assert.h>
#include <stdlib.h>
#include <string.h>

enum { MAKER_LIMIT = 60000 };

typedef struct maker {
    stp_candidates candidates;
    uint32_t order[MAKER_LIMIT];
    float radii[MAKER_LIMIT];
    float final_radius;
    uint32_t count; ///< ordered
} maker;

static inline maker* maker_create(double pixel_size)
{
    maker* m = calloc(1, sizeof(*m));
    stp_candidates* c = &m->candidates;
    c->positions = malloc(MAKER_LIMIT * 3 * sizeof(float));
    c->normals = malloc(MAKER_LIMIT * 3 * sizeof(float));
    c->colors = malloc(MAKER_LIMIT * 4);
    c->materials = calloc(MAKER_LIMIT, sizeof(uint32_t));
    c->pixel_size = pixel_size;
    c->direction_count = 8;
    return m;
}

static inline void maker_destroy(maker* m)
{
    free(m->candidates.positions);
    free(m->candidates.normals);
    free(m->candidates.colors);
    free(m->candidates.materials);
    free(m);
}

static inline void maker_add(maker* m, stp_vec3 p, stp_vec3 n, uint32_t rgba)
{
    stp_candidates* c = &m->candidates;
    if (c->count < MAKER_LIMIT) {
        size_t i = c->count++;
        memcpy(c->positions + 3 * i, &p, sizeof(p));
        memcpy(c->normals + 3 * i, &n, sizeof(n));
        for (int k = 0; k < 4; ++k) {
            c->colors[4 * i + (size_t)k] = (uint8_t)(rgba >> (24 - 8 * k));
        }
    }
}

/// Intersections of the plane z = 0 with the pixels of four views from above its corners; `inside`
/// tells where there is surface, and its colour (alpha 0: no surface).
static inline void maker_add_plane(maker* m, double half_extent,
                                   uint32_t (*inside)(double x, double y, void* user), void* user)
{
    for (int view = 0; view < 4; ++view) {
        double dx = (view & 1) != 0 ? -1.0 : 1.0, dy = (view & 2) != 0 ? -1.0 : 1.0;
        // right = normalize(-dy, dx, 0), up = cross(d, right): on z = 0 only their x and y count
        double s = 0.70710678118654752, c = 0.57735026918962576;
        double rx = -dy * s, ry = dx * s, ux = -c * ry, uy = c * rx;
        double scale = m->candidates.pixel_size, determinant = rx * uy - ry * ux;
        int range = (int)(1.5 * half_extent / scale) + 1;
        for (int i = -range; i < range; ++i) {
            for (int j = -range; j < range; ++j) {
                double a = (i + 0.5 + 0.13 * view) * scale, b = (j + 0.37) * scale;
                double x = (a * uy - ry * b) / determinant, y = (rx * b - a * ux) / determinant;
                bool within = fabs(x) <= half_extent && fabs(y) <= half_extent;
                uint32_t color = within ? inside(x, y, user) : 0;
                if ((color & 0xff) != 0) {
                    maker_add(m, (stp_vec3){(float)x, (float)y, 0}, (stp_vec3){0, 0, 1}, color);
                }
            }
        }
    }
}

/// Candidates near each other: a cell of a grid.
typedef struct maker_cell {
    float minimum[3], maximum[3];
    float farthest;      ///< largest distance of its candidates to those picked
    uint32_t at;         ///< the first candidate at that distance
    uint32_t begin, end; ///< in the list of candidates by cell
} maker_cell;

enum { MAKER_GRID = 24, MAKER_CELLS = MAKER_GRID * MAKER_GRID * MAKER_GRID };

static inline uint32_t maker_cell_of(const stp_candidates* c, uint32_t candidate, float minimum,
                                     float maximum)
{
    uint32_t cell = 0;
    for (int k = 0; k < 3; ++k) {
        float at = (c->positions[3 * (size_t)candidate + (size_t)k] - minimum) /
                   (maximum - minimum + 1e-6f);
        cell = MAKER_GRID * cell + (uint32_t)(at * (float)MAKER_GRID);
    }
    return cell < MAKER_CELLS ? cell : MAKER_CELLS - 1;
}

/// Sorts the candidates by cell. @return the number of cells that have any
static inline uint32_t maker_fill_cells(const stp_candidates* c, uint32_t* list, maker_cell* cells)
{
    float minimum = INFINITY, maximum = -INFINITY;
    for (size_t i = 0; i < 3 * (size_t)c->count; ++i) {
        minimum = c->positions[i] < minimum ? c->positions[i] : minimum;
        maximum = c->positions[i] > maximum ? c->positions[i] : maximum;
    }
    uint32_t* starts = calloc(MAKER_CELLS + 1, sizeof(uint32_t));
    for (uint32_t i = 0; i < c->count; ++i) {
        starts[maker_cell_of(c, i, minimum, maximum) + 1] += 1;
    }
    uint32_t count = 0;
    for (uint32_t i = 0; i < MAKER_CELLS; ++i) {
        if (starts[i + 1] > 0) {
            cells[count++] = (maker_cell){{INFINITY, INFINITY, INFINITY},
                                          {-INFINITY, -INFINITY, -INFINITY},
                                          INFINITY,
                                          UINT32_MAX,
                                          starts[i],
                                          starts[i] + starts[i + 1]};
        }
        starts[i + 1] += starts[i];
    }
    for (uint32_t i = 0; i < c->count; ++i) {
        list[starts[maker_cell_of(c, i, minimum, maximum)]++] = i;
    }
    free(starts);
    for (uint32_t i = 0; i < count; ++i) {
        for (uint32_t at = cells[i].begin; at < cells[i].end; ++at) {
            const float* p = c->positions + 3 * (size_t)list[at];
            for (int k = 0; k < 3; ++k) {
                cells[i].minimum[k] = p[k] < cells[i].minimum[k] ? p[k] : cells[i].minimum[k];
                cells[i].maximum[k] = p[k] > cells[i].maximum[k] ? p[k] : cells[i].maximum[k];
            }
        }
        cells[i].at = list[cells[i].begin];
    }
    assert(count <= MAKER_CELLS && "no more cells than the grid has");
    return count;
}

/// Whether a place is farther from all of a cell than its candidates are from those picked.
static inline bool maker_is_beyond(const maker_cell* cell, const float* p)
{
    float square = 0.0f;
    for (int k = 0; k < 3; ++k) {
        float below = cell->minimum[k] - p[k], above = p[k] - cell->maximum[k];
        float away = below > 0.0f ? below : above > 0.0f ? above : 0.0f;
        square += away * away;
    }
    return square > 1.001f * cell->farthest * cell->farthest; // despite rounding
}

/// Updates the distances of a cell after a candidate was picked.
static inline void maker_update_cell(const stp_candidates* c, const uint32_t* list,
                                     maker_cell* cell, uint32_t picked, float side, float* distance)
{
    const float* p = c->positions + 3 * (size_t)picked;
    const float* n = c->normals + 3 * (size_t)picked;
    cell->farthest = -1.0f;
    for (uint32_t at = cell->begin; at < cell->end; ++at) {
        uint32_t i = list[at];
        const float* q = c->positions + 3 * (size_t)i;
        const float* k = c->normals + 3 * (size_t)i;
        float x = q[0] - p[0], y = q[1] - p[1], z = q[2] - p[2];
        float d = sqrtf(x * x + y * y + z * z);
        d += n[0] * k[0] + n[1] * k[1] + n[2] * k[2] < 0.0f ? side : 0.0f;
        distance[i] = d < distance[i] ? d : distance[i];
        if (distance[i] > cell->farthest) {
            cell->farthest = distance[i];
            cell->at = i;
        }
    }
}

/// Farthest-first, the first of equals: the Euclidean distance, plus `side` where normals face
/// apart.
static inline void maker_order(maker* m, uint32_t wanted, float side)
{
    const stp_candidates* c = &m->candidates;
    assert(c->count > 0 && c->count <= MAKER_LIMIT && "candidates were added");
    float* distance = malloc(c->count * sizeof(float));
    uint32_t* list = malloc(c->count * sizeof(uint32_t));
    maker_cell* cells = malloc(MAKER_CELLS * sizeof(maker_cell));
    for (uint32_t i = 0; i < c->count; ++i) {
        distance[i] = INFINITY;
    }
    uint32_t next = 0, cell_count = maker_fill_cells(c, list, cells);
    for (m->count = 0; m->count < wanted && m->count < c->count && distance[next] > 0.0f;) {
        uint32_t picked = next;
        m->order[m->count] = picked;
        m->radii[m->count++] = distance[picked];
        const float* p = c->positions + 3 * (size_t)picked;
        distance[picked] = 0.0f;
        next = picked;
        for (uint32_t i = 0; i < cell_count; ++i) {
            maker_cell* cell = &cells[i];
            if (!maker_is_beyond(cell, p)) {
                maker_update_cell(c, list, cell, picked, side, distance);
            }
            float difference = cell->farthest - distance[next];
            next = difference > 0.0f || (difference == 0.0f && cell->at < next) ? cell->at : next;
        }
    }
    m->final_radius = m->count < c->count ? distance[next] : 0.0f;
    free(cells);
    free(list);
    free(distance);
}

static inline stp_finish_input maker_input(const maker* m)
{
    static const uint8_t shadings[1] = {0};
    return (stp_finish_input){.candidates = &m->candidates,
                              .order = m->order,
                              .radii = m->radii,
                              .count = m->count,
                              .final_radius = m->final_radius,
                              .shading_of_material = shadings};
}

/// Orders `wanted` of the candidates and finishes them.
static inline stp_result maker_finish(maker* m, stp_context* context, uint32_t wanted,
                                      stp_splats* out)
{
    maker_order(m, wanted, 10.0f);
    stp_finish_input input = maker_input(m);
    return stp_finish_surfels(context, &input, out);
}

/// Where an octave's entries begin in colors and coverages.
static inline size_t octave_start(const stp_splats* s, uint32_t octave)
{
    size_t start = 0;
    assert(octave <= s->octave_count && "the set has the octave");
    for (uint32_t i = 0; i < octave; ++i) {
        start += s->octave_ends[i];
    }
    return start;
}

/// Probability that a disk is drawn at a place, `offset` (over its radius) from its centre.
/// `entry`: index of its coverage (see octave_start).
static inline double drawn_chance(const stp_splats* s, size_t entry, uint32_t surfel,
                                  stp_vec3 offset)
{
    uint8_t code = s->coverages[entry];
    if (!stp_coverage_clips(code)) {
        return stp_coverage_share(code) / 255.0;
    }
    stp_disk_clip clip = stp_coverage_clip(code);
    stp_disk_axes axes = stp_disk_axes_of((float)s->normals[2 * (size_t)surfel],
                                          (float)s->normals[2 * (size_t)surfel + 1]);
    float at = clip.across * stp_dot(axes.x, offset) + clip.along * stp_dot(axes.y, offset);
    return at >= clip.low && at <= clip.high ? 1.0 : 0.0;
}

/// Whether a disk has no holes.
static inline bool is_without_holes(uint8_t code)
{
    return code >= STP_COVERAGE_CHANCES;
}
