// SPDX-License-Identifier: MIT
#include "store/file/records.h"

#include "base/io/bytes.h"

#include <stipple/view.h>

#include <assert.h>

static void note_fault(stp_store_codec* codec, const char* fault)
{
    codec->fault = codec->fault != NULL ? codec->fault : fault;
}

static void code_u32(stp_store_codec* codec, uint32_t* value)
{
    if (codec->input != NULL) {
        *value = stp_read_u32(codec->input + codec->offset);
    } else {
        stp_write_u32(codec->output + codec->offset, *value);
    }
    codec->offset += 4;
}

static void code_u64(stp_store_codec* codec, uint64_t* value)
{
    if (codec->input != NULL) {
        *value = stp_read_u64(codec->input + codec->offset);
    } else {
        stp_write_u64(codec->output + codec->offset, *value);
    }
    codec->offset += 8;
}

static void code_f32(stp_store_codec* codec, float* value)
{
    if (codec->input != NULL) {
        *value = stp_read_f32(codec->input + codec->offset);
    } else {
        stp_write_f32(codec->output + codec->offset, *value);
    }
    codec->offset += 4;
    if (!isfinite(*value)) {
        note_fault(codec, "has a number that is not finite");
    }
}

static void code_f64(stp_store_codec* codec, double* value)
{
    if (codec->input != NULL) {
        *value = stp_read_f64(codec->input + codec->offset);
    } else {
        stp_write_f64(codec->output + codec->offset, *value);
    }
    codec->offset += 8;
    if (!isfinite(*value)) {
        note_fault(codec, "has a number that is not finite");
    }
}

static void code_reserved(stp_store_codec* codec)
{
    uint32_t value = 0;
    code_u32(codec, &value);
    if (value != 0) {
        note_fault(codec, "has a reserved field that is not zero");
    }
}

static uint32_t add_text(stp_store_codec* codec, const char* text)
{
    stp_store_text* pool = codec->text;
    size_t length = strlen(text) + 1;
    if (length > STP_STORE_TEXT_LIMIT + 1) {
        note_fault(codec, "has a text of more than 4095 bytes");
        return STP_STORE_NONE;
    }
    if (length > STP_STORE_NONE - pool->size) {
        note_fault(codec, "has a text beyond the limit of 4 GiB in all");
        return STP_STORE_NONE;
    }
    if (pool->capacity - pool->size < length) {
        if (!STP_MAKE_ROOM(pool->context, pool->bytes, pool->capacity, pool->size + length)) {
            codec->result = STP_ERROR_OUT_OF_MEMORY;
            return STP_STORE_NONE;
        }
    }
    assert(length <= pool->capacity - pool->size && pool->size + length <= STP_STORE_NONE);
    uint32_t offset = (uint32_t)pool->size;
    memcpy(pool->bytes + offset, text, length);
    pool->size += length;
    return offset;
}

static void code_text(stp_store_codec* codec, const char** text)
{
    uint32_t offset = STP_STORE_NONE;
    if (codec->input == NULL && *text != NULL) {
        offset = add_text(codec, *text);
    }
    code_u32(codec, &offset);
    if (codec->input != NULL) {
        *text = NULL;
        if (offset < codec->text->size) {
            *text = codec->text->stored + offset;
            // else the caller checks it (stp_store_verify_text)
            const char* fault =
                codec->text->checked ? stp_store_use_text(codec->text, *text) : NULL;
            if (fault != NULL) {
                note_fault(codec, fault);
            }
        } else if (offset != STP_STORE_NONE) {
            note_fault(codec, "has a text that lies outside the section of texts");
        }
    }
}

static void code_affine(stp_store_codec* codec, stp_affine* transform)
{
    for (int i = 0; i < 12; ++i) {
        code_f64(codec, &transform->m[i / 4][i % 4]);
    }
}

static void code_vec3(stp_store_codec* codec, stp_vec3* v)
{
    code_f32(codec, &v->x);
    code_f32(codec, &v->y);
    code_f32(codec, &v->z);
}

static void code_vec3d(stp_store_codec* codec, stp_vec3d* v)
{
    code_f64(codec, &v->x);
    code_f64(codec, &v->y);
    code_f64(codec, &v->z);
}

