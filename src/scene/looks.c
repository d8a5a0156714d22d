// SPDX-License-Identifier: MIT
#include "scene/looks.h"

#include "base/core/context.h"
#include "base/math/color.h"
#include "scene/texel_runs.h"

#include <assert.h>
#include <string.h>

enum {
    METAL_STEPS = 4,
    ROUGH_STEPS = 8,
    GLOW_STEPS = 4, ///< of each of three channels
};
_Static_assert(METAL_STEPS* ROUGH_STEPS <= STP_LOOK_CODES, "codes of a surface");
_Static_assert(GLOW_STEPS* GLOW_STEPS* GLOW_STEPS <= STP_LOOK_CODES, "codes of a glow");

/// The nearest of `steps` values from 0 to 1.
static uint32_t step_of(float value, uint32_t steps)
{
    float scaled = value * (float)(steps - 1) + 0.5f;
    return !(scaled > 0.0f) ? 0 : scaled >= (float)steps ? steps - 1 : (uint32_t)scaled;
}

static uint32_t surface_code(float metal, float roughness)
{
    return step_of(metal, METAL_STEPS) * ROUGH_STEPS + step_of(roughness, ROUGH_STEPS);
}

/// Steps are even to the eye: those of square roots.
static uint32_t glow_code(const float color[3], uint32_t steps)
{
    uint32_t code = 0;
    for (int c = 0; c < 3; ++c) {
        code = code * steps + step_of(sqrtf(stp_max(color[c], 0.0f)), steps);
    }
    return code;
}

/// What the bins of a texture are found for. A glow of too many variants has fewer steps.
typedef enum bins_kind {
    BINS_OF_SURFACE,
    BINS_OF_GLOW, ///< and those of half, and of a quarter of the steps
    BINS_KINDS = BINS_OF_GLOW + 3,
} bins_kind;

/// Steps of each channel of a glow; 1: the mean alone.
static uint32_t glow_steps(uint32_t kind)
{
    assert(kind >= BINS_OF_GLOW && kind < BINS_KINDS);
    return GLOW_STEPS >> (kind - BINS_OF_GLOW);
}

/// The code and the three values of a texel, from three of its bytes.
typedef struct texel_table {
    uint8_t channel[3];
    uint8_t code[3][256]; ///< the sum of three is the code
    float value[3][256];
} texel_table;

static void make_surface_table(texel_table* table)
{
    *table = (texel_table){.channel = {2, 1, 0}};
    for (int i = 0; i < 256; ++i) {
        float value = (float)i / 255.0f;
        table->value[0][i] = table->value[1][i] = value;
        table->code[0][i] = (uint8_t)surface_code(value, 0.0f);
        table->code[1][i] = (uint8_t)surface_code(0.0f, value);
    }
}

static void make_glow_table(uint32_t steps, texel_table* table)
{
    *table = (texel_table){.channel = {0, 1, 2}};
    for (int i = 0; i < 256; ++i) {
        for (int c = 0; c < 3; ++c) {
            float color[3] = {0.0f, 0.0f, 0.0f};
            color[c] = table->value[c][i] = stp_srgb8_to_linear((uint8_t)i);
            table->code[c][i] = (uint8_t)glow_code(color, steps);
        }
    }
}

/// Sums of the texels of each code.
typedef struct code_sums {
    uint64_t count[STP_LOOK_CODES];
    double sum[STP_LOOK_CODES][3];
} code_sums;

static void add_texels(const stp_texture* texture, const stp_texel_run* run,
                       const texel_table* table, code_sums* sums)
{
    for (size_t i = run->begin; i < run->end; ++i) {
        const uint8_t* t = texture->texels + 4 * i;
        uint32_t code = 0;
        for (int c = 0; c < 3; ++c) {
            code += table->code[c][t[table->channel[c]]];
        }
        assert(code < STP_LOOK_CODES);
        sums->count[code] += 1;
        for (int c = 0; c < 3; ++c) {
            sums->sum[code][c] += (double)table->value[c][t[table->channel[c]]];
        }
    }
}

