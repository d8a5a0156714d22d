// SPDX-License-Identifier: MIT
// Items of sets of splats: their octaves brought to the pool, and commands that draw them.
#pragma once

#include "draw/gl/renderer.h"

/// Makes the item of a set: with what is here of it, in splats as large as that needs.
/// @return STP_OK, or as uploads and the store's functions; logged
STP_MUST_USE stp_result gl_set_item_make(gl_renderer* r, uint32_t index);
