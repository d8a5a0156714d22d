// SPDX-License-Identifier: MIT
// Materials (3.9), with unlit, emissive strength, texture transforms and, for old files,
// specular-glossiness.
#include "import/gltf/gltf.h"
#include "import/gltf/gltf_primitive.h"

#include <assert.h>
#include <math.h>
#include <string.h>

typedef struct pending_material {
    stp_material material; ///< its textures are numbers of requests until they are loaded
    stp_gltf_material slots;
} pending_material;

typedef struct material_reader {
    stp_gltf_scope* scope;
    stp_gltf_textures* textures;
    pending_material* pending;
} material_reader;

// Sine and cosine from the series after halving the angle four times: the C library's results
// differ between machines.
static void rotate(double angle, double* sine, double* cosine)
{
    double turns = angle / (2.0 * STP_PI);
    turns = turns < -1e9 || turns > 1e9 ? 0.0 : turns - (double)(int64_t)turns;
    double x = turns * 2.0 * STP_PI / 16.0; // below 0.4: the terms soon pass the last bit
    assert(x > -0.4 && x < 0.4);
    double s = 0.0, c = 0.0, term = 1.0;
    for (int n = 0; n < 16; ++n) {
        double signed_term = (n / 2) % 2 == 0 ? term : -term;
        *(n % 2 == 0 ? &c : &s) += signed_term;
        term *= x / (double)(n + 1);
    }
    for (int i = 0; i < 4; ++i) {
        double doubled = 2.0 * s * c;
        c = c * c - s * s;
        s = doubled;
    }
    assert(s * s + c * c > 0.999999 && s * s + c * c < 1.000001);
    *sine = s;
    *cosine = c;
}

// KHR_texture_transform: uv' = translation * rotation * scale * uv. The rotation is
// counter-clockwise to the eye, with v down: the extension's example of the lower left quadrant
// fixes the sign.
static stp_result read_transform(stp_gltf_scope* scope, const json_t* info, stp_texture_use* use,
                                 size_t* texcoord)
{
    const json_t* json;
    stp_result result = stp_gltf_extension(scope, info, "KHR_texture_transform", &json);
    double offset[2] = {0, 0}, scale[2] = {1, 1}, rotation = 0.0, sine, cosine;
    if (result == STP_OK) {
        result = stp_gltf_numbers(scope, json, "offset", 2, offset);
    }
    if (result == STP_OK) {
        result = stp_gltf_numbers(scope, json, "scale", 2, scale);
    }
    if (result == STP_OK) {
        result = stp_gltf_number(scope, json, "rotation", &rotation);
    }
    if (result == STP_OK) {
        result = stp_gltf_size(scope, json, "texCoord", texcoord);
    }
    if (result != STP_OK || json == NULL) {
        return result;
    }
    rotate(rotation, &sine, &cosine);
    const double matrix[2][3] = {{cosine * scale[0], sine * scale[1], offset[0]},
                                 {-sine * scale[0], cosine * scale[1], offset[1]}};
    for (int r = 0; r < 2; ++r) {
        for (int c = 0; c < 3; ++c) {
            use->transform[r][c] = (float)matrix[r][c];
        }
    }
    return STP_OK;
}

// The set of a mesh that TEXCOORD_n goes into, adding one if needed; false if no set is free.
static bool find_slot(stp_gltf_material* slots, size_t texcoord, uint32_t* slot)
{
    assert(slots->set_count <= STP_GLTF_TEXCOORD_SETS);
    for (uint32_t i = 0; i < slots->set_count; ++i) {
        if (slots->sets[i] == texcoord) {
            *slot = i;
            return true;
        }
    }
    if (slots->set_count == STP_GLTF_TEXCOORD_SETS || texcoord >= STP_NONE) {
        return false;
    }
    *slot = slots->set_count;
    slots->sets[slots->set_count++] = (uint32_t)texcoord;
    return true;
}

