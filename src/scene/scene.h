// SPDX-License-Identifier: MIT
//
// An imported scene: meshes, point sets, materials, textures, and the objects that place them.
//
//   objects (a tree, as the input wrote it: names, ids)       nodes (a graph without cycles,
// shared)
//
//      plant ── line 1 ── motor ── bolt                        n3 ─┬─ n2 ─┬─ n1 ── n0
//            └─ line 2 ── motor ── bolt           each object      └──────┘ (two edges, one node)
//                                                 knows its node
//
// Importers add objects under their parents, with parts (meshes or point sets) and instances. Then
// stp_scene_finish() merges identical meshes, finds identical subtrees, and builds the graph of
// nodes: identical content becomes one node, however often the input repeats it. Users see objects;
// all expensive work runs on nodes.
//
// Positions are floats relative to their object; transforms are double, so a site far from its
// origin keeps its precision. Internally, y is up and lengths are in the scene's unit. Material
// colours are linear; textures and point colours are sRGB bytes.
#pragma once

#include "base/core/arena.h"
#include "base/io/hash.h"
#include "base/io/spill.h"
#include "base/math/math.h"
#include "scene/content_table.h"

#include <stipple/attributes.h>

#define STP_NONE UINT32_MAX
/// Maximum bytes of a name or id; longer ones are truncated with a warning
#define STP_SCENE_TEXT_LIMIT 4064
/// Maximum distance of a point's time from 0, in any unit: nanoseconds since 1970 stay below. A
/// difference of two such times is finite.
#define STP_SCENE_TIME_LIMIT 1e19

typedef enum stp_alpha_mode {
    STP_ALPHA_OPAQUE,
    STP_ALPHA_MASK,  ///< texels below the cutoff are cut out
    STP_ALPHA_BLEND, ///< transparent: drawn as hashed alpha
} stp_alpha_mode;

typedef enum stp_wrap { STP_WRAP_REPEAT, STP_WRAP_CLAMP, STP_WRAP_MIRROR } stp_wrap;

/// A use of a texture. The transform is two rows of three: uv' = t * (u, v, 1).
typedef struct stp_texture_use {
    uint32_t texture;  ///< STP_NONE: none
    uint32_t texcoord; ///< which of a mesh's two sets
    float transform[2][3];
} stp_texture_use;

typedef struct stp_material {
    const char* name; ///< may be NULL
    float base_color[4];
    float metallic, roughness;
    float emissive[3]; ///< includes the strength; may exceed 1
    float alpha_cutoff;
    stp_alpha_mode alpha_mode;
    bool double_sided, unlit;
    bool front_only; ///< backs are not drawn: single-sided, from a format in which that culls
    /// Meshes of it that are closed and whose fronts face inwards; set by stp_scene_finish
    uint32_t inverted;
    uint32_t look; ///< 1 + index in scene->looks; 0: without variants; by stp_scene_find_looks
    stp_texture_use base_color_texture;         ///< sRGB, alpha
    stp_texture_use metallic_roughness_texture; ///< linear: green roughness, blue metallic
    stp_texture_use emissive_texture;           ///< sRGB
    /// Linear, a normal map: red along u, green against v (up in the picture), blue outwards
    stp_texture_use normal_texture;
    float normal_scale; ///< factor of the map's red and green; not 0 where there is a map
    stp_hash content;   ///< hash of all visible properties and textures; set by stp_scene_finish
} stp_material;

/// Encoding of a texture's `encoded` bytes; the numbers of `.stip` files.
typedef enum stp_texture_encoding {
    STP_TEXTURE_TEXELS, ///< no encoded bytes
    STP_TEXTURE_PNG,
    STP_TEXTURE_JPEG,
    STP_TEXTURE_WEBP,
} stp_texture_encoding;

