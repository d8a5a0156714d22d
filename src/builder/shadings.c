// SPDX-License-Identifier: MIT
#include "builder/shadings.h"

#include "base/io/hash.h"
#include "base/math/color.h"
#include "scene/looks.h"
#include "scene/texel_runs.h"

#include <assert.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>

// The mean of a texture's channels, as stored and linear.
typedef struct texture_mean {
    float raw[3], linear[3];
} texture_mean;

typedef struct reduction {
    const stp_scene* scene;
    texture_mean* means;    ///< by texture; of those that shadings need
    size_t count;           ///< materials, and then their variants (scene/looks.h)
    stp_shading* exact;     ///< shading of each
    bool *used, *of_points; ///< by material
    float* distance;        ///< from each material's shading to the nearest chosen one
} reduction;

/// Sums of a run of texels, as stored and linear.
typedef struct run_sums {
    double raw[3], linear[3];
} run_sums;

static void sum_texels(const stp_texture* texture, const stp_texel_run* run, size_t index,
                       void* user)
{
    run_sums* sums = (run_sums*)user + index;
    uint64_t counts[3][256] = {{0}};
    for (size_t k = run->begin; k < run->end; ++k) {
        for (int channel = 0; channel < 3; ++channel) {
            counts[channel][texture->texels[4 * k + (size_t)channel]] += 1;
        }
    }
    for (int channel = 0; channel < 3; ++channel) {
        for (int value = 0; value < 256; ++value) {
            double count = (double)counts[channel][value];
            sums->raw[channel] += count * value;
            sums->linear[channel] += count * (double)stp_srgb8_to_linear((uint8_t)value);
        }
    }
}

static void find_means(reduction* r, const uint32_t* textures, size_t count,
                       const stp_texel_runs* runs, const run_sums* of_runs)
{
    size_t run = 0;
    for (size_t k = 0; k < count; ++k) {
        size_t i = textures[k];
        const stp_texture* texture = &r->scene->textures[i];
        double size = (double)texture->width * texture->height;
        run_sums sums = {0};
        for (; run < runs->count && runs->runs[run].source == k; ++run) {
            for (int c = 0; c < 3; ++c) {
                sums.raw[c] += of_runs[run].raw[c];
                sums.linear[c] += of_runs[run].linear[c];
            }
        }
        for (int c = 0; c < 3; ++c) {
            r->means[i].raw[c] = size > 0.0 ? (float)(sums.raw[c] / (255.0 * size)) : 1.0f;
            r->means[i].linear[c] = size > 0.0 ? (float)(sums.linear[c] / size) : 1.0f;
        }
    }
    assert(run == runs->count);
}

/// Lists the textures whose means shadings have: not those of colours and normals. @return how many
static size_t list_textures(const reduction* r, uint32_t* textures)
{
    const stp_scene* scene = r->scene;
    size_t listed = 0;
    for (size_t i = 0; i < scene->material_count; ++i) {
        const stp_material* m = &scene->materials[i];
        const uint32_t used[] = {m->metallic_roughness_texture.texture,
                                 m->emissive_texture.texture};
        for (int k = 0; k < 2; ++k) {
            if (used[k] < scene->texture_count) {
                textures[used[k]] = 1; // marked
            }
        }
    }
    for (size_t i = 0; i < scene->texture_count; ++i) { // listed <= i
        if (textures[i] != 0) {
            textures[listed++] = (uint32_t)i;
        }
    }
    return listed;
}

static stp_result measure_textures(reduction* r)
{
    stp_context* context = r->scene->context;
    stp_texel_runs runs = {0};
    run_sums* sums = NULL;
    uint32_t* textures = STP_NEW_ZEROED(context, uint32_t, r->scene->texture_count + 1);
    if (textures == NULL) {
        return stp_fail_memory(context);
    }
    size_t count = list_textures(r, textures);
    stp_result result = stp_texel_runs_list(r->scene, textures, count, &runs);
    if (result == STP_OK) {
        sums = STP_NEW_ZEROED(context, run_sums, runs.count + 1);
        result = sums != NULL ? stp_texel_runs_read(r->scene, &runs, "materials", sum_texels, sums)
                              : stp_fail_memory(context);
    }
    if (result == STP_OK) {
        find_means(r, textures, count, &runs, sums);
    }
    stp_free(context, sums);
    stp_free(context, textures);
    stp_texel_runs_destroy(r->scene, &runs);
    return result;
}

