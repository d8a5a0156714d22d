// SPDX-License-Identifier: MIT
#include "lod/method.h"

#include "base/core/clock.h"
#include "lod/psp/psp_set.h"
#include "lod/spt/spt_set.h"
#include "lod/stochastic/set.h"

#include <assert.h>
#include <string.h>

enum {
    SPT_VERSION = 7,          ///< increment when sets change
    SPT_BYTES = 2 * 120,      ///< per sample: two nodes in tree, sequence and columns
    SPT_TRIANGLE_BYTES = 100, ///< per large triangle: in boxes, and their order
    PSP_VERSION = 3,
    PSP_BYTES = 1000, ///< per sample
    COARSE_VERSION = 1,
    COARSE_SAMPLES = 2048, ///< the first surfels of a set, at most
    COARSE_FEWEST_SAMPLES = 64,
    COARSE_SURFELS_PER_SAMPLE = 7, ///< of small sets
    COARSE_SAMPLES_PER_SPLAT = 4,  ///< of the finest state
    STOCHASTIC_VERSION = 5,
    STOCHASTIC_BYTES = 120, ///< per sample
    SPT_COLORS = 48,        ///< if colours differ by more, of 255, a node's error is its diameter
};

stp_method_options stp_method_options_default(void)
{
    return (stp_method_options){.tree = {STP_TREE_GEOMETRIC, SPT_COLORS},
                                .psp_metric = STP_PSP_REGIONS,
                                .leaves = stp_leaf_desc_default()};
}

static stp_hash hash_spt(stp_hash key, const stp_method_options* options)
{
    uint32_t all[3] = {SPT_VERSION, (uint32_t)options->tree.error, options->tree.color_threshold};
    key = stp_hash_bytes(key, "spt", 3);
    return stp_hash_bytes(key, all, sizeof(all));
}

static uint64_t spt_bytes(uint64_t samples, uint64_t triangles)
{
    return SPT_BYTES * samples + SPT_TRIANGLE_BYTES * triangles;
}

static stp_result make_spt(stp_context* context, const stp_method_source* source,
                           const stp_method_options* options, stp_splats* splats)
{
    assert(source->triangle_count == 0 || source->corners != NULL);
    const stp_spt_desc desc = {.tree = options->tree,
                               .shadings = source->shadings,
                               .corners = source->corners,
                               .triangle_count = source->triangle_count};
    return stp_spt_make(context, source->samples, &desc, splats);
}

static stp_hash hash_psp(stp_hash key, const stp_method_options* options)
{
    const uint32_t version = PSP_VERSION;
    key = stp_hash_bytes(key, "psp", 3);
    key = stp_hash_bytes(key, &version, sizeof(version));
    if (options->psp_metric != STP_PSP_REGIONS) { // keys of the default stay those of older files
        const uint32_t metric = (uint32_t)options->psp_metric;
        key = stp_hash_bytes(key, &metric, sizeof(metric));
    }
    return key;
}

static uint64_t psp_bytes(uint64_t samples, uint64_t triangles)
{
    (void)triangles;
    return PSP_BYTES * samples;
}

static stp_result make_psp(stp_context* context, const stp_method_source* source,
                           const stp_method_options* options, stp_splats* splats)
{
    return stp_psp_make(context, source->samples, source->shadings, source->two_sided,
                        options->psp_metric, 0, splats);
}

static stp_hash hash_coarse(stp_hash key, const stp_method_options* options)
{
    const uint32_t all[] = {COARSE_VERSION, PSP_VERSION};
    (void)options;
    key = stp_hash_bytes(key, "coarse", 6);
    return stp_hash_bytes(key, all, sizeof(all));
}

// Few of a small set, so that builds take hardly longer.
static uint32_t count_coarse_samples(uint64_t surfels)
{
    uint64_t part = surfels / COARSE_SURFELS_PER_SAMPLE;
    part = part > COARSE_FEWEST_SAMPLES ? part : COARSE_FEWEST_SAMPLES;
    part = part < surfels ? part : surfels;
    return (uint32_t)(part < COARSE_SAMPLES ? part : COARSE_SAMPLES);
}

static uint64_t coarse_bytes(uint64_t samples, uint64_t triangles)
{
    return psp_bytes(count_coarse_samples(samples), triangles);
}

static stp_result make_coarse(stp_context* context, const stp_method_source* source,
                              const stp_method_options* options, stp_splats* splats)
{
    stp_splats few = *source->samples;
    uint32_t count = count_coarse_samples(few.count), limit = count / COARSE_SAMPLES_PER_SPLAT;
    (void)options;
    if (count < few.count) { // with colours and coverages of the octave that holds them
        few.octave_count = 1;
        while (few.octave_ends[few.octave_count - 1] < count) {
            few.octave_count += 1;
        }
        assert(few.octave_count <= source->samples->octave_count);
        few.octave_ends[few.octave_count - 1] = few.count = count;
    }
    return stp_psp_make(context, &few, NULL, source->two_sided, STP_PSP_REGIONS,
                        limit > 0 ? limit : 1, splats);
}