typedef struct stp_texture {
    const char* name; ///< may be NULL
    uint32_t width, height;
    uint8_t* texels; ///< owned; RGBA rows, top first
    /// The picture file that decodes to exactly these texels; owned. NULL: the texels had another
    /// source or were changed on import.
    uint8_t* encoded;
    size_t encoded_size;
    stp_texture_encoding encoding;
    stp_wrap wrap_u, wrap_v;
    bool nearest;     ///< magnified without interpolation
    bool spilled;     ///< the arrays are in the scene's spill file, perhaps shared
    stp_hash content; ///< hash of the texels; set when they are spilled, or by stp_scene_finish
} stp_texture;

/// Triangles of one material. Arrays are owned; optional ones may be NULL.
typedef struct stp_mesh {
    const char* name; ///< may be NULL
    uint32_t vertex_count;
    uint32_t triangle_count;
    float* positions;    ///< 3 per vertex; within reach once added (finish_steps.h)
    float* normals;      ///< optional: 3 per vertex, unit or zero; NULL: flat, from the winding
    float* texcoords[2]; ///< optional: 2 per vertex
    uint16_t* colors;    ///< optional: 4 per vertex, linear, 65535 is 1; multiplies the base colour
    uint32_t* indices;   ///< 3 per triangle, each below vertex_count
    uint32_t material;
    stp_box bounds;
    /// Hash of the geometry, without the material; set when spilled, or by stp_scene_finish
    stp_hash content;
    double grid_step; ///< step of stored positions (base/math/position_grid.h), by stp_scene_finish
    double area;      ///< sum of the triangles' areas; set by stp_scene_finish
    bool spilled;  ///< the arrays are in the scene's spill file, perhaps shared with other meshes
    bool is_piece; ///< a piece of a larger mesh, adjacent to other pieces at its borders
} stp_mesh;

typedef struct stp_point_set {
    const char* name; ///< may be NULL
    uint32_t point_count;
    float* positions;                 ///< 3 per point; within reach once added (finish_steps.h)
    float* normals;                   ///< optional: 3 per point
    uint8_t* colors;                  ///< optional: RGBA per point, sRGB
    void* attributes[STP_ATTRIBUTES]; ///< each optional: one value per point (stipple/attributes.h)
    uint32_t material;
    stp_box bounds;
    stp_hash content;
    bool spilled;
} stp_point_set;

typedef enum stp_part_kind { STP_PART_MESH, STP_PART_POINTS } stp_part_kind;

/// A mesh or a point set, by index.
typedef struct stp_part {
    stp_part_kind kind;
    uint32_t index; ///< STP_NONE if the partition has split the object's mesh
} stp_part;

enum {
    STP_OBJECT_MOVING = 1,    ///< skinned or animated: never merged into a static ancestor's splats
    STP_OBJECT_PROTOTYPE = 2, ///< visible only through objects that use it (stp_scene_add_use)
};

typedef struct stp_object {
    const char* name;     ///< may be NULL
    const char* id;       ///< the input's own id or extras as JSON text; may be NULL
    uint32_t parent;      ///< below this object's own index; STP_NONE for a root
    stp_affine transform; ///< to the parent
    uint32_t first_part, part_count;
    uint32_t first_instance,
        instance_count; ///< transforms of its parts within it; 0: one, the identity
    /// An object of lower index whose parts and children it also shows; STP_NONE: none
    uint32_t use;
    uint32_t flags;
    uint32_t node; ///< set by stp_scene_finish
} stp_object;

/// A child within a node.
typedef struct stp_edge {
    uint32_t node;
    stp_affine transform;
} stp_edge;

/// A vertex of the graph; children have lower indices than parents.
typedef struct stp_node {
    uint32_t first_edge, edge_count;
    uint32_t first_part, part_count; ///< into node_parts
    uint32_t flags;                  ///< STP_OBJECT_MOVING of its objects
    stp_boxd bounds;                 ///< encloses the whole subtree, in the node's own space
    uint64_t triangle_count;         ///< triangles of the whole subtree; each instance counts
    uint64_t point_count;            ///< points, likewise
    double area; ///< sum over the subtree's triangles with all instances, in units of its space
    stp_hash content; ///< hash of the subtree: geometry, materials, textures, transforms, flags
} stp_node;

