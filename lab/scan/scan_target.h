// SPDX-License-Identifier: MIT
// The target of a simulated scanner: the triangles of a scene or a .stip, and their colours.
#pragma once

#include "lab/measure/ray_cast.h"
#include "program/options/command.h"
#include "raster/texture.h"
#include "scene/scene.h"
#include "store/file/store.h"

/// Colour and cut-outs of a surface.
typedef struct scan_material {
    float base_color[4]; ///< linear
    float uv_transform[2][3];
    float cutoff;  ///< surfaces with lower alpha are not hit; 0: those with alpha 0
    bool asks;     ///< whether alpha matters
    bool textured; ///< `texture` multiplies the base colour
    uint32_t texcoord;
    stp_texture_pyramid texture; ///< a single level; texels are borrowed
} scan_material;

/// Data of a mesh that colours need, by the vertices of its triangles.
typedef struct scan_columns {
    const float* texcoords;   ///< 2 per vertex, of the set that the material asks for; NULL: none
    const uint16_t* colors;   ///< 4 per vertex, linear, 65535 is 1; NULL: see `wide_colors`
    const float* wide_colors; ///< 4 per vertex, linear; NULL: none
    uint32_t material;
    void* owned[3]; ///< arrays that the target made for itself
} scan_columns;

typedef struct scan_target {
    stp_context* context;
    stp_caster* caster; ///< lengths are metres, z is up
    stp_cast_mesh* meshes;
    scan_columns* columns; ///< one per mesh
    scan_material* materials;
    stp_cast_part* parts; ///< uses of meshes: an object of the truth is one of them, by its index
    uint32_t mesh_count, material_count, part_count;
    double metres; ///< length of a unit of the scene
} scan_target;

/// The target of a finished scene, which must outlive it. @return STP_OK, STP_ERROR_FORMAT (no
/// triangles), STP_ERROR_OUT_OF_MEMORY, STP_ERROR_LIMIT (more than 16 million uses of parts);
/// logged. After a failure there is nothing to destroy
STP_MUST_USE stp_result scan_target_of_scene(const stp_scene* scene, const char* name,
                                             scan_target* target);
/// Same, for the original triangles of an open .stip.
STP_MUST_USE stp_result scan_target_of_store(stp_context* context, stp_store* store,
                                             const char* name, scan_target* target);
void scan_target_destroy(scan_target* target);

/// The surface that a ray hit.
typedef struct scan_surface {
    stp_vec3d place;  ///< position of the hit
    stp_vec3d normal; ///< unit normal of the triangle, facing the origin of the ray
    bool from_behind; ///< the triangle's winding shows its back
    float color[3];   ///< linear; texture and colours of vertices included
    double distance;  ///< metres
    uint32_t object;
} scan_surface;

/// Casts a ray.
/// @param direction of unit length
/// @return whether it hits anything up to `farthest`
bool scan_target_intersect(const scan_target* target, stp_vec3d origin, stp_vec3d direction,
                           double nearest, double farthest, scan_surface* surface);