/// Adds the sums of the next run of a texture.
static void add_sums(code_sums* sums, const code_sums* run)
{
    for (int i = 0; i < STP_LOOK_CODES; ++i) {
        sums->count[i] += run->count[i];
        for (int c = 0; c < 3; ++c) {
            sums->sum[i][c] += run->sum[i][c];
        }
    }
}

/// The mean of all texels: farther away, that is what is seen.
static void find_mean(const code_sums* sums, float mean[3])
{
    double count = 0.0, sum[3] = {0};
    for (int i = 0; i < STP_LOOK_CODES; ++i) {
        count += (double)sums->count[i];
        for (int c = 0; c < 3; ++c) {
            sum[c] += sums->sum[i][c];
        }
    }
    for (int c = 0; c < 3; ++c) {
        mean[c] = count > 0.0 ? (float)(sum[c] / count) : 1.0f;
    }
}

/// Adds the mean, unless texels have its code.
static void add_mean(code_sums* sums, uint32_t code, const float mean[3])
{
    assert(code < STP_LOOK_CODES);
    if (sums->count[code] == 0) {
        sums->count[code] = 1;
        for (int c = 0; c < 3; ++c) {
            sums->sum[code][c] = (double)mean[c];
        }
    }
}

/// The centre of a code, to compare codes.
static void centre_of(uint32_t code, const uint32_t steps[3], float out[3])
{
    for (int c = 2; c >= 0; --c) {
        out[c] = steps[c] > 1 ? (float)(code % steps[c]) / (float)(steps[c] - 1) : 0.0f;
        code /= steps[c];
    }
}

/// Makes a bin of each code that texels have. Other codes take the nearest bin.
static void make_bins(const code_sums* sums, const uint32_t steps[3], stp_look_bins* bins)
{
    uint32_t codes[STP_LOOK_CODES], code_count = steps[0] * steps[1] * steps[2];
    *bins = (stp_look_bins){.steps = steps[2]};
    for (uint32_t i = 0; i < code_count; ++i) {
        if (sums->count[i] != 0) {
            codes[bins->count] = i;
            for (int c = 0; c < 3; ++c) {
                bins->values[bins->count][c] = (float)(sums->sum[i][c] / (double)sums->count[i]);
            }
            bins->count += 1;
        }
    }
    assert(bins->count > 0 && "a texture has texels");
    for (uint32_t i = 0; i < code_count; ++i) {
        float own[3], least = FLT_MAX;
        centre_of(i, steps, own);
        for (uint32_t b = 0; b < bins->count; ++b) {
            float other[3], distance = 0.0f;
            centre_of(codes[b], steps, other);
            for (int c = 0; c < 3; ++c) {
                distance += (own[c] - other[c]) * (own[c] - other[c]);
            }
            if (distance < least) {
                least = distance;
                bins->of_code[i] = (uint8_t)b;
            }
        }
    }
}

static void make_table(uint32_t kind, texel_table* table)
{
    if (kind == BINS_OF_SURFACE) {
        make_surface_table(table);
    } else {
        make_glow_table(glow_steps(kind), table);
    }
}

/// Finds bins from the sums of a texture, to which it adds the mean.
static void find_bins(code_sums* sums, uint32_t kind, stp_look_bins* bins)
{
    static const uint32_t surface_steps[3] = {1, METAL_STEPS, ROUGH_STEPS};
    bool surface = kind == BINS_OF_SURFACE;
    float mean[3];
    find_mean(sums, mean);
    if (surface) {
        add_mean(sums, surface_code(mean[0], mean[1]), mean);
        make_bins(sums, surface_steps, bins);
    } else {
        const uint32_t steps = glow_steps(kind), glow[3] = {steps, steps, steps};
        add_mean(sums, glow_code(mean, steps), mean);
        make_bins(sums, glow, bins);
    }
}

