// SPDX-License-Identifier: MIT
#include "draw/transparency.h"

#include <string.h>

bool stp_transparency_of_scene(const stp_store_directory* directory)
{
    bool any = false;
    for (uint32_t i = 0; i < directory->material_count; ++i) {
        any = any || directory->materials[i].alpha == STP_STORE_BLEND;
    }
    for (uint32_t i = 0; i < directory->shading_count; ++i) {
        any = any || (directory->shadings[i].flags & STP_SHADING_TRANSPARENT) != 0;
    }
    return any;
}

void stp_transparency_of_shadings(const stp_store_directory* directory, uint8_t transparent[256])
{
    memset(transparent, 0, 256);
    for (uint32_t i = 0; i < directory->shading_count && i < 256; ++i) {
        transparent[i] = (directory->shadings[i].flags & STP_SHADING_TRANSPARENT) != 0;
    }
}

stp_mesh_transparency stp_transparency_of_mesh(const stp_store_material* material, bool varies)
{
    if (material->alpha != STP_STORE_BLEND) {
        return STP_TRANSPARENT_NOWHERE;
    }
    if (varies) {
        return STP_TRANSPARENT_PARTLY;
    }
    return material->base_color[3] >= STP_ALPHA_OPAQUE_FROM ? STP_TRANSPARENT_NOWHERE
                                                            : STP_TRANSPARENT_EVERYWHERE;
}

float stp_transparency_cells(stp_box box)
{
    float x = box.max.x - box.min.x, y = box.max.y - box.min.y, z = box.max.z - box.min.z;
    float longest = stp_max(stp_max(x, y), z);
    return longest > 0.0f ? STP_TRANSPARENT_CELLS / longest : 0.0f;
}