/// A named camera. `eye`, `target` and `up` in scene space.
typedef struct stp_scene_view {
    const char* name;
    stp_vec3d eye, target, up;
    double fov_degrees; ///< vertical
} stp_scene_view;

typedef struct stp_source {
    const char* path; ///< as given by the user
    const char* format;
    uint64_t bytes;
    const char* coordinate_system; ///< as in the file: WKT, or "EPSG:25832"; NULL: unspecified
} stp_source;

/// Meshes and point sets of which parts were dropped when they were added (finish_steps.h).
typedef struct stp_damage {
    uint32_t count;   ///< number of such items
    stp_part first;   ///< the first one
    uint32_t dropped; ///< its dropped triangles or points
} stp_damage;

typedef struct stp_look stp_look;           // scene/looks.h
typedef struct stp_look_bins stp_look_bins; // scene/looks.h

typedef struct stp_scene {
    stp_context* context;
    stp_arena text; ///< names and ids live here
    stp_mesh* meshes;
    stp_point_set* point_sets;
    stp_material* materials; ///< material 0 always exists: glTF's default
    stp_texture* textures;
    stp_object* objects;
    stp_part* parts;
    stp_affine* instances;
    stp_scene_view* views;
    stp_source* sources;
    size_t mesh_count, point_set_count, material_count, texture_count, object_count, part_count,
        instance_count, view_count, source_count;
    size_t mesh_capacity, point_set_capacity, material_capacity, texture_capacity, object_capacity,
        part_capacity, instance_capacity, view_capacity, source_capacity;
    stp_damage damaged;
    uint32_t shortened; ///< truncated names and ids

    // made by stp_scene_finish
    stp_node* nodes;
    stp_edge* edges;
    stp_part* node_parts;
    size_t node_count, edge_count, node_part_count;
    uint32_t root; ///< the node that contains everything; STP_NONE in an empty scene

    stp_spill* spill; ///< NULL: everything stays in memory
    uint64_t spill_above;
    uint64_t bulk_bytes;       ///< size of meshes, point sets and textures in memory
    stp_content_table spilled; ///< by content: spilled meshes, point sets and textures

    /// Per shading (builder/shadings.h): whether its splats are seen from the front only. Set
    /// before splats are made.
    bool front_only_shadings[256];
    stp_look* looks;          ///< by stp_scene_find_looks
    stp_look_bins* look_bins; ///< of its textures
    uint32_t look_count, variant_count;

    double unit_metres; ///< length of one unit; 0 if unknown
    const char* up;     ///< the input's up axis, "x", "y" or "z", without sign: it was rotated to y
} stp_scene;

/// From now on, added meshes, point sets and texels move to `spill` once more than `above_bytes` of
/// them are in memory; content already there is not written again. The spill must outlive the
/// scene. Adding may then also fail with STP_ERROR_IO (logged). See base/io/spill.h.
void stp_scene_use_spill(stp_scene* scene, stp_spill* spill, uint64_t above_bytes);

/// Makes room for `count` elements in an array of a scene; see stp_make_room. @return STP_OK,
/// STP_ERROR_LIMIT (indices would exceed 32 bits), STP_ERROR_OUT_OF_MEMORY; logged
STP_MUST_USE stp_result stp_scene_make_room(stp_context* context, void* array_address,
                                            size_t* capacity, size_t count, size_t size);
/// The same as STP_MAKE_ROOM, for an array of a scene.
#define STP_SCENE_MAKE_ROOM(context, array, capacity, count)                                       \
    stp_scene_make_room((context), &(array), &(capacity), (count), sizeof(*(array)))

