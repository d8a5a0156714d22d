// SPDX-License-Identifier: MIT
//
// A `.stip` file opened for reading: the whole scene as verified tables and columns, directly in
// the mapped file. docs/format.md is the authority on the bytes.
//
// `stp_store_open` reads the whole directory and checks every count and offset in it. The data
// of a mesh, texture or splat set is verified (checksum, index ranges) on first use.
#pragma once

#include "base/io/hash.h"
#include "base/splats/leaf_tree.h"
#include "base/splats/splat_columns.h"
#include "store/clusters/clusters.h"
#include "store/file/levels.h"
#include "store/file/summary.h"

#include <assert.h>

#define STP_STORE_NONE UINT32_MAX

/// A use of a texture; see stp_texture_use in src/scene/scene.h.
typedef struct stp_store_texture_use {
    uint32_t texture; ///< STP_STORE_NONE: none
    uint32_t texcoord;
    float transform[2][3];
} stp_store_texture_use;

typedef enum stp_store_alpha { STP_STORE_OPAQUE, STP_STORE_MASK, STP_STORE_BLEND } stp_store_alpha;

typedef struct stp_store_material {
    const char* name;
    float base_color[4]; ///< linear
    float metallic, roughness, emissive[3], alpha_cutoff;
    stp_store_alpha alpha;
    uint32_t flags; ///< STP_SHADING_*
    /// Closed meshes of it whose fronts face inwards, if it is STP_SHADING_FRONT_ONLY
    uint32_t inverted;
    stp_store_texture_use base_color_texture, metallic_roughness_texture, emissive_texture;
    stp_store_texture_use normal_texture; ///< only with a scale; see stp_material (src/scene)
    float normal_scale;                   ///< finite; 0: no normal map
} stp_store_material;

enum { STP_STORE_MATERIAL_TEXTURES = 4 };

/// Lists the uses of textures that a material has. @return their number
static inline uint32_t
stp_store_used_textures(const stp_store_material* material,
                        const stp_store_texture_use* uses[STP_STORE_MATERIAL_TEXTURES])
{
    const stp_store_texture_use* all[] = {
        &material->base_color_texture, &material->metallic_roughness_texture,
        &material->emissive_texture,
        material->normal_scale != 0.0f ? &material->normal_texture : NULL};
    uint32_t count = 0;
    for (int i = 0; i < STP_STORE_MATERIAL_TEXTURES; ++i) {
        if (all[i] != NULL && all[i]->texture != STP_STORE_NONE) {
            uses[count++] = all[i];
        }
    }
    return count;
}

typedef struct stp_store_texture {
    uint32_t width, height;
    uint32_t wrap_u, wrap_v; ///< 0 repeat, 1 clamp, 2 mirror
    uint32_t nearest;
    const uint8_t* texels; ///< RGBA, sRGB
    /// Encoding of its block: 0 texels, else an image file: 1 PNG, 2 JPEG, 3 WebP (stp_image_kind).
    uint32_t encoding;
    /// Only for the writer: the image file that decodes to the texels, which may then be NULL.
    /// NULL: texels are written.
    const uint8_t* encoded;
    size_t encoded_size;
} stp_store_texture;

typedef struct stp_store_point_set {
    const char* name;
    uint32_t point_count, material;
    uint32_t held_by; ///< 1 + the set of splats that stores all its points; 0: none
    stp_box bounds;
    const float* positions;
    const int16_t* normals; ///< NULL, or octahedral
    const uint8_t* colors;  ///< NULL, or RGBA, sRGB
    /// Only for the writer: each NULL, or one value per point (stipple/attributes.h).
    const void* attributes[STP_ATTRIBUTES];
} stp_store_point_set;

typedef enum stp_store_part_kind { STP_STORE_PART_MESH, STP_STORE_PART_POINTS } stp_store_part_kind;

typedef struct stp_store_part {
    stp_store_part_kind kind;
    uint32_t index;
} stp_store_part;

typedef struct stp_store_edge {
    uint32_t node;
    stp_affine transform;
} stp_store_edge;

/// Children have lower indices than parents.
typedef struct stp_store_node {
    uint32_t first_edge, edge_count;
    uint32_t first_part, part_count;
    uint32_t set;   ///< its splat set, the view from outside; STP_STORE_NONE: none
    uint32_t flags; ///< bit 0: moving
    uint64_t triangle_count, point_count; ///< below it, each instance counted
    stp_boxd bounds;
} stp_store_node;

typedef struct stp_store_object {
    const char* name; ///< NULL: none
    const char* id;   ///< NULL: none
    uint32_t parent, node;
    stp_affine transform;
} stp_store_object;

