// SPDX-License-Identifier: MIT
// Items of splat sets: uploads their octaves to the pool, and adds the commands that draw them.
#pragma once

#include "draw/gl/gl_renderer.h"

/// Makes the item of a set from its resident part, with splats large enough for it.
/// @return STP_OK, or as uploads and the store's functions; logged
STP_MUST_USE stp_result stp_gl_set_item_make(stp_gl_renderer* r, uint32_t index);
