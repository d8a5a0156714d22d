// SPDX-License-Identifier: MIT
// A builder as the files of this room see it: what was added waits in a scene of its own, which stp_builder_write moves
// into the scene that is built.
#pragma once

#include "embed/model.h"
#include "scene/scene.h"

#include <stipple/build.h>

enum { STP_BUILDER_MATERIAL = 1 }; // the staged scene's, which stands for number 0: white and rough

struct stp_builder {
    stp_context* context;
    stp_builder_desc desc;
    char* name;
    stp_scene* staged;
    stp_part* parts; ///< by number less 1
    size_t part_count, part_capacity;
    char** files;
    size_t file_count, file_capacity;
    bool written; ///< nothing can be added any more
    bool moved;   ///< what was staged is gone
    void* bytes;  ///< of a file that was built in memory
    size_t size;
};

/// A copy of a text, from stp_alloc; NULL where memory runs out (not logged).
char* stp_builder_copy_text(stp_context* context, const char* text);
/// Says that something cannot be added any more, or of which the builder does not know the number.
STP_MUST_USE stp_result stp_builder_check(const stp_builder* builder, uint32_t material);
