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
    void* bytes;  ///< of a file built in memory
    size_t size;
};

/// Logs that adding is no longer possible, or that a number is unknown to the builder.
STP_MUST_USE stp_result stp_builder_check(const stp_builder* builder, uint32_t material);