static stp_shading make_shading(const reduction* r, const stp_material* material)
{
    stp_shading shading;
    memset(&shading, 0, sizeof(shading)); // compared as bytes
    shading.metallic = material->metallic;
    shading.roughness = material->roughness;
    memcpy(shading.emissive, material->emissive, sizeof(shading.emissive));
    uint32_t texture = material->metallic_roughness_texture.texture;
    if (texture < r->scene->texture_count) {
        shading.metallic *= r->means[texture].raw[2];
        shading.roughness *= r->means[texture].raw[1];
    }
    texture = material->emissive_texture.texture;
    for (int i = 0; i < 3 && texture < r->scene->texture_count; ++i) {
        shading.emissive[i] *= r->means[texture].linear[i];
    }
    shading.flags = (material->unlit ? STP_SHADING_UNLIT : 0u) |
                    (material->double_sided ? STP_SHADING_DOUBLE_SIDED : 0u) |
                    (material->front_only ? STP_SHADING_FRONT_ONLY : 0u) |
                    (material->alpha_mode == STP_ALPHA_BLEND ? STP_SHADING_TRANSPARENT : 0u);
    return shading;
}

/// The shading of a variant: with values of its own, in place of means.
static stp_shading make_variant(const reduction* r, uint32_t variant)
{
    stp_variant v = stp_scene_get_variant(r->scene, variant);
    stp_shading shading = r->exact[v.material];
    shading.metallic = v.metallic;
    shading.roughness = v.roughness;
    memcpy(shading.emissive, v.emissive, sizeof(shading.emissive));
    return shading;
}

static void mark_used(reduction* r)
{
    const stp_scene* scene = r->scene;
    for (size_t i = 0; i < scene->mesh_count; ++i) {
        assert(scene->meshes[i].material < scene->material_count);
        r->used[scene->meshes[i].material] = true;
    }
    for (size_t i = 0; i < scene->point_set_count; ++i) {
        assert(scene->point_sets[i].material < scene->material_count);
        r->used[scene->point_sets[i].material] = true;
        r->of_points[scene->point_sets[i].material] = true;
    }
    for (size_t i = scene->material_count; i < r->count; ++i) {
        r->used[i] = true; // triangles have its material
    }
}

// Flags weigh more than numbers up to 1, because they change the look most.
static float shading_distance(const stp_shading* a, const stp_shading* b)
{
    float sum = 0.0f;
    float numbers[2][5] = {
        {a->metallic, a->roughness, a->emissive[0], a->emissive[1], a->emissive[2]},
        {b->metallic, b->roughness, b->emissive[0], b->emissive[1], b->emissive[2]},
    };
    for (int i = 0; i < 5; ++i) {
        float difference = numbers[0][i] - numbers[1][i];
        sum += difference * difference;
    }
    uint32_t flags = a->flags ^ b->flags;
    sum += (flags & STP_SHADING_UNLIT) != 0 ? 16.0f : 0.0f;
    sum += (flags & STP_SHADING_TRANSPARENT) != 0 ? 16.0f : 0.0f;
    sum += (flags & STP_SHADING_FRONT_ONLY) != 0 ? 16.0f : 0.0f;
    return sum + ((flags & STP_SHADING_DOUBLE_SIDED) != 0 ? 4.0f : 0.0f);
}

// The shading of a used material, with one growth, to be placed in the table.
typedef struct shading_place {
    stp_hash hash;
    uint32_t material, growth;
    uint32_t place;
} shading_place;

// By hash; ties by material.
static int compare_places(const void* left, const void* right)
{
    const shading_place *a = left, *b = right;
    if (a->hash.low != b->hash.low) {
        return a->hash.low < b->hash.low ? -1 : 1;
    }
    if (a->hash.high != b->hash.high) {
        return a->hash.high < b->hash.high ? -1 : 1;
    }
    if (a->material != b->material) {
        return a->material < b->material ? -1 : 1;
    }
    return a->growth < b->growth ? -1 : a->growth > b->growth ? 1 : 0;
}

