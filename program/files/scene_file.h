// SPDX-License-Identifier: MIT
// Scenes from the command line: opens a .stip, or builds a model into a cache first. Imports
// models, and finds named views and the files that a model references.
#pragma once

#include "base/io/file.h"
#include "base/io/hash.h"
#include "import/reading/scan_info.h"
#include "program/options/command.h"
#include "scene/scene.h"
#include "select/farthest.h"
#include "store/file/store.h"

#include <stipple/view.h>

/// Whether a file is a .stip, by its first bytes, or by its name if it is shorter than these.
bool tool_is_store_file(const char* path);

/// Opens `path`. A model (anything but a .stip) is built first, unless the cache
/// ($XDG_CACHE_HOME/stipple, or ~/.cache/stipple) holds a build of the same bytes. Failures are
/// logged by the context.
STP_MUST_USE stp_result tool_open_scene(stp_context* context, const char* path, stp_store** store);

/// Purpose of opening a scene.
typedef enum scene_use {
    SCENE_FOR_METHODS,   ///< needs the splats of all methods
    SCENE_FOR_SPLATS,    ///< needs the splats of the first method
    SCENE_FOR_A_PICTURE, ///< triangles suffice if they are quicker than making splats
    SCENE_FOR_ORIGINALS, ///< needs only triangles and points
} scene_use;

/// For splats of the method with this id; 0: the file's first method.
scene_use scene_use_of_method(uint32_t id);

/// As tool_open_scene, but builds without splats, in a tenth of the time, if they are not needed:
/// for a picture of a large model whose triangles draw faster than splats can be made.
STP_MUST_USE stp_result tool_open_scene_for(stp_context* context, const char* path, scene_use use,
                                            stp_store** store);

/// Same, and also accepts a partial .stip, one that ends early; with `part`, uses only that much. A
/// reference (SCENE_FOR_ORIGINALS) needs the complete file.
STP_MUST_USE stp_result tool_open_partial_scene(stp_context* context, const char* path,
                                                scene_use use, const option_partial_file* part,
                                                stp_store** store);

/// What is shown: a .stip, or models that make one scene.
typedef struct scene_input {
    const char* const* paths;
    size_t count;       ///< at least 1
    char up;            ///< corrects the up axis of models (stp_import_desc.up); 0: as in the files
    double unit_metres; ///< corrects their unit; 0: as in the files
} scene_input;

/// Callbacks while a model is built.
typedef struct scene_watcher {
    /// Reports a .stip that can be shown in the meantime: an earlier build without splats, or a
    /// draft (builder/draft.h). If a path repeats, the file was replaced. Called on any thread.
    void (*grown)(const char* path, void* user);
    void* user;
} scene_watcher;

/// Path of the .stip that shows an input, as tool_open_scene_for would open it for
/// SCENE_FOR_METHODS or SCENE_FOR_SPLATS; builds it if needed. `located` and `draft` have room for
/// PATH_MAX bytes. `draft` receives the path of drafts, which the caller removes; empty if there
/// are none. @return as tool_open_scene_for; STP_ERROR_BUSY (logged) if another process builds the
/// same
STP_MUST_USE stp_result tool_locate_watched(stp_context* context, const scene_input* input,
                                            scene_use use, const scene_watcher* watcher,
                                            char* located, char* draft);

/// Imports a model or makes a named scene (scene:NAME), and finishes it. The caller destroys it
/// with stp_scene_destroy; NULL on failure, which is logged.
STP_MUST_USE stp_result tool_import_scene(stp_context* context, const char* path,
                                          stp_scene** scene);
/// Same, with large content in a spill file (stp_scene_use_spill), which must outlive the scene;
/// NULL: none.
STP_MUST_USE stp_result tool_import_spilled(stp_context* context, const char* path,
                                            stp_spill* spill, stp_scene** scene);

/// As tool_import_scene, plus the header of a file of points. If scan->alone, the scene has the
/// source but no points.
STP_MUST_USE stp_result tool_import_described(stp_context* context, const char* path,
                                              stp_scan_info* scan, stp_scene** scene);

/// Sets eye, target and up of `view` from a named view of the file, and the field of view if that
/// is a camera with one and `view->fov_degrees` is 0. @return false if the file has no such view
bool tool_find_stored_view(const stp_store* store, const char* name, stp_view* view);

/// The same for a named view of the file or a standard view. Standard views fit the visible content
/// without what the view's sections cut away; they use width, height, fov (0: STP_CAMERA_FOV),
/// eye_distance and ortho_height. @return false if no view has that name
bool tool_find_view(const stp_farthest_store* content, const char* name, stp_view* view);

/// Whether a name is that of a standard view.
bool tool_is_standard_view(const stp_store* store, const char* name);

// Files next to a model that it references: buffers, pictures, material libraries.

/// Adds to `hash` the name, size and time of each file in the model's folder whose name (three
/// bytes or more) occurs in the model's first 16 MiB. The folder's listing order does not matter.
/// The text is read once for any number of files. If memory runs out, nothing is added.
void neighbours_hash(const char* path, const stp_mapped_file* file, stp_hash* hash);