static stp_result read_texture(material_reader* reader, const json_t* material, const char* key,
                               stp_texture_use* use)
{
    stp_gltf_scope* scope = reader->scope;
    const json_t* info;
    uint32_t texture = STP_NONE;
    size_t texcoord = 0;
    *use = stp_texture_use_none();
    stp_result result = stp_gltf_object(scope, material, key, &info);
    if (result == STP_OK) {
        result = stp_gltf_index(scope, info, "index", STP_GLTF_TEXTURES, &texture);
    }
    if (result == STP_OK) {
        result = stp_gltf_size(scope, info, "texCoord", &texcoord);
    }
    if (result == STP_OK) {
        result = read_transform(scope, info, use, &texcoord);
    }
    if (result != STP_OK || texture == STP_NONE) {
        return result;
    }
    if (!find_slot(&reader->pending->slots, texcoord, &use->texcoord)) {
        stp_gltf_warn(scope, "%s is left out: the material uses more than %d texture coordinates",
                      key, STP_GLTF_TEXCOORD_SETS);
        return STP_OK;
    }
    return stp_gltf_textures_want(scope, reader->textures, texture, &use->texture);
}

static stp_result read_factor(stp_gltf_scope* scope, const json_t* json, const char* key,
                              float* factor)
{
    double value = (double)*factor;
    stp_result result = stp_gltf_number(scope, json, key, &value);
    *factor = (float)(value < 0.0 ? 0.0 : value > 1.0 ? 1.0 : value);
    return result;
}

static stp_result read_factors(stp_gltf_scope* scope, const json_t* json, const char* key,
                               size_t count, float* factors)
{
    double values[4];
    assert(count <= sizeof(values) / sizeof(values[0]));
    for (size_t i = 0; i < count; ++i) {
        values[i] = (double)factors[i];
    }
    stp_result result = stp_gltf_numbers(scope, json, key, count, values);
    for (size_t i = 0; i < count; ++i) {
        factors[i] = (float)(values[i] < 0.0 ? 0.0 : values[i] > 1.0 ? 1.0 : values[i]);
    }
    return result;
}

static stp_result read_metallic_roughness(material_reader* reader, const json_t* material)
{
    stp_gltf_scope* scope = reader->scope;
    stp_material* out = &reader->pending->material;
    const json_t* json;
    stp_result result = stp_gltf_object(scope, material, "pbrMetallicRoughness", &json);
    if (result == STP_OK) {
        result = read_factors(scope, json, "baseColorFactor", 4, out->base_color);
    }
    if (result == STP_OK) {
        result = read_factor(scope, json, "metallicFactor", &out->metallic);
    }
    if (result == STP_OK) {
        result = read_factor(scope, json, "roughnessFactor", &out->roughness);
    }
    if (result == STP_OK) {
        result = read_texture(reader, json, "baseColorTexture", &out->base_color_texture);
    }
    return result == STP_OK ? read_texture(reader, json, "metallicRoughnessTexture",
                                           &out->metallic_roughness_texture)
                            : result;
}

// KHR_materials_pbrSpecularGlossiness: uses its diffuse part as a dielectric, which suits most such
// files.
static stp_result read_specular_glossiness(material_reader* reader, const json_t* material)
{
    stp_gltf_scope* scope = reader->scope;
    stp_material* out = &reader->pending->material;
    const json_t* json;
    stp_result result =
        stp_gltf_extension(scope, material, "KHR_materials_pbrSpecularGlossiness", &json);
    if (result != STP_OK || json == NULL ||
        json_object_get(material, "pbrMetallicRoughness") != NULL) {
        return result;
    }
    float glossiness = 1.0f;
    result = read_factors(scope, json, "diffuseFactor", 4, out->base_color);
    if (result == STP_OK) {
        result = read_factor(scope, json, "glossinessFactor", &glossiness);
    }
    if (result == STP_OK) {
        result = read_texture(reader, json, "diffuseTexture", &out->base_color_texture);
    }
    out->metallic = 0.0f;
    out->roughness = 1.0f - glossiness;
    return result;
}