// Content of unused indices.
static stp_shading make_unused(void)
{
    stp_shading shading;
    memset(&shading, 0, sizeof(shading));
    shading.roughness = 1.0f;
    return shading;
}

static stp_shading with_growth(stp_shading shading, uint32_t growth)
{
    shading.growth = stp_growth_factor(growth) - 1.0f;
    return shading;
}

// What the table holds besides the shadings of materials.
typedef struct table_content {
    bool growths;  // where materials of points have them
    bool variants; // else each looks as the mean of its material
} table_content;

// Lists the shadings of all used materials, and what else the table holds.
static size_t list_places(const reduction* r, table_content content, shading_place* places)
{
    size_t used = 0, count = content.variants ? r->count : r->scene->material_count;
    for (size_t i = 0; i < count; ++i) {
        for (uint32_t s = 0; s < STP_GROWTHS && r->used[i]; ++s) {
            if (s != STP_GROWTH_PLAIN && !(content.growths && r->of_points[i])) {
                continue;
            }
            stp_shading shading = with_growth(r->exact[i], s);
            stp_hash hash = stp_hash_bytes((stp_hash){0}, &shading, offsetof(stp_shading, growth));
            if (s != STP_GROWTH_PLAIN) {
                hash = stp_hash_bytes(hash, &shading.growth, sizeof(shading.growth));
            }
            places[used++] = (shading_place){.hash = hash, .material = (uint32_t)i, .growth = s};
        }
    }
    return used;
}

// Says for each shading which ones differ only in the growth.
static void link_growths(const shading_place* places, size_t count, stp_shading_set* set)
{
    for (uint32_t i = 0; i < STP_SHADING_LIMIT; ++i) {
        memset(set->growths.of[i], (int)i, STP_GROWTHS);
        set->growths.plain[i] = (uint8_t)i;
    }
    for (size_t i = 0; i < count; ++i) {
        uint8_t plain = set->of_material[places[i].material];
        set->growths.of[plain][places[i].growth] = (uint8_t)places[i].place;
        set->growths.plain[places[i].place] = plain;
        set->has_growths = set->has_growths || places[i].growth != STP_GROWTH_PLAIN;
    }
}

// Gives every shading its own index: the one its hash names, or the next free one, in the order of
// their hashes. So splats of a previous build stay valid when other materials are added or
// removed, except for the few whose indices collide. @return false if there are too many
static bool place_shadings(const reduction* r, table_content content, shading_place* places,
                           stp_shading_set* set)
{
    size_t used = list_places(r, content, places);
    qsort(places, used, sizeof(*places), compare_places);
    bool taken[STP_SHADING_LIMIT] = {false};
    size_t distinct = 0;
    for (size_t i = 0; i < used; ++i) {
        assert((i == 0 || compare_places(&places[i - 1], &places[i]) < 0) &&
               "the order is total: indices depend on content only");
        if (i > 0 && stp_hash_equal(places[i].hash, places[i - 1].hash)) {
            places[i].place = places[i - 1].place;
            continue;
        }
        if (++distinct > STP_SHADING_LIMIT) {
            return false;
        }
        uint32_t place = (uint32_t)(places[i].hash.high % STP_SHADING_LIMIT);
        while (taken[place]) {
            place = (place + 1) % STP_SHADING_LIMIT;
        }
        taken[place] = true;
        places[i].place = place;
    }
    for (int i = 0; i < STP_SHADING_LIMIT; ++i) {
        set->shadings[i] = make_unused();
    }
    set->count = 1;
    for (size_t i = 0; i < used; ++i) {
        uint32_t place = places[i].place;
        set->shadings[place] = with_growth(r->exact[places[i].material], places[i].growth);
        if (places[i].growth == STP_GROWTH_PLAIN) {
            set->of_material[places[i].material] = (uint8_t)place;
        }
        set->count = place + 1 > set->count ? place + 1 : set->count;
    }
    assert(set->count >= 1 && set->count <= STP_SHADING_LIMIT);
    for (uint32_t i = 0; i < r->scene->variant_count && !content.variants; ++i) {
        set->of_material[r->scene->material_count + i] =
            set->of_material[stp_scene_get_variant(r->scene, i).material];
    }
    link_growths(places, used, set);
    return true;
}

