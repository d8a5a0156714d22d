// SPDX-License-Identifier: MIT
#include "lab/scenes/compose.h"

#include "lab/scenes/trigonometry.h"

stp_affine place_at(double x, double y, double z)
{
    return (stp_affine){{{1, 0, 0, x}, {0, 1, 0, y}, {0, 0, 1, z}}};
}

stp_affine place_turned(double x, double y, double z, double turns, double scale)
{
    double s = scale * turn_sine(turns), c = scale * turn_cosine(turns);
    return (stp_affine){{{c, 0, s, x}, {0, scale, 0, y}, {-s, 0, c, z}}};
}

// The sRGB curve without pow: its 2.4th power as x^2 * x^0.4, the latter by Newton's method on y^5
// = x^2.
static float linear_from_srgb(uint32_t byte)
{
    double value = (double)(byte & 255) / 255.0;
    if (value <= 0.04045) {
        return (float)(value / 12.92);
    }
    double x = (value + 0.055) / 1.055, y = 1.0;
    for (int i = 0; i < 40; ++i) {
        y -= (y - x * x / (y * y * y * y)) / 5.0;
    }
    return (float)(x * x * y);
}

stp_result add_plain_material(stp_scene* scene, const char* name, uint32_t srgb, double roughness,
                              uint32_t* index)
{
    stp_material material = stp_material_default();
    material.name = name;
    material.base_color[0] = linear_from_srgb(srgb >> 16);
    material.base_color[1] = linear_from_srgb(srgb >> 8);
    material.base_color[2] = linear_from_srgb(srgb);
    material.metallic = 0.0f;
    material.roughness = (float)roughness;
    return stp_scene_add_material(scene, &material, index);
}

stp_result add_group(stp_scene* scene, const char* name, uint32_t parent,
                     const stp_affine* transform, uint32_t* index)
{
    return stp_scene_add_object(
        scene, &(stp_object){.name = name, .parent = parent, .transform = *transform}, index);
}

stp_result add_mesh_object(stp_scene* scene, const char* name, uint32_t parent,
                           const stp_affine* transform, uint32_t mesh)
{
    stp_result result = add_group(scene, name, parent, transform, NULL);
    return result == STP_OK ? stp_scene_add_part(scene, (stp_part){STP_PART_MESH, mesh}) : result;
}

stp_result add_view(stp_scene* scene, const char* name, stp_vec3d eye, stp_vec3d target,
                    double fov_degrees)
{
    return stp_scene_add_view(scene, &(stp_scene_view){.name = name,
                                                       .eye = eye,
                                                       .target = target,
                                                       .up = {0, 1, 0},
                                                       .fov_degrees = fov_degrees});
}
