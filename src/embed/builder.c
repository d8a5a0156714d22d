// SPDX-License-Identifier: MIT
// Collects materials, objects and files; builder_parts.c collects meshes and points.
#include "embed/builder.h"

#include <assert.h>
#include <math.h>
#include <string.h>

/// A copy of a text, from stp_alloc; NULL if out of memory (not logged).
static char* copy_text(stp_context* context, const char* text)
{
    size_t size = strlen(text) + 1;
    char* copy = stp_alloc(context, size);
    return copy != NULL ? memcpy(copy, text, size) : NULL;
}

stp_result stp_builder_check(const stp_builder* builder, uint32_t material)
{
    if (builder == NULL) {
        return STP_ERROR_ARGUMENT;
    }
    if (builder->written) {
        return stp_fail(builder->context, STP_ERROR_ARGUMENT,
                        "stp_builder: already written; create another one");
    }
    assert(builder->staged->material_count > STP_BUILDER_MATERIAL);
    if (material >= builder->staged->material_count - STP_BUILDER_MATERIAL) {
        return stp_fail(builder->context, STP_ERROR_ARGUMENT,
                        "stp_builder: material %u was not added", material);
    }
    return STP_OK;
}

/// White and rough.
static stp_material plain_material(void)
{
    stp_material material = stp_material_default();
    material.metallic = 0.0f;
    material.roughness = 1.0f;
    return material;
}

static bool is_desc_valid(const stp_builder_desc* desc)
{
    return (desc->up == 0 || strchr("xXyYzZ", desc->up) != NULL) && isfinite(desc->unit_metres) &&
           desc->unit_metres >= 0.0;
}

static stp_result fill_builder(stp_builder* builder)
{
    stp_context* context = builder->context;
    const char* name = builder->desc.name != NULL ? builder->desc.name : "memory";
    builder->name = copy_text(context, name);
    builder->desc.name = NULL;
    if (builder->name == NULL) {
        return stp_fail_memory(context);
    }
    stp_result result = stp_scene_create(context, &builder->staged);
    stp_material material = plain_material();
    result = result == STP_OK ? stp_scene_add_material(builder->staged, &material, NULL) : result;
    assert((result != STP_OK || builder->staged->material_count == STP_BUILDER_MATERIAL + 1) &&
           "number 0 is the default material");
    return result;
}

stp_result stp_builder_create(stp_context* context, const stp_builder_desc* given,
                              stp_builder** builder)
{
    stp_builder_desc desc;
    if (context == NULL) {
        return STP_ERROR_ARGUMENT;
    }
    stp_result result = STP_CHECK_POINTER(context, builder);
    if (result != STP_OK) {
        return result;
    }
    *builder = NULL;
    result = STP_READ_DESC(context, stp_builder_desc, &desc, given);
    if (result != STP_OK) {
        return result;
    }
    if (!is_desc_valid(&desc)) {
        return stp_fail(context, STP_ERROR_ARGUMENT,
                        "stp_builder_desc: up is not an axis, or unit_metres is not a length");
    }
    stp_builder* made = STP_NEW_ZEROED(context, stp_builder, 1);
    if (made == NULL) {
        return stp_fail_memory(context);
    }
    made->context = context;
    made->desc = desc;
    result = fill_builder(made);
    if (result != STP_OK) {
        stp_builder_destroy(made);
        return result;
    }
    *builder = made;
    return STP_OK;
}

void stp_builder_destroy(stp_builder* builder)
{
    if (builder == NULL) {
        return;
    }
    stp_context* context = builder->context;
    for (size_t i = 0; i < builder->file_count; ++i) {
        stp_free(context, builder->files[i]);
    }
    stp_free(context, builder->files);
    stp_free(context, builder->parts);
    stp_free(context, builder->name);
    stp_free(context, builder->bytes);
    if (builder->staged != NULL) {
        stp_scene_destroy(builder->staged);
    }
    stp_free(context, builder);
}

