// SPDX-License-Identifier: MIT
//
// Light normals (base/splats/light_normal.h): for each entry of the pyramid, the mean normal of the
// surface nearest to its surfel, by area. Candidates may have light normals that differ from their
// normals: those of normal maps, and those of the sets that they were taken from. Sums are
// integers, so they do not depend on the order of threads.
#include "base/splats/light_normal.h"
#include "lod/blue/pyramid.h"

#include <string.h>

#define GRAIN 16384

stp_result stp_pyramid_allocate_lights(stp_pyramid* p, size_t entries, size_t summed)
{
    const stp_finish_input* finish = p->input->finish;
    if (finish->candidates->light_normals == NULL || finish->two_sided) {
        return STP_OK;
    }
    p->lights = STP_NEW_ARRAY(p->context, float, 3 * entries);
    p->light_sums = STP_NEW_ARRAY(p->context, int64_t, 3 * summed);
    return p->lights != NULL && p->light_sums != NULL ? STP_OK : stp_fail_memory(p->context);
}

static void candidate_light(const stp_pyramid* p, uint32_t candidate, float light[3])
{
    const stp_candidates* c = p->input->finish->candidates;
    uint8_t alpha = c->colors[4 * (size_t)candidate + 3];
    float area = (float)stp_candidate_area(&p->areas, candidate, alpha);
    for (size_t k = 0; k < 3; ++k) {
        light[k] = area * c->light_normals[3 * (size_t)candidate + k];
    }
}

static void add_light(int64_t sum[3], const float light[3])
{
    for (int k = 0; k < 3; ++k) {
        sum[k] += (int64_t)(light[k] + (light[k] < 0.0f ? -0.5f : 0.5f));
    }
}

void stp_pyramid_sum_lights(stp_pyramid* p, uint32_t octave, const stp_grid* samples)
{
    if (p->lights == NULL) {
        return;
    }
    bool finest = octave + 1 == p->surfels->octave_count;
    uint32_t count = p->surfels->octave_ends[octave];
    float* lights = p->lights + 3 * stp_pyramid_first(p, octave);
    const float* finer = finest ? NULL : p->lights + 3 * stp_pyramid_first(p, octave + 1);
    memset(p->light_sums, 0, 3 * (size_t)count * sizeof(*p->light_sums));
    for (uint32_t at = 0; at < samples->count; ++at) {
        if (p->nearest[at] != UINT32_MAX) {
            float light[3];
            size_t index = samples->index[at];
            if (finest) {
                candidate_light(p, (uint32_t)index, light);
            }
            add_light(p->light_sums + 3 * (size_t)p->nearest[at],
                      finest ? light : finer + 3 * index);
        }
    }
    for (size_t i = 0; i < count; ++i) {
        if (p->sums[i].weight != 0) {
            for (size_t k = 0; k < 3; ++k) {
                lights[3 * i + k] = (float)p->light_sums[3 * i + k];
            }
        } else if (finest) { // no samples: its own
            candidate_light(p, p->input->finish->order[i], lights + 3 * i);
        } else {
            memcpy(lights + 3 * i, finer + 3 * i, 3 * sizeof(float));
        }
    }
}

void stp_pyramid_keep_lights(stp_pyramid* p, uint32_t octave)
{
    if (p->lights == NULL) {
        return;
    }
    float* lights = p->lights + 3 * stp_pyramid_first(p, octave);
    for (size_t i = 0; i < p->surfels->count; ++i) {
        candidate_light(p, p->input->finish->order[i], lights + 3 * i);
    }
}

// An octave's entries, and where they are written.
typedef struct lit_octave {
    const stp_pyramid* p;
    size_t first; ///< entry of its first surfel
    int8_t* turns;
    uint8_t* spreads;
} lit_octave;

static void write_octave(size_t begin, size_t end, uint32_t worker, void* user)
{
    (void)worker;
    const lit_octave* o = user;
    const stp_pyramid* p = o->p;
    for (size_t i = begin; i < end; ++i) {
        const stp_pyramid_entry* e = &p->entries[o->first + i];
        const float* sum = p->lights != NULL ? p->lights + 3 * (o->first + i) : e->toward;
        assert(e->area > 0.0f && "an entry stands for some surface");
        stp_vec3 mean = stp_scale((stp_vec3){sum[0], sum[1], sum[2]}, 1.0f / e->area);
        stp_light_normal_encode(mean, p->surfels->normals + 2 * i, o->turns + 2 * i,
                                o->spreads + i);
    }
}

static bool is_any_set(const void* bytes, size_t size)
{
    const uint8_t* at = bytes;
    uint8_t all = 0;
    for (size_t i = 0; i < size; ++i) {
        all |= at[i];
    }
    return all != 0;
}

stp_result stp_pyramid_write_lights(const stp_pyramid* p)
{
    stp_splats* s = p->surfels;
    bool own = p->lights == NULL; // finest surfels stand for a few candidates each
    uint32_t octaves = s->octave_count - (own ? 1 : 0);
    size_t entries = 0, to = 0;
    for (uint32_t k = 0; k < octaves; ++k) {
        entries += s->octave_ends[k];
    }
    if (entries == 0 || p->input->finish->two_sided) {
        return STP_OK;
    }
    s->turns = STP_NEW_ARRAY(p->context, int8_t, 2 * entries);
    s->spreads = STP_NEW_ARRAY(p->context, uint8_t, entries);
    if (s->turns == NULL || s->spreads == NULL) {
        return stp_fail_memory(p->context);
    }
    for (uint32_t k = 0; k < octaves; ++k) {
        size_t count = s->octave_ends[k];
        lit_octave octave = {p, stp_pyramid_first(p, k), s->turns + 2 * to, s->spreads + to};
        stp_parallel_for(p->context, count, GRAIN, write_octave, &octave);
        if (is_any_set(octave.turns, 2 * count) || is_any_set(octave.spreads, count)) {
            s->light_octaves |= 1u << k;
            to += count;
        }
    }
    if (s->light_octaves == 0) {
        stp_free(p->context, s->turns);
        stp_free(p->context, s->spreads);
        s->turns = NULL;
        s->spreads = NULL;
    }
    return STP_OK;
}
