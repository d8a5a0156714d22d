// SPDX-License-Identifier: MIT
//
// A builder turns the caller's triangles and points, and model files, into one `.stip` file.
//
//   material <- mesh or points (a part) <- object (name, place, parent)
//
// Everything added gets a number, from 1; 0 means none, or the default.
#pragma once

#include <stipple/attributes.h>
#include <stipple/image.h>
#include <stipple/types.h>

#include <stdbool.h>

#ifdef __cplusplus
extern "C" {
#endif

/// Collects the input of a build. Belongs to its context. Builds once: stp_builder_write consumes
/// the geometry.
typedef struct stp_builder stp_builder;

typedef struct stp_builder_desc {
    size_t struct_size;
    /// Up axis of the input ('x', 'y', 'z', or upper case for the negative axis); default 'y'.
    /// Files that declare an up axis keep their own.
    char up;
    double unit_metres; ///< metres per unit; default: unknown. Files that declare a unit keep it
    const char* name;   ///< name of the scene in the list of sources; default "memory"
} stp_builder_desc;

/// @param desc  NULL: all zero
/// @return STP_OK, STP_ERROR_ARGUMENT, STP_ERROR_OUT_OF_MEMORY
STP_API STP_MUST_USE stp_result stp_builder_create(stp_context* context,
                                                   const stp_builder_desc* desc,
                                                   stp_builder** builder);

/// NULL is allowed.
STP_API void stp_builder_destroy(stp_builder* builder);

/// Adds a model file in any format that `stipple build` reads. stp_builder_write reads the file.
/// Formats that the library does not read itself are converted in a sandboxed child process.
/// @return STP_OK, STP_ERROR_ARGUMENT (already written), STP_ERROR_OUT_OF_MEMORY
STP_API STP_MUST_USE stp_result stp_builder_add_file(stp_builder* builder, const char* path);

/// Appearance of a surface, which is drawn from both sides. All zero: white, rough, opaque.
typedef struct stp_material_desc {
    size_t struct_size;
    const char* name;
    float base_color[4]; ///< linear RGB and opacity, 0 to 1; all zero: 1, 1, 1, 1
    float metallic;      ///< 0 to 1
    float roughness;     ///< 0 to 1; 0: 1
    float emissive[3];   ///< linear
    /// Multiplies the base colour: sRGB and alpha, by the mesh's texcoords, repeated beyond 0 to 1.
    /// Copied. NULL: none.
    const stp_image* picture;
    float alpha_cutoff; ///< above 0: parts with less opacity are cut out
    bool transparent;   ///< opacity below 1 is blended
    bool double_sided;  ///< recorded; changes no picture
    bool unlit;
    /// Bytes from the start of a row of `picture` to that of the next, at least 4 * width; 0:
    /// 4 * width.
    size_t picture_stride;
} stp_material_desc;

/// @return STP_OK, STP_ERROR_ARGUMENT, STP_ERROR_OUT_OF_MEMORY
STP_API STP_MUST_USE stp_result stp_builder_add_material(stp_builder* builder,
                                                         const stp_material_desc* desc,
                                                         uint32_t* material);

/// Triangles of one material. Arrays are copied. Positions are relative to the object that has the
/// mesh: put large coordinates into the object's transform, which is in double precision.
typedef struct stp_mesh_desc {
    size_t struct_size;
    const char* name;
    const float* positions; ///< 3 per vertex
    /// 3 per vertex; NULL: flat, from the winding (counter-clockwise is the front)
    const float* normals;
    const float* texcoords; ///< 2 per vertex, (0, 0) is the image's top left; NULL: none
    const uint8_t* colors;  ///< 4 per vertex, sRGB and alpha, multiply the material's; NULL: none
    size_t vertex_count;
    const uint32_t* indices; ///< 3 per triangle, each below vertex_count; NULL: vertices in order
    size_t triangle_count;
    uint32_t material; ///< 0: the default material
} stp_mesh_desc;

/// @param part  receives its number; may be NULL
/// @return STP_OK, STP_ERROR_ARGUMENT (counts, indices or the material), STP_ERROR_OUT_OF_MEMORY
STP_API STP_MUST_USE stp_result stp_builder_add_mesh(stp_builder* builder,
                                                     const stp_mesh_desc* desc, uint32_t* part);

/// Points, scanned or generated. Arrays are copied; see stp_mesh_desc for positions.
typedef struct stp_points_desc {
    size_t struct_size;
    const char* name;
    const float* positions; ///< 3 per point
    const float* normals;   ///< 3 per point, unit length; NULL: estimated
    const uint8_t* colors;  ///< 4 per point, sRGB and alpha; NULL: white
    size_t point_count;
    uint32_t material; ///< 0: the default material
    /// Indexed by stp_attribute: NULL, or one value per point, of the attribute's type
    /// (attributes.h).
    const void* attributes[STP_ATTRIBUTES];
} stp_points_desc;

/// @param part  receives its number; may be NULL
/// @return STP_OK, STP_ERROR_ARGUMENT, STP_ERROR_OUT_OF_MEMORY
STP_API STP_MUST_USE stp_result stp_builder_add_points(stp_builder* builder,
                                                       const stp_points_desc* desc, uint32_t* part);

/// A named object in the scene tree. Parts that belong to no object are shown untransformed.
typedef struct stp_object_desc {
    size_t struct_size;
    const char* name;
    const char* id;        ///< any text, for the host to find the object again; NULL: none
    uint32_t parent;       ///< an object added before; 0: none
    stp_affine transform;  ///< to the parent; all zero: the identity
    const uint32_t* parts; ///< numbers of the parts it shows; objects may share parts
    size_t part_count;
    /// Instances of all its parts within the object; instance_count 0: one, the identity
    const stp_affine* instances;
    size_t instance_count;
} stp_object_desc;

/// @param object  receives its number; may be NULL
/// @return STP_OK, STP_ERROR_ARGUMENT (no such parent or part), STP_ERROR_OUT_OF_MEMORY
STP_API STP_MUST_USE stp_result stp_builder_add_object(stp_builder* builder,
                                                       const stp_object_desc* desc,
                                                       uint32_t* object);

typedef struct stp_write_desc {
    size_t struct_size;
    /// Output file: written under a temporary name, and renamed when complete. The folder PATH.work
    /// keeps intermediate results, so that an interrupted build can resume. NULL: builds in memory
    /// (stp_builder_get_bytes).
    const char* path;
    const char* folder;  ///< without a path: folder for temporary files; default $TMPDIR or /tmp
    const char* methods; ///< "blue" (default), "spt", "psp", "stochastic", or several: "blue,psp"
    /// Most splats of a node, which has fewer where `triangles_per_splat` asks for fewer; 0:
    /// 50,000; of a cloud all points
    uint32_t splat_limit;
    uint64_t threshold; ///< mesh nodes with more triangles get splats; default 1,000
    /// Memory limit of the build; default: the context's limit, or most of the machine's memory
    uint64_t memory_bytes;
    bool fresh; ///< reuses nothing from an earlier build
    /// A mesh node has one splat for so many triangles; 0: 8. Brandt 5.2: 2, and at most 200,000
    double triangles_per_splat;
} stp_write_desc;

typedef struct stp_write_report {
    size_t struct_size;
    double seconds;
    uint64_t file_bytes;
    uint32_t sets_made, sets_found; ///< splat sets built now, and reused from an earlier build
} stp_write_report;

/// Builds and writes. Reports progress and can be cancelled through the context's callback. The
/// same input and options give the same bytes, for any number of threads. Afterwards only
/// stp_builder_get_bytes and stp_builder_destroy may be called, unless the options were refused
/// (STP_ERROR_ARGUMENT) or nothing was added: then the builder is as before.
/// @return STP_OK; STP_ERROR_ARGUMENT, STP_ERROR_IO, STP_ERROR_BUSY (another program builds the
/// same file), STP_ERROR_CANCELLED, STP_ERROR_LIMIT, STP_ERROR_OUT_OF_MEMORY, and for input files
/// the results of stp_model_open
STP_API STP_MUST_USE stp_result stp_builder_write(stp_builder* builder, const stp_write_desc* desc,
                                                  stp_write_report* report);

/// Bytes of a file built in memory, aligned for stp_model_desc.bytes. The builder owns them: close
/// models opened from them before destroying it. NULL if there are none. `size` may be NULL.
STP_API const void* stp_builder_get_bytes(const stp_builder* builder, size_t* size);

#ifdef __cplusplus
}
#endif
