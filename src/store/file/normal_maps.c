// SPDX-License-Identifier: MIT
#include "store/file/normal_maps.h"

#include "base/core/context.h"
#include "store/file/tables.h"

#include <assert.h>

stp_result stp_store_link_normal_maps(const stp_store* store)
{
    const stp_store_normal_map* records = store->tables[STP_SECTION_NORMAL_MAPS];
    stp_store_material* materials = store->tables[STP_SECTION_MATERIALS];
    uint32_t count = store->counts[STP_SECTION_NORMAL_MAPS];
    uint32_t material_count = store->counts[STP_SECTION_MATERIALS];
    for (uint32_t i = 0; i < count; ++i) {
        const stp_store_normal_map* record = &records[i];
        bool ascends = i == 0 || record->material > records[i - 1].material;
        if (!ascends || record->material >= material_count) {
            return stp_fail(store->context, STP_ERROR_FORMAT,
                            "%s: normal map %u: material %u does not exist, or not in this place",
                            store->path, i, record->material);
        }
        if (record->use.texture == STP_STORE_NONE || record->scale == 0.0f) {
            return stp_fail(store->context, STP_ERROR_FORMAT,
                            "%s: normal map %u: has no texture, or a scale of 0", store->path, i);
        }
        materials[record->material].normal_texture = record->use;
        materials[record->material].normal_scale = record->scale;
    }
    return STP_OK;
}

static bool has_normal_map(const stp_store_material* material)
{
    return material->normal_scale != 0.0f && material->normal_texture.texture != STP_STORE_NONE;
}

uint32_t stp_store_count_normal_maps(const stp_store_directory* directory)
{
    uint32_t count = 0;
    for (uint32_t i = 0; i < directory->material_count; ++i) {
        count += has_normal_map(&directory->materials[i]) ? 1 : 0;
    }
    return count;
}

stp_result stp_store_list_normal_maps(stp_context* context, const stp_store_directory* directory,
                                      stp_store_normal_map** records)
{
    uint32_t count = stp_store_count_normal_maps(directory), listed = 0;
    *records = STP_NEW_ZEROED(context, stp_store_normal_map, (size_t)count + 1);
    for (uint32_t i = 0; *records != NULL && i < directory->material_count; ++i) {
        const stp_store_material* material = &directory->materials[i];
        if (has_normal_map(material)) {
            assert(listed < count);
            (*records)[listed++] = (stp_store_normal_map){
                .material = i, .scale = material->normal_scale, .use = material->normal_texture};
        }
    }
    return *records != NULL ? STP_OK : stp_fail_memory(context);
}