static void code_node(stp_store_codec* codec, void* element)
{
    stp_store_node* node = element;
    code_u32(codec, &node->first_edge);
    code_u32(codec, &node->edge_count);
    code_u32(codec, &node->first_part);
    code_u32(codec, &node->part_count);
    code_u32(codec, &node->set);
    code_u32(codec, &node->flags);
    code_u64(codec, &node->triangle_count);
    code_u64(codec, &node->point_count);
    code_vec3d(codec, &node->bounds.min);
    code_vec3d(codec, &node->bounds.max);
}

static void code_edge(stp_store_codec* codec, void* element)
{
    stp_store_edge* edge = element;
    code_u32(codec, &edge->node);
    code_reserved(codec);
    code_affine(codec, &edge->transform);
}

static void code_part(stp_store_codec* codec, void* element)
{
    stp_store_part* part = element;
    uint32_t kind = (uint32_t)part->kind;
    code_u32(codec, &kind);
    part->kind = (stp_store_part_kind)kind;
    code_u32(codec, &part->index);
}

static void code_texture_use(stp_store_codec* codec, stp_store_texture_use* use)
{
    code_u32(codec, &use->texture);
    code_u32(codec, &use->texcoord);
    for (int i = 0; i < 6; ++i) {
        code_f32(codec, &use->transform[i / 3][i % 3]);
    }
}

/// Flags of a material or shading. STP_SHADING_FRONT_ONLY has a section of its own.
static void code_look_flags(stp_store_codec* codec, uint32_t* flags)
{
    uint32_t stored = *flags & ~(uint32_t)STP_SHADING_FRONT_ONLY;
    code_u32(codec, &stored);
    if (codec->input != NULL) {
        *flags = stored;
        if ((stored & STP_SHADING_FRONT_ONLY) != 0) {
            note_fault(codec, "has flags that are not defined in this version");
        }
    }
}

static void code_material(stp_store_codec* codec, void* element)
{
    stp_store_material* material = element;
    uint32_t alpha = (uint32_t)material->alpha;
    code_text(codec, &material->name);
    code_look_flags(codec, &material->flags);
    code_u32(codec, &alpha);
    material->alpha = (stp_store_alpha)alpha;
    code_f32(codec, &material->alpha_cutoff);
    for (int i = 0; i < 4; ++i) {
        code_f32(codec, &material->base_color[i]);
    }
    code_f32(codec, &material->metallic);
    code_f32(codec, &material->roughness);
    for (int i = 0; i < 3; ++i) {
        code_f32(codec, &material->emissive[i]);
    }
    code_reserved(codec);
    code_texture_use(codec, &material->base_color_texture);
    code_texture_use(codec, &material->metallic_roughness_texture);
    code_texture_use(codec, &material->emissive_texture);
}

static void code_shading(stp_store_codec* codec, void* element)
{
    stp_shading* shading = element;
    code_f32(codec, &shading->metallic);
    code_f32(codec, &shading->roughness);
    for (int i = 0; i < 3; ++i) {
        code_f32(codec, &shading->emissive[i]);
    }
    code_look_flags(codec, &shading->flags);
}

static void code_texture(stp_store_codec* codec, void* element)
{
    stp_store_texture_record* record = element;
    code_u32(codec, &record->texture.width);
    code_u32(codec, &record->texture.height);
    code_u32(codec, &record->texture.wrap_u);
    code_u32(codec, &record->texture.wrap_v);
    code_u32(codec, &record->texture.nearest);
    code_u32(codec, &record->block);
}

static void code_mesh(stp_store_codec* codec, void* element)
{
    stp_store_mesh_record* record = element;
    code_text(codec, &record->mesh.name);
    code_u32(codec, &record->mesh.vertex_count);
    code_u32(codec, &record->mesh.triangle_count);
    code_u32(codec, &record->mesh.material);
    code_u32(codec, &record->present);
    code_u32(codec, &record->block);
    code_vec3(codec, &record->mesh.bounds.min);
    code_vec3(codec, &record->mesh.bounds.max);
}