/// Creates an empty scene with its default material.
STP_MUST_USE stp_result stp_scene_create(stp_context* context, stp_scene** scene);
void stp_scene_destroy(stp_scene* scene);

// Each of these adds one item and returns its index through the last argument (may be NULL). Arrays
// inside the struct (positions, texels, ...) must come from stp_alloc; the scene takes ownership,
// also on failure. Texts are copied. Without a spill, the only failure is STP_ERROR_OUT_OF_MEMORY,
// logged. Triangles and points without a finite position within reach are dropped;
// stp_scene_finish warns.
STP_MUST_USE stp_result stp_scene_add_mesh(stp_scene* scene, const stp_mesh* mesh, uint32_t* index);
STP_MUST_USE stp_result stp_scene_add_point_set(stp_scene* scene, const stp_point_set* points,
                                                uint32_t* index);
/// Adds a point set whose arrays are already in the scene's spill.
STP_MUST_USE stp_result stp_scene_add_spilled_points(stp_scene* scene, const stp_point_set* points,
                                                     uint32_t* index);
STP_MUST_USE stp_result stp_scene_add_material(stp_scene* scene, const stp_material* material,
                                               uint32_t* index);
STP_MUST_USE stp_result stp_scene_add_texture(stp_scene* scene, const stp_texture* texture,
                                              uint32_t* index);
/// Reads only name, id, parent, transform and flags.
STP_MUST_USE stp_result stp_scene_add_object(stp_scene* scene, const stp_object* object,
                                             uint32_t* index);
/// Adds a part to the most recent object.
STP_MUST_USE stp_result stp_scene_add_part(stp_scene* scene, stp_part part);
STP_MUST_USE stp_result stp_scene_add_instance(stp_scene* scene, const stp_affine* transform);
/// Makes the most recent object also show the content of an earlier one, below its own transform
/// (the earlier one's transform does not count): a sub-assembly defined once and used many times,
/// also nested. One use per object. Its instances place the used content as well as its own parts.
/// If objects contain themselves this way, stp_scene_finish fails with STP_ERROR_FORMAT.
STP_MUST_USE stp_result stp_scene_add_use(stp_scene* scene, uint32_t object);
STP_MUST_USE stp_result stp_scene_add_view(stp_scene* scene, const stp_scene_view* view);
STP_MUST_USE stp_result stp_scene_add_source(stp_scene* scene, const stp_source* source);
/// Sets the coordinate system of a source once it is known. The source being imported is the last.
STP_MUST_USE stp_result stp_scene_set_coordinate_system(stp_scene* scene, size_t source,
                                                        const char* text);

/// glTF's default material: white, fully metallic and rough, opaque; but drawn from both sides.
stp_material stp_material_default(void);
stp_texture_use stp_texture_use_none(void);
/// The texture of a use; NULL: none, or one without texels in memory.
const stp_texture* stp_scene_used_texture(const stp_scene* scene, const stp_texture_use* use);

/// Computes bounds, drops empty meshes' parts (no triangles), merges identical meshes and subtrees,
/// and builds the graph of nodes. Objects out of reach in their parent are dropped, with a warning
/// that names the first one. Duplicate view names get numbers. Call once, after adding everything.
STP_MUST_USE stp_result stp_scene_finish(stp_scene* scene);

/// One use of a part in the whole scene.
typedef struct stp_placed_part {
    stp_part part;
    stp_affine transform; ///< to the space of the queried node (the scene's, for the root)
    uint32_t flags;       ///< union of the flags on the path to it, without the queried node's
} stp_placed_part;

/// Lists each use of each part below `node`. The caller frees the array (stp_free).
/// @return STP_OK, STP_ERROR_OUT_OF_MEMORY, or STP_ERROR_LIMIT if there are more than `limit` uses
STP_MUST_USE stp_result stp_scene_flatten(const stp_scene* scene, uint32_t node, size_t limit,
                                          stp_placed_part** parts, size_t* part_count);