typedef struct stp_store_view {
    const char* name;
    stp_vec3d eye, target, up;
    double fov_degrees;
} stp_store_view;

/// A method. Its sets are consecutive in the table of sets.
typedef struct stp_store_method {
    const char* name;
    uint32_t id;      ///< STP_METHOD_*
    uint32_t columns; ///< STP_SPLATS_*, of all its sets
    uint32_t first_set, set_count;
    const uint32_t* sets; ///< by node, STP_STORE_NONE: none. NULL: the nodes' own sets
} stp_store_method;

typedef struct stp_store_source {
    const char* path;
    const char* format;
    uint64_t bytes;
    const char* coordinate_system; ///< WKT, or a code such as "EPSG:25832"; NULL: not known
} stp_store_source;

typedef struct stp_store_attribute stp_store_attribute;             // store/file/point_attributes.h
typedef struct stp_store_attribute_value stp_store_attribute_value; // store/file/point_attributes.h

/// Everything but the bulk data; also the input of the writer. The store owns the arrays.
typedef struct stp_store_directory {
    uint32_t node_count, edge_count, part_count, object_count, material_count, shading_count,
        texture_count, mesh_count, point_set_count, set_count, view_count, source_count,
        method_count, attribute_count, attribute_value_count, level_count, level_cluster_count,
        level_group_count;
    const stp_store_node* nodes;
    const stp_store_edge* edges;
    const stp_store_part* parts;
    const stp_store_object* objects;
    const stp_store_material* materials;
    const stp_shading* shadings;
    const stp_store_view* views;
    const stp_store_source* sources;
    const stp_store_method* methods; ///< the first method's sets are the nodes' own
    const stp_store_attribute*
        attributes; ///< statistics of point attributes; the writer computes them
    const stp_store_attribute_value* attribute_values; ///< points per class; the writer counts them
    /// Sorted by node; within a node, coarse ones first. They are the last meshes: level i is mesh
    /// mesh_count - level_count + i. No part names one.
    const stp_store_level* levels;
    const stp_store_level_cluster* level_clusters; ///< level after level
    const stp_store_level_group* level_groups;
    /// node_count + 1: the levels of node i are [level_starts[i], level_starts[i + 1]). Made by the
    /// reader; NULL without levels.
    const uint32_t* level_starts;
    uint32_t root;          ///< STP_STORE_NONE in an empty scene
    double unit_metres;     ///< 0: unknown
    char up;                ///< the input's up axis
    const char* build_json; ///< the parameters of the build, one JSON object
} stp_store_directory;

/// The set of a node for a method, given by its index in the directory.
static inline uint32_t stp_store_set_of(const stp_store_directory* directory, uint32_t method,
                                        uint32_t node)
{
    assert(node < directory->node_count);
    assert(method == 0 || method < directory->method_count);
    const uint32_t* sets = method != 0 ? directory->methods[method].sets : NULL;
    return sets != NULL ? sets[node] : directory->nodes[node].set;
}

/// Index of the first mesh that is a level; mesh_count if none is.
static inline uint32_t stp_store_first_level_mesh(const stp_store_directory* directory)
{
    assert(directory->level_count <= directory->mesh_count);
    return directory->mesh_count - directory->level_count;
}

/// Number of methods that a user can choose: all but coarse ellipses, which come last.
uint32_t stp_store_offered_methods(const stp_store_directory* directory);

/// Index of a method in the directory; the first method if `id` is 0 or not in the file.
uint32_t stp_store_find_method(const stp_store_directory* directory, uint32_t id);

/// Opens and checks the directory. @return STP_OK, or IO, TRUNCATED, FORMAT, VERSION, UNSUPPORTED
/// (an unknown critical section, or an unknown encoding of a block), OUT_OF_MEMORY (logged)
///
/// The file stays mapped. Truncating it while open ends the process (SIGBUS) at the next access
/// beyond its new end. Replacing it by renaming, as stp_store_write does, is safe.
STP_MUST_USE stp_result stp_store_open(stp_context* context, const char* path, stp_store** store);

/// Options for opening. Zero means the behaviour of stp_store_open.
typedef struct stp_store_open_desc {
    /// Accepts a partial file, one that ends early, if it holds its whole directory. Splat sets
    /// then have their complete octaves (perhaps none, count 0); other data beyond the end is
    /// STP_ERROR_TRUNCATED. Descriptions cover the whole file; ask stp_store_resident_splats and
    /// related functions (store/residency/residency.h) what is available.
    bool accept_partial;
    /// Treats the file as ending after this many bytes; 0: no.
    uint64_t partial_bytes;
    /// Leaves `objects` NULL (with their count) until stp_store_load_objects.
    bool defer_objects;
    /// Reads only the file's description: summary, views, sources, methods and build parameters,
    /// less than 1 MB of a file of any size. Other tables are empty, and there is no root. Files
    /// without a summary (version 1.0) are opened in full.
    bool summary_only;
} stp_store_open_desc;

