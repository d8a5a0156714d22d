// SPDX-License-Identifier: MIT
//
// Drafts: the unfinished scene, written repeatedly as a separate file for display during the
// build. First points of all meshes, then triangles, then splats from the smallest parts up.
// Drafts take at most a tenth of the time of one thread, and are skipped if the disk might become
// too small for the build. They never change the result.
#pragma once

#include "builder/build_scene.h"
#include "builder/set_plan.h"
#include "store/clusters/clusters.h"
#include "store/file/summary.h"

typedef struct stp_build_draft stp_build_draft;

/// `context`: the build's. @return NULL if drafts are not wanted or memory runs out. All functions
/// below accept NULL and do nothing
stp_build_draft* stp_build_draft_create(const stp_context* context, const stp_build_desc* desc);
void stp_build_draft_destroy(stp_build_draft* draft);

/// Writes points of a finished scene before it is partitioned; it may change afterwards. Skips
/// small scenes.
void stp_build_draft_preview(stp_build_draft* draft, const stp_scene* scene);

/// Registers the scene whose results are added from now on. It must outlive the draft; so must the
/// bytes of meshes and the columns of sets.
void stp_build_draft_begin(stp_build_draft* draft, const stp_scene* scene,
                           const stp_build_plan* plan, const stp_shading_set* shadings,
                           const stp_store_census* census);

/// Adds a coded mesh, or a finished step of the plan. Writes a draft if one is due. Any thread.
void stp_build_draft_add_mesh(stp_build_draft* draft, size_t mesh, const stp_coded_mesh* coded);
void stp_build_draft_add_splat_set(stp_build_draft* draft, uint32_t step, const stp_splats* set);
/// Writes new results immediately. Nothing may be added during this call.
void stp_build_draft_write(stp_build_draft* draft);
