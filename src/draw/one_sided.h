// SPDX-License-Identifier: MIT
#pragma once

#include "select/select.h"

/// Whether back-facing splats of an item can be culled. Sections, ghosts and transparent splats
/// (`glass`: the scene has some) show surface that faces away from the eye.
static inline bool stp_draw_one_sided(const stp_draw_item* item, bool glass)
{
    return item->one_sided && item->sections == 0 && !item->ghost && !glass;
}