static stp_hash hash_stochastic(stp_hash key, const stp_method_options* options)
{
    const stp_leaf_desc* leaves = &options->leaves;
    const uint32_t all[] = {STOCHASTIC_VERSION, leaves->budget,     leaves->minimum,
                            leaves->sample,     leaves->neighbours, leaves->normal_neighbours,
                            leaves->scales};
    key = stp_hash_bytes(key, "stochastic", 10);
    key = stp_hash_bytes(key, all, sizeof(all));
    return stp_hash_bytes(key, &leaves->flatness, sizeof(leaves->flatness));
}

static uint64_t stochastic_bytes(uint64_t samples, uint64_t triangles)
{
    (void)triangles;
    return STOCHASTIC_BYTES * samples;
}

static stp_result make_stochastic(stp_context* context, const stp_method_source* source,
                                  const stp_method_options* options, stp_splats* splats)
{
    return stp_stochastic_make_of_samples(context, source->samples, source->two_sided,
                                          &options->leaves, splats);
}

static stp_result make_stochastic_alone(const stp_scene* scene, uint32_t node,
                                        const uint8_t* shading_of_material,
                                        const stp_blue_desc* desc,
                                        const stp_method_options* options, stp_splats* splats,
                                        stp_blue_report* report)
{
    double start = stp_clock_ms();
    stp_blue_candidates found;
    stp_result result = stp_blue_find_candidates(scene, node, desc, &found);
    double captured = stp_clock_ms();
    *report = (stp_blue_report){.candidate_count = found.candidates.count,
                                .capture_ms = captured - start};
    *splats = (stp_splats){.columns = STP_STOCHASTIC_COLUMNS};
    if (result == STP_OK) {
        const stp_stochastic_source source = {.candidates = &found.candidates,
                                              .shading_of_material = shading_of_material,
                                              .wanted = found.wanted,
                                              .has_normals = !found.two_sided};
        assert(found.wanted <= found.candidates.count);
        result = stp_stochastic_make_set(scene->context, &source, &options->leaves, splats);
        report->order_ms = stp_clock_ms() - captured;
    }
    stp_candidates_destroy(scene->context, &found.candidates);
    return result;
}

const stp_method stp_methods[STP_METHOD_COUNT] = {
    {.name = "blue", .title = "Progressive Blue Surfels", .id = STP_METHOD_BLUE},
    {.name = "spt",
     .title = "Sequential Point Trees",
     .id = STP_METHOD_SPT,
     .columns = STP_SPT_COLUMNS,
     .split_columns = STP_SPLATS_ERRORS,
     .hash = hash_spt,
     .bytes = spt_bytes,
     .make = make_spt},
    {.name = "psp",
     .title = "Progressive Splatting",
     .id = STP_METHOD_PSP,
     .columns = STP_PSP_COLUMNS,
     .hash = hash_psp,
     .bytes = psp_bytes,
     .make = make_psp},
    {.name = "stochastic",
     .title = "View-Dependent Stochastic Sampling",
     .id = STP_METHOD_STOCHASTIC,
     .columns = STP_STOCHASTIC_COLUMNS,
     .finds_signs = true,
     .hash = hash_stochastic,
     .bytes = stochastic_bytes,
     .make = make_stochastic,
     .make_alone = make_stochastic_alone},
};

uint32_t stp_method_columns(const stp_method* method, const stp_method_options* options)
{
    return method->columns | (options->tree.error == STP_TREE_SPLIT ? method->split_columns : 0);
}

const stp_method stp_method_coarse = {.name = "coarse",
                                      .title = "Coarse ellipses",
                                      .id = STP_METHOD_COARSE,
                                      .columns = STP_PSP_COLUMNS,
                                      .hash = hash_coarse,
                                      .bytes = coarse_bytes,
                                      .make = make_coarse};

bool stp_methods_want_coarse(const stp_method* const* methods, uint32_t count)
{
    bool wants = count > 0 && methods[0]->id == STP_METHOD_BLUE;
    for (uint32_t i = 1; i < count; ++i) {
        wants = wants && methods[i]->id != STP_METHOD_PSP;
    }
    return wants;
}

const stp_method* stp_method_by_name(const char* name)
{
    for (int i = 0; i < STP_METHOD_COUNT; ++i) {
        if (strcmp(stp_methods[i].name, name) == 0) {
            return &stp_methods[i];
        }
    }
    return NULL;
}

const stp_method* stp_method_by_id(uint32_t id)
{
    for (int i = 0; i < STP_METHOD_COUNT; ++i) {
        if (stp_methods[i].id == id) {
            return &stp_methods[i];
        }
    }
    return NULL;
}