stp_result stp_builder_add_file(stp_builder* builder, const char* path)
{
    static const char generated[] = "scene:"; // would not be recognized as a file
    stp_result result = STP_CHECK_CALL(builder, path);
    result = result == STP_OK ? stp_builder_check(builder, 0) : result;
    if (result != STP_OK) {
        return result;
    }
    stp_context* context = builder->context;
    bool room =
        STP_MAKE_ROOM(context, builder->files, builder->file_capacity, builder->file_count + 1);
    bool is_scene_name = strncmp(path, generated, sizeof(generated) - 1) == 0;
    size_t size = strlen(path) + 3;
    char* copy = room ? stp_alloc(context, size) : NULL;
    if (copy == NULL) {
        return stp_fail_memory(context);
    }
    copy[0] = '\0';
    strcat(strcat(copy, is_scene_name ? "./" : ""), path);
    builder->files[builder->file_count++] = copy;
    return STP_OK;
}

static bool are_finite(const float* values, size_t count)
{
    bool finite = true;
    for (size_t i = 0; i < count; ++i) {
        finite = finite && isfinite(values[i]) && values[i] >= 0.0f;
    }
    return finite;
}

static size_t row_stride(const stp_material_desc* desc)
{
    return desc->picture_stride != 0 ? desc->picture_stride : (size_t)desc->picture->width * 4;
}

static bool is_material_valid(const stp_material_desc* desc)
{
    const stp_image* picture = desc->picture;
    bool has_pixels =
        picture == NULL || (picture->pixels != NULL && picture->width > 0 && picture->height > 0 &&
                            picture->width <= 65536 && picture->height <= 65536 &&
                            row_stride(desc) >= (size_t)picture->width * 4);
    bool has_color = are_finite(desc->base_color, 4);
    for (int i = 0; i < 4; ++i) {
        has_color = has_color && desc->base_color[i] <= 1.0f;
    }
    return has_pixels && has_color && are_finite(desc->emissive, 3) &&
           are_finite(&desc->metallic, 1) && desc->metallic <= 1.0f &&
           are_finite(&desc->roughness, 1) && desc->roughness <= 1.0f &&
           are_finite(&desc->alpha_cutoff, 1);
}

static stp_result add_picture(stp_builder* builder, const stp_material_desc* desc,
                              stp_material* material)
{
    const stp_image* picture = desc->picture;
    size_t row = (size_t)picture->width * 4, size = row * picture->height;
    assert(row_stride(desc) >= row && size > 0 && "checked before");
    stp_texture texture = {.width = picture->width,
                           .height = picture->height,
                           .texels = stp_alloc(builder->context, size)};
    if (texture.texels == NULL) {
        return stp_fail_memory(builder->context);
    }
    for (uint32_t y = 0; y < picture->height; ++y) {
        memcpy(texture.texels + y * row, picture->pixels + y * row_stride(desc), row);
    }
    return stp_scene_add_texture(builder->staged, &texture, &material->base_color_texture.texture);
}