/// What bins are found from.
typedef struct bins_source {
    uint32_t texture, kind;
} bins_source;

/// The reading of textures for some bins.
typedef struct bins_reading {
    const bins_source* sources; ///< as the runs count them
    stp_look_bins* bins;        ///< of each source
    const uint32_t* places;     ///< of each run in `sums`; STP_NONE: it is a whole texture
    code_sums* sums;            ///< of the runs of textures that have several
} bins_reading;

/// A search for the bins of all looks. Looks that share a texture share its bins.
typedef struct look_search {
    stp_scene* scene;
    uint32_t* places;     ///< in scene->look_bins, of each texture and kind; 0: not asked for
    bins_source* sources; ///< of scene->look_bins
    size_t bins_capacity, source_capacity;
    uint32_t count, found; ///< bins asked for, and of these the first ones, which are found
} look_search;

/// Asks for bins. @param place receives their index in scene->look_bins
static stp_result ask_bins(look_search* s, uint32_t texture, uint32_t kind, uint32_t* place)
{
    stp_scene* scene = s->scene;
    uint32_t* known = &s->places[(size_t)texture * BINS_KINDS + kind];
    stp_result result = STP_OK;
    if (*known == 0) {
        size_t wanted = (size_t)s->count + 1;
        result = STP_SCENE_MAKE_ROOM(scene->context, scene->look_bins, s->bins_capacity, wanted);
        result = result == STP_OK
                     ? STP_SCENE_MAKE_ROOM(scene->context, s->sources, s->source_capacity, wanted)
                     : result;
        if (result == STP_OK) {
            s->sources[s->count] = (bins_source){texture, kind};
            *known = s->count++;
        }
    }
    *place = *known;
    return result;
}

/// Asks for the bins of a look that are not found yet: at first all, then those of fewer steps if it
/// has too many variants.
static stp_result ask_look(look_search* s, stp_look* look, bool first)
{
    const stp_material* m = &s->scene->materials[look->material];
    bool glows = m->emissive[0] > 0.0f || m->emissive[1] > 0.0f || m->emissive[2] > 0.0f;
    stp_result result = STP_OK;
    if (!first) {
        bool many = stp_look_variants(s->scene, look) > STP_LOOK_VARIANTS;
        return many ? ask_bins(s, m->emissive_texture.texture, s->sources[look->glow].kind + 1,
                               &look->glow)
                    : STP_OK;
    }
    if (stp_scene_used_texture(s->scene, &m->metallic_roughness_texture) != NULL) {
        result =
            ask_bins(s, m->metallic_roughness_texture.texture, BINS_OF_SURFACE, &look->surface);
    }
    if (result == STP_OK && glows &&
        stp_scene_used_texture(s->scene, &m->emissive_texture) != NULL) {
        result = ask_bins(s, m->emissive_texture.texture, BINS_OF_GLOW, &look->glow);
    }
    return result;
}

static void read_run(const stp_texture* texture, const stp_texel_run* run, size_t index, void* user)
{
    const bins_reading* r = user;
    uint32_t kind = r->sources[run->source].kind;
    texel_table table;
    make_table(kind, &table);
    if (r->places[index] != STP_NONE) {
        add_texels(texture, run, &table, &r->sums[r->places[index]]);
    } else { // sums of all small textures would take more memory than their texels
        code_sums sums = {0};
        add_texels(texture, run, &table, &sums);
        find_bins(&sums, kind, &r->bins[run->source]);
    }
}

/// Finds the bins of textures that have no run or several.
static void join_runs(const bins_reading* r, const stp_texel_runs* runs, size_t count)
{
    size_t run = 0;
    for (size_t i = 0; i < count; ++i) {
        code_sums sums = {0};
        size_t first = run;
        for (; run < runs->count && runs->runs[run].source == i; ++run) {
            if (r->places[run] != STP_NONE) {
                add_sums(&sums, &r->sums[r->places[run]]);
            }
        }
        if (run == first || r->places[first] != STP_NONE) {
            find_bins(&sums, r->sources[i].kind, &r->bins[i]);
        }
    }
    assert(run == runs->count);
}

