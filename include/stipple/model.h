// SPDX-License-Identifier: MIT
//
// A model: a `.stip` file opened for reading. What is in it, where to look from, what is shown, and how much of
// it is in memory.
#pragma once

#include <stipple/attributes.h>
#include <stipple/view.h>

#include <stdbool.h>

#ifdef __cplusplus
extern "C" {
#endif

/// An opened file. Belongs to its context, which must outlive it, and to one thread at a time.
typedef struct stp_model stp_model;

/// Reads `size` bytes at `offset` of a file that the caller keeps. @return 0, or any other value where it cannot
typedef int (*stp_read_callback)(void* user, uint64_t offset, void* bytes, size_t size);

/// How scanned points are coloured, and which classes of them are hidden. All zero: colours of the file, all shown.
typedef struct stp_point_coloring {
    bool by_attribute; ///< colour from `attribute`, for points that have it
    stp_attribute attribute;
    double low, high; ///< ends of the colour scale; both 0: percentiles 2 and 98 of the file
    uint8_t class_hidden[256]; ///< by class (STP_ATTRIBUTE_CLASS): not 0 hides its points
} stp_point_coloring;

/// Where a file is and how to open it. Exactly one of `path`, `bytes` and `read` is set.
typedef struct stp_model_desc {
    size_t struct_size;
    /// A file, which is mapped. It may be replaced by renaming, but must not be cut short while it is open.
    const char* path;
    /// `size` bytes that stay as they are until the model is closed. They are used in place where they are aligned
    /// to 64 bytes, and copied otherwise.
    const void* bytes;
    /// Called by stp_model_open on its thread; with `stream`, also later, by several threads at once, until the
    /// model is closed. Without `stream`, the whole file is read at once.
    stp_read_callback read;
    void* read_user;
    uint64_t size;    ///< of `bytes`, or of the file behind `read`
    const char* name; ///< in messages, where there is no path; default "memory"
    /// Accepts a file that ends early, a download that goes on, as long as its directory is there: it is drawn as
    /// far as it goes. Not with `read`.
    bool accept_prefix;
    /// Loads geometry and textures as views need them, and drops them again under a limit of memory. The coarsest
    /// of everything is loaded by stp_model_open. Needs two threads of its own for reading.
    bool stream;
    /// Most bytes of streamed data; 0: what the context's memory_limit_bytes leaves (or no limit).
    uint64_t stream_bytes;
    stp_point_coloring point_coloring;
} stp_model_desc;

/// Opens a file and checks its directory; geometry is checked when it is first needed.
/// @return STP_OK; STP_ERROR_ARGUMENT (not exactly one source), STP_ERROR_IO, STP_ERROR_TRUNCATED,
/// STP_ERROR_FORMAT, STP_ERROR_VERSION, STP_ERROR_UNSUPPORTED, STP_ERROR_LIMIT (no threads for streaming),
/// STP_ERROR_OUT_OF_MEMORY, STP_ERROR_CANCELLED (by the context's progress, while a callback reads)
STP_API STP_MUST_USE stp_result stp_model_open(stp_context* context, const stp_model_desc* desc,
                                               stp_model** model);

/// All painters of the model must be gone. NULL is allowed.
STP_API void stp_model_close(stp_model* model);

/// What the file holds. Counts include all instances; `stored_...` count each shared thing once.
typedef struct stp_model_info {
    size_t struct_size;
    uint32_t format_major, format_minor; ///< version of the file
    uint64_t file_bytes;                 ///< as its header says
    uint64_t present_bytes;              ///< less where the file ends early
    double unit_metres;                  ///< metres of one unit; 0: unknown
    char up;                             ///< the input's up axis, 'x', 'y' or 'z'; inside, y is up
    stp_boxd bounds;                     ///< scene space; max < min where nothing is in it
    uint64_t triangles, points, splats;
    uint64_t stored_triangles, stored_points, stored_splats;
    uint32_t object_count; ///< of the tree of named things
    uint32_t view_count, method_count, source_count;
    uint32_t material_count, texture_count, mesh_count;
    uint32_t attributes;           ///< of points, a bit each (stp_attribute_bit)
    const char* coordinate_system; ///< WKT or "EPSG:25832", where the sources agree; NULL: unknown
    const char* build_json;        ///< options of the build, one JSON object; NULL: not stored
} stp_model_info;

STP_API STP_MUST_USE stp_result stp_model_get_info(const stp_model* model, stp_model_info* info);

#define STP_NO_OBJECT UINT32_MAX

/// A named thing of the scene's tree, as the input wrote it.
typedef struct stp_object_info {
    size_t struct_size;
    const char* name; ///< NULL: none
    const char* id;   ///< the input's own id or extras, as JSON text; NULL: none
    uint32_t parent;  ///< STP_NO_OBJECT: an uppermost one
    /// Whether it stands in the scene by itself. Not where nothing of it can be seen, nor below a prototype: that
    /// is shown where other objects use it.
    bool placed;
    stp_affine transform; ///< to scene space, of a placed object
    stp_boxd bounds;      ///< scene space; empty where it is not placed
    uint64_t triangles, points;
    uint64_t child_count;
} stp_object_info;

/// `object` is below stp_model_info.object_count; STP_NO_OBJECT describes the whole scene. The first call for objects
/// takes time that grows with their number.
/// @return STP_OK, STP_ERROR_ARGUMENT, STP_ERROR_FORMAT, STP_ERROR_OUT_OF_MEMORY
STP_API STP_MUST_USE stp_result stp_model_get_object(stp_model* model, uint32_t object,
                                                     stp_object_info* info);

/// Children `first` to `first + room` - 1 of an object (STP_NO_OBJECT: the uppermost ones), in the file's order; of an
/// object that uses a prototype, those of the prototype too. `count` receives how many were given.
/// @return as stp_model_get_object
STP_API STP_MUST_USE stp_result stp_model_get_children(stp_model* model, uint32_t object,
                                                       uint64_t first, uint32_t room,
                                                       uint32_t* objects, uint32_t* count);

/// The first object from number `from` on whose name, id, end of path ("house/door") or number ("#7") is `text`;
/// STP_NO_OBJECT where there is none. @return as stp_model_get_object
STP_API STP_MUST_USE stp_result stp_model_find_object(stp_model* model, const char* text,
                                                      uint32_t from, uint32_t* object);

/// How an object is drawn.
typedef enum stp_appearance {
    STP_APPEARANCE_SHOWN,
    STP_APPEARANCE_HIDDEN, ///< neither drawn nor picked
    STP_APPEARANCE_GHOST, ///< drawn in a part of its pixels (stp_paint_desc.ghost); what is behind shows through
} stp_appearance;

/// Sets an object with all that is below it, whatever was set of that before; STP_NO_OBJECT sets the whole scene. To
/// isolate an object, hide the scene and show the object.
/// @return STP_OK, STP_ERROR_ARGUMENT (the object is not placed), STP_ERROR_LIMIT (its places are too many),
/// STP_ERROR_FORMAT, STP_ERROR_OUT_OF_MEMORY
STP_API STP_MUST_USE stp_result stp_model_set_appearance(stp_model* model, uint32_t object,
                                                         stp_appearance appearance);

/// Name of a view that the file stores; `view` is below stp_model_info.view_count, else NULL.
STP_API const char* stp_model_get_view_name(const stp_model* model, uint32_t view);

/// Points `view` at the scene: eye, target, up and fov_degrees are set. `name` is a view of the file or a standard one
/// that fits the scene's bounds: "front", "back", "left", "right", "top", "bottom", "iso"; NULL: the file's first
/// view, else "iso". width, height, ortho_height and sections are read and must be set before; a fov_degrees that is
/// above 0 is kept by standard views.
/// @return STP_OK, STP_ERROR_ARGUMENT (no such view, or a size of 0)
STP_API STP_MUST_USE stp_result stp_model_look(const stp_model* model, const char* name,
                                               stp_view* view);

/// A method, that is, how a file's splats were chosen.
typedef struct stp_method_info {
    size_t struct_size;
    const char* name;   ///< "blue", "spt", "psp", "stochastic"
    uint32_t set_count; ///< nodes that have splats of it
} stp_method_info;

/// `method` is below stp_model_info.method_count; the first is the default. @return STP_OK, STP_ERROR_ARGUMENT
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
    double low_percentile, high_percentile; ///< 2 and 98 of 100 lie below
} stp_attribute_info;

/// @return STP_OK, STP_ERROR_ARGUMENT (the file does not have it: see stp_model_info.attributes)
STP_API STP_MUST_USE stp_result stp_model_get_attribute(const stp_model* model,
                                                        stp_attribute attribute,
                                                        stp_attribute_info* info);

/// Streamed data. All zero for a model that does not stream.
typedef struct stp_stream_info {
    size_t struct_size;
    uint64_t limit_bytes, resident_bytes, peak_bytes;
    uint64_t read_bytes;      ///< since the model was opened
    uint64_t loaded, dropped; ///< pieces, since then
    uint64_t damaged;         ///< pieces that cannot be read; each was named in a warning
    uint32_t missing;         ///< things that the last picture wanted finer than they were
    uint32_t loading;         ///< of them, those being read
} stp_stream_info;

STP_API STP_MUST_USE stp_result stp_model_get_stream(const stp_model* model, stp_stream_info* info);

#ifdef __cplusplus
}
#endif