stp_result stp_builder_add_material(stp_builder* builder, const stp_material_desc* given,
                                    uint32_t* material)
{
    static const float none[4] = {0};
    stp_material_desc desc;
    stp_result result = stp_builder_check(builder, 0);
    result = result == STP_OK ? STP_CHECK_CALL(builder, material) : result;
    if (result == STP_OK) {
        result = STP_READ_DESC(builder->context, stp_material_desc, &desc, given);
    }
    if (result != STP_OK) {
        return result;
    }
    if (!is_material_valid(&desc)) {
        return stp_fail(builder->context, STP_ERROR_ARGUMENT,
                        "stp_material_desc: a value is out of range");
    }
    stp_material made = plain_material();
    made.name = desc.name;
    if (memcmp(desc.base_color, none, sizeof(none)) != 0) {
        memcpy(made.base_color, desc.base_color, sizeof(made.base_color));
    }
    made.metallic = desc.metallic;
    made.roughness = desc.roughness > 0.0f ? desc.roughness : 1.0f;
    memcpy(made.emissive, desc.emissive, sizeof(made.emissive));
    made.alpha_cutoff = desc.alpha_cutoff;
    made.alpha_mode = desc.alpha_cutoff > 0.0f ? STP_ALPHA_MASK
                      : desc.transparent       ? STP_ALPHA_BLEND
                                               : STP_ALPHA_OPAQUE;
    made.double_sided = desc.double_sided;
    made.unlit = desc.unlit;
    if (desc.picture != NULL) {
        result = add_picture(builder, &desc, &made);
    }
    uint32_t index = 0;
    result = result == STP_OK ? stp_scene_add_material(builder->staged, &made, &index) : result;
    if (result == STP_OK) {
        assert(index > STP_BUILDER_MATERIAL && "0 is the default material");
        *material = index - STP_BUILDER_MATERIAL;
    }
    return result;
}

static bool is_transform_finite(const stp_affine* transform)
{
    bool finite = true;
    for (int i = 0; i < 12; ++i) {
        finite = finite && isfinite(transform->m[i / 4][i % 4]);
    }
    return finite;
}

static stp_result check_transforms(const stp_builder* builder, const stp_object_desc* desc)
{
    if (desc->instance_count > 0 && desc->instances == NULL) {
        return stp_fail(builder->context, STP_ERROR_ARGUMENT, "stp_object_desc: no instances");
    }
    bool finite = is_transform_finite(&desc->transform);
    for (size_t i = 0; i < desc->instance_count && finite; ++i) {
        finite = is_transform_finite(&desc->instances[i]);
    }
    return finite ? STP_OK
                  : stp_fail(builder->context, STP_ERROR_ARGUMENT,
                             "stp_object_desc: a transform is not finite");
}

static stp_result check_object(const stp_builder* builder, const stp_object_desc* desc)
{
    if (desc->parent > builder->staged->object_count) {
        return stp_fail(builder->context, STP_ERROR_ARGUMENT,
                        "stp_object_desc: parent %u was not added", desc->parent);
    }
    for (size_t i = 0; i < desc->part_count; ++i) {
        if (desc->parts == NULL || desc->parts[i] == 0 || desc->parts[i] > builder->part_count) {
            return stp_fail(builder->context, STP_ERROR_ARGUMENT,
                            "stp_object_desc: part %zu was not added", i);
        }
    }
    return check_transforms(builder, desc);
}

stp_result stp_builder_add_object(stp_builder* builder, const stp_object_desc* given,
                                  uint32_t* object)
{
    static const stp_affine none = {0};
    stp_object_desc desc;
    stp_result result = stp_builder_check(builder, 0);
    if (result == STP_OK) {
        result = STP_READ_DESC(builder->context, stp_object_desc, &desc, given);
    }
    result = result == STP_OK ? check_object(builder, &desc) : result;
    if (result != STP_OK) {
        return result;
    }
    bool placed = memcmp(&desc.transform, &none, sizeof(none)) != 0;
    stp_object made = {.name = desc.name,
                       .id = desc.id,
                       .parent = desc.parent != 0 ? desc.parent - 1 : STP_NONE,
                       .transform = placed ? desc.transform : stp_affine_identity()};
    uint32_t index = 0;
    assert(made.parent == STP_NONE || made.parent < builder->staged->object_count);
    result = stp_scene_add_object(builder->staged, &made, &index);
    for (size_t i = 0; i < desc.part_count && result == STP_OK; ++i) {
        result = stp_scene_add_part(builder->staged, builder->parts[desc.parts[i] - 1]);
    }
    for (size_t i = 0; i < desc.instance_count && result == STP_OK; ++i) {
        result = stp_scene_add_instance(builder->staged, &desc.instances[i]);
    }
    if (result == STP_OK && object != NULL) {
        *object = index + 1;
    }
    return result;
}