/// Gives each run of a texture with several a place for its sums. @return the places
static size_t place_runs(const stp_texel_runs* runs, uint32_t* places)
{
    size_t count = 0;
    for (size_t i = 0; i < runs->count; ++i) {
        bool after = i > 0 && runs->runs[i - 1].source == runs->runs[i].source;
        bool before = i + 1 < runs->count && runs->runs[i + 1].source == runs->runs[i].source;
        places[i] = after || before ? (uint32_t)count++ : STP_NONE;
    }
    return count;
}

/// Reads the runs of textures, and finds their bins.
static stp_result read_runs(look_search* s, const stp_texel_runs* runs)
{
    stp_context* context = s->scene->context;
    uint32_t* places = STP_NEW_ARRAY(context, uint32_t, runs->count + 1);
    if (places == NULL) {
        return stp_fail_memory(context);
    }
    bins_reading r = {
        .sources = s->sources + s->found, .bins = s->scene->look_bins + s->found, .places = places};
    r.sums = STP_NEW_ZEROED(context, code_sums, place_runs(runs, places) + 1);
    stp_result result = r.sums != NULL ? stp_texel_runs_read(s->scene, runs, "looks", read_run, &r)
                                       : stp_fail_memory(context);
    if (result == STP_OK) {
        join_runs(&r, runs, s->count - s->found);
        s->found = s->count;
    }
    stp_free(context, r.sums);
    stp_free(context, places);
    return result;
}

/// Reads the textures of the bins that are asked for, and finds these.
static stp_result read_asked(look_search* s)
{
    stp_context* context = s->scene->context;
    size_t count = s->count - s->found;
    stp_texel_runs runs = {0};
    uint32_t* textures = STP_NEW_ARRAY(context, uint32_t, count);
    stp_result result = textures != NULL ? STP_OK : stp_fail_memory(context);
    for (size_t i = 0; i < count && result == STP_OK; ++i) {
        textures[i] = s->sources[s->found + i].texture;
    }
    result = result == STP_OK ? stp_texel_runs_list(s->scene, textures, count, &runs) : result;
    result = result == STP_OK ? read_runs(s, &runs) : result;
    stp_texel_runs_destroy(s->scene, &runs);
    stp_free(context, textures);
    return result;
}

/// Finds the bins of all looks: in rounds, because fewer steps are tried only where needed.
static stp_result search_bins(look_search* s)
{
    stp_scene* scene = s->scene;
    stp_result result = STP_SCENE_MAKE_ROOM(scene->context, scene->look_bins, s->bins_capacity, 1);
    result = result == STP_OK
                 ? STP_SCENE_MAKE_ROOM(scene->context, s->sources, s->source_capacity, 1)
                 : result;
    if (result == STP_OK) { // one bin that changes nothing
        scene->look_bins[0] =
            (stp_look_bins){.count = 1, .values = {{1.0f, 1.0f, 1.0f}}, .steps = 1};
        s->count = s->found = 1;
    }
    for (uint32_t round = 0; round < BINS_KINDS - BINS_OF_GLOW && result == STP_OK; ++round) {
        for (uint32_t i = 0; i < scene->look_count && result == STP_OK; ++i) {
            result = ask_look(s, &scene->looks[i], round == 0);
        }
        if (result == STP_OK && s->found < s->count) {
            result = read_asked(s);
        }
    }
    return result;
}

static stp_result find_all_bins(stp_scene* scene)
{
    look_search s = {.scene = scene};
    s.places = STP_NEW_ZEROED(scene->context, uint32_t, BINS_KINDS * scene->texture_count + 1);
    stp_free(scene->context, scene->look_bins);
    scene->look_bins = NULL;
    stp_result result = s.places != NULL ? search_bins(&s) : stp_fail_memory(scene->context);
    stp_free(scene->context, s.places);
    stp_free(scene->context, s.sources);
    return result;
}

