// SPDX-License-Identifier: MIT
// Splits points in space: the step that kd-trees and the pieces of a large merge share.
#pragma once

#include "base/math/math.h"
#include "lod/psp/room.h"

/// A point and its number. The number also breaks ties, so each order along an axis is total.
typedef struct stp_kd_point {
    float at[3];
    uint32_t index;
} stp_kd_point;

/// Axis of the largest extent; of many points, estimated from a sample. `count` is at least 1.
int stp_kd_widest(const stp_kd_point* points, size_t count);

/// Quickselect along an axis: moves smaller points before `place`, and larger ones after it.
/// `place` is below `count`. Expected linear time for any input. The result depends on the input
/// alone.
/// @param room storage of the points, whose pages are released during the split; NULL: in memory
void stp_kd_select(stp_kd_point* points, size_t count, size_t place, int axis,
                   const stp_psp_room* room);