static void code_points(stp_store_codec* codec, void* element)
{
    stp_store_point_record* record = element;
    code_text(codec, &record->points.name);
    code_u32(codec, &record->points.point_count);
    code_u32(codec, &record->points.material);
    code_u32(codec, &record->present);
    code_u32(codec, &record->block);
    code_u32(codec, &record->points.held_by);
    code_vec3(codec, &record->points.bounds.min);
    code_vec3(codec, &record->points.bounds.max);
}

static void code_splat_set(stp_store_codec* codec, void* element)
{
    stp_store_set_record* record = element;
    code_u32(codec, &record->splats.count);
    code_u32(codec, &record->splats.octave_count);
    code_u32(codec, &record->first_octave);
    code_u32(codec, &record->splats.table.size);
    code_u32(codec, &record->first_breakpoint);
    code_u32(codec, &record->splats.paper_count);
    code_vec3(codec, &record->splats.origin);
    code_f32(codec, &record->splats.step);
    code_f32(codec, &record->splats.candidate_radius);
    code_f32(codec, &record->splats.paper_radius);
}

static void code_octave(stp_store_codec* codec, void* element)
{
    stp_store_octave* octave = element;
    code_u32(codec, &octave->end);
    code_u32(codec, &octave->block);
}

static void code_breakpoint(stp_store_codec* codec, void* element)
{
    stp_store_breakpoint* breakpoint = element;
    code_u32(codec, &breakpoint->count);
    code_f32(codec, &breakpoint->radius);
}

static void code_view(stp_store_codec* codec, void* element)
{
    stp_store_view* view = element;
    code_text(codec, &view->name);
    code_reserved(codec);
    code_vec3d(codec, &view->eye);
    code_vec3d(codec, &view->target);
    code_vec3d(codec, &view->up);
    code_f64(codec, &view->fov_degrees);
    if (!(view->fov_degrees >= STP_FOV_DEGREES_MIN && view->fov_degrees <= STP_FOV_DEGREES_MAX)) {
        note_fault(codec, "has a field of view that is not from 0.001 to 179.9 degrees");
    }
}

static void code_source(stp_store_codec* codec, void* element)
{
    stp_store_source* source = element;
    code_text(codec, &source->path);
    code_text(codec, &source->format);
    code_u64(codec, &source->bytes);
}

static void code_block(stp_store_codec* codec, void* element)
{
    stp_store_block* block = element;
    code_u32(codec, &block->kind);
    code_u32(codec, &block->owner);
    code_u32(codec, &block->octave);
    code_u32(codec, &block->crc);
    code_u64(codec, &block->offset);
    code_u64(codec, &block->size);
    code_f32(codec, &block->radius);
    code_u32(codec, &block->encoding);
}

static void code_object(stp_store_codec* codec, void* element)
{
    stp_store_object* object = element;
    code_text(codec, &object->name);
    code_text(codec, &object->id);
    code_u32(codec, &object->parent);
    code_u32(codec, &object->node);
    code_affine(codec, &object->transform);
}

static void code_figures(stp_store_codec* codec, stp_store_figures* figures)
{
#define X(name) code_u64(codec, &figures->name);
    STP_STORE_FIGURES(X)
#undef X
}

static void code_summary(stp_store_codec* codec, void* element)
{
    stp_store_summary* summary = element;
    code_figures(codec, &summary->figures);
    code_vec3d(codec, &summary->bounds.min);
    code_vec3d(codec, &summary->bounds.max);
    code_u32(codec, &summary->material_count);
    code_u32(codec, &summary->texture_count);
    code_u32(codec, &summary->mesh_count);
    code_u32(codec, &summary->point_set_count);
}

static void code_scene_part(stp_store_codec* codec, void* element)
{
    stp_store_scene_part* part = element;
    code_text(codec, &part->name);
    code_u32(codec, &part->object);
    code_figures(codec, &part->figures);
}

static void code_page(stp_store_codec* codec, void* element)
{
    code_u32(codec, element);
}

static void code_key(stp_store_codec* codec, void* element)
{
    stp_store_key* key = element;
    code_u64(codec, &key->hash.low);
    code_u64(codec, &key->hash.high);
}

static void code_clusters(stp_store_codec* codec, void* element)
{
    stp_store_clusters_record* record = element;
    code_u32(codec, &record->cluster_count);
}

static void code_leaves(stp_store_codec* codec, void* element)
{
    stp_store_leaves_record* record = element;
    code_u32(codec, &record->leaf_count);
    code_u32(codec, &record->block);
}

