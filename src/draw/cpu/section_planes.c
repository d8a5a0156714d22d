// SPDX-License-Identifier: MIT
// Section planes through items, splats of ghosts and splats that face away. Nearly all items lie
// inside all planes and skip these tests.
#include "base/splats/coverage.h"
#include "draw/cpu/cpu.h"
#include "draw/placement.h"
#include "select/sections.h"

#include <assert.h>
#include <string.h>

// Relative rounding error of a product: a face in the plane itself stays whole.
#define ROUNDED 2e-6

/// Moves a plane outwards by the maximum rounding error within a box.
static void relax(double row[4], const double reach[3], double steps)
{
    double size = fabs(row[3]);
    for (int c = 0; c < 3; ++c) {
        size += fabs(row[c]) * reach[c];
        row[3] -= steps * fabs(row[c]);
    }
    row[3] -= ROUNDED * size;
}

void stp_cpu_find_sections(const stp_cpu_renderer* r, const stp_cpu_item* item,
                           stp_cpu_sections* sections)
{
    sections->count = 0;
    if (item->draw->sections == 0) {
        return;
    }
    assert(item->kind == STP_DRAW_MESH && "splats are tested by stp_cpu_filter_splats");
    stp_box box = stp_store_describe_mesh(r->store, item->draw->index)->bounds;
    const double reach[3] = {0.5 * ((double)box.max.x - (double)box.min.x),
                             0.5 * ((double)box.max.y - (double)box.min.y),
                             0.5 * ((double)box.max.z - (double)box.min.z)};
    for (uint32_t bits = item->draw->sections; bits != 0; bits &= bits - 1) {
        const stp_section_plane* plane = &r->sections->planes[__builtin_ctz(bits)];
        double row[4];
        stp_section_row(plane, &item->draw->transform, item->offset, row);
        relax(row, reach, 0.0);
        assert(sections->count < STP_SECTION_PLANES);
        float* out = sections->rows[sections->count++];
        for (int c = 0; c < 4; ++c) {
            out[c] = (float)row[c];
        }
    }
}

bool stp_cpu_sections_drop(const stp_cpu_sections* sections, const stp_cpu_item* item, stp_box box,
                           uint32_t* mask)
{
    const float low[3] = {box.min.x, box.min.y, box.min.z};
    const float high[3] = {box.max.x, box.max.y, box.max.z};
    for (uint32_t i = 0; i < sections->count; ++i) {
        const float* row = sections->rows[i];
        float minimum = row[3], maximum = row[3], size = fabsf(row[3]);
        for (int c = 0; c < 3; ++c) {
            float from = row[c] * (low[c] - item->offset[c]);
            float to = row[c] * (high[c] - item->offset[c]);
            minimum += stp_min(from, to);
            maximum += stp_max(from, to);
            size += stp_max(fabsf(from), fabsf(to));
        }
        if (minimum > 1e-5f * size) { // float rounding
            return true;
        }
        if (maximum > -1e-5f * size) {
            *mask |= 1u << i;
        }
    }
    assert(*mask >> sections->count == 0 && "bits of known planes");
    return false;
}

/// Planes in the units of splat positions.
static void turn_sections(const stp_cpu_renderer* r, const stp_cpu_item* item, bool grid,
                          float rows[STP_SECTION_PLANES][4], uint32_t* count)
{
    const float origin[3] = {grid ? item->splats.origin.x : 0.0f,
                             grid ? item->splats.origin.y : 0.0f,
                             grid ? item->splats.origin.z : 0.0f};
    double step = grid ? (double)item->splats.step : 1.0;
    stp_box box = item->points.bounds;
    double reach[3] = {65535.0, 65535.0, 65535.0};
    if (!grid) {
        reach[0] = (double)stp_max(fabsf(box.min.x), fabsf(box.max.x));
        reach[1] = (double)stp_max(fabsf(box.min.y), fabsf(box.max.y));
        reach[2] = (double)stp_max(fabsf(box.min.z), fabsf(box.max.z));
    }
    *count = 0;
    for (uint32_t bits = item->draw->sections; bits != 0; bits &= bits - 1) {
        const stp_section_plane* plane = &r->sections->planes[__builtin_ctz(bits)];
        double row[4];
        stp_section_row(plane, &item->draw->transform, origin, row);
        for (int c = 0; c < 3; ++c) {
            row[c] *= step;
        }
        relax(row, reach, grid ? 0.5 : 0.0); // splat positions are integers
        for (int c = 0; c < 4; ++c) {
            rows[*count][c] = (float)row[c];
        }
        assert(*count < STP_SECTION_PLANES);
        *count += 1;
    }
}

/// Bits of up to 16 splats that no plane cuts away.
static uint16_t find_left(const stp_raster_splats* splats, uint32_t first, uint32_t count,
                          float rows[STP_SECTION_PLANES][4], uint32_t row_count)
{
    assert(count <= 16 && row_count <= STP_SECTION_PLANES);
    float x[16] = {0}, y[16] = {0}, z[16] = {0};
    uint16_t left = 0;
    for (uint32_t i = 0; i < count; ++i) {
        size_t at = 3 * (size_t)(first + i);
        if (splats->positions != NULL) {
            const uint16_t* p = splats->positions + at;
            x[i] = (float)p[0];
            y[i] = (float)p[1];
            z[i] = (float)p[2];
        } else {
            const float* p = splats->points + at;
            x[i] = p[0];
            y[i] = p[1];
            z[i] = p[2];
        }
    }
    uint32_t beyond[16] = {0};
    for (uint32_t k = 0; k < row_count; ++k) {
        const float* row = rows[k];
        for (int i = 0; i < 16; ++i) {
            beyond[i] |=
                (uint32_t)((row[0] * x[i] + row[1] * y[i]) + row[2] * z[i] + row[3] > 0.0f);
        }
    }
    for (uint32_t i = 0; i < count; ++i) {
        left = (uint16_t)(left | (beyond[i] ^ 1u) << i);
    }
    return left;
}

