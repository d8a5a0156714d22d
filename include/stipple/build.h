// SPDX-License-Identifier: MIT
//
// A builder: the caller's triangles and points, and model files, to one `.stip` file.
//
//   material <- mesh or points (a part) <- object (name, place, parent)
//
// Each thing that is added gets a number from 1 on; 0 means none, or the default.
#pragma once

#include <stipple/attributes.h>
#include <stipple/image.h>
#include <stipple/types.h>

#include <stdbool.h>

#ifdef __cplusplus
extern "C" {
#endif

/// Collects what to build. Belongs to its context. Builds once: stp_builder_write hands the geometry on.
typedef struct stp_builder stp_builder;

typedef struct stp_builder_desc {
    size_t struct_size;
    /// The axis that points up in what is added ('x', 'y', 'z', or upper case for the negative axis); default 'y'.
    /// Files that say theirs keep it.
    char up;
    double
        unit_metres;  ///< metres of one unit of it; default: unknown. Files that say theirs keep it
    const char* name; ///< of the scene, as sources list it; default "memory"
} stp_builder_desc;

/// @param desc  NULL: all zero
/// @return STP_OK, STP_ERROR_ARGUMENT, STP_ERROR_OUT_OF_MEMORY
STP_API STP_MUST_USE stp_result stp_builder_create(stp_context* context,
                                                   const stp_builder_desc* desc,
                                                   stp_builder** builder);

/// NULL is allowed.
STP_API void stp_builder_destroy(stp_builder* builder);

/// Adds a model file in any format that `stipple build` reads. It is read by stp_builder_write. Formats that the
/// library does not read itself go through a child process with little rights.
/// @return STP_OK, STP_ERROR_OUT_OF_MEMORY
STP_API STP_MUST_USE stp_result stp_builder_add_file(stp_builder* builder, const char* path);

/// How a surface looks. All zero: white, rough, opaque, one-sided.
typedef struct stp_material_desc {
    size_t struct_size;
    const char* name;
    float base_color[4]; ///< linear RGB and opacity, 0 to 1; all zero: 1, 1, 1, 1
    float metallic;      ///< 0 to 1
    float roughness;     ///< 0 to 1; 0: 1
    float emissive[3];   ///< linear
    /// Multiplies the base colour: sRGB and alpha, by the mesh's texcoords, repeated beyond 0 to 1. Copied. NULL: none.
    const stp_image* picture;
    float alpha_cutoff; ///< above 0: what is less opaque is left out
    bool transparent;   ///< opacity below 1 lets through what is behind
    bool double_sided;
    bool unlit;
} stp_material_desc;

/// @return STP_OK, STP_ERROR_ARGUMENT, STP_ERROR_OUT_OF_MEMORY
STP_API STP_MUST_USE stp_result stp_builder_add_material(stp_builder* builder,
                                                         const stp_material_desc* desc,
                                                         uint32_t* material);

/// Triangles of one material. Arrays are copied. Positions are relative to the object that has the mesh: large
/// coordinates belong into the object's transform, which is double.
typedef struct stp_mesh_desc {
    size_t struct_size;
    const char* name;
    const float* positions; ///< 3 a vertex
    const float*
        normals; ///< 3 a vertex; NULL: flat, from the winding (counter-clockwise is the front)
    const float* texcoords; ///< 2 a vertex, (0, 0) is the picture's top left; NULL: none
    const uint8_t* colors;  ///< 4 a vertex, sRGB and alpha, multiply the material's; NULL: none
    size_t vertex_count;
    const uint32_t*
        indices; ///< 3 a triangle, each below vertex_count; NULL: vertices in their order
    size_t triangle_count;
    uint32_t material; ///< 0: the default material
} stp_mesh_desc;

/// @param part  receives its number; may be NULL
/// @return STP_OK, STP_ERROR_ARGUMENT (counts, indices or the material), STP_ERROR_OUT_OF_MEMORY
STP_API STP_MUST_USE stp_result stp_builder_add_mesh(stp_builder* builder,
                                                     const stp_mesh_desc* desc, uint32_t* part);

/// Points, scanned or made. Arrays are copied; see stp_mesh_desc for positions.
typedef struct stp_points_desc {
    size_t struct_size;
    const char* name;
    const float* positions; ///< 3 a point
    const float* normals;   ///< 3 a point, unit; NULL: estimated
    const uint8_t* colors;  ///< 4 a point, sRGB and alpha; NULL: white
    size_t point_count;
    uint32_t material; ///< 0: the default material
    /// By stp_attribute: NULL, or a value a point of the attribute's type (attributes.h).
    const void* attributes[STP_ATTRIBUTES];
} stp_points_desc;

/// @param part  receives its number; may be NULL
/// @return STP_OK, STP_ERROR_ARGUMENT, STP_ERROR_OUT_OF_MEMORY
STP_API STP_MUST_USE stp_result stp_builder_add_points(stp_builder* builder,
                                                       const stp_points_desc* desc, uint32_t* part);

/// A named thing in the scene's tree. Parts that no object has are shown as they are.
typedef struct stp_object_desc {
    size_t struct_size;
    const char* name;
    const char* id;        ///< any text, by which hosts find it again; NULL: none
    uint32_t parent;       ///< an object added before; 0: none
    stp_affine transform;  ///< to the parent; all zero: the identity
    const uint32_t* parts; ///< what it shows, numbers of parts; any object may show a part
    size_t part_count;
    const stp_affine*
        instances; ///< places within the object at which all its parts stand; NULL: one, the identity
    size_t instance_count;
} stp_object_desc;

/// @param object  receives its number; may be NULL
/// @return STP_OK, STP_ERROR_ARGUMENT (no such parent or part), STP_ERROR_OUT_OF_MEMORY
STP_API STP_MUST_USE stp_result stp_builder_add_object(stp_builder* builder,
                                                       const stp_object_desc* desc,
                                                       uint32_t* object);

typedef struct stp_write_desc {
    size_t struct_size;
    /// The file, written aside and renamed when it is complete. A folder PATH.work holds results meanwhile; after an
    /// interruption the same build goes on from there. NULL: the file is built in memory (stp_builder_get_bytes).
    const char* path;
    const char* folder;  ///< without a path: where temporary files go; default $TMPDIR or /tmp
    const char* methods; ///< "blue" (default), "spt", "psp", "stochastic", or several: "blue,psp"
    uint32_t
        splat_limit; ///< most splats of a node; 0: one for 8 triangles, at most 50,000; all points of a cloud
    uint64_t threshold; ///< a node of triangles gets splats above so many; default 1,000
    uint64_t
        memory_bytes; ///< what the build may use; default: the context's limit, or most of the machine's
    bool fresh;       ///< takes nothing from an earlier build
} stp_write_desc;

typedef struct stp_write_report {
    size_t struct_size;
    double seconds;
    uint64_t file_bytes;
    uint32_t sets_made, sets_found; ///< of splats: made now, and found of an earlier build
} stp_write_report;

/// Builds and writes. Reports progress and can be cancelled through the context's callback. The same input and options
/// give the same bytes, for any number of threads. Afterwards the builder is spent: only stp_builder_get_bytes and
/// stp_builder_destroy may follow.
/// @return STP_OK; STP_ERROR_ARGUMENT, STP_ERROR_IO, STP_ERROR_BUSY (another program builds the same file),
/// STP_ERROR_CANCELLED, STP_ERROR_LIMIT, STP_ERROR_OUT_OF_MEMORY, and of files as stp_model_open
STP_API STP_MUST_USE stp_result stp_builder_write(stp_builder* builder, const stp_write_desc* desc,
                                                  stp_write_report* report);

/// The bytes of a file that was built in memory, aligned for stp_model_desc.bytes. They belong to the builder: models
/// opened from them must be closed before it is destroyed. NULL where there are none.
STP_API const void* stp_builder_get_bytes(const stp_builder* builder, size_t* size);

#ifdef __cplusplus
}
#endif
