// SPDX-License-Identifier: MIT
// Internals of a builder. Added content is staged in a separate scene; stp_builder_write moves it
// into the scene that is built.
#pragma once

#include "embed/model_internal.h"
#include "scene/scene.h"

#include <stipple/build.h>

enum { STP_BUILDER_MATERIAL = 1 }; // the staged scene's default material, number 0: white and rough

struct stp_builder {
    stp_context* context;
    stp_builder_desc desc;
    char* name;
    stp_scene* staged;
    stp_part* parts; ///< indexed by number - 1
    size_t part_count, part_capacity;
    char** files;
    size_t file_count, file_capacity;
    bool written; ///< adding is no longer possible
    bool moved;   ///< the staged content has been moved
    void* bytes;  ///< the file built in memory, from stp_alloc; NULL: none
    size_t size;
};

/// Whether something with this material can be added. @return STP_OK; STP_ERROR_ARGUMENT (logged):
/// the builder was written, or the material was not added
STP_MUST_USE stp_result stp_builder_check(const stp_builder* builder, uint32_t material);

/// For stp_build_desc.generate: `user` is the builder, whose geometry is consumed. @return STP_OK,
/// STP_ERROR_OUT_OF_MEMORY, STP_ERROR_IO (a second call, or the spill); logged
STP_MUST_USE stp_result stp_builder_move(stp_scene* scene, const char* input, void* user);