static void code_certainty(stp_store_codec* codec, void* element)
{
    stp_store_certainty* record = element;
    code_u32(codec, &record->flags);
    code_f32(codec, &record->position_error);
}

static void code_growth(stp_store_codec* codec, void* element)
{
    code_f32(codec, element);
}

static void code_level(stp_store_codec* codec, void* element)
{
    stp_store_level* level = element;
    code_u32(codec, &level->node);
    code_u32(codec, &level->flags);
}

static void code_level_cluster(stp_store_codec* codec, void* element)
{
    stp_store_level_cluster* cluster = element;
    code_u32(codec, &cluster->made_by);
    code_u32(codec, &cluster->used_by);
    code_u32(codec, &cluster->one_sided);
}

static void code_level_group(stp_store_codec* codec, void* element)
{
    stp_store_level_group* group = element;
    for (int k = 0; k < 3; ++k) {
        code_f32(codec, &group->center[k]);
    }
    code_f32(codec, &group->radius);
    code_f32(codec, &group->error);
}

static void code_sides(stp_store_codec* codec, void* element)
{
    stp_store_sides* sides = element;
    code_u32(codec, &sides->flags);
    code_u32(codec, &sides->inverted);
    code_u64(codec, &sides->triangles);
}

static void code_normal_map(stp_store_codec* codec, void* element)
{
    stp_store_normal_map* record = element;
    code_u32(codec, &record->material);
    code_f32(codec, &record->scale);
    code_texture_use(codec, &record->use);
}

static void code_level_figures(stp_store_codec* codec, void* element)
{
    stp_store_level_figures* figures = element;
    code_u64(codec, &figures->levels);
    code_u64(codec, &figures->triangles);
    code_u64(codec, &figures->bytes);
}

static void code_method(stp_store_codec* codec, void* element)
{
    stp_store_method* method = &((stp_store_method_record*)element)->method;
    code_text(codec, &method->name);
    code_u32(codec, &method->id);
    code_u32(codec, &method->columns);
    code_u32(codec, &method->first_set);
    code_u32(codec, &method->set_count);
    code_reserved(codec);
}

static void code_attribute(stp_store_codec* codec, void* element)
{
    stp_store_attribute* attribute = element;
    code_u32(codec, &attribute->attribute);
    code_reserved(codec);
    code_u64(codec, &attribute->count);
    code_f64(codec, &attribute->low);
    code_f64(codec, &attribute->high);
    code_f64(codec, &attribute->low_percentile);
    code_f64(codec, &attribute->high_percentile);
}

static void code_attribute_value(stp_store_codec* codec, void* element)
{
    stp_store_attribute_value* value = element;
    code_u32(codec, &value->attribute);
    code_u32(codec, &value->value);
    code_u64(codec, &value->count);
}

static void code_attribute_block(stp_store_codec* codec, void* element)
{
    stp_store_attribute_block* block = element;
    code_u32(codec, &block->block);
    code_u32(codec, &block->attributes);
}

static void code_coordinates(stp_store_codec* codec, void* element)
{
    code_text(codec, &((stp_store_coordinates*)element)->text);
}

void stp_store_code_section(stp_store_codec* codec, stp_store_section* section)
{
    size_t begin = codec->offset;
    code_u32(codec, &section->type);
    code_u32(codec, &section->flags);
    code_u64(codec, &section->offset);
    code_u64(codec, &section->size);
    code_u64(codec, &section->count);
    code_u32(codec, &section->record_size);
    code_u32(codec, &section->crc);
    assert(codec->offset - begin == STP_STORE_SECTION_BYTES);
    (void)begin;
}