static stp_result read_emissive(material_reader* reader, const json_t* material)
{
    stp_gltf_scope* scope = reader->scope;
    stp_material* out = &reader->pending->material;
    const json_t* json;
    double strength = 1.0;
    stp_result result = read_factors(scope, material, "emissiveFactor", 3, out->emissive);
    if (result == STP_OK) {
        result = stp_gltf_extension(scope, material, "KHR_materials_emissive_strength", &json);
    }
    if (result == STP_OK) {
        result = stp_gltf_number(scope, json, "emissiveStrength", &strength);
    }
    if (result != STP_OK) {
        return result;
    }
    if (strength < 0.0 || strength > 1e6) {
        stp_gltf_warn(scope, "emissiveStrength %g is out of range: uses 1", strength);
        strength = 1.0;
    }
    for (int c = 0; c < 3; ++c) {
        out->emissive[c] *= (float)strength;
    }
    return read_texture(reader, material, "emissiveTexture", &out->emissive_texture);
}

// A map that would change nothing is left out, with its picture.
static stp_result read_normal_map(material_reader* reader, const json_t* material)
{
    stp_gltf_scope* scope = reader->scope;
    stp_material* out = &reader->pending->material;
    const json_t* info;
    double scale = 1.0;
    stp_result result = stp_gltf_object(scope, material, "normalTexture", &info);
    if (result == STP_OK) {
        result = stp_gltf_number(scope, info, "scale", &scale);
    }
    if (result == STP_OK && !(fabs(scale) <= 1e3)) {
        stp_gltf_warn(scope, "the scale %g of its normal map is out of range: uses 1", scale);
        scale = 1.0;
    }
    out->normal_scale = (float)scale;
    return result == STP_OK && !out->unlit && out->normal_scale != 0.0f
               ? read_texture(reader, material, "normalTexture", &out->normal_texture)
               : result;
}

static stp_result read_material(material_reader* reader, const json_t* json)
{
    stp_gltf_scope* scope = reader->scope;
    stp_material* out = &reader->pending->material;
    const json_t* unlit;
    double cutoff = 0.5;
    *out = stp_material_default();
    out->name = stp_gltf_text(json, "name");
    out->double_sided = stp_gltf_flag(json, "doubleSided");
    out->front_only = !out->double_sided;
    const char* mode = stp_gltf_text(json, "alphaMode");
    out->alpha_mode = mode != NULL && strcmp(mode, "MASK") == 0    ? STP_ALPHA_MASK
                      : mode != NULL && strcmp(mode, "BLEND") == 0 ? STP_ALPHA_BLEND
                                                                   : STP_ALPHA_OPAQUE;
    stp_result result = stp_gltf_number(scope, json, "alphaCutoff", &cutoff);
    if (result == STP_OK) {
        result = stp_gltf_extension(scope, json, "KHR_materials_unlit", &unlit);
    }
    if (result == STP_OK) {
        out->alpha_cutoff = (float)cutoff;
        out->unlit = unlit != NULL;
        result = read_metallic_roughness(reader, json);
    }
    if (result == STP_OK) {
        result = read_specular_glossiness(reader, json);
    }
    if (result == STP_OK) {
        result = read_emissive(reader, json);
    }
    // last: if there are too many sets of texture coordinates, colours keep theirs
    return result == STP_OK ? read_normal_map(reader, json) : result;
}

static stp_result add_materials(stp_gltf_scope* scope, const stp_gltf_textures* textures,
                                pending_material* pending, stp_gltf* gltf)
{
    stp_scene* scene = gltf->import->scene;
    gltf->first_material = (uint32_t)scene->material_count;
    for (size_t i = 0; i < stp_gltf_count(gltf, STP_GLTF_MATERIALS); ++i) {
        stp_material* material = &pending[i].material;
        stp_texture_use* uses[] = {&material->base_color_texture,
                                   &material->metallic_roughness_texture,
                                   &material->emissive_texture, &material->normal_texture};
        for (int k = 0; k < 4; ++k) {
            uses[k]->texture = stp_gltf_textures_get(textures, uses[k]->texture);
        }
        gltf->materials[i] = pending[i].slots;
        stp_result result = stp_gltf_logged(scope, stp_scene_add_material(scene, material, NULL));
        assert(result != STP_OK || scene->material_count == gltf->first_material + i + 1);
        if (result != STP_OK) {
            return result;
        }
    }
    return STP_OK;
}

