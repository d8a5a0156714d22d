// SPDX-License-Identifier: MIT
//
// The glTF 2.0 reader, shared between its files. Sections in brackets in these files are those of
// the Khronos glTF 2.0 Specification.
//
//   container --> json --> buffers --> buffer views --> accessors --> primitives --+
//   (format_gltf) (gltf_json) (gltf_buffer) (gltf_meshopt)  (gltf_accessor)        +--> scene
//                            images --> textures --> materials --> nodes ----------+
//                            (gltf_image)            (gltf_material) (gltf_node)
//
// Reading happens in a scope, which knows the location for messages and keeps the first failure.
// Primitives are read in jobs, each in its own scope; only the calling thread logs and adds to the
// scene, in file order.
#pragma once

#include "import/reading/import.h"

#include <jansson.h>

/// The top-level lists of a file.
#define STP_GLTF_LISTS(X)                                                                          \
    X(ACCESSORS, "accessors")                                                                      \
    X(ANIMATIONS, "animations")                                                                    \
    X(BUFFERS, "buffers")                                                                          \
    X(BUFFER_VIEWS, "bufferViews")                                                                 \
    X(CAMERAS, "cameras")                                                                          \
    X(IMAGES, "images")                                                                            \
    X(MATERIALS, "materials")                                                                      \
    X(MESHES, "meshes")                                                                            \
    X(NODES, "nodes")                                                                              \
    X(SAMPLERS, "samplers")                                                                        \
    X(SCENES, "scenes")                                                                            \
    X(SKINS, "skins")                                                                              \
    X(TEXTURES, "textures")

typedef enum stp_gltf_list {
#define X(name, text) STP_GLTF_##name,
    STP_GLTF_LISTS(X)
#undef X
        STP_GLTF_LIST_COUNT,
} stp_gltf_list;

typedef struct stp_gltf_buffer {
    const unsigned char* bytes; ///< NULL: a fallback buffer without data (EXT_meshopt_compression)
    size_t size;
    unsigned char* owned; ///< decoded from a data URI
    stp_mapped_file file; ///< mapped beside the model
} stp_gltf_buffer;

enum { STP_GLTF_TEXCOORD_SETS = 2 };

/// Texture coordinates that a material needs: which TEXCOORD_n goes into which set of a mesh.
typedef struct stp_gltf_material {
    uint32_t set_count;
    uint32_t sets[STP_GLTF_TEXCOORD_SETS];
} stp_gltf_material;

enum { STP_GLTF_MOVES = 1, STP_GLTF_IN_SCENE = 2, STP_GLTF_HAS_WEIGHTS = 4 };

typedef struct stp_gltf_node {
    const json_t* json;
    uint32_t parent, mesh, skin, camera;
    uint32_t flags;
    uint32_t variant; ///< index of its mesh's variant; STP_NONE: none is shown
    uint32_t object;
    stp_affine local, world; ///< world: within the file, before axis conversion
} stp_gltf_node;

/// A mesh as shown by some nodes. Nodes without skins and weights of their own share one.
typedef struct stp_gltf_variant {
    uint32_t mesh;
    uint32_t skin;         ///< STP_NONE: none
    uint32_t weights_node; ///< node whose morph target weights apply; STP_NONE: the mesh's
    size_t first_primitive, primitive_count;
} stp_gltf_variant;

/// Result of a primitive; `part` is valid if `present`.
typedef struct stp_gltf_part {
    bool present;
    stp_part part;
} stp_gltf_part;

typedef struct stp_gltf {
    stp_import* import;
    stp_context* context;
    json_t* root;
    uint64_t root_bytes;                      ///< memory reserved for `root`
    const json_t* lists[STP_GLTF_LIST_COUNT]; ///< each NULL or an array
    stp_gltf_buffer* buffers;
    const unsigned char* chunk; ///< binary chunk of a .glb; NULL: none
    size_t chunk_size;
    unsigned char** decoded_views; ///< by buffer view; NULL if it is not compressed
    size_t content_bytes;          ///< size of the model and the files beside it; scales the limits
    uint32_t first_material;       ///< index in the scene of the file's first material
    uint32_t default_material;     ///< in the scene: of triangles without a material
    stp_gltf_material* materials;
    stp_gltf_node* nodes;
    uint32_t* node_order; ///< parents before children, each node once
    size_t node_count;
    stp_gltf_variant* variants;
    size_t variant_count, variant_capacity;
    stp_gltf_part* parts; ///< one per primitive, in the order of variants
} stp_gltf;

