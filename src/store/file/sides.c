// SPDX-License-Identifier: MIT
// Materials and shadings whose backs are not drawn. Early readers skip the section, and draw both
// sides.
#include "store/file/sides.h"

#include "base/core/context.h"
#include "base/core/saturate.h"
#include "store/file/block_order.h"
#include "store/file/tables.h"

#include <assert.h>

/// Records of a section, which need not be read.
static uint64_t count_records(const stp_store* store, uint32_t type)
{
    return store->known[type] != NULL ? store->known[type]->count : 0;
}

stp_result stp_store_validate_sides(const stp_store* store)
{
    const stp_store_sides* records = store->tables[STP_SECTION_SIDES];
    uint32_t count = store->counts[STP_SECTION_SIDES];
    uint64_t materials = count_records(store, STP_SECTION_MATERIALS);
    uint64_t wanted = stp_add_saturated(materials, count_records(store, STP_SECTION_SHADINGS));
    if (store->known[STP_SECTION_SIDES] == NULL) {
        return STP_OK;
    }
    if (count != wanted) {
        return stp_fail(store->context, STP_ERROR_FORMAT,
                        "%s: tells the sides of %u materials and shadings but has %llu",
                        store->path, count, (unsigned long long)wanted);
    }
    for (uint32_t i = 0; i < count; ++i) {
        if (records[i].flags > STP_SIDES_FRONT_ONLY) {
            return stp_fail(store->context, STP_ERROR_FORMAT,
                            "%s: sides %u: flags %#x are not defined in this version", store->path,
                            i, records[i].flags);
        }
        if (i >= materials && (records[i].triangles != 0 || records[i].inverted != 0)) {
            return stp_fail(store->context, STP_ERROR_FORMAT,
                            "%s: sides %u: a shading has no triangles and no meshes", store->path,
                            i);
        }
    }
    return STP_OK;
}

stp_result stp_store_link_sides(stp_store* store)
{
    const stp_store_sides* records = store->tables[STP_SECTION_SIDES];
    stp_store_material* materials = store->tables[STP_SECTION_MATERIALS];
    stp_shading* shadings = store->tables[STP_SECTION_SHADINGS];
    uint32_t material_count = store->counts[STP_SECTION_MATERIALS];
    uint32_t count = store->counts[STP_SECTION_SIDES];
    stp_result result = stp_store_validate_sides(store);
    for (uint32_t i = 0; i < count && result == STP_OK; ++i) {
        bool front_only = (records[i].flags & STP_SIDES_FRONT_ONLY) != 0;
        uint32_t* flags =
            i < material_count ? &materials[i].flags : &shadings[i - material_count].flags;
        *flags |= front_only ? STP_SHADING_FRONT_ONLY : 0u;
        if (i < material_count) {
            materials[i].inverted = records[i].inverted;
        }
    }
    return result;
}

static void add_record(stp_store_side_figures* figures, const stp_store_sides* record)
{
    bool front_only = (record->flags & STP_SIDES_FRONT_ONLY) != 0;
    figures->materials += front_only && record->triangles > 0 ? 1 : 0;
    figures->triangles = stp_add_saturated(figures->triangles, front_only ? record->triangles : 0);
    figures->inverted += front_only ? record->inverted : 0;
}

stp_store_side_figures stp_store_get_side_figures(const stp_store* store)
{
    const stp_store_sides* records = store->tables[STP_SECTION_SIDES];
    stp_store_side_figures figures = {0};
    uint64_t material_count = count_records(store, STP_SECTION_MATERIALS);
    for (uint32_t i = 0; i < store->counts[STP_SECTION_SIDES] && i < material_count; ++i) {
        add_record(&figures, &records[i]);
    }
    return figures;
}

bool stp_store_tells_sides(const stp_store_directory* directory)
{
    bool any = false;
    for (uint32_t i = 0; i < directory->material_count; ++i) {
        any = any || (directory->materials[i].flags & STP_SHADING_FRONT_ONLY) != 0;
    }
    for (uint32_t i = 0; i < directory->shading_count; ++i) {
        any = any || (directory->shadings[i].flags & STP_SHADING_FRONT_ONLY) != 0;
    }
    return any;
}

stp_result stp_store_sides_of_content(stp_context* context, const stp_store_content* content,
                                      stp_store_sides** records)
{
    const stp_store_directory* d = &content->directory;
    size_t count = (size_t)d->material_count + d->shading_count;
    *records = STP_NEW_ZEROED(context, stp_store_sides, count + 1);
    if (*records == NULL) {
        return stp_fail_memory(context);
    }
    for (size_t i = 0; i < count; ++i) {
        bool is_material = i < d->material_count;
        uint32_t flags =
            is_material ? d->materials[i].flags : d->shadings[i - d->material_count].flags;
        (*records)[i].flags = (flags & STP_SHADING_FRONT_ONLY) != 0 ? STP_SIDES_FRONT_ONLY : 0u;
        (*records)[i].inverted = is_material ? d->materials[i].inverted : 0;
    }
    for (uint32_t i = 0; i < stp_store_first_level_mesh(d); ++i) {
        const stp_coded_mesh* coded = stp_store_coded_mesh(content, i);
        assert(content->meshes[i].material < d->material_count);
        (*records)[content->meshes[i].material].triangles +=
            coded != NULL ? coded->triangle_count : content->meshes[i].triangle_count;
    }
    return STP_OK;
}

stp_result stp_store_side_figures_of_content(stp_context* context, const stp_store_content* content,
                                             stp_store_side_figures* figures)
{
    stp_store_sides* records = NULL;
    *figures = (stp_store_side_figures){0};
    stp_result result = stp_store_sides_of_content(context, content, &records);
    for (uint32_t i = 0; i < content->directory.material_count && result == STP_OK; ++i) {
        add_record(figures, &records[i]);
    }
    stp_free(context, records);
    return result;
}