const stp_store_table* stp_store_table_of(uint32_t type)
{
    static const stp_store_table tables[STP_SECTION_END] = {
        [STP_SECTION_NODES] = {"node", 88, sizeof(stp_store_node), code_node},
        [STP_SECTION_EDGES] = {"edge", 104, sizeof(stp_store_edge), code_edge},
        [STP_SECTION_PARTS] = {"part", 8, sizeof(stp_store_part), code_part},
        [STP_SECTION_MATERIALS] = {"material", 152, sizeof(stp_store_material), code_material},
        [STP_SECTION_SHADINGS] = {"shading", 24, sizeof(stp_shading), code_shading},
        [STP_SECTION_TEXTURES] = {"texture", 24, sizeof(stp_store_texture_record), code_texture},
        [STP_SECTION_MESHES] = {"mesh", 48, sizeof(stp_store_mesh_record), code_mesh},
        [STP_SECTION_POINT_SETS] = {"point set", 48, sizeof(stp_store_point_record), code_points},
        [STP_SECTION_SPLAT_SETS] = {"splat set", 48, sizeof(stp_store_set_record), code_splat_set},
        [STP_SECTION_OCTAVES] = {"octave", 8, sizeof(stp_store_octave), code_octave},
        [STP_SECTION_BREAKPOINTS] = {"breakpoint", 8, sizeof(stp_store_breakpoint),
                                     code_breakpoint},
        [STP_SECTION_VIEWS] = {"view", 88, sizeof(stp_store_view), code_view},
        [STP_SECTION_SOURCES] = {"source", 16, sizeof(stp_store_source), code_source},
        [STP_SECTION_BLOCKS] = {"block", 40, sizeof(stp_store_block), code_block},
        [STP_SECTION_TEXT] = {NULL, 1, 1, NULL},
        [STP_SECTION_BUILD] = {NULL, 1, 1, NULL},
        [STP_SECTION_OBJECTS] = {"object", 112, sizeof(stp_store_object), code_object},
        [STP_SECTION_OBJECT_TEXT] = {NULL, 1, 1, NULL},
        [STP_SECTION_SUMMARY] = {"summary", 200, sizeof(stp_store_summary), code_summary},
        [STP_SECTION_SCENE_PARTS] = {"scene part", 144, sizeof(stp_store_scene_part),
                                     code_scene_part},
        [STP_SECTION_PAGES] = {"page", 4, sizeof(uint32_t), code_page},
        [STP_SECTION_KEYS] = {"key", 16, sizeof(stp_store_key), code_key},
        [STP_SECTION_CLUSTERS] = {"mesh's clusters", 4, sizeof(stp_store_clusters_record),
                                  code_clusters},
        [STP_SECTION_METHODS] = {"method", 24, sizeof(stp_store_method_record), code_method},
        [STP_SECTION_METHOD_NODES] = {"method's node", 4, sizeof(uint32_t), code_page},
        [STP_SECTION_ATTRIBUTES] = {"attribute", 48, sizeof(stp_store_attribute), code_attribute},
        [STP_SECTION_ATTRIBUTE_VALUES] = {"value of an attribute", 16,
                                          sizeof(stp_store_attribute_value), code_attribute_value},
        [STP_SECTION_ATTRIBUTE_BLOCKS] = {"block of attributes", 8,
                                          sizeof(stp_store_attribute_block), code_attribute_block},
        [STP_SECTION_COORDINATES] = {"coordinate system", 4, sizeof(stp_store_coordinates),
                                     code_coordinates},
        [STP_SECTION_LEAVES] = {"set's leaves", 8, sizeof(stp_store_leaves_record), code_leaves},
        [STP_SECTION_CERTAINTY] = {"set's certainty", 8, sizeof(stp_store_certainty),
                                   code_certainty},
        [STP_SECTION_GROWTHS] = {"growth", 4, sizeof(float), code_growth},
        [STP_SECTION_LEVELS] = {"level", 8, sizeof(stp_store_level), code_level},
        [STP_SECTION_LEVEL_CLUSTERS] = {"level cluster", 12, sizeof(stp_store_level_cluster),
                                        code_level_cluster},
        [STP_SECTION_LEVEL_GROUPS] = {"level group", 20, sizeof(stp_store_level_group),
                                      code_level_group},
        [STP_SECTION_LEVEL_FIGURES] = {"figures of levels", 24, sizeof(stp_store_level_figures),
                                       code_level_figures},
        [STP_SECTION_SIDES] = {"sides", 16, sizeof(stp_store_sides), code_sides},
        [STP_SECTION_NORMAL_MAPS] = {"normal map", 40, sizeof(stp_store_normal_map),
                                     code_normal_map},
    };
    return &tables[type < STP_SECTION_END ? type : 0];
}
