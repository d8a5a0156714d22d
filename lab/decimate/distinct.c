// SPDX-License-Identifier: MIT
#include "base/math/rng.h"
#include "lab/decimate/contraction.h"
#include "lod/grid.h"

#include <assert.h>
#include <string.h>

static uint64_t hash_place(const float* p)
{
    uint64_t hash = 0;
    for (int k = 0; k < 3; ++k) {
        float value = p[k] + 0.0f; // -0 is 0
        uint32_t bits;
        memcpy(&bits, &value, sizeof(bits));
        hash = stp_rng_hash(hash, bits);
    }
    return hash;
}

static bool is_same(const float* a, const float* b)
{
    return a[0] == b[0] && a[1] == b[1] && a[2] == b[2];
}

static void add_point(const stp_decimate_input* input, size_t point, uint32_t place,
                      stp_distinct* d)
{
    stp_color_mean_add(&d->means[place], input, point, 1.0);
    for (size_t k = 0; k < 3 && d->normals != NULL; ++k) {
        d->normals[3 * (size_t)place + k] += input->normals[3 * point + k];
    }
}

static void normalize_all(stp_distinct* d)
{
    for (uint32_t i = 0; i < d->count && d->normals != NULL; ++i) {
        stp_vec3 n = stp_normalize(stp_decimate_vector(d->normals, i));
        float* to = d->normals + 3 * (size_t)i;
        to[0] = n.x;
        to[1] = n.y;
        to[2] = n.z;
    }
}

stp_result stp_distinct_make(stp_context* context, const stp_decimate_input* input, stp_distinct* d)
{
    size_t count = input->count, mask = 15;
    while (mask + 1 < 2 * count) {
        mask = 2 * mask + 1;
    }
    assert((mask & (mask + 1)) == 0 && mask >= count && "a slot is always free");
    *d = (stp_distinct){
        .positions = STP_NEW_ARRAY(context, float, 3 * count + 1),
        .normals = input->normals != NULL ? STP_NEW_ZEROED(context, float, 3 * count + 1) : NULL,
        .points = STP_NEW_ARRAY(context, uint32_t, count + 1),
        .places = STP_NEW_ARRAY(context, uint32_t, count + 1),
        .means = STP_NEW_ZEROED(context, stp_color_mean, count + 1)};
    uint32_t* slots = STP_NEW_ZEROED(context, uint32_t, mask + 1); // position index + 1
    uint32_t* order = STP_NEW_ARRAY(context, uint32_t, count + 1);
    bool made = d->positions != NULL && d->points != NULL && d->places != NULL &&
                d->means != NULL && slots != NULL && order != NULL &&
                (input->normals == NULL || d->normals != NULL);
    stp_result result = made ? STP_OK : stp_fail_memory(context);
    if (result == STP_OK) {
        result = stp_sort_spatially(context, input->positions, input->count, order);
    }
    for (size_t i = 0; result == STP_OK && i < count; ++i) {
        const float* p = input->positions + 3 * (size_t)order[i];
        size_t slot = hash_place(p) & mask;
        while (slots[slot] != 0 && !is_same(d->positions + 3 * ((size_t)slots[slot] - 1), p)) {
            slot = (slot + 1) & mask;
        }
        if (slots[slot] == 0) {
            memcpy(d->positions + 3 * (size_t)d->count, p, 3 * sizeof(*p));
            d->points[d->count] = order[i];
            slots[slot] = ++d->count;
        }
        d->places[order[i]] = slots[slot] - 1;
        add_point(input, order[i], slots[slot] - 1, d);
    }
    if (result == STP_OK) {
        normalize_all(d);
    }
    stp_free(context, slots);
    stp_free(context, order);
    return result;
}

void stp_distinct_destroy(stp_context* context, stp_distinct* d)
{
    stp_free(context, d->positions);
    stp_free(context, d->normals);
    stp_free(context, d->points);
    stp_free(context, d->places);
    stp_free(context, d->means);
    *d = (stp_distinct){0};
}

/// Copies the disk and the neighbours of each position to its points. A disk faces as its point
/// does.
static void spread_disks(const stp_decimate_input* input, const stp_distinct* d,
                         const stp_ellipse* place_disks, const uint32_t* place_near,
                         stp_ellipse* disks, uint32_t* neighbours)
{
    for (uint32_t i = 0; i < input->count; ++i) {
        uint32_t place = d->places[i];
        assert(place < d->count);
        disks[i] = place_disks[place];
        if (input->normals != NULL &&
            stp_dot(disks[i].normal, stp_decimate_vector(input->normals, i)) < 0.0f) {
            disks[i].normal = stp_scale(disks[i].normal, -1.0f);
        }
        for (uint32_t n = 0; n < STP_DECIMATE_NEIGHBOURS && neighbours != NULL; ++n) {
            uint32_t near = place_near[(size_t)STP_DECIMATE_NEIGHBOURS * place + n];
            neighbours[(size_t)STP_DECIMATE_NEIGHBOURS * i + n] =
                near != UINT32_MAX ? d->points[near] : UINT32_MAX;
        }
    }
}

stp_result stp_decimate_make_disks(stp_context* context, const stp_decimate_input* input,
                                   stp_ellipse** disks, uint32_t** neighbours)
{
    stp_distinct d;
    stp_ellipse* place_disks = NULL;
    uint32_t* place_near = NULL;
    *disks = NULL;
    stp_result result = stp_distinct_make(context, input, &d);
    if (result == STP_OK && d.count == input->count) {
        stp_distinct_destroy(context, &d);
        return stp_decimate_make_distinct_disks(context, input, disks, neighbours);
    }
    if (result == STP_OK) {
        const stp_decimate_input places = {
            .count = d.count, .positions = d.positions, .normals = d.normals};
        result = stp_decimate_make_distinct_disks(context, &places, &place_disks, &place_near);
    }
    if (result == STP_OK) {
        size_t links = (size_t)input->count * STP_DECIMATE_NEIGHBOURS;
        *disks = STP_NEW_ARRAY(context, stp_ellipse, (size_t)input->count + 1);
        uint32_t* near = neighbours != NULL ? STP_NEW_ARRAY(context, uint32_t, links + 1) : NULL;
        if (neighbours != NULL) {
            *neighbours = near;
        }
        if (*disks == NULL || (neighbours != NULL && near == NULL)) {
            result = stp_fail_memory(context);
        } else {
            spread_disks(input, &d, place_disks, place_near, *disks, near);
        }
    }
    stp_free(context, place_disks);
    stp_free(context, place_near);
    stp_distinct_destroy(context, &d);
    return result;
}

uint32_t stp_distinct_weld(const stp_distinct* distinct, const uint32_t* triangles,
                           uint32_t triangle_count, uint32_t* welded)
{
    uint32_t kept = 0;
    for (size_t t = 0; t < triangle_count; ++t) {
        uint32_t c[3];
        for (size_t k = 0; k < 3; ++k) {
            c[k] = distinct->places[triangles[3 * t + k]];
        }
        if (c[0] != c[1] && c[1] != c[2] && c[2] != c[0]) {
            memcpy(welded + 3 * (size_t)kept++, c, sizeof(c));
        }
    }
    return kept;
}