enum { STP_GLTF_MESSAGE_SIZE = 400 };

typedef struct stp_gltf_scope {
    const stp_gltf* gltf;
    char place[64]; ///< "meshes[3].primitives[0]"; may be empty
    char error[STP_GLTF_MESSAGE_SIZE];
    char warning[STP_GLTF_MESSAGE_SIZE]; ///< the first warning; empty: none
    bool logged;                         ///< the failure was logged where it occurred
} stp_gltf_scope;

// gltf_json.c: type-checked members of objects. Missing members and null are equivalent.

stp_gltf_scope stp_gltf_scope_begin(const stp_gltf* gltf);
void stp_gltf_set_place(stp_gltf_scope* scope, const char* format, ...)
    __attribute__((format(printf, 2, 3)));
/// Stores the sentence; returns `result`. Does not log.
stp_result stp_gltf_fail(stp_gltf_scope* scope, stp_result result, const char* format, ...)
    __attribute__((format(printf, 3, 4)));
void stp_gltf_warn(stp_gltf_scope* scope, const char* format, ...)
    __attribute__((format(printf, 2, 3)));
/// For results of calls that log themselves; returns `result`.
stp_result stp_gltf_logged(stp_gltf_scope* scope, stp_result result);
/// Logs the scope's messages: the warning, and the failure if `result` is one. Returns `result`. A
/// failure without a message can only be STP_ERROR_OUT_OF_MEMORY.
stp_result stp_gltf_scope_end(stp_gltf_scope* scope, stp_result result);

size_t stp_gltf_count(const stp_gltf* gltf, stp_gltf_list list);
STP_MUST_USE stp_result stp_gltf_find_lists(stp_gltf_scope* scope, stp_gltf* gltf);
/// The object at an index of a top-level list.
STP_MUST_USE stp_result stp_gltf_item(stp_gltf_scope* scope, stp_gltf_list list, size_t index,
                                      const json_t** item);
/// Member objects and arrays; NULL if missing.
STP_MUST_USE stp_result stp_gltf_object(stp_gltf_scope* scope, const json_t* object,
                                        const char* key, const json_t** member);
STP_MUST_USE stp_result stp_gltf_array(stp_gltf_scope* scope, const json_t* object, const char* key,
                                       const json_t** member);
/// The object of an extension; NULL if missing.
STP_MUST_USE stp_result stp_gltf_extension(stp_gltf_scope* scope, const json_t* object,
                                           const char* name, const json_t** member);
/// An index into a top-level list; STP_NONE if missing.
STP_MUST_USE stp_result stp_gltf_index(stp_gltf_scope* scope, const json_t* object, const char* key,
                                       stp_gltf_list list, uint32_t* index);
/// A whole number, not negative; unchanged where missing.
STP_MUST_USE stp_result stp_gltf_size(stp_gltf_scope* scope, const json_t* object, const char* key,
                                      size_t* value);
/// Numbers; unchanged where missing. `count` elements exactly.
STP_MUST_USE stp_result stp_gltf_number(stp_gltf_scope* scope, const json_t* object,
                                        const char* key, double* value);
STP_MUST_USE stp_result stp_gltf_numbers(stp_gltf_scope* scope, const json_t* object,
                                         const char* key, size_t count, double* values);
/// Texts and flags; NULL or false if missing or of another type.
const char* stp_gltf_text(const json_t* object, const char* key);
bool stp_gltf_flag(const json_t* object, const char* key);
/// An element of an array as an index below `limit`.
STP_MUST_USE stp_result stp_gltf_element_index(stp_gltf_scope* scope, const json_t* array,
                                               size_t element, size_t limit, uint32_t* index);

// gltf_uri.c

bool stp_gltf_uri_is_data(const char* uri);
/// The bytes of a data URI (stp_alloc).
STP_MUST_USE stp_result stp_gltf_uri_decode(stp_gltf_scope* scope, const char* uri,
                                            unsigned char** bytes, size_t* size);
/// Percent-decoded (stp_alloc).
STP_MUST_USE stp_result stp_gltf_uri_path(stp_gltf_scope* scope, const char* uri, char** path);

// gltf_buffer.c