// Places as much as fits: growths close holes, which are seen more than the variants of a material.
// @return false if the materials and their variants are too many
static bool place_most(const reduction* r, bool with_growths, shading_place* places,
                       stp_shading_set* set)
{
    bool grow = false;
    for (size_t i = 0; i < r->count; ++i) {
        grow = grow || (with_growths && r->of_points[i]);
    }
    const table_content contents[] = {{true, true}, {true, false}, {false, true}};
    bool placed = false;
    for (size_t i = grow ? 0 : 2; i < 3 && !placed; ++i) {
        placed = place_shadings(r, contents[i], places, set);
    }
    return placed;
}

// Farthest-point selection: repeatedly takes the shading farthest from those taken (the first of
// several), until all are covered or the table is full.
static void choose_shadings(reduction* r, stp_shading_set* set)
{
    size_t count = r->count, next = 0;
    assert(count > STP_SHADING_LIMIT && "fewer shadings have exact places");
    set->count = 0;
    while (next < count && !r->used[next]) {
        next += 1;
    }
    next = next < count ? next : 0;
    for (size_t i = 0; i < count; ++i) {
        r->distance[i] = r->used[i] ? FLT_MAX : -1.0f;
    }
    while (set->count < STP_SHADING_LIMIT) {
        uint8_t index = (uint8_t)set->count;
        set->shadings[set->count++] = r->exact[next];
        size_t farthest = next;
        float maximum = 0.0f;
        for (size_t i = 0; i < count; ++i) {
            float distance = shading_distance(&r->exact[i], &r->exact[next]);
            if (distance < r->distance[i]) {
                r->distance[i] = distance;
                set->of_material[i] = index;
            }
            if (r->distance[i] > maximum) {
                maximum = r->distance[i];
                farthest = i;
            }
        }
        if (farthest == next) {
            break;
        }
        next = farthest;
    }
}

static void fill_set(reduction* r, bool with_growths, shading_place* places, stp_shading_set* set)
{
    const stp_scene* scene = r->scene;
    for (size_t i = 0; i < scene->material_count; ++i) {
        r->exact[i] = make_shading(r, &scene->materials[i]);
    }
    for (uint32_t i = 0; i < scene->variant_count; ++i) {
        r->exact[scene->material_count + i] = make_variant(r, i);
    }
    mark_used(r);
    if (!place_most(r, with_growths, places, set)) {
        choose_shadings(r, set);
    }
}

stp_result stp_make_shadings(const stp_scene* scene, bool with_growths, stp_shading_set* set)
{
    stp_context* context = scene->context;
    size_t count = scene->material_count + scene->variant_count;
    *set = (stp_shading_set){0};
    reduction r = {.scene = scene, .count = count};
    r.means = STP_NEW_ARRAY(context, texture_mean, scene->texture_count);
    r.exact = STP_NEW_ARRAY(context, stp_shading, count);
    r.used = STP_NEW_ZEROED(context, bool, count);
    r.of_points = STP_NEW_ZEROED(context, bool, count);
    r.distance = STP_NEW_ARRAY(context, float, count);
    set->of_material = STP_NEW_ZEROED(context, uint8_t, count);
    shading_place* places = STP_NEW_ARRAY(context, shading_place, STP_GROWTHS * count);
    bool made = places != NULL && r.means != NULL && r.exact != NULL && r.used != NULL &&
                r.of_points != NULL && r.distance != NULL && set->of_material != NULL;
    stp_result result = made ? measure_textures(&r) : stp_fail_memory(context);
    if (result == STP_OK) {
        fill_set(&r, with_growths, places, set);
    } else {
        stp_free(context, set->of_material);
        set->of_material = NULL;
    }
    stp_free(context, places);
    stp_free(context, r.distance);
    stp_free(context, r.of_points);
    stp_free(context, r.used);
    stp_free(context, r.exact);
    stp_free(context, r.means);
    return result;
}