/// Lists the materials that may have looks and that triangles have.
static stp_result list_looks(stp_scene* scene)
{
    bool* used = STP_NEW_ZEROED(scene->context, bool, scene->material_count + 1);
    if (used == NULL) {
        return stp_fail_memory(scene->context);
    }
    stp_free(scene->context, scene->looks);
    scene->looks = NULL;
    scene->look_count = scene->variant_count = 0;
    size_t capacity = 0;
    stp_result result = STP_OK;
    for (size_t i = 0; i < scene->mesh_count; ++i) {
        used[scene->meshes[i].material] = true;
    }
    for (uint32_t i = 0; i < scene->material_count && result == STP_OK; ++i) {
        stp_material* m = &scene->materials[i];
        m->look = 0;
        bool textured = stp_scene_used_texture(scene, &m->metallic_roughness_texture) != NULL ||
                        stp_scene_used_texture(scene, &m->emissive_texture) != NULL;
        if (!used[i] || !textured || m->unlit) {
            continue;
        }
        result = STP_SCENE_MAKE_ROOM(scene->context, scene->looks, capacity,
                                     (size_t)scene->look_count + 1);
        if (result == STP_OK) {
            scene->looks[scene->look_count++] = (stp_look){.material = i};
            m->look = scene->look_count;
        }
    }
    stp_free(scene->context, used);
    return result;
}

stp_result stp_scene_find_looks(stp_scene* scene)
{
    stp_result result = list_looks(scene);
    result = result == STP_OK && scene->look_count > 0 ? find_all_bins(scene) : result;
    if (result != STP_OK) {
        return result;
    }
    for (uint32_t i = 0; i < scene->look_count; ++i) {
        stp_look* look = &scene->looks[i];
        uint32_t count = stp_look_variants(scene, look);
        assert(count <= STP_LOOK_VARIANTS);
        look->first_variant = scene->variant_count;
        if (count > 1) {
            scene->variant_count += count;
        } else { // the means say it all
            scene->materials[look->material].look = 0;
        }
    }
    return STP_OK;
}

uint32_t stp_look_surface_bin(const stp_look_bins* surface, float metal, float roughness)
{
    return surface->count > 1 ? surface->of_code[surface_code(metal, roughness)] : 0;
}

uint32_t stp_look_glow_bin(const stp_look_bins* glow, const float color[3])
{
    return glow->count > 1 ? glow->of_code[glow_code(color, glow->steps)] : 0;
}

/// The last look that begins at a variant or before: looks without variants come before it.
static const stp_look* look_of(const stp_scene* scene, uint32_t variant)
{
    uint32_t first = 0, end = scene->look_count;
    assert(variant < scene->variant_count && scene->looks[0].first_variant == 0);
    while (end - first > 1) {
        uint32_t middle = first + (end - first) / 2;
        bool before = scene->looks[middle].first_variant <= variant;
        first = before ? middle : first;
        end = before ? end : middle;
    }
    return &scene->looks[first];
}

stp_variant stp_scene_get_variant(const stp_scene* scene, uint32_t variant)
{
    const stp_look* look = look_of(scene, variant);
    const stp_look_bins *surfaces = stp_look_surface(scene, look),
                        *glows = stp_look_glow(scene, look);
    const stp_material* m = &scene->materials[look->material];
    uint32_t within = variant - look->first_variant;
    const float* surface = surfaces->values[within / glows->count];
    const float* glow = glows->values[within % glows->count];
    assert(within < surfaces->count * glows->count);
    return (stp_variant){
        .material = look->material,
        .metallic = m->metallic * surface[0],
        .roughness = m->roughness * surface[1],
        .emissive = {m->emissive[0] * glow[0], m->emissive[1] * glow[1], m->emissive[2] * glow[2]}};
}
