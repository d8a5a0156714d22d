// SPDX-License-Identifier: MIT
//
// The offline driver: import, partition, surfels bottom-up, clusters, write.
//
// What is made on the way is kept in a work directory beside the output, FILE.stip.work, until the file is written:
// a build that was killed goes on from there. A former output of the same name serves likewise: what has not
// changed since is taken from it.
#pragma once

#include "import/import.h"
#include "lod/blue/blue.h"
#include "lod/method.h"
#include "scene/partition.h"

typedef struct stp_build_desc {
    const char* const* inputs; ///< files, or "scene:NAME" for `generate`
    size_t input_count;
    const char* output;
    stp_import_desc import;
    stp_partition_desc partition;
    stp_blue_desc blue; ///< `sets` are the build's own business
    /// Whose sets the file holds, the first one's for readers that do not choose; each once. None: those of `blue`.
    const stp_method* const* methods;
    uint32_t method_count;
    stp_method_options method_options; ///< read where there are others than `blue`
    uint64_t
        threshold; ///< a node of triangles gets surfels above so many; default 1,000 (5.2); 1: always
    /// Asked once the scene is finished: whether it gets surfels at all. Where not, the file holds the original
    /// triangles and points only. NULL: it does.
    bool (*wants_surfels)(const stp_scene* scene, void* user);
    void* wants_surfels_user;
    bool from_triangles; ///< upper nodes capture triangles, not their children's surfels (3.4)
    bool fresh;          ///< nothing is taken from a former build
    uint64_t
        memory_bytes; ///< what the context may use; 0: its own limit. The most goes to nodes in the making
    const char* parameters_json; ///< written into the file: what the user asked for
    /// What is made so far is written there as a scene of its own now and then, to be looked at while the build goes on
    /// (build/draft.h). A draft is replaced by renaming; the last one is the caller's to remove. NULL: none.
    const char* draft;
    uint32_t
        draft_sample; ///< points of a scan that are in its first draft, before it is read; default 1,000,000
    bool draft_always; ///< after each mesh and each set, however short the build: for tests
    void (*drafted)(void* user); ///< after each, on any thread of the build; may be NULL
    void* drafted_user;
    /// Adds a named scene; NULL: "scene:" inputs are unknown.
    stp_result (*generate)(stp_scene* scene, const char* name, void* user);
    void* generate_user;
} stp_build_desc;

typedef struct stp_build_report {
    double import_s, partition_s, clusters_s, write_s, total_s;
    double capture_s, order_s, finish_s; ///< shares of the time that surfels took
    double surfel_thread_s;              ///< time of all threads for surfels
    double methods_s;                    ///< for sets of other methods than `blue`
    uint64_t candidates;
    // made now, and taken from what was there before the build began: a killed build's work directory, a former output
    uint32_t sets_made, sets_found;
    uint32_t meshes_made, meshes_found;
    uint64_t work_bytes; ///< of the work directory, at its largest
} stp_build_report;

/// Builds one scene from the inputs and writes it. @return STP_OK or what the stages return (logged)
STP_MUST_USE stp_result stp_build(stp_context* context, const stp_build_desc* desc,
                                  stp_build_report* report);
