// SPDX-License-Identifier: MIT
// A scene to be looked at, from the command line: a .stip, or a model that is built into a cache first.
#pragma once

#include "command.h"

#include "import/scan_info.h"
#include "scene/scene.h"
#include "select/visibility.h"
#include "store/store.h"

#include <stipple/view.h>

/// Whether a file is a .stip, by its first bytes; what ends within these, by its name.
bool tool_is_store_file(const char* path);

/// Opens `path`. A model (anything that is not a .stip) is built first, unless the cache already holds what the
/// same bytes gave: $XDG_CACHE_HOME/stipple, or ~/.cache/stipple. Failures are logged by the context.
STP_MUST_USE stp_result tool_open_scene(stp_context* context, const char* path, stp_store** store);

/// What a scene is opened for.
typedef enum scene_use {
    SCENE_FOR_METHODS, ///< it needs the splats of all methods
    SCENE_FOR_SPLATS,  ///< it needs those of the first method
    SCENE_FOR_A_PICTURE, ///< of a size at which triangles do as well, where surfels would take longer than them
    SCENE_FOR_ORIGINALS, ///< it needs triangles and points only
} scene_use;

/// For splats of a method, by its id; 0: the file's first.
scene_use scene_use_of_method(uint32_t id);

/// As tool_open_scene. What does not need surfels is built without them, which takes a tenth of the time: for a picture, where
/// the model is large, but not so large that its triangles would take longer to draw than surfels to make.
STP_MUST_USE stp_result tool_open_scene_for(stp_context* context, const char* path, scene_use use,
                                            stp_store** store);

/// The same, also of a .stip that ends early, and of its first bytes alone where `prefix` says so. For a reference
/// (SCENE_FOR_ORIGINALS) the file must be whole.
STP_MUST_USE stp_result tool_open_scene_prefix(stp_context* context, const char* path,
                                               scene_use use, const option_prefix* prefix,
                                               stp_store** store);

/// Where the .stip is that tool_open_scene_for would open, built now where it is not there yet. `located` has room for
/// PATH_MAX bytes. @return STP_OK: it can be opened; else as that
STP_MUST_USE stp_result tool_locate_scene(stp_context* context, const char* path, scene_use use,
                                          char* located);

/// Who looks on while a model is built.
typedef struct scene_watcher {
    /// There is a .stip that can be looked at meanwhile: a former build without surfels, or a draft (build/draft.h). The
    /// same path again: a newer one stands there. On any thread.
    void (*grown)(const char* path, void* user);
    void* user;
} scene_watcher;

/// As tool_locate_scene for SCENE_FOR_METHODS or SCENE_FOR_SPLATS.
/// `draft` (PATH_MAX bytes) is where drafts are, the caller's to remove; empty
/// where none were made. @return STP_ERROR_BUSY (logged) where another process builds the same
STP_MUST_USE stp_result tool_locate_watched(stp_context* context, const char* path, scene_use use,
                                            const scene_watcher* watcher, char* located,
                                            char* draft);

/// Takes what --columns says for all models that are imported or built from now on; NULL is allowed.
/// @return 0, or the code of a usage error where it is no list of columns
int tool_take_columns(const char* names);

/// Imports a model, or makes a named scene (scene:NAME), and finishes it. The caller's (stp_scene_destroy); NULL on
/// failure, which is logged.
STP_MUST_USE stp_result tool_import_scene(stp_context* context, const char* path,
                                          stp_scene** scene);
/// The same with large content in a spill file (stp_scene_use_spill), which must outlive the scene; NULL: none.
STP_MUST_USE stp_result tool_import_spilled(stp_context* context, const char* path,
                                            stp_spill* spill, stp_scene** scene);

/// As tool_import_scene, with what the header of a file of points says. Where scan->alone, the scene has the source, and
/// no points.
STP_MUST_USE stp_result tool_import_described(stp_context* context, const char* path,
                                              stp_scan_info* scan, stp_scene** scene);

/// Sets eye, target and up (and the angle, where the view is a camera with one and `view->fov_degrees` is 0) to
/// a view of the file or a standard one. Standard views fit what is drawn: `visibility` (NULL: everything) and the view's
/// sections say of what; width, height, fov, eye_distance and ortho_height are read. @return false if no view has that name
bool tool_find_view(const stp_store* store, const char* name, const stp_visibility* visibility,
                    stp_view* view);

/// Whether a name means a standard view, not one of the file.
bool tool_is_standard_view(const stp_store* store, const char* name);