STP_MUST_USE stp_result stp_store_open_with(stp_context* context, const char* path,
                                            const stp_store_open_desc* desc, stp_store** store);
/// stp_store_open_with `accept_partial`.
STP_MUST_USE stp_result stp_store_open_partial(stp_context* context, const char* path,
                                               stp_store** store);
/// Opens a file in memory: 64-byte aligned, must outlive the store. `name` stands for the path.
STP_MUST_USE stp_result stp_store_open_memory(stp_context* context, const char* name,
                                              const void* bytes, size_t size,
                                              const stp_store_open_desc* desc, stp_store** store);
STP_MUST_USE stp_result stp_store_load_objects(stp_store* store);
/// Reads and checks one object without loading the others; works with deferred objects. The store
/// owns its texts. @return STP_OK, STP_ERROR_FORMAT, STP_ERROR_ARGUMENT (no such object, or a store
/// opened for its summary), STP_ERROR_OUT_OF_MEMORY; logged
STP_MUST_USE stp_result stp_store_read_object(stp_store* store, uint32_t index,
                                              stp_store_object* object);
/// Reads only an object's parent and node; ignores texts.
STP_MUST_USE stp_result stp_store_read_object_place(stp_store* store, uint32_t index,
                                                    stp_store_object* object);
void stp_store_close(stp_store* store);
const stp_store_directory* stp_store_get_directory(const stp_store* store);
uint64_t stp_store_file_bytes(const stp_store* store);
/// Size of the whole file according to its header; above stp_store_file_bytes if partial.
uint64_t stp_store_whole_bytes(const stp_store* store);
bool stp_store_is_partial(const stp_store* store);
/// Maximum error of points that sets hold, on each axis, in scene units: half the coarsest grid
/// step. 0: unknown, or no set holds points. Works for a store opened for its summary.
double stp_store_position_error(const stp_store* store);
/// The stored summary; NULL if the file has none (see stp_store_summarise).
const stp_store_summary* stp_store_get_summary(const stp_store* store);
/// How much the levels are; NULL if there are none, or the file does not say. Works for a store
/// opened for its summary.
const stp_store_level_figures* stp_store_get_level_figures(const stp_store* store);
/// Major version of the format.
uint32_t stp_store_format_version(const stp_store* store);
uint32_t stp_store_format_minor(const stp_store* store);

/// The leaves of a set that was built leaf by leaf (docs/format.md, Leaves).
typedef struct stp_store_leaves {
    uint32_t leaf_count; ///< 0: none, or not available
    const stp_splat_leaf* leaves;
    uint32_t node_count;
    const stp_leaf_node* nodes; ///< the tree over them; the first node is the root
} stp_store_leaves;

// Descriptions that need no bulk data: counts, bounds, octaves, prefix tables, materials. Columns
// may be NULL. `index` must be below the directory's count.
const stp_store_mesh* stp_store_describe_mesh(const stp_store* store, uint32_t index);
const stp_store_point_set* stp_store_describe_point_set(const stp_store* store, uint32_t index);
const stp_store_texture* stp_store_describe_texture(const stp_store* store, uint32_t index);
const stp_splats* stp_store_describe_splat_set(const stp_store* store, uint32_t index);
/// Whether a mesh is stored as clusters (store/clusters/clusters.h); then stp_store_get_mesh fails.
bool stp_store_is_clustered(const stp_store* store, uint32_t index);

// Each function verifies the data on first use and returns pointers into the file, or to decoded
// texels. They are valid as long as the store. One thread at a time. Wrong checksum or index:
// STP_ERROR_FORMAT, logged.
STP_MUST_USE stp_result stp_store_get_mesh(stp_store* store, uint32_t index, stp_store_mesh* mesh);
/// The clusters of a coded mesh: pointers into the file, checked on first use. One thread at a
/// time. @return STP_OK, STP_ERROR_FORMAT, STP_ERROR_TRUNCATED, STP_ERROR_ARGUMENT (the mesh is
/// stored as columns); logged
STP_MUST_USE stp_result stp_store_get_clusters(stp_store* store, uint32_t index,
                                               stp_clusters* clusters);
