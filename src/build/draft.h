// SPDX-License-Identifier: MIT
//
// What a build has made so far, written again and again as a scene of its own, so that somebody can look at it: first
// points of all meshes, then triangles, then surfels from the smallest parts up. Drafts take at most a tenth of the
// time of one thread, and none is written where the disk might then be too small for the build. None changes its result.
#pragma once

#include "build/build.h"
#include "build/plan.h"
#include "store/clusters.h"
#include "store/summary.h"

typedef struct stp_build_draft stp_build_draft;

/// `context`: of the build. @return NULL where none are wanted, or there is no memory. All functions below take NULL, and
/// do nothing then
stp_build_draft* stp_build_draft_create(const stp_context* context, const stp_build_desc* desc);
void stp_build_draft_destroy(stp_build_draft* draft);

/// Writes points of a finished scene, before it is partitioned: it may change afterwards. Small ones are not worth it.
void stp_build_draft_sketch(stp_build_draft* draft, const stp_scene* scene);

/// From now on, what is made of this scene is kept in mind. All of it must outlive the draft; bytes of meshes and
/// columns of sets too.
void stp_build_draft_begin(stp_build_draft* draft, const stp_scene* scene,
                           const stp_build_plan* plan, const stp_shading_set* shadings,
                           const stp_store_census* census);

/// A mesh of the scene is coded, a step of the plan is made. Writes a draft where it is time for one. Any thread.
void stp_build_draft_add_mesh(stp_build_draft* draft, size_t mesh, const stp_coded_mesh* coded);
void stp_build_draft_add_surfels(stp_build_draft* draft, uint32_t step, const stp_splats* set);
/// Writes what is new, time or not. While nothing is added.
void stp_build_draft_write(stp_build_draft* draft);