bool stp_cpu_hides_some(const stp_cpu_renderer* r, const stp_cpu_item* item)
{
    bool marked =
        item->kind == STP_DRAW_SPLATS ? item->coverages != NULL : item->points.colors != NULL;
    return marked && stp_store_get_coloring(r->store)->hides;
}

/// Bits of up to 16 splats or points of visible classes (store/file/point_attributes.h).
static uint16_t find_shown(const stp_cpu_item* item, uint32_t first, uint32_t count)
{
    assert(count <= 16 && "one word of bits");
    uint16_t shown = 0;
    for (uint32_t i = 0; i < count; ++i) {
        size_t at = (size_t)first + i;
        uint8_t mark =
            item->kind == STP_DRAW_SPLATS ? item->coverages[at] : item->points.colors[4 * at + 3];
        shown = (uint16_t)(shown | (mark != 0 ? 1u : 0u) << i);
    }
    return shown;
}

// Disks of stretched items are turned as if they were not, so their sides are not those of the
// surface.
bool stp_cpu_drops_backs(const stp_cpu_renderer* r, const stp_cpu_item* item)
{
    return item->kind == STP_DRAW_SPLATS && r->front_only != STP_FRONT_ONLY_NONE &&
           !item->splats.unknown_signs && stp_affine_is_similarity(&item->draw->transform) &&
           !stp_cpu_draws_backs(r);
}

/// Bits of up to 16 splats that do not face away, or may.
static uint16_t find_fronts(const stp_cpu_renderer* r, const stp_cpu_item* item,
                            const stp_raster_splats* splats, const float eye[3], uint32_t first,
                            uint32_t count)
{
    assert(count <= 16 && "one word of bits");
    float from = r->frame.parallel ? 0.0f : 1.0f; // in parallel, `eye` is a direction
    uint16_t fronts = 0;
    for (uint32_t i = 0; i < count; ++i) {
        size_t at = (size_t)first + i;
        const uint16_t* p = splats->positions + 3 * at;
        const int8_t* code = splats->normals + 2 * at;
        stp_vec3 n = stp_octahedral_unfold((float)code[0], (float)code[1]);
        stp_vec3 sight = {eye[0] - from * (float)p[0], eye[1] - from * (float)p[1],
                          eye[2] - from * (float)p[2]};
        float along = stp_dot(n, sight);
        float least = STP_BACK_SINE * STP_BACK_SINE * (stp_dot(n, n) * stp_dot(sight, sight));
        bool away = along < 0.0f && along * along > least;
        bool dropped = away && r->front_only_shadings[item->splats.materials[at]] != 0;
        fronts = (uint16_t)(fronts | (dropped ? 0u : 1u) << i);
    }
    return fronts;
}

/// From where the splats of an item are seen, in steps of their grid. @return false if none are
/// left out for facing away
static bool find_grid_eye(const stp_cpu_renderer* r, const stp_cpu_item* item,
                          const stp_raster_splats* splats, float eye[3])
{
    const float origin[3] = {item->splats.origin.x, item->splats.origin.y, item->splats.origin.z};
    bool drops = stp_cpu_drops_backs(r, item) && splats->normals != NULL &&
                 stp_find_item_eye(&r->frame, &item->draw->transform, origin, eye);
    for (int c = 0; c < 3 && drops && !r->frame.parallel; ++c) {
        eye[c] /= item->splats.step;
    }
    return drops;
}

bool stp_cpu_filter_splats(const stp_cpu_renderer* r, const stp_cpu_item* item,
                           stp_raster_splats* splats, stp_cpu_worker* worker)
{
    splats->share = item->draw->ghost ? stp_placement_ghost_part(stp_cpu_ghost_share(r)) : 0.0f;
    float eye[3] = {0};
    bool hides = stp_cpu_hides_some(r, item);
    bool fronts = find_grid_eye(r, item, splats, eye);
    if (item->draw->sections == 0 && !hides && !fronts) {
        return true;
    }
    assert(splats->begin % 16 == 0 && splats->begin <= splats->end && "bits in words of 16");
    size_t words = ((size_t)splats->end + 15) / 16;
    uint16_t* left = stp_arena_alloc(&worker->scratch, words * sizeof(*left));
    if (left == NULL) {
        return false;
    }
    float rows[STP_SECTION_PLANES][4] = {{0}};
    uint32_t row_count;
    turn_sections(r, item, splats->positions != NULL, rows, &row_count);
    for (uint32_t first = splats->begin; first < splats->end; first += 16) {
        uint32_t count = splats->end - first < 16 ? splats->end - first : 16;
        uint32_t wanted = splats->wanted != NULL ? splats->wanted[first / 16] : 0xFFFFu;
        wanted &= hides ? find_shown(item, first, count) : 0xFFFFu;
        wanted &= fronts ? find_fronts(r, item, splats, eye, first, count) : 0xFFFFu;
        left[first / 16] = (uint16_t)(wanted & find_left(splats, first, count, rows, row_count));
    }
    splats->wanted = left;
    return true;
}