STP_MUST_USE stp_result stp_store_get_point_set(stp_store* store, uint32_t index,
                                                stp_store_point_set* points);
STP_MUST_USE stp_result stp_store_get_texture(stp_store* store, uint32_t index,
                                              stp_store_texture* texture);
/// Like stp_store_get_texture, but a picture that the store has not decoded yet is decoded for the
/// caller: free `*owned` (stp_free) unless NULL. stp_store_get_texture keeps such texels until the
/// store is closed.
STP_MUST_USE stp_result stp_store_load_texture(stp_store* store, uint32_t index,
                                               stp_store_texture* texture, uint8_t** owned);
/// Decodes the pictures of many textures on all threads, for stp_store_get_texture. Each index must
/// be below the directory's count. That call reports failures.
void stp_store_decode_textures(stp_store* store, const uint32_t* textures, size_t count);
/// The set's columns. Do not write to or free its arrays.
STP_MUST_USE stp_result stp_store_get_splat_set(stp_store* store, uint32_t index,
                                                stp_splats* splats);

/// Only the first `octave_count` octaves: reads only their blocks and allocates only their memory.
/// Returns fewer if the set, or the complete part of a partial file, has fewer. Requesting more
/// octaves later keeps earlier results valid, with their memory: a third more if octaves grow
/// fourfold.
STP_MUST_USE stp_result stp_store_get_splat_set_prefix(stp_store* store, uint32_t index,
                                                       uint32_t octave_count, stp_splats* splats);
/// Number of leaves that the file lists for a set.
uint32_t stp_store_leaf_count(const stp_store* store, uint32_t set);
/// Verifies the block on first use and builds the tree. Gives no leaves if the set has none or they
/// are not available: a partial file, or not loaded yet (store/residency/residency.h). @return
/// STP_OK, STP_ERROR_FORMAT, STP_ERROR_OUT_OF_MEMORY (logged)
STP_MUST_USE stp_result stp_store_get_leaves(stp_store* store, uint32_t set,
                                             stp_store_leaves* leaves);
/// Octaves needed to draw the first `count` splats of a set.
uint32_t stp_store_octaves_for(const stp_splats* splats, uint32_t count);
/// Frees the memory of a set's columns and invalidates pointers to them. They can be requested
/// again.
void stp_store_release_splat_set(stp_store* store, uint32_t index);

/// Coverage of a check, also on failure.
typedef struct stp_store_check_report {
    uint64_t file_bytes, bytes_checked;
    uint64_t blocks; ///< in the file
} stp_store_check_report;

/// Checks every checksum and invariant of the file. `quick`: only the directory. Of a directory
/// above 512 KiB, only the part that readers need first: header, section table, summary, scene
/// parts, views, sources and parameters with their texts, all page checksums, and the first page of
/// each section. Logs the first fault.
STP_MUST_USE stp_result stp_store_check_with_report(stp_context* context, const char* path,
                                                    bool quick, stp_store_check_report* report);
/// Checks an open store, not opened as a prefix. One opened for its summary gets the quick check.
STP_MUST_USE stp_result stp_store_check_open(stp_store* store, bool quick,
                                             stp_store_check_report* report);
STP_MUST_USE stp_result stp_store_check(stp_context* context, const char* path, bool quick);

/// A splat set as stored; its blocks are verified when its columns are requested. Pointers are
/// valid as long as the store.
typedef struct stp_store_stored_splat_set {
    uint32_t index;           ///< STP_STORE_NONE: no such key in the file
    const stp_splats* splats; ///< without columns (stp_store_get_splat_set)
} stp_store_stored_splat_set;

/// A mesh as stored; the checksum of its block is verified. Pointers are valid as long as the
/// store.
typedef struct stp_store_stored_mesh {
    uint32_t index;             ///< STP_STORE_NONE: no such key in the file
    const stp_store_mesh* mesh; ///< without columns
    uint32_t present;           ///< its optional columns (STP_COLUMN_*)
    const void* block; ///< columns, or the clusters of a coded mesh (stp_store_is_clustered)
    size_t size;
} stp_store_stored_mesh;

// Finds the first result with a content key. The first call builds a table. One thread at a time.
// @return STP_OK, also if not found; STP_ERROR_FORMAT, STP_ERROR_OUT_OF_MEMORY (logged)
STP_MUST_USE stp_result stp_store_find_splat_set_by_key(stp_store* store, stp_hash key,
                                                        stp_store_stored_splat_set* found);
STP_MUST_USE stp_result stp_store_find_mesh_by_key(stp_store* store, stp_hash key,
                                                   stp_store_stored_mesh* found);
