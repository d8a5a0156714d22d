// SPDX-License-Identifier: MIT
//
// A model is a `.stip` file opened for reading: its contents, stored views, visibility and
// streaming state.
#pragma once

#include <stipple/attributes.h>
#include <stipple/view.h>

#include <stdbool.h>

#ifdef __cplusplus
extern "C" {
#endif

/// An opened file. Belongs to its context, which must outlive it, and to one thread at a time.
typedef struct stp_model stp_model;

/// Reads `size` bytes at `offset` of the caller's file. @return 0, or any other value on failure
typedef int (*stp_read_callback)(void* user, uint64_t offset, void* bytes, size_t size);

/// Colouring of scanned points, and hidden classes. All zero: the file's colours, all classes
/// shown.
typedef struct stp_point_coloring {
    bool by_attribute; ///< colour by `attribute`, for points that have it
    stp_attribute attribute;
    double low, high; ///< ends of the colour scale; both 0: the file's percentiles 2 and 98
    /// Indexed by class (STP_ATTRIBUTE_CLASS): non-zero hides its points
    uint8_t class_hidden[256];
} stp_point_coloring;

/// Location of a file, and how to open it. Exactly one of `path`, `bytes` and `read` is set.
typedef struct stp_model_desc {
    size_t struct_size;
    /// Path of a file, which is memory-mapped. It may be replaced by renaming, but must not be
    /// truncated while open.
    const char* path;
    /// `size` bytes that must stay unchanged until the model is closed. Used in place if aligned to
    /// 64 bytes, copied otherwise.
    const void* bytes;
    /// Called by stp_model_open on its thread; with `stream`, also later, by several threads at
    /// once, until the model is closed. Without `stream`, the whole file is read at once.
    stp_read_callback read;
    void* read_user;
    uint64_t size;    ///< size of `bytes`, or of the file behind `read`, in bytes
    const char* name; ///< name in messages if there is no path; default "memory"
    /// Accepts a truncated file, such as a download in progress, if its directory is complete. The
    /// part that is present is drawn. Not with `read`.
    bool accept_prefix;
    /// Streams: loads geometry and textures as views need them, and evicts them under a memory
    /// limit. stp_model_open loads the coarsest level of everything. Uses two reading threads of
    /// its own.
    bool stream;
    /// Limit on streamed data in bytes; 0: the rest of the context's memory_limit_bytes (or no
    /// limit).
    uint64_t stream_bytes;
    stp_point_coloring point_coloring;
} stp_model_desc;

/// Opens a file and checks its directory; geometry is checked when it is first needed.
/// @return STP_OK; STP_ERROR_ARGUMENT (not exactly one source), STP_ERROR_IO, STP_ERROR_TRUNCATED,
/// STP_ERROR_FORMAT, STP_ERROR_VERSION, STP_ERROR_UNSUPPORTED, STP_ERROR_LIMIT (no threads for
/// streaming), STP_ERROR_OUT_OF_MEMORY, STP_ERROR_CANCELLED (by the context's progress, while a
/// callback reads)
STP_API STP_MUST_USE stp_result stp_model_open(stp_context* context, const stp_model_desc* desc,
                                               stp_model** model);

/// Destroy all painters of the model first. NULL is allowed.
STP_API void stp_model_close(stp_model* model);

/// Contents of the file. Counts include all instances; `stored_...` counts each shared item once.
typedef struct stp_model_info {
    size_t struct_size;
    uint32_t format_major, format_minor; ///< version of the file
    uint64_t file_bytes;                 ///< according to its header
    uint64_t present_bytes;              ///< less if the file is truncated
    double unit_metres;                  ///< metres of one unit; 0: unknown
    char up;                             ///< the input's up axis, 'x', 'y' or 'z'; inside, y is up
    stp_boxd bounds;                     ///< scene space; max < min if the scene is empty
    uint64_t triangle_count, point_count, splat_count;
    uint64_t stored_triangle_count, stored_point_count, stored_splat_count;
    uint32_t object_count; ///< objects of the scene tree
    uint32_t view_count, method_count, source_count;
    uint32_t material_count, texture_count, mesh_count;
    uint32_t attributes; ///< attributes that points have, one bit each (stp_attribute_bit)
    const char* coordinate_system; ///< WKT or "EPSG:25832", if the sources agree; NULL: unknown
    const char* build_json;        ///< options of the build, one JSON object; NULL: not stored
} stp_model_info;

STP_API STP_MUST_USE stp_result stp_model_get_info(const stp_model* model, stp_model_info* info);

#define STP_NO_OBJECT UINT32_MAX

/// A named object of the scene tree, as in the input.
typedef struct stp_object_info {
    size_t struct_size;
    const char* name; ///< NULL: none
    const char* id;   ///< the input's own id or extras, as JSON text; NULL: none
    uint32_t parent;  ///< STP_NO_OBJECT: a root object
    /// Whether the object itself is placed in the scene. False if it has no visible content, or is
    /// part of a prototype, which is shown where other objects use it.
    bool placed;
    stp_affine transform; ///< to scene space, if placed
    stp_boxd bounds;      ///< scene space; empty if not placed
    uint64_t triangle_count, point_count;
    uint64_t child_count;
} stp_object_info;

/// `object` is below stp_model_info.object_count; STP_NO_OBJECT describes the whole scene. The
/// first call takes time proportional to the number of objects.
/// @return STP_OK, STP_ERROR_ARGUMENT, STP_ERROR_FORMAT, STP_ERROR_OUT_OF_MEMORY
STP_API STP_MUST_USE stp_result stp_model_get_object(stp_model* model, uint32_t object,
                                                     stp_object_info* info);

/// Children `first` to `first + room` - 1 of an object (STP_NO_OBJECT: the root objects), in file
/// order. For an object that uses a prototype, includes the prototype's children. `count` receives
/// the number written.
/// @return as stp_model_get_object
STP_API STP_MUST_USE stp_result stp_model_get_children(stp_model* model, uint32_t object,
                                                       uint64_t first, uint32_t room,
                                                       uint32_t* objects, uint32_t* count);

/// The first object, from number `from`, whose name, id, path suffix ("house/door") or number
/// ("#7") equals `text`; STP_NO_OBJECT if there is none. @return as stp_model_get_object
STP_API STP_MUST_USE stp_result stp_model_find_object(stp_model* model, const char* text,
                                                      uint32_t from, uint32_t* object);

/// How an object is drawn.
typedef enum stp_appearance {
    STP_APPEARANCE_SHOWN,
    STP_APPEARANCE_HIDDEN, ///< neither drawn nor picked
    /// Drawn in a share of its pixels (stp_paint_desc.ghost); the background shows through
    STP_APPEARANCE_GHOST,
} stp_appearance;

/// Sets the appearance of an object and everything below it, overriding earlier settings there.
/// STP_NO_OBJECT sets the whole scene. To isolate an object, hide the scene, then show the object.
/// @return STP_OK, STP_ERROR_ARGUMENT (the object is not placed), STP_ERROR_LIMIT (it has too many
/// instances), STP_ERROR_FORMAT, STP_ERROR_OUT_OF_MEMORY
STP_API STP_MUST_USE stp_result stp_model_set_appearance(stp_model* model, uint32_t object,
                                                         stp_appearance appearance);

/// Name of a stored view; NULL unless `view` is below stp_model_info.view_count.
STP_API const char* stp_model_get_view_name(const stp_model* model, uint32_t view);

/// Points `view` at the scene: sets eye, target, up and fov_degrees. `name` is a stored view, or a
/// standard view that fits the content of the scene (while data is streamed, its bounds): "front",
/// "back", "left", "right", "top", "bottom", "iso"; NULL: the file's first view, else "iso". Set
/// width, height, ortho_height and sections before the call. Standard views keep a fov_degrees
/// above 0; else they use 40.
/// @return STP_OK, STP_ERROR_ARGUMENT (no such view, or a size of 0)
STP_API STP_MUST_USE stp_result stp_model_get_view(const stp_model* model, const char* name,
                                                   stp_view* view);

/// A method: the algorithm that chose a file's splats.
typedef struct stp_method_info {
    size_t struct_size;
    const char* name;   ///< "blue", "spt", "psp", "stochastic"
    uint32_t set_count; ///< nodes with splats of this method
} stp_method_info;

/// `method` is below stp_model_info.method_count; the first is the default. @return STP_OK,
/// STP_ERROR_ARGUMENT
STP_API STP_MUST_USE stp_result stp_model_get_method(const stp_model* model, uint32_t method,
                                                     stp_method_info* info);

/// A file that the model was built from.
typedef struct stp_source_info {
    size_t struct_size;
    const char* path;
    const char* format; ///< "gltf", "las", ...
    uint64_t bytes;
    const char* coordinate_system; ///< NULL: unknown
} stp_source_info;

/// `source` is below stp_model_info.source_count. @return STP_OK, STP_ERROR_ARGUMENT
STP_API STP_MUST_USE stp_result stp_model_get_source(const stp_model* model, uint32_t source,
                                                     stp_source_info* info);

/// Range of a point attribute.
typedef struct stp_attribute_info {
    size_t struct_size;
    uint64_t count; ///< points that have it
    double low, high;
    double low_percentile, high_percentile; ///< percentiles 2 and 98
} stp_attribute_info;

/// @return STP_OK, STP_ERROR_ARGUMENT (the file does not have it: see stp_model_info.attributes)
STP_API STP_MUST_USE stp_result stp_model_get_attribute(const stp_model* model,
                                                        stp_attribute attribute,
                                                        stp_attribute_info* info);

/// Streaming state. All zero for a model that does not stream.
typedef struct stp_stream_info {
    size_t struct_size;
    uint64_t limit_bytes, resident_bytes, peak_bytes;
    uint64_t read_bytes;      ///< since the model was opened
    uint64_t loaded, dropped; ///< blocks, since then
    uint64_t damaged;         ///< blocks that cannot be read; a warning names each
    uint32_t missing;         ///< items that the last picture wanted at a finer level
    uint32_t loading;         ///< those of them being read
} stp_stream_info;

STP_API STP_MUST_USE stp_result stp_model_get_stream(const stp_model* model, stp_stream_info* info);

#ifdef __cplusplus
}
#endif