// Draws both sides of materials that points have, which have no sides. @return whether triangles
// have no material
static bool look_at_primitive(const json_t* primitive, stp_material* materials, size_t count)
{
    const json_t *mode = json_object_get(primitive, "mode"),
                 *material = json_object_get(primitive, "material");
    json_int_t kind =
        json_is_integer(mode) ? json_integer_value(mode) : (json_int_t)STP_GLTF_TRIANGLES;
    json_int_t index = json_is_integer(material) ? json_integer_value(material) : -1;
    if (kind == (json_int_t)STP_GLTF_POINTS && index >= 0 && index < (json_int_t)count) {
        materials[index].front_only = false;
    }
    return kind >= (json_int_t)STP_GLTF_TRIANGLES && material == NULL;
}

// Decides which materials are drawn from the front only. Adds the default material (3.9.6), which
// is single-sided, if triangles have it.
static stp_result settle_sides(stp_gltf_scope* scope, stp_gltf* gltf)
{
    stp_scene* scene = gltf->import->scene;
    stp_material* materials = scene->materials + gltf->first_material;
    size_t count = scene->material_count - gltf->first_material;
    bool lacking = false;
    for (size_t i = 0; i < stp_gltf_count(gltf, STP_GLTF_MESHES); ++i) {
        const json_t* mesh = json_array_get(gltf->lists[STP_GLTF_MESHES], i);
        const json_t* primitives = json_object_get(mesh, "primitives");
        for (size_t k = 0; k < json_array_size(primitives); ++k) {
            bool lacks = look_at_primitive(json_array_get(primitives, k), materials, count);
            lacking = lacking || lacks;
        }
    }
    stp_material added = stp_material_default();
    added.front_only = true;
    return lacking ? stp_gltf_logged(scope,
                                     stp_scene_add_material(scene, &added, &gltf->default_material))
                   : STP_OK;
}

static stp_result read_materials(stp_gltf_scope* scope, stp_gltf_textures* textures,
                                 pending_material* pending, stp_gltf* gltf)
{
    material_reader reader = {.textures = textures};
    for (size_t i = 0; i < stp_gltf_count(gltf, STP_GLTF_MATERIALS); ++i) {
        stp_gltf_scope own = stp_gltf_scope_begin(gltf); // so that each material has its warning
        const json_t* json;
        stp_gltf_set_place(&own, "materials[%zu]", i);
        reader.scope = &own;
        reader.pending = &pending[i];
        stp_result result = stp_gltf_item(&own, STP_GLTF_MATERIALS, i, &json);
        if (result == STP_OK) {
            result = read_material(&reader, json);
        }
        if (stp_gltf_scope_end(&own, result) != STP_OK) {
            return stp_gltf_logged(scope, result);
        }
    }
    stp_result result = stp_gltf_textures_load(scope, textures, gltf);
    result = result == STP_OK ? add_materials(scope, textures, pending, gltf) : result;
    return result == STP_OK ? settle_sides(scope, gltf) : result;
}

stp_result stp_gltf_load_materials(stp_gltf_scope* scope, stp_gltf* gltf)
{
    size_t count = stp_gltf_count(gltf, STP_GLTF_MATERIALS);
    stp_gltf_textures* textures = NULL;
    pending_material* pending = STP_NEW_ZEROED(gltf->context, pending_material, count);
    gltf->materials = STP_NEW_ZEROED(gltf->context, stp_gltf_material, count);
    stp_result result = STP_ERROR_OUT_OF_MEMORY;
    if (pending != NULL && gltf->materials != NULL) {
        result = stp_gltf_textures_create(scope, &textures);
    }
    if (result == STP_OK) {
        result = read_materials(scope, textures, pending, gltf);
    }
    stp_gltf_textures_destroy(textures, gltf);
    stp_free(gltf->context, pending);
    return result;
}