STP_MUST_USE stp_result stp_gltf_load_buffers(stp_gltf_scope* scope, stp_gltf* gltf);
/// The bytes of a buffer view, decompressed; `stride` 0: none given.
STP_MUST_USE stp_result stp_gltf_view(stp_gltf_scope* scope, uint32_t view,
                                      const unsigned char** bytes, size_t* size, size_t* stride);
/// Bytes of a buffer, checked against its actual size.
STP_MUST_USE stp_result stp_gltf_buffer_range(stp_gltf_scope* scope, uint32_t buffer, size_t offset,
                                              size_t size, const unsigned char** bytes);
/// Releases the memory of file content that has been read. Any thread.
void stp_gltf_release_buffers(const stp_gltf* gltf);
void stp_gltf_free_buffers(stp_gltf* gltf);

// gltf_meshopt.c

/// Decompresses all buffer views with EXT_meshopt_compression, in jobs.
STP_MUST_USE stp_result stp_gltf_decompress_views(stp_gltf_scope* scope, stp_gltf* gltf);

// gltf_limit.c

/// The cost of reading one primitive of a variant: its indices, or else vertices, plus vertices for
/// each morph target and sparse attribute, plus the joints of the skin.
uint64_t stp_gltf_primitive_elements(const stp_gltf* gltf, const stp_gltf_variant* variant,
                                     size_t index);
/// How many elements of a given size to read before the scene takes them and may move them out of
/// memory: `maximum`, or fewer if the scene keeps little in memory. 0: one element at a time.
uint64_t stp_gltf_batch(const stp_gltf* gltf, uint64_t maximum, uint64_t bytes_each);
/// Rejects meshes that claim far more data than the file holds.
STP_MUST_USE stp_result stp_gltf_check_meshes(stp_gltf_scope* scope, const stp_gltf* gltf);
/// Same, for compressed buffer views; sets `any` if there are some.
STP_MUST_USE stp_result stp_gltf_check_views(stp_gltf_scope* scope, const stp_gltf* gltf,
                                             bool* any);

// gltf_material.c, gltf_image.c

/// Adds all materials and the textures they use to the scene.
STP_MUST_USE stp_result stp_gltf_load_materials(stp_gltf_scope* scope, stp_gltf* gltf);

/// Pictures used by materials. A glTF texture is a picture and a sampler; equal ones become one
/// texture of the scene.
typedef struct stp_gltf_textures stp_gltf_textures;

STP_MUST_USE stp_result stp_gltf_textures_create(stp_gltf_scope* scope,
                                                 stp_gltf_textures** textures);
void stp_gltf_textures_destroy(stp_gltf_textures* textures, stp_gltf* gltf);
/// Registers a use; returns a number for looking up the scene's texture after loading.
STP_MUST_USE stp_result stp_gltf_textures_want(stp_gltf_scope* scope, stp_gltf_textures* textures,
                                               uint32_t texture, uint32_t* request);
/// Reads and decodes all registered pictures and adds the textures to the scene.
STP_MUST_USE stp_result stp_gltf_textures_load(stp_gltf_scope* scope, stp_gltf_textures* textures,
                                               stp_gltf* gltf);
/// The scene's texture; STP_NONE if its picture is not available.
uint32_t stp_gltf_textures_get(const stp_gltf_textures* textures, uint32_t request);

// gltf_node.c

/// Reads hierarchy, transforms and animations; decides which variants of meshes are shown.
STP_MUST_USE stp_result stp_gltf_load_nodes(stp_gltf_scope* scope, stp_gltf* gltf);
/// Scale, then rotation by a quaternion (x, y, z, w) of any length but 0, then translation.
stp_affine stp_gltf_affine_from_parts(const double translation[3], const double rotation[4],
                                      const double scale[3]);
/// The matrices that transform a skin's vertices from the mesh to the world, one per joint
/// (stp_alloc).
STP_MUST_USE stp_result stp_gltf_skin_matrices(stp_gltf_scope* scope, uint32_t skin,
                                               stp_affine** matrices, size_t* count);

// gltf_mesh.c, gltf_object.c

/// Reads the primitives of all variants, in jobs, and adds them to the scene: makes `parts`.
STP_MUST_USE stp_result stp_gltf_load_meshes(stp_gltf_scope* scope, stp_gltf* gltf);
/// Adds the nodes of the scene as objects, with their parts, instances and cameras.
STP_MUST_USE stp_result stp_gltf_add_objects(stp_gltf_scope* scope, stp_gltf* gltf);
