// SPDX-License-Identifier: MIT
// Golden pictures: whole pictures are compared with those in tests/golden/draw. Machines may differ
// in the last bit of a tangent, so a few pixels may differ, and the others may be a little lighter
// or darker: two tolerances. STP_WRITE_GOLDEN=1 writes the pictures again; look at them before you
// commit them.
#pragma once

#include "tests.h"

#include "draw/draw.h"

/// Compares a picture of at most GOLDEN_MAX pixels with NAME.png. If it differs, writes expected,
/// got and difference into the folder for temporary files.
/// @return NULL if it is as expected, else what is wrong; printed
const char* golden_compare(stp_context* context, const char* name, stp_image* got);

/// Selects, draws on the CPU, and compares. The view has the size of the picture.
const char* golden_draw(stp_context* context, stp_store* store, const char* name, stp_view view,
                        stp_quality quality, stp_draw_style style);

enum { GOLDEN_MAX = 208 * 208 };
