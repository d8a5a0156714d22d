// SPDX-License-Identifier: MIT
// What all methods do with sets of their own.
#pragma once

#include "base/context.h"

#include <stipple/surfels.h>

/// Frees the columns of a set, each of which came from stp_alloc.
void stp_splats_destroy(stp_context* context, stp_splats* surfels);
