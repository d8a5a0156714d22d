// SPDX-License-Identifier: MIT
//
// Loops over the texels of textures. Large textures are read in runs, so that such a loop can be
// cancelled, and several threads share one texture.
#pragma once

#include "scene/scene.h"

/// Texels [begin, end) of a texture.
typedef struct stp_texel_run {
    uint32_t source, texture; ///< indices in the list of textures, and in the scene
    size_t begin, end;
} stp_texel_run;

typedef struct stp_texel_runs {
    stp_texel_run* runs; ///< by source; empty textures have none
    size_t count;
    uint64_t texels; ///< of all
} stp_texel_runs;

/// Reads one run. Called on any thread; `index` is that of the run.
typedef void (*stp_texel_job)(const stp_texture* texture, const stp_texel_run* run, size_t index,
                              void* user);

/// Lists the runs of textures, given by their indices in the scene. @return STP_OK, STP_ERROR_OUT_OF_MEMORY (logged)
STP_MUST_USE stp_result stp_texel_runs_list(const stp_scene* scene, const uint32_t* textures,
                                            size_t count, stp_texel_runs* runs);
void stp_texel_runs_destroy(const stp_scene* scene, stp_texel_runs* runs);

/// Reads all runs of a list, and reports progress of a stage (static text). @return STP_OK,
/// STP_ERROR_CANCELLED (logged)
STP_MUST_USE stp_result stp_texel_runs_read(const stp_scene* scene, const stp_texel_runs* runs,
                                            const char* stage, stp_texel_job job, void* user);
