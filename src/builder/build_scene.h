// SPDX-License-Identifier: MIT
//
// The offline build: import, partition, splats bottom-up, clusters, write.
//
// Until the file is written, intermediate results are kept in a work folder beside the output,
// FILE.stip.work: a killed build continues from there. An existing output of the same name also
// supplies results that have not changed.
#pragma once

#include "import/reading/import.h"
#include "lod/blue/blue.h"
#include "lod/method.h"
#include "scene/partition.h"

#define STP_BUILD_DEFAULT_THRESHOLD 1000u ///< triangles (Brandt 5.2)

typedef struct stp_build_desc {
    const char* const* inputs; ///< files, or "scene:NAME" for `generate`
    size_t input_count;
    const char* output;
    stp_import_desc import;
    stp_partition_desc partition;
    /// The build sets `sets`, `splat_count` and `capture.textures`.
    stp_blue_desc blue;
    stp_splat_rule splat_rule; ///< splats of each node; zeroed: the default
    /// Methods whose sets the file holds, each at most once. Readers that do not choose use the
    /// first. None: `blue`.
    const stp_method* const* methods;
    uint32_t method_count;
    /// Also makes a few ellipses of each uppermost set, if the first method is `blue` and none is
    /// `psp`: they are drawn where few splats suffice (stp_method_coarse).
    bool coarse;
    stp_method_options method_options; ///< used if there are methods other than `blue`
    /// Nodes with more triangles get splats; 0: STP_BUILD_DEFAULT_THRESHOLD
    uint64_t threshold;
    /// Called once the scene is finished: whether it gets splats at all. If not, the file holds
    /// only the original triangles and points. NULL: it does.
    bool (*wants_splats)(const stp_scene* scene, void* user);
    void* wants_splats_user;
    bool no_levels;      ///< no levels of triangles (lod/levels/node_levels.h)
    bool from_triangles; ///< upper nodes capture triangles, not their children's splats (3.4)
    bool fresh;          ///< ignores results of previous builds
    /// Limit on the context's memory; 0: the context's own. Nodes in progress use most of it.
    uint64_t memory_bytes;
    const char* parameters_json; ///< the user's parameters, written into the file
    /// Path of drafts: the unfinished scene is written there repeatedly as a separate file, for
    /// display during the build (builder/draft.h). A draft replaces the one before by renaming; the
    /// caller removes the last one. NULL: no drafts.
    const char* draft;
    /// Points of a scan in its first draft, before the scan is read. Default 1,000,000.
    uint32_t draft_sample;
    bool draft_always; ///< after each mesh and each set, even in short builds: for tests
    /// Called after each draft, on any thread of the build. May be NULL.
    void (*drafted)(void* user);
    void* drafted_user;
    /// Adds a scene; `name` is the input with its "scene:". NULL: such inputs are files.
    stp_result (*generate)(stp_scene* scene, const char* name, void* user);
    void* generate_user;
} stp_build_desc;

typedef struct stp_build_report {
    double import_s, partition_s, clusters_s, write_s, total_s;
    double capture_s, order_s, finish_s; ///< shares of the time for splats chosen from candidates
    double splat_thread_s;               ///< sum of these over all threads
    double levels_s;                     ///< for levels of triangles
    double methods_s;                    ///< for sets of methods other than `blue`
    uint64_t candidates;
    // Made by this build, or found in an older work folder or output.
    uint32_t sets_made, sets_found;
    uint32_t meshes_made, meshes_found;
    uint32_t levels_made, levels_found; ///< nodes that may have levels of triangles
    uint64_t work_bytes;                ///< bytes of results in the work folder, found and stored
} stp_build_report;

/// The folder of intermediate results of a build. @return false if it does not fit into `size`
/// bytes
bool stp_build_work_folder(const char* output, char* folder, size_t size);

/// Builds one scene from the inputs and writes it. `report` may be NULL. @return STP_OK, or the
/// failure of a stage (logged)
STP_MUST_USE stp_result stp_build(stp_context* context, const stp_build_desc* desc,
                                  stp_build_report* report);
